//! `telamon measure`: it finds what is known, and keeps what it measured. Nothing here depends on how long
//! anything takes.

mod support;

use std::fs;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use support::command::{Folder, SCENE};
use telamon::intersect::Backend;
use telamon::load::{LoadOptions, load_text};
use telamon::measure::bench::{Bench, MemoryProbe, Run, mean_error, render_reference};
use telamon::measure::knobs::Setting;
use telamon::measure::plan::{Candidate, Design, Variation, candidates, order};
use telamon::measure::series::{SLOPE_TOLERANCE, SlopeVerdict, UNBIASED_SLOPE};
use telamon::measure::summary::{Findings, Summary};

/// A room with a lamp, so that light arrives in several ways.
const ROOM: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <transform name="to_world">
            <lookat origin="0, 0, 0.9" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <float name="fov" value="80"/>
        <sampler type="independent"><integer name="sample_count" value="2"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="32"/>
            <integer name="height" value="24"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="cube">
        <boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="0.3" y="-0.6" z="0"/>
        <float name="radius" value="0.4"/>
        <bsdf type="diffuse"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="0.5"/>
            <rotate x="1" angle="90"/>
            <translate y="0.99"/>
        </transform>
        <emitter type="area"><rgb name="radiance" value="3"/></emitter>
    </shape>
</scene>
"#;

#[derive(Debug)]
struct NoProbe;

impl MemoryProbe for NoProbe {
    fn reset(&self) {}
    fn peak(&self) -> Option<u64> {
        None
    }
}

fn room() -> telamon::render::Description {
    load_text(ROOM, Path::new("room.xml"), &LoadOptions::default()).expect("valid").description
}

fn vary(knob: &str, values: &str) -> Variation {
    Variation { knob: knob.to_owned(), values: values.split(',').map(str::to_owned).collect() }
}

/// All runs of `candidates` of the room with `repeats` seeds each, against a reference of `reference_spp`
/// samples, and what they show. Times are
/// those of a machine that takes a microsecond for each ray and none to build.
fn experiment(
    choose: impl Fn(&Setting) -> Vec<Candidate>,
    repeats: u32,
    reference_spp: u32,
) -> (Vec<Run>, Findings) {
    let description = room();
    let base = Setting::of(&description, Backend::Rust.into(), 2).expect("a picture");
    let candidates = choose(&base);
    let mut bench =
        Bench::new(description, candidates.iter().map(|c| &c.setting), &NoProbe).expect("builds");
    let never = AtomicBool::new(false);
    let precise = Setting { samples_per_pixel: reference_spp, ..base };
    let reference =
        render_reference(&mut bench, &precise, 1, &|_| (), &never).expect("not cancelled");
    let runs: Vec<Run> = order(candidates.len(), repeats, 1)
        .into_iter()
        .map(|(c, repeat)| {
            let subject = (candidates[c].label(), &candidates[c].setting);
            let subject = (subject.0.as_str(), subject.1);
            let run = bench.run(subject, repeat, 1, &reference, &never).expect("not cancelled");
            Run { seconds: run.rays as f64 * 1e-6, build_seconds: 0.0, ..run }
        })
        .collect();
    let findings = Findings::of(&candidates, &runs, mean_error(&reference));
    (runs, findings)
}

/// Five doublings for three strategies that are all unbiased. The relative error of an MSE from 8 pictures
/// of 2304 numbers is about √(10/18432) = 2.3 % (a kurtosis of 10), that of its root half of it; six such
/// points over ln 32 give the slope to 1.2 %/√(Σ(x − x̄)²) = 1.2 %/2.9 = 0.004. Numbers of a pixel depend on
/// each other, and tails may be heavier: thrice that is still less than the tolerance of 0.03.
#[test]
fn unbiased_settings_have_the_slope_of_monte_carlo() {
    let choose = |base: &Setting| {
        let knobs = [vary("strategy", "bsdf,emitter,mis_power"), vary("spp", "1,2,4,8,16,32")];
        candidates(base, &knobs, Design::Grid).expect("valid")
    };
    let (_, findings) = experiment(choose, 8, 512);
    assert_eq!(findings.series.len(), 3);
    for series in &findings.series {
        let (slope, _) = series.slope.expect("six points");
        assert!((slope - UNBIASED_SLOPE).abs() <= SLOPE_TOLERANCE, "{series:?}");
        assert_eq!(series.verdict, Some(SlopeVerdict::AsExpected), "{series:?}");
    }
    for setting in &findings.settings {
        assert!(!setting.bias.is_biased, "{setting:?}");
        assert_eq!(setting.runs, 8);
    }
    // A closed room shows that sampling the lamp pays.
    let strategy = |name: &str| {
        let label = format!("strategy={name}, spp=8");
        findings.settings.iter().find(|s| s.setting == label).expect("measured").efficiency
    };
    assert!(strategy("bsdf").high < strategy("mis_power").low);
}

/// Paths that end after direct light lose what walls reflect to each other: named as biased with 8 seeds. So is
/// a path that may not end by chance but must after four edges. The base is not.
#[test]
fn a_depth_limit_is_named_as_biased() {
    let choose = |base: &Setting| {
        candidates(base, &[vary("max_depth", "2,4,-1")], Design::Grid).expect("valid")
    };
    let (runs, findings) = experiment(choose, 8, 512);
    let biased: Vec<_> =
        findings.settings.iter().filter(|s| s.bias.is_biased).map(|s| &s.setting).collect();
    assert_eq!(biased, ["max_depth=2", "max_depth=4"]);
    assert!(findings.settings[0].bias.relative < -0.1, "{:?}", findings.settings[0].bias);
    assert!(findings.base().is_some_and(|b| b.setting == "max_depth=-1"));
    // The verdict says so, and does not recommend them.
    let sentences = telamon::measure::report::verdict(&findings, &runs, 0.01);
    assert!(
        sentences.iter().any(|s| s.starts_with("\"max_depth=2\" is biased: ")),
        "{sentences:?}"
    );
}

/// Clamped samples are too dark, and said to be.
#[test]
fn clamped_samples_are_named_as_biased() {
    let choose = |base: &Setting| {
        candidates(base, &[vary("clamp", "none,0.25")], Design::Grid).expect("valid")
    };
    let (_, findings) = experiment(choose, 24, 1024);
    let [whole, clamped] = [&findings.settings[0].bias, &findings.settings[1].bias];
    assert!(!whole.is_biased && clamped.is_biased, "{whole:?} {clamped:?}");
    assert!(clamped.value < 0.0, "{clamped:?}");
}

/// Two names for one setting get seeds of their own, and are neither told apart nor called biased.
#[test]
fn equal_settings_are_not_told_apart() {
    let choose = |base: &Setting| {
        let twin = |name: &str| Candidate {
            choices: vec![("twin".to_owned(), name.to_owned())],
            setting: base.clone(),
            is_base: name == "1",
            in_base_series: name == "1",
        };
        ["1", "2", "3"].map(twin).to_vec()
    };
    let (runs, findings) = experiment(choose, 8, 256);
    for setting in &findings.settings {
        assert!(!setting.bias.is_biased, "{setting:?}");
        assert!(setting.compared.is_none_or(|c| !c.differs), "{setting:?}");
    }
    let mut seeds: Vec<_> = runs.iter().map(|r| r.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    assert_eq!(seeds.len(), 24);
    let different = |a: usize, b: usize| runs[a].metrics != runs[b].metrics;
    assert!(different(0, 1) && different(1, 2));
}

/// 60 experiments with pictures of 192 pixels at 8 seeds: a base, the same again, one that is biased and one with
/// twice the samples. With false alarms in one of a hundred experiments at most, 4 or more of 60 have one with a
/// probability of 0.0034, for each of both tests: below 0.01 for both together. What is biased or twice as
/// efficient is named so in all.
#[test]
fn false_alarms_are_rare_and_true_ones_are_not() {
    const EXPERIMENTS: u64 = 60;
    let mut description = room();
    description.resize(16, 12).expect("a size");
    let base = Setting::of(&description, Backend::Rust.into(), 1).expect("a picture");
    let candidate = |name: &str, knobs: &[(&str, &str)]| {
        let mut setting = base.clone();
        for (knob, value) in knobs {
            assert_eq!(setting.turn(knob, value), Ok(true));
        }
        let (is_base, in_base_series) = (name == "base", name == "base");
        let choices = vec![("case".to_owned(), name.to_owned())];
        Candidate { choices, setting, is_base, in_base_series }
    };
    let all = [
        candidate("base", &[]),
        candidate("twin", &[]),
        candidate("shallow", &[("max_depth", "2")]),
        candidate("double", &[("spp", "4")]),
    ];
    let mut bench =
        Bench::new(description, all.iter().map(|c| &c.setting), &NoProbe).expect("builds");
    let never = AtomicBool::new(false);
    let precise = Setting { samples_per_pixel: 4096, ..base };
    let reference = render_reference(&mut bench, &precise, 1, &|_| (), &never).expect("rendered");
    let (mut false_bias, mut false_difference) = (0, 0);
    for experiment in 0..EXPERIMENTS {
        let mut run = |(c, repeat): (usize, u32)| {
            let subject = (&*all[c].label(), &all[c].setting);
            let run = bench.run(subject, repeat, experiment, &reference, &never);
            // As if twice the samples took no longer.
            Run { seconds: 1.0, ..run.expect("not cancelled") }
        };
        let runs: Vec<Run> = order(all.len(), 8, experiment).into_iter().map(&mut run).collect();
        let findings = Findings::of(&all, &runs, mean_error(&reference));
        let [base, twin, shallow, double] = findings.settings.as_slice() else { panic!("four") };
        let differs = |s: &Summary| s.compared.is_some_and(|c| c.differs);
        assert!(shallow.bias.is_biased && differs(double), "{shallow:?} {double:?}");
        false_bias += u64::from([base, twin, double].iter().any(|s| s.bias.is_biased));
        false_difference += u64::from(differs(twin));
    }
    assert!(false_bias < 4 && false_difference < 4, "{false_bias} {false_difference}");
}

/// What is drawn from a description does not depend on what was drawn before, nor on the threads.
#[test]
fn a_run_can_be_made_again() {
    let choose = |base: &Setting| {
        let knobs = [vary("threads", "1,3"), vary("filter", "box,gaussian:0.5")];
        candidates(base, &knobs, Design::OneAtATime).expect("valid")
    };
    let (first, _) = experiment(choose, 2, 64);
    let (second, _) = experiment(choose, 2, 64);
    assert_eq!(first, second);
}

fn json(folder: &Folder, name: &str) -> Value {
    let text = fs::read(folder.path(name)).expect("written");
    serde_json::from_slice(&text).expect("JSON")
}

fn count(folder: &Folder) -> usize {
    json(folder, "out/measurements.json")["runs"].as_array().expect("a list").len()
}

#[test]
fn an_experiment_is_shown_kept_and_continued() {
    let folder = Folder::with_scene(ROOM);
    let command = "measure scene.xml --backend rust --vary strategy=bsdf,mis_power --vary spp=1,4 \
                   --repeats 2 --reference-spp 64 --seed 3 --report out";
    let run = folder.succeed(command);
    assert!(run.stderr.ends_with("report: out/report.html\n"), "{}", run.stderr);
    for part in [
        "strategy=bsdf, spp=1 ",
        "strategy=mis_power, spp=4 ",
        "\nAn error of 10 % of a pixel's brightness (relMSE 0.01) takes ",
        "From 2 seeds for each setting. ",
    ] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    assert_eq!(count(&folder), 2 * 4);
    let csv = fs::read_to_string(folder.path("out/runs.csv")).expect("written");
    assert_eq!(csv.lines().count(), 1 + 2 * 4);
    assert!(csv.contains("\n\"strategy=bsdf, spp=1\",0,"), "{csv}");
    let findings = json(&folder, "out/findings.json");
    assert_eq!(findings["settings"].as_array().expect("a list").len(), 4);
    let page = fs::read_to_string(folder.path("out/report.html")).expect("written");
    for part in ["<svg ", "data:image/png;base64,", "Rust BVH", "--repeats 2", "</html>"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("http"), "it needs nothing else");
    let before = json(&folder, "out/measurements.json");

    // The same again measures nothing; one more repetition adds one run of each setting.
    folder.succeed(command);
    assert_eq!(json(&folder, "out/measurements.json"), before);
    folder.succeed(&command.replace("--repeats 2", "--repeats 3"));
    assert_eq!(count(&folder), 3 * 4);
    let after = json(&folder, "out/measurements.json");
    assert_eq!(
        after["runs"].as_array().expect("a list")[..8],
        *before["runs"].as_array().expect("a list")
    );

    let told = folder.fail(&command.replace("--seed 3", "--seed 4"), 1);
    assert_eq!(
        told,
        "error: `out` holds measurements of something else: its seed is 3, now 4 (expected another folder)\n"
    );
    fs::write(folder.path("out/measurements.json"), "{").expect("writable");
    let told = folder.fail(command, 1);
    assert!(told.starts_with("error: cannot read `out/measurements.json`: "), "{told}");
}

/// Scenes whose pictures have no noise, no light, or light that one strategy cannot find: what is shown are
/// numbers, and what is said is so.
#[test]
fn scenes_without_noise_or_light_are_judged_soundly() {
    let furnace = SCENE.replace(
        r#"<bsdf type="diffuse"/>"#,
        r#"<bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf>"#,
    );
    let dark = SCENE.replace(r#"<emitter type="constant"/>"#, "");
    let point = r#"<emitter type="point"><point name="position" x="2" y="3" z="4"/></emitter>"#;
    let point = SCENE.replace(r#"<emitter type="constant"/>"#, point);
    let exact = "Errors of less than half the reference's own noise, which are hardly known and count as that \
                 half: \"strategy=bsdf, spp=1\"; ";
    for (name, scene, expected) in [
        ("dark", dark, "An error of 10 % of a pixel's brightness (relMSE 0.01) takes "),
        ("furnace", furnace, exact),
        ("point", point, "\"strategy=bsdf, spp=1\" is biased: its mean is off by −100 % ± "),
    ] {
        let folder = Folder::with_scene(&scene);
        let command = "measure scene.xml --backend rust --vary strategy=bsdf,mis_power --vary spp=1,2,4 \
                       --repeats 4 --report out";
        let run = folder.succeed(command);
        assert!(run.stdout.contains(expected), "{name}: {}", run.stdout);
        let page = fs::read_to_string(folder.path("out/report.html")).expect("written");
        for text in [&run.stdout, &page] {
            assert!(
                !text.contains("NaN") && !text.contains("inf ") && !text.contains("(inf"),
                "{name}: {text}"
            );
        }
        let biased = run.stdout.matches(" is biased: ").count();
        assert_eq!(biased, if name == "point" { 3 } else { 0 }, "{name}: {}", run.stdout);
        // It can be continued.
        folder.succeed(command);
    }
}

#[test]
fn ctrl_c_keeps_what_was_measured() {
    let folder = Folder::with_scene(ROOM);
    let command = "measure scene.xml --backend rust --vary spp=64,128 --repeats 10000 \
                   --reference-spp 16 --report out";
    folder.interrupt(command, |run| {
        run.code == Some(130) && folder.path("out/measurements.json").exists()
    });
    assert!(count(&folder) > 0);
}

#[test]
fn references_can_come_from_files() {
    let folder = Folder::with_scene(ROOM);
    folder.succeed("render scene.xml -q --backend rust -o r.exr --spp 256 --seed 9");
    let command = "measure scene.xml --backend rust --vary spp=1 --repeats 2 --reference r.exr";
    let run = folder.succeed(&format!("{command} --crop 4,4,8,8"));
    assert!(
        run.stderr.starts_with("warning: `r.exr` does not say how noisy it is"),
        "{}",
        run.stderr
    );
    assert_eq!(
        folder.fail(&format!("{command} --size 8x8"), 1),
        "error: cannot measure `scene.xml` against `r.exr`: a film of 8x8 pixels cannot be compared with \
         one of 32x24\n"
    );
    assert!(
        folder.fail(&command.replace("r.exr", "none.exr"), 1).contains("cannot read `none.exr`")
    );
}

#[test]
fn what_makes_no_sense_is_said_before_anything_is_rendered() {
    let folder = Folder::with_scene(ROOM);
    for (arguments, message) in [
        (
            "--vary branches=2,4",
            "knob `branches` changes nothing: only integrator `branching` has it",
        ),
        (
            "--set branches=5 --vary spp=1",
            "knob `branches` changes nothing: only integrator `branching` has it",
        ),
        ("--vary spp=1,1", "`spp=1` is given twice"),
        ("--set spp=1 --set spp=2", "knob `spp` is given twice"),
        (
            "--vary spp=1 --report no/out",
            "cannot create the folder `no/out`: No such file or directory (os error 2)",
        ),
    ] {
        let told = folder.fail(&format!("measure scene.xml {arguments}"), 1);
        assert_eq!(told, format!("error: {message}\n"));
    }
    let told = folder.fail("measure scene.xml --vary spp=0", 1);
    assert_eq!(told, "error: knob `spp` cannot be `0` (expected a whole number from 1)\n");
    let told = folder.fail("measure scene.xml --vary depth=2", 1);
    assert!(
        told.starts_with("error: there is no knob `depth` (expected one of: spp, backend, "),
        "{told}"
    );
    let told = folder.fail("measure scene.xml --vary spp", 2);
    assert!(
        told.contains("expected a knob, an equals sign and values with commas between"),
        "{told}"
    );
    let layers = r#"<integrator type="aov"><string name="aovs" value="z:depth"/></integrator>"#;
    let folder = Folder::with_scene(&SCENE.replace(r#"<integrator type="path"/>"#, layers));
    assert_eq!(
        folder.fail("measure scene.xml --vary spp=1,2", 1),
        "error: the scene makes layers but no picture, and layers have no noise to be measured\n"
    );
}
