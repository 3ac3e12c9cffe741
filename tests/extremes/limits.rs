//! What 32-bit floats cannot hold is refused, or told of.

use std::path::Path;

use telamon::load::{LoadOptions, load_text};

/// A lit cube under a map, seen by a camera: what is wrong, and what the loader warns of, with the help.
fn said(cube: &str, camera: &str) -> Result<Vec<String>, String> {
    let text = format!(
        "<scene version='3.0.0'>\n<shape type='cube'>{cube}</shape>\n<sensor type='perspective'>{camera}\
         </sensor><emitter type='constant'/></scene>"
    );
    let loaded = load_text(&text, Path::new("scene.xml"), &LoadOptions::default());
    let loaded = loaded.map_err(|error| error.to_string())?;
    let help = |h: &Option<String>| h.clone().unwrap_or_default();
    Ok(loaded.warnings.iter().map(|w| format!("{w}; {}", help(&w.help))).collect())
}

fn moved(scale: f64, place: f64) -> String {
    format!(
        "<transform name='to_world'><scale value='{scale}'/><translate x='{place}'/></transform>"
    )
}

#[test]
fn ordinary_and_extreme_scales_raise_no_warning() {
    for scale in [1e-10, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e8] {
        for place in [0.0, 1.0, 1e3] {
            assert_eq!(said(&moved(scale, place * scale), ""), Ok(Vec::new()), "{scale} {place}");
        }
    }
}

#[test]
fn distorted_shapes_are_told_of() {
    for (cube, expected) in [
        (
            moved(1.0, 1e6),
            "scene.xml:2:20: this shape lies 1.0e6 from the origin, where 32-bit floats are 1.2e-1 apart: \
             100 % of the triangles are distorted; move the scene, with its camera, to the origin",
        ),
        (
            moved(1e-12, 0.0),
            "scene.xml:2:20: 100 % of the triangles of this shape are shorter than 1e-11, where the products \
             of lengths leave 32-bit floats; choose another unit of length: scale the scene up",
        ),
        (
            moved(1e13, 0.0),
            "scene.xml:2:20: this shape reaches 1.0e13 far, where the products of its lengths leave 32-bit \
             floats and rays may miss it; choose another unit of length: keep coordinates below 1e12",
        ),
    ] {
        assert_eq!(said(&cube, ""), Ok(vec![expected.to_owned()]), "{cube}");
    }
}

/// Too large, or so small that all corners are one.
#[test]
fn shapes_that_are_lost_are_refused() {
    for scale in [1e19, 1e39, 1e-46, 1e-300] {
        assert_eq!(
            said(&moved(scale, 0.0), ""),
            Err("scene.xml:2:1: shape `cube` has no triangle with an area and finite vertices\n  \
                 help: keep all coordinates below 1.844e18 and above what a 32-bit float can hold"
                .to_owned()),
            "{scale}"
        );
    }
}

#[test]
fn cameras_beyond_the_floats_are_refused_or_told_of() {
    let far = "<transform name='to_world'><translate x='1e19'/></transform>";
    assert_eq!(
        said("", far),
        Err("scene.xml:3:28: the camera is at 10000000000000000000, 0, 0 (expected coordinates below \
             1.844e18)"
            .to_owned())
    );
    let oblique = "<float name='fov' value='1e-4'/><transform name='to_world'>\
                   <lookat origin='9, 8, 7' target='0, 0, 0'/></transform>";
    assert_eq!(
        said("", oblique),
        Ok(vec![
            "scene.xml:3:53: the field of view is so narrow that neighbouring pixels have the same \
             direction as 32-bit floats; make fewer pixels of it, or look along an axis, where directions \
             are finer"
                .to_owned()
        ])
    );
    for (fov, problem) in [
        ("0", "`fov` is 0 (expected: float above 0)"),
        ("-1", "`fov` is -1 (expected: float above 0)"),
        ("180", "the field of view is 180 degrees (expected more than 0 and less than 180)"),
        ("nan", "`nan` is not a finite number"),
        ("inf", "`inf` is not a finite number"),
    ] {
        let camera = format!("<float name='fov' value='{fov}'/>");
        assert_eq!(said("", &camera), Err(format!("scene.xml:3:53: {problem}")), "{fov}");
    }
}
