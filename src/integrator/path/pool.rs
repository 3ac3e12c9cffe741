//! Many paths at once: their rays go out together.
//!
//! The paths of a pool take turns. In each, all rays are traced, every path scatters at the surface that its ray met,
//! eight at a time that met the same material, all shadow rays are traced, and new paths take the place of those that have
//! ended. What a path finds depends on nothing but its sample, and estimates are handed on in the order of the samples,
//! so that sums over them do not depend on when a path ends.

use std::{mem, ptr};

use super::groups::Groups;
use super::shadows::Shadows;
use super::state::{State, StateLanes};
use super::{Extras, Path, Paths, spoil_if_nan};
use crate::integrator::shading::Shading;
use crate::integrator::{Estimate, Samples, Tracer, Vertex};
use crate::math::Rgb;
use crate::math::real::{Lanes, Mask, Real, Simd, Task, f32x8};
use crate::math::vector::Vec3;
use crate::ray::{Hit, Ray, Rays};
use crate::sampler::{PathSampler, PathSamplers, Sampler};
use crate::shape::{Arrivals, Interaction};

/// Paths in a pool: enough that few packets of rays are not full, and few enough for a core's own cache.
const PATHS: usize = 256;

/// Samples begun after one that has not ended, at most.
const WAITING: usize = 4 * PATHS;

/// Paths that scatter together.
const LANES: usize = 8;

/// All that a pool holds at a time stays in a core's own cache.
const _: () = {
    // Both for this turn and for the next one.
    let path = 2 * (size_of::<Ray>() + State::MOST_BYTES) + size_of::<Option<Hit>>();
    let bytes = PATHS * (path + Shadows::BYTES + Groups::BYTES);
    assert!(bytes + WAITING * size_of::<Slot>() < 256 * 1024);
};

/// Paths under way, and what they have in common.
pub(super) struct Pool<'p, 't, 'a, 's> {
    integrator: &'p Path,
    tracer: &'t mut Tracer<'a>,
    /// That of all samples.
    sampler: Option<&'s dyn Sampler>,
    /// Numbers of samples that begin.
    begun: Vec<PathSampler<'s>>,
    now: Wave,
    next: Wave,
    hits: Vec<Option<Hit>>,
    groups: Groups,
    shadows: Shadows,
    finished: Finished,
}

/// Rays that are to be traced, and of each its path.
struct Wave {
    rays: Rays,
    paths: State,
}

impl Wave {
    fn new(extras: &Extras) -> Self {
        Self { rays: Rays::with_time(extras.time), paths: State::new(extras) }
    }
}

/// [`Pool::run`] at some level.
struct Run<'r, 'p, 't, 'a, 's> {
    pool: Pool<'p, 't, 'a, 's>,
    samples: &'r mut dyn Samples<'s>,
    done: &'r mut dyn FnMut(Estimate, &mut Tracer<'a>),
}

impl Task for Run<'_, '_, '_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { mut pool, samples, done } = self;
        loop {
            pool.fill(samples);
            if pool.now.rays.is_empty() {
                return;
            }
            pool.hits.resize(pool.now.rays.len(), None);
            pool.tracer.closest_hits(&pool.now.rays, &mut pool.hits);
            pool.group();
            pool.scatter(simd);
            pool.shadows.trace(pool.tracer, &mut pool.finished.slots);
            pool.finished.hand_on(|estimate| done(estimate, pool.tracer));
            mem::swap(&mut pool.now, &mut pool.next);
            pool.next.rays.clear();
            pool.next.paths.clear();
        }
    }
}

impl<'p, 't, 'a, 's> Pool<'p, 't, 'a, 's> {
    pub(super) fn new(integrator: &'p Path, tracer: &'t mut Tracer<'a>) -> Self {
        // And the outside.
        let materials = tracer.scene().bsdfs().len() + 1;
        let extras = &integrator.extras;
        Self {
            integrator,
            tracer,
            sampler: None,
            begun: Vec::new(),
            now: Wave::new(extras),
            next: Wave::new(extras),
            hits: Vec::with_capacity(PATHS),
            groups: Groups::new(materials, PATHS),
            shadows: Shadows::new(extras),
            finished: Finished::new(),
        }
    }

    /// Follows the path of each sample and hands on what it finds.
    pub(super) fn run(
        self,
        samples: &mut dyn Samples<'s>,
        done: &mut dyn FnMut(Estimate, &mut Tracer<'a>),
    ) {
        self.tracer.level().run(Run { pool: self, samples, done });
    }

    /// Begins new paths where there is room for eight.
    fn fill(&mut self, samples: &mut dyn Samples<'s>) {
        let Self { sampler: of_all, tracer, now, begun, finished, .. } = self;
        while now.rays.len() + LANES <= PATHS && finished.has_room() {
            samples.next_eight(tracer.level(), &mut now.rays, begun);
            if begun.is_empty() {
                return;
            }
            for (sampler, key, dimension) in begun.drain(..).map(|sampler| sampler.parts()) {
                let first = *of_all.get_or_insert(sampler);
                debug_assert!(ptr::addr_eq(first, sampler), "all samples have one sampler");
                now.paths.begin(finished.begin(), key, dimension);
            }
        }
    }

    /// Puts together the paths that have met the same material, and those that have left the scene, if there is anything to
    /// see outside; else these end.
    fn group(&mut self) {
        let Self { integrator, tracer, now, hits, groups, finished, .. } = self;
        let scene = tracer.scene();
        let outside = scene.environment().map(|_| scene.bsdfs().len());
        groups.clear();
        for (path, hit) in hits.iter().enumerate() {
            if let Some(hit) = hit {
                let object = &scene.objects()[hit.shape as usize];
                groups.add(object.bsdf_of(hit.member), path);
            } else if let Some(group) = outside {
                groups.add(group, path);
            } else {
                let (slot, from_camera, unscattered) = now.paths.whence(path);
                let Slot { estimate, has_ended } = &mut finished.slots[slot];
                integrator.leave(tracer, from_camera, unscattered, estimate);
                *has_ended = true;
            }
        }
    }

    /// Lets every path scatter where its ray has led, those at the same material together.
    #[inline(always)]
    fn scatter<S: Simd>(&mut self, simd: S) {
        for group in 0..self.groups.len() {
            let mut next = self.groups.first(group);
            let hits_something = next.is_some_and(|path| self.hits[path].is_some());
            while let Some(first) = next {
                let (mut paths, mut count) = ([first; LANES], 0);
                while let Some(path) = next
                    && count < LANES
                {
                    paths[count] = path;
                    count += 1;
                    next = self.groups.after(path);
                }
                if hits_something {
                    self.turn::<f32x8<S>>(simd, &paths, count);
                } else {
                    self.leave::<f32x8<S>>(simd, &paths, count);
                }
                // Some settings ask for many at each surface.
                if self.shadows.len() >= PATHS {
                    self.shadows.trace(self.tracer, &mut self.finished.slots);
                }
            }
        }
    }

    /// Lets the first `count` of these paths, whose rays have left the scene, see what is outside.
    #[inline(always)]
    fn leave<R: Real>(&mut self, token: R::Token, paths: &[usize; LANES], count: usize) {
        let Self { integrator, tracer, now, finished, .. } = self;
        let (origin, direction, _) = now.rays.gather::<R>(token, paths);
        let state = now.paths.gather::<R>(token, paths);
        let edges = state.last_edges(&now.rays.gather_starts(token, paths));
        let begins = state.begins();
        for i in 0..count {
            let Slot { estimate, has_ended } = &mut finished.slots[state.slot(i)];
            integrator.leave(tracer, begins.lane(i), state.is_unscattered(i), estimate);
            *has_ended = true;
        }
        let hidden = begins & R::Mask::splat(token, integrator.settings.hide_emitters);
        let seen = R::mask(token, |i| i < count) & !hidden;
        let radiance = integrator.background(tracer, origin, direction, &edges);
        add(&mut finished.slots, &state, seen, radiance);
    }

    /// Lets the first `count` of these paths scatter, whose rays have met one material.
    #[inline(always)]
    fn turn<R: Real>(&mut self, token: R::Token, paths: &[usize; LANES], count: usize) {
        let Self { integrator, tracer, sampler, now, next, hits, shadows, finished, .. } = self;
        let (scene, slots) = (tracer.scene(), &mut finished.slots);
        let (origin, direction, time) = now.rays.gather::<R>(token, paths);
        let found = R::each(|i| hits[paths[i]].expect("grouped by what was hit"));
        let object = |i: usize| &scene.objects()[found.as_ref()[i].shape as usize];
        let arrivals = Arrivals::<R> {
            shapes: R::each(|i| object(i).shape.as_ref()),
            hits: found,
            origin,
            direction,
            time,
        };
        let ray = |i: usize| now.rays.get(paths[i]);
        let interaction = Interaction::new(&arrivals, ray);
        let bsdf = scene.bsdfs()[object(0).bsdf_of(found.as_ref()[0].member)].as_ref();

        let state = now.paths.gather::<R>(token, paths);
        let mut goes_on = R::mask(token, |i| i < count);
        let emits = R::mask(token, |i| object(i).emitter.is_some());
        let begins = goes_on & state.begins();
        for i in (0..count).filter(|&i| begins.lane(i)) {
            // Nothing but a surface.
            slots[state.slot(i)].estimate = Estimate { radiance: Rgb::ZERO, alpha: 1.0 };
        }
        if emits.any() {
            if integrator.settings.hide_emitters {
                for i in (0..count).filter(|&i| (begins & emits).lane(i)) {
                    let hit = found.as_ref()[i];
                    let vertex =
                        Vertex { object: object(i), hit, surface: interaction.lane(i), bsdf };
                    let Some(rest) = Path::look_through(tracer, &ray(i), &vertex) else { continue };
                    next.rays.push(&rest);
                    next.paths.push(now.paths.row(paths[i]));
                    goes_on &= !R::mask(token, |lane| lane == i);
                }
            }
            let seen = goes_on & emits;
            let edges = state.last_edges(&now.rays.gather_starts(token, paths));
            let radiance =
                integrator.emitted(tracer, object, &arrivals, &interaction, seen, &edges);
            add(slots, &state, seen, radiance);
        }
        let is_longest = match integrator.settings.max_depth {
            Some(_) => R::mask(token, |i| integrator.is_longest(state.edges(i))),
            None => R::Mask::splat(token, false),
        };
        for i in (0..count).filter(|&i| (goes_on & is_longest).lane(i)) {
            slots[state.slot(i)].has_ended = true;
        }
        let scatters = goes_on & !is_longest;
        if !scatters.any() {
            return;
        }

        let shading = Shading::new(bsdf, &interaction, &arrivals, ray);
        let sampler = sampler.expect("there are samples");
        let StateLanes { throughput, eta, keys, dimension, .. } = state;
        let min_depth = integrator.settings.roulette.min_depth;
        let mut lanes = Paths::new(
            throughput,
            eta,
            R::splat(token, 1.0),
            R::mask(token, |i| state.edges(i) < min_depth),
            state.is_first(),
            PathSamplers::new(sampler, keys, dimension),
        );
        let samples = integrator.light_samples(shading.flags);
        if samples > 0 {
            let receivers = shadows.receive(scatters, samples, throughput, state.slots);
            for _ in 0..samples {
                let lights = integrator.next_event(
                    scene.emitters(),
                    &interaction,
                    &shading,
                    &mut lanes,
                    scatters,
                );
                for light in lights.iter().filter(|light| light.exists.any()) {
                    shadows.add(receivers, light, &light.shadow_rays(&interaction));
                }
            }
        }
        let (direction, goes_on) = integrator.scatter(&shading, &mut lanes, scatters);
        for i in (0..count).filter(|&i| (scatters & !goes_on).lane(i)) {
            let slot = &mut slots[state.slot(i)];
            slot.has_ended = true;
            spoil_if_nan(&mut slot.estimate, lanes.throughput.lane(i).into());
        }
        next.rays.append(goes_on, &interaction.spawn(direction));
        next.paths.append(goes_on, &state.after(&lanes, shading.flags));
    }
}

/// Adds light that arrives where paths have led to what they have found.
#[inline(always)]
fn add<R: Real>(slots: &mut [Slot], state: &StateLanes<R>, mask: R::Mask, light: Vec3<R>) {
    let light = state.throughput.times(light);
    for i in (0..R::LANES).filter(|&i| mask.lane(i)) {
        slots[state.slot(i)].estimate.radiance += Rgb::from(light.lane(i));
    }
}

/// Samples that have begun, in their order.
struct Finished {
    /// Of each of them, at its number modulo [`WAITING`].
    slots: Vec<Slot>,
    /// Samples that were handed on.
    handed_on: u64,
    /// Samples that have begun.
    begun: u64,
}

/// What a sample has found so far.
#[derive(Clone, Copy, Default)]
pub(super) struct Slot {
    pub(super) estimate: Estimate,
    has_ended: bool,
}

impl Finished {
    fn new() -> Self {
        Self { slots: Vec::new(), handed_on: 0, begun: 0 }
    }

    /// Whether eight more can begin.
    fn has_room(&self) -> bool {
        self.begun - self.handed_on + LANES as u64 <= WAITING as u64
    }

    /// The place of the next sample.
    fn begin(&mut self) -> usize {
        let slot = (self.begun % WAITING as u64) as usize;
        if slot == self.slots.len() {
            self.slots.push(Slot::default());
        } else {
            self.slots[slot] = Slot::default();
        }
        self.begun += 1;
        slot
    }

    fn hand_on(&mut self, mut done: impl FnMut(Estimate)) {
        while self.handed_on < self.begun {
            let slot = self.slots[(self.handed_on % WAITING as u64) as usize];
            if !slot.has_ended {
                return;
            }
            done(slot.estimate);
            self.handed_on += 1;
        }
    }
}
