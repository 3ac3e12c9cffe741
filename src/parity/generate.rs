//! Rays of all families, made from the shapes by the counter-based sampler, so that a seed and a number name
//! a ray on every machine and for every number of threads.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3, Vec3A};

use super::{Family, RaySource};
use crate::camera::Camera;
use crate::math::{Aabb, Frame, warp};
use crate::ray::{Hit, Ray};
use crate::sampler::{Independent, PathSampler};
use crate::scene::CameraMotion;
use crate::shape::{Geometry, Instance, Shape, SurfacePoint};

/// A camera, and how it moves if it does.
pub type View = (Camera, Option<CameraMotion>);

/// Rays of all families in turn.
#[derive(Debug)]
pub struct Generated {
    shapes: Vec<Arc<dyn Shape>>,
    /// Number of primitives in all shapes before each.
    starts: Vec<usize>,
    primitives: usize,
    center: Vec3A,
    size: f32,
    view: Option<View>,
    sampler: Independent,
    /// Where moments within the shutter come from.
    moments: Independent,
    count: u64,
}

/// The random numbers of a ray, and its time.
struct Draw<'a> {
    numbers: PathSampler<'a>,
    time: f32,
}

impl Draw<'_> {
    fn next_1d(&mut self) -> f32 {
        self.numbers.next_1d()
    }

    fn next_2d(&mut self) -> Vec2 {
        self.numbers.next_2d()
    }
}

/// A primitive of a shape; of one in a group if it is an instance.
struct Pick<'a> {
    shape: &'a dyn Shape,
    member: u32,
    primitive: u32,
}

impl<'a> Pick<'a> {
    /// The shape that has the primitive, and the instance that it is in.
    fn part(&self) -> (&'a dyn Shape, Option<&'a Instance>) {
        match self.shape.geometry() {
            Geometry::Instance(i) => (i.group().shapes()[self.member as usize].as_ref(), Some(i)),
            _ => (self.shape, None),
        }
    }
}

/// A point on a surface, as families aim at it.
struct Target {
    /// In f64, because rounded to f32 it may be a vertex: of a small triangle far from the origin, often.
    point: DVec3,
    normal: Vec3A,
    /// As a path leaves it; nothing where there is no shape.
    surface: Option<SurfacePoint>,
}

impl Generated {
    /// `count` rays around `shapes`. Without a `view`, a camera looks at all of them from a corner.
    #[must_use]
    pub fn new(shapes: &[Arc<dyn Shape>], view: Option<View>, seed: u64, count: u64) -> Self {
        let mut primitives = 0;
        let starts = shapes.iter().map(|shape| {
            let start = primitives;
            primitives += primitives_of(shape.as_ref());
            start
        });
        let starts = starts.collect();
        let bounds = shapes.iter().map(|s| s.bounds()).filter(|b| !b.is_empty());
        let bounds = bounds.reduce(Aabb::union);
        let bounds = bounds.unwrap_or(Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE });
        let half = bounds.max * 0.5 - bounds.min * 0.5;
        Self {
            shapes: shapes.to_vec(),
            starts,
            primitives,
            center: (bounds.max * 0.5 + bounds.min * 0.5).into(),
            // The half diagonal; the smallest number that divides, for a scene of one point.
            size: (half.as_dvec3().length() as f32).max(f32::MIN_POSITIVE),
            view,
            sampler: Independent::new(seed),
            moments: Independent::new(!seed),
            count,
        }
    }

    /// A point around the scene: of a cube twice as large, or ten times as large for one in four.
    fn around(&self, u: &mut Draw<'_>) -> Vec3A {
        let reach = if u.next_1d() < 0.75 { 1.0 } else { 5.0 } * self.size;
        self.center + (Vec3A::new(u.next_1d(), u.next_1d(), u.next_1d()) * 2.0 - 1.0) * reach
    }

    fn primitive(&self, u: &mut Draw<'_>) -> Option<Pick<'_>> {
        if self.primitives == 0 {
            return None;
        }
        let pick = (u.numbers.next_choice().x * self.primitives as f64) as usize;
        let pick = pick.min(self.primitives - 1);
        // Shapes without primitives start where the next one does.
        let shape = self.starts.partition_point(|&s| s <= pick) - 1;
        let mut primitive = pick - self.starts[shape];
        let shape = self.shapes[shape].as_ref();
        let mut member = 0;
        if let Geometry::Instance(instance) = shape.geometry() {
            let counts = instance.group().shapes().iter().map(|s| s.primitive_count());
            for count in counts {
                if primitive < count {
                    break;
                }
                (member, primitive) = (member + 1, primitive - count);
            }
        }
        Some(Pick { shape, member, primitive: primitive as u32 })
    }

    /// A point of a surface, uniform within a primitive that is drawn from all alike.
    fn target(&self, u: &mut Draw<'_>) -> Target {
        let pick = self.primitive(u);
        let uv = u.next_2d();
        let (point, surface) =
            pick.map_or((self.center.as_dvec3(), None), |pick| self.point_of(&pick, uv, u));
        let anywhere = || warp::square_to_uniform_sphere(uv);
        Target { point, normal: surface.map_or_else(anywhere, |s| s.geometric_normal), surface }
    }

    /// A point of a primitive at its moment, and the surface there.
    fn point_of(
        &self,
        pick: &Pick<'_>,
        uv: Vec2,
        u: &mut Draw<'_>,
    ) -> (DVec3, Option<SurfacePoint>) {
        let (part, instance) = pick.part();
        let Pick { shape, member, primitive } = *pick;
        if let Some(corners) = part.geometry().corners(primitive, u.time) {
            let b = warp::square_to_uniform_triangle(uv);
            let hit = Hit { t: 0.0, u: b.x, v: b.y, shape: 0, primitive, member };
            let [p0, p1, p2] = corners.map(|p| p.as_dvec3());
            let b = b.as_dvec2();
            let point = p0 + (p1 - p0) * b.x + (p2 - p0) * b.y;
            let point = instance.map_or(point, |i| i.to_world(u.time).transform_point3(point));
            let ray = Ray { time: u.time, ..Ray::from_exact(point, Vec3A::Z) };
            return (point, Some(shape.surface(&ray, &hit)));
        }
        let sample = part.sample_primitive(primitive as usize, self.around(u).as_dvec3(), uv);
        let surface =
            sample.map(|s| instance.map_or(s.point, |i| i.placed_point(&s.point, u.time)));
        (surface.map_or(self.center.as_dvec3(), |s| s.position), surface)
    }

    /// The corners of a triangle, beginning with any of them; a surface point thrice for other shapes.
    fn corners(&self, u: &mut Draw<'_>) -> [Vec3A; 3] {
        let pick = self.primitive(u);
        let turn = (u.next_1d() * 3.0) as usize;
        if let Some((pick, (part, instance))) = pick.map(|pick| (pick.primitive, pick.part()))
            && let Some(corners) = part.geometry().corners(pick, u.time)
        {
            let corners = [0, 1, 2].map(|i| corners[(i + turn) % 3]);
            let Some(instance) = instance else { return corners };
            let map = instance.to_world(u.time);
            return corners.map(|p| map.transform_point3(p.as_dvec3()).as_vec3a());
        }
        [self.target(u).point.as_vec3a(); 3]
    }

    fn camera(&self, u: &mut Draw<'_>) -> Ray {
        let film = u.next_2d();
        if let Some((camera, motion)) = &self.view {
            let ray = camera.ray(film.as_dvec2());
            return motion.as_ref().map_or(ray, |motion| motion.carry(&ray, u.time));
        }
        // From three half diagonals away all is within 20 degrees of the axis.
        let back = Vec3A::new(0.6, 0.5, 0.62).normalize();
        let frame = Frame::from_normal(back);
        let across = (film * 2.0 - 1.0) * 0.4;
        let direction = frame.to_world(across.extend(-1.0).into());
        Ray::new(self.center + back * (3.0 * self.size), unit(direction.as_dvec3()))
    }

    /// Never from surface to surface: faces are flat, so that many such rays would lie in one.
    fn pair(&self, u: &mut Draw<'_>) -> Ray {
        let (from, to) = match u.next_1d() {
            x if x < 0.5 => (self.around(u), self.target(u).point),
            x if x < 0.75 => (self.target(u).point.as_vec3a(), self.around(u).as_dvec3()),
            _ => (self.around(u), self.around(u).as_dvec3()),
        };
        let ray = towards(from, to);
        if u.next_1d() < 0.5 { ray.until(distance(from, to)) } else { ray }
    }

    fn bounce(&self, u: &mut Draw<'_>) -> Ray {
        let target = self.target(u);
        let up = warp::square_to_cosine_hemisphere(u.next_2d());
        let side = if u.next_1d() < 0.5 { 1.0 } else { -1.0 };
        let frame = Frame::from_normal(target.normal * side);
        let direction = unit(frame.to_world(up).as_dvec3());
        // Not spawned from the surface: engines are judged by the ray as it is in f32.
        let from = target.surface.map(|surface| surface.leave_towards(direction).0);
        Ray::new(from.unwrap_or(target.point.as_vec3a()), direction)
    }

    fn axis(&self, u: &mut Draw<'_>) -> Ray {
        let axis = (u.next_1d() * 3.0) as usize;
        let sign = |x: f32| if x < 0.5 { 1.0 } else { -1.0 };
        let mut direction =
            Vec3A::ZERO.to_array().map(|zero: f32| zero.copysign(sign(u.next_1d())));
        direction[axis] = sign(u.next_1d());
        // Each coordinate from a vertex: of one and the same for a third of the rays, which then pass
        // exactly through it, else of several; or from anywhere.
        let vertex = self.corners(u)[0];
        let kind = u.next_1d();
        let mut origin = vertex;
        if kind > 0.33 {
            for other in (0..3).filter(|&i| i != axis) {
                let from_vertex = u.next_1d() < 0.7;
                origin[other] =
                    if from_vertex { self.corners(u)[0][other] } else { self.around(u)[other] };
            }
        }
        // From outside, from the plane of a vertex, from anywhere.
        let start = u.next_1d();
        origin[axis] = if start < 0.4 {
            self.center[axis] - direction[axis] * 2.0 * self.size
        } else if start < 0.7 {
            self.corners(u)[0][axis]
        } else {
            self.around(u)[axis]
        };
        Ray::new(origin, Vec3A::from_array(direction))
    }

    fn grazing(&self, u: &mut Draw<'_>) -> Ray {
        let back = self.size * 10f32.powf(-3.0 * u.next_1d());
        let kind = u.next_1d();
        if kind < 0.25 {
            let [p, q, _] = self.corners(u);
            let along = unit(q.as_dvec3() - p.as_dvec3());
            return Ray::new(p - along * back, along);
        }
        if kind < 0.35 {
            return towards(self.target(u).point.as_vec3a(), self.target(u).point);
        }
        let target = self.target(u);
        let frame = Frame::from_normal(target.normal);
        let (sin, cos) = (f64::from(u.next_1d()) * std::f64::consts::TAU).sin_cos();
        let elevation = 10f64.powf(-7.0 * f64::from(u.next_1d()));
        let [s, t, n] = [frame.s, frame.t, frame.n].map(Vec3A::as_dvec3);
        let direction = unit((s * cos + t * sin) * elevation.cos() - n * elevation.sin());
        Ray::new(target.point.as_vec3a() - direction * back, direction)
    }

    fn inside(&self, u: &mut Draw<'_>) -> Ray {
        let target = self.target(u);
        let depth = self.size * 10f32.powf(-4.0 * u.next_1d());
        let direction = unit(warp::square_to_uniform_sphere(u.next_2d()).as_dvec3());
        Ray::new(target.point.as_vec3a() - target.normal * depth, direction)
    }

    fn far(&self, u: &mut Draw<'_>) -> Ray {
        let away = warp::square_to_uniform_sphere(u.next_2d());
        // With n triangles of about size / √n, the referee's bound of 2⁻¹⁹ of the distance is a few of them
        // wide at most: beyond, anything would be excused.
        let farthest = (2e6 / (self.primitives as f64).sqrt()).clamp(100.0, 1e6) as f32;
        let distance = self.size * 10.0 * (0.1 * farthest).powf(u.next_1d());
        let to =
            if u.next_1d() < 0.5 { self.target(u).point } else { self.corners(u)[0].as_dvec3() };
        towards(self.center + away * distance, to)
    }

    fn segment(&self, u: &mut Draw<'_>) -> Ray {
        let (from, to) = (self.around(u), self.target(u).point);
        let ray = towards(from, to);
        let t = distance(from, to);
        let (t_min, t_max) = match (u.next_1d() * 10.0) as u32 {
            0 => (ray.t_min, t * 0.999),
            1 => (ray.t_min, t * 1.001),
            2 => (ray.t_min, t),
            3 => (t * 0.999, t * 1.001),
            4 => (t * 1.001, f32::INFINITY),
            5 => (t, t),
            6 => (0.0, 1e30),
            7 => (0.0, 0.0),
            8 => (f32::MIN_POSITIVE, 1e-30),
            _ => (1e30, f32::INFINITY),
        };
        Ray { t_min, t_max, ..ray }
    }

    fn of(&self, family: Family, u: &mut Draw<'_>) -> Ray {
        match family {
            Family::Camera => self.camera(u),
            Family::Pair => self.pair(u),
            Family::Bounce => self.bounce(u),
            Family::Vertex => towards(self.around(u), self.corners(u)[0].as_dvec3()),
            Family::Edge => {
                let from = self.around(u);
                let [p, q, _] = self.corners(u).map(|p| p.as_dvec3());
                // The middle, or anywhere.
                let share = if u.next_1d() < 0.5 { 0.5 } else { u.next_1d() };
                towards(from, p.lerp(q, share.into()))
            }
            Family::Axis => self.axis(u),
            Family::Grazing => self.grazing(u),
            Family::Inside => self.inside(u),
            Family::Far => self.far(u),
            Family::Segment => self.segment(u),
        }
    }
}

impl RaySource for Generated {
    fn count(&self) -> u64 {
        self.count
    }

    fn ray(&self, index: u64) -> (Family, Ray) {
        let family = Family::ALL[(index % Family::ALL.len() as u64) as usize];
        let (pixel, sample) = ((index >> 32) as u32, index as u32);
        // Both ends of the shutter as often as the moments between.
        let moment = PathSampler::new(&self.moments, pixel, sample).next_1d();
        let time = (moment * 3.0 - 1.0).clamp(0.0, 1.0);
        let numbers = PathSampler::new(&self.sampler, pixel, sample);
        let ray = self.of(family, &mut Draw { numbers, time });
        (family, Ray { time, ..ray })
    }
}

/// Those of a group's shapes for an instance.
fn primitives_of(shape: &dyn Shape) -> usize {
    match shape.geometry() {
        Geometry::Instance(instance) => {
            instance.group().shapes().iter().map(|s| s.primitive_count()).sum()
        }
        _ => shape.primitive_count(),
    }
}

/// The half-line from one point through another, in any direction if they are one.
fn towards(from: Vec3A, to: DVec3) -> Ray {
    Ray::new(from, unit(to - from.as_dvec3()))
}

fn distance(from: Vec3A, to: DVec3) -> f32 {
    from.as_dvec3().distance(to) as f32
}

fn unit(v: DVec3) -> Vec3A {
    v.try_normalize().unwrap_or(DVec3::X).as_vec3a()
}
