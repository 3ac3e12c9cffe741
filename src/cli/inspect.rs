//! `telamon inspect`.

use std::time::Instant;

use clap::Args;
use telamon::camera::Camera;
use telamon::film::{ComponentFormat, FilmSettings};
use telamon::integrator::settings::Part;
use telamon::intersect;
use telamon::render::{Description, Requirements};
use telamon::scene::{Object, Scene};
use telamon::shape::{Geometry, Shape};

use super::message::Failure;
use super::table::{bytes, table};
use super::{Input, print};

/// Rows of a list; a scene of ten thousand shapes is summed up.
const LONGEST_LIST: usize = 30;

/// Show what is in a scene, and what a render of it will model and skip
#[derive(Args, Debug)]
#[command(after_help = "Example: telamon inspect scene.xml")]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let accel = self.input.accel();
        let limits = self.input.resources.limits();
        let description = self.input.load(&limits, None, false)?.description;
        let built_over = description.scene.shapes();
        limits.claim(accel.estimated_bytes(&built_over))?;
        let start = Instant::now();
        let engine = intersect::build(accel, &built_over)?;
        let built = format!(
            "{}, {} beside the shapes' own memory, built in {:.2} s",
            engine.name(),
            bytes(engine.bytes()),
            start.elapsed().as_secs_f64()
        );
        let text = [
            overview(&description, &built),
            list("Shapes", &shapes(&description.scene), &[2, 3]),
            list("Materials", &materials(&description.scene), &[2]),
            list("Emitters", &emitters(&description.scene), &[2]),
            requirements(&Requirements::of(&description)),
        ];
        print(text.concat().as_bytes())
    }
}

/// One line for each part.
fn overview(description: &Description, built: &str) -> String {
    let Description { scene, film, sampler, integrator, effort, .. } = description;
    let objects = scene.objects();
    let triangles: usize = objects.iter().map(|o| triangles(o.shape.as_ref())).sum();
    let bounds = scene.bounds().map_or("nothing to be seen".to_owned(), |b| {
        format!(
            "({}, {}, {}) to ({}, {}, {})",
            b.min.x, b.min.y, b.min.z, b.max.x, b.max.y, b.max.z
        )
    });
    let shapes = format!("{} with {triangles} triangles, {}", objects.len(), bytes(scene.bytes()));
    let count = match effort.error {
        Some(error) => {
            format!("until the relMSE is {error}, at most {}", sampler.samples_per_pixel)
        }
        None => sampler.samples_per_pixel.to_string(),
    };
    let samples = format!("{}, {count} samples per pixel, seed {}", sampler.kind, sampler.seed);
    let rows = [
        ("shapes", shapes),
        ("bounds", bounds),
        ("engine", built.to_owned()),
        ("camera", describe_camera(description)),
        ("film", describe_film(film)),
        ("sampler", samples),
        ("integrator", integrator.about().describe()),
    ];
    table(&rows.map(|(name, text)| vec![name.to_owned(), text]), &[])
}

fn describe_film(film: &FilmSettings) -> String {
    let crop = film.crop;
    let part = if (crop.width, crop.height) == (film.width, film.height) {
        String::new()
    } else {
        format!(", cropped to {}x{} at {},{}", crop.width, crop.height, crop.x, crop.y)
    };
    let filter = film.filter.describe();
    let component = match film.component {
        ComponentFormat::Half => "half floats",
        ComponentFormat::Float => "32-bit floats",
    };
    let alpha = if film.alpha { "RGBA" } else { "RGB" };
    format!("{}x{} pixels{part}, {filter}, {alpha} in {component}", film.width, film.height)
}

fn describe_camera(description: &Description) -> String {
    let kind = match description.camera {
        Camera::Perspective(_) if description.camera.has_lens() => "perspective with a lens",
        Camera::Perspective(_) => "perspective",
        Camera::Orthographic(_) => "orthographic",
    };
    format!("{kind}{}", if description.camera_motion.is_some() { ", moving" } else { "" })
}

fn triangles(shape: &dyn Shape) -> usize {
    match shape.geometry() {
        Geometry::Triangles { triangles, .. } => triangles.len(),
        Geometry::Deforming(mesh) => mesh.triangles().len(),
        Geometry::Analytic(_) => 0,
        Geometry::Instance(instance) => {
            instance.group().shapes().iter().map(|s| triangles(s.as_ref())).sum()
        }
    }
}

/// A heading and rows; nothing where there are none.
fn list(heading: &str, rows: &[Vec<String>], right: &[usize]) -> String {
    let Some((titles, entries)) = rows.split_first().filter(|(_, entries)| !entries.is_empty())
    else {
        return String::new();
    };
    let shown: Vec<_> =
        std::iter::once(titles).chain(entries.iter().take(LONGEST_LIST)).cloned().collect();
    let more = match entries.len().saturating_sub(LONGEST_LIST) {
        0 => String::new(),
        hidden => format!("  and {hidden} more\n"),
    };
    format!("\n{heading}\n{}{more}", table(&shown, right))
}

fn titles(titles: &[&str]) -> Vec<String> {
    titles.iter().map(|t| (*t).to_owned()).collect()
}

fn shapes(scene: &Scene) -> Vec<Vec<String>> {
    let rows = scene.objects().iter().enumerate().map(|(index, object)| {
        let emitter = object.emitter.map(|i| format!(", emitter {i}"));
        vec![
            named(index, &object.name),
            object.shape.kind().to_owned(),
            triangles(object.shape.as_ref()).to_string(),
            bytes(object.shape.bytes()),
            format!("{}{}", materials_of(object), emitter.unwrap_or_default()),
        ]
    });
    let head = titles(&["shape", "kind", "triangles", "memory", "made of"]);
    std::iter::once(head).chain(rows).collect()
}

/// `"material 3"`, or `"materials 3, 4"`.
fn materials_of(object: &Object) -> String {
    let numbers: Vec<_> = object.bsdfs().iter().map(usize::to_string).collect();
    format!("material{} {}", if numbers.len() == 1 { "" } else { "s" }, numbers.join(", "))
}

fn materials(scene: &Scene) -> Vec<Vec<String>> {
    let mut users = vec![0_usize; scene.bsdfs().len()];
    scene.objects().iter().flat_map(|o| o.bsdfs()).for_each(|&bsdf| users[bsdf] += 1);
    let rows = scene.bsdfs().iter().zip(users).enumerate().map(|(index, (bsdf, users))| {
        vec![index.to_string(), bsdf.kind().to_owned(), users.to_string()]
    });
    std::iter::once(titles(&["material", "kind", "shapes"])).chain(rows).collect()
}

fn emitters(scene: &Scene) -> Vec<Vec<String>> {
    let rows = scene.emitters().iter().enumerate().map(|(index, emitter)| {
        let power =
            emitter.power().map_or_else(|| "from outside".to_owned(), |p| format!("{p:.4} W"));
        vec![index.to_string(), emitter.kind().to_owned(), power]
    });
    std::iter::once(titles(&["emitter", "kind", "power"])).chain(rows).collect()
}

/// An index, with the name that the scene file gives, if any.
fn named(index: usize, name: &str) -> String {
    if name.is_empty() { index.to_string() } else { format!("{index} {name}") }
}

fn requirements(requirements: &Requirements) -> String {
    let part = |heading: &str, modelled: bool| {
        let decisions = requirements.decisions().iter().filter(|d| d.modelled == modelled);
        let rows: Vec<_> =
            decisions.map(|d| vec![d.feature.to_string(), d.reason.clone()]).collect();
        format!("\n{heading}\n{}", table(&rows, &[]))
    };
    part("The render will model", true)
        + &part("The render will skip", false)
        + &carried(requirements.carried())
}

/// What paths carry.
fn carried(parts: &[Part]) -> String {
    if parts.is_empty() {
        return String::new();
    }
    let (mut all, mut some, mut rows) = (0, 0, Vec::new());
    for Part { name, bytes, reason } in parts {
        let (carried, reason) = match reason {
            Ok(reason) => (*bytes, reason),
            Err(reason) => (0, reason),
        };
        all += bytes;
        some += carried;
        rows.push(vec![(*name).to_owned(), carried.to_string(), reason.clone()]);
    }
    format!("\nA path carries {some} of {all} bytes\n{}", table(&rows, &[1]))
}
