//! Shapes: their geometry, sampling by area or solid angle, and the surface at a hit with the rays that
//! leave it.

use std::fmt::Debug;

use glam::{DVec3, Vec2, Vec3, Vec3A};

use self::sample::area_pdf_toward;
use crate::math::{Aabb, Cone, UNIT_ROUNDOFF as U, type_word};
use crate::ray::{Hit, Inward, Ray, RayEnd};

pub mod cylinder;
pub mod deforming;
pub mod disk;
pub mod instance;
pub mod interaction;
pub mod mesh;
mod neighbours;
pub mod primitive_lanes;
pub mod primitives;
pub mod sample;
mod silhouette;
pub mod sphere;
mod triangle;

pub use cylinder::Cylinder;
pub use deforming::DeformingMesh;
pub use disk::Disk;
pub use instance::{Group, Instance};
pub use interaction::{Arrivals, Interaction};
pub use mesh::TriangleMesh;
pub use primitive_lanes::PrimitiveLane;
pub use sample::ShapeSample;
pub(crate) use sample::ShapeSamples;
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

    /// Puts a primitive that is a triangle or a sphere, as it is at a moment within the shutter, where it is asked for; of
    /// another nothing. What puts one here has its [`Shape::surface`] from [`Interaction::new`], which takes eight at once.
    fn put(&self, _primitive: u32, _time: f32, _lane: &mut PrimitiveLane<'_>) {}

    /// The other triangles that share a corner with this one, some perhaps repeatedly: rarely asked for.
    fn touching(&self, _primitive: u32) -> Vec<u32> {
        Vec::new()
    }

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
    /// which lies on that primitive, in sr⁻¹; 0 where it never does. Unless said otherwise, that of points chosen uniformly.
    /// In f64, because a primitive may be too small for its density to be an f32.
    fn primitive_pdf(&self, primitive: usize, from: DVec3, point: &SurfacePoint) -> f64 {
        let (position, normal) = (point.position.into(), point.geometric_normal.into());
        area_pdf_toward::<f32>(self.primitive_area(primitive), from.into(), position, normal)
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
        let inward = match Inward::new(shift / distance) {
            _ if coarse => Inward::NONE,
            // Far enough from the edge in these roundings, but near it all the same: to say so a little will do.
            Inward::NONE => Inward::least(shifted(NEAR_EDGE * rounding) - position),
            inward => inward,
        };
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

    /// Where a ray towards `direction` (unit, world) leaves, and what that stands for: see [`Interaction::spawn`].
    #[must_use]
    pub fn leave_towards(&self, direction: Vec3A) -> (Vec3A, RayEnd) {
        let ray = self.spawn(direction);
        (ray.origin, ray.start.expect("leaves a surface"))
    }

    /// The ray that leaves the surface towards `direction` (unit, world): see [`Interaction::spawn`].
    #[must_use]
    #[inline(always)]
    pub fn spawn(&self, direction: Vec3A) -> Ray {
        Interaction::from(*self).spawn(direction.into()).lane(0)
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
pub(crate) fn rounding_of(position: DVec3) -> f64 {
    f64::from(U) * position.abs().element_sum()
}
