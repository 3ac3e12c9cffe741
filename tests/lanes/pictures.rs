//! Whole pictures of the scenes that come with the program: eight lanes at each level, and each path by itself.

use std::fs;

use glam::{DVec2, DVec3};
use telamon::integrator::{self, Estimate, Sample, Tracer};
use telamon::intersect::{self, Backend};
use telamon::math::real::Level;
use telamon::render::Description;
use telamon::sampler::{self, PathSampler, Sampler};

use crate::support::meshes::{ply, sphere_mesh};
use crate::support::pictures::{read, scene_files};

/// The samples of a picture of 12 x 9 pixels, three each, row by row.
fn samples<'s>(
    description: &'s Description,
    sampler: &'s dyn Sampler,
) -> impl Iterator<Item = Sample<'s>> {
    (0..12 * 9 * 3u32).map(move |i| {
        let pixel = i / 3;
        let mut numbers = PathSampler::new(sampler, pixel, i % 3);
        let corner = DVec2::new((pixel % 12).into(), (pixel / 12).into());
        let film = (corner + numbers.next_2d().as_dvec2()) / DVec2::new(12.0, 9.0);
        let ray = description.camera.ray_through_lens(film, numbers.next_2d());
        Sample { ray, sampler: numbers }
    })
}

fn bits(estimates: &[Estimate]) -> Vec<[u32; 4]> {
    let bits = |e: &Estimate| {
        let [r, g, b] = e.radiance.to_array();
        [r, g, b, e.alpha].map(f32::to_bits)
    };
    estimates.iter().map(bits).collect()
}

#[test]
fn pictures_have_one_form() {
    let folder = tempfile::tempdir().expect("a folder");
    // In the place of the meshes that are not part of the package.
    let mesh = folder.path().join("ball.ply");
    let ball = sphere_mesh(DVec3::new(0.0, 1.1, 0.0), 1.0, 6, 9);
    fs::write(&mesh, ply(&ball)).expect("writable");
    let mesh = mesh.to_str().expect("UTF-8");
    let mut pictures = 0;
    for path in scene_files("scenes") {
        let text = fs::read_to_string(&path).expect("readable");
        // That of `ajax.xml` has to be an OBJ file.
        if text.contains("ajax.obj") {
            continue;
        }
        let defines: &[_] = if text.contains("name=\"mesh\"") { &[("mesh", mesh)] } else { &[] };
        let description = read(&path, defines);
        let (integrator, _) = integrator::build(&description.integrator, &description.scene);
        let integrator = integrator.expect("makes a picture");
        let sampler = sampler::build(&description.sampler);
        for &backend in Backend::AVAILABLE {
            let shapes = description.scene.shapes();
            let engine = intersect::build(backend, &shapes).expect("builds");
            let tracer = || Tracer::new(&description.scene, engine.as_ref());
            let together = |level: Level| {
                let mut estimates = Vec::new();
                integrator.estimates(
                    &mut tracer().at_level(level),
                    &mut samples(&description, sampler.as_ref()),
                    &mut |estimate, _| estimates.push(estimate),
                );
                bits(&estimates)
            };
            let mut tracer = tracer();
            let alone: Vec<_> = samples(&description, sampler.as_ref())
                .map(|mut s| integrator.estimate(&mut tracer, &s.ray, &mut s.sampler))
                .collect();
            let lit = alone.iter().filter(|estimate| estimate.radiance.max_element() > 0.0).count();
            assert!(lit > 50, "{}: {lit} samples have light", path.display());
            for level in [Level::baseline(), Level::detect()] {
                assert!(together(level) == bits(&alone), "{} {backend} {level:?}", path.display());
            }
            pictures += 1;
        }
    }
    assert!(pictures >= 5 * Backend::AVAILABLE.len(), "{pictures}");
}
