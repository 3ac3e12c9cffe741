//! One sample by itself: the same as among all others, and followed edge by edge.

use telamon::film::Crop;
use telamon::integrator::{IntegratorSettings, MisHeuristic, PathSettings, Strategy};
use telamon::intersect::recorder::Answer;
use telamon::intersect::{self, Backend};
use telamon::math::Rgb;
use telamon::render::{Description, SampleId, trace};

use crate::support::pictures::{in_package, picture, read};

/// The mean of a pixel's samples, each followed by itself, is the pixel, in a crop as on the whole film; and a
/// path's first edges do not change when it goes on.
#[test]
fn samples_are_the_same_by_themselves() {
    let scene = in_package("scenes/cornell-glass.xml");
    let mut description = read(&scene, &[("spp", "16"), ("resx", "32"), ("resy", "32")]);
    let shapes = description.scene.shapes();
    for &backend in Backend::AVAILABLE {
        description.film.crop = Crop { x: 0, y: 0, width: 32, height: 32 };
        let whole = picture(&description, backend).radiance();
        for (x, y) in [(5, 27), (16, 16), (20, 24)] {
            description.film.crop = Crop { x, y, width: 1, height: 1 };
            let pixel = picture(&description, backend).radiance()[0];
            assert_eq!(whole[(y * 32 + x) as usize], pixel, "{backend}: a crop of {x}, {y}");
            let engine = intersect::build(backend, &shapes).expect("builds");
            let mut sum = glam::DVec3::ZERO;
            for sample in 0..16 {
                let id = SampleId { x, y, sample, seed: description.sampler.seed };
                let traced = trace(&description, engine.as_ref(), id).expect("a path tracer");
                sum += traced.estimate.radiance.as_dvec3();
                let first = &traced.edges[0];
                assert!(matches!(first.queries[..], [q] if matches!(q.answer, Answer::Closest(_))));
                let brighter = traced
                    .edges
                    .windows(2)
                    .all(|e| e[1].radiance.cmpge(e[0].radiance).all() && e[1].queries.len() <= 2);
                assert!(brighter, "{traced:?}");
                let last = traced.edges.last().expect("an edge");
                assert_eq!(last.radiance, traced.estimate.radiance);
            }
            assert_eq!((sum / 16.0).as_vec3a(), Rgb::from(pixel), "{backend}: {x}, {y}");
        }
    }
}

/// What a pool of paths finds is what each path finds by itself, to the last bit: in every pixel, of all kinds of surfaces
/// and lights, however paths end and split, and also where the pool is not full.
#[test]
fn paths_do_not_know_of_each_other() {
    let variants: [(&str, PathSettings); 6] = [
        ("furnace", PathSettings::default()),
        ("materials", PathSettings::default()),
        ("veach-mis", PathSettings { hide_emitters: true, ..PathSettings::default() }),
        ("cornell-glass", PathSettings { emitter_samples: 3, ..PathSettings::default() }),
        (
            "cornell-glass",
            PathSettings {
                bsdf_samples: 2,
                strategy: Strategy::Mis(MisHeuristic::Balance),
                ..PathSettings::default()
            },
        ),
        (
            "cornell-box",
            PathSettings {
                strategy: Strategy::Emitter,
                max_depth: Some(4),
                ..PathSettings::default()
            },
        ),
    ];
    for (name, settings) in variants {
        let scene = in_package(&format!("scenes/{name}.xml"));
        let mut description = read(&scene, &[("spp", "3"), ("resx", "13"), ("resy", "11")]);
        description.integrator = IntegratorSettings::Path(settings);
        for &backend in Backend::AVAILABLE {
            let together = picture(&description, backend).radiance();
            assert_eq!(together, one_by_one(&description, backend), "{name} on {backend}");
        }
    }
}

/// The mean of the samples of each pixel, row by row.
fn one_by_one(description: &Description, backend: Backend) -> Vec<Rgb> {
    let engine = intersect::build(backend, &description.scene.shapes()).expect("builds");
    let Crop { width, height, .. } = description.film.crop;
    let spp = description.sampler.samples_per_pixel;
    let pixel = |x, y| {
        let sum: glam::DVec3 = (0..spp)
            .map(|sample| SampleId { x, y, sample, seed: description.sampler.seed })
            .filter_map(|id| trace(description, engine.as_ref(), id))
            .map(|traced| traced.estimate.radiance.as_dvec3())
            .sum();
        (sum / f64::from(spp)).as_vec3a()
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect()
}
