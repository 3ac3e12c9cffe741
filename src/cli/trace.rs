//! `telamon trace`.

use std::fmt::Write;

use clap::Args;
use glam::Vec3A;
use telamon::intersect;
use telamon::intersect::recorder::{Answer, Query};
use telamon::ray::{Hit, Ray};
use telamon::render::{SampleId, Trace, trace};
use telamon::scene::Scene;
use telamon::shape::Geometry;

use super::message::Failure;
use super::values::{self, Pixel, Size};
use super::{Input, print};

/// Follow the path of one sample: its rays, what they meet, and what each edge adds
#[derive(Args, Debug)]
#[command(
    after_help = "The path is the one that `telamon render` traces with the same scene, size, seed and \
                  engine, whatever its crop.\n\n\
                  Example: telamon trace scene.xml --pixel 3,4 --sample 17"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,

    /// Column and row on the whole picture, from 0
    #[arg(long, value_name = "X,Y", value_parser = values::pixel, help_heading = "Sample")]
    pixel: Pixel,

    /// Which of the pixel's samples, from 0
    #[arg(long, value_name = "N", default_value = "0", help_heading = "Sample")]
    sample: u32,

    /// Seed of the random numbers [default: the scene's]
    #[arg(long, value_name = "N", help_heading = "Sample")]
    seed: Option<u64>,

    /// Columns and rows of the whole picture [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = "Sample")]
    size: Option<Size>,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<(), Failure> {
        let accel = self.input.accel();
        let limits = self.input.resources.limits();
        let description = self.input.load(&limits, self.size, false)?.description;
        let seed = self.seed.unwrap_or(description.sampler.seed);
        let Pixel { x, y } = self.pixel;
        let (width, height) = (description.film.width, description.film.height);
        if x >= width || y >= height {
            return Err(Failure::new(format!(
                "pixel {x},{y} does not lie within the film of {width}x{height} pixels"
            )));
        }
        let shapes = description.scene.shapes();
        limits.claim(accel.estimated_bytes(&shapes))?;
        let engine = intersect::build(accel, &shapes)?;
        let id = SampleId { x, y, sample: self.sample, seed };
        let traced = trace(&description, engine.as_ref(), id).ok_or_else(|| {
            Failure::new("there is no path: the integrator makes layers alone".to_owned())
        })?;
        let text = format!(
            "sample {} of pixel {x},{y} with seed {seed} and {}\n{}",
            self.sample,
            engine.name(),
            describe(&traced, &description.scene)
        );
        print(text.as_bytes())
    }
}

fn describe(trace: &Trace, scene: &Scene) -> String {
    let mut text = String::new();
    for (number, edge) in (1..).zip(&trace.edges) {
        let _ = writeln!(text, "\nedge {number}");
        for query in &edge.queries {
            text += &describe_query(query, scene);
        }
        let _ = writeln!(text, "  radiance so far: {}", triple(edge.radiance));
    }
    let radiance = trace.estimate.radiance;
    let finite = if radiance.is_finite() { "" } else { ", which is not finite and left out" };
    let alpha = trace.estimate.alpha;
    let _ = writeln!(text, "\nradiance {}{finite}; alpha {alpha}", triple(radiance));
    text
}

fn describe_query(Query { ray, answer }: &Query, scene: &Scene) -> String {
    let name = if matches!(answer, Answer::Occluded(_)) { "shadow ray" } else { "ray" };
    let Ray { origin, direction, t_max, .. } = *ray;
    let reach = if t_max.is_finite() { format!(", {t_max:?} long") } else { String::new() };
    let found = match *answer {
        _ if !ray.is_traceable() => "left the range of 32-bit floats".to_owned(),
        Answer::Occluded(true) => "is blocked".to_owned(),
        Answer::Occluded(false) => "is free".to_owned(),
        Answer::Closest(None) => "leaves the scene".to_owned(),
        Answer::Closest(Some(hit)) => describe_hit(ray, &hit, scene),
    };
    format!("  {name} from {} towards {}{reach}\n    {found}\n", triple(origin), triple(direction))
}

fn describe_hit(ray: &Ray, hit: &Hit, scene: &Scene) -> String {
    let object = &scene.objects()[hit.shape as usize];
    let name = if object.name.is_empty() { String::new() } else { format!(" `{}`", object.name) };
    let part = part(object.shape.geometry(), hit);
    let point = object.shape.surface(ray, hit);
    format!(
        "meets shape {}{name} ({}, {}){part}, after {:?} at {}, normal {}",
        hit.shape,
        object.shape.kind(),
        scene.bsdfs()[object.bsdf_of(hit.member)].kind(),
        hit.t,
        triple(point.position.as_vec3a()),
        triple(point.shading_normal)
    )
}

/// Which part of a shape was hit, where it has several.
fn part(geometry: Geometry<'_>, hit: &Hit) -> String {
    match geometry {
        Geometry::Triangles { .. } | Geometry::Deforming(_) => {
            format!(", triangle {}", hit.primitive)
        }
        Geometry::Analytic(_) => String::new(),
        Geometry::Instance(instance) => {
            let member = &instance.group().shapes()[hit.member as usize];
            format!(", member {}{}", hit.member, part(member.geometry(), hit))
        }
    }
}

/// As many digits as tell the numbers apart, and a power of ten where they are tiny or huge.
fn triple(v: Vec3A) -> String {
    format!("({:?}, {:?}, {:?})", v.x, v.y, v.z)
}
