//! The surfaces that some rays have met, in lanes, and the rays that leave them.

use glam::{DVec3, Vec3A};

use super::facets::Facets;
use super::triangle::Triangle;
use super::{NearEdge, Shape, ShapeSample, SurfacePoint, Toward};
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};
use crate::math::warp;
use crate::ray::{Hit, Ray, RayEnds, RayLanes};

/// A [`SurfacePoint`] in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Interaction<R: Real> {
    /// See [`SurfacePoint::position`].
    pub position: Vec3<R::Double>,
    /// See [`SurfacePoint::parameters`].
    pub parameters: Vec2<R>,
    /// See [`SurfacePoint::geometric_normal`].
    pub geometric_normal: Vec3<R>,
    /// See [`SurfacePoint::shading_normal`].
    pub shading_normal: Vec3<R>,
    /// Where [`SurfacePoint::near_edge`] is there.
    pub is_near_edge: R::Mask,
    /// See [`SurfacePoint::near_edge`].
    pub near_edge: R::Each<Option<NearEdge>>,
    /// See [`SurfacePoint::time`].
    pub time: R,
}

/// The rays that have met shapes, and what an engine found of it, in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Arrivals<'a, R: Real> {
    /// What was hit.
    pub shapes: R::Each<&'a dyn Shape>,
    /// Where, in the engine's words.
    pub hits: R::Each<Hit>,
    /// See [`Ray::exact_origin`].
    pub origin: Vec3<R::Double>,
    /// See [`Ray::direction`].
    pub direction: Vec3<R>,
    /// See [`Ray::time`].
    pub time: R,
}

impl<'a> Arrivals<'a, f32> {
    /// One lane.
    #[inline(always)]
    #[must_use]
    pub fn one(shape: &'a dyn Shape, ray: &Ray, hit: &Hit) -> Self {
        Self {
            shapes: [shape],
            hits: [*hit],
            origin: ray.exact_origin().into(),
            direction: ray.direction.into(),
            time: ray.time,
        }
    }
}

impl<R: Real> Interaction<R> {
    /// The surface that each lane's ray has met. Triangles are solved together; of other shapes, and next to edges, one
    /// lane after the other, of whose `ray` all is asked.
    #[inline(always)]
    #[must_use]
    pub fn new(arrivals: &Arrivals<'_, R>, ray: impl Fn(usize) -> Ray) -> Self {
        let Arrivals { origin, direction, time, .. } = *arrivals;
        let token = time.token();
        let mut facets = Facets::NONE;
        let mut triangles = 0;
        for (i, (shape, hit)) in
            arrivals.shapes.as_ref().iter().zip(arrivals.hits.as_ref()).enumerate()
        {
            let is_triangle = shape.facet(hit.primitive, time.lane(i), &mut facets.lane(i));
            triangles |= u32::from(is_triangle) << i;
        }
        let triangles = R::Mask::from_bits(token, triangles);
        let triangle = Triangle::new(facets.corners(token));
        let (point, clear) = triangle.meet(origin, direction);
        let normals = facets.normals(token);
        let (geometric_normal, shading_normal) = triangle.normals(point.weights, normals);
        let mut interaction = Self {
            position: point.position,
            parameters: point.weights,
            geometric_normal,
            shading_normal,
            is_near_edge: R::Mask::splat(token, false),
            near_edge: R::each(|_| None),
            time,
        };
        if !(triangles & clear).all() {
            interaction.mend(triangles, clear, arrivals, ray);
        }
        interaction
    }

    /// Puts right what was not solved together.
    #[inline(always)]
    fn mend(
        &mut self,
        triangles: R::Mask,
        clear: R::Mask,
        arrivals: &Arrivals<'_, R>,
        ray: impl Fn(usize) -> Ray,
    ) {
        for i in (0..R::LANES).filter(|&i| !(triangles & clear).lane(i)) {
            let (shape, hit) = (arrivals.shapes.as_ref()[i], &arrivals.hits.as_ref()[i]);
            let ray = ray(i);
            let surface = if triangles.lane(i) {
                near_edge(shape, &ray, hit)
            } else {
                shape.surface(&ray, hit)
            };
            self.set_lane(i, &SurfacePoint { time: ray.time, ..surface });
        }
    }

    /// That of one lane.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> SurfacePoint {
        SurfacePoint {
            position: self.position.lane(i).into(),
            parameters: self.parameters.lane(i).into(),
            geometric_normal: self.geometric_normal.lane(i).into(),
            shading_normal: self.shading_normal.lane(i).into(),
            near_edge: self.near_edge.as_ref()[i],
            time: self.time.lane(i),
        }
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, surface: &SurfacePoint) {
        let token = self.time.token();
        let here = R::mask(token, |i| i == lane);
        let vector =
            |number: Vec3A, old| Vec3::select(here, Vec3::splat(token, number.into()), old);
        let position = Vec3::splat(token, surface.position.into());
        let parameters = Vec2::splat(token, surface.parameters.into());
        self.position = Vec3::select(here, position, self.position);
        self.parameters = Vec2::select(here, parameters, self.parameters);
        self.geometric_normal = vector(surface.geometric_normal, self.geometric_normal);
        self.shading_normal = vector(surface.shading_normal, self.shading_normal);
        self.time = R::select(here, surface.time, self.time);
        self.near_edge.as_mut()[lane] = surface.near_edge;
        if surface.near_edge.is_some() {
            self.is_near_edge |= here;
        }
    }

    /// The rays that leave the surfaces towards `direction` (unit, world): from the positions, lifted off by what rounding
    /// makes necessary. They begin at t = 0, because another surface may pass through the point that a start is rounded to.
    ///
    /// Next to an edge another surface may pass between the position and what it is rounded to. There the ray
    /// starts a little behind its surface on a line that crosses it inside of the edge. So it crosses the other
    /// surface too, if the ray from the position does, and the engines pass over what lies behind.
    #[inline(always)]
    #[must_use]
    pub fn spawn(&self, direction: Vec3<R>) -> RayLanes<R> {
        let token = self.time.token();
        let start = RayEnds::new(self.position, self.geometric_normal, direction);
        let mut rays = RayLanes {
            origin: start.start(),
            direction,
            t_max: R::splat(token, f32::INFINITY),
            time: self.time,
            start,
            inward: R::Uint::splat(token, 0),
        };
        if self.is_near_edge.any() {
            self.start_near_edges(&mut rays);
        }
        rays
    }

    #[inline(always)]
    fn start_near_edges(&self, rays: &mut RayLanes<R>) {
        let token = self.time.token();
        for i in 0..R::LANES {
            let Some(near_edge) = self.near_edge.as_ref()[i] else { continue };
            let start = near_edge.start(&rays.start.lane(i), rays.direction.lane(i).into());
            let here = R::mask(token, |lane| lane == i);
            rays.origin = Vec3::select(here, Vec3::splat(token, start.into()), rays.origin);
            rays.inward = R::Uint::select(here, near_edge.inward.to_bits(), rays.inward);
        }
    }
}

impl From<SurfacePoint> for Interaction<f32> {
    #[inline(always)]
    fn from(surface: SurfacePoint) -> Self {
        Self {
            position: surface.position.into(),
            parameters: surface.parameters.into(),
            geometric_normal: surface.geometric_normal.into(),
            shading_normal: surface.shading_normal.into(),
            is_near_edge: surface.near_edge.is_some(),
            near_edge: [surface.near_edge],
            time: surface.time,
        }
    }
}

/// The surface of a triangle that is met close to its edge.
#[cold]
fn near_edge(shape: &dyn Shape, ray: &Ray, hit: &Hit) -> SurfacePoint {
    let mut facets = Facets::NONE;
    shape.facet(hit.primitive, ray.time, &mut facets.lane(0));
    let triangle = facets.triangle();
    let (origin, direction) = (ray.exact_origin().into(), ray.direction.into());
    let met = triangle.meet_near_edge(origin, direction, Vec2::new(hit.u, hit.v));
    if met.is_beyond
        && let Some(surface) = shape.neighbouring_surface(ray, hit)
    {
        // The hit still names this triangle.
        return SurfacePoint { parameters: Vec2::new(hit.u, hit.v).into(), ..surface };
    }
    let surface = facets.surface(&triangle, met.point);
    SurfacePoint { near_edge: Some(met.near_edge), ..surface }
}

/// A [`super::ShapeSample`] in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShapeSamples<R: Real> {
    /// Where anything can be sampled.
    pub(crate) exists: R::Mask,
    /// Of the chosen point.
    pub(crate) position: Vec3<R::Double>,
    /// Of the chosen point: see [`SurfacePoint::parameters`].
    pub(crate) parameters: Vec2<R>,
    /// Of the chosen point: see [`SurfacePoint::geometric_normal`].
    pub(crate) normal: Vec3<R>,
    /// Of the chosen point: see [`SurfacePoint::shading_normal`].
    pub(crate) shading_normal: Vec3<R>,
    /// See [`super::ShapeSample::direction`].
    pub(crate) direction: Vec3<R>,
    /// See [`super::ShapeSample::pdf`].
    pub(crate) pdf: R::Double,
}

impl<R: Real> ShapeSamples<R> {
    /// A point of a primitive of `shape` as seen from `from`: [`Shape::sample_primitive`].
    #[inline(always)]
    pub(crate) fn new(
        shape: &dyn Shape,
        primitives: &R::Each<u32>,
        from: Vec3<R::Double>,
        u: Vec2<R>,
    ) -> Self {
        let token = u.x.token();
        let primitives = primitives.as_ref();
        let mut facets = Facets::NONE;
        for (i, &primitive) in primitives.iter().enumerate() {
            // What emits is at rest.
            if !shape.facet(primitive, 0.0, &mut facets.lane(i)) {
                return Self::lane_by_lane(shape, primitives, from, u);
            }
        }
        let triangle = Triangle::new(facets.corners(token));
        let point = triangle.point(warp::square_to_uniform_triangle(u));
        let normals = facets.normals(token);
        let (normal, shading_normal) = triangle.normals(point.weights, normals);
        let to = Toward::new(triangle.area, from, point.position, normal);
        Self {
            exists: to.exists,
            position: point.position,
            parameters: point.weights,
            normal,
            shading_normal,
            direction: to.direction,
            pdf: to.pdf,
        }
    }

    /// That of a lane, if there is one.
    pub(super) fn lane(&self, i: usize) -> Option<ShapeSample> {
        let point = SurfacePoint {
            position: self.position.lane(i).into(),
            parameters: self.parameters.lane(i).into(),
            geometric_normal: self.normal.lane(i).into(),
            shading_normal: self.shading_normal.lane(i).into(),
            near_edge: None,
            time: 0.0,
        };
        self.exists.lane(i).then(|| ShapeSample {
            point,
            direction: self.direction.lane(i).into(),
            pdf: self.pdf.lane(i),
        })
    }

    #[inline(always)]
    fn lane_by_lane(
        shape: &dyn Shape,
        primitives: &[u32],
        from: Vec3<R::Double>,
        u: Vec2<R>,
    ) -> Self {
        let token = u.x.token();
        let samples = R::each(|i| {
            let (from, u) = (from.lane(i).into(), u.lane(i).into());
            shape.sample_primitive(primitives[i] as usize, from, u)
        });
        let samples = samples.as_ref();
        let vector = |of: fn(&ShapeSample) -> Vec3A| {
            Vec3::from_fn(token, |i| samples[i].as_ref().map_or(Vec3A::ZERO, of).into())
        };
        let point = |i: usize| samples[i].map(|sample| sample.point);
        Self {
            exists: R::mask(token, |i| samples[i].is_some()),
            position: Vec3::from_fn(token, |i| {
                point(i).map_or(DVec3::ZERO, |point| point.position).into()
            }),
            parameters: Vec2::from_fn(token, |i| {
                point(i).map_or(glam::Vec2::ZERO, |point| point.parameters).into()
            }),
            normal: vector(|sample| sample.point.geometric_normal),
            shading_normal: vector(|sample| sample.point.shading_normal),
            direction: vector(|sample| sample.direction),
            pdf: R::Double::from_fn(token, |i| samples[i].map_or(0.0, |sample| sample.pdf)),
        }
    }
}
