//! What every integrator asks of a scene: the next vertex of a path, and whether light gets through.

use std::iter;

use glam::{DVec3, Vec3A};

use super::{DirectionSampling, Estimate};
use crate::bsdf::{Bsdf, BsdfSample, Flags, Needs, Place, shading_normal};
use crate::emitter::{Emitter, Receiver, Sight};
use crate::intersect::Intersector;
use crate::math::vector::Vec3;
use crate::math::{Frame, Rgb};
use crate::ray::{Hit, Ray};
use crate::sampler::PathSampler;
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

impl Vertex<'_> {
    /// The shading normal as the material sees it from the start of `ray`.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    fn normal(&self, ray: &Ray) -> Vec3A {
        let SurfacePoint { shading_normal, geometric_normal, .. } = self.surface;
        if shading_normal == geometric_normal {
            return shading_normal;
        }
        let interface = self.bsdf.interface();
        let [shading, geometric] = [shading_normal, geometric_normal].map(Vec3::from);
        shading_normal::bend(shading, geometric, Vec3::from(-ray.direction), interface).into()
    }
}

impl<'a> Tracer<'a> {
    /// `engine` must have been built over the shapes of `scene`.
    #[must_use]
    pub fn new(scene: &'a Scene, engine: &'a dyn Intersector) -> Self {
        Self { scene, engine, counts: RayCounts::default() }
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
            self.count_untraceable(iter::once(ray));
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
    pub(super) fn closest_hits(&mut self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.counts.closest += rays.len() as u64;
        self.engine.closest_hits(rays, hits);
        let missed = rays.iter().zip(hits).filter(|(_, hit)| hit.is_none());
        self.count_untraceable(missed.map(|(ray, _)| ray));
    }

    /// [`Tracer::occluded`] of each ray.
    pub(super) fn occluded_many(&mut self, rays: &[Ray], occluded: &mut [bool]) {
        self.counts.occlusion += rays.len() as u64;
        self.engine.occluded_many(rays, occluded);
        let free = rays.iter().zip(occluded).filter(|(_, occluded)| !**occluded);
        self.count_untraceable(free.map(|(ray, _)| ray));
    }

    /// Counts among rays that found nothing, which is what engines say to untraceable ones.
    #[inline(always)]
    fn count_untraceable<'r>(&mut self, rays: impl Iterator<Item = &'r Ray>) {
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
            self.count_untraceable(iter::once(ray));
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

/// A vertex as its material sees it: a frame around the shading normal, bent where it has to be
/// ([`shading_normal`]), and the rule that the geometric normal decides what is a reflection.
#[derive(Debug)]
pub(super) struct Shading<'a> {
    pub(super) bsdf: &'a dyn Bsdf,
    pub(super) flags: Flags,
    pub(super) place: Place,
    frame: Frame,
    geometric_normal: Vec3A,
    /// Where the path came from, local.
    pub(super) wi: Vec3A,
    /// Cosine of the same with the geometric normal.
    cos_geometric: f32,
}

impl<'a> Shading<'a> {
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    pub(super) fn new(vertex: &Vertex<'a>, ray: &Ray) -> Self {
        let geometric_normal = vertex.surface.geometric_normal;
        let flags = vertex.bsdf.flags();
        let normal = vertex.normal(ray);
        let mut shading = Self {
            bsdf: vertex.bsdf,
            flags,
            place: Place::default(),
            frame: Frame::from_normal(normal.into()),
            geometric_normal,
            wi: Vec3A::ZERO,
            cos_geometric: -ray.direction.dot(geometric_normal),
        };
        // Filled in where it is, since copies of it cost more than the rest.
        if flags.needs != Needs::Nothing {
            shading.look_up(vertex, ray);
        }
        shading.wi = shading.frame.to_local((-ray.direction).into()).into();
        shading
    }

    /// The place as far as the material needs it. With tangents x of the frame is the direction in which the
    /// first texture coordinate grows.
    #[inline(never)]
    fn look_up(&mut self, vertex: &Vertex<'a>, ray: &Ray) {
        let shape = vertex.object.shape.as_ref();
        self.place.uv = shape.uv(ray, &vertex.hit).into();
        if self.flags.needs != Needs::Tangents {
            return;
        }
        let [dp_du, dp_dv] = shape.tangents(ray, &vertex.hit);
        self.frame = Frame::from_normal_and_tangent(self.frame.n, dp_du.into());
        self.place.dp_du = self.frame.to_local(dp_du.into());
        self.place.dp_dv = self.frame.to_local(dp_dv.into());
        self.place.geometric_normal = self.frame.to_local(self.geometric_normal.into());
    }

    /// See [`Bsdf::albedo`].
    pub(super) fn albedo(&self) -> Rgb {
        self.bsdf.albedo(&self.place, self.wi)
    }

    /// A direction for the path to go on, in the world, with the weight f·|cosθ|/pdf. `None` where it
    /// ends.
    pub(super) fn scatter(
        &self,
        directions: DirectionSampling,
        sampler: &mut PathSampler<'_>,
    ) -> Option<(Vec3A, Rgb)> {
        let sample = directions.sample(self, sampler.next_2d())?;
        Some((self.onward(&sample)?, sample.weight))
    }

    /// This vertex as one that light is to arrive at: what does not transmit needs none from behind.
    #[inline]
    pub(super) fn receiver(&self, surface: &SurfacePoint) -> Receiver {
        let normal = self.geometric_normal;
        Receiver {
            position: surface.position,
            normal: if self.cos_geometric < 0.0 { -normal } else { normal },
            both_sides: self.flags.transmits,
        }
    }

    pub(super) fn to_local(&self, direction: Vec3A) -> Vec3A {
        self.frame.to_local(direction.into()).into()
    }

    /// The direction of a sample in the world; `None` where it would leak.
    // Inlined for the same reason as `Tracer::closest_vertex`.
    #[inline(always)]
    pub(super) fn onward(&self, sample: &BsdfSample) -> Option<Vec3A> {
        let mut direction = Vec3A::from(self.frame.to_world(sample.wo.into()));
        if sample.lobe.is_delta() {
            // It comes from the one before it: its length would drift, by 1e-4 in ten thousand bounces.
            direction = direction.normalize();
        }
        self.sides_agree(sample.wo, direction).then_some(direction)
    }

    /// Whether the shading normal and the geometric normal agree on which side of the surface `wo` is
    /// (local and world form of one direction): whether it is a reflection for both, or for neither.
    /// Where they do not, light would leak through the surface (Veach 1997, section 5.3).
    fn sides_agree(&self, wo: Vec3A, wo_world: Vec3A) -> bool {
        let reflected = self.wi.z * wo.z > 0.0;
        let reflected_geometrically =
            self.cos_geometric * self.geometric_normal.dot(wo_world) > 0.0;
        reflected == reflected_geometrically
    }

    /// f·|cosθ| towards a world direction; 0 where the normals disagree about the side.
    pub(super) fn eval(&self, wo: Vec3A, wo_world: Vec3A) -> Rgb {
        if self.sides_agree(wo, wo_world) {
            self.bsdf.eval(&self.place, self.wi, wo)
        } else {
            Rgb::ZERO
        }
    }
}
