//! Shapes: their geometry, sampling by area or solid angle, and the surface at a hit with the rays that
//! leave it.

use std::fmt::Debug;

use glam::{DVec3, Vec2, Vec3, Vec3A};

use crate::math::{Aabb, Cone, UNIT_ROUNDOFF as U, type_word};
use crate::ray::{Hit, Inward, Ray, RayEnd};

pub mod cylinder;
pub mod deforming;
pub mod disk;
pub mod instance;
pub mod mesh;
pub mod primitives;
pub mod sphere;
mod triangle;

pub use cylinder::Cylinder;
pub use deforming::DeformingMesh;
pub use disk::Disk;
pub use instance::{Group, Instance};
pub use mesh::TriangleMesh;
pub use sphere::Sphere;

/// What an engine has to intersect.
#[derive(Clone, Copy, Debug)]
pub enum Geometry<'a> {
    /// Triangles, which each engine tests with its own code.
    Triangles {
        /// Vertices in world space; 16 bytes each, so that Embree may read the last one whole.
        positions: &'a [Vec3A],
        /// Three vertex indices per triangle, all below `positions.len()`.
        triangles: &'a [[u32; 3]],
    },
    /// Triangles that are elsewhere at another moment.
    Deforming(&'a DeformingMesh),
    /// A single primitive that is intersected by one piece of Rust code in every engine.
    Analytic(&'a dyn Analytic),
    /// Other shapes, under a map.
    Instance(&'a Instance),
}

impl Geometry<'_> {
    /// The corners of a triangle at a moment within the shutter; `None` for what is not made of triangles.
    #[must_use]
    pub fn corners(&self, primitive: u32, time: f32) -> Option<[Vec3A; 3]> {
        match self {
            Self::Triangles { positions, triangles } => {
                Some(triangles[primitive as usize].map(|i| positions[i as usize]))
            }
            Self::Deforming(mesh) => Some(mesh.corners(primitive as usize, time)),
            Self::Analytic(_) | Self::Instance(_) => None,
        }
    }
}

/// A primitive with an intersection test of its own.
pub trait Analytic: Debug + Send + Sync {
    /// The nearest hit within the ray's segment: distance and surface parameters `(t, u, v)`.
    fn intersect(&self, ray: &Ray) -> Option<(f32, f32, f32)>;
    /// A box around the primitive, world space.
    fn bounds(&self) -> Aabb;
    /// Where the whole line through `origin` along `direction` crosses the primitive, in f64: what
    /// [`Analytic::intersect`] is judged by, so computed in another way.
    fn crossings(&self, origin: DVec3, direction: DVec3) -> [Option<Crossing>; 2];
    /// Distance of a point from the primitive, in scene units.
    fn distance(&self, point: DVec3) -> f64;
}

/// A crossing of a line with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Distance along the line, in units of its direction.
    pub t: f64,
    /// How far the line may be moved sideways, in scene units, so that it surely still crosses there.
    pub clearance: f64,
}

/// A surface that can be hit, shaded and, for an emitter, sampled.
pub trait Shape: Debug + Send + Sync {
    /// What an engine has to intersect.
    fn geometry(&self) -> Geometry<'_>;

    /// A box around the shape, world space.
    fn bounds(&self) -> Aabb;

    /// The surface at `hit`, which an engine reported for `ray`.
    fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint;

    /// Texture coordinates at the same point.
    fn uv(&self, ray: &Ray, hit: &Hit) -> Vec2;

    /// Derivatives of the position after both texture coordinates at the same point, in world space and
    /// scene units. Where there are none, two directions along the surface.
    fn tangents(&self, ray: &Ray, hit: &Hit) -> [Vec3A; 2];

    /// A box around a primitive and a cone around its geometric normals, world space.
    fn primitive_extent(&self, _primitive: usize) -> (Aabb, Cone) {
        (self.bounds(), Cone::ALL)
    }

    /// Number of primitives; 0 for an instance, whose primitives are its group's.
    fn primitive_count(&self) -> usize;

    /// Area of one primitive in square scene units; 0 if it is degenerate, or cannot emit, as is the default.
    fn primitive_area(&self, _primitive: usize) -> f64 {
        0.0
    }

    /// A point of one primitive as seen from `from`. `None` where nothing of it can be sampled.
    fn sample_primitive(&self, _primitive: usize, _from: DVec3, _u: Vec2) -> Option<ShapeSample> {
        None
    }

    /// Density with which [`Shape::sample_primitive`] chooses the direction from `from` to `point`,
    /// which lies on that primitive, in sr⁻¹; 0 where it never does.
    /// In f64, because a primitive may be too small for its density to be an f32.
    fn primitive_pdf(&self, _primitive: usize, _from: DVec3, _point: &SurfacePoint) -> f64 {
        0.0
    }

    /// Bytes held by the shape's buffers.
    fn bytes(&self) -> usize;

    /// Whether shading normals are interpolated between vertices.
    fn has_vertex_normals(&self) -> bool {
        false
    }

    /// Whether it is elsewhere at another moment within the shutter.
    fn moves(&self) -> bool {
        false
    }

    /// Name of the shape's type, for reports.
    fn kind(&self) -> &'static str {
        type_word::<Self>()
    }
}

/// A point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// World position, exact to a few roundings of f64: where the ray met the primitive, and never moved along it.
    pub position: DVec3,
    /// The surface parameters there, as in [`Hit::u`] and [`Hit::v`] but of the position itself: a triangle's do not
    /// depend on the engine that found it.
    pub parameters: Vec2,
    /// Unit normal of the geometry. It lies on the side of the shading normal.
    pub geometric_normal: Vec3A,
    /// Unit normal for shading: interpolated where the shape has vertex normals.
    pub shading_normal: Vec3A,
    /// How rays start next to an edge of the primitive. `None` where no edge is near.
    pub near_edge: Option<NearEdge>,
    /// Moment within the shutter, `[0, 1]`, of the ray that met the surface; rays that leave it have the same.
    pub time: f32,
}

/// How rays leave a point next to an edge.
#[derive(Clone, Copy, Debug)]
pub struct NearEdge {
    /// What keeps the start off the edge, so that rounding does not put it beyond: about a rounding along the
    /// surface, in scene units.
    pub shift: Vec3,
    /// Of the primitive, about, in scene units.
    pub size: f32,
    /// Where the edge is not, in the roundings of another space, if the primitive is not too small for those of its own.
    pub inward: Inward,
}

impl NearEdge {
    /// For a primitive of this size. `shifted` moves a position away from edges by a distance.
    fn new(position: DVec3, size: f64, shifted: impl Fn(f64) -> DVec3) -> Self {
        let rounding = rounding_of(position);
        let coarse = is_coarse(rounding, size);
        let distance = rounding * if coarse { FROM_COARSE_EDGE } else { FROM_EDGE };
        let shift = shifted(distance) - position;
        let inward = if coarse { Inward::NONE } else { Inward::new(shift / distance) };
        Self { shift: shift.as_vec3(), size: size as f32, inward }
    }

    /// Where the ray towards `direction` (unit) starts that has this end.
    #[cold]
    fn start(&self, end: &RayEnd, direction: Vec3A) -> Vec3A {
        let (normal, direction) = (end.normal.as_dvec3(), direction.as_dvec3());
        let (rounding, size) = (rounding_of(end.point), f64::from(self.size));
        let (lift, back) = if is_coarse(rounding, size) {
            // From behind, a ray would meet other parts of so small a primitive.
            (4.0, 0.0)
        } else {
            // Rounded once, from f64: a little more than one is enough.
            (1.25, (STEP_BACK * rounding).min(size))
        };
        let lift = normal * (lift * f64::from(U) * normal.abs().dot(end.point.abs()));
        let lift = if normal.dot(direction) < 0.0 { -lift } else { lift };
        (end.point + self.shift.as_dvec3() + lift - direction * back).as_vec3a()
    }
}

/// Whether a rounding is coarse for a primitive of this size.
fn is_coarse(rounding: f64, size: f64) -> bool {
    rounding >= COARSE * size
}

impl SurfacePoint {
    /// The point as the end of a ray that leaves towards `direction` (unit, world).
    #[must_use]
    #[inline(always)]
    pub fn end_towards(&self, direction: Vec3A) -> RayEnd {
        RayEnd::new(self.position, self.geometric_normal, direction)
    }

    /// The point from which a ray towards `direction` (unit, world) leaves, and what it stands for: the position, lifted off
    /// by what rounding makes necessary.
    ///
    /// Next to an edge another surface may pass between the position and what it is rounded to. There the ray
    /// starts a little behind its surface on a line that crosses it inside of the edge. So it crosses the other
    /// surface too, if the ray from the position does, and the engines pass over what lies behind.
    #[must_use]
    #[inline(always)]
    pub fn leave_towards(&self, direction: Vec3A) -> (Vec3A, RayEnd) {
        let end = self.end_towards(direction);
        match &self.near_edge {
            None => (end.start(), end),
            Some(near_edge) => {
                let end = RayEnd { inward: near_edge.inward, ..end };
                (near_edge.start(&end, direction), end)
            }
        }
    }

    /// The ray that leaves the surface towards `direction` (unit, world). It begins at t = 0, because another surface
    /// may pass through the point that its start is rounded to.
    #[must_use]
    #[inline(always)]
    pub fn spawn(&self, direction: Vec3A) -> Ray {
        let (origin, start) = self.leave_towards(direction);
        let ray = Ray::new(origin, direction);
        Ray { t_min: 0.0, time: self.time, start: Some(start), ..ray }
    }
}

/// Distance from an edge, in roundings of a point, within which rays start with care. Elsewhere the start,
/// which is lifted by up to 6 roundings, is before both of two walls that meet at more than 11 degrees.
const NEAR_EDGE: f64 = 32.0;

/// How far off the edge they start, in the same unit, of which rounding takes one at most.
const FROM_EDGE: f64 = 1.25;

/// The same where rounding is coarse.
const FROM_COARSE_EDGE: f64 = 1.5;

/// How far they start behind their surface, in the same unit. A surface that passes within two roundings of the point
/// is met if the ray's angle to it is at least about 2⁻⁷.
const STEP_BACK: f64 = 256.0;

/// The size of a primitive, in roundings over that, below which rounding is coarse for it.
const COARSE: f64 = 1.0 / 64.0;

/// How far off an edge a point itself is kept, over the largest coordinates of its primitive: 2⁻⁴², a few thousand
/// roundings of f64, so that it is decided on which side of other surfaces that share the edge it is.
const OFF_EDGE: f64 = 1.0 / (1u64 << 42) as f64;

/// What rounding to f32 may move a point by.
#[inline(always)]
fn rounding_of(position: DVec3) -> f64 {
    f64::from(U) * position.abs().element_sum()
}

/// A point of a shape chosen as seen from another point.
#[derive(Clone, Copy, Debug)]
pub struct ShapeSample {
    /// The chosen point.
    pub point: SurfacePoint,
    /// Unit direction towards it.
    pub direction: Vec3A,
    /// Density per solid angle, in sr⁻¹. In f64, since for a tiny and distant primitive it or its
    /// inverse leaves the range of f32, though not after the choice of the primitive is counted in.
    pub pdf: f64,
}

/// Density per solid angle of a point chosen uniformly on a primitive of `area`, as seen from
/// `from`; 0 where the primitive is seen edge-on.
#[must_use]
pub(crate) fn area_pdf_toward(area: f64, from: DVec3, point: &SurfacePoint) -> f64 {
    let to = point.position - from;
    let distance_squared = to.length_squared();
    let cosine = (to.dot(point.geometric_normal.as_dvec3()) / distance_squared.sqrt()).abs();
    let pdf = distance_squared / (cosine * area);
    if pdf.is_finite() { pdf } else { 0.0 }
}

/// The sample for a point chosen uniformly on a primitive of `area`; `None` where it is seen edge-on
/// or coincides with `from`. In f64 where d² or the area is extreme, so that neither d² nor 1/area
/// overflows on the way.
#[must_use]
pub(crate) fn area_sample_toward(
    area: f64,
    from: DVec3,
    point: SurfacePoint,
) -> Option<ShapeSample> {
    let exact = point.position - from;
    let to = exact.as_vec3a();
    let distance_squared = to.length_squared();
    let area_f32 = area as f32;
    if IN_RANGE.contains(&distance_squared) && IN_RANGE.contains(&area_f32) {
        let direction = to / distance_squared.sqrt();
        let cosine = direction.dot(point.geometric_normal).abs();
        let pdf = distance_squared / (cosine * area_f32);
        if pdf.is_finite() {
            return Some(ShapeSample { point, direction, pdf: pdf.into() });
        }
    }
    let distance_squared = exact.length_squared();
    let direction = exact / distance_squared.sqrt();
    let solid_angle =
        direction.dot(point.geometric_normal.as_dvec3()).abs() * area / distance_squared;
    (solid_angle > 0.0 && solid_angle.is_finite()).then(|| ShapeSample {
        point,
        direction: direction.as_vec3a(),
        pdf: 1.0 / solid_angle,
    })
}

/// Squared lengths that have kept all their bits in f32, with room for a cosine.
const IN_RANGE: std::ops::Range<f32> = 1e-30..1e30;
