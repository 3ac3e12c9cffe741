//! The text and place of every message.

use std::fs;

use super::super::{LoadOptions, load_scene};
use super::{SENSOR, load};

/// Blocks with a blank line between: what stands in the scene's second line, then what is to be said.
const MESSAGES: &str = include_str!("messages.txt");

#[test]
fn everything_wrong_is_said_and_located() {
    let mut count = 0;
    for block in MESSAGES.split("\n\n") {
        let (content, expected) = block.split_once('\n').expect("content, then messages");
        let expected = expected.lines().map(|l| l.strip_prefix("    ").expect("indented"));
        let expected: Vec<_> = expected.collect();
        let text = format!("<scene version='3.0.0'>\n{content}\n{SENSOR}</scene>");
        let error = load(&text).map(|_| ()).expect_err(content).to_string();
        assert_eq!(error, expected.join("\n"), "{content}");
        count += 1;
    }
    assert!(count > 100, "{count}");
}

#[test]
fn files_as_a_whole_are_judged() {
    for (text, expected) in [
        (
            "<scene/>",
            "scene.xml:1:1: <scene> lacks the attribute `version`\n  help: add version=\"3.0.0\"",
        ),
        (
            "<scene version='new'/>",
            "scene.xml:1:17: `new` is not a version\n  help: write it like 3.0.0",
        ),
        (
            "<scene version='4.0.0'/>",
            "scene.xml:1:17: version 4.0.0 is newer than what is known here\n  \
             help: scenes of Mitsuba 3 and, upgraded, of older versions are understood",
        ),
        (
            "<scene version='3.0.0' depth='3'/>",
            "scene.xml:1:24: unexpected attribute `depth` in <scene>\n  \
             help: expected `id`, `type`, `name`",
        ),
        (
            "<shape version='3.0.0' type='cube'/>",
            "scene.xml:1:1: the outermost element is <shape> (expected <scene>)",
        ),
        (
            "<default version='3.0.0' name='a' value='b'/>",
            "scene.xml:1:1: <default> cannot be the outermost element of a file",
        ),
        (
            "<scene version='3.0.0'/>",
            "scene.xml:1:1: the scene has no sensor\n  \
             help: add <sensor type=\"perspective\"> with a `to_world` and a `fov`",
        ),
    ] {
        let error = load(text).map(|_| ()).expect_err(text).to_string();
        assert_eq!(error, expected, "{text}");
    }
}

/// One run of the loader names all unsupported plugins and unknown properties.
#[test]
fn problems_are_collected() {
    let error = load(
        "<scene version='3.0.0'>\n<shape type='hair'/>\n<bsdf type='diffuse'><float name='a' value='x'/></bsdf>\n\
         <sensor type='fisheye'/>\n<shape type='cube'><float name='size' value='1'/></shape></scene>",
    )
    .expect_err("wrong");
    let lines: Vec<_> =
        error.problems().iter().filter_map(|p| p.position.as_ref()).map(|p| p.line).collect();
    assert_eq!((lines, error.more()), (vec![2, 3, 3, 4, 5], 0));
}

/// What one stage finds hides nothing of what the next ones find, and leads to no problem that is none.
#[test]
fn no_problem_hides_another() {
    let error = load(
        "<scene version='3.0.0'>
<shape type='$kind' id='$name'/>
<include filename='none.xml'/>
<shape type='sphere'><float name='radius' value='$r'/><float name='radios' value='1'/><ref id='a'/></shape>
<bsdf type='principled'><texture type='wood'><texture type='marble'/><bsdf type='velvet'/></texture></bsdf>
<shape type='obj'><string name='filename' value='none.obj'/><ref id='in none.xml'/></shape>
<shape type='ply'><string name='filename' value='$mesh'/></shape>
<sensor type='fisheye'><float name='x' values='1' y='2'/></sensor>
<integrator type='path'><integer name='max_depth' value='many'/></integrator>
</scene>",
    )
    .expect_err("wrong");
    let said: Vec<_> = error.problems().iter().map(ToString::to_string).collect();
    let expected = [
        "2:14: undefined parameter `$kind`",
        "2:25: undefined parameter `$name`",
        "3:20: there is no file `none.xml`",
        "4:50: undefined parameter `$r`",
        "4:68: shape `sphere`: unexpected property `radios` (did you mean `radius`?)",
        "5:13: bsdf `principled` is not supported",
        "5:40: texture `wood` is not supported",
        "5:61: texture `marble` is not supported",
        "5:82: bsdf `velvet` is not supported",
        "6:50: there is no file `none.obj`",
        "7:50: undefined parameter `$mesh`",
        "8:15: sensor `fisheye` is not supported",
        "8:24: <float> lacks the attribute `value`",
        "8:40: unexpected attribute `values` in <float> (did you mean `value`?)",
        "8:51: unexpected attribute `y` in <float>",
        "9:58: `many` is not a whole number",
    ];
    let expected = expected.map(|line| format!("scene.xml:{line}"));
    assert_eq!(said.join("\n"), expected.join("\n"));
}

/// Spans hold the offending text, in characters and bytes that differ.
#[test]
fn positions_hold_the_offending_text() {
    let text =
        format!("<scene version='3.0.0'>\n<!-- é --><shape type='sphère' id='ü'/>{SENSOR}</scene>");
    let error = load(&text).expect_err("no such shape");
    let position = error.problems()[0].position.as_ref().expect("in the file");
    assert_eq!((position.line, position.column), (2, 24));
    assert_eq!(&position.source[position.span.clone()], "sphère");
    assert_eq!(&*position.source, text);
}

#[test]
fn long_lists_are_cut() {
    let text = format!("<scene version='3.0.0'>{}</scene>", "<x/>".repeat(60));
    let error = load(&text).expect_err("no such elements");
    assert_eq!((error.problems().len(), error.more()), (50, 10));
    assert!(error.to_string().ends_with("\nand 10 more problems"));
}

#[test]
fn a_scene_without_light_says_so_once() {
    let warnings = |content: &str| {
        let loaded = load(&format!("<scene version='3.0.0'>\n{content}{SENSOR}</scene>"));
        let warnings: Vec<_> =
            loaded.expect("valid").warnings.iter().map(ToString::to_string).collect();
        warnings.join("\n")
    };
    let ball = "<shape type='sphere'/>";
    let none = "scene.xml:1:1: the scene has no light, so its picture will be black";
    let black = "scene.xml:1:1: the lights of the scene are all black, and so its picture will be";
    let aov = |inner: &str| {
        let layers = "<string name='aovs' value='d:depth'/>";
        format!("{ball}<integrator type='aov'>{layers}{inner}</integrator>")
    };
    let lamp = |radiance: &str| {
        let radiance = format!("<rgb name='radiance' value='{radiance}'/>");
        format!("{ball}<shape type='disk'><emitter type='area'>{radiance}</emitter></shape>")
    };
    for (content, expected) in [
        (ball.to_owned(), none),
        (format!("{ball}{ball}<integrator type='direct'/>"), none),
        (aov("<integrator type='path'/>"), none),
        (lamp("0 0 0"), black),
        (lamp("0 1e-9 0"), ""),
        (format!("{ball}<emitter type='constant'/>"), ""),
        (format!("{ball}<emitter type='point'/>"), ""),
        // What shows no light needs none.
        (aov(""), ""),
        (format!("{ball}<integrator type='ao'/>"), ""),
    ] {
        assert_eq!(warnings(&content), expected, "{content}");
    }
}

/// Scenes begin with a byte order mark where Windows wrote them; in UTF-16 they are not read, and it is said why.
#[test]
fn encodings_are_told_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let text = format!("<scene version='3.0.0'>{SENSOR}</scene>");
    let load = |bytes: Vec<u8>| {
        fs::write(&path, bytes).expect("can be written");
        load_scene(&path, &LoadOptions::default()).map(|_| ())
    };
    assert_eq!(load(format!("\u{feff}{text}").into_bytes()), Ok(()));
    for mark in ["", "\u{feff}"] {
        for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
            let utf_16 = format!("{mark}{text}").encode_utf16().flat_map(bytes).collect();
            let error = load(utf_16).expect_err("not read").to_string();
            assert!(
                error.ends_with(
                    "scene.xml: is text in UTF-16 (expected UTF-8: save it in that encoding)"
                ),
                "{error}"
            );
        }
    }
}
