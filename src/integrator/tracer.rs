//! What every integrator asks of a scene: the next vertex of a path, and whether light gets through.

use std::iter;

use glam::{DVec3, Vec3A};

use super::Estimate;
use crate::bsdf::Bsdf;
use crate::emitter::{Emitter, Sight};
use crate::intersect::Intersector;
use crate::math::Rgb;
use crate::math::real::Level;
use crate::ray::{Hit, Ray, Rays};
use crate::scene::{Object, Scene};
use crate::shape::SurfacePoint;

/// How many rays were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// Closest-hit queries.
    pub closest: u64,
    /// Occlusion queries.
    pub occlusion: u64,
    /// Rays among these that no engine could be asked about; more than 0 is a bug unless the scene's
    /// numbers leave the range of f32.
    pub untraceable: u64,
}

impl RayCounts {
    /// Closest-hit and occlusion queries together.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.closest + self.occlusion
    }
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.closest += other.closest;
        self.occlusion += other.occlusion;
        self.untraceable += other.untraceable;
    }
}

/// A scene with the engine that was built over it, as one thread sees them.
#[derive(Debug)]
pub struct Tracer<'a> {
    scene: &'a Scene,
    engine: &'a dyn Intersector,
    level: Level,
    /// Rays traced so far.
    pub counts: RayCounts,
}

/// A point where a path meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Vertex<'a> {
    /// What was hit.
    pub object: &'a Object,
    /// Where, in the engine's words.
    pub hit: Hit,
    /// Where, in space.
    pub surface: SurfacePoint,
    /// The object's material.
    pub bsdf: &'a dyn Bsdf,
}

/// What the camera sees at the end of a ray.
pub(super) enum CameraView {
    /// This, without any bounce.
    Seen(Estimate),
    /// Nothing that it shows: the ray goes on behind it.
    Behind(Ray),
}

impl<'a> Tracer<'a> {
    /// `engine` must have been built over the shapes of `scene`.
    #[must_use]
    pub fn new(scene: &'a Scene, engine: &'a dyn Intersector) -> Self {
        Self { scene, engine, level: Level::detect(), counts: RayCounts::default() }
    }

    /// The same with the instructions of this level: with the same answers.
    #[must_use]
    pub fn at_level(self, level: Level) -> Self {
        Self { level, ..self }
    }

    pub(super) fn level(&self) -> Level {
        self.level
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// The nearest surface along `ray`.
    // Returned through memory, the vertex costs a twentieth of a path.
    #[inline(always)]
    pub fn closest_vertex(&mut self, ray: &Ray) -> Option<Vertex<'a>> {
        self.counts.closest += 1;
        let Some(hit) = self.engine.closest_hit(ray) else {
            self.count_untraceable(iter::once(*ray));
            return None;
        };
        Some(self.vertex(ray, hit))
    }

    /// What an engine found for `ray`, as a vertex.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    pub(super) fn vertex(&self, ray: &Ray, mut hit: Hit) -> Vertex<'a> {
        let object = &self.scene.objects()[hit.shape as usize];
        let mut surface = object.shape.surface(ray, &hit);
        surface.time = ray.time;
        [hit.u, hit.v] = surface.parameters.to_array();
        let bsdf = self.scene.bsdfs()[object.bsdf_of(hit.member)].as_ref();
        Vertex { object, hit, surface, bsdf }
    }

    /// [`Intersector::closest_hit`] of each ray.
    pub(super) fn closest_hits(&mut self, rays: &Rays, hits: &mut [Option<Hit>]) {
        self.counts.closest += rays.len() as u64;
        self.engine.closest_hits(rays, hits);
        let missed = (0..rays.len()).filter(|&i| hits[i].is_none());
        self.count_untraceable(missed.map(|i| rays.get(i)));
    }

    /// [`Tracer::occluded`] of each ray.
    pub(super) fn occluded_many(&mut self, rays: &Rays, occluded: &mut [bool]) {
        self.counts.occlusion += rays.len() as u64;
        self.engine.occluded_many(rays, occluded);
        let free = (0..rays.len()).filter(|&i| !occluded[i]);
        self.count_untraceable(free.map(|i| rays.get(i)));
    }

    /// Counts among rays that found nothing, which is what engines say to untraceable ones.
    #[inline(always)]
    fn count_untraceable(&mut self, rays: impl Iterator<Item = Ray>) {
        self.counts.untraceable += rays.filter(|ray| !ray.is_traceable()).count() as u64;
    }

    /// The first vertex of a path from the camera, and the estimate that holds what the camera sees
    /// without any bounce. With `hide_emitters` the ray passes through emitters, as in Mitsuba 3, and is
    /// moved behind them.
    pub fn camera_vertex(
        &mut self,
        ray: &mut Ray,
        hide_emitters: bool,
    ) -> (Option<Vertex<'a>>, Estimate) {
        loop {
            let vertex = self.closest_vertex(ray);
            match self.seen_by_camera(ray, vertex.as_ref(), hide_emitters) {
                CameraView::Seen(estimate) => return (vertex, estimate),
                CameraView::Behind(rest) => *ray = rest,
            }
        }
    }

    /// What the camera sees of `vertex` without any bounce.
    pub(super) fn seen_by_camera(
        &self,
        ray: &Ray,
        vertex: Option<&Vertex<'a>>,
        hide_emitters: bool,
    ) -> CameraView {
        if !hide_emitters {
            let radiance = self.emitted(ray, vertex);
            let alpha = if vertex.is_some() { 1.0 } else { self.background_alpha() };
            return CameraView::Seen(Estimate { radiance, alpha });
        }
        match vertex {
            Some(v) if v.object.emitter.is_some() => {
                CameraView::Behind(v.surface.spawn(ray.direction).until(ray.t_max - v.hit.t))
            }
            Some(_) => CameraView::Seen(Estimate { radiance: Rgb::ZERO, alpha: 1.0 }),
            None => CameraView::Seen(Estimate::default()),
        }
    }

    /// 1 if there is an environment to be seen behind all surfaces, else 0.
    pub(super) fn background_alpha(&self) -> f32 {
        f32::from(u8::from(self.scene.environment().is_some()))
    }

    /// Whether anything lies within the ray's segment.
    pub fn occluded(&mut self, ray: &Ray) -> bool {
        self.counts.occlusion += 1;
        let occluded = self.engine.occluded(ray);
        if !occluded {
            self.count_untraceable(iter::once(*ray));
        }
        occluded
    }

    /// The emitter at the end of a ray: that of the surface it hit, or the environment if it hit none.
    /// With its index.
    #[must_use]
    pub fn emitter_in_sight(
        &self,
        vertex: Option<&Vertex<'a>>,
    ) -> Option<(usize, &'a dyn Emitter)> {
        match vertex {
            Some(vertex) => vertex.object.emitter.map(|i| (i, self.scene.emitters()[i].as_ref())),
            None => self.scene.environment(),
        }
    }

    /// Radiance of the emitter at the end of `ray`, which met `vertex` or left the scene.
    #[must_use]
    pub fn emitted(&self, ray: &Ray, vertex: Option<&Vertex<'a>>) -> Rgb {
        self.emitter_in_sight(vertex).map_or(Rgb::ZERO, |(_, emitter)| {
            emitter.radiance(&sight(ray.exact_origin(), ray.direction, vertex))
        })
    }
}

/// The line of sight from `from` to `vertex`, or out of the scene.
pub(super) fn sight<'v>(
    from: DVec3,
    direction: Vec3A,
    vertex: Option<&'v Vertex<'_>>,
) -> Sight<'v> {
    let surface = vertex.map(|v| (&v.hit, &v.surface));
    Sight { from, direction, surface }
}
