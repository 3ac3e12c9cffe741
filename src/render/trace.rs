//! The path of one sample, edge by edge.

use super::{Description, Renderer, SampleId};
use crate::integrator::{self, Estimate, IntegratorSettings, Sample, Tracer};
use crate::intersect::recorder::Query;
use crate::intersect::{Intersector, Recorder};
use crate::math::Rgb;
use crate::sampler;
use crate::sampler::SamplerSettings;

/// A path that was followed.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Its edges from the camera on; all of them as one if the integrator is not the path tracer, or splits paths.
    pub edges: Vec<Edge>,
    /// The sample's value, as [`super::render`] adds it to the picture.
    pub estimate: Estimate,
}

/// What is asked and found between two bounces.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The shadow ray at the bounce before, if there is one, and the ray itself.
    pub queries: Vec<Query>,
    /// Radiance of the path up to here.
    pub radiance: Rgb,
}

/// Edges that are told apart: each takes a path of its own.
const MOST_EDGES: u32 = 1000;

/// Traces one sample by itself, as [`super::render`] does among others; `None` if the scene asks for layers
/// alone.
///
/// A sample's numbers do not depend on where its path ends, so the path of at most n edges is the beginning
/// of that of n + 1.
#[must_use]
pub fn trace(description: &Description, engine: &dyn Intersector, id: SampleId) -> Option<Trace> {
    let recorder = Recorder::new(engine);
    let renderer = Renderer::new(description, &recorder);
    let numbers = sampler::build(&SamplerSettings { seed: id.seed, ..description.sampler });
    let look = |settings: &IntegratorSettings| {
        let (integrator, _) = integrator::build(settings, &description.scene);
        let Sample { ray, mut sampler } = renderer.begin(numbers.as_ref(), id);
        let mut tracer = Tracer::new(&description.scene, &recorder);
        let estimate = integrator?.estimate(&mut tracer, &ray, &mut sampler);
        Some((estimate, recorder.take()))
    };
    let (estimate, queries) = look(&description.integrator)?;
    let (mut edges, mut told) = (Vec::new(), 0);
    let picture = description.integrator.picture()?.about();
    for limited in (1..=MOST_EDGES).map_while(|most| picture.up_to(most)) {
        let (so_far, first) = look(&limited)?;
        if first.len() == queries.len() {
            break;
        }
        let queries = queries[told..first.len()].to_vec();
        told = first.len();
        edges.push(Edge { queries, radiance: so_far.radiance });
    }
    edges.push(Edge { queries: queries[told..].to_vec(), radiance: estimate.radiance });
    Some(Trace { edges, estimate })
}
