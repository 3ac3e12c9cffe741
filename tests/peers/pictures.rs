//! Mitsuba 3 renders the same pictures from the same files.
//!
//! Every file of `tests/peers/scenes/` is a test; its film and its `sample_count` say how much is
//! rendered. What differs on purpose (README.md) is set in the files so that it agrees. A parameter that
//! only Telamon shall get stands in a line `<!-- telamon: NAME=VALUE ... -->`.

use std::fs;
use std::path::PathBuf;

use telamon::load::plugins::Category;

use crate::judge::{judge, means, pixels};
use crate::mitsuba::{Mitsuba, Renders};
use crate::support::pictures::{in_package, scene_files};
use crate::support::plugin_names;

/// Renders of each scene on each side.
const RUNS: u32 = 16;

fn scenes() -> Vec<PathBuf> {
    scene_files("tests/peers/scenes")
}

fn scene(name: &str) -> PathBuf {
    in_package(&format!("tests/peers/scenes/{name}.xml"))
}

/// The same renders with 2 % more light in all pixels that have noise. A lamp or a sky in full view has none
/// and would give the change away. `None` if there is hardly a noisy pixel.
fn brighter(renders: &Renders) -> Option<Renders> {
    let mut renders = renders.clone();
    let (mut noisy, mut total) = (0, 0);
    for pictures in renders.channels.values_mut() {
        for pixel in 0..pictures[0].len() {
            total += 1;
            if pictures.iter().any(|p| p[pixel] != pictures[0][pixel]) {
                noisy += 1;
                pictures.iter_mut().for_each(|p| p[pixel] *= 1.02);
            }
        }
    }
    (noisy > total / 4).then_some(renders)
}

/// Mitsuba's rule for the pixels, and the means of tiles and of whole pictures with a significance of 0.01
/// for all scenes together. In each scene, 2 % more light would be noticed.
#[test]
fn pictures_are_the_same() {
    let mut mitsuba = Mitsuba::start();
    let scenes = scenes();
    let mut failures = Vec::new();
    for path in &scenes {
        let verdict = mitsuba.renders(path, RUNS).and_then(|theirs| {
            let ours = Renders::ours(path, &[], RUNS);
            judge(&ours, &theirs, scenes.len())?;
            match brighter(&ours).map(|brighter| means(&brighter, &theirs, scenes.len())) {
                Some(Ok(())) => Err("2 % more light would not be noticed".to_owned()),
                Some(Err(_)) | None => Ok(()),
            }
        });
        failures.extend(verdict.err().map(|e| format!("{}: {e}", path.display())));
    }
    assert!(failures.is_empty(), "{} of {}\n{}", failures.len(), scenes.len(), failures.join("\n"));
}

/// What a wrong renderer would make does not pass: an albedo that is 2 % off, a picture that is shifted by a
/// pixel, and, which only tiles show, a corner that is 4 % brighter.
#[test]
fn differences_are_noticed() {
    let path = scene("bsdf-diffuse");
    let theirs = Mitsuba::start().renders(&path, RUNS).expect("renders");
    assert_eq!(judge(&Renders::ours(&path, &[], RUNS), &theirs, 1), Ok(()));
    let count = scenes().len();
    let albedo = Renders::ours(&path, &[("albedo", "0.51")], RUNS);
    assert!(means(&albedo, &theirs, count).is_err());

    let ours = Renders::ours(&path, &[], RUNS);
    let pictures = |renders: &mut Renders, edit: &dyn Fn(&mut Vec<f32>)| {
        renders.channels.values_mut().flatten().for_each(edit);
    };
    let mut shifted = ours.clone();
    pictures(&mut shifted, &|picture| picture.rotate_right(1));
    assert!(pixels(&shifted, &theirs).is_err());

    let mut spot = ours;
    let width = spot.width;
    pictures(&mut spot, &|picture| {
        let rows = picture.chunks_exact_mut(width).skip(8).take(8);
        rows.flat_map(|row| &mut row[8..16]).for_each(|value| *value *= 1.04);
    });
    assert_eq!(pixels(&spot, &theirs), Ok(()));
    assert!(means(&spot, &theirs, count).is_err());
}

/// All that a scene file can name is compared.
#[test]
fn every_element_has_a_scene() {
    let files = [scenes(), scene_files("tests/peers/scenes/parts")].concat();
    let text: String = files.iter().map(|p| fs::read_to_string(p).expect("readable")).collect();
    for category in Category::ALL {
        for name in plugin_names(category) {
            let named = [format!("type=\"{name}\""), format!("={name} ")];
            assert!(named.iter().any(|n| text.contains(n)), "no scene has {category:?} {name}");
        }
    }
}
