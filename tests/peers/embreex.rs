//! Embree 4 as the Python package `embreex` ships and calls it.
//!
//! `embreex` was made for `trimesh` and offers less than Embree: triangles only, no `t_min` (a ray starts at
//! its origin), no time, and one ray after the other on one thread. It takes f32 and hands the hit over as
//! Embree reports it.

use std::sync::{Arc, Mutex};

use telamon::intersect::Intersector;
use telamon::ray::{Hit, Ray, Rays};
use telamon::shape::{Geometry, Shape};

use crate::support::python::{self, Python};

/// An engine in another process. It is asked about rays with `t_min` 0 only, and in batches unless a
/// detour through two pipes is no matter.
#[derive(Debug)]
pub(crate) struct Embreex {
    process: Mutex<Python>,
    name: String,
}

/// What a batch is about.
#[derive(Clone, Copy)]
enum Query {
    Closest = 0,
    Occluded = 1,
}

impl Embreex {
    /// Starts it over `shapes`, which are meshes.
    pub(crate) fn new(shapes: &[Arc<dyn Shape>], robust: bool) -> Self {
        let interpreter = python::peers().unwrap_or_else(|message| panic!("{message}"));
        let mode = if robust { "robust" } else { "fast" };
        let script = include_str!("trace_rays.py");
        let mut process = Python::start(&interpreter, script, &[mode.to_owned()]).expect("starts");
        let mut bytes = words([shapes.len() as u32]);
        for shape in shapes {
            let Geometry::Triangles { positions, triangles } = shape.geometry() else {
                panic!("embreex has triangles only, not {shape:?}");
            };
            bytes.extend(words([positions.len() as u32, triangles.len() as u32]));
            bytes.extend(floats(positions.iter().flat_map(|p| p.to_array())));
            bytes.extend(words(triangles.iter().copied().flatten()));
        }
        process.send(&bytes).expect("listens");
        let name = process.line().expect("answers");
        Self { process: Mutex::new(process), name }
    }

    /// `WORDS` numbers for each ray, as bits.
    fn ask<const WORDS: usize>(&self, query: Query, rays: &Rays) -> Vec<[u32; WORDS]> {
        let mut bytes = words([query as u32, rays.len() as u32]);
        for ray in rays.iter() {
            assert_eq!((ray.t_min, ray.time), (0.0, 0.0), "embreex knows neither: {ray:?}");
            // A ray that no engine may see is none, whatever is answered for it.
            let numbers = [ray.origin.to_array(), ray.direction.to_array(), [ray.t_max, 0.0, 0.0]];
            let numbers = numbers.into_iter().flatten().take(7);
            bytes.extend(floats(numbers.map(|n| if ray.is_traceable() { n } else { 0.0 })));
        }
        let mut process = self.process.lock().expect("no other thread has panicked");
        process.send(&bytes).expect("listens");
        let answer = process.bytes(rays.len() * WORDS * 4).expect("answers");
        let mut numbers =
            answer.chunks_exact(4).map(|b| u32::from_le_bytes(b.try_into().expect("four bytes")));
        rays.iter().map(|_| [0; WORDS].map(|_| numbers.next().expect("of this length"))).collect()
    }
}

fn words(numbers: impl IntoIterator<Item = u32>) -> Vec<u8> {
    numbers.into_iter().flat_map(u32::to_le_bytes).collect()
}

fn floats(numbers: impl IntoIterator<Item = f32>) -> Vec<u8> {
    words(numbers.into_iter().map(f32::to_bits))
}

impl Intersector for Embreex {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let mut hit = [None];
        self.closest_hits(&Rays::from_iter([ray]), &mut hit);
        hit[0]
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let mut occluded = [false];
        self.occluded_many(&Rays::from_iter([ray]), &mut occluded);
        occluded[0]
    }

    fn closest_hits(&self, rays: &Rays, hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one answer for each ray");
        for ((ray, slot), answer) in rays.iter().zip(hits).zip(self.ask(Query::Closest, rays)) {
            let [shape, primitive, t, u, v] = answer;
            let [t, u, v] = [t, u, v].map(f32::from_bits);
            // As with our own Embree, a triangle whose test leaves the range of f32 is no hit.
            let found = ray.is_traceable() && shape != u32::MAX && t.is_finite();
            *slot = found.then_some(Hit { t, u, v, shape, primitive, member: 0 });
        }
    }

    fn occluded_many(&self, rays: &Rays, occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer for each ray");
        for ((ray, slot), [answer]) in
            rays.iter().zip(occluded).zip(self.ask(Query::Occluded, rays))
        {
            *slot = ray.is_traceable() && answer != u32::MAX;
        }
    }

    /// Unknown: `embreex` does not tell.
    fn bytes(&self) -> usize {
        0
    }

    fn name(&self) -> String {
        self.name.clone()
    }
}
