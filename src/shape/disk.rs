//! Flat disks.

use glam::{Affine3A, DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3A};

use super::sample::area_sample_toward;
use super::{
    Analytic, Crossing, Geometry, NEAR_EDGE, NearEdge, OFF_EDGE, Shape, ShapeSample, SurfacePoint,
    rounding_of,
};
use crate::math::{Aabb, Cone, warp};
use crate::ray::{Hit, Ray};

/// The image of the unit disk in the xy plane under an affine map: an ellipse in general.
#[derive(Clone, Copy, Debug)]
pub struct Disk {
    to_world: Affine3A,
    to_local: DAffine3,
    normal: Vec3A,
    area: f64,
    /// The smaller radius of the ellipse.
    narrow: f64,
}

impl Disk {
    /// The unit disk (z = 0, normal +z) under `to_world`; `flip_normals` turns the normal.
    /// `None` if the map is singular or not finite, as it is or rounded to f32.
    #[must_use]
    pub fn new(to_world: DAffine3, flip_normals: bool) -> Option<Self> {
        // Rounded first: both directions then are of one disk, wherever it lies.
        let to_world = to_world.as_affine3a();
        let exact = to_world.as_daffine3();
        let linear: DMat3 = exact.matrix3;
        let determinant = linear.determinant();
        if !exact.is_finite() || determinant == 0.0 || !determinant.is_finite() {
            return None;
        }
        // Normals go with the inverse transpose, whose direction is the cross product of the axes,
        // on the side that +z is mapped to.
        let across = linear.x_axis.cross(linear.y_axis);
        let side = determinant.signum() * if flip_normals { -1.0 } else { 1.0 };
        Some(Self {
            to_world,
            to_local: exact.inverse(),
            normal: (across.normalize() * side).as_vec3a(),
            area: std::f64::consts::PI * across.length(),
            narrow: Plane::of(&exact).least_stretch(),
        })
    }

    fn plane(&self) -> Plane {
        Plane::of(&self.to_local.inverse())
    }

    /// The surface at a point of the unit disk.
    fn surface_at(&self, p: DVec2) -> SurfacePoint {
        let m = self.to_world.matrix3;
        let (x, y, center) =
            (m.x_axis.as_dvec3(), m.y_axis.as_dvec3(), self.to_world.translation.as_dvec3());
        SurfacePoint {
            position: center + (x * p.x + y * p.y),
            parameters: p.as_vec2(),
            geometric_normal: self.normal,
            shading_normal: self.normal,
            near_edge: None,
            time: 0.0,
        }
    }

    /// Where a line crosses the disk's plane: how far along, and where on the disk.
    fn cross(&self, origin: DVec3, direction: DVec3) -> (f64, DVec2) {
        let origin = self.to_local.transform_point3(origin);
        let direction = self.to_local.transform_vector3(direction);
        // A line in the plane of the disk has direction.z == 0 and t = ±inf or NaN.
        let t = -origin.z / direction.z;
        (t, (origin + direction * t).truncate())
    }
}

impl Analytic for Disk {
    fn intersect(&self, ray: &Ray) -> Option<(f32, f32, f32)> {
        let (t, p) = self.cross(ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let t = t as f32;
        let inside = p.length_squared() <= 1.0;
        (t >= ray.t_min && t <= ray.t_max && t.is_finite() && inside)
            .then_some((t, p.x as f32, p.y as f32))
    }

    fn bounds(&self) -> Aabb {
        let (x, y) = (self.to_world.matrix3.x_axis, self.to_world.matrix3.y_axis);
        let center = self.to_world.translation;
        // The farthest point of the ellipse along an axis: the length of that row of (x y), with
        // a margin for the rounding of these sums.
        let reach = Vec3A::from((x * x + y * y).to_array().map(f32::sqrt))
            + (center.abs() + (x.abs() + y.abs())) * (4.0 * f32::EPSILON);
        Aabb { min: (center - reach).into(), max: (center + reach).into() }
    }

    /// In the world's plane of the disk, where [`Analytic::intersect`] goes to the disk's own space.
    fn crossings(&self, origin: DVec3, direction: DVec3) -> [Option<Crossing>; 2] {
        let plane = self.plane();
        let normal = plane.x.cross(plane.y);
        let facing = direction.dot(normal);
        let t = (plane.center - origin).dot(normal) / facing;
        let radius = plane.coordinates(origin + direction * t).length();
        let cosine = facing.abs() / (direction.length() * normal.length());
        let crossing = Crossing { t, clearance: (1.0 - radius) * plane.least_stretch() * cosine };
        [(t.is_finite() && radius <= 1.0).then_some(crossing), None]
    }

    /// Exact for a circle; for an ellipse, beyond its rim, at most too large by the ratio of its axes.
    fn distance(&self, point: DVec3) -> f64 {
        let plane = self.plane();
        let p = plane.coordinates(point);
        let p = p / p.length().max(1.0);
        (plane.center + plane.x * p.x + plane.y * p.y).distance(point)
    }
}

/// The disk in world space: its centre and the images of the axes.
struct Plane {
    center: DVec3,
    x: DVec3,
    y: DVec3,
}

impl Plane {
    fn of(to_world: &DAffine3) -> Self {
        let [x, y] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis];
        Self { center: to_world.translation, x, y }
    }

    /// The entries of the Gram matrix of the axes: x², xy, y².
    fn gram(&self) -> [f64; 3] {
        [self.x.length_squared(), self.x.dot(self.y), self.y.length_squared()]
    }

    /// The coordinates along the axes of the point of the plane that is nearest to `point`.
    fn coordinates(&self, point: DVec3) -> DVec2 {
        let p = point - self.center;
        let (px, py) = (p.dot(self.x), p.dot(self.y));
        let [xx, xy, yy] = self.gram();
        DVec2::new(yy * px - xy * py, xx * py - xy * px) / (xx * yy - xy * xy)
    }

    /// The smaller radius of the ellipse: the root of the smaller eigenvalue of the Gram matrix.
    fn least_stretch(&self) -> f64 {
        let [xx, xy, yy] = self.gram();
        let (mean, half_difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        // The product of both over the larger one: the difference would cancel.
        let larger = mean + half_difference.hypot(xy);
        ((xx * yy - xy * xy) / larger).sqrt()
    }
}

impl Shape for Disk {
    fn geometry(&self) -> Geometry<'_> {
        Geometry::Analytic(self)
    }

    fn bounds(&self) -> Aabb {
        Analytic::bounds(self)
    }

    fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        // Again from the exact start; as found where that passes the disk.
        let (_, p) = self.cross(ray.exact_origin(), ray.direction.as_dvec3());
        let found = Vec2::new(hit.u, hit.v).as_dvec2();
        let p = if p.length_squared() <= 1.0 { p } else { found };
        let surface = self.surface_at(p);
        // Off the rim, as for triangles; the rim is nearest where the disk is narrow.
        let rounding = rounding_of(surface.position) / self.narrow;
        if 1.0 - p.length() > NEAR_EDGE * rounding {
            return surface;
        }
        let inner = |margin: f64| self.surface_at(p.clamp_length_max(1.0 - margin.min(0.5)));
        let surface = inner(OFF_EDGE * (1.0 + rounding));
        let shifted = |distance: f64| inner(distance / self.narrow).position;
        let near_edge = NearEdge::new(surface.position, self.narrow, shifted);
        SurfacePoint { near_edge: Some(near_edge), ..surface }
    }

    /// Polar, as Mitsuba has it: u is the radius, v the angle in turns.
    fn uv(&self, _ray: &Ray, hit: &Hit) -> Vec2 {
        let turn = hit.v.atan2(hit.u) / std::f32::consts::TAU;
        Vec2::new(Vec2::new(hit.u, hit.v).length(), if turn < 0.0 { turn + 1.0 } else { turn })
    }

    fn tangents(&self, _ray: &Ray, hit: &Hit) -> [Vec3A; 2] {
        let p = Vec2::new(hit.u, hit.v);
        // In the centre there is no direction outwards.
        let outwards = p.try_normalize().unwrap_or(Vec2::ZERO);
        [outwards, p.perp() * std::f32::consts::TAU]
            .map(|d| self.to_world.transform_vector3a(d.extend(0.0).into()))
    }

    fn primitive_extent(&self, _primitive: usize) -> (Aabb, Cone) {
        (Shape::bounds(self), Cone::direction(self.normal.normalize().into()))
    }

    fn primitive_count(&self) -> usize {
        1
    }

    fn primitive_area(&self, _primitive: usize) -> f64 {
        self.area
    }

    fn sample_primitive(&self, _primitive: usize, from: DVec3, u: Vec2) -> Option<ShapeSample> {
        let p = Vec2::from(warp::square_to_uniform_disk(u.into()));
        area_sample_toward(self.area, from, self.surface_at(p.as_dvec2()))
    }

    fn bytes(&self) -> usize {
        size_of::<Self>()
    }
}
