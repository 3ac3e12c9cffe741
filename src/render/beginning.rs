//! The beginnings of paths: rays from the camera, and the numbers of the rest.

use super::SampleId;
use super::tiles::Renderer;
use crate::integrator::{Sample, Samples};
use crate::math::real::{Lanes, Level, Real, Simd, Task, f32x8};
use crate::math::vector::Vec2;

use crate::ray::{CameraRays, Rays};
use crate::sampler::{PathKeys, PathSampler, PathSamplers, Sampler};

/// The samples of `ids`, in their order.
pub(super) struct Beginnings<'r, 'a, 's, I> {
    renderer: &'r Renderer<'a>,
    sampler: &'s dyn Sampler,
    ids: I,
}

impl Renderer<'_> {
    /// The camera ray of a sample, and the numbers of the rest of its path.
    pub(super) fn begin<'s>(&self, sampler: &'s dyn Sampler, id: SampleId) -> Sample<'s> {
        let (rays, numbers) = self.begin_each::<f32>((), sampler, |_| id);
        Sample { ray: rays.lane(0), sampler: PathSampler::resume(&numbers, 0) }
    }

    /// The same of the samples of `ids`.
    pub(super) fn begin_all<'s, I: Iterator<Item = SampleId>>(
        &self,
        sampler: &'s dyn Sampler,
        ids: I,
    ) -> Beginnings<'_, '_, 's, I> {
        Beginnings { renderer: self, sampler, ids }
    }

    /// The same of a sample in each lane.
    #[inline(always)]
    fn begin_each<'s, R: Real>(
        &self,
        token: R::Token,
        sampler: &'s dyn Sampler,
        id: impl Fn(usize) -> SampleId,
    ) -> (CameraRays<R>, PathSamplers<'s, R>) {
        let film = &self.description.film;
        let everywhere = R::mask(token, |_| true);
        let keys = R::each(|i| {
            let SampleId { x, y, sample, .. } = id(i);
            PathKeys::from(sampler.path(y * film.width + x, sample))
        });
        let keys = keys.as_ref();
        let keys = PathKeys {
            high: R::Uint::from_fn(token, |i| keys[i].high),
            low: R::Uint::from_fn(token, |i| keys[i].low),
        };
        let mut numbers = PathSamplers::new(sampler, keys, R::Uint::splat(token, 0));
        let offset = self.filter.sample(numbers.next_2d(everywhere)).widen();
        // In f64: an f32 would put what lies at the end of pixel 1000 on the next one.
        let center =
            |of: fn(SampleId) -> u32| R::Double::from_fn(token, |i| f64::from(of(id(i))) + 0.5);
        let film = Vec2::new(
            (center(|id| id.x) + offset.x) / f64::from(film.width),
            (center(|id| id.y) + offset.y) / f64::from(film.height),
        );
        let camera = &self.description.camera;
        let lens = camera.has_lens().then(|| numbers.next_2d(everywhere));
        let mut rays = camera.rays(film, lens);
        if self.moves {
            rays.time = numbers.next_1d(everywhere);
            if let Some(motion) = &self.description.camera_motion {
                rays = rays.map(|ray| motion.carry(&ray, ray.time));
            }
        }
        (rays, numbers)
    }
}

impl<'s, I: Iterator<Item = SampleId>> Samples<'s> for Beginnings<'_, '_, 's, I> {
    fn next(&mut self) -> Option<Sample<'s>> {
        self.ids.next().map(|id| self.renderer.begin(self.sampler, id))
    }

    fn next_eight(&mut self, level: Level, rays: &mut Rays, samplers: &mut Vec<PathSampler<'s>>) {
        let mut ids = [None; 8];
        for id in &mut ids {
            *id = self.ids.next();
        }
        let Some(first) = ids[0] else { return };
        let Self { renderer, sampler, .. } = *self;
        level.run(Eight { renderer, sampler, ids: &ids, first, rays, samplers });
    }
}

/// [`Samples::next_eight`] at some level.
struct Eight<'r, 'a, 's, 'b> {
    renderer: &'r Renderer<'a>,
    sampler: &'s dyn Sampler,
    /// Those that there are, the first of them first.
    ids: &'b [Option<SampleId>; 8],
    first: SampleId,
    rays: &'b mut Rays,
    samplers: &'b mut Vec<PathSampler<'s>>,
}

impl Task for Eight<'_, '_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { renderer, sampler, ids, first, rays, samplers } = self;
        let id = |i: usize| ids[i].unwrap_or(first);
        let (eight, numbers) = renderer.begin_each::<f32x8<S>>(simd, sampler, id);
        let exists = f32x8::<S>::mask(simd, |i| ids[i].is_some());
        rays.append_from_camera(exists, &eight);
        let lanes = (0..8).filter(|&i| ids[i].is_some());
        samplers.extend(lanes.map(|i| PathSampler::resume(&numbers, i)));
    }
}
