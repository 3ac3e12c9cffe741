//! The limit: what the path tracer adds to bare Embree.
//!
//! Records the rays that a render of a scene really traces, then traces the recorded rays with bare
//! Embree calls from C on the same number of threads, and compares the two, interleaved.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use embree_sys::bare;
use rayon::prelude::*;
use telamon::intersect::{Backend, Intersector};
use telamon::ray::{Hit, Ray};
use telamon::render::render;
use telamon::scene::Description;
use telamon::shape::{Geometry, Shape};

/// Interleaved runs of each side.
const RUNS: usize = 9;

/// Passes rays on to an engine and keeps them.
#[derive(Debug)]
struct Recorder<'a> {
    engine: &'a dyn Intersector,
    queries: Mutex<Vec<bare::Query>>,
}

impl Recorder<'_> {
    fn record(&self, ray: &Ray, occlusion: bool) {
        let query = bare::Query {
            origin: ray.origin.into(),
            t_min: ray.t_min,
            direction: ray.direction.into(),
            t_max: ray.t_max,
            occlusion: occlusion.into(),
        };
        self.queries.lock().unwrap_or_else(PoisonError::into_inner).push(query);
    }
}

impl Intersector for Recorder<'_> {
    fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.record(ray, false);
        self.engine.closest_hit(ray)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.record(ray, true);
        self.engine.occluded(ray)
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        rays.iter().for_each(|ray| self.record(ray, false));
        self.engine.closest_hits(rays, hits);
    }

    fn occluded_many(&self, rays: &[Ray], occluded: &mut [bool]) {
        rays.iter().for_each(|ray| self.record(ray, true));
        self.engine.occluded_many(rays, occluded);
    }

    fn bytes(&self) -> usize {
        self.engine.bytes()
    }

    fn name(&self) -> String {
        self.engine.name()
    }
}

/// Vertices with their padding, as C reads them.
fn buffers(shapes: &[Arc<dyn Shape>]) -> Vec<(Vec<[f32; 4]>, Vec<[u32; 3]>)> {
    shapes
        .iter()
        .map(|shape| match shape.geometry() {
            Geometry::Triangles { positions, triangles } => {
                (positions.iter().map(|p| p.extend(0.0).to_array()).collect(), triangles.to_vec())
            }
            Geometry::Analytic(shape) => panic!("{shape:?}: bare Embree knows meshes only"),
        })
        .collect()
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    std::hint::black_box(work());
    start.elapsed().as_secs_f64()
}

fn measure(name: &str, description: &Description) {
    let shapes = description.scene.shapes();
    let engine = telamon::intersect::build(Backend::Embree, &shapes).expect("builds");
    let cancel = AtomicBool::new(false);
    let trace = |engine: &dyn Intersector| render(description, engine, &|_| (), &cancel).1;

    let recorder = Recorder { engine: engine.as_ref(), queries: Mutex::default() };
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let statistics = one_thread.install(|| trace(&recorder));
    let queries = recorder.queries.into_inner().unwrap_or_else(PoisonError::into_inner);

    let buffers = buffers(&shapes);
    let meshes: Vec<_> =
        buffers.iter().map(|(positions, triangles)| bare::Mesh { positions, triangles }).collect();
    let threads = rayon::current_num_threads();
    let scene = bare::Scene::new(&meshes, threads);
    let bare = || queries.par_chunks(1 << 14).map(|chunk| scene.trace(chunk)).sum::<usize>();

    let mut times = [Vec::new(), Vec::new(), Vec::new()];
    for run in 0..=RUNS {
        let ours = seconds(|| trace(engine.as_ref()));
        let limit = seconds(bare);
        // The first run warms the caches.
        if run > 0 {
            times[0].push(ours);
            times[1].push(limit);
            times[2].push(ours / limit);
        }
    }
    let [ours, limit, ratio] = times.each_mut().map(|t| median(t));
    let paths = statistics.samples as f64;
    println!(
        "{name}: {:.2} + {:.2} rays a path, {threads} threads, {RUNS} runs; medians: ours {:.2} Mpaths/s, \
         bare {:.2} Mpaths/s, ratio of times {ratio:.3} ({:.3} to {:.3})",
        statistics.rays.closest as f64 / paths,
        statistics.rays.occlusion as f64 / paths,
        paths / ours / 1e6,
        paths / limit / 1e6,
        times[2][0],
        times[2][RUNS - 1],
    );
    let mut ratios: Vec<_> = (0..RUNS)
        .map(|_| {
            let ours =
                seconds(|| telamon::intersect::build(Backend::Embree, &shapes).expect("builds"));
            ours / seconds(|| bare::Scene::new(&meshes, threads))
        })
        .collect();
    println!("{name}: build through our wrapper over a bare one: {:.3}", median(&mut ratios));
}

fn main() {
    use glam::*;
    use telamon::scene::{settings::*, *};
    use telamon::{bsdf::*, camera::*, emitter::*, shape::*};
    let data = std::fs::read("/tmp/peer/dragon.bin").unwrap();
    let u = |i: usize| u32::from_le_bytes(data[i * 4..i * 4 + 4].try_into().unwrap());
    let f = |i: usize| f32::from_bits(u(i));
    let (nv, nf) = (u(0) as usize, u(1) as usize);
    let positions = (0..nv).map(|i| Vec3A::new(f(2 + 3 * i), f(3 + 3 * i), f(4 + 3 * i))).collect();
    let b = 2 + 3 * nv;
    let tris = (0..nf).map(|i| [u(b + 3 * i), u(b + 3 * i + 1), u(b + 3 * i + 2)]).collect();
    let mesh: Arc<dyn Shape> =
        Arc::new(TriangleMesh::new(positions, tris, vec![], vec![]).unwrap().0);
    let floor: Arc<dyn Shape> = Arc::new(
        primitives::rectangle(
            DAffine3::from_translation(dvec3(0., 5.27, 0.))
                * DAffine3::from_rotation_x(-std::f64::consts::FRAC_PI_2)
                * DAffine3::from_scale(dvec3(60., 60., 60.)),
            false,
        )
        .0,
    );
    let light: Arc<dyn Shape> = Arc::new(
        primitives::rectangle(
            DAffine3::from_translation(dvec3(0., 50., 0.))
                * DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2)
                * DAffine3::from_scale(dvec3(10., 10., 10.)),
            false,
        )
        .0,
    );
    let emitters: Vec<Box<dyn Emitter>> =
        vec![Box::new(Area::new(light.clone(), Vec3::splat(10.)).unwrap())];
    let with_floor = std::env::args().any(|a| a == "floor");
    let mut objects = vec![
        Object { name: "dragon".into(), shape: mesh, bsdf: 0, emitter: None },
        Object { name: "light".into(), shape: light, bsdf: 0, emitter: Some(0) },
    ];
    if with_floor {
        objects.push(Object { name: "floor".into(), shape: floor, bsdf: 0, emitter: None });
    }
    let scene = Scene::new(objects, vec![Box::new(Diffuse::new(Vec3::splat(0.7)))], emitters, None)
        .unwrap();
    let eye = dvec3(-5., 18., 25.);
    let fw = (dvec3(-0.6, 12., 0.) - eye).normalize();
    let left = DVec3::Y.cross(fw).normalize();
    let up = fw.cross(left);
    let camera = Perspective::new(&PerspectiveSettings {
        to_world: DAffine3::from_cols(left, up, fw, eye),
        fov_x_deg: 45.,
        aspect: 1.,
        principal_point_offset: Vec2::ZERO,
        near_clip: 0.,
        far_clip: f32::INFINITY,
    })
    .unwrap();
    let d = Description {
        scene,
        camera,
        film: FilmSettings {
            width: 512,
            height: 512,
            crop: Crop { x: 0, y: 0, width: 512, height: 512 },
            filter: Filter::Box,
            alpha: false,
            component: ComponentFormat::Half,
        },
        sampler: SamplerSettings { kind: SamplerKind::Independent, samples_per_pixel: 8, seed: 0 },
        integrator: IntegratorSettings::Path(PathSettings {
            max_depth: Some(8),
            ..PathSettings::default()
        }),
    };
    measure("dragon", &d);
}
