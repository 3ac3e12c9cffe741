use glam::{Vec2, Vec3, Vec3A};

use super::super::tests::{load_bytes, mesh, message};
use super::super::{MeshOptions, load_ply};

const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\n";
const POINTS: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";

fn file(format: &str, elements: &str, data: &str) -> String {
    format!("ply\nformat {format} 1.0\n{elements}end_header\n{data}")
}

fn ascii(data: &str) -> String {
    file("ascii", &format!("{POINTS}{FACES}"), data)
}

#[test]
fn normals_and_texture_coordinates_are_read() {
    for (u, v) in [("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("texture_s", "texture_t")] {
        let elements = format!(
            "{POINTS}property float nx\nproperty float {u}\nproperty float ny\n\
             property float {v}\nproperty float nz\nelement face 1\n\
             property list uchar int vertex_index\n"
        );
        let data = "0 0 0 0 0.5 0 0.25 1\n1 0 0 0 0 0 0 2\n0 1 0 0 0 3 0 0\n3 0 1 2\n";
        let mesh = mesh(load_ply, file("ascii", &elements, data));
        assert_eq!(mesh.positions(), [Vec3A::ZERO, Vec3A::X, Vec3A::Y]);
        assert_eq!(mesh.normals(), [Vec3::Z, Vec3::Z, Vec3::Y]);
        assert_eq!(mesh.uvs(), [Vec2::new(0.5, 0.25), Vec2::ZERO, Vec2::ZERO]);
    }
}

/// A square of two triangles and a quadrilateral beside it, with texture coordinates for corners, as MeshLab
/// writes them; those of the vertices then do not count.
#[test]
fn corners_have_texture_coordinates_of_their_own() {
    let elements = "element vertex 6\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\n\
                    property float ny\nproperty float nz\nproperty float s\nproperty float t\nelement face 3\n\
                    property list uchar int vertex_indices\nproperty list uchar float texcoord\n\
                    property int texnumber\n";
    let vertices: String = (0..6).map(|i| format!("{} {} 0 0 0 1 9 9\n", i / 2, i % 2)).collect();
    let faces =
        "3 0 2 3 6 0 0 1 0 1 1 0\n3 0 3 1 6 0 0 1 1 0 1 0\n4 2 4 5 3 8 .5 0 1 0 1 1 .5 1 0\n";
    let text = file("ascii", elements, &(vertices.clone() + faces));
    let options = MeshOptions { flip_tex_coords: true, ..MeshOptions::default() };
    let loaded = load_bytes(load_ply, text.as_bytes(), &options).expect("a good file");
    assert!(loaded.warnings().is_empty() && !loaded.remarks.some_lack_uvs);
    let mesh = loaded.mesh;
    // Vertices 2 and 3 are split, vertex 0 is not.
    assert_eq!(mesh.positions().len(), 8);
    assert_eq!((mesh.triangles().len(), mesh.normals()), (4, &[Vec3::Z; 8][..]));
    let uv = |triangle: usize, i: usize| mesh.uvs()[mesh.triangles()[triangle][i] as usize];
    let corners = [[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]];
    for (triangle, corners) in corners.into_iter().enumerate() {
        assert_eq!([0, 1, 2].map(|i| uv(triangle, i)), corners.map(Vec2::from));
    }
    assert_eq!(uv(2, 0), Vec2::new(0.5, 1.0));
    assert_eq!(mesh.positions()[mesh.triangles()[2][0] as usize], Vec3A::X);

    // The list may come first, and faces may have none.
    let elements = elements.replacen("property list uchar int vertex_indices\n", "", 1)
        + "property list uchar int vertex_indices\n";
    let faces = "6 0 0 1 0 1 1 0 3 0 2 3\n0 1 3 0 3 1\n0 0 4 2 4 5 3\n";
    let text = file("ascii", &elements, &(vertices.clone() + faces));
    let loaded = load_bytes(load_ply, text.as_bytes(), &MeshOptions::default()).expect("good");
    assert_eq!(loaded.mesh.uvs()[loaded.mesh.triangles()[0][2] as usize], Vec2::ONE);
    assert_eq!(loaded.mesh.uvs()[loaded.mesh.triangles()[1][0] as usize], Vec2::ZERO);
    assert!(loaded.remarks.some_lack_uvs);
    assert_eq!(
        loaded.warnings(),
        [
            "faces name several textures (`texnumber`): all show that of the shape; write a file for each texture, \
          and give each a shape of its own"
        ]
    );
    // None at all: those of the vertices count.
    let text = file("ascii", &elements, &(vertices.clone() + &"0 0 3 0 2 3\n".repeat(3)));
    assert_eq!(super::super::tests::mesh(load_ply, &text).uvs(), [Vec2::splat(9.0); 6]);
    let text = file("ascii", &elements, &(vertices + "4 0 0 1 0 0 3 0 2 3\n"));
    assert_eq!(
        message(load_ply, text),
        ":23:19: a list of 4 texture coordinates for 3 corners (expected 6, or 0)"
    );
}

#[test]
fn face_normals_leave_the_files_normals_out() {
    let elements =
        format!("{POINTS}property float nx\nproperty float ny\nproperty float nz\n{FACES}");
    let text = file("ascii", &elements, "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n");
    let options = MeshOptions { face_normals: true, ..Default::default() };
    let loaded = load_bytes(load_ply, text.as_bytes(), &options).expect("a good file");
    assert!(loaded.mesh.normals().is_empty() && loaded.mesh.triangles().len() == 1);
}

#[test]
fn faces_may_come_before_vertices() {
    let text = file("ascii", &format!("{FACES}{POINTS}"), "3 0 1 2\n0 0 0\n\n1 0 0\n0 1 0\n");
    assert_eq!(mesh(load_ply, text).triangles(), [[0, 1, 2]]);
}

#[test]
fn every_problem_of_the_data_is_named() {
    for (data, expected) in [
        ("0 0 0\n1 0 0\n", ":11:1: the file ends after 2 of 3 records of the element `vertex`"),
        (
            "0 0 0\n1 0 0\n0 1 0\n",
            ":12:1: the file ends after 0 of 1 records of the element `face`",
        ),
        ("0 0 0\n1 0\n0 1 0\n3 0 1 2\n", ":11:3: a value is missing at the end of the record"),
        ("0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n", ":11:7: expected the end of the line, found `0`"),
        ("0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n", ":11:5: expected a number, found `x`"),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", ":13:7: vertex index 3 is out of range (there are 3)"),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", ":13:7: vertex index -1 is out of range (there are 3)"),
        ("0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n", ":13:5: expected a whole number, found `1.5`"),
        ("0 0 0\n1 0 0\n0 1 0\n2 0 1\n", ":13:1: a face needs at least 3 vertices, but this has 2"),
        ("0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", ":13:7: a value is missing at the end of the record"),
        (
            "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n",
            ":14:1: the file goes on after the last element that its header declares",
        ),
    ] {
        assert_eq!(message(load_ply, ascii(data)), expected, "{data}");
    }
    let elements = format!("element note 1\nproperty list int int words\n{POINTS}{FACES}");
    assert_eq!(
        message(load_ply, file("ascii", &elements, "-1\n")),
        ":12:1: a list of -1 entries (expected 0 or more)"
    );
}

#[test]
fn binary_problems_are_named_by_byte_and_record() {
    let header = file("binary_little_endian", &format!("{POINTS}{FACES}"), "");
    let mut bytes = header.clone().into_bytes();
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_le_bytes());
    }
    let start = header.len();
    let ended = message(load_ply, &bytes[..start + 15]);
    let expected = "the file ends after 1 of 3 records of the element `vertex`";
    assert_eq!(ended, format!(": byte {} (vertex 1): {expected}", start + 15));
    bytes.push(3);
    for i in [0_i32, 1, 3] {
        bytes.extend(i.to_le_bytes());
    }
    let expected = "vertex index 3 is out of range (there are 3)";
    assert_eq!(message(load_ply, &bytes), format!(": byte {} (face 0): {expected}", start + 45));
    bytes[start + 45] = 2;
    assert_eq!(mesh(load_ply, &bytes).triangles(), [[0, 1, 2]]);
    bytes.push(0);
    assert_eq!(
        message(load_ply, &bytes),
        ": the file goes on after the last element that its header declares"
    );
}

#[test]
fn every_problem_of_the_header_is_named() {
    let elements = |elements: &str| file("ascii", elements, "");
    for (text, expected) in [
        ("plx\n".into(), ":1:1: not a PLY file (the first line of one is `ply`)"),
        (String::new(), ":1:1: not a PLY file (the first line of one is `ply`)"),
        (
            file("ascii2", "", ""),
            ":2:1: expected format ascii 1.0, binary_little_endian 1.0 or binary_big_endian 1.0, \
             found `format ascii2 1.0`",
        ),
        (
            "ply\nend_header\n".into(),
            ":2:1: expected a line `format` before the end of the header, found `end_header`",
        ),
        ("ply\n".into(), ":2:1: expected the line `end_header`, found `the end of the file`"),
        (
            elements("vertices 3\n"),
            ":3:1: expected comment, obj_info, format, element, property or end_header, found \
             `vertices 3`",
        ),
        (
            elements("element vertex -3\n"),
            ":3:1: expected element, a name and the number of its records, found `element vertex \
             -3`",
        ),
        (
            elements("property float x\n"),
            ":3:1: expected an `element` before the first `property`, found `property float x`",
        ),
        (
            elements("element vertex 3\nproperty half x\n"),
            ":4:1: expected a type (char, uchar, short, ushort, int, uint, float, double, int8 to \
             uint32, float32, float64), found `property half x`",
        ),
        (
            elements("element face 3\nproperty list float int vertex_indices\n"),
            ":4:1: expected a list whose count is of an integer type, found `property list float \
             int vertex_indices`",
        ),
        (
            elements("element vertex 3\nproperty float\n"),
            ":4:1: expected the property's name behind its type, found `property float`",
        ),
        (
            elements("element vertex 3\nproperty float x\nproperty float y\n"),
            ":3:1: the element `vertex` has 0 properties `z` (expected one)",
        ),
        (
            elements(&format!("{POINTS}property float u\nproperty float s\n")),
            ":3:1: the element `vertex` has 2 properties `u` or `s` or `texture_u` or `texture_s` \
             (expected one)",
        ),
        (
            elements(POINTS),
            ": has no faces, only 3 points (expected polygons: a cloud of points has no surface until a program \
             such as MeshLab makes one of it)",
        ),
        (elements(FACES), ": expected one element `vertex`"),
        (elements(&format!("{FACES}{FACES}")), ": expected one element `face`"),
        (
            elements(&format!("{POINTS}element face 1\nproperty list uchar float vertex_index\n")),
            ":7:1: the element `face` has no list `vertex_indices` or `vertex_index` of an integer \
             type",
        ),
        (
            elements(&format!(
                "{POINTS}element tristrips 1\nproperty list int int vertex_indices\n"
            )),
            ":7:1: triangle strips are not read (expected triangles or polygons in an element \
             `face`)",
        ),
        (elements("element nothing 5\n"), ":3:1: the element `nothing` has no properties"),
    ] {
        assert_eq!(message(load_ply, &text), expected, "{text}");
    }
}

/// Room is made for what the file can hold, not for what its header claims: 4e9 vertices with
/// normals would take 112 GB.
#[test]
fn absurd_counts_end_early() {
    for format in ["ascii", "binary_little_endian"] {
        let elements =
            format!("{POINTS}property float nx\nproperty float ny\nproperty float nz\n{FACES}")
                .replace("vertex 3", "vertex 4000000000")
                .replace("face 1", "face 18446744073709551615");
        let message = message(load_ply, file(format, &elements, ""));
        let expected = "the file ends after 0 of 4000000000 records of the element `vertex`";
        assert!(message.ends_with(expected), "{message}");
    }
}
