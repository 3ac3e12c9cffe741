//! What goes wrong, and what the command says of itself.

use std::fs;
use std::process::Command;

use crate::support::command::{Folder, PROGRAM, Run, SCENE};

#[test]
fn bad_usage_ends_with_2() {
    let folder = Folder::new();
    for (arguments, message) in [
        ("render", "<SCENE_OR_MESH>"),
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
        ("render scene.xml --live vnc", "expected tev, tev:HOST:PORT, web, web:PORT or terminal"),
        (
            "render scene.xml --live tev:farm",
            "expected a host and a port, such as tev:127.0.0.1:14158",
        ),
        ("render scene.xml --live web:0", "expected a port from 1 to 65535, such as web:8080"),
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
fn help_mentions_every_option() {
    let folder = Folder::new();
    let help = folder.succeed("--help").stdout;
    for part in [
        "render",
        "scene",
        "inspect",
        "trace",
        "parity",
        "completions",
        "man",
        "Example: telamon render",
    ] {
        assert!(help.contains(part), "{part}: {help}");
    }
    let options = [
        "<SCENE_OR_MESH>",
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
        "--live <VIEWER>",
        "-q, --quiet",
        "--up <AXIS>",
        "--view <NAME|AZ,EL>",
        "--fov <DEGREES>",
        "--light <LIGHT>",
        "--ground <ON|OFF>",
        "--material <MATERIAL>",
        "--background <COLOR>",
        "--turntable <N>",
    ];
    let help = folder.succeed("render --help").stdout;
    for option in options {
        assert!(help.contains(option), "{option}: {help}");
    }
    for heading in ["Input:", "Sampling:", "Output:", "Picture:", "A mesh instead of a scene:"] {
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
