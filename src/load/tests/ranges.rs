//! Textures beyond what a material takes, texture coordinates beyond what integers hold, headers of Radiance.

use std::fs;
use std::path::Path;

use glam::Vec3A;

use super::textures::{Folder, albedo, bitmap};

/// Writes a picture of one row.
fn write(path: &Path, pixels: &[f32]) {
    let pixel = |x: usize, _| (pixels[x], pixels[x], pixels[x]);
    exr::prelude::write_rgb_file(path, pixels.len(), 1, pixel).expect("writable");
}

fn warnings(folder: &Folder, bsdf: &str) -> Vec<String> {
    let loaded = folder.load(bsdf).expect("valid");
    loaded.warnings.iter().map(|w| folder.without_folder(&w.to_string())).collect()
}

/// The picture of one that rings, as enlarging leaves it, is that of the same one clamped, also between pixels.
#[test]
fn values_outside_count_as_the_nearest_inside() {
    let folder = Folder::new();
    let ringing = [-0.25, 0.5, 1.125, 0.75];
    write(&folder.path("ringing.exr"), &ringing);
    write(&folder.path("clamped.exr"), &ringing.map(|v| v.clamp(0.0, 1.0)));
    let [a, b] =
        ["ringing.exr", "clamped.exr"].map(|file| folder.load(&bitmap(file, "")).expect("valid"));
    for i in 0..32 {
        let u = i as f32 / 32.0;
        assert_eq!(albedo(&a, u, 0.5), albedo(&b, u, 0.5), "{u}");
    }
    assert!(b.warnings.is_empty());
    assert_eq!(
        warnings(&folder, &bitmap("ringing.exr", "")),
        [
            "scene.xml:2:46: `reflectance` is a texture with values from -0.25 to 1.125 (expected: colour from 0 to \
          1, or texture); the nearest value within takes the place of those outside"
        ]
    );
    // Through a texture that holds the picture, and for a number.
    let inner = |name: &str| {
        format!(
            "<texture name='{name}' type='bitmap'><string name='filename' value='ringing.exr'/></texture>"
        )
    };
    let board = format!(
        "<bsdf type='diffuse'><texture name='reflectance' type='checkerboard'>{}{}</texture></bsdf>",
        inner("color0"),
        inner("color1")
    );
    let board = folder.load(&board).expect("valid");
    for i in 0..32 {
        let value = albedo(&board, i as f32 / 32.0, 0.25);
        assert!(value.min_element() >= 0.0 && value.max_element() <= 1.0, "{value}");
    }
    let mask = format!("<bsdf type='mask'>{}<bsdf type='diffuse'/></bsdf>", inner("opacity"));
    assert!(
        warnings(&folder, &mask)[0]
            .contains("`opacity` is a texture with values from -0.25 to 1.125")
    );
}

/// Such a texture is no better than such a number.
#[test]
fn textures_that_are_outside_throughout_are_errors() {
    let folder = Folder::new();
    write(&folder.path("bright.exr"), &[1.5, 1.125]);
    write(&folder.path("negative.exr"), &[-1.0]);
    for (file, range) in [("bright.exr", "1.125 to 1.5"), ("negative.exr", "-1 to -1")] {
        assert_eq!(
            folder.load(&bitmap(file, "")).map(|_| ()),
            Err(format!(
                "scene.xml:2:46: `reflectance` is a texture with values from {range} (expected: colour from 0 to \
                 1, or texture)"
            ))
        );
    }
    let lamp = "<emitter type='area'><texture name='radiance' type='bitmap'>\
                <string name='filename' value='FILE'/></texture></emitter>";
    assert!(folder.load(&lamp.replace("FILE", "bright.exr")).is_ok());
    let error = folder.load(&lamp.replace("FILE", "negative.exr")).map(|_| ()).expect_err("dark");
    assert!(error.contains("`radiance` is a texture with values from -1 to -1"), "{error}");
}

/// Heights may have any value, and roughness is raised as a number is.
#[test]
fn heights_and_roughness_have_ranges_of_their_own() {
    let folder = Folder::new();
    write(&folder.path("heights.exr"), &[-1e30, 2.0, 3e38]);
    let texture = |name: &str, file: &str| {
        format!("<texture type='bitmap' {name}><string name='filename' value='{file}'/></texture>")
    };
    let bump =
        format!("<bsdf type='bumpmap'>{}<bsdf type='diffuse'/></bsdf>", texture("", "heights.exr"));
    assert!(warnings(&folder, &bump).is_empty());
    let loaded = folder.load(&bump).expect("valid");
    for i in 0..32 {
        let value = albedo(&loaded, i as f32 / 32.0, 0.5);
        assert_eq!(value, Vec3A::splat(0.5));
    }
    write(&folder.path("alpha.exr"), &[0.0, 0.5]);
    let rough = texture("name='alpha'", "alpha.exr");
    assert_eq!(
        warnings(&folder, &format!("<bsdf type='roughconductor'>{rough}</bsdf>")),
        ["scene.xml:2:25: `alpha` is raised to 0.0001, the least roughness there is"]
    );
}

/// 1e8 is a whole number of periods and has no fraction as an f32: exactly the border of the picture.
#[test]
fn large_texture_coordinates_show_the_right_pixel() {
    let folder = Folder::new();
    write(&folder.path("row.exr"), &[0.125, 0.25, 0.5, 1.0]);
    for filter in ["nearest", "bilinear"] {
        for wrap in ["repeat", "mirror", "clamp"] {
            let more = format!(
                "<string name='filter_type' value='{filter}'/><string name='wrap_mode' value='{wrap}'/>"
            );
            let loaded = folder.load(&bitmap("row.exr", &more)).expect("valid");
            let at = |u: f32| albedo(&loaded, u, 0.5).x;
            // An even number of periods, and beyond the last pixel.
            for u in [1e8, -1e8, 16_777_218.0, 1e20, -3e38, f32::MAX] {
                let same = match wrap {
                    "clamp" => u.signum(),
                    _ => 0.0,
                };
                assert_eq!(at(u), at(same), "{filter} {wrap} {u}");
            }
            // An odd number of periods.
            assert_eq!(at(16_777_215.0), at(1.0), "{filter} {wrap}");
            for u in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                assert_eq!(at(u), at(0.0), "{filter} {wrap} {u}");
            }
        }
    }
}

#[test]
fn radiance_files_may_name_any_program_and_end_lines_as_on_windows() {
    let folder = Folder::new();
    let pixels = [[128, 64, 32, 129], [10, 20, 30, 128], [1, 2, 3, 128], [200, 100, 50, 129]];
    for first in ["#?RADIANCE", "#?RGBE", "#?AUTOPANO"] {
        for end in ["\n", "\r\n"] {
            let lines = [first, "# made here", "FORMAT=32-bit_rle_rgbe", "", "-Y 2 +X 2", ""];
            let mut file = lines.join(end).into_bytes();
            file.extend(pixels.concat());
            fs::write(folder.path("a.hdr"), file).expect("writable");
            let more = "<string name='filter_type' value='nearest'/>";
            let loaded = folder.load(&bitmap("a.hdr", more)).expect("valid");
            // `Bitmap` of Mitsuba 3.9.1.
            assert_eq!(albedo(&loaded, 0.1, 0.1), Vec3A::new(1.0, 0.5, 0.25), "{first}");
            assert_eq!(albedo(&loaded, 0.1, 0.9), Vec3A::new(1.0, 2.0, 3.0) / 256.0, "{first}");
        }
    }
    fs::write(folder.path("a.hdr"), "#?RGBE\nno end").expect("writable");
    let error = folder.load(&bitmap("a.hdr", "")).map(|_| ()).expect_err("cut off");
    assert!(error.contains("a.hdr cannot be decoded: "), "{error}");
}
