//! The surfaces that some rays have met, in lanes, and the rays that leave them.

use glam::Vec3A;

use super::primitive_lanes::PrimitiveLanes;
use super::silhouette::near_edge;
use super::{NearEdge, Shape, SurfacePoint};
use crate::math::real::{Lanes, Mask, Real, Select};
use crate::math::vector::{Vec2, Vec3};
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
    /// The surface that each lane's ray has met. Triangles and spheres are solved together; other shapes, and what is next
    /// to edges, one lane after the other, of whose `ray` all is asked.
    #[inline(always)]
    #[must_use]
    pub fn new(arrivals: &Arrivals<'_, R>, ray: impl Fn(usize) -> Ray) -> Self {
        let Arrivals { origin, direction, time, .. } = *arrivals;
        let token = time.token();
        let mut lanes = PrimitiveLanes::NONE;
        for (i, (shape, hit)) in
            arrivals.shapes.as_ref().iter().zip(arrivals.hits.as_ref()).enumerate()
        {
            shape.put(hit.primitive, time.lane(i), &mut lanes.lane(i));
        }
        let triangles = lanes.are_triangles::<R>(token);
        let spheres = lanes.are_spheres::<R>(token);
        let mut solved = Solved::none(token);
        if triangles.any() {
            solved = Solved::on_triangles(&lanes, origin, direction);
        }
        if spheres.any() {
            let on_spheres = R::vectorize(
                token,
                #[inline(always)]
                || Solved::on_spheres(&lanes, arrivals),
            );
            solved = Solved::selected(spheres, on_spheres, solved);
        }
        let mut interaction = Self {
            position: solved.position,
            parameters: solved.parameters,
            geometric_normal: solved.geometric_normal,
            shading_normal: solved.shading_normal,
            is_near_edge: R::Mask::splat(token, false),
            near_edge: R::each(|_| None),
            time,
        };
        let whole = solved.is_clear & (triangles | spheres);
        if !whole.all() {
            interaction.mend(triangles, whole, arrivals, ray);
        }
        interaction
    }

    /// Puts right what was not solved together.
    #[inline(always)]
    fn mend(
        &mut self,
        triangles: R::Mask,
        whole: R::Mask,
        arrivals: &Arrivals<'_, R>,
        ray: impl Fn(usize) -> Ray,
    ) {
        for i in (0..R::LANES).filter(|&i| !whole.lane(i)) {
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

/// The surfaces of triangles or spheres.
#[derive(Clone, Copy)]
struct Solved<R: Real> {
    position: Vec3<R::Double>,
    parameters: Vec2<R>,
    geometric_normal: Vec3<R>,
    shading_normal: Vec3<R>,
    /// Where no edge is near.
    is_clear: R::Mask,
}

impl<R: Real> Solved<R> {
    #[inline(always)]
    fn none(token: R::Token) -> Self {
        let zero = Vec3::splat(token, Vec3::default());
        Self {
            position: zero.widen(),
            parameters: Vec2::splat(token, Vec2::default()),
            geometric_normal: zero,
            shading_normal: zero,
            is_clear: R::Mask::splat(token, false),
        }
    }

    #[inline(always)]
    fn on_triangles(lanes: &PrimitiveLanes, origin: Vec3<R::Double>, direction: Vec3<R>) -> Self {
        let token = direction.x.token();
        let triangle = lanes.triangles(token);
        let (point, is_clear) = triangle.meet(origin, direction);
        let (geometric_normal, shading_normal) =
            triangle.normals(point.weights, lanes.normals(token));
        let (position, parameters) = (point.position, point.weights);
        Self { position, parameters, geometric_normal, shading_normal, is_clear }
    }

    #[inline(always)]
    fn on_spheres(lanes: &PrimitiveLanes, arrivals: &Arrivals<'_, R>) -> Self {
        let token = arrivals.time.token();
        let hits = arrivals.hits.as_ref();
        let [t, u, v]: [fn(&Hit) -> f32; 3] = [|hit| hit.t, |hit| hit.u, |hit| hit.v];
        let [t, u, v] = [t, u, v].map(|of| R::from_fn(token, |i| of(&hits[i])));
        let spheres = lanes.spheres(token);
        let (position, normal) = spheres.meet(arrivals.origin, arrivals.direction, u.ge(0.5), t);
        Self {
            position,
            parameters: Vec2::new(u, v),
            geometric_normal: normal,
            shading_normal: normal,
            is_clear: R::Mask::splat(token, true),
        }
    }
}

impl<R: Real> Select for Solved<R> {
    type Mask = R::Mask;

    #[inline(always)]
    fn selected(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            position: Vec3::select(mask, yes.position, no.position),
            parameters: Vec2::select(mask, yes.parameters, no.parameters),
            geometric_normal: Vec3::select(mask, yes.geometric_normal, no.geometric_normal),
            shading_normal: Vec3::select(mask, yes.shading_normal, no.shading_normal),
            is_clear: mask.select(yes.is_clear, no.is_clear),
        }
    }
}
