//! Scenes rendered through the library.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use telamon::film::Film;
use telamon::intersect::{self, Backend};
use telamon::load::{LoadOptions, NoriX, load_scene, load_text};
use telamon::render::{Description, Statistics, render};

/// A file of the package.
pub(crate) fn in_package(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The scene files of a folder of the package, sorted.
pub(crate) fn scene_files(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(in_package(folder)).expect("is there").flatten();
    let files = entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "xml"));
    let mut files: Vec<_> = files.collect();
    files.sort_unstable();
    files
}

/// The scene in `text`, which must be right and without warnings.
pub(crate) fn parse(text: &str) -> Description {
    let loaded = load_text(text, Path::new("test.xml"), &LoadOptions::default());
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.warnings, []);
    loaded.description
}

/// The scene in a file, which must be right and without warnings, except those of a sampler's stand-in and of
/// what Mitsuba's `moment` adds.
pub(crate) fn read(path: &Path, defines: &[(&str, &str)]) -> Description {
    let defines = defines.iter().map(|&(n, v)| (n.to_owned(), v.to_owned())).collect();
    let nori_x = Some(NoriX::Right);
    let loaded = load_scene(path, &LoadOptions { defines, nori_x, ..LoadOptions::default() });
    let mut loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    let expected = ["sampler `sobol` is used in place of ", "second moments are left out"];
    loaded.warnings.retain(|w| !expected.iter().any(|e| w.message.starts_with(e)));
    assert_eq!(loaded.warnings, [], "{}", path.display());
    loaded.description
}

/// Renders all of it; no sample may be lost and no ray refused.
pub(crate) fn picture(description: &Description, backend: Backend) -> Film {
    let (film, statistics) = render_on(description, backend);
    assert_eq!(statistics.non_finite, 0, "{statistics:?}");
    assert_eq!(statistics.rays.untraceable, 0, "{statistics:?}");
    let count = description.sampler.samples_per_pixel;
    assert_eq!(statistics.samples_per_pixel, (count, count));
    film
}

fn render_on(description: &Description, backend: Backend) -> (Film, Statistics) {
    let engine = intersect::build(backend, &description.scene.shapes()).expect("builds");
    render(description, engine.as_ref(), &|_| (), &AtomicBool::new(false))
}
