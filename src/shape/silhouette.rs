//! Triangles that are met next to their edges: which of those that touch there a ray meets.

use glam::{DVec3, Vec3A};

use super::primitive_lanes::PrimitiveLanes;
use super::triangle::Triangle;
use super::{NEAR_EDGE, Shape, SurfacePoint, rounding_of};
use crate::math::UNIT_ROUNDOFF as U;
use crate::math::vector::Vec2;
use crate::ray::{Hit, Ray, Side};

/// The surface of a triangle that is met close to its edge.
#[cold]
pub(super) fn near_edge(shape: &dyn Shape, ray: &Ray, hit: &Hit) -> SurfacePoint {
    let (lanes, triangle) = put(shape, hit.primitive, ray.time);
    let (origin, direction) = (ray.exact_origin().into(), ray.direction.into());
    let met = triangle.meet_near_edge(origin, direction, Vec2::new(hit.u, hit.v));
    // The hit still names this triangle, and has its parameters.
    let parameters = Vec2::new(hit.u, hit.v).into();
    if met.is_beyond
        && let Some(surface) = neighbour(shape, ray, hit)
    {
        return SurfacePoint { parameters, ..surface };
    }
    let surface = lanes.surface(&triangle, met.point);
    let surface = SurfacePoint { near_edge: Some(met.near_edge), ..surface };
    if is_as_expected(ray, &surface) {
        return surface;
    }
    let before = before(shape, ray, hit.primitive, surface.position);
    before.map_or(surface, |before| SurfacePoint { parameters, ..before })
}

/// Whether a ray sees the side of a surface that it should, coming from where it does: the back, if it has left the back of
/// another.
fn is_as_expected(ray: &Ray, surface: &SurfacePoint) -> bool {
    let is_back = surface.geometric_normal.dot(ray.direction) > 0.0;
    is_back == ray.start.is_some_and(|start| start.side == Side::Back)
}

/// A triangle of a shape at a moment.
fn put(shape: &dyn Shape, primitive: u32, time: f32) -> (PrimitiveLanes, Triangle) {
    let mut lanes = PrimitiveLanes::NONE;
    shape.put(primitive, time, &mut lanes.lane(0));
    let triangle = lanes.triangles(());
    (lanes, triangle)
}

/// The surface of another triangle that `ray` truly meets near `hit`, which its own triangle is passed by: rather one that it
/// sees as it should, and of those the nearest to where the hit was found.
fn neighbour(shape: &dyn Shape, ray: &Ray, hit: &Hit) -> Option<SurfacePoint> {
    let met = shape.touching(hit.primitive).into_iter().filter_map(|other| {
        let (lanes, triangle) = put(shape, other, ray.time);
        let (point, near_edge) = triangle.meet_inside(ray, hit.t)?;
        Some(SurfacePoint { near_edge, ..lanes.surface(&triangle, point) })
    });
    let rank = |surface: &SurfacePoint| {
        let to = surface.position - ray.origin.as_dvec3();
        let off = (to.dot(ray.direction.as_dvec3()) - f64::from(hit.t)).abs();
        (!is_as_expected(ray, surface), off)
    };
    let order = |a: &(bool, f64), b: &(bool, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
    met.min_by(|a, b| order(&rank(a), &rank(b)))
}

/// The surface before a triangle that no ray can meet first next to `position`, if it is one: where two triangles that
/// share an edge lie on the same side of it, as the ray sees them, one hides the other, and rays beyond the edge meet neither.
/// But distances there differ by less than their rounding, and an engine may find the hidden one. Of those that hide
/// others this is the first that the ray sees as it should.
fn before(shape: &dyn Shape, ray: &Ray, primitive: u32, position: DVec3) -> Option<SurfacePoint> {
    /// More than that are hardly stacked around one corner.
    const MOST: usize = 16;
    let (origin, direction) = (ray.exact_origin().into(), ray.direction.into());
    let mut last = primitive;
    for _ in 0..MOST {
        last = hiding(shape, ray, last, position)?;
        let (lanes, triangle) = put(shape, last, ray.time);
        let met = triangle.meet_near_edge(origin, direction, triangle.weights_at(position.into()));
        let near_edge = Some(met.near_edge);
        let surface = SurfacePoint { near_edge, ..lanes.surface(&triangle, met.point) };
        if is_as_expected(ray, &surface) {
            return Some(surface);
        }
    }
    None
}

/// A triangle that hides this one at an edge that the ray passes close to `position`.
fn hiding(shape: &dyn Shape, ray: &Ray, primitive: u32, position: DVec3) -> Option<u32> {
    let direction = ray.direction.as_dvec3();
    let corners_of = |primitive| put(shape, primitive, ray.time).0.corners();
    let corners = corners_of(primitive);
    let passes = |&[p, q, _]: &[Vec3A; 3]| {
        let (p, along) = (p.as_dvec3(), (q - p).as_dvec3());
        let apart = direction.cross(along);
        // Between the ray and the edge, of which those that are parallel are not near any other either.
        let distance = apart.normalize_or_zero().dot(ray.exact_origin() - p).abs();
        distance <= NEAR_EDGE * (rounding_of(position) + f64::from(U) * along.length())
    };
    let edges = (0..3).map(|i| [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]]);
    let edges: Vec<_> = edges.filter(passes).collect();
    if edges.is_empty() {
        return None;
    }
    shape.touching(primitive).into_iter().find(|&other| {
        let others = corners_of(other);
        edges.iter().any(|&[p, q, third]| {
            if !(others.contains(&p) && others.contains(&q)) {
                return false;
            }
            let Some(&apex) = others.iter().find(|&&corner| corner != p && corner != q) else {
                return false;
            };
            let [along, to_third, to_apex] = [q, third, apex].map(|c| c.as_dvec3() - p.as_dvec3());
            let normal = along.cross(to_third);
            let facing = normal.dot(direction);
            let same_side = facing * along.cross(to_apex).dot(direction) > 0.0;
            same_side && normal.dot(to_apex) * facing < 0.0
        })
    })
}
