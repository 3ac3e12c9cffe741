//! The scene as text.

use std::fmt::Write;

use glam::DVec3;

use super::framing::Basis;
use super::setup::{Background, Light, Material};
use super::{ERROR, SAMPLES, Studio};
use crate::load::mesh::MeshFormat;

/// Edges at which a mesh without normals turns by more degrees are creases: corners of boxes and of coarse prisms, not the
/// noise of a scan.
const CREASE: f64 = 40.0;

/// Light from all around in the studio, which fills the shadows. A second lamp in its place would take twice as long to
/// the same error.
const SURROUNDINGS: DVec3 = DVec3::new(0.307, 0.314, 0.336);

/// That of the sky.
const SKY: DVec3 = DVec3::new(0.2, 0.3, 0.48);

/// Radius of the ground, in radii of the mesh.
const GROUND: f64 = 1000.0;

/// What the ground reflects. Grey lets the mesh stand out, and what it throws back to the mesh is half the noise of white
/// ground: the picture has the same error after half the time.
const GREY: f64 = 0.45;

/// Where the lamps no longer reach, ground that reflects all light is as bright as what is behind it. So it has to be where
/// its end could be seen.
const WHITE: f64 = 1.0;

/// How far the ground lies below the mesh, in radii of it, so that a flat base is not in the very same plane.
const GAP: f64 = 1e-4;

/// A scene that holds the camera of one frame and nothing else.
pub(super) fn camera_alone(studio: &Studio, frame: usize) -> String {
    let mut text = Text::default();
    text.open("<scene version=\"3.0.0\">");
    camera(&mut text, studio, &studio.frames[frame]);
    text.close("</scene>");
    text.lines
}

/// The whole scene, with the camera of the first frame.
pub(super) fn scene(studio: &Studio) -> String {
    let mut text = Text::default();
    // Two hyphens would end a comment.
    text.line(&format!("<!-- {} -->", studio.choices().replace("--", "")));
    text.open("<scene version=\"3.0.0\">");
    integrator(&mut text, studio);
    camera(&mut text, studio, &studio.frames[0]);
    mesh(&mut text, studio);
    if studio.ground {
        ground(&mut text, studio);
    }
    lights(&mut text, studio);
    text.close("</scene>");
    text.lines
}

fn integrator(text: &mut Text, studio: &Studio) {
    if studio.setup.background == Some(Background::Transparent) {
        text.open("<integrator type=\"path\">");
        text.line("<boolean name=\"hide_emitters\" value=\"true\"/>");
        text.close("</integrator>");
    } else {
        text.line("<integrator type=\"path\"/>");
    }
}

fn camera(text: &mut Text, studio: &Studio, basis: &Basis) {
    let (setup, n) = (&studio.setup, Numbers::of(studio));
    let place = studio.subject.center + basis.vector(studio.framing.place);
    // On the optical axis, as deep as the middle of the mesh.
    let target = place - basis.back * -studio.framing.place.z;
    let axis = studio.up.0.direction();
    let up = if setup.view.elevation().abs() > 60.0 { basis.up } else { axis };
    text.open("<sensor type=\"perspective\">");
    text.line(&format!("<float name=\"fov\" value=\"{}\"/>", setup.fov));
    text.line("<string name=\"fov_axis\" value=\"larger\"/>");
    let turn = format!(
        "<lookat origin=\"{}\" target=\"{}\" up=\"{}\"/>",
        n.point(place),
        n.point(target),
        Numbers::UNIT.point(up)
    );
    transform(text, &[turn]);
    text.open("<film type=\"hdrfilm\">");
    text.line(&format!("<integer name=\"width\" value=\"{}\"/>", setup.size.0));
    text.line(&format!("<integer name=\"height\" value=\"{}\"/>", setup.size.1));
    if setup.background == Some(Background::Transparent) {
        text.line("<string name=\"pixel_format\" value=\"rgba\"/>");
    }
    text.close("</film>");
    text.open("<sampler type=\"sobol\">");
    text.line(&format!("<integer name=\"sample_count\" value=\"{SAMPLES}\"/>"));
    text.line(&format!("<float name=\"error\" value=\"{ERROR}\"/>"));
    text.close("</sampler>");
    text.close("</sensor>");
}

fn mesh(text: &mut Text, studio: &Studio) {
    let subject = &studio.subject;
    text.open(&format!("<shape type=\"{}\">", studio.format.plugin()));
    text.line(&format!(
        "<string name=\"filename\" value=\"{}\"/>",
        escaped(&studio.path.to_string_lossy())
    ));
    if let Some(placement) = subject.placement {
        let c = -placement.center;
        let mut steps = vec![format!("<translate x=\"{}\" y=\"{}\" z=\"{}\"/>", c.x, c.y, c.z)];
        if placement.scale != 1.0 {
            steps.push(format!("<scale value=\"{}\"/>", placement.scale));
        }
        transform(text, &steps);
    }
    if !subject.has_normals && studio.format != MeshFormat::Serialized {
        text.line(&format!("<float name=\"max_smooth_angle\" value=\"{CREASE}\"/>"));
    }
    material(text, studio.material);
    text.close("</shape>");
}

fn material(text: &mut Text, material: Material) {
    let coated = |text: &mut Text, color: &str, alpha: f64| {
        two_sided(text, "roughplastic", |text| {
            text.line("<string name=\"distribution\" value=\"ggx\"/>");
            text.line(&format!("<float name=\"alpha\" value=\"{alpha}\"/>"));
            text.line(&format!("<rgb name=\"diffuse_reflectance\" value=\"{color}\"/>"));
        });
    };
    let metal = |text: &mut Text, name: &str, alpha: f64| {
        two_sided(text, "roughconductor", |text| {
            text.line(&format!("<string name=\"material\" value=\"{name}\"/>"));
            text.line("<string name=\"distribution\" value=\"ggx\"/>");
            text.line(&format!("<float name=\"alpha\" value=\"{alpha}\"/>"));
        });
    };
    match material {
        // The shape finds the materials of its file by itself.
        Material::File => {}
        Material::Clay => coated(text, "0.68, 0.55, 0.45", 0.35),
        Material::Plaster => two_sided(text, "diffuse", |text| {
            text.line("<rgb name=\"reflectance\" value=\"0.78, 0.77, 0.75\"/>");
        }),
        Material::Marble => coated(text, "0.8, 0.78, 0.74", 0.12),
        Material::Plastic => coated(text, "0.06, 0.2, 0.5", 0.05),
        Material::Metal => metal(text, "Cr", 0.2),
        Material::Gold => metal(text, "Au", 0.15),
        Material::Copper => metal(text, "Cu", 0.15),
        Material::Glass => text.line("<bsdf type=\"dielectric\"/>"),
    }
}

/// A material for both sides: scans have holes, and faces of some programs look inwards.
fn two_sided(text: &mut Text, name: &str, properties: impl FnOnce(&mut Text)) {
    text.open("<bsdf type=\"twosided\">");
    text.open(&format!("<bsdf type=\"{name}\">"));
    properties(text);
    text.close("</bsdf>");
    text.close("</bsdf>");
}

fn ground(text: &mut Text, studio: &Studio) {
    let (subject, n, up) = (&studio.subject, Numbers::of(studio), studio.up.0);
    let [least, most] = subject.bounds;
    let mut foot = subject.center;
    foot[up.index] = if up.negative { most } else { least }[up.index];
    foot -= up.direction() * (GAP * subject.radius);
    text.open("<shape type=\"disk\">");
    transform(
        text,
        &[
            format!("<scale value=\"{}\"/>", n.length(GROUND * subject.radius)),
            format!(
                "<lookat origin=\"{}\" target=\"{}\" up=\"{}\"/>",
                n.point(foot),
                n.point(foot + up.direction() * subject.radius),
                Numbers::UNIT.point(up.front())
            ),
        ],
    );
    text.open("<bsdf type=\"diffuse\">");
    // What is behind the mesh is the background that was asked for, and not a darker ground.
    let is_white = studio.setup.background.is_some() || ends_in_sight(studio, foot);
    let reflectance = if is_white { WHITE } else { GREY };
    text.line(&format!("<rgb name=\"reflectance\" value=\"{reflectance}\"/>"));
    text.close("</bsdf>");
    text.close("</shape>");
}

/// Whether the end of the ground, whose middle is at `foot`, is in the picture.
fn ends_in_sight(studio: &Studio, foot: DVec3) -> bool {
    let (setup, subject) = (&studio.setup, &studio.subject);
    let place = subject.center + studio.frames[0].vector(studio.framing.place);
    let height = (place - foot).dot(studio.up.0.direction());
    let below_horizon = (height / (GROUND * subject.radius)).atan();
    let (width, rows) = (f64::from(setup.size.0), f64::from(setup.size.1));
    let half_view = ((setup.fov.to_radians() / 2.0).tan() * rows / width.max(rows)).atan();
    setup.view.elevation().to_radians() - half_view < below_horizon
}

/// A lamp that looks at the mesh.
struct Lamp {
    /// Degrees to the right of the camera, and above.
    from: (f64, f64),
    /// In radii of the mesh.
    distance: f64,
    /// In radii of the mesh.
    half_size: f64,
    shape: &'static str,
    radiance: DVec3,
}

fn lights(text: &mut Text, studio: &Studio) {
    let n = Numbers::of(studio);
    let surroundings = |default: DVec3| match studio.setup.background {
        Some(background) if background != Background::Transparent => background.light(),
        _ => default,
    };
    let constant = match &studio.setup.light {
        Light::Studio => {
            // Flat light shows relief; one who goes around would see the lamp.
            let elevation = if studio.frames.len() > 1 { 45.0 } else { 36.0 };
            let key = Lamp {
                from: (-38.0, elevation),
                distance: 5.0,
                half_size: 1.6,
                shape: "rectangle",
                radiance: DVec3::new(6.1, 5.9, 5.5),
            };
            lamp(text, studio, &n, &key);
            surroundings(SURROUNDINGS)
        }
        Light::Sky => {
            let radiance = DVec3::new(520.0, 475.0, 405.0);
            let from = (-40.0, 45.0);
            let sun = Lamp { from, distance: 40.0, half_size: 1.5, shape: "disk", radiance };
            lamp(text, studio, &n, &sun);
            surroundings(SKY)
        }
        Light::File(picture) => {
            text.open("<emitter type=\"envmap\">");
            let name = escaped(&picture.to_string_lossy());
            text.line(&format!("<string name=\"filename\" value=\"{name}\"/>"));
            // Its upper edge is at +y.
            let up = studio.up.0;
            if up.direction() != DVec3::Y {
                let n = Numbers::UNIT;
                let [x, y, z] = [up.right(), up.direction(), up.front()].map(|v| n.triple(v));
                let rows: Vec<_> =
                    (0..3).map(|i| format!("{} {} {} 0", x[i], y[i], z[i])).collect();
                transform(text, &[format!("<matrix value=\"{} 0 0 0 1\"/>", rows.join(" "))]);
            }
            text.close("</emitter>");
            return;
        }
        Light::None => surroundings(DVec3::ZERO),
    };
    if constant != DVec3::ZERO {
        text.open("<emitter type=\"constant\">");
        let color = format!("{}, {}, {}", constant.x, constant.y, constant.z);
        text.line(&format!("<rgb name=\"radiance\" value=\"{color}\"/>"));
        text.close("</emitter>");
    }
}

fn lamp(text: &mut Text, studio: &Studio, n: &Numbers, lamp: &Lamp) {
    let (subject, up) = (&studio.subject, studio.up.0);
    let (azimuth, elevation) = (studio.setup.view.azimuth() + lamp.from.0, lamp.from.1);
    let toward = Basis::new(up, azimuth, elevation).back;
    let place = subject.center + toward * (lamp.distance * subject.radius);
    text.open(&format!("<shape type=\"{}\">", lamp.shape));
    transform(
        text,
        &[
            format!("<scale value=\"{}\"/>", n.length(lamp.half_size * subject.radius)),
            format!(
                "<lookat origin=\"{}\" target=\"{}\" up=\"{}\"/>",
                n.point(place),
                n.point(subject.center),
                Numbers::UNIT.point(up.direction())
            ),
        ],
    );
    text.open("<emitter type=\"area\">");
    let DVec3 { x, y, z } = lamp.radiance;
    text.line(&format!("<rgb name=\"radiance\" value=\"{x}, {y}, {z}\"/>"));
    text.close("</emitter>");
    text.close("</shape>");
}

fn transform(text: &mut Text, steps: &[String]) {
    text.open("<transform name=\"to_world\">");
    steps.iter().for_each(|step| text.line(step));
    text.close("</transform>");
}

/// Lines with indentation.
#[derive(Default)]
struct Text {
    lines: String,
    depth: usize,
}

impl Text {
    fn line(&mut self, line: &str) {
        let indent = 4 * self.depth;
        let _ = writeln!(self.lines, "{:indent$}{line}", "");
    }

    fn open(&mut self, line: &str) {
        self.line(line);
        self.depth += 1;
    }

    fn close(&mut self, line: &str) {
        self.depth -= 1;
        self.line(line);
    }
}

/// Lengths with as many decimals as are seen.
#[derive(Clone, Copy, Debug)]
struct Numbers {
    decimals: usize,
}

impl Numbers {
    /// For directions.
    const UNIT: Self = Self { decimals: 9 };

    /// A ten-millionth of the mesh.
    fn of(studio: &Studio) -> Self {
        let digits = 7.0 - studio.subject.radius.log10().floor();
        Self { decimals: digits.clamp(0.0, 12.0) as usize }
    }

    fn length(self, value: f64) -> String {
        let text = format!("{value:.*}", self.decimals);
        let text = if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.')
        } else {
            &text
        };
        if text == "-0" { "0".to_owned() } else { text.to_owned() }
    }

    fn triple(self, v: DVec3) -> [String; 3] {
        v.to_array().map(|value| self.length(value))
    }

    fn point(self, v: DVec3) -> String {
        self.triple(v).join(", ")
    }
}

/// A text as the value of an attribute. A dollar sign would begin the name of a parameter.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' => escaped.push_str("&#10;"),
            '\t' => escaped.push_str("&#9;"),
            '\r' => escaped.push_str("&#13;"),
            '$' => escaped.push_str("\\$"),
            _ => escaped.push(c),
        }
    }
    escaped
}
