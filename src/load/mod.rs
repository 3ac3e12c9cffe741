//! Stand-in for the loader: reads numbers of film, sampler and integrator, and makes a sphere under
//! a constant light, whatever the file says.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use crate::bsdf::Diffuse;
use crate::camera::{Perspective, PerspectiveSettings};
use crate::emitter::Constant;
use crate::math::Rgb;
use crate::scene::settings::*;
use crate::scene::{Description, Object, Scene};
use crate::shape::Sphere;

/// Options.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// `-D`.
    pub defines: Vec<(String, String)>,
}

/// A scene.
#[derive(Debug)]
pub struct Loaded {
    /// What.
    pub description: Description,
    /// Warnings.
    pub warnings: Vec<Warning>,
}

/// Errors.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", problems[0])]
pub struct LoadError {
    problems: Vec<Problem>,
    more: usize,
}

impl LoadError {
    /// All.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }
    /// More.
    #[must_use]
    pub fn more(&self) -> usize {
        self.more
    }
}

/// One thing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file.
    pub path: PathBuf,
    /// Where in the file; `None` if it concerns the file as a whole.
    pub position: Option<Position>,
    /// What is wrong: a fragment without a full stop.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
}

/// Warning.
pub type Warning = Problem;

/// A stretch of a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The text of the whole file.
    pub source: Arc<str>,
    /// The stretch in bytes; within `source`, at character boundaries.
    pub span: Range<usize>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(position) = &self.position {
            write!(f, ":{}:{}", position.line, position.column)?;
        }
        write!(f, ": {}", self.message)
    }
}

/// Loads.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Loaded, LoadError> {
    let problem = |message: String, position| Problem {
        path: path.to_owned(),
        position,
        message,
        help: Some("read the manual".into()),
    };
    let fail =
        |message, position| LoadError { problems: vec![problem(message, position)], more: 0 };
    let mut text = std::fs::read_to_string(path).map_err(|e| fail(e.to_string(), None))?;
    let mut warnings = Vec::new();
    for (name, value) in &options.defines {
        if !text.contains(&format!("${name}")) {
            warnings.push(problem(format!("nothing uses `-D {name}={value}`"), None));
        }
        text = text.replace(&format!("${name}"), value);
    }
    let document = roxmltree::Document::parse(&text).map_err(|e| fail(e.to_string(), None))?;
    let find = |name: &str| {
        document
            .descendants()
            .find(|n| n.attribute("name") == Some(name))
            .and_then(|n| n.attribute("value"))
    };
    if let Some(n) = document.descendants().find(|n| n.has_tag_name("nonsense")) {
        let span = n.range();
        let at = document.text_pos_at(span.start);
        let position = Position {
            line: at.row as usize,
            column: at.col as usize,
            source: text.as_str().into(),
            span,
        };
        return Err(fail("unknown element `nonsense`".into(), Some(position)));
    }
    let int = |name: &str, or: u32| find(name).and_then(|v| v.parse().ok()).unwrap_or(or);
    let (width, height) = (int("width", 768), int("height", 576));
    let crop = Crop {
        x: int("crop_offset_x", 0),
        y: int("crop_offset_y", 0),
        width: int("crop_width", width),
        height: int("crop_height", height),
    };
    let mut integrator = IntegratorSettings::Path(PathSettings::default());
    if let Some(aovs) = find("aovs") {
        let layers = aovs
            .split(',')
            .filter_map(|a| a.split_once(':'))
            .map(|(name, kind)| AovLayer {
                name: name.trim().to_owned(),
                kind: match kind.trim() {
                    "depth" => AovKind::Depth,
                    "position" => AovKind::Position,
                    "uv" => AovKind::Uv,
                    "albedo" => AovKind::Albedo,
                    "geo_normal" => AovKind::GeometricNormal,
                    "shape_index" => AovKind::ShapeIndex,
                    "prim_index" => AovKind::PrimitiveIndex,
                    _ => AovKind::ShadingNormal,
                },
            })
            .collect();
        let nested = document
            .descendants()
            .filter(|n| n.has_tag_name("integrator"))
            .nth(1)
            .map(|_| Box::new(integrator));
        integrator = IntegratorSettings::Aov { layers, picture: nested };
    }
    let scene = Scene::new(
        vec![Object {
            name: "ball".into(),
            shape: Arc::new(Sphere::new(
                Vec3::ZERO,
                1.0,
                crate::math::Frame::from_normal(Vec3::Z),
                false,
            )),
            bsdf: 0,
            emitter: None,
        }],
        vec![Box::new(Diffuse::new(Rgb::splat(0.5)))],
        vec![Box::new(Constant::new(Rgb::ONE))],
        Some(0),
    )
    .expect("parts exist");
    let camera = Perspective::new(&PerspectiveSettings {
        to_world: DAffine3::from_translation(DVec3::new(0.0, 0.0, -4.0)),
        fov_x_deg: 45.0,
        aspect: f64::from(width) / f64::from(height),
        principal_point_offset: Vec2::ZERO,
        near_clip: 0.0,
        far_clip: f32::INFINITY,
    })
    .expect("valid");
    Ok(Loaded {
        description: Description {
            scene,
            camera,
            film: FilmSettings {
                width,
                height,
                crop,
                filter: Filter::Box,
                alpha: text.contains("rgba"),
                component: ComponentFormat::Half,
            },
            sampler: SamplerSettings {
                kind: SamplerKind::Independent,
                samples_per_pixel: int("sample_count", 4),
                seed: u64::from(int("seed", 0)),
            },
            integrator,
        },
        warnings,
    })
}
