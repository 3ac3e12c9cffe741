//! Instances: shapes that are placed many times and stored once.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec3A};

use super::{
    FROM_COARSE_EDGE, FROM_EDGE, Geometry, NearEdge, Shape, SurfacePoint, is_coarse, rounding_of,
};
use crate::math::{Aabb, Motion};
use crate::ray::{Hit, Inward, Ray, RayEnd};

/// Shapes in a space of their own, which instances map into the scene.
#[derive(Debug)]
pub struct Group {
    shapes: Vec<Arc<dyn Shape>>,
    bounds: Aabb,
}

/// Why a group cannot be, or not there.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum InstanceError {
    /// An instance inside a group.
    #[error("an instance cannot be part of what is instanced")]
    Nested,
    /// A map that is singular, not finite, or so close to it that f32 does not hold what it makes of a ray.
    #[error(
        "the map is singular: it flattens what it places, or scales by less than 1e-18 or more than 1e18"
    )]
    Singular,
    /// The same, between two keys of a motion: at this moment within the shutter.
    #[error(
        "the map is singular {:.0} % into the shutter: keys are too far apart, since its matrix is linear \
         between them",
        100.0 * .0
    )]
    SingularAt(f64),
    /// Coordinates that no engine can take.
    #[error("an instance reaches farther than coordinates may")]
    TooFar,
}

impl Group {
    /// # Errors
    /// An instance among the shapes.
    pub fn new(shapes: Vec<Arc<dyn Shape>>) -> Result<Self, InstanceError> {
        if shapes.iter().any(|shape| matches!(shape.geometry(), Geometry::Instance(_))) {
            return Err(InstanceError::Nested);
        }
        let bounds = shapes.iter().fold(Aabb::EMPTY, |all, shape| all.union(shape.bounds()));
        Ok(Self { shapes, bounds })
    }

    /// The shapes; a hit's `member` is an index into them.
    #[must_use]
    pub fn shapes(&self) -> &[Arc<dyn Shape>] {
        &self.shapes
    }

    /// Bytes held by the shapes' buffers.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.shapes.iter().map(|shape| shape.bytes()).sum()
    }
}

/// A group placed in the scene.
///
/// Engines build one tree over the group and answer for an instance with [`Instance::nearest`] and
/// [`Instance::local`], so that all of them ask about the same ray in the group's space.
#[derive(Debug)]
pub struct Instance {
    group: Arc<Group>,
    placement: Placement,
    /// Around all places.
    bounds: Aabb,
}

/// Where a group is.
#[derive(Debug)]
enum Placement {
    Still(Box<Maps>),
    Moving(Motion),
}

/// A map and what follows from it.
#[derive(Clone, Debug)]
struct Maps {
    to_world: DAffine3,
    to_group: DAffine3,
    /// Takes normals into the scene: the inverse transpose.
    normal_to_world: DMat3,
}

impl Maps {
    fn new(to_world: DAffine3) -> Self {
        let to_group = to_world.inverse();
        Self { to_world, to_group, normal_to_world: to_group.matrix3.transpose() }
    }

    /// Whether the maps are right in both directions, and f32 holds what they make of a ray.
    fn are_regular(&self) -> bool {
        let [out, back] = [self.to_world, self.to_group].map(|map| {
            map.matrix3.to_cols_array().into_iter().fold(0.0, |most: f64, v| most.max(v.abs()))
        });
        let within = |scale: f64| scale > LEAST_SCALE && scale < 1.0 / LEAST_SCALE;
        let finite = self.to_world.is_finite() && self.to_group.is_finite();
        finite && within(out) && within(back) && out * back < MOST_STRETCH
    }
}

/// A ray in the space of a group.
#[derive(Clone, Copy, Debug)]
pub struct LocalRay {
    /// With a unit direction.
    pub ray: Ray,
    /// Lengths along it over lengths along the ray in the scene.
    pub stretch: f64,
    /// How far it starts before the ray in the scene, in lengths of the group: next to an edge, each starts behind
    /// its surface by roundings of its own coordinates.
    pub ahead: f64,
}

impl LocalRay {
    /// Distance along the ray in the scene, for one along this.
    #[must_use]
    pub fn in_scene(&self, t: f64) -> f64 {
        (t + self.ahead) / self.stretch
    }

    /// Distance along this ray, for one along that in the scene.
    #[must_use]
    pub fn in_group(&self, t: f64) -> f64 {
        t * self.stretch - self.ahead
    }
}

impl Instance {
    /// The group under the map `to_world`.
    ///
    /// # Errors
    /// A map that is singular or nearly so, or coordinates that no engine can take.
    pub fn new(group: Arc<Group>, to_world: DAffine3) -> Result<Self, InstanceError> {
        let maps = Maps::new(to_world);
        if !maps.are_regular() {
            return Err(InstanceError::Singular);
        }
        Self::placed(group, Placement::Still(Box::new(maps)), [to_world])
    }

    /// The group under maps that change over the shutter.
    ///
    /// # Errors
    /// A map that is singular or nearly so at some moment, or coordinates that no engine can take.
    pub fn moving(group: Arc<Group>, motion: Motion) -> Result<Self, InstanceError> {
        let singular = |time: &f64| !Maps::new(motion.at(*time)).are_regular();
        if let Some(time) = motion.moments().find(singular) {
            return Err(InstanceError::SingularAt(time));
        }
        // Between two keys every point goes along a straight line, and stays in the box around both ends.
        let maps: Vec<_> = motion.keys().iter().map(|(_, map)| *map).collect();
        Self::placed(group, Placement::Moving(motion), maps)
    }

    /// `maps` are those whose images of the group hold it at all times between them.
    fn placed(
        group: Arc<Group>,
        placement: Placement,
        maps: impl IntoIterator<Item = DAffine3>,
    ) -> Result<Self, InstanceError> {
        let around = |all: Aabb, map| all.union(mapped(&map, &group.bounds));
        let bounds = maps.into_iter().fold(Aabb::EMPTY, around);
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        // NaN compares as false and is refused too. What is empty reaches nowhere.
        if group.bounds.is_empty() || reach < Ray::LARGEST_COORDINATE {
            Ok(Self { group, placement, bounds })
        } else {
            Err(InstanceError::TooFar)
        }
    }

    fn maps(&self, time: f32) -> Cow<'_, Maps> {
        match &self.placement {
            Placement::Still(maps) => Cow::Borrowed(maps),
            Placement::Moving(motion) => Cow::Owned(Maps::new(motion.at(time.into()))),
        }
    }

    /// The map at a moment within the shutter.
    #[must_use]
    pub fn to_world(&self, time: f32) -> DAffine3 {
        self.maps(time).to_world
    }

    /// What is placed.
    #[must_use]
    pub fn group(&self) -> &Arc<Group> {
        &self.group
    }

    /// `ray` in the group's space, formed in f64 and rounded once.
    #[must_use]
    pub fn local(&self, ray: &Ray) -> LocalRay {
        let maps = self.maps(ray.time);
        let (local, stretch) = ray.mapped(&maps.to_group);
        // Normals go into the group by the transpose of the way out.
        let normals = maps.to_world.matrix3.transpose();
        let mapped = |end: RayEnd, direction| end.mapped(&maps.to_group, &normals, direction);
        let start = ray.start.map(|start| mapped(start, local.direction));
        let end = ray.end.map(|end| mapped(end, -local.direction));
        let local = Ray { start, end, ..local };
        match (ray.start, start) {
            (Some(there), Some(start)) if there.inward != Inward::NONE => {
                next_to_edge(ray, there, local, start, stretch, &maps)
            }
            // Rounded where it is small: far from the origin of the scene the ray's own start may lie beside the surface.
            (_, Some(start)) => {
                LocalRay { ray: Ray { origin: start.start(), ..local }, stretch, ahead: 0.0 }
            }
            (_, None) => LocalRay { ray: local, stretch, ahead: 0.0 },
        }
    }

    /// The nearest hit within the ray's segment, given `closest_hit` of an engine over the group.
    pub fn nearest(&self, ray: &Ray, closest_hit: impl FnOnce(&Ray) -> Option<Hit>) -> Option<Hit> {
        let local = self.local(ray);
        let Hit { t, u, v, shape, primitive, .. } = closest_hit(&local.ray)?;
        let t = local.in_scene(t.into()) as f32;
        // A start behind the edge was rounded twice.
        let t = if local.ahead == 0.0 { t } else { t.max(ray.t_min) };
        // The way there and back may round a hit at the very end out of the segment.
        let within = t >= ray.t_min && t <= ray.t_max && t < f32::INFINITY;
        within.then_some(Hit { t, u, v, shape: 0, primitive, member: shape })
    }

    /// A point of a member's surface, where it is at a moment within the shutter.
    #[must_use]
    pub fn placed_point(&self, point: &SurfacePoint, time: f32) -> SurfacePoint {
        let maps = self.maps(time);
        let normal = |n: Vec3A| (maps.normal_to_world * n.as_dvec3()).normalize().as_vec3a();
        let position = maps.to_world.transform_point3(point.position);
        SurfacePoint {
            position,
            parameters: point.parameters,
            geometric_normal: normal(point.geometric_normal),
            shading_normal: normal(point.shading_normal),
            near_edge: point.near_edge.map(|near| placed_edge(&near, position, &maps)),
            time,
        }
    }

    /// The member that was hit, and the ray and hit as it sees them.
    fn member(&self, ray: &Ray, hit: &Hit) -> (&dyn Shape, Ray, Hit) {
        let local = self.local(ray);
        let t = local.in_group(hit.t.into()) as f32;
        let hit = Hit { t, shape: hit.member, member: 0, ..*hit };
        (self.group.shapes[hit.shape as usize].as_ref(), local.ray, hit)
    }
}

/// As [`FROM_EDGE`], for a way that is rounded to eighths, so by up to √3 sixteenths.
const FROM_ROUNDED_EDGE: f64 = 1.125 * FROM_EDGE;

/// The edge near a point of a member, as it is near to where the point is placed.
#[cold]
fn placed_edge(near: &NearEdge, position: DVec3, maps: &Maps) -> NearEdge {
    let way = carried(&maps.to_world, near.inward);
    let size = f64::from(near.size) / most_stretch(&maps.to_group.matrix3);
    let rounding = rounding_of(position);
    let distance = if is_coarse(rounding, size) {
        (FROM_COARSE_EDGE * rounding).min(size / 3.0)
    } else {
        FROM_ROUNDED_EDGE * rounding
    };
    NearEdge { shift: (way * distance).as_vec3(), size: size as f32, inward: Inward::new(way) }
}

/// The ray `local` from the end `start`, next to an edge of what it leaves: in the scene it is `ray` from `there`.
#[cold]
fn next_to_edge(
    ray: &Ray,
    there: RayEnd,
    local: Ray,
    start: RayEnd,
    stretch: f64,
    maps: &Maps,
) -> LocalRay {
    let way = carried(&maps.to_group, there.inward);
    let rounding = rounding_of(start.point);
    let start = RayEnd { inward: Inward::new(way), ..start };
    // Not coarse, or the way would not be known.
    let near_edge = NearEdge {
        shift: (start.inward.way() * (FROM_ROUNDED_EDGE * rounding)).as_vec3(),
        size: f32::INFINITY,
        inward: start.inward,
    };
    let origin = near_edge.start(&start, local.direction);
    let before = |origin: Vec3A, end: &RayEnd, direction: Vec3A| {
        (origin.as_dvec3() - end.point).dot(direction.as_dvec3())
    };
    let ahead = before(origin, &start, local.direction)
        - stretch * before(ray.origin, &there, ray.direction);
    let place = LocalRay { ray: local, stretch, ahead };
    // 0 stands for the surface that the ray leaves.
    let t_min = place.in_group(ray.t_min.into()).max(f32::MIN_POSITIVE.into());
    let t_min = if ray.t_min == 0.0 { f32::MIN_POSITIVE } else { t_min as f32 };
    let t_max = place.in_group(ray.t_max.into()) as f32;
    LocalRay { ray: Ray { origin, start: Some(start), t_min, t_max, ..local }, ..place }
}

/// The way off an edge in another space, as long as in this: where the map back leads to, it is what it was.
fn carried(map: &DAffine3, inward: Inward) -> DVec3 {
    let way = inward.way();
    map.transform_vector3(way).normalize_or_zero() * way.length()
}

/// What a matrix makes of a unit vector is at most this long: the root of the largest sum of a row of MᵀM, which bounds
/// its eigenvalues. Exact where it turns and scales.
fn most_stretch(matrix: &DMat3) -> f64 {
    let squared = matrix.transpose() * *matrix;
    let row = |axis: DVec3| axis.abs().element_sum();
    row(squared.x_axis).max(row(squared.y_axis)).max(row(squared.z_axis)).sqrt()
}

/// Scales beyond this, or its inverse, take a ray out of f32.
const LEAST_SCALE: f64 = 1e-18;

/// The largest scale over the least, about: beyond, the inverse has lost digits that f32 needs.
const MOST_STRETCH: f64 = 1e9;

/// The box around the image of a box, with a margin for the rounding of rays in the group's space.
fn mapped(map: &DAffine3, bounds: &Aabb) -> Aabb {
    if bounds.is_empty() {
        return Aabb::EMPTY;
    }
    let corners = (0..8).map(|i| {
        let pick =
            |axis: usize| if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
        map.transform_point3(DVec3::new(pick(0).into(), pick(1).into(), pick(2).into())).as_vec3()
    });
    let around = Aabb::around(corners);
    let reach = around.min.abs().max(around.max.abs());
    // Of the ray's start, which is rounded in proportion to the group's coordinates.
    let local = bounds.min.abs().max(bounds.max.abs()).as_dvec3();
    let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(DVec3::abs);
    let margin =
        (reach + (x * local.x + y * local.y + z * local.z).as_vec3()) * (8.0 * f32::EPSILON);
    let margin = margin + Vec3::splat(f32::MIN_POSITIVE);
    Aabb { min: around.min - margin, max: around.max + margin }
}

impl Shape for Instance {
    fn geometry(&self) -> Geometry<'_> {
        Geometry::Instance(self)
    }

    fn bounds(&self) -> Aabb {
        self.bounds
    }

    fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        let (shape, local, hit) = self.member(ray, hit);
        self.placed_point(&shape.surface(&local, &hit), ray.time)
    }

    fn uv(&self, ray: &Ray, hit: &Hit) -> Vec2 {
        let (shape, ray, hit) = self.member(ray, hit);
        shape.uv(&ray, &hit)
    }

    fn tangents(&self, ray: &Ray, hit: &Hit) -> [Vec3A; 2] {
        let to_world = self.maps(ray.time).to_world;
        let (shape, ray, hit) = self.member(ray, hit);
        let into_world = |v: Vec3A| to_world.transform_vector3(v.as_dvec3()).as_vec3a();
        shape.tangents(&ray, &hit).map(into_world)
    }

    /// None: an instance cannot emit.
    fn primitive_count(&self) -> usize {
        0
    }

    /// Without the group, which all its instances share.
    fn bytes(&self) -> usize {
        let placement = match &self.placement {
            Placement::Still(maps) => size_of_val(maps.as_ref()),
            Placement::Moving(motion) => size_of_val(motion.keys()),
        };
        size_of::<Self>() + placement
    }

    fn moves(&self) -> bool {
        let moving = matches!(self.placement, Placement::Moving(_));
        moving || self.group.shapes.iter().any(|shape| shape.moves())
    }

    fn has_vertex_normals(&self) -> bool {
        self.group.shapes.iter().any(|shape| shape.has_vertex_normals())
    }
}
