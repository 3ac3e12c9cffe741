//! Surfaces that rays meet, the rays that leave them, and light that is to arrive there.

use std::array;
use std::f32::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, Mat3A, Vec3A};
use telamon::emitter::spot::SpotSettings;
use telamon::emitter::{
    Area, ChoicePolicy, Constant, Directional, Emitter, EmitterChoice, EmitterSample, LightOrigin,
    Point, Receiver, Receivers, Spot,
};
use telamon::intersect::{self, Backend};
use telamon::math::real::{Lanes, Level, Mask, Simd, Task, f32x8, f64x8};
use telamon::math::vector::{Vec2, Vec3};
use telamon::math::{Frame, Rgb, warp};
use telamon::ray::{Hit, Ray, RayEnd, Rays};
use telamon::shape::{
    Arrivals, Cylinder, DeformingMesh, Disk, Group, Instance, Interaction, Shape, Sphere,
    SurfacePoint, TriangleMesh, primitives,
};
use telamon::texture::Textured;

use crate::support::lights::{lights, sphere, square};
use crate::support::meshes::sphere_mesh;
use crate::support::points;

/// All of a ray, in bits.
fn ray_bits(ray: &Ray) -> impl PartialEq + std::fmt::Debug + use<> {
    let end = |end: Option<RayEnd>| {
        end.map(|end| {
            let point = end.point.to_array().map(f64::to_bits);
            (point, end.normal.to_array().map(f32::to_bits), end.side, end.inward)
        })
    };
    let (o, d) = (ray.origin, ray.direction);
    let numbers = [o.x, o.y, o.z, d.x, d.y, d.z, ray.t_min, ray.t_max, ray.time];
    (numbers.map(f32::to_bits), end(ray.start), end(ray.end))
}

/// All of a surface, in bits.
fn surface_bits(surface: &SurfacePoint) -> impl PartialEq + std::fmt::Debug + use<> {
    let SurfacePoint { position, parameters, geometric_normal, shading_normal, near_edge, time } =
        *surface;
    let numbers = [geometric_normal, shading_normal].map(|n| n.to_array().map(f32::to_bits));
    (
        position.to_array().map(f64::to_bits),
        parameters.to_array().map(f32::to_bits),
        numbers,
        near_edge.map(|edge| (edge.shift.to_array().map(f32::to_bits), edge.inward)),
        time.to_bits(),
    )
}

fn at(x: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, 0.0, 0.0))
}

/// Shapes of all kinds, with vertex normals and without, at rest and moving.
fn shapes() -> Vec<Arc<dyn Shape>> {
    let ball = sphere_mesh(DVec3::ZERO, 1.0, 12, 24);
    let normals = ball.positions().iter().map(|p| glam::Vec3::from(*p)).collect();
    let smooth = TriangleMesh::new(
        ball.positions().to_vec(),
        ball.triangles().to_vec(),
        normals,
        Vec::new(),
    );
    let smooth = smooth.expect("valid").0;
    let moved = sphere_mesh(DVec3::new(0.0, 0.4, 0.0), 1.1, 12, 24);
    let keys = vec![(0.0, Arc::new(ball.clone())), (1.0, Arc::new(moved))];
    let group = Group::new(vec![Arc::new(smooth.clone()) as Arc<dyn Shape>]).expect("not empty");
    let instance = Instance::new(Arc::new(group), DAffine3::from_rotation_x(0.3));
    let axes = Frame::from_normal(Vec3::new(0.0, 0.0, 1.0));
    vec![
        Arc::new(ball),
        Arc::new(smooth),
        Arc::new(DeformingMesh::new(keys).expect("valid")),
        Arc::new(instance.expect("valid")),
        Arc::new(Sphere::new(Vec3A::ZERO, 1.0, axes, false)),
        Arc::new(Disk::new(at(0.0), false).expect("not singular")),
        Arc::new(primitives::cube(at(0.0), false).0),
        Arc::new(
            Cylinder::new(DVec3::NEG_Y, [DVec3::X, DVec3::Z, DVec3::Y * 2.0], false)
                .expect("has an area"),
        ),
    ]
}

/// Rays at the shapes, some of them at corners and edges, at all moments.
fn rays() -> Vec<Ray> {
    let ray = |(i, (from, to)): (usize, (glam::Vec2, glam::Vec2))| {
        let origin = Vec3A::from(warp::square_to_uniform_sphere(from.into())) * 4.0;
        let mut target = Vec3A::from(warp::square_to_uniform_sphere(to.into())) * 0.9;
        if i % 4 == 0 {
            // Corners and edges of the cube, and poles.
            target = target.signum() * Vec3A::new(1.0, 1.0, to.x.round());
        }
        Ray { time: to.y, ..Ray::new(origin, (target - origin).normalize()) }
    };
    points(70, 4000).zip(points(71, 4000)).enumerate().map(ray).collect()
}

/// Eight surfaces and the rays that leave them.
#[derive(Clone, Copy)]
struct Meet<'a> {
    shape: &'a dyn Shape,
    rays: &'a [Ray; 8],
    hits: &'a [Hit; 8],
    directions: [Vec3; 8],
}

impl Task for Meet<'_> {
    type Output = [(SurfacePoint, Ray); 8];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let all = Rays::from_iter(self.rays);
        let numbers: [usize; 8] = array::from_fn(|i| i);
        let (origin, direction, time) = all.gather::<f32x8<S>>(simd, &numbers);
        let shapes = [self.shape; 8];
        let arrivals = Arrivals { shapes, hits: *self.hits, origin, direction, time };
        let interaction = Interaction::new(&arrivals, |i| self.rays[i]);
        let leaving = interaction.spawn(Vec3::load(simd, &self.directions));
        // By way of the columns, of the lanes from the last on.
        let mut columns = Rays::default();
        for lane in (0..8).rev() {
            columns.append(f32x8::<S>::mask(simd, |i| i == lane), &leaving);
        }
        array::from_fn(|i| {
            assert_eq!(ray_bits(&columns.get(7 - i)), ray_bits(&leaving.lane(i)));
            (interaction.lane(i), leaving.lane(i))
        })
    }
}

#[test]
fn surfaces_and_the_rays_that_leave_them_have_one_form() {
    let (rays, mut near_edges) = (rays(), 0);
    for shape in shapes() {
        let engine = intersect::build(Backend::Rust, std::slice::from_ref(&shape)).expect("builds");
        let met = rays.iter().filter_map(|ray| Some((*ray, engine.closest_hit(ray)?)));
        let met: Vec<_> = met.collect();
        assert!(met.len() > 500, "{}: {}", shape.kind(), met.len());
        for (turn, met) in met.as_chunks::<8>().0.iter().enumerate() {
            let (rays, hits) = (met.map(|(ray, _)| ray), met.map(|(_, hit)| hit));
            let directions = points(72 + turn as u64, 8)
                .map(|u| warp::square_to_uniform_sphere(Vec2::from(u)))
                .collect::<Vec<_>>();
            let directions: [Vec3; 8] = directions.try_into().expect("eight");
            for level in [Level::baseline(), Level::detect()] {
                let task = Meet { shape: shape.as_ref(), rays: &rays, hits: &hits, directions };
                for (lane, (surface, leaving)) in level.run(task).into_iter().enumerate() {
                    let mut alone = shape.surface(&rays[lane], &hits[lane]);
                    alone.time = rays[lane].time;
                    let name = shape.kind();
                    assert_eq!(surface_bits(&surface), surface_bits(&alone), "{name} {level:?}");
                    let spawned = alone.spawn(directions[lane].into());
                    assert_eq!(ray_bits(&leaving), ray_bits(&spawned), "{name} {level:?}");
                    near_edges += u32::from(alone.near_edge.is_some());
                }
            }
        }
    }
    assert!(near_edges > 100, "{near_edges}");
}

/// Eight samples of light by a choice among emitters, and the shadow rays.
#[derive(Clone, Copy)]
struct Light<'a> {
    choice: &'a EmitterChoice,
    emitters: &'a [Box<dyn Emitter>],
    from: [SurfacePoint; 8],
    u: [DVec2; 8],
}

type Lit = [Option<(EmitterSample, Option<Ray>)>; 8];

impl Task for Light<'_> {
    type Output = Lit;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Lit {
        let Self { choice, emitters, from, u } = self;
        let double = |of: &dyn Fn(usize) -> f64| f64x8::from_fn(simd, of);
        let receivers = Receivers::<f32x8<S>> {
            position: Vec3::from_fn(simd, |i| from[i].position.into()),
            normal: Vec3::from_fn(simd, |i| from[i].geometric_normal.into()),
            both_sides: f32x8::mask(simd, |_| true),
            is_diffuse: f32x8::mask(simd, |i| i % 2 == 0),
        };
        let u = Vec2::new(double(&|i| u[i].x), double(&|i| u[i].y));
        let wanted = f32x8::mask(simd, |_| true);
        let samples = choice.sample_toward_each(emitters, &receivers, u, wanted);
        let interaction = Interaction::<f32x8<S>> {
            position: receivers.position,
            parameters: Vec2::from_fn(simd, |i| from[i].parameters.into()),
            geometric_normal: receivers.normal,
            shading_normal: receivers.normal,
            is_near_edge: f32x8::mask(simd, |_| false),
            near_edge: [None; 8],
            time: f32x8::splat(simd, 0.25),
        };
        let shadows = samples.shadow_rays(&interaction);
        assert_eq!(samples.exists.bits() & shadows.exists.bits(), shadows.exists.bits());
        array::from_fn(|i| samples.lane(i).map(|sample| (sample, shadows.lane(i))))
    }
}

fn sample_bits(sample: &EmitterSample) -> impl PartialEq + std::fmt::Debug + use<> {
    let EmitterSample { direction: d, weight: w, pdf, origin } = *sample;
    let numbers = [d.x, d.y, d.z, w.x, w.y, w.z, pdf].map(f32::to_bits);
    let (kind, point) = match origin {
        LightOrigin::Infinity => (0, DVec3::ZERO),
        LightOrigin::Point(point) => (1, point.as_dvec3()),
        LightOrigin::Surface(end) => (2, end.point),
    };
    (numbers, kind, point.to_array().map(f64::to_bits))
}

#[test]
fn light_has_one_form() {
    // Each light of the table alone, and all kinds together.
    let mut rooms: Vec<Vec<Box<dyn Emitter>>> = lights()
        .into_iter()
        .map(|light| {
            vec![Box::new(Area::new(light.shape, Rgb::ONE).expect("an area")) as Box<dyn Emitter>]
        })
        .collect();
    let area = |shape: Arc<dyn Shape>| Area::new(shape, Rgb::new(1.0, 2.0, 3.0)).expect("an area");
    let point = || Point::new(Vec3A::new(1.0, 1.0, 1.0), Rgb::ONE);
    let spot = || {
        Spot::new(SpotSettings {
            position: Vec3A::new(0.2, -0.1, 2.0),
            axes: Mat3A::from_rotation_x(PI),
            intensity: Rgb::new(3.0, 2.0, 1.0),
            cutoff_angle: 0.25,
            beam_width: 0.1,
            texture: Textured::Uniform(Rgb::ONE),
        })
    };
    let directional = || Directional::new(Vec3A::NEG_Z, Rgb::ONE);
    let constant = || Constant::new(Rgb::new(0.5, 0.6, 0.7));
    // So many parts that they are in a tree.
    rooms.push(vec![
        Box::new(area(square(0.5, Vec3A::Z))),
        Box::new(area(sphere(Vec3A::new(0.0, 3.0, 1.0), 0.3))),
        Box::new(area(Arc::new(sphere_mesh(DVec3::new(2.0, 0.0, 1.0), 0.3, 6, 9)))),
        Box::new(point()),
        Box::new(directional()),
    ]);
    // So few that they are in a list; one of them the receivers are within.
    rooms.push(vec![
        Box::new(area(square(0.5, Vec3A::Z))),
        Box::new(area(sphere(Vec3A::new(0.0, 3.0, 1.0), 0.3))),
        Box::new(area(sphere(Vec3A::new(0.4, 0.4, 0.0), 0.2))),
        Box::new(area(Arc::new(primitives::cube(at(3.0), false).0))),
        Box::new(spot()),
        Box::new(point()),
        Box::new(constant()),
    ]);
    rooms.push(vec![Box::new(point())]);
    rooms.push(vec![Box::new(spot())]);
    rooms.push(vec![Box::new(directional())]);
    rooms.push(vec![Box::new(constant())]);
    let mut lit = 0;
    for (room, emitters) in rooms.iter().enumerate() {
        for policy in [ChoicePolicy::Uniform, ChoicePolicy::Power, ChoicePolicy::Bvh] {
            let choice = EmitterChoice::new(policy, emitters);
            let places: Vec<_> = points(73, 200).zip(points(74, 200)).collect();
            for places in places.as_chunks::<8>().0 {
                let from = places.map(|(at, _)| SurfacePoint {
                    position: DVec3::new((at.x - 0.5).into(), (at.y - 0.5).into(), 0.0),
                    parameters: at,
                    geometric_normal: Vec3A::Z,
                    shading_normal: Vec3A::Z,
                    near_edge: None,
                    time: 0.25,
                });
                let u = places.map(|(_, u)| u.as_dvec2());
                for level in [Level::baseline(), Level::detect()] {
                    let task = Light { choice: &choice, emitters, from, u };
                    for (lane, found) in level.run(task).into_iter().enumerate() {
                        let receiver = Receiver {
                            position: from[lane].position,
                            normal: Vec3A::Z,
                            both_sides: true,
                            is_diffuse: lane % 2 == 0,
                        };
                        let alone = choice.sample_toward(emitters, &receiver, u[lane]);
                        let shadow = alone.map(|sample| sample.shadow_ray(&from[lane]));
                        let (sample, ray) = found.unzip();
                        let name = format!("{room} {policy:?} {level:?}");
                        let bits = |sample: Option<EmitterSample>| sample.as_ref().map(sample_bits);
                        assert_eq!(bits(sample), bits(alone), "{name}");
                        let bits = |ray: Option<Option<Ray>>| ray.flatten().as_ref().map(ray_bits);
                        assert_eq!(bits(ray), bits(shadow), "{name}");
                        lit += usize::from(sample.is_some());
                    }
                }
            }
        }
    }
    assert!(lit > 10_000, "{lit}");
}
