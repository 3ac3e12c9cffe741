//! `telamon parity`.

use std::fs;

use telamon::intersect::Backend;

use crate::support::command::Folder;

/// A cube, closed, in which f32 arithmetic without precautions loses rays at the edges.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n\
                    f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

/// The table's lines that begin with a name.
fn lines_of<'a>(table: &'a str, name: &str) -> Vec<&'a str> {
    table.lines().filter(|line| line.starts_with(name)).collect()
}

#[test]
fn parity_compares_all_engines_on_meshes_and_scenes() {
    let folder = Folder::new();
    fs::write(folder.path("cube.obj"), CUBE).expect("writable");
    let run = folder.succeed("parity cube.obj --rays 5000 --budget 1,1");
    assert_eq!(run.stderr, "");
    for part in [
        "same",
        "twin",
        "silhouette",
        "undecided",
        "leak",
        "false",
        "wrong",
        "distance",
        "Mrays/s",
        "\n5000 rays, 0 of ",
    ] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    // Once with its answers and once with its budget; each engine with at least two modes.
    for backend in Backend::AVAILABLE {
        let name = if backend.name() == "rust" { "Rust BVH" } else { "Embree" };
        assert!(lines_of(&run.stdout, name).len() >= 4, "{name}: {}", run.stdout);
    }
    let run =
        folder.succeed("parity scene.xml -D spp=3 --rays 1e3 --seed 4 --engine rust --threads 3");
    assert_eq!(lines_of(&run.stdout, "Rust BVH").len(), 2, "{}", run.stdout);
    assert!(run.stdout.contains("\n1000 rays, "), "{}", run.stdout);
    assert_eq!(folder.names(), ["cube.obj"]);
    fs::write(folder.path("cube.obj"), format!("{CUBE}f 1 2 2\n")).expect("writable");
    let run = folder.succeed("parity cube.obj -D spp=3 --rays 100 --engine rust");
    let warnings = "warning: `--define` changes nothing: it is for scene files, and this is a mesh\n\
         warning: cube.obj: left out 1 triangle without area\n";
    assert_eq!(run.stderr, warnings);
}

#[test]
fn parity_fails_beyond_the_budget_and_its_report_can_be_replayed() {
    let folder = Folder::new();
    fs::write(folder.path("cube.obj"), CUBE).expect("writable");
    let plain = "parity cube.obj --engine rust,triangle=plain";
    let run = folder.run(&format!("{plain} --rays 20000 --budget 0,0 --report all.jsonl"));
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    let told = "error: more faults than the budget allows: Rust BVH ";
    assert!(run.stderr.starts_with(told), "{}", run.stderr);
    assert!(run.stdout.contains("  over budget\n"), "the table is shown: {}", run.stdout);
    assert_eq!(folder.names(), ["all.jsonl", "cube.obj"]);
    let all = fs::read_to_string(folder.path("all.jsonl")).expect("written");

    // Only the leaks: they leak again.
    let leaks: Vec<_> = all.lines().filter(|line| line.contains(r#""class":"leak""#)).collect();
    assert!(!leaks.is_empty() && leaks.len() < all.lines().count());
    fs::write(folder.path("leaks.jsonl"), leaks.join("\n")).expect("writable");
    let run =
        folder.succeed(&format!("{plain} --replay leaks.jsonl --budget 1,1 --report again.jsonl"));
    assert!(run.stdout.contains(&format!("\n{} rays, ", leaks.len())), "{}", run.stdout);
    let again = fs::read_to_string(folder.path("again.jsonl")).expect("written");
    // But for the number of the ray.
    let rays = |text: &str| -> Vec<String> {
        text.lines()
            .map(|line| line.split_once(',').expect("a number first").1.to_owned())
            .collect()
    };
    assert_eq!(rays(&again), rays(&leaks.join("\n")));
}

#[test]
fn parity_says_what_it_cannot_use() {
    let folder = Folder::new();
    fs::write(folder.path("cube.obj"), CUBE).expect("writable");
    fs::write(folder.path("rays.jsonl"), "{}\n").expect("writable");
    for (arguments, message) in [
        ("none.ply", "error: none.ply: cannot be read: "),
        ("none.obj.gz", "error: none.obj.gz: cannot be read: "),
        ("rays.jsonl", "error: "),
        ("cube.obj --report none/a", "error: cannot write `none/a`: there is no folder `none`"),
        ("cube.obj --replay none", "error: cannot read `none`: "),
        (
            "cube.obj --replay rays.jsonl",
            "error: `rays.jsonl`, line 1, column 2: missing field `origin`",
        ),
    ] {
        let told = folder.fail(&format!("parity {arguments}"), 1);
        assert!(told.starts_with(message), "{arguments}: {told}");
    }
}

#[test]
fn parity_shows_what_there_is_after_ctrl_c() {
    let folder = Folder::new();
    fs::write(folder.path("cube.obj"), CUBE).expect("writable");
    let arguments = "parity cube.obj --engine rust --rays 1e12 --budget 1,1 --report a.jsonl";
    let run = folder.interrupt(arguments, |run| run.code.is_some());
    assert_eq!(run.code, Some(130), "{}", run.stderr);
    assert!(run.stderr.starts_with("warning: interrupted: the table is about "), "{}", run.stderr);
    assert!(run.stderr.ends_with(" of 1000000000000 rays\n"), "{}", run.stderr);
    assert!(run.stdout.contains("Rust BVH"), "{}", run.stdout);
    assert_eq!(folder.names(), ["a.jsonl", "cube.obj"]);
}

/// A cube with a ball of 20,000 triangles in it that is 10⁻⁸ of its size, as Wavefront text.
fn mixed_scales() -> String {
    let mut text = CUBE.replace('1', "1e4");
    text = text.lines().filter(|line| line.starts_with('v')).map(|l| format!("{l}\n")).collect();
    let faces = CUBE.lines().filter(|line| line.starts_with('f'));
    text.extend(faces.map(|line| format!("{line}\n")));
    let (rings, segments) = (100, 101);
    for ring in 0..=rings {
        let theta = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for segment in 0..segments {
            let phi = std::f64::consts::TAU * f64::from(segment) / f64::from(segments);
            let [x, y, z] = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
            let [x, y, z] = [x, y, z].map(|c| 1e-4 * c);
            text += &format!("v {x:e} {y:e} {z:e}\n");
        }
    }
    for ring in 0..rings {
        for segment in 0..segments {
            let at = |ring, segment| 9 + ring * segments + segment % segments;
            let (a, b) = (at(ring, segment), at(ring, segment + 1));
            let (c, d) = (at(ring + 1, segment), at(ring + 1, segment + 1));
            text += &format!("f {a} {c} {b}\nf {b} {c} {d}\n");
        }
    }
    text
}

/// Ctrl-C ends a run on a mesh of which a single ray takes milliseconds, long before a group of rays is done; how
/// little is begun after it `a_cancelled_run_begins_nothing_more` counts. The mesh is warned of.
#[test]
fn parity_ends_at_once_on_meshes_that_take_long() {
    let folder = Folder::new();
    fs::write(folder.path("mixed.obj"), mixed_scales()).expect("writable");
    let arguments = "parity mixed.obj --engine rust --rays 1e12 --budget 1,1";
    let run = folder.interrupt(arguments, |run| run.code.is_some());
    assert_eq!(run.code, Some(130), "{}", run.stderr);
    let told = " of 20111 triangles are smaller than ";
    assert!(
        run.stderr.starts_with("warning: mixed.obj: ") && run.stderr.contains(told),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("\nwarning: interrupted: the table is about "), "{}", run.stderr);
    assert!(run.stdout.contains("Rust BVH"), "{}", run.stdout);
}

#[test]
fn parity_refuses_bad_usage() {
    let folder = Folder::new();
    for (arguments, message) in [
        ("parity", "<SCENE_OR_MESH>"),
        (
            "parity scene.xml --rays 0",
            "expected a whole number of at least 1, such as 1000000 or 1e6",
        ),
        (
            "parity scene.xml --rays 1.5",
            "expected a whole number of at least 1, such as 1000000 or 1e6",
        ),
        ("parity scene.xml --budget 0.5", "expected two numbers from 0 to 1, such as 1e-6,0.01"),
        ("parity scene.xml --budget 0,2", "expected two numbers from 0 to 1, such as 1e-6,0.01"),
        ("parity scene.xml --engine gpu", "no backend `gpu` in this build (expected one of: "),
        ("parity scene.xml --engine rust,fast", "expected KEY=VALUE, such as "),
        ("parity scene.xml --engine rust,robust=true", "backend `rust` has no mode `robust` "),
        ("parity scene.xml --replay a --seed 1", "cannot be used with"),
    ] {
        let told = folder.fail(arguments, 2);
        assert!(told.contains(message), "{arguments}: {told}");
    }
}

#[test]
fn the_help_of_parity_mentions_every_option() {
    let help = Folder::new().succeed("parity --help").stdout;
    for option in [
        "<SCENE_OR_MESH>",
        "-D, --define <NAME=VALUE>",
        "--engine <ENGINE[,KEY=VALUE...]>",
        "--rays <N>",
        "--seed <N>",
        "--replay <FILE>",
        "--threads <N>",
        "--report <FILE>",
        "--budget <RANDOM,AIMED>",
        "-q, --quiet",
    ] {
        assert!(help.contains(option), "{option}: {help}");
    }
}
