//! Pictures, their files, and what limits them.

use std::fs;

use crate::support::command::{Folder, SCENE};
use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;

/// A number or text of an EXR file's metadata.
fn attribute(header: &Header, name: &str) -> String {
    match header.own_attributes.other.get(&exr::prelude::Text::from(name)) {
        Some(AttributeValue::I32(value)) => value.to_string(),
        Some(AttributeValue::F32(value)) => value.to_string(),
        Some(AttributeValue::Text(value)) => value.to_string(),
        other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn both_files_are_written_and_a_line_sums_up() {
    let folder = Folder::new();
    let run = folder.succeed("render scene.xml -o a.exr -o b.PNG");
    assert_eq!(folder.names(), ["a.exr", "b.PNG"]);
    assert_eq!(run.stdout, "");
    let line = run.stderr.strip_suffix('\n').expect("a line");
    assert!(line.starts_with("a.exr and b.PNG: 4 samples per pixel with "), "{line}");
    for part in ["load ", "build ", "render ", " s; ", " Mpaths/s, ", " Mrays/s"] {
        assert!(line.contains(part), "{part}: {line}");
    }
    assert!(!line.contains('\n'), "{line}");
    let (width, height, bytes) = folder.png("b.PNG");
    assert_eq!((width, height), (32, 24));
    // The sky, and the ball in the middle: convex under a white sky it shows its reflectance of 0.5,
    // with roulette and MIS as noise. 188 is 0.5 in sRGB.
    assert_eq!(bytes[..3], [255, 255, 255]);
    let middle = bytes[(12 * 32 + 16) * 3];
    assert!((100..255).contains(&middle), "{middle}");
}

#[test]
fn without_a_name_the_scene_gives_it() {
    let folder = Folder::new();
    fs::create_dir(folder.path("sub")).expect("writable");
    fs::rename(folder.path("scene.xml"), folder.path("sub/box.v2.xml")).expect("writable");
    folder.succeed("render sub/box.v2.xml");
    assert_eq!(folder.names(), ["box.v2.exr", "sub"]);
}

#[test]
fn an_existing_file_is_replaced() {
    let folder = Folder::new();
    fs::write(folder.path("a.exr"), "old").expect("writable");
    folder.succeed("render scene.xml -o a.exr");
    assert_eq!(folder.header("a.exr").layer_size.0, 32);
    assert_eq!(folder.names(), ["a.exr"]);
}

#[test]
fn the_header_says_how_the_picture_came_about() {
    let folder = Folder::new();
    folder.succeed("render scene.xml -o a.exr --seed 7");
    let header = folder.header("a.exr");
    assert_eq!(attribute(&header, "scene"), "scene.xml");
    assert_eq!(attribute(&header, "sampler"), "independent");
    assert_eq!(attribute(&header, "seed"), "7");
    assert_eq!(attribute(&header, "samplesPerPixel"), "4");
    assert!(attribute(&header, "renderTimeSeconds").parse::<f32>().expect("a number") > 0.0);
    assert!(!attribute(&header, "backend").is_empty());
}

#[test]
fn every_sampling_option_has_an_effect() {
    let folder = Folder::new();
    let picture = |arguments: &str| {
        folder.succeed(&format!("render scene.xml -o a.exr -o a.png {arguments}"));
        folder.png("a.png").2
    };
    let plain = picture("");
    assert_eq!(plain, picture("--threads 7"), "threads do not change the picture");
    assert_ne!(plain, picture("--seed 1"));
    assert_eq!(plain, picture("--seed 0"));
    assert_eq!(plain, picture("--sampler independent"));
    assert_ne!(plain, picture("--sampler sobol"));
    assert_eq!(attribute(&folder.header("a.exr"), "sampler"), "sobol");
    assert_ne!(plain, picture("--spp 9"));
    assert_eq!(attribute(&folder.header("a.exr"), "samplesPerPixel"), "9");
    picture("-D spp=5");
    assert_eq!(attribute(&folder.header("a.exr"), "samplesPerPixel"), "5");
    picture("--define spp=5 --spp 6");
    assert_eq!(attribute(&folder.header("a.exr"), "samplesPerPixel"), "6");
    let run = folder.succeed("render scene.xml --threads 3");
    assert!(run.stderr.contains(" on 3 threads; "), "{}", run.stderr);
    let run = folder.succeed("render scene.xml --threads 1 --backend rust");
    assert!(run.stderr.contains(" with Rust BVH"), "{}", run.stderr);
    assert!(run.stderr.contains(" on 1 thread; "), "{}", run.stderr);
}

#[test]
fn every_picture_option_has_an_effect() {
    let folder = Folder::new();
    folder.succeed("render scene.xml -o a.exr -o a.png --size 16x20");
    assert_eq!(folder.header("a.exr").layer_size, exr::math::Vec2(16, 20));
    let (width, height, plain) = folder.png("a.png");
    assert_eq!((width, height), (16, 20));

    // A crop is that part of the whole picture, to the last bit.
    folder.succeed("render scene.xml -o b.exr -o b.png --size 16x20 --crop 3,5,8,2");
    let header = folder.header("b.exr");
    assert_eq!(header.own_attributes.layer_position, exr::math::Vec2(3, 5));
    assert_eq!(header.shared_attributes.display_window.size, exr::math::Vec2(16, 20));
    let (width, height, part) = folder.png("b.png");
    assert_eq!((width, height), (8, 2));
    assert_eq!(part[..24], plain[(5 * 16 + 3) * 3..][..24]);

    folder.succeed("render scene.xml -o a.png --size 16x20 --exposure -2");
    let dark = folder.png("a.png").2;
    // A quarter of 1 is 137 in sRGB.
    assert_eq!(dark[0], 137);
    folder.succeed("render scene.xml -o a.png --size 16x20 --clamp 0.25");
    assert_eq!(folder.png("a.png").2[0], 137);
    let run = folder.succeed("render scene.xml -o a.exr --exposure 1");
    assert!(run.stderr.contains("warning: `--exposure` changes nothing"), "{}", run.stderr);
}

/// The names of the channels of an EXR file, sorted as they are in it.
fn channels(header: &Header) -> Vec<String> {
    header.channels.list.iter().map(|c| c.name.to_string()).collect()
}

#[test]
fn variance_is_written_only_if_asked_for() {
    let folder = Folder::new();
    folder.succeed("render scene.xml -o a.exr -o a.png");
    assert_eq!(channels(&folder.header("a.exr")), ["B", "G", "R"]);
    folder.succeed("render scene.xml -o b.exr -o b.png --variance");
    let expected = ["B", "G", "R", "samples.N", "variance.B", "variance.G", "variance.R"];
    assert_eq!(channels(&folder.header("b.exr")), expected);
    assert_eq!(folder.png("a.png"), folder.png("b.png"), "the picture is the same");
    let run = folder.succeed("render scene.xml -o a.png --variance");
    let message =
        "warning: `--variance` changes nothing: it is for EXR files, and none is asked for";
    assert!(run.stderr.starts_with(message), "{}", run.stderr);
}

#[test]
fn a_time_limit_leaves_a_whole_picture() {
    let folder = Folder::new();
    folder.succeed("render scene.xml -o a.exr -o a.png --time 0.3s");
    let header = folder.header("a.exr");
    let count = attribute(&header, "samplesPerPixel");
    assert_eq!(attribute(&header, "largestSamplesPerPixel"), count);
    folder.succeed(&format!("render scene.xml -o b.png --spp {count}"));
    assert_eq!(folder.png("a.png"), folder.png("b.png"));
    folder.succeed("render scene.xml -o a.exr --time 1h --spp 3");
    assert_eq!(attribute(&folder.header("a.exr"), "samplesPerPixel"), "3");
}

#[test]
fn an_error_limit_is_reached_and_told() {
    let folder = Folder::new();
    for (option, name, limit) in
        [("error", "relMSEBound", 0.01), ("noise-level", "noiseLevelBound", 0.2)]
    {
        let run = folder.succeed(&format!("render scene.xml -o a.exr --{option} {limit}"));
        let header = folder.header("a.exr");
        let bound: f32 = attribute(&header, name).parse().expect("a number");
        assert!(bound <= limit, "{bound}");
        let count: u32 = attribute(&header, "samplesPerPixel").parse().expect("a number");
        assert!((16..65536).contains(&count), "{count}");
        assert!(run.stderr.starts_with(&format!("a.exr: {count} samples per pixel with ")));
        for part in ["; relMSE 0.", "; relMSE 0.0", " (at most 0.", ", noise level 0."] {
            assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
        }
    }
    let run = folder.succeed("render scene.xml --spp 32 --error 1e-9 --noise-level 9");
    let start = "warning: all samples were taken before the picture was good enough: the relMSE is at \
                 most 0.";
    assert!(run.stderr.starts_with(start), "{}", run.stderr);
    assert!(run.stderr.contains(", not 0.000000001\n"), "{}", run.stderr);
}

#[test]
fn adaptive_sampling_needs_enough_samples() {
    let folder = Folder::new();
    let run = folder.succeed("render scene.xml -o a.exr --adaptive --spp 64");
    let header = folder.header("a.exr");
    let least: u32 = attribute(&header, "samplesPerPixel").parse().expect("a number");
    let most: u32 = attribute(&header, "largestSamplesPerPixel").parse().expect("a number");
    assert!(16 <= least && least < most, "{least} {most}");
    let range = format!(" ({least} to {most}) samples per pixel with ");
    assert!(run.stderr.contains(&range), "{}", run.stderr);
    let run = folder.succeed("render scene.xml --adaptive --spp 16");
    let message = "warning: `--adaptive` changes nothing: it begins after 16 samples per pixel";
    assert!(run.stderr.starts_with(message), "{}", run.stderr);
}

#[test]
fn variance_needs_a_picture_and_a_free_name() {
    let aov = |inside: &str| {
        let text = r#"<integrator type="aov"><string name="aovs" value="variance:albedo"/>INSIDE</integrator>"#;
        let aov = text.replace("INSIDE", inside);
        Folder::with_scene(&SCENE.replace(r#"<integrator type="path"/>"#, &aov))
    };
    let render = "render scene.xml --variance";
    let told = aov(r#"<integrator type="path"/>"#).fail(&format!("{render} --spp 4000000000"), 1);
    let message = "error: cannot write `scene.exr`: there are two channels `variance.R`";
    assert!(told.starts_with(message), "{told}");
    for option in ["--error 0.1", "--noise-level 0.1", "--adaptive"] {
        let told = aov("").fail(&format!("render scene.xml {option}"), 1);
        let message = "error: `--error`, `--noise-level` and `--adaptive` need a picture, and the scene \
                       makes layers alone\n";
        assert_eq!(told, message);
    }
    let told = aov("").succeed(render).stderr;
    let message = "warning: `--variance` changes nothing: the scene makes layers alone";
    assert!(told.starts_with(message), "{told}");
}

#[test]
fn quiet_is_silent() {
    let folder = Folder::new();
    for quiet in ["-q", "--quiet"] {
        let run = folder.succeed(&format!("render scene.xml {quiet}"));
        assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    }
    assert!(folder.fail("render none.xml --quiet", 1).contains("none.xml"));
}

#[test]
fn layers_alone_are_refused_as_png_before_rendering() {
    let layers = r#"<integrator type="aov"><string name="aovs" value="z:depth"/></integrator>"#;
    let folder = Folder::with_scene(&SCENE.replace(r#"<integrator type="path"/>"#, layers));
    let told = folder.fail("render scene.xml -o a.exr -o a.png --spp 4000000000", 1);
    let message = "error: cannot write `a.png`: the picture has layers but no colours";
    assert!(told.starts_with(message), "{told}");
    folder.succeed("render scene.xml -o a.exr");
    assert_eq!(channels(&folder.header("a.exr")), ["z.T"]);
}

#[test]
fn ctrl_c_writes_what_is_there_and_says_so() {
    let folder = Folder::new();
    let arguments = "render scene.xml -o a.exr -o a.png --quiet --spp 4000000000";
    // If the program had not begun to render, it has nothing to write.
    let run = folder.interrupt(arguments, |run| run.code.is_some() && !folder.names().is_empty());
    assert_eq!(run.code, Some(130), "{}", run.stderr);
    assert_eq!(folder.names(), ["a.exr", "a.png"]);
    let told = run.stderr;
    assert!(told.starts_with("warning: interrupted: "), "{told}");
    let rest = " of 4000000000 samples per pixel are in a.exr and a.png\n";
    assert!(told.ends_with(rest), "{told}");
    let header = folder.header("a.exr");
    let [least, most] = ["samplesPerPixel", "largestSamplesPerPixel"]
        .map(|name| attribute(&header, name).parse::<u32>().expect("a number"));
    assert!(0 < most && least <= most && most < 4_000_000_000, "{least} {most}");
}
