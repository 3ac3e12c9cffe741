//! Renders that are watched: in which order pixels get their samples, and what can be seen of them meanwhile.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use telamon::film::picture::{Picture, Values};
use telamon::film::{Crop, Film};
use telamon::intersect::{self, Backend};
use telamon::load::{LoadOptions, load_text};
use telamon::render::{Description, Effort, Preview, Progress, Statistics, render};

/// A ball on a mirror under a sky, by a lens, with layers; a crop whose last tiles are 5 and 3 pixels wide and high.
const SCENE: &str = r#"<scene version="3.0.0">
    <integrator type="aov">
        <string name="aovs" value="d:depth, n:sh_normal, i:shape_index"/>
        <integrator type="path"/>
    </integrator>
    <sensor type="thinlens">
        <transform name="to_world"><lookat origin="0, 1, -4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <float name="aperture_radius" value="0.1"/>
        <float name="focus_distance" value="4"/>
        <film type="hdrfilm">
            <integer name="width" value="80"/><integer name="height" value="60"/>
            <integer name="crop_offset_x" value="7"/><integer name="crop_offset_y" value="9"/>
            <integer name="crop_width" value="53"/><integer name="crop_height" value="35"/>
            <string name="pixel_format" value="rgba"/>
        </film>
        <sampler type="independent"><integer name="sample_count" value="21"/></sampler>
    </sensor>
    <shape type="sphere"><bsdf type="diffuse"/></shape>
    <shape type="disk">
        <transform name="to_world">
            <rotate x="1" angle="-90"/><scale value="3"/><translate y="-1"/>
        </transform>
        <bsdf type="conductor"/>
    </shape>
    <emitter type="constant"/>
</scene>"#;

const PIXELS: u64 = 53 * 35;

fn description(effort: Effort) -> Description {
    let loaded = load_text(SCENE, Path::new("ball.xml"), &LoadOptions::default());
    let mut description = loaded.expect("a scene").description;
    description.effort = effort;
    description
}

fn watched(
    description: &Description,
    on_progress: &(dyn Fn(Progress<'_>) + Sync),
    cancel: &AtomicBool,
) -> (Film, Statistics) {
    let engine = intersect::build(Backend::Rust, &description.scene.shapes()).expect("builds");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("starts");
    pool.install(|| render(description, engine.as_ref(), on_progress, cancel))
}

fn never() -> AtomicBool {
    AtomicBool::new(false)
}

/// Efforts that sample in different ways: one sum a pixel, two halves, and as many as each tile wants.
fn efforts() -> [Effort; 3] {
    let plain = Effort::default();
    [plain, Effort { error: Some(1e-9), ..plain }, Effort { adaptive: true, ..plain }]
}

#[test]
fn the_order_of_the_first_samples_changes_nothing() {
    for effort in efforts() {
        let mut description = description(effort);
        description.film.variance = true;
        // Beyond the first allocation of an adaptive render.
        description.sampler.samples_per_pixel = 40;
        let (film, plain) = watched(&description, &|_| (), &never());
        description.effort.coarse_first = true;
        let (other, coarse) = watched(&description, &|_| (), &never());
        assert_eq!(Picture::from_film(&film), Picture::from_film(&other), "{effort:?}");
        assert_eq!(plain.samples, coarse.samples);
        assert_eq!(plain.rays, coarse.rays);
    }
}

/// The rectangles and the number of samples of each call, in their order.
fn calls(effort: Effort) -> Vec<(Crop, u64)> {
    let calls = Mutex::new(Vec::new());
    let on_progress = |now: Progress<'_>| {
        let area = now.tile.area();
        let samples = |pixel| u64::from(now.tile.samples(pixel));
        let samples = (0..now.tile.pixels().count()).map(samples).sum();
        calls.lock().expect("no panic").push((area, samples));
    };
    watched(&description(effort), &on_progress, &never());
    calls.into_inner().expect("no panic")
}

#[test]
fn the_whole_film_comes_first_and_before_it_a_few_pixels_everywhere() {
    let tiles = 4 * 3;
    let pixels = |area: Crop| u64::from(area.width * area.height);
    let of_pass = |calls: &[(Crop, u64)], samples: u64| {
        let corners: HashSet<_> = calls.iter().map(|(area, _)| (area.x, area.y)).collect();
        assert_eq!(corners.len(), tiles, "each tile once");
        assert!(calls.iter().all(|&(area, count)| count == samples * pixels(area)));
    };
    let plain = calls(Effort::default());
    of_pass(&plain[..tiles], 1);
    of_pass(&plain[tiles..][..tiles], 2);

    let coarse = calls(Effort { coarse_first: true, ..Effort::default() });
    // The middle of each square of 8x8: columns 4 and 12 of a tile, if it has them; likewise for rows.
    let middles = |side: u32| u64::from((side > 4) as u32 + (side > 12) as u32);
    for (area, count) in &coarse[..tiles] {
        assert_eq!(*count, middles(area.width) * middles(area.height), "{area:?}");
    }
    of_pass(&coarse[tiles..][..tiles], 1);
    assert_eq!(coarse.len(), plain.len() + tiles);
}

/// All that a preview has, as a picture would: channel by channel, row by row.
fn composed(preview: &Preview, since: u64) -> (Vec<Vec<f32>>, usize) {
    let crop = preview.crop();
    let mut channels = vec![vec![f32::NAN; PIXELS as usize]; preview.channels().len()];
    let mut tiles = 0;
    preview.changes(since, |area, values| {
        tiles += 1;
        let pixels = (area.width * area.height) as usize;
        for (channel, values) in channels.iter_mut().zip(values.chunks_exact(pixels)) {
            for (row, values) in values.chunks_exact(area.width as usize).enumerate() {
                let y = (area.y - crop.y) as usize + row;
                let begin = y * crop.width as usize + (area.x - crop.x) as usize;
                channel[begin..][..values.len()].copy_from_slice(values);
            }
        }
    });
    (channels, tiles)
}

#[test]
fn a_preview_has_in_the_end_what_the_picture_has() {
    for effort in efforts() {
        let description = description(Effort { coarse_first: true, ..effort });
        let preview = Preview::new(&description);
        assert_eq!((preview.version(), composed(&preview, 0).1), (0, 0));
        let (film, _) = watched(&description, &|now| preview.update(now.tile), &never());
        let picture = Picture::from_film(&film);
        let names: Vec<_> = picture.channels.iter().map(|c| c.name.clone()).collect();
        assert_eq!(preview.channels(), names);
        assert_eq!(names.join(" "), "R G B A d.T n.X n.Y n.Z i.I");
        let (channels, _) = composed(&preview, 0);
        for (seen, channel) in channels.iter().zip(&picture.channels) {
            let expected = match &channel.values {
                Values::Color(values) | Values::Float(values) => values.clone(),
                Values::Index(values) => values.iter().map(|&i| i as f32).collect(),
            };
            assert_eq!(*seen, expected, "{} {effort:?}", channel.name);
        }
        assert_eq!(Preview::bytes(&description), PIXELS * 9 * 4);
    }
}

#[test]
fn only_tiles_that_changed_are_seen_again() {
    let description = description(Effort::default());
    let preview = Preview::new(&description);
    let seen = Mutex::new((0, Vec::new()));
    let on_progress = |now: Progress<'_>| {
        let mut seen = seen.lock().expect("no panic");
        preview.update(now.tile);
        let (since, counts) = &mut *seen;
        let mut tiles = Vec::new();
        *since = preview.changes(*since, |area, _| tiles.push(area));
        counts.push(tiles == [now.tile.area()]);
    };
    watched(&description, &on_progress, &never());
    let (since, counts) = seen.into_inner().expect("no panic");
    assert!(counts.len() > 24 && counts.iter().all(|&alone| alone), "{counts:?}");
    assert_eq!((since, composed(&preview, since).1), (preview.version(), 0));
}

/// After the coarse step, each pixel looks like the sampled one of its 8x8 square, whose value is that of the first
/// sample.
#[test]
fn few_samples_are_seen_as_blocks() {
    let mut of_one = description(Effort::default());
    of_one.sampler.samples_per_pixel = 1;
    let first = Preview::new(&of_one);
    watched(&of_one, &|now| first.update(now.tile), &never());
    let (first, _) = composed(&first, 0);

    let description = description(Effort { coarse_first: true, ..Effort::default() });
    let preview = Preview::new(&description);
    let cancel = never();
    let taken = AtomicU64::new(0);
    let on_progress = |now: Progress<'_>| {
        // 2·3 columns and 2·2 rows of middles, and the strip of 5 that has one column.
        let all = taken.fetch_add(1, Ordering::Relaxed) + 1 == 12;
        cancel.fetch_or(all, Ordering::Relaxed);
        if taken.load(Ordering::Relaxed) <= 12 {
            preview.update(now.tile);
        }
    };
    watched(&description, &on_progress, &cancel);
    let (seen, tiles) = composed(&preview, 0);
    assert_eq!(tiles, 12);
    for y in 0..32 {
        for x in 0..48 {
            let middle = (y / 8 * 8 + 4) * 53 + x / 8 * 8 + 4;
            let place = y * 53 + x;
            // Halfway between two, either is the nearest one.
            if x % 8 > 0 && y % 8 > 0 {
                for (seen, first) in seen.iter().zip(&first) {
                    assert_eq!(seen[place], first[middle], "{x} {y}");
                }
            }
        }
    }
    // Rows 32 to 34 have no middle.
    assert!((33..35).all(|y| seen[0][y * 53..][..53].iter().all(|v| *v == 0.0)));
}
