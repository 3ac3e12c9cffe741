use glam::Vec3A;

use super::super::tests::{load_bytes, mesh, message};
use super::super::{MeshOptions, load_stl};

/// Two triangles of a square.
const SQUARE: [[[f32; 3]; 3]; 2] = [
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
    [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, -0.0]],
];

fn text(triangles: &[[[f32; 3]; 3]]) -> String {
    let facet = |corners: &[[f32; 3]; 3]| {
        let vertices: String =
            corners.iter().map(|[x, y, z]| format!("  vertex {x} {y} {z}\n")).collect();
        format!(" facet normal 0 0 nan\n outer loop\n{vertices} endloop\n endfacet\n")
    };
    let facets: String = triangles.iter().map(facet).collect();
    format!("solid a # square\n{facets}endsolid a # square\n")
}

fn binary(header: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend([0x1f, 0x80]);
    }
    bytes
}

#[test]
fn text_and_bytes_are_the_same_mesh() {
    let expected = mesh(load_stl, text(&SQUARE));
    assert_eq!(expected.triangles(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(expected.positions(), [Vec3A::ZERO, Vec3A::X, Vec3A::new(1.0, 1.0, 0.0), Vec3A::Y]);
    let upper = text(&SQUARE).to_uppercase().replace("NAN", "0");
    let marked = format!("\u{feff}{}", text(&SQUARE));
    for other in [
        upper.into_bytes(),
        text(&SQUARE).replace('\n', "\r\n").into_bytes(),
        marked.into_bytes(),
        binary(b"exported", &SQUARE),
        // Binary files of some programs begin like text.
        binary(b"solid exported", &SQUARE),
    ] {
        let other = mesh(load_stl, other);
        assert_eq!(other.triangles(), expected.triangles());
        assert_eq!(other.positions(), expected.positions());
    }
}

#[test]
fn polygons_are_cut() {
    let pentagon = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 2 1 0\nvertex 1 2 \
                    0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    assert_eq!(mesh(load_stl, pentagon).triangles(), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn every_problem_is_named() {
    let (whole, bytes) = (text(&SQUARE), binary(b"", &SQUARE));
    for (file, expected) in [
        (
            whole.replace("vertex 1 1 0", "vertex 1 one 0").into_bytes(),
            ":6:12: expected a number, found `one`",
        ),
        (
            whole.replacen("  vertex 1 0 0\n", "", 1).into_bytes(),
            ":6:2: a face needs at least 3 vertices, but this has 2",
        ),
        (
            whole.replacen("outer loop", "other loop", 1).into_bytes(),
            ":3:2: unknown keyword `other` (expected solid, facet, outer loop, vertex, endloop, endfacet or endsolid)",
        ),
        (
            whole.replacen("1 0 0", "1 0", 1).into_bytes(),
            ":5:12: a vertex needs at least 3 numbers, but the line has 2",
        ),
        (
            whole.replacen("1 0 0", "1 0 0 0", 1).into_bytes(),
            ":5:16: expected the end of the line, found `0`",
        ),
        (
            whole[..whole.rfind(" endloop").expect("there")].into(),
            ": the file ends after 1 of 2 records of the element `facet`",
        ),
        (
            bytes[..bytes.len() - 1].to_vec(),
            ": byte 183 (facet 1): the file ends after 1 of 2 records of the element `facet`",
        ),
        (
            [bytes.as_slice(), b"more"].concat(),
            ": the file goes on after the last element that its header declares",
        ),
        (
            bytes[..83].to_vec(),
            ": not an STL file (one is text that begins with `solid`, or has 84 bytes before its facets)",
        ),
        (b"solid\nendsolid\n".to_vec(), ": has no faces and no points"),
        // No file of this size has so many.
        (
            [&[7; 80][..], &[0xff; 4], &[1; 120]].concat(),
            ": byte 204 (facet 2): the file ends after 2 of 4294967295 records of the element `facet`",
        ),
        (
            "v 0.25 0.5 0.75\n".repeat(100).into_bytes(),
            ": not an STL file (one is text that begins with `solid`, or has 84 bytes before its facets)",
        ),
    ] {
        assert_eq!(message(load_stl, file), expected);
    }
}

#[test]
fn long_facets_end_early() {
    let file = format!("solid\n{}", "vertex 0 0 0\n".repeat(20_000));
    let error =
        load_bytes(load_stl, file.as_bytes(), &MeshOptions::default()).expect_err("no facet");
    assert!(error.to_string().contains("a facet of more than 1000 vertices"), "{error}");
}
