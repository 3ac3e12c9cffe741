//! The command as a user meets it: the real program, run in a fresh folder.

mod support;

use std::fs;
use std::process::Command;

use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;
use support::command::{Folder, PROGRAM, Run, SCENE};

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
    let start = "warning: all samples were taken before the picture was as asked for: the relMSE is at \
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
fn bad_usage_ends_with_2() {
    let folder = Folder::new();
    for (arguments, message) in [
        ("render", "<SCENE>"),
        ("paint scene.xml", "unrecognized subcommand 'paint'"),
        ("render scene.xml --colour", "unexpected argument '--colour'"),
        (
            "render scene.xml -o a.jpg",
            "unknown kind of picture `a.jpg` (expected a name that ends in `.exr` or `.png`)",
        ),
        ("render scene.xml -D spp", "expected a name, an equals sign and a value"),
        ("render scene.xml --size 64", "expected columns and rows, such as 640x480"),
        ("render scene.xml --size 0x64", "expected columns and rows, such as 640x480"),
        ("render scene.xml --crop 1,2,3", "expected first column and row, columns and rows"),
        ("render scene.xml --spp 0", "0 is not in 1..=4294967295"),
        ("render scene.xml --time 1d", "expected a time such as 90s, 5m or 1.5h"),
        ("render scene.xml --error 0", "expected a number above 0"),
        ("render scene.xml --noise-level x", "expected a number above 0"),
        ("render scene.xml --threads 0", "0 is not in 1..=1024"),
        ("render scene.xml --seed -1", "unexpected argument '-1'"),
        ("render scene.xml --exposure NaN", "expected a number from -149 to 127"),
        ("render scene.xml --backend gpu", "[possible values: "),
        ("completions tcl", "[possible values: bash"),
    ] {
        let told = folder.fail(arguments, 2);
        assert!(told.contains(message), "{arguments}: {told}");
    }
}

#[test]
fn failures_end_with_1_before_anything_is_rendered() {
    let folder = Folder::new();
    fs::create_dir(folder.path("folder.exr")).expect("writable");
    fs::write(folder.path("file"), "").expect("writable");
    // So many samples that no test would see the end of it.
    let render = "render scene.xml --spp 4000000000";
    for (arguments, message) in [
        ("-o none/a.exr", "error: cannot write `none/a.exr`: there is no folder `none`"),
        ("-o file/a.exr", "error: cannot write `file/a.exr`: there is no folder `file`"),
        ("-o folder.exr", "error: cannot write `folder.exr`: it is a folder"),
        // The kernel's own folder, which even root cannot write to.
        ("-o /proc/a.exr", "error: cannot write `/proc/a.exr`: "),
        ("-o a.exr -o none/a.png", "error: cannot write `none/a.png`: there is no folder `none`"),
        (
            "--size 65536x65536",
            "error: a film of 65536x65536 pixels is not possible (expected at least 1x1, and at most \
             4294967295 pixels)",
        ),
        (
            "--crop 30,0,3,24",
            "error: a crop of 3x24 pixels at 30,0 does not lie within the film of 32x24 pixels",
        ),
    ] {
        let told = folder.fail(&format!("{render} {arguments}"), 1);
        assert!(told.starts_with(message), "{arguments}: {told}");
        assert_eq!(told.matches("error:").count(), 1, "{told}");
    }
    let told = folder.fail(&format!("{render} -o none/a.exr -o /proc/a.png"), 1);
    assert_eq!(told.matches("error:").count(), 2, "both are named: {told}");
}

#[test]
fn scene_errors_show_the_line() {
    let folder = Folder::with_scene(&SCENE.replace("<bsdf", "<nonsense"));
    for command in ["render", "inspect"] {
        let told = folder.fail(&format!("{command} scene.xml"), 1);
        assert!(told.starts_with("error: "), "{told}");
        assert!(told.contains("[scene.xml:19:"), "{told}");
        assert!(told.contains("19 |         <nonsense type=\"diffuse\"/>"), "{told}");
        let told = folder.fail(&format!("{command} none.xml"), 1);
        assert!(told.contains("none.xml"), "{told}");
    }
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

#[test]
fn inspect_shows_what_is_there_and_what_is_skipped() {
    let folder = Folder::new();
    let run = folder.succeed("inspect scene.xml -D spp=11 --backend rust");
    assert_eq!(run.stderr, "");
    assert!(folder.names().is_empty());
    let text = run.stdout;
    for part in
        ["Sphere", "Diffuse", "32x24 pixels", "independent, 11 samples per pixel", "Rust BVH"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let (modelled, skipped) = text
        .split_once("\nThe render will model\n")
        .and_then(|(_, rest)| rest.split_once("\nThe render will skip\n"))
        .expect("both lists");
    assert!(modelled.contains("\n  next-event estimation ") || modelled.starts_with("  next"));
    assert!(modelled.contains("environment light"), "{modelled}");
    for feature in ["time", "lens", "textures", "variance"] {
        assert!(skipped.contains(&format!("  {feature} ")), "{feature}: {skipped}");
    }
}

/// A ball in a room so bright that a bounce leaves the range of f32.
const BLINDING: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <sampler type="independent"><integer name="sample_count" value="1"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="4"/>
            <integer name="height" value="3"/>
        </film>
    </sensor>
    <shape type="cube">
        <boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"/>
        <emitter type="area"><rgb name="radiance" value="3e38"/></emitter>
    </shape>
</scene>
"#;

#[test]
fn lost_samples_are_told_and_can_be_followed() {
    let folder = Folder::with_scene(BLINDING);
    let run = folder.succeed("render scene.xml --quiet --seed 5 --size 8x6");
    assert_eq!(
        run.stderr,
        "warning: samples that were not finite and are left out: 48; the first is sample 0 of pixel 0,0 with \
         seed 5\n  help: `telamon trace` follows its path: give it the same scene, --define, --size, --backend \
         and --accel, and --pixel 0,0 --sample 0 --seed 5\n"
    );
    let path = folder.succeed("trace scene.xml --pixel 0,0 --sample 0 --seed 5 --size 8x6").stdout;
    assert!(path.contains("\nedge 1\n  ray from (0.0, 0.0, 0.0) towards ("), "{path}");
    assert!(path.contains("(TriangleMesh, Diffuse), triangle "), "{path}");
    assert!(
        path.contains("  radiance so far: (3e38, 3e38, 3e38)\n\nedge 2\n  shadow ray "),
        "{path}"
    );
    let end = "\nradiance (inf, inf, inf), which is not finite and left out; alpha 1\n";
    assert!(path.ends_with(end), "{path}");
}

#[test]
fn what_half_floats_cannot_hold_is_clamped_and_told() {
    let folder = Folder::with_scene(&BLINDING.replace("3e38", "1e30"));
    let run = folder.succeed("render scene.xml -o a.exr --quiet");
    // Twelve pixels of three channels.
    assert_eq!(run.stderr, "warning: a.exr: values clamped to ±65504: 36\n");
}

#[test]
fn paths_that_are_not_there_cannot_be_followed() {
    let folder = Folder::new();
    let told = folder.fail("trace scene.xml --pixel 32,0", 1);
    assert_eq!(told, "error: pixel 32,0 does not lie within the film of 32x24 pixels\n");
    let told = folder.fail("trace scene.xml --pixel 32", 2);
    assert!(told.contains("expected column and row, such as 3,4"), "{told}");
    let layers = SCENE.replace(
        "<integrator type=\"path\"/>",
        "<integrator type=\"aov\"><string name=\"aovs\" value=\"z:depth\"/></integrator>",
    );
    let told = Folder::with_scene(&layers).fail("trace scene.xml --pixel 0,0", 1);
    assert_eq!(told, "error: there is no path: the integrator makes layers alone\n");
}

#[test]
fn help_mentions_every_option() {
    let folder = Folder::new();
    let help = folder.succeed("--help").stdout;
    for part in
        ["render", "inspect", "trace", "parity", "completions", "man", "Example: telamon render"]
    {
        assert!(help.contains(part), "{part}: {help}");
    }
    let options = [
        "<SCENE>",
        "-o, --output <FILE>",
        "--spp <N>",
        "--size <WxH>",
        "--sampler <KIND>",
        "--seed <N>",
        "--threads <N>",
        "--backend <ENGINE>",
        "-D, --define <NAME=VALUE>",
        "--crop <X,Y,W,H>",
        "--exposure <STOPS>",
        "--variance",
        "--time <TIME>",
        "--error <RELMSE>",
        "--noise-level <LEVEL>",
        "--adaptive",
        "--clamp <RADIANCE>",
        "-q, --quiet",
    ];
    let help = folder.succeed("render --help").stdout;
    for option in options {
        assert!(help.contains(option), "{option}: {help}");
    }
    for heading in ["Input:", "Sampling:", "Output:", "Picture:"] {
        assert!(help.contains(heading), "{heading}: {help}");
    }
    assert!(folder.run("").stderr.contains("Usage: telamon <COMMAND>"));
}

#[test]
fn the_version_names_embree() {
    let version = Folder::new().succeed("--version").stdout;
    let start = format!("telamon {} (", env!("CARGO_PKG_VERSION"));
    assert!(version.starts_with(&start), "{version}");
    let embree = if cfg!(feature = "embree") { "(Embree " } else { "(without Embree)" };
    assert!(version.contains(embree), "{version}");
}

#[test]
fn completions_and_manual_come_from_the_same_definitions() {
    let folder = Folder::new();
    let page = folder.succeed("man").stdout;
    assert!(page.contains(".TH telamon 1"), "{page}");
    assert!(!page.contains(".SH HELP"), "{page}");
    let scripts = ["bash", "elvish", "fish", "powershell", "zsh"]
        .map(|shell| folder.succeed(&format!("completions {shell}")).stdout);
    for option in
        ["exposure", "threads", "backend", "crop", "define", "sampler", "seed", "spp", "size"]
    {
        // Hyphens are escaped in roff.
        assert!(page.contains(&format!("\\-\\-{option}")), "{option}: {page}");
        assert!(scripts.iter().all(|s| s.contains(option)), "{option}");
    }
}

#[test]
fn a_reader_that_leaves_is_no_failure() {
    let folder = Folder::new();
    for command in ["man", "completions bash", "inspect scene.xml"] {
        // `true` has ended long before anything is written.
        let script = format!("(sleep 0.2; '{PROGRAM}' {command}; echo ended with $? >&2) | true");
        let output = Command::new("sh")
            .args(["-c", &script])
            .current_dir(folder.path("."))
            .output()
            .expect("sh is there");
        let run = Run::from(output);
        assert_eq!(run.stderr, "ended with 0\n", "{command}");
    }
}
