//! All formats: the same cube in all spellings, the options, large and damaged files.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{DAffine3, DVec3, Vec2, Vec3, Vec3A};

use super::serialized::tests as serialized;
use super::*;

mod others;

type Load = fn(&Path, &MeshOptions) -> Result<LoadedMesh, MeshFileError>;

/// The corners of the unit cube: bit 0 is x, bit 1 is y, bit 2 is z.
fn corner(i: usize) -> [f64; 3] {
    [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f64)
}

/// The cube's sides, seen counter-clockwise from outside.
const QUADS: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn cube_obj() -> String {
    let mut text = String::from("# a cube\nmtllib cube.mtl\no cube\n");
    for [x, y, z] in (0..8).map(corner) {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    text += "g sides\nusemtl grey\ns off\n";
    for [a, b, c, d] in QUADS.map(|quad| quad.map(|i| i + 1)) {
        let _ = writeln!(text, "f {a} {b} {c} {d}");
    }
    text
}

/// A PLY cube with properties and elements that must be skipped.
fn cube_ply(format: &str) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat {format} 1.0\ncomment a cube\nobj_info nothing\n\
         element camera 1\nproperty list ushort short numbers\nproperty char sign\n\
         element vertex 8\nproperty double x\nproperty uchar red\nproperty float y\n\
         property list uint8 float32 weights\nproperty int8 z\n\
         element face 6\nproperty list uchar double weights\n\
         property list uchar uint vertex_indices\nproperty ushort flags\nend_header\n"
    )
    .into_bytes();
    let mut records = vec![vec![(2.0, "u16"), (-300.0, "i16"), (7.0, "i16"), (-1.0, "i8")]];
    for (i, [x, y, z]) in (0..8).map(corner).enumerate() {
        let mut record = vec![(x, "f64"), (9.0, "u8"), (y, "f32"), ((i % 3) as f64, "u8")];
        record.extend(vec![(0.5, "f32"); i % 3]);
        record.push((z, "i8"));
        records.push(record);
    }
    for quad in QUADS {
        let mut record = vec![(1.0, "u8"), (0.25, "f64"), (4.0, "u8")];
        record.extend(quad.map(|i| (f64::from(i), "u32")));
        record.push((1000.0, "u16"));
        records.push(record);
    }
    for record in records {
        for (value, scalar) in record {
            if format == "ascii" {
                file.extend(format!("{value} ").bytes());
                continue;
            }
            let mut bytes = match scalar {
                "i8" => (value as i8).to_le_bytes().to_vec(),
                "u8" => (value as u8).to_le_bytes().to_vec(),
                "i16" => (value as i16).to_le_bytes().to_vec(),
                "u16" => (value as u16).to_le_bytes().to_vec(),
                "u32" => (value as u32).to_le_bytes().to_vec(),
                "f32" => (value as f32).to_le_bytes().to_vec(),
                _ => value.to_le_bytes().to_vec(),
            };
            if format == "binary_big_endian" {
                bytes.reverse();
            }
            file.extend(bytes);
        }
        if format == "ascii" {
            file.push(b'\n');
        }
    }
    file
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("a Vec takes all")
}

/// Loads a file that holds `bytes`. Its name says nothing about compression.
pub(super) fn load_bytes(
    load: Load,
    bytes: &[u8],
    options: &MeshOptions,
) -> Result<LoadedMesh, MeshFileError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mesh");
    fs::write(&path, bytes).expect("a temporary file");
    load(&path, options)
}

pub(super) fn mesh(load: Load, bytes: impl AsRef<[u8]>) -> TriangleMesh {
    load_bytes(load, bytes.as_ref(), &MeshOptions::default()).expect("a good file").mesh
}

/// The error's text, with the file's name left out.
pub(super) fn message(load: Load, bytes: impl AsRef<[u8]>) -> String {
    let error = load_bytes(load, bytes.as_ref(), &MeshOptions::default()).expect_err("a bad file");
    let path = error.path().display().to_string();
    error.to_string().replacen(&path, "", 1)
}

fn assert_is_cube(mesh: &TriangleMesh, what: &str) {
    let positions: Vec<_> = (0..8).map(|i| Vec3A::from(corner(i).map(|x| x as f32))).collect();
    let fans = QUADS.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    assert_eq!(mesh.positions(), positions, "{what}");
    assert_eq!(mesh.triangles(), fans.as_flattened(), "{what}");
    assert!(mesh.normals().is_empty() && mesh.uvs().is_empty(), "{what}");
}

#[test]
fn every_spelling_gives_the_same_cube() {
    let obj = cube_obj();
    let ascii = String::from_utf8(cube_ply("ascii")).expect("ASCII");
    let negative =
        QUADS.map(|q| q.map(|i| i64::from(i) - 8)).iter().fold(
            obj.split("f ").next().expect("a first piece").to_owned(),
            |text, [a, b, c, d]| text + &format!("f {a} {b} {c} {d}\n"),
        );
    let files: [(&str, Load, Vec<u8>); 13] = [
        ("obj", load_obj, obj.clone().into()),
        ("obj, CRLF", load_obj, obj.replace('\n', "\r\n").into()),
        (
            "obj, continued",
            load_obj,
            obj.replace("# a cube", "#").replace(' ', " \\\n ").replace('#', "#\\").into(),
        ),
        ("obj, continued, CRLF", load_obj, obj.replace(" 1", "\\\r\n 1").into()),
        ("obj, comments", load_obj, obj.replace("\nv", " # \\\n\n\t v").into()),
        ("obj, negative", load_obj, negative.into()),
        ("obj, no last newline", load_obj, obj.trim_end().into()),
        ("obj.gz", load_obj, gzip(obj.as_bytes())),
        ("ply", load_ply, ascii.clone().into()),
        ("ply, CRLF", load_ply, ascii.replace('\n', "\r\n").trim_end().into()),
        ("ply, little", load_ply, cube_ply("binary_little_endian")),
        ("ply, big", load_ply, cube_ply("binary_big_endian")),
        ("ply.gz", load_ply, gzip(&cube_ply("binary_big_endian"))),
    ];
    for (what, load, bytes) in files {
        assert_is_cube(&mesh(load, bytes), what);
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0.25\nvt 1 0\nvt 0 1\nvn 0 0 1\n\
                        f 1/1/1 2/2/1 3/3/1\n";

fn triangle(options: &MeshOptions) -> TriangleMesh {
    load_bytes(load_obj, TRIANGLE.as_bytes(), options).expect("a good file").mesh
}

/// The values are what Mitsuba 3.9.1 gives for the same file: a mirror leaves the winding alone,
/// vertex normals stay outside, and `flip_normals` turns both.
#[test]
fn options_act_as_in_mitsuba() {
    let plain = triangle(&MeshOptions::default());
    assert_eq!((plain.triangles(), plain.normals()), (&[[0, 1, 2]][..], &[Vec3::Z; 3][..]));
    assert_eq!(plain.uvs()[0], Vec2::new(0.0, 0.25));

    let to_world = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mirrored = triangle(&MeshOptions { to_world, ..Default::default() });
    assert_eq!(mirrored.positions()[1], Vec3A::NEG_X);
    assert_eq!((mirrored.triangles(), mirrored.normals()), (&[[0, 1, 2]][..], &[Vec3::Z; 3][..]));

    let flipped = triangle(&MeshOptions { flip_normals: true, ..Default::default() });
    assert_eq!((flipped.triangles(), flipped.normals()), (&[[0, 2, 1]][..], &[Vec3::NEG_Z; 3][..]));

    let faceted = triangle(&MeshOptions { face_normals: true, ..Default::default() });
    assert!(faceted.normals().is_empty() && !faceted.uvs().is_empty());

    let turned = triangle(&MeshOptions { flip_tex_coords: true, ..Default::default() });
    assert_eq!(turned.uvs(), [Vec2::new(0.0, 0.75), Vec2::new(1.0, 1.0), Vec2::ZERO]);
}

#[test]
fn normals_stay_perpendicular_when_squeezed() {
    let file = "v 0 0 0\nv 1 0 -1\nv 0 1 0\nvn 3 0 3\nf 1//1 2//1 3//1\n";
    let to_world = DAffine3::from_scale(DVec3::new(4.0, 1.0, 1.0));
    let options = MeshOptions { to_world, ..Default::default() };
    let mesh = load_bytes(load_obj, file.as_bytes(), &options).expect("a good file").mesh;
    let expected = DVec3::new(1.0, 0.0, 4.0).normalize().as_vec3();
    // One rounding to f32 of a value with an error of a few ulps of f64.
    assert!((mesh.normals()[0] - expected).abs().max_element() <= f32::EPSILON);
}

#[test]
fn positions_are_rounded_once() {
    // 16777217 is no f32, but 16777217 - 16777216 is.
    let file = "v 16777217 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let to_world = DAffine3::from_translation(DVec3::new(-16_777_216.0, 0.0, 0.0));
    let options = MeshOptions { to_world, ..Default::default() };
    let mesh = load_bytes(load_obj, file.as_bytes(), &options).expect("a good file").mesh;
    assert_eq!(mesh.positions()[0].x, 1.0);
}

#[test]
fn triangles_without_area_or_value_are_counted() {
    let file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 1e39 0 0\nv 0 0 -2e18\nf 1 2 3\nf 1 2 4\nf 1 5 2\n\
         f 1 2 2\nf 6 1 2\n";
    let loaded = load_bytes(load_obj, file.as_bytes(), &MeshOptions::default()).expect("a mesh");
    assert_eq!(loaded.dropped, Dropped { not_finite: 2, too_large: 1, degenerate: 1 });
    assert_eq!(loaded.mesh.triangles(), [[0, 1, 2]]);
}

/// A grid of `side` by `side` vertices; triangles behind each row, with indices from the end.
fn grid_obj(side: u32) -> (String, Vec<Vec3A>, Vec<[u32; 3]>) {
    let (mut text, mut positions, mut triangles) = (String::new(), Vec::new(), Vec::new());
    for y in 0..side {
        for x in 0..side {
            let p = Vec3A::new(x as f32 * 0.37, y as f32 * 0.11, ((x * y) % 7) as f32);
            let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
            positions.push(p);
        }
        for x in 0..if y == 0 { 0 } else { side - 1 } {
            let a = (y - 1) * side + x;
            let (end, b, c) = (i64::from((y + 1) * side), a + 1, a + side);
            let from_end = |i: u32| i64::from(i) - end;
            let _ = writeln!(text, "f {} {} {}", from_end(a), b + 1, from_end(c));
            triangles.push([a, b, c]);
        }
    }
    (text, positions, triangles)
}

#[test]
fn any_number_of_threads_gives_the_same_mesh() {
    // More than two blocks of 2 MiB, of many parts each.
    let (text, positions, triangles) = grid_obj(400);
    assert!(text.len() > 5 << 20, "only {} bytes", text.len());
    let mut bad = text.clone();
    bad.push_str("f 1 2 160001\n");
    let last = text.lines().count() + 1;
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mesh = mesh(load_obj, &text);
            assert!(mesh.positions() == positions && mesh.triangles() == triangles);
            assert_eq!(
                message(load_obj, &bad),
                format!(":{last}:7: vertex index 160001 is out of range (there are 160000)"),
            );
        });
    }
}

#[test]
fn errors_say_where() {
    let text = format!("v 1 2 3\r\nv 1 2 x{} # y\r\n", "z".repeat(500));
    let error = load_bytes(load_obj, text.as_bytes(), &MeshOptions::default()).expect_err("bad");
    assert_eq!((error.line(), error.column(), error.byte_offset()), (Some(2), Some(7), None));
    let line = error.source_line().expect("a line");
    assert!(line.starts_with("v 1 2 xzz") && line.ends_with("zz…"), "{line}");
    assert!(line.len() < 200, "{line}");
}

#[test]
fn files_that_cannot_be_read_are_errors() {
    for load in [load_obj as Load, load_ply, |path, o| load_serialized(path, 1, o)] {
        let error = load(Path::new("no/such/mesh"), &MeshOptions::default()).expect_err("no file");
        assert!(error.to_string().starts_with("no/such/mesh: cannot be read: "), "{error}");
        assert!(matches!(error.problem(), MeshProblem::Io(_)) && error.line().is_none());
    }
    let compressed = gzip(cube_obj().as_bytes());
    let cut = message(load_obj, &compressed[..compressed.len() / 2]);
    assert!(cut.starts_with(": cannot be read: "), "{cut}");
    let endless = vec![b'1'; 33 << 20];
    assert_eq!(
        message(load_obj, endless),
        ": a line of more than 33554432 bytes (is this a text file?)"
    );
}

/// Damages a file in up to four places.
fn damage(file: &[u8], random: &mut impl FnMut(usize) -> usize) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for _ in 0..=random(4) {
        if bytes.is_empty() {
            break;
        }
        let at = random(bytes.len());
        match random(5) {
            0 => bytes[at] ^= 1 << random(8),
            1 => drop(bytes.remove(at)),
            2 => bytes.insert(at, random(256) as u8),
            // What a format gives a meaning to.
            3 => bytes[at] = b"0123456789-+.eE/\\#\n\r \xff\0"[random(23)],
            _ => bytes.truncate(at),
        }
    }
    bytes
}

#[test]
fn damaged_files_do_no_harm() {
    let files: [(&str, Load, Vec<u8>); 9] = [
        ("obj", load_obj, cube_obj().into()),
        ("obj with attributes", load_obj, TRIANGLE.into()),
        ("obj.gz", load_obj, gzip(cube_obj().as_bytes())),
        ("ascii ply", load_ply, cube_ply("ascii")),
        ("little-endian ply", load_ply, cube_ply("binary_little_endian")),
        ("big-endian ply", load_ply, cube_ply("binary_big_endian")),
        ("ply.gz", load_ply, gzip(&cube_ply("ascii"))),
        ("serialized, 3", |path, o| load_serialized(path, 0, o), serialized::example(3)),
        ("serialized, 4", |path, o| load_serialized(path, 1, o), serialized::example(4)),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("mesh");
    for (what, load, file) in files {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut random = |below: usize| {
            // Knuth's MMIX generator; its upper bits are good enough to choose with.
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        let (mut good, mut bad) = (0, 0);
        for _ in 0..2000 {
            fs::write(&path, damage(&file, &mut random)).expect("a temporary file");
            match load(&path, &MeshOptions::default()) {
                Ok(loaded) => {
                    let vertices = loaded.mesh.positions().len() as u32;
                    assert!(loaded.mesh.triangles().iter().flatten().all(|&i| i < vertices));
                    good += 1;
                }
                Err(error) => {
                    assert!(!error.to_string().is_empty());
                    bad += 1;
                }
            }
        }
        // The damage is neither harmless nor all in the first bytes.
        assert!(bad > 500, "{what}: {good} good, {bad} bad");
    }
}
