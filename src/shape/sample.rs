//! Points of shapes, chosen as seen from another point.

use glam::{DVec3, Vec3A};

use super::primitive_lanes::PrimitiveLanes;
use super::{Interaction, Shape, SurfacePoint};
use crate::math::real::{Double, Float, Lanes, Mask, Real, Select};
use crate::math::vector::{Vec2, Vec3};
use crate::math::warp;

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

/// Density per solid angle of a point chosen uniformly on a primitive of `area`, whose normal there is `normal`, as seen
/// from `from`; 0 where the primitive is seen edge-on.
#[inline(always)]
pub(crate) fn area_pdf_toward<R: Real>(
    area: R::Double,
    from: Vec3<R::Double>,
    position: Vec3<R::Double>,
    normal: Vec3<R>,
) -> R::Double {
    let to = position - from;
    let distance_squared = to.length_squared();
    let cosine = (to.dot(normal.widen()) / distance_squared.sqrt()).abs();
    let pdf = distance_squared / (cosine * area);
    R::Double::select(pdf.lt(f64::INFINITY), pdf, 0.0)
}

/// The sample for a point chosen uniformly on a primitive of `area`; `None` where it is seen edge-on
/// or coincides with `from`.
#[must_use]
pub(crate) fn area_sample_toward(
    area: f64,
    from: DVec3,
    point: SurfacePoint,
) -> Option<ShapeSample> {
    let normal = point.geometric_normal.into();
    let to = Toward::<f32>::new(area, from.into(), point.position.into(), normal);
    let direction = to.direction.into();
    to.exists.then_some(ShapeSample { point, direction, pdf: to.pdf })
}

/// The direction in which a point is seen that was chosen uniformly on a primitive, in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Toward<R: Real> {
    /// Not where the primitive is seen edge-on or the point coincides with where it is seen from.
    pub(crate) exists: R::Mask,
    /// See [`ShapeSample::direction`].
    pub(crate) direction: Vec3<R>,
    /// See [`ShapeSample::pdf`].
    pub(crate) pdf: R::Double,
}

impl<R: Real> Toward<R> {
    /// Of `point`, on a primitive of `area` whose normal there is `normal`, as seen from `from`. In f64 where d² or the area
    /// is extreme, so that neither d² nor 1/area overflows on the way.
    #[inline(always)]
    pub(crate) fn new(
        area: R::Double,
        from: Vec3<R::Double>,
        point: Vec3<R::Double>,
        normal: Vec3<R>,
    ) -> Self {
        let exact = point - from;
        let to = exact.narrow();
        let distance_squared = to.length_squared();
        let small_area = area.narrow();
        let direction = to / distance_squared.sqrt();
        let cosine = direction.dot(normal).abs();
        let pdf = distance_squared / (cosine * small_area);
        let exists = in_range(distance_squared) & in_range(small_area) & pdf.lt(f32::INFINITY);
        let near = Self { exists, direction, pdf: pdf.widen() };
        if exists.all() {
            return near;
        }
        let distance_squared = exact.length_squared();
        let direction = exact / distance_squared.sqrt();
        let solid_angle = direction.dot(normal.widen()).abs() * area / distance_squared;
        let pdf = R::Double::splat(area.token(), 1.0) / solid_angle;
        let is_seen = solid_angle.gt(0.0) & solid_angle.lt(f64::INFINITY);
        Self {
            exists: exists | is_seen,
            direction: Vec3::select(exists, near.direction, direction.narrow()),
            pdf: R::Double::select(exists, near.pdf, pdf),
        }
    }
}

/// Of squared lengths, whether they have kept all their bits in f32, with room for a cosine.
#[inline(always)]
fn in_range<R: Real>(squared: R) -> R::Mask {
    squared.ge(1e-30) & squared.lt(1e30)
}

/// A [`ShapeSample`] in each lane.
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
    /// See [`ShapeSample::direction`].
    pub(crate) direction: Vec3<R>,
    /// See [`ShapeSample::pdf`].
    pub(crate) pdf: R::Double,
}

impl<R: Real> ShapeSamples<R> {
    /// A point of a primitive of each lane's shape as seen from `from`: [`Shape::sample_primitive`]. Of triangles and
    /// spheres together, of others lane by lane.
    #[inline(always)]
    pub(crate) fn new(
        shapes: &R::Each<&dyn Shape>,
        primitives: &R::Each<u32>,
        from: Vec3<R::Double>,
        u: Vec2<R>,
    ) -> Self {
        let token = u.x.token();
        let lanes = PrimitiveLanes::at_rest::<R>(shapes, primitives);
        let (triangles, spheres) = (lanes.are_triangles::<R>(token), lanes.are_spheres::<R>(token));
        let mut samples = Self::none(token);
        if triangles.any() {
            samples = Self::of_triangles(&lanes, from, u);
        }
        if spheres.any() {
            let on_spheres = R::vectorize(
                token,
                #[inline(always)]
                || lanes.spheres(token).sample(from, u),
            );
            samples = Self::selected(spheres, on_spheres, samples);
        }
        for i in (0..R::LANES).filter(|&i| !(triangles | spheres).lane(i)) {
            let (from, u) = (from.lane(i).into(), u.lane(i).into());
            let primitive = primitives.as_ref()[i] as usize;
            samples.set_lane(i, shapes.as_ref()[i].sample_primitive(primitive, from, u));
        }
        samples
    }

    #[inline(always)]
    fn none(token: R::Token) -> Self {
        let zero = Vec3::splat(token, Vec3::default());
        Self {
            exists: R::Mask::splat(token, false),
            position: zero.widen(),
            parameters: Vec2::splat(token, Vec2::default()),
            normal: zero,
            shading_normal: zero,
            direction: zero,
            pdf: R::Double::splat(token, 0.0),
        }
    }

    #[inline(always)]
    fn of_triangles(lanes: &PrimitiveLanes, from: Vec3<R::Double>, u: Vec2<R>) -> Self {
        let token = u.x.token();
        let triangle = lanes.triangles(token);
        let point = triangle.point(warp::square_to_uniform_triangle(u));
        let (normal, shading_normal) = triangle.normals(point.weights, lanes.normals(token));
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
    fn set_lane(&mut self, lane: usize, sample: Option<ShapeSample>) {
        let token = self.pdf.token();
        let here = R::mask(token, |i| i == lane);
        let Some(ShapeSample { point, direction, pdf }) = sample else {
            self.exists &= !here;
            return;
        };
        let sample = Self {
            exists: R::Mask::splat(token, true),
            position: Vec3::splat(token, point.position.into()),
            parameters: Vec2::splat(token, point.parameters.into()),
            normal: Vec3::splat(token, point.geometric_normal.into()),
            shading_normal: Vec3::splat(token, point.shading_normal.into()),
            direction: Vec3::splat(token, direction.into()),
            pdf: R::Double::splat(token, pdf),
        };
        *self = Self::selected(here, sample, *self);
    }
}

impl<R: Real> Select for ShapeSamples<R> {
    type Mask = R::Mask;

    #[inline(always)]
    fn selected(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            exists: mask.select(yes.exists, no.exists),
            position: Vec3::select(mask, yes.position, no.position),
            parameters: Vec2::select(mask, yes.parameters, no.parameters),
            normal: Vec3::select(mask, yes.normal, no.normal),
            shading_normal: Vec3::select(mask, yes.shading_normal, no.shading_normal),
            direction: Vec3::select(mask, yes.direction, no.direction),
            pdf: R::Double::select(mask, yes.pdf, no.pdf),
        }
    }
}

/// [`Shape::primitive_pdf`] in each lane, of the points that are `seen` from `from`: of triangles and spheres together, of
/// others lane by lane.
#[inline(always)]
pub(crate) fn primitive_pdf<R: Real>(
    shapes: &R::Each<&dyn Shape>,
    primitives: &R::Each<u32>,
    from: Vec3<R::Double>,
    seen: &Interaction<R>,
) -> R::Double {
    let token = seen.time.token();
    let lanes = PrimitiveLanes::at_rest::<R>(shapes, primitives);
    let (triangles, spheres) = (lanes.are_triangles::<R>(token), lanes.are_spheres::<R>(token));
    let (position, normal) = (seen.position, seen.geometric_normal);
    let mut pdf = R::Double::splat(token, 0.0);
    if triangles.any() {
        pdf = area_pdf_toward::<R>(lanes.triangles::<R>(token).area, from, position, normal);
    }
    if spheres.any() {
        let on_spheres = lanes.spheres::<R>(token).pdf(from, position, normal);
        pdf = R::Double::select(spheres, on_spheres, pdf);
    }
    for i in (0..R::LANES).filter(|&i| !(triangles | spheres).lane(i)) {
        let primitive = primitives.as_ref()[i] as usize;
        let alone = shapes.as_ref()[i].primitive_pdf(primitive, from.lane(i).into(), &seen.lane(i));
        pdf = R::Double::select(R::mask(token, |lane| lane == i), alone, pdf);
    }
    pdf
}
