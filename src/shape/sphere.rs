//! Spheres.

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3A};

use super::sample::{ShapeSamples, Toward, area_pdf_toward};
use super::{
    Analytic, Arrivals, Crossing, Geometry, Interaction, PrimitiveLane, Shape, ShapeSample,
    SurfacePoint,
};
use crate::math::real::{Double, Float, Lanes, Mask, Real, Select};
use crate::math::{Aabb, Frame, vector as real, warp};
use crate::ray::{Hit, Ray};

/// A sphere in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    center: Vec3A,
    radius: f32,
    /// Rotation of the parameterisation: local axes in world coordinates.
    axes: Frame,
    /// −1 if the normals point inwards, else 1.
    side: f32,
}

impl Sphere {
    /// A sphere around `center` with `radius` > 0. The poles of its texture coordinates lie on ±n of
    /// `axes`, u = 0 on its s. `flip_normals` turns the normals inwards.
    #[must_use]
    pub fn new(center: Vec3A, radius: f32, axes: Frame, flip_normals: bool) -> Self {
        Self { center, radius, axes, side: if flip_normals { -1.0 } else { 1.0 } }
    }

    /// The same in one lane.
    fn one(&self) -> Spheres<f32> {
        let radius = f64::from(self.radius);
        Spheres { center: self.center.as_dvec3().into(), radius, side: self.side }
    }
}

impl Analytic for Sphere {
    /// The first parameter is 0 where the ray's line enters the sphere, 1 where it leaves.
    fn intersect(&self, ray: &Ray) -> Option<(f32, f32, f32)> {
        let roots = self.one().roots(ray.origin.as_dvec3().into(), ray.direction.into());
        if !roots.exist {
            return None;
        }
        let [near, far] = [roots.near, roots.far].map(|t| t as f32);
        let within = |t: f32| t >= ray.t_min && t <= ray.t_max;
        let hit = [(near, 0.0, 0.0), (far, 1.0, 0.0)];
        hit.into_iter().find(|&(t, ..)| within(t))
    }

    fn bounds(&self) -> Aabb {
        // One more ulp of the sum on each side: the box must hold the sphere after rounding.
        let reach = Vec3A::splat(self.radius) + (self.center.abs() + self.radius) * f32::EPSILON;
        Aabb { min: (self.center - reach).into(), max: (self.center + reach).into() }
    }

    /// By Pythagoras, from the point of the line that is nearest to the centre.
    fn crossings(&self, origin: DVec3, direction: DVec3) -> [Option<Crossing>; 2] {
        let to_center = self.center.as_dvec3() - origin;
        let length = direction.length();
        let unit = direction / length;
        let beside = to_center.cross(unit).length();
        let radius = f64::from(self.radius);
        let clearance = radius - beside;
        if clearance.is_nan() || clearance < 0.0 {
            return [None; 2];
        }
        let half_chord = (clearance * (radius + beside)).sqrt();
        [-half_chord, half_chord]
            .map(|h| Some(Crossing { t: (to_center.dot(unit) + h) / length, clearance }))
    }

    fn distance(&self, point: DVec3) -> f64 {
        (point.distance(self.center.as_dvec3()) - f64::from(self.radius)).abs()
    }
}

impl Shape for Sphere {
    fn geometry(&self) -> Geometry<'_> {
        Geometry::Analytic(self)
    }

    fn bounds(&self) -> Aabb {
        Analytic::bounds(self)
    }

    fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        Interaction::new(&Arrivals::one(self, ray, hit), |_| *ray).lane(0)
    }

    fn put(&self, _primitive: u32, _time: f32, lane: &mut PrimitiveLane<'_>) {
        lane.put_sphere(self.center, self.radius, self.side);
    }

    fn uv(&self, ray: &Ray, hit: &Hit) -> Vec2 {
        let local = Vec3A::from(
            self.axes.to_local((self.surface(ray, hit).geometric_normal * self.side).into()),
        );
        let turn = local.y.atan2(local.x) / std::f32::consts::TAU;
        Vec2::new(
            if turn < 0.0 { turn + 1.0 } else { turn },
            local.z.clamp(-1.0, 1.0).acos() / std::f32::consts::PI,
        )
    }

    fn tangents(&self, ray: &Ray, hit: &Hit) -> [Vec3A; 2] {
        let local = Vec3A::from(
            self.axes.to_local((self.surface(ray, hit).geometric_normal * self.side).into()),
        );
        let across = local.truncate().length();
        // At a pole, the meridian that lies ahead.
        let azimuth = if across > 0.0 { local.truncate() / across } else { Vec2::X };
        let dp_du = Vec3A::new(-local.y, local.x, 0.0) * (2.0 * std::f32::consts::PI);
        let dp_dv = (azimuth * local.z).extend(-across) * std::f32::consts::PI;
        [dp_du, dp_dv.into()].map(|d| Vec3A::from(self.axes.to_world(d.into())) * self.radius)
    }

    fn primitive_count(&self) -> usize {
        1
    }

    fn primitive_area(&self, _primitive: usize) -> f64 {
        4.0 * PI * f64::from(self.radius).powi(2)
    }

    fn sample_primitive(&self, _primitive: usize, from: DVec3, u: Vec2) -> Option<ShapeSample> {
        self.one().sample(from.into(), u.into()).lane(0)
    }

    fn primitive_pdf(&self, _primitive: usize, from: DVec3, point: &SurfacePoint) -> f64 {
        let normal = point.geometric_normal.into();
        self.one().pdf(from.into(), point.position.into(), normal)
    }

    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
}

/// A sphere in each lane, as paths meet and sample it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spheres<R: Real> {
    pub(super) center: real::Vec3<R::Double>,
    pub(super) radius: R::Double,
    /// −1 where the normals point inwards, else 1.
    pub(super) side: R,
}

/// Distances at which lines meet spheres.
#[derive(Clone, Copy, Debug)]
struct Roots<R: Real> {
    /// Where they meet at all.
    exist: R::Mask,
    near: R::Double,
    far: R::Double,
}

/// The cones of directions in which spheres are seen.
#[derive(Clone, Copy, Debug)]
struct Cones<R: Real> {
    /// Not from inside and not from the surface, on whichever side of it f64 has put the point.
    exist: R::Mask,
    axis: real::Vec3<R>,
    /// In f64: that of a sphere at 1e20 times its radius is no f32.
    one_minus_cos: R::Double,
    /// From the centre.
    distance: R::Double,
}

impl<R: Real> Cones<R> {
    /// Density of directions uniform in the cone, in sr⁻¹.
    #[inline(always)]
    fn pdf(&self) -> R::Double {
        (self.one_minus_cos * (2.0 * PI)).recip()
    }
}

/// How far a point of the surface may lie from it, over the largest coordinate: a few roundings of f64.
const ON_SURFACE: f64 = 16.0 * f64::EPSILON;

impl<R: Real> Spheres<R> {
    /// The surface where the rays from the exact `origin` meet it, at the far side where they `leave` it: position and
    /// normal. The distance again, in f64 and from the exact start: rounded to f32, as `t`, it moves the point along the ray
    /// by up to 6e-8 t, which for a distant sphere may be more than its radius.
    #[inline(always)]
    pub(super) fn meet(
        &self,
        origin: real::Vec3<R::Double>,
        direction: real::Vec3<R>,
        leave: R::Mask,
        t: R,
    ) -> (real::Vec3<R::Double>, real::Vec3<R>) {
        let roots = self.roots(origin, direction);
        let exact = R::Double::select(leave, roots.far, roots.near);
        let t = R::Double::select(roots.exist, exact, t.widen());
        self.surface_at(origin + direction.widen() * t - self.center)
    }

    /// The surface in a direction from the centre, of any length: position and normal.
    #[inline(always)]
    fn surface_at(&self, outward: real::Vec3<R::Double>) -> (real::Vec3<R::Double>, real::Vec3<R>) {
        let outward = outward.normalize();
        (self.center + outward * self.radius, outward.narrow() * self.side)
    }

    /// Distances at which whole lines meet the spheres.
    ///
    /// Solves the quadratic in f64: with f32 the discriminant cancels for a sphere that is small
    /// against its distance (Haines et al., "Precision Improvements for Ray/Sphere Intersection", 2019).
    #[inline(always)]
    fn roots(&self, origin: real::Vec3<R::Double>, direction: real::Vec3<R>) -> Roots<R> {
        let (origin, direction) = (origin - self.center, direction.widen());
        let a = direction.length_squared();
        let b = -origin.dot(direction);
        let closest = origin + direction * (b / a);
        let squared = self.radius * self.radius;
        let discriminant = squared - closest.length_squared();
        let root = (a * discriminant).sqrt();
        // The root without cancellation first, the other from the product of both.
        let q = b + R::Double::select(b.lt(0.0), -root, root);
        let c = origin.length_squared() - squared;
        let (first, second) = (c / q, q / a);
        let swapped = first.gt(second);
        Roots {
            exist: discriminant.ge(0.0),
            near: R::Double::select(swapped, second, first),
            far: R::Double::select(swapped, first, second),
        }
    }

    /// A point of each: from outside, uniform in the cone that the sphere fills (Shirley, Wang and Zimmerman 1996,
    /// section 3.2); from inside, uniform by area.
    #[inline(always)]
    pub(super) fn sample(&self, from: real::Vec3<R::Double>, u: real::Vec2<R>) -> ShapeSamples<R> {
        let cones = self.cones_from(from);
        let outside = self.sample_cone(&cones, u);
        if cones.exist.all() {
            return outside;
        }
        ShapeSamples::selected(cones.exist, outside, self.sample_area(from, u))
    }

    #[inline(always)]
    fn sample_cone(&self, cones: &Cones<R>, u: real::Vec2<R>) -> ShapeSamples<R> {
        let frame = Frame::from_normal(cones.axis);
        let local = warp::square_to_uniform_cone(u, cones.one_minus_cos.narrow());
        let direction = frame.to_world(local).normalize();
        // The near root along that direction, and the point it leads to, relative to the centre and in
        // the cone's frame. Not by way of `direction`: rounding it to f32 moves the end by more than
        // the radius of a distant sphere.
        let (x, y) = (local.x.widen(), local.y.widen());
        let sin_squared = x * x + y * y;
        let cos = not_negative(-sin_squared + 1.0).sqrt();
        let (d, r) = (cones.distance, self.radius);
        let half_chord = not_negative(r * r - d * d * sin_squared).sqrt();
        let t = d * cos - half_chord;
        let from_center = real::Vec3::new(t * x, t * y, -(d * sin_squared) - cos * half_chord);
        let outward = frame.to_world(from_center.normalize().narrow());
        let (position, normal) = self.surface_at(outward.widen());
        ShapeSamples {
            exists: cones.exist,
            position,
            parameters: real::Vec2::splat(u.x.token(), real::Vec2::default()),
            normal,
            shading_normal: normal,
            direction,
            pdf: cones.pdf(),
        }
    }

    #[inline(always)]
    fn sample_area(&self, from: real::Vec3<R::Double>, u: real::Vec2<R>) -> ShapeSamples<R> {
        let token = u.x.token();
        let (position, normal) = self.surface_at(warp::square_to_uniform_sphere(u).widen());
        let to = Toward::new(self.area(), from, position, normal);
        let leaves = (normal.dot((position - from).narrow()) * self.side).gt(0.0);
        let leaves = R::select(leaves, 1.0, R::splat(token, 0.0));
        ShapeSamples {
            exists: to.exists,
            position,
            parameters: real::Vec2::new(leaves, R::splat(token, 0.0)),
            normal,
            shading_normal: normal,
            direction: to.direction,
            pdf: to.pdf,
        }
    }

    /// Density with which [`Spheres::sample`] chooses the direction from `from` to a point of the surface.
    #[inline(always)]
    pub(super) fn pdf(
        &self,
        from: real::Vec3<R::Double>,
        position: real::Vec3<R::Double>,
        normal: real::Vec3<R>,
    ) -> R::Double {
        let cones = self.cones_from(from);
        let outside = cones.pdf();
        if cones.exist.all() {
            return outside;
        }
        let inside = area_pdf_toward::<R>(self.area(), from, position, normal);
        R::Double::select(cones.exist, outside, inside)
    }

    #[inline(always)]
    fn area(&self) -> R::Double {
        self.radius * self.radius * (4.0 * PI)
    }

    #[inline(always)]
    fn cones_from(&self, from: real::Vec3<R::Double>) -> Cones<R> {
        let to_center = self.center - from;
        let distance = to_center.length();
        // What f64 makes of a point of the surface.
        let center = self.center.abs();
        let larger = |a: R::Double, b: R::Double| R::Double::select(a.gt(b), a, b);
        let scale = larger(larger(center.x, center.y), center.z) + self.radius;
        let reach = self.radius + scale * ON_SURFACE;
        let sin_squared = {
            let sin = self.radius / distance;
            sin * sin
        };
        // 1 - cos = sin² / (1 + cos): the subtraction would lose narrow cones.
        let cos = (-sin_squared + 1.0).sqrt();
        Cones {
            exist: distance.gt(reach),
            axis: (to_center / distance).narrow(),
            one_minus_cos: sin_squared / (cos + 1.0),
            distance,
        }
    }
}

/// What rounding has put below 0, at 0.
#[inline(always)]
fn not_negative<D: Double>(number: D) -> D {
    D::select(number.gt(0.0), number, 0.0)
}
