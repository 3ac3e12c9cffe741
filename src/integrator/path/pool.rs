//! Many paths at once: their rays go out together.
//!
//! The paths of a pool take turns. In each, all rays are traced, every path scatters at the surface that its ray met,
//! all shadow rays are traced, and paths that have ended make room for new ones. What a path finds
//! depends on nothing but its sample, and estimates are handed on in the order of the samples, so that sums over them
//! do not depend on when a path ends.

use std::collections::VecDeque;

use super::{Carried, Path};
use crate::integrator::tracer::{CameraView, Shading};
use crate::integrator::{Estimate, Sample, Tracer};
use crate::math::Rgb;
use crate::ray::{Hit, Ray};
use crate::sampler::PathSampler;

/// Paths in a pool: enough that few packets of rays are not full, and few enough for a core's own cache.
const PATHS: usize = 256;

/// Samples begun after one that has not ended, at most.
const WAITING: usize = 4 * PATHS;

/// All that a pool holds at a time stays in a core's own cache.
const _: () = {
    let path = size_of::<Ray>() + size_of::<Option<Hit>>() + size_of::<Entry<'_>>();
    let shadow = size_of::<ReceiverOf>() + size_of::<Ray>() + size_of::<(Rgb, bool)>() + 1;
    let bytes = PATHS * (path + shadow) + WAITING * size_of::<Option<Estimate>>();
    assert!(bytes < 256 * 1024);
};

/// Paths under way, and what they have in common.
pub(super) struct Pool<'p, 't, 'a, 's> {
    integrator: &'p Path,
    tracer: &'t mut Tracer<'a>,
    /// Of each path the ray that is to be traced next.
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    paths: Vec<Entry<'s>>,
    shadows: Shadows,
    finished: Finished,
}

/// A path under way.
struct Entry<'s> {
    /// Number of its sample.
    sample: u64,
    sampler: PathSampler<'s>,
    /// `None` on the way from the camera.
    carried: Option<Carried>,
    estimate: Estimate,
}

impl<'p, 't, 'a, 's> Pool<'p, 't, 'a, 's> {
    pub(super) fn new(integrator: &'p Path, tracer: &'t mut Tracer<'a>) -> Self {
        Self {
            integrator,
            tracer,
            rays: Vec::with_capacity(PATHS),
            hits: Vec::with_capacity(PATHS),
            paths: Vec::with_capacity(PATHS),
            shadows: Shadows::default(),
            finished: Finished::default(),
        }
    }

    /// Follows the path of each sample and hands on what it finds.
    pub(super) fn run(
        mut self,
        samples: &mut dyn Iterator<Item = Sample<'s>>,
        done: &mut dyn FnMut(Estimate, &mut Tracer<'a>),
    ) {
        loop {
            self.fill(samples);
            if self.paths.is_empty() {
                return;
            }
            self.hits.resize(self.rays.len(), None);
            self.tracer.closest_hits(&self.rays, &mut self.hits);
            let ended = self.scatter();
            self.shadows.trace(self.tracer, &mut self.paths);
            self.remove(&ended);
            self.finished.hand_on(|estimate| done(estimate, self.tracer));
        }
    }

    /// Begins new paths where there is room.
    fn fill(&mut self, samples: &mut dyn Iterator<Item = Sample<'s>>) {
        while self.paths.len() < PATHS && self.finished.waiting.len() < WAITING {
            let Some(Sample { ray, sampler }) = samples.next() else { return };
            let sample = self.finished.begin();
            let estimate = Estimate::default();
            self.paths.push(Entry { sample, sampler, carried: None, estimate });
            self.rays.push(ray);
        }
    }

    /// Lets every path scatter where its ray has led. The places of those that end, in ascending order.
    fn scatter(&mut self) -> Vec<usize> {
        let mut ended = Vec::new();
        for place in 0..self.paths.len() {
            match self.turn(place) {
                Some(ray) => self.rays[place] = ray,
                None => ended.push(place),
            }
            // Some settings ask for many at each surface.
            if self.shadows.rays.len() >= PATHS {
                self.shadows.trace(self.tracer, &mut self.paths);
            }
        }
        ended
    }

    /// The next ray of a path, if it goes on.
    #[inline(always)]
    fn turn(&mut self, place: usize) -> Option<Ray> {
        let Self { integrator, tracer, rays, hits, paths, shadows, .. } = self;
        let (ray, path) = (&rays[place], &mut paths[place]);
        let vertex;
        let here = match hits[place] {
            Some(hit) => {
                vertex = tracer.vertex(ray, hit);
                Some(&vertex)
            }
            None => None,
        };
        let carried = match &mut path.carried {
            Some(carried) => {
                integrator.arrive(tracer, ray, here, carried, &mut path.estimate);
                carried
            }
            None => {
                let hide = integrator.settings.hide_emitters;
                match tracer.seen_by_camera(ray, here, hide) {
                    CameraView::Seen(estimate) => path.estimate = estimate,
                    CameraView::Behind(rest) => return Some(rest),
                }
                path.carried.insert(Carried::BEGUN)
            }
        };
        let here = here?;
        if integrator.is_longest(carried.edges) {
            return None;
        }
        let shading = Shading::new(here, ray);
        let samples = integrator.light_samples(&shading);
        if samples > 0 {
            let directions = integrator.directions(carried.edges);
            shadows.begin(place, carried.throughput, samples);
            for _ in 0..samples {
                let found =
                    integrator.next_event(tracer, here, &shading, directions, &mut path.sampler);
                if let Some((light, sample)) = found {
                    shadows.add(light, sample.shadow_ray(&here.surface));
                }
            }
        }
        integrator.go_on(here, &shading, carried, &mut path.sampler, &mut path.estimate)
    }

    /// Takes out the paths at these places, the last first, so that the others stay where they are meant.
    fn remove(&mut self, ended: &[usize]) {
        for &place in ended.iter().rev() {
            let path = self.paths.swap_remove(place);
            self.rays.swap_remove(place);
            self.finished.end(path.sample, path.estimate);
        }
    }
}

/// The shadow rays of a turn.
#[derive(Default)]
struct Shadows {
    /// The surfaces that light is to arrive at.
    receivers: Vec<ReceiverOf>,
    rays: Vec<Ray>,
    occluded: Vec<bool>,
    /// Of each sample the light that arrives if nothing is between, and whether a ray has to say so.
    lights: Vec<(Rgb, bool)>,
}

/// A surface that light is to arrive at, by so many samples.
struct ReceiverOf {
    place: usize,
    throughput: Rgb,
    samples: u32,
    /// Those by which any may arrive.
    lit: u32,
}

impl Shadows {
    fn begin(&mut self, place: usize, throughput: Rgb, samples: u32) {
        self.receivers.push(ReceiverOf { place, throughput, samples, lit: 0 });
    }

    /// A sample of the light that arrives at the newest surface, and what has to be free for that; nothing, where the two
    /// are too close.
    #[inline(always)]
    fn add(&mut self, light: Rgb, shadow_ray: Option<Ray>) {
        if let Some(receiver) = self.receivers.last_mut() {
            receiver.lit += 1;
        }
        self.lights.push((light, shadow_ray.is_some()));
        if let Some(ray) = shadow_ray {
            self.rays.push(ray);
        }
    }

    /// Traces them all and adds to each path what arrives.
    fn trace(&mut self, tracer: &mut Tracer<'_>, paths: &mut [Entry<'_>]) {
        self.occluded.resize(self.rays.len(), false);
        tracer.occluded_many(&self.rays, &mut self.occluded);
        let mut occluded = self.occluded.iter();
        let mut lights = self.lights.iter();
        for receiver in &self.receivers {
            let mut arriving = Rgb::ZERO;
            for (light, has_ray) in lights.by_ref().take(receiver.lit as usize) {
                if !(*has_ray && occluded.next().is_some_and(|&occluded| occluded)) {
                    arriving += *light;
                }
            }
            let estimate = &mut paths[receiver.place].estimate;
            estimate.radiance += receiver.throughput * (arriving / receiver.samples as f32);
        }
        self.receivers.clear();
        self.rays.clear();
        self.occluded.clear();
        self.lights.clear();
    }
}

/// Estimates in the order of their samples.
#[derive(Default)]
struct Finished {
    /// Samples that were handed on.
    handed_on: u64,
    /// Of the samples after these, what has been found, where the path has ended.
    waiting: VecDeque<Option<Estimate>>,
}

impl Finished {
    /// The number of the next sample.
    fn begin(&mut self) -> u64 {
        self.waiting.push_back(None);
        self.handed_on + self.waiting.len() as u64 - 1
    }

    fn end(&mut self, sample: u64, estimate: Estimate) {
        self.waiting[(sample - self.handed_on) as usize] = Some(estimate);
    }

    fn hand_on(&mut self, mut done: impl FnMut(Estimate)) {
        while let Some(Some(estimate)) = self.waiting.front() {
            done(*estimate);
            self.waiting.pop_front();
            self.handed_on += 1;
        }
    }
}
