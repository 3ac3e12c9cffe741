//! Cylinders without caps.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2, Vec3A};

use super::sample::area_sample_toward;
use super::{
    Analytic, Crossing, Geometry, NEAR_EDGE, NearEdge, OFF_EDGE, Shape, ShapeSample, SurfacePoint,
    rounding_of,
};
use crate::math::Aabb;
use crate::ray::{Hit, Ray};

/// The side of a circular cylinder in world space, open at both ends. All that an f32 rounds is computed in
/// f64, so that only positions and rays are rounded, once each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Middle of the end where v is 0.
    base: DVec3,
    /// Unit vectors: towards u = 0, towards u = 1/4, and along the axis.
    axes: [DVec3; 3],
    radius: f64,
    length: f64,
    /// -1 if the normals point inwards, else 1.
    side: f64,
}

impl Cylinder {
    /// The image of the cylinder x² + y² = 1, 0 ≤ z ≤ 1 under the map that sends the origin to `base` and the unit
    /// vectors to `axes`, which are orthogonal and of which the first two are of one length.
    /// `flip_normals` turns the normals inwards. `None` if a length is 0 or not finite as an f32.
    #[must_use]
    pub fn new(base: DVec3, axes: [DVec3; 3], flip_normals: bool) -> Option<Self> {
        let [radius, length] = [axes[0], axes[2]].map(|axis| f64::from(axis.length() as f32));
        // What the axes lack to be orthogonal by rounding is taken from the first two.
        let z = axes[2].try_normalize()?;
        let x = axes[0].try_normalize()?.reject_from_normalized(z).try_normalize()?;
        let y = axes[1].try_normalize()?.reject_from_normalized(z);
        let y = y.reject_from_normalized(x).try_normalize()?;
        let sizes = [radius, length].into_iter().all(|v| v > 0.0 && v.is_finite());
        let base = base.as_vec3a().as_dvec3();
        let side = if flip_normals { -1.0 } else { 1.0 };
        (sizes && base.is_finite()).then_some(Self { base, axes: [x, y, z], radius, length, side })
    }

    /// Coordinates along the axes, in scene units.
    fn to_local(self, v: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| v.dot(axis)))
    }

    fn to_world(self, v: DVec3) -> DVec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    /// Where a line meets the cylinder, however long it is: distances, the smaller first, and points.
    fn roots(&self, origin: DVec3, direction: DVec3) -> Option<[(f64, DVec3); 2]> {
        let o = self.to_local(origin - self.base);
        let d = self.to_local(direction);
        let (across, along) = (o.truncate(), d.truncate());
        let a = along.length_squared();
        let b = -across.dot(along);
        let closest = across + along * (b / a);
        let discriminant = self.radius * self.radius - closest.length_squared();
        // NaN for a ray along the axis.
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let root = (a * discriminant).sqrt();
        // The root without cancellation first, the other from the product of both.
        let q = b + root.copysign(b);
        let (near, far) = ((across.length_squared() - self.radius * self.radius) / q, q / a);
        let sorted = if near > far { [far, near] } else { [near, far] };
        Some(sorted.map(|t| (t, o + d * t)))
    }

    /// The surface at an angle, given by any vector of that direction, and a height.
    fn surface_at(&self, towards: DVec2, z: f64) -> SurfacePoint {
        let towards = towards.try_normalize().unwrap_or(DVec2::X);
        let outward = self.to_world(towards.extend(0.0));
        let on_axis = self.base + self.axes[2] * z.clamp(0.0, self.length);
        let position = on_axis + outward * self.radius;
        let normal = (outward * self.side).as_vec3a();
        SurfacePoint {
            position,
            parameters: Vec2::ZERO,
            geometric_normal: normal,
            shading_normal: normal,
            near_edge: None,
            time: 0.0,
        }
    }

    /// The point of a hit: the distance again, in f64 and from the exact start, as for spheres.
    fn local(&self, ray: &Ray, hit: &Hit) -> DVec3 {
        match self.roots(ray.exact_origin(), ray.direction.as_dvec3()) {
            Some([near, far]) => {
                let (_, p) = if hit.u < 0.5 { near } else { far };
                p
            }
            None => {
                let p = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(hit.t);
                self.to_local(p - self.base)
            }
        }
    }
}

impl Analytic for Cylinder {
    /// The first parameter is 0 where the ray's line enters the cylinder, 1 where it leaves.
    fn intersect(&self, ray: &Ray) -> Option<(f32, f32, f32)> {
        let [near, far] = self.roots(ray.origin.as_dvec3(), ray.direction.as_dvec3())?;
        let within = |(t, p): (f64, DVec3)| {
            let t = t as f32;
            t >= ray.t_min && t <= ray.t_max && t.is_finite() && (0.0..=self.length).contains(&p.z)
        };
        let hit = [(near, 0.0), (far, 1.0)].into_iter().find(|&(root, _)| within(root));
        hit.map(|((t, _), which)| (t as f32, which, 0.0))
    }

    fn bounds(&self) -> Aabb {
        let axis = self.axes[2];
        let top = self.base + axis * self.length;
        // The farthest point of a circle along a coordinate.
        let reach = (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt) * self.radius;
        let (low, high) = (self.base.min(top) - reach, self.base.max(top) + reach);
        // The box must hold the cylinder after rounding.
        let margin = low.abs().max(high.abs()) * f64::from(f32::EPSILON);
        Aabb { min: (low - margin).as_vec3(), max: (high + margin).as_vec3() }
    }

    /// From the points of the line and of the axis that are nearest to each other.
    fn crossings(&self, origin: DVec3, direction: DVec3) -> [Option<Crossing>; 2] {
        let length = direction.length();
        let (unit, axis) = (direction / length, self.axes[2]);
        let to_base = self.base - origin;
        let across = unit.cross(axis);
        let sine = across.length();
        let beside = (to_base.dot(across) / sine).abs();
        // NaN for a line along the axis.
        if beside.is_nan() || beside > self.radius {
            return [None; 2];
        }
        let nearest = to_base.cross(axis).dot(across) / (sine * sine);
        let half_chord = ((self.radius - beside) * (self.radius + beside)).sqrt() / sine;
        [-half_chord, half_chord].map(|h| {
            let z = (unit * (nearest + h) - to_base).dot(axis);
            if !(0.0..=self.length).contains(&z) {
                return None;
            }
            // Moved sideways by up to half of what is left to the tangent, the line meets the cylinder at
            // a height that changes by 1/sine of that, and with the half chord's length.
            let margin = 0.5 * (self.radius - beside);
            let rim = self.radius - margin;
            let slope = rim / ((self.radius - rim) * (self.radius + rim)).sqrt();
            let ends = z.min(self.length - z) * sine / (1.0 + slope * unit.dot(axis).abs());
            // The slope is infinite for a tangent, where nothing is left.
            let clearance = if margin > 0.0 { margin.min(ends) } else { 0.0 };
            Some(Crossing { t: (nearest + h) / length, clearance })
        })
    }

    fn distance(&self, point: DVec3) -> f64 {
        let p = self.to_local(point - self.base);
        let beyond = p.z - p.z.clamp(0.0, self.length);
        (p.truncate().length() - self.radius).hypot(beyond)
    }
}

impl Shape for Cylinder {
    fn geometry(&self) -> Geometry<'_> {
        Geometry::Analytic(self)
    }

    fn bounds(&self) -> Aabb {
        Analytic::bounds(self)
    }

    fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let p = self.local(ray, hit);
        let parameters = Vec2::new(hit.u, hit.v);
        let surface = SurfacePoint { parameters, ..self.surface_at(p.truncate(), p.z) };
        // Off the ends, as triangles' points are off their edges.
        let rounding = rounding_of(surface.position);
        if p.z.min(self.length - p.z) > NEAR_EDGE * rounding {
            return surface;
        }
        let inner = |margin: f64| {
            let off = margin.min(0.5 * self.length);
            self.surface_at(p.truncate(), p.z.clamp(off, self.length - off))
        };
        let size = surface.position.abs().element_sum() + self.length;
        let surface = inner(OFF_EDGE * size);
        let shifted = |distance: f64| inner(distance).position;
        let near_edge = NearEdge::new(surface.position, self.length.min(self.radius), shifted);
        SurfacePoint { parameters, near_edge: Some(near_edge), ..surface }
    }

    /// u is the angle in turns, v the height as a fraction of the length.
    fn uv(&self, ray: &Ray, hit: &Hit) -> Vec2 {
        let p = self.local(ray, hit);
        let turn = (p.y.atan2(p.x) / TAU) as f32;
        let height = (p.z / self.length).clamp(0.0, 1.0) as f32;
        Vec2::new(if turn < 0.0 { turn + 1.0 } else { turn }, height)
    }

    fn tangents(&self, ray: &Ray, hit: &Hit) -> [Vec3A; 2] {
        let towards = self.local(ray, hit).truncate().normalize_or(DVec2::X);
        let du = towards.perp() * (TAU * self.radius);
        [du.extend(0.0), DVec3::Z * self.length].map(|d| self.to_world(d).as_vec3a())
    }

    fn primitive_count(&self) -> usize {
        1
    }

    fn primitive_area(&self, _primitive: usize) -> f64 {
        TAU * self.radius * self.length
    }

    /// Uniform by area.
    fn sample_primitive(&self, primitive: usize, from: DVec3, u: Vec2) -> Option<ShapeSample> {
        let angle = TAU * f64::from(u.x);
        let point = self.surface_at(DVec2::from_angle(angle), f64::from(u.y) * self.length);
        let outward = point.geometric_normal * self.side as f32;
        let leaves = outward.dot((point.position - from).as_vec3a()) > 0.0;
        let parameters = Vec2::new(f32::from(u8::from(leaves)), 0.0);
        let point = SurfacePoint { parameters, ..point };
        area_sample_toward(self.primitive_area(primitive), from, point)
    }

    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
}
