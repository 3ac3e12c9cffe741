//! What is written down can be fired again.

use std::fs;
use std::path::Path;

use telamon::parity::{
    Contender, Disagreement, Family, Generated, RaySource, RecordWriter, Recorded,
};
use telamon::ray::Ray;

use crate::testers::{Flaw, Flawed};
use crate::{compare, meshes};

fn record(path: &Path, contenders: &[Contender<'_>], disagreements: &[Disagreement]) {
    let mut recorder = RecordWriter::create(path, contenders).expect("writable");
    disagreements.iter().for_each(|d| recorder.write(d).expect("there is room"));
    recorder.finish().expect("there is room");
}

/// What is written down is fired again: the same rays, bit for bit, the same answers, the same classes.
#[test]
fn a_report_can_be_replayed() {
    let shapes = [meshes::cube()];
    let engine = Flawed::new(&shapes, Some(Flaw::Leaks));
    let contenders = [Contender::new(&engine)];
    let rays = Generated::new(&shapes, None, 6, 3_000);
    let (_, first) = compare(&shapes, &contenders, &rays);
    assert!(first.len() > 30);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rays.jsonl");
    record(&path, &contenders, &first);

    let recorded = Recorded::read(&path).expect("our own");
    let (report, second) = compare(&shapes, &contenders, &recorded);
    assert_eq!(report.rays, first.len() as u64);
    assert_eq!(first.len(), second.len());
    for (a, b) in first.iter().zip(&second) {
        assert_eq!(bits(&a.ray), bits(&b.ray));
        assert_eq!((a.family, a.crossed, &a.answers), (b.family, b.crossed, &b.answers));
    }

    // A file of rays alone, as another program may write them.
    fs::write(
        &path,
        r#"{"index": 0, "family": "pair", "origin": ["0x0p+0", "-0x0p+0", "-0x1.8p+1"],
            "direction": ["0x0p+0", "0x0p+0", "0x1p+0"], "t_min": "0x1p-126", "t_max": "inf", "time": "0x0p+0"}"#
            .replace('\n', " "),
    )
    .expect("writable");
    let half_line = Ray::new(glam::Vec3A::new(0.0, -0.0, -3.0), glam::Vec3A::Z);
    let (_, ray) = Recorded::read(&path).expect("complete").ray(0);
    assert_eq!(bits(&ray), bits(&half_line));
    // And as a person may.
    fs::write(
        &path,
        r#"{"origin": [0, -0.0, -3e0], "direction": [0, 0, 1.00000001], "t_max": 0.1}"#,
    )
    .expect("writable");
    let (family, ray) = Recorded::read(&path).expect("enough").ray(0);
    assert_eq!((family, bits(&ray)), (Family::Pair, bits(&half_line.until(0.1))));
}

fn bits(ray: &Ray) -> Vec<u32> {
    let vectors = [ray.origin, ray.direction].into_iter().flat_map(|v| v.to_array());
    vectors.chain([ray.t_min, ray.t_max, ray.time]).map(f32::to_bits).collect()
}

#[test]
fn what_is_no_record_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rays.jsonl");
    let line = r#"{"index":0,"family":"pair","origin":["0x1p+0","0x1p+0","0x1p+0"],"direction":["0x1p+0","0x1p+0","0x1p+0"],"t_min":"0x0p+0","t_max":"inf","time":"0x0p+0"}"#;
    let name = path.display();
    for (text, message) in [
        (
            line.replace("inf", "1.5"),
            "column 136: `1.5` is not exactly an f32 (expected a hexadecimal float such as 0x1.8p+1, inf or \
             nan)",
        ),
        (
            line.replace("pair", "pear"),
            "column 26: unknown variant `pear`, expected one of `camera`, `pair`, `bounce`, `vertex`, \
             `edge`, `axis`, `grazing`, `inside`, `far`, `segment`",
        ),
        (line.replace("\"origin\"", "\"start\""), "column 152: missing field `origin`"),
        ("7".to_owned(), "column 1: invalid type: integer `7`, expected a ray"),
        ("{".to_owned(), "column 1: EOF while parsing an object"),
    ] {
        fs::write(&path, format!("{line}\n\n{text}\n")).expect("writable");
        let error = Recorded::read(&path).expect_err("no record").to_string();
        assert_eq!(error, format!("`{name}`, line 3, {message}"));
    }
    let none = folder.path().join("none");
    let error = Recorded::read(&none).expect_err("not there").to_string();
    let reason = "No such file or directory (os error 2)";
    assert_eq!(error, format!("cannot read `{}`: {reason}", none.display()));
}
