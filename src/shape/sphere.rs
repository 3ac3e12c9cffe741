//! Spheres.

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3A};

use super::{
    Analytic, Crossing, Geometry, Shape, ShapeSample, SurfacePoint, area_pdf_toward,
    area_sample_toward,
};
use crate::math::{Aabb, Frame, warp};
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

    /// The surface in a direction from the centre, of any length.
    fn surface_at(&self, outward: DVec3) -> SurfacePoint {
        let outward = outward.normalize();
        let position = self.center.as_dvec3() + outward * f64::from(self.radius);
        let normal = outward.as_vec3a() * self.side;
        SurfacePoint {
            position,
            parameters: Vec2::ZERO,
            geometric_normal: normal,
            shading_normal: normal,
            near_edge: None,
            time: 0.0,
        }
    }
}

impl Sphere {
    /// Distances at which the whole line of `ray` meets the sphere, the smaller first.
    ///
    /// Solves the quadratic in f64: with f32 the discriminant cancels for a sphere that is small
    /// against its distance (Haines et al., "Precision Improvements for Ray/Sphere Intersection", 2019).
    fn roots(&self, ray: &Ray) -> Option<[f64; 2]> {
        self.roots_from(ray.origin.as_dvec3(), ray.direction.as_dvec3())
    }

    fn roots_from(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let origin = origin - self.center.as_dvec3();
        let radius = f64::from(self.radius);
        let a = direction.length_squared();
        let b = -origin.dot(direction);
        let closest = origin + direction * (b / a);
        let discriminant = radius * radius - closest.length_squared();
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let root = (a * discriminant).sqrt();
        // The root without cancellation first, the other from the product of both.
        let q = b + root.copysign(b);
        let c = origin.length_squared() - radius * radius;
        let (near, far) = (c / q, q / a);
        Some(if near > far { [far, near] } else { [near, far] })
    }
}

impl Analytic for Sphere {
    /// The first parameter is 0 where the ray's line enters the sphere, 1 where it leaves.
    fn intersect(&self, ray: &Ray) -> Option<(f32, f32, f32)> {
        let [near, far] = self.roots(ray)?.map(|t| t as f32);
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
        // The distance again, in f64 and from the exact start: rounded to f32 it moves the point along the ray
        // by up to 6e-8 t, which for a distant sphere may be more than its radius.
        let (origin, direction) = (ray.exact_origin(), ray.direction.as_dvec3());
        let [near, far] = self.roots_from(origin, direction).unwrap_or([f64::from(hit.t); 2]);
        let t = if hit.u < 0.5 { near } else { far };
        let outward = origin + direction * t - self.center.as_dvec3();
        SurfacePoint { parameters: Vec2::new(hit.u, hit.v), ..self.surface_at(outward) }
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

    /// From outside, uniform in the cone that the sphere fills (Shirley, Wang and Zimmerman 1996,
    /// section 3.2); from inside, uniform by area.
    fn sample_primitive(&self, primitive: usize, from: DVec3, u: Vec2) -> Option<ShapeSample> {
        let Some(cone) = self.cone_from(from) else {
            let point =
                self.surface_at(Vec3A::from(warp::square_to_uniform_sphere(u.into())).as_dvec3());
            let along = (point.position - from).as_vec3a();
            let leaves = point.geometric_normal.dot(along) * self.side > 0.0;
            let parameters = Vec2::new(f32::from(u8::from(leaves)), 0.0);
            let point = SurfacePoint { parameters, ..point };
            return area_sample_toward(self.primitive_area(primitive), from, point);
        };
        let frame = Frame::from_normal(cone.axis.into());
        let local = Vec3A::from(warp::square_to_uniform_cone(u.into(), cone.one_minus_cos as f32));
        let direction = Vec3A::from(frame.to_world(local.into())).normalize();
        // The near root along that direction, and the point it leads to, relative to the centre and in
        // the cone's frame. Not by way of `direction`: rounding it to f32 moves the end by more than
        // the radius of a distant sphere.
        let sin_squared = f64::from(local.x).powi(2) + f64::from(local.y).powi(2);
        let cos = (1.0 - sin_squared).max(0.0).sqrt();
        let (d, r) = (cone.distance, f64::from(self.radius));
        let half_chord = (r * r - d * d * sin_squared).max(0.0).sqrt();
        let t = d * cos - half_chord;
        let from_center = DVec3::new(
            t * f64::from(local.x),
            t * f64::from(local.y),
            -d * sin_squared - cos * half_chord,
        );
        let outward = Vec3A::from(frame.to_world(from_center.normalize().as_vec3a().into()));
        let point = self.surface_at(outward.as_dvec3());
        Some(ShapeSample { point, direction, pdf: cone.pdf() })
    }

    fn primitive_pdf(&self, primitive: usize, from: DVec3, point: &SurfacePoint) -> f64 {
        match self.cone_from(from) {
            Some(cone) => cone.pdf(),
            None => area_pdf_toward(self.primitive_area(primitive), from, point),
        }
    }

    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
}

/// How far a point of the surface may lie from it, over the largest coordinate: a few roundings of f64.
const ON_SURFACE: f64 = 16.0 * f64::EPSILON;

/// The cone of directions in which a sphere is seen.
struct Cone {
    axis: Vec3A,
    /// In f64: that of a sphere at 1e20 times its radius is no f32.
    one_minus_cos: f64,
    distance: f64,
}

impl Cone {
    /// Density of directions uniform in the cone, in sr⁻¹.
    fn pdf(&self) -> f64 {
        0.5 / (PI * self.one_minus_cos)
    }
}

impl Sphere {
    /// `None` from inside and from the surface, on whichever side of it f64 has put `from`.
    fn cone_from(&self, from: DVec3) -> Option<Cone> {
        let to_center = self.center.as_dvec3() - from;
        let distance = to_center.length();
        // What f64 makes of a point of the surface.
        let scale = self.center.abs().max_element() + self.radius;
        let reach = f64::from(self.radius) + f64::from(scale) * ON_SURFACE;
        let sin = f64::from(self.radius) / distance;
        // 1 - cos = sin² / (1 + cos): the subtraction would lose narrow cones.
        let one_minus_cos = sin * sin / (1.0 + (1.0 - sin * sin).sqrt());
        (distance > reach).then(|| Cone {
            axis: (to_center / distance).as_vec3a(),
            one_minus_cos,
            distance,
        })
    }
}
