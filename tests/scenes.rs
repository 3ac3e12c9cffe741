//! The scenes that come with the program, small, on every engine.

mod support;

use std::fs;
use std::path::{Path, PathBuf};

use glam::Vec3A;
use support::meshes::{mesh, ply};
use support::pictures::{in_package, picture, read, scene_files};
use support::stats::Moments;
use telamon::intersect::Backend;
use telamon::load::{LoadOptions, load_scene};
use telamon::math::Rgb;

/// A tetrahedron about as large as the meshes that `gyroid.xml` and `ajax.xml` show, where they show
/// them; as PLY and as OBJ.
fn write_mesh(scene: &str, folder: &Path) -> Option<PathBuf> {
    let (center, size) = match scene {
        "gyroid" => ([0.0, 1.1, 0.0], 1.0),
        "ajax" => ([0.0, 18.0, -17.3], 15.0),
        _ => return None,
    };
    // Counter-clockwise from outside.
    let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
    let faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    let corners = corners.map(|c| [0, 1, 2].map(|i| (center[i] + size * f64::from(c[i])) as f32));
    let text = if scene == "gyroid" {
        ply(&mesh(corners.map(Vec3A::from).into(), faces.into()))
    } else {
        let corners = corners.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
        let faces = faces.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).concat();
        format!("{corners}{faces}")
    };
    let path = folder.join(scene);
    fs::write(&path, text).expect("writable");
    Some(path)
}

/// Names without the ending, sorted.
fn scenes() -> Vec<String> {
    let name = |path: PathBuf| Some(path.file_stem()?.to_str()?.to_owned());
    scene_files("scenes").into_iter().filter_map(name).collect()
}

/// How many of the pixels differ by more than `tolerance` of their brightest channel.
fn count_apart(a: &[Rgb], b: &[Rgb], tolerance: f32) -> usize {
    let apart = |(a, b): (&Rgb, &Rgb)| {
        let scale = a.abs().max(b.abs()).max_element();
        (*a - *b).abs().max_element() > tolerance * scale
    };
    a.iter().zip(b).filter(|&pair| apart(pair)).count()
}

/// Student's paired test that two pictures have the same mean, as one of `checks`.
fn same_mean(a: &[Rgb], b: &[Rgb], checks: usize) -> Result<(), String> {
    let brightness = |c: &Rgb| f64::from(c.element_sum() / 3.0);
    let mean = Moments::of(a.iter().map(brightness)).mean();
    let pairs = a.iter().zip(b).map(|(a, b)| mean + brightness(b) - brightness(a));
    // Around the mean and not around 0, so that roundings are forgiven in proportion to it.
    Moments::of(pairs).has_mean(mean, checks)
}

/// Each scene renders on each engine, and with equal random numbers engines differ in few pixels.
///
/// Both rebuild positions from barycentrics that are good to some 2⁻²². Each bounce multiplies a
/// difference by about the ratio of the distances before and after it, so that 2⁻¹⁰ leaves 12 bits for
/// that. What is larger comes from a ray that passes an edge on one engine and not on the other. The
/// edges of these scenes have a total length below a hundred times the width of the picture, and engines
/// place them to 2⁻²⁰ of it: of fewer than 2¹⁷ rays (3072 samples of 40 rays) some 2¹⁷ · 100 · 2⁻²⁰ = 12
/// are in doubt, and each spoils one of 768 pixels. The means agree in Student's paired test.
#[test]
fn every_scene_renders_alike_on_every_engine() {
    const TOLERANCE: f32 = 1.0 / 1024.0;
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = scenes();
    assert!(scenes.len() >= 6, "{scenes:?}");
    for scene in &scenes {
        let mesh = write_mesh(scene, folder.path());
        let mut defines = vec![("resx", "32"), ("resy", "24"), ("spp", "4")];
        if let Some(path) = &mesh {
            defines.push(("mesh", path.to_str().expect("a plain name")));
        }
        let description = read(&in_package(&format!("scenes/{scene}.xml")), &defines);
        let pictures: Vec<_> = Backend::AVAILABLE
            .iter()
            .map(|&backend| picture(&description, backend).radiance())
            .collect();
        for pixels in &pictures {
            assert!(pixels.iter().all(|p| p.is_finite() && p.min_element() >= 0.0), "{scene}");
            assert!(pixels.iter().sum::<Rgb>().min_element() > 0.0, "{scene} is black");
        }
        for other in &pictures[1..] {
            let apart = count_apart(&pictures[0], other, TOLERANCE);
            assert!(apart <= 12, "{scene}: {apart} pixels differ");
            same_mean(&pictures[0], other, scenes.len())
                .unwrap_or_else(|figures| panic!("{scene}: {figures}"));
        }
        // One hundredth more light is noticed.
        let brighter: Vec<_> = pictures[0].iter().map(|p| 1.01 * *p).collect();
        assert!(same_mean(&pictures[0], &brighter, scenes.len()).is_err(), "{scene}");
        assert!(count_apart(&pictures[0], &brighter, TOLERANCE) > 12, "{scene}");
        // Another seed is another picture: the comparison can fail.
        let mut other = description;
        other.sampler.seed += 1;
        let other = picture(&other, Backend::default()).radiance();
        let apart = count_apart(&pictures[0], &other, TOLERANCE);
        assert!(apart > 32 * 24 / 5, "{scene}: another seed changes only {apart} pixels");
    }
}

/// In the furnace every pixel is 1/(1 − albedo): Student's test of each over 16 pictures of unrelated
/// seeds. A sample is skewed as a geometric series is, by about 2; the mean of 64 by a quarter, which
/// the test bears.
#[test]
fn the_furnace_has_one_radiance() {
    const SIDE: usize = 12;
    for (albedo, expected) in [("0.5", 2.0), ("0.8", 5.0)] {
        let defines = [("albedo", albedo), ("resx", "12"), ("resy", "12"), ("spp", "64")];
        let mut description = read(&in_package("scenes/furnace.xml"), &defines);
        for &backend in Backend::AVAILABLE {
            let pictures: Vec<_> = (1..=16)
                .map(|seed| {
                    description.sampler.seed = seed;
                    picture(&description, backend).radiance()
                })
                .collect();
            let checks = 4 * (SIDE * SIDE + 1);
            for pixel in 0..SIDE * SIDE {
                Moments::of(pictures.iter().map(|p| f64::from(p[pixel].x)))
                    .has_mean(expected, checks)
                    .unwrap_or_else(|figures| panic!("{backend}, {albedo}, {pixel}: {figures}"));
            }
            let all = Moments::of(pictures.iter().flatten().map(|p| f64::from(p.x)));
            all.has_mean(expected, checks).unwrap_or_else(|f| panic!("{backend}, {albedo}: {f}"));
            // 1 % more or less light is noticed.
            assert!(all.has_mean(1.01 * expected, 1).is_err(), "{all:?}");
            assert!(all.has_mean(0.99 * expected, 1).is_err(), "{all:?}");
        }
    }
}

#[test]
fn missing_meshes_say_where_people_get_them() {
    let folder = tempfile::tempdir().expect("a folder");
    for (scene, help) in [("ajax", "https://wjakob.github.io/nori/"), ("gyroid", "`sculpt`")] {
        let path = folder.path().join(format!("{scene}.xml"));
        fs::copy(in_package(&format!("scenes/{scene}.xml")), &path).expect("writable");
        let error = load_scene(&path, &LoadOptions::default()).expect_err("there is no mesh");
        let [problem] = error.problems() else { panic!("{error}") };
        let message = format!("there is no file `meshes/{scene}.");
        assert!(problem.message.starts_with(&message), "{problem}");
        assert!(problem.help.as_ref().is_some_and(|h| h.contains(help)), "{problem:?}");
    }
}
