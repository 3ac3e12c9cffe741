//! A scene around a mesh: camera, ground, light and material such that a scan looks like a photograph.
//!
//! What is made up is the text of an ordinary scene file ([`Studio::scene`]), which is loaded like any other: there is no
//! other way into a render.
//!
//! - `setup`: what can be asked for, and its names;
//! - `subject`: the mesh, which way is up, where its vertices are;
//! - `framing`: where the camera stands so that all of them are in the picture;
//! - `document`: the scene as text.

use std::path::{Path, PathBuf};

use glam::DVec3;

mod document;
mod framing;
mod setup;
mod subject;

#[cfg(test)]
mod tests;

pub use framing::MARGIN;
pub use setup::{Axis, Background, Light, Material, Setup, View};

use self::framing::{Basis, Framing};
use self::subject::Subject;
use crate::load::mesh::{MeshFileError, MeshFormat};
use crate::memory::Limits;

/// The relMSE at which the render of a made-up scene ends: noise of 1/40 of the signal.
///
/// Subjects of the experiments behind ISO 12232 called prints of that noise excellent, with 30 pixels to a degree of the eye,
/// which it can just not tell apart; noise of 1/10 was acceptable to them (ISO 12232:2019, note 3 on S/N values). A pixel of a
/// screen at arm's length is as large or smaller.
pub const ERROR: f64 = 0.000_625;

/// Samples per pixel of a made-up scene if they do not bring the error down to [`ERROR`] before, as with glass.
pub const SAMPLES: u32 = 256;

/// Why there is no picture of a mesh.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudioError {
    /// Its file cannot be loaded.
    #[error(transparent)]
    Mesh(#[from] MeshFileError),
    /// All triangles are without area or without end.
    #[error("{}: there is no triangle with an area and finite vertices, so nothing to be seen", .0.display())]
    Nothing(PathBuf),
    /// A name that no scene file can hold.
    #[error("{}: the name is not UTF-8, which scene files are written in (rename the file)", .0.display())]
    Name(PathBuf),
    /// Nothing emits.
    #[error(
        "without a light the picture is black: the mesh has no material that emits (give a --light or a --background)"
    )]
    Dark,
    /// The camera is below the ground.
    #[error(
        "the ground hides the mesh from below (leave out --ground on, or look from above: --view)"
    )]
    BelowGround,
    /// A background beside a picture of all that is around.
    #[error("--background has no effect beside --light {}: what that shows is the background", .0.display())]
    TwoBackgrounds(PathBuf),
    /// A material is asked for which the file does not have.
    #[error("{}: has no materials of its own for --material file (only an OBJ file with its .mtl does)", .0.display())]
    NoMaterials(PathBuf),
}

/// A mesh with all that makes a scene of it.
#[derive(Debug)]
pub struct Studio {
    path: PathBuf,
    format: MeshFormat,
    subject: Subject,
    setup: Setup,
    /// Which way is up, and why.
    up: (Axis, &'static str),
    ground: bool,
    material: Material,
    framing: Framing,
    /// One for each picture of a turntable.
    frames: Vec<Basis>,
}

impl Studio {
    /// Reads the mesh at `path` within `limits` and places camera and light around it. `turntable` is how many
    /// pictures go once around it, 1 for a single one.
    ///
    /// # Errors
    /// A mesh that cannot be loaded or has nothing to be seen, and what makes no sense together.
    pub fn new(
        path: &Path,
        format: MeshFormat,
        setup: &Setup,
        turntable: u32,
        limits: &Limits,
    ) -> Result<Self, StudioError> {
        if path.to_str().is_none() {
            return Err(StudioError::Name(path.to_owned()));
        }
        let subject = Subject::load(path, format, limits)?;
        if subject.points.is_empty() {
            return Err(StudioError::Nothing(path.to_owned()));
        }
        let material = match setup.material {
            Some(Material::File) if !subject.has_materials => {
                return Err(StudioError::NoMaterials(path.to_owned()));
            }
            Some(material) => material,
            None if subject.has_materials => Material::File,
            None => Material::Clay,
        };
        if let (Light::File(picture), Some(_)) = (&setup.light, setup.background) {
            return Err(StudioError::TwoBackgrounds(picture.clone()));
        }
        let dark = setup.light == Light::None
            && setup.background.is_none_or(|background| background.light() == DVec3::ZERO);
        if dark && !(material == Material::File && subject.emits) {
            return Err(StudioError::Dark);
        }
        let up = match setup.up {
            Some(up) => (up, "as asked"),
            None => subject.up(format),
        };
        let from_below = setup.view.elevation() < 0.0;
        let ground = match setup.ground {
            Some(true) if from_below => return Err(StudioError::BelowGround),
            Some(ground) => ground,
            None => {
                let lit_by_lamps = matches!(setup.light, Light::Studio | Light::Sky);
                !from_below && lit_by_lamps && setup.background != Some(Background::Transparent)
            }
        };
        let count = turntable.max(1);
        let azimuth =
            |frame: u32| setup.view.azimuth() + 360.0 * f64::from(frame) / f64::from(count);
        let elevation = setup.view.elevation();
        let frames: Vec<_> =
            (0..count).map(|frame| Basis::new(up.0, azimuth(frame), elevation)).collect();
        let framing = Framing::new(&subject.points, subject.center, subject.radius, &frames, setup);
        Ok(Self {
            path: path.to_owned(),
            format,
            subject,
            setup: setup.clone(),
            up,
            ground,
            material,
            framing,
            frames,
        })
    }

    /// The scene as the text of a file. Relative names in it are those that were given: from the folder in which the
    /// program runs.
    #[must_use]
    pub fn scene(&self) -> String {
        document::scene(self)
    }

    /// The cameras of all pictures of a turntable, each as a scene without anything in it.
    pub fn cameras(&self) -> impl Iterator<Item = String> + '_ {
        (0..self.frames.len()).map(|frame| document::camera_alone(self, frame))
    }

    /// What the text is to be called in messages: it lies in the folder in which the program runs.
    #[must_use]
    pub fn name(&self) -> PathBuf {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        format!("the scene made of {name}").into()
    }

    /// What was chosen, in one line, with the options that change it.
    #[must_use]
    pub fn choices(&self) -> String {
        let setup = &self.setup;
        let (up, why) = self.up;
        let turns = match self.frames.len() {
            1 => String::new(),
            count => format!(", {count} pictures around it (--turntable)"),
        };
        format!(
            "{}: seen from {} (--view), {up} is up, {why} (--up), {} degrees across (--fov){turns}; light {} (--light), \
             ground {} (--ground), background {} (--background), material {} (--material), {}x{} pixels (--size)",
            self.path.display(),
            setup.view,
            setup.fov,
            setup.light,
            if self.ground { "on" } else { "off" },
            setup.background.map_or_else(|| "by the light".to_owned(), |b| b.to_string()),
            self.material,
            setup.size.0,
            setup.size.1,
        )
    }
}
