//! A mesh in the place of a scene: what it is shown with.

use std::path::Path;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use telamon::load::mesh::MeshFormat;
use telamon::memory::Limits;
use telamon::studio::{Axis, Background, Light, Material, Setup, Studio, View};

use super::message::Failure;
use super::values::Size;

/// Kinds of files with meshes in them that other programs write, by their extensions.
const FOREIGN: [(&str, &str); 14] = [
    ("glb", "glTF"),
    ("gltf", "glTF"),
    ("fbx", "FBX"),
    ("blend", "Blender's own"),
    ("usd", "USD"),
    ("usda", "USD"),
    ("usdc", "USD"),
    ("usdz", "USD"),
    ("3mf", "3MF"),
    ("dae", "COLLADA"),
    ("abc", "Alembic"),
    ("3ds", "3DS"),
    ("off", "OFF"),
    ("stp", "STEP"),
];

/// Refuses files of formats that nothing here reads, by their names: as XML they would be broken.
pub(super) fn refuse_foreign(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().unwrap_or_default();
    let is = |(known, _): &&(&str, &str)| extension.eq_ignore_ascii_case(known);
    match FOREIGN.iter().find(is) {
        Some((_, format)) => Err(Failure::new(format!(
            "{}: the format {format} is not read (expected a scene file, .xml, or a mesh: {READ}; most programs \
             export .obj and .ply)",
            path.display()
        ))),
        None => Ok(()),
    }
}

/// The meshes that are read.
pub(super) const READ: &str = ".obj, .ply, .stl or .serialized, or one of them with .gz";

/// How a mesh is shown that stands in the place of a scene. `telamon scene` writes what is made of it.
#[derive(Args, Debug)]
#[command(next_help_heading = "A mesh instead of a scene")]
pub(super) struct Presentation {
    /// Axis that points up: +x, +y, +z, -x, -y or -z [default: +z in STL files, +y in others, unless the
    /// mesh stands on a flat base elsewhere]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    up: Option<Axis>,

    /// From where the mesh is seen: front, back, left, right, top, bottom, three-quarter, or degrees to
    /// the right of the front and above [default: three-quarter, which is -30,15]
    #[arg(long, value_name = "NAME|AZ,EL", allow_hyphen_values = true)]
    view: Option<View>,

    /// Degrees of the view across the longer side of the picture; the camera stands where the mesh fits
    /// [default: 30]
    #[arg(long, value_name = "DEGREES", value_parser = fov)]
    fov: Option<f64>,

    /// What lights the mesh: studio (a large soft lamp, and a little from all around), sky (a sun and blue),
    /// a picture of all that is around (.exr, .hdr), or none [default: studio]
    #[arg(long, value_name = "LIGHT")]
    light: Option<Light>,

    /// Whether the mesh stands on the ground [default: on; off from below, with a picture as the light
    /// or a transparent background]
    #[arg(long, value_name = "ON|OFF", value_parser = on_or_off())]
    ground: Option<bool>,

    /// What the mesh is made of [default: file, the materials of an OBJ file's .mtl, or else clay]
    #[arg(long, value_name = "MATERIAL", value_parser = materials())]
    material: Option<Material>,

    /// What is behind, and lights the mesh as well: white, black, transparent, or red, green and blue
    /// such as 0.1,0.1,0.2 [default: grey; blue with --light sky]
    #[arg(long, value_name = "COLOR")]
    background: Option<Background>,
}

impl Presentation {
    /// The options that are given, with their values.
    pub(super) fn given(&self) -> Vec<(String, String)> {
        let Self { up, view, fov, light, ground, material, background } = self;
        let on = |&on: &bool| if on { "on" } else { "off" }.to_owned();
        let all = [
            ("--up", up.map(|v| v.to_string())),
            ("--view", view.map(|v| v.to_string())),
            ("--fov", fov.map(|v| v.to_string())),
            ("--light", light.as_ref().map(Light::to_string)),
            ("--ground", ground.as_ref().map(on)),
            ("--material", material.map(|v| v.to_string())),
            ("--background", background.map(|v| v.to_string())),
        ];
        all.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect()
    }

    /// What is made of the mesh at `path`.
    pub(super) fn studio(
        &self,
        path: &Path,
        format: MeshFormat,
        size: Option<Size>,
        turntable: u32,
        limits: &Limits,
    ) -> Result<Studio, Failure> {
        let default = Setup::default();
        let setup = Setup {
            up: self.up,
            view: self.view.unwrap_or(default.view),
            fov: self.fov.unwrap_or(default.fov),
            light: self.light.clone().unwrap_or(default.light),
            ground: self.ground,
            material: self.material,
            background: self.background,
            size: size.map_or(default.size, |Size { width, height }| (width, height)),
        };
        Ok(Studio::new(path, format, &setup, turntable, limits)?)
    }
}

fn fov(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(degrees) if (1.0..=170.0).contains(&degrees) => Ok(degrees),
        _ => Err("expected degrees from 1 to 170".to_owned()),
    }
}

fn on_or_off() -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new(["on", "off"]).map(|text| text == "on")
}

/// The names, for the help and for completions as well.
fn materials() -> impl TypedValueParser<Value = Material> {
    PossibleValuesParser::new(Material::ALL.map(Material::name))
        .try_map(|name| name.parse::<Material>())
}
