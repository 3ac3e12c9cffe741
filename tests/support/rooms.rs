//! Closed rooms of known radiance, and estimates in them.

use std::sync::Arc;

use glam::{DAffine3, Vec3A};
use telamon::bsdf::{Bsdf, Diffuse};
use telamon::emitter::{Area, Emitter};
use telamon::integrator::{IntegratorSettings, Roulette, RoulettePolicy, Tracer, build};
use telamon::intersect::Intersector;
use telamon::math::{Frame, Rgb, warp};
use telamon::ray::Ray;
use telamon::sampler::{Independent, PathSampler};
use telamon::scene::{Object, Scene};
use telamon::shape::{Shape, Sphere, primitives};

/// Paths that nothing ends by chance.
pub(crate) const NO_ROULETTE: Roulette =
    Roulette { policy: RoulettePolicy::None, factor: 1.0, min_depth: 0, max_survival: 0.99 };

/// Shapes that share one material, all of which emit the same radiance.
pub(crate) fn scene(shapes: Vec<Arc<dyn Shape>>, bsdf: Box<dyn Bsdf>, radiance: f32) -> Scene {
    let mut emitters: Vec<Box<dyn Emitter>> = Vec::new();
    let objects = shapes
        .into_iter()
        .map(|shape| {
            let emitter = (radiance > 0.0).then(|| {
                let area = Area::new(Arc::clone(&shape), Rgb::splat(radiance)).expect("an area");
                emitters.push(Box::new(area));
                emitters.len() - 1
            });
            object(shape, 0, emitter)
        })
        .collect();
    Scene::new(objects, vec![bsdf], emitters, None).expect("indices in range")
}

/// A shape with the indices of its material and its emitter.
pub(crate) fn object(shape: Arc<dyn Shape>, bsdf: usize, emitter: Option<usize>) -> Object {
    Object::new("", shape, bsdf, emitter)
}

/// The inside of the cube `[-1, 1]³`.
pub(crate) fn closed_cube() -> Arc<dyn Shape> {
    Arc::new(primitives::cube(DAffine3::IDENTITY, true).0)
}

/// The inside of the unit sphere.
pub(crate) fn closed_sphere() -> Arc<dyn Shape> {
    Arc::new(Sphere::new(Vec3A::ZERO, 1.0, Frame::from_normal(Vec3A::Z.into()), true))
}

/// A closed room whose walls emit 1 and have this albedo: radiance 1/(1 − albedo) everywhere.
pub(crate) fn furnace(shape: Arc<dyn Shape>, albedo: f32) -> Scene {
    scene(vec![shape], Box::new(Diffuse::new(Rgb::splat(albedo))), 1.0)
}

/// The radiance of a furnace when paths have at most `depth` edges: 1 + a + … + a^(depth − 1).
pub(crate) fn furnace_radiance(albedo: f32, depth: u32) -> f64 {
    let a = f64::from(albedo);
    (1.0 - a.powi(depth as i32)) / (1.0 - a)
}

/// Estimates of the red channel, one in a random direction from `from` for each number below `count`.
/// Every ray must be one that the engine can be asked about.
pub(crate) fn estimates(
    scene: &Scene,
    engine: &dyn Intersector,
    settings: &IntegratorSettings,
    from: Vec3A,
    count: u32,
) -> Vec<f64> {
    let (integrator, _) = build(settings, scene);
    let integrator = integrator.expect("makes a picture");
    let sampler = Independent::new(11);
    let mut tracer = Tracer::new(scene, engine);
    let values = (0..count)
        .map(|i| {
            let mut numbers = PathSampler::new(&sampler, i, 0);
            let direction = Vec3A::from(warp::square_to_uniform_sphere(numbers.next_2d().into()));
            let ray = Ray::new(from, direction);
            f64::from(integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.x)
        })
        .collect();
    assert_eq!(tracer.counts.untraceable, 0);
    values
}
