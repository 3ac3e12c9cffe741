//! `telamon compare`, as a user meets it.

mod support;

use support::command::Folder;
use telamon::film::exr::{Metadata, write_exr};
use telamon::film::picture::{Channel, Picture, Values};
use telamon::film::read::read_exr;
use telamon::film::{ComponentFormat, Crop};

/// Writes grey pixels on a film of 4x3, from `x` on in row 1, with a variance of `variance` for each of 4
/// samples.
fn write(folder: &Folder, name: &str, x: u32, values: &[f32], variance: Option<f32>) {
    let width = values.len() as u32;
    let color = |name: &str| Channel::new(name, Values::Color(values.to_vec()));
    let mut channels = vec![color("R"), color("G"), color("B")];
    if let Some(v) = variance {
        let layer = |name: &str| Channel::new(name, Values::Float(vec![v; values.len()]));
        channels.extend(["variance.R", "variance.G", "variance.B"].map(layer));
        channels.push(Channel::new("samples.N", Values::Index(vec![4; values.len()])));
    }
    let crop = Crop { x, y: 1, width, height: 1 };
    let component = ComponentFormat::Float;
    let picture = Picture { width: 4, height: 3, crop, channels, component };
    write_exr(&folder.path(name), &picture, &Metadata::default()).expect("writable");
}

/// Two pixels, 1 against 2 and 0.5 against 0.5, by hand: MSE 1/2, relMSE 1/4.01/2, SMAPE 1/3.01/2.
#[test]
fn metrics_are_listed() {
    let folder = Folder::new();
    write(&folder, "a.exr", 1, &[1.0, 0.5], None);
    write(&folder, "b.exr", 0, &[7.0, 2.0, 0.5], None);
    let run = folder.succeed("compare a.exr b.exr");
    assert_eq!(run.stderr, "");
    let flip = run.stdout.lines().find(|l| l.trim_start().starts_with("FLIP")).expect("a line");
    let expected = format!(
        "a.exr against b.exr
  pixels                                    2
  MSE                               5.0000e-1
  RMSE                              7.0711e-1
  relMSE                            1.2469e-1
  relMSE without the worst 0.1 %    1.2469e-1
  relative squared error, 99.9 %    2.4938e-1
  relative squared error, largest   2.4938e-1
  SMAPE                              0.166113
{flip}
  bias                             -5.0000e-1
  standard error of the bias        5.0000e-1
  bias over the mean                -40.000 %
  p-value if there is no bias        5.000e-1
"
    );
    assert_eq!(run.stdout, expected);
}

/// The reference has a variance of 0.4 for each of 4 samples, hence 0.1 for its pixels: the MSE of 0.5 is
/// 0.4 without it.
#[test]
fn two_pictures_are_measured_against_a_third() {
    let folder = Folder::new();
    write(&folder, "a.exr", 1, &[1.0, 0.5], Some(4.0));
    write(&folder, "b.exr", 1, &[2.0, 0.5], Some(4.0));
    write(&folder, "r.exr", 0, &[7.0, 2.0, 0.5], Some(0.4));
    let run = folder.succeed("compare a.exr b.exr --reference r.exr -o d.png");
    let starts = |start: &str| {
        let line = run.stdout.lines().find(|l| l.trim_start().starts_with(start));
        line.unwrap_or_else(|| panic!("{}", run.stdout)).split_whitespace().collect::<Vec<_>>()
    };
    assert_eq!(run.stdout.lines().next(), Some("A = a.exr, B = b.exr against r.exr"));
    assert_eq!(starts("MSE without")[5..], ["4.0000e-1", "-1.0000e-1"]);
    // z = −1/√(1 + 1) in three of six numbers.
    assert_eq!(
        run.stdout.lines().last(),
        Some(
            "A and B agree within their noise: 0 of 6 numbers differ beyond chance (p < 1.67e-3 each, 0.01 \
             for all; 0.25 % may). Mean z squared 0.250."
        )
    );
    // A to the left: darker in its first pixel (blue), equal in its second; B is equal.
    let (width, height, bytes) = folder.png("d.png");
    assert_eq!((width, height), (4, 1));
    assert!(bytes[2] > 200 && bytes[0] < bytes[2], "{bytes:?}");
    assert_eq!(bytes[3..], [0; 9]);
}

/// A single pixel has no spread, a black reference no mean to compare with, and a picture without a variance is
/// said to count as exact.
#[test]
fn what_is_not_known_is_said() {
    let folder = Folder::new();
    write(&folder, "a.exr", 0, &[1.0], None);
    write(&folder, "b.exr", 0, &[0.0], Some(1.0));
    let run = folder.succeed("compare a.exr b.exr");
    for name in ["standard error of the bias", "bias over the mean", "p-value if there is no bias"]
    {
        let line = run.stdout.lines().find(|l| l.trim_start().starts_with(name)).expect("a line");
        assert!(line.ends_with(" unknown"), "{line}");
    }
    // z = 1/√(1/4).
    let expected = "A and B agree within their noise: 0 of 3 numbers differ beyond chance (p < 3.34e-3 each, 0.01 \
                    for all; 0.25 % may). Mean z squared 4.000. A does not say how noisy it is and counts as exact.";
    assert_eq!(run.stdout.lines().last(), Some(expected));
}

#[test]
fn differences_beyond_noise_are_told() {
    let folder = Folder::new();
    write(&folder, "a.exr", 0, &[1.0, 0.5], Some(0.01));
    write(&folder, "b.exr", 0, &[2.0, 0.5], Some(0.01));
    let run = folder.succeed("compare a.exr b.exr");
    let last = run.stdout.lines().last().expect("a line");
    let expected = "A and B differ by more than their noise: 3 of 6 numbers differ beyond chance";
    assert!(last.starts_with(expected), "{last}");
    assert_eq!(run.stderr, "");
}

/// Infinities and NaN on one side are no agreement, in colours, in variances and in other layers.
#[test]
fn what_is_not_finite_never_agrees() {
    let folder = Folder::new();
    let last = |a: &str, b: &str| {
        let run = folder.succeed(&format!("compare {a} {b}"));
        (run.stdout.lines().last().expect("a line").to_owned(), run.stderr)
    };
    write(&folder, "good.exr", 0, &[1.0, 0.5], Some(1.0));
    write(&folder, "bright.exr", 0, &[1.0, f32::INFINITY], Some(1.0));
    let (verdict, warning) = last("good.exr", "bright.exr");
    assert_eq!(
        verdict,
        "A and B differ by more than their noise: 0 of 3 numbers differ beyond chance (p < 3.34e-3 each, 0.01 for \
         all; 0.25 % may). Mean z squared 0.000. 3 more numbers are finite in one of them only."
    );
    assert_eq!(warning, "warning: `good.exr`: pixels that are not finite and are left out: 1\n");
    write(&folder, "single.exr", 0, &[1.0, 0.5], Some(f32::INFINITY));
    let (verdict, warning) = last("single.exr", "good.exr");
    assert_eq!(
        verdict,
        "A and B cannot be said to agree: 0 of 0 numbers differ beyond chance (p < 1.00e-2 each, 0.01 for all; \
         0.25 % may). Mean z squared unknown. 6 more numbers or their variances are not finite, so that nothing \
         can be said of them."
    );
    for c in ["R", "G", "B"] {
        let line = format!("layer `variance.{c}`: numbers that are finite in one picture only: 2");
        assert!(warning.contains(&line), "{warning}");
    }
    let error = folder.fail("compare good.exr single.exr", 1);
    assert_eq!(
        error.lines().last().expect("a line").to_owned() + "\n",
        "error: `good.exr`: no pixel is finite in both pictures, with a finite variance in the reference\n"
    );
    // A layer that the test does not use.
    for (name, depth) in [("near.exr", 1.0), ("far.exr", f32::INFINITY)] {
        write(&folder, name, 0, &[1.0, 0.5], Some(1.0));
        let mut picture = read_exr(&folder.path(name)).expect("readable");
        picture.channels.push(Channel::new("depth.T", Values::Float(vec![depth, 2.0])));
        write_exr(&folder.path(name), &picture, &Metadata::default()).expect("writable");
    }
    let (verdict, warning) = last("near.exr", "far.exr");
    assert!(verdict.starts_with("A and B cannot be said to agree: 0 of 6 numbers"), "{verdict}");
    assert!(
        warning.contains("layer `depth.T`: numbers that are finite in one picture only: 1"),
        "{warning}"
    );
}

/// Samples that are spread evenly say less of the noise of their mean.
#[test]
fn even_samples_are_pointed_out() {
    let folder = Folder::new();
    write(&folder, "a.exr", 0, &[1.0, 0.5], Some(0.01));
    write(&folder, "b.exr", 0, &[1.0, 0.5], None);
    let metadata = Metadata { sampler: "sobol".to_owned(), ..Metadata::default() };
    for name in ["a.exr", "b.exr"] {
        let picture = read_exr(&folder.path(name)).expect("readable");
        write_exr(&folder.path(name), &picture, &metadata).expect("writable");
    }
    assert_eq!(
        folder.succeed("compare a.exr b.exr").stderr,
        "warning: `a.exr` was rendered with sampler `sobol`, so it is less noisy than its variance says \
         (expected one of `telamon render --variance --sampler independent`)\n"
    );
}

#[test]
fn what_cannot_be_compared_is_said() {
    let folder = Folder::new();
    write(&folder, "a.exr", 0, &[1.0, 0.5], None);
    write(&folder, "b.exr", 1, &[1.0, 0.5], None);
    write(&folder, "nan.exr", 0, &[f32::NAN; 2], None);
    assert_eq!(
        folder.fail("compare a.exr b.exr", 1),
        "error: cannot compare `a.exr` with `b.exr`: pixels 2x1 at 0,1 are not within pixels 2x1 at 1,1 \
         of the other picture\n"
    );
    assert_eq!(
        folder.fail("compare a.exr nan.exr", 1),
        "error: `a.exr`: no pixel is finite in both pictures\n"
    );
    assert_eq!(
        folder.fail("compare a.exr none.exr", 1),
        "error: cannot read `none.exr`: No such file or directory (os error 2)\n"
    );
    assert_eq!(
        folder.fail("compare a.exr scene.xml", 1),
        "error: cannot read `scene.xml`: file identifier missing (expected an OpenEXR file)\n"
    );
    assert_eq!(
        folder.fail("compare a.exr a.exr -o no/d.png", 1),
        "error: cannot write `no/d.png`: there is no folder `no`\n"
    );
    folder.succeed("render scene.xml -o c.exr");
    assert_eq!(
        folder.fail("compare a.exr c.exr", 1),
        "error: cannot compare `a.exr` with `c.exr`: a film of 4x3 pixels cannot be compared with one \
         of 32x24\n"
    );
}

/// Two seeds of one scene, from the command to the command.
#[test]
fn renders_can_be_compared() {
    let folder = Folder::new();
    folder.succeed("render scene.xml -o a.exr --seed 1");
    folder.succeed("render scene.xml -o b.exr --seed 2");
    folder.succeed("render scene.xml -o r.exr --spp 256 --seed 3");
    let run = folder.succeed("compare a.exr b.exr --reference r.exr -o d.exr");
    let line = run.stdout.lines().find(|l| l.contains("  RMSE")).expect("a line");
    let errors: Vec<f64> =
        line.split_whitespace().skip(1).map(|v| v.parse().expect("a number")).collect();
    // Equally many samples: their errors differ by a few percent of sampling noise.
    assert!(errors[0] > 0.0 && (errors[0] / errors[1] - 1.0).abs() < 0.5, "{line}");
    assert_eq!(folder.names(), ["a.exr", "b.exr", "d.exr", "r.exr"]);
}
