//! Files as other programs write them: with byte order marks, in UTF-16, without faces, with concave ones.

use super::*;

/// Byte order marks, as programs on Windows write them, are no part of the text.
#[test]
fn byte_order_marks_are_passed_over() {
    let marked = |bytes: &[u8]| [b"\xef\xbb\xbf", bytes].concat();
    let files: [(&str, Load, Vec<u8>); 6] = [
        ("obj", load_obj, marked(cube_obj().as_bytes())),
        ("obj, CRLF", load_obj, marked(cube_obj().replace('\n', "\r\n").as_bytes())),
        ("obj.gz", load_obj, gzip(&marked(cube_obj().as_bytes()))),
        ("ply", load_ply, marked(&cube_ply("ascii"))),
        ("ply, little", load_ply, marked(&cube_ply("binary_little_endian"))),
        ("ply.gz", load_ply, gzip(&marked(&cube_ply("binary_big_endian")))),
    ];
    for (what, load, bytes) in files {
        assert_is_cube(&mesh(load, bytes), what);
    }
    // Columns, lines and bytes are those of the file.
    let error = load_bytes(load_obj, &marked(b"vx 1\n"), &MeshOptions::default()).expect_err("bad");
    assert_eq!((error.column(), error.source_line()), (Some(1), Some("vx 1")));
    let good = cube_ply("binary_little_endian");
    let [plain, with_mark] = [good.clone(), marked(&good)].map(|bytes| {
        let cut = &bytes[..bytes.len() - 1];
        load_bytes(load_ply, cut, &MeshOptions::default()).expect_err("cut off").byte_offset()
    });
    assert_eq!(with_mark, plain.map(|offset| offset + 3));
    // In the middle of a file, as where two were joined, they can be seen.
    assert_eq!(
        message(load_obj, "v 0 0 0\n\u{feff}v 1 0 0\n"),
        ":2:1: unknown keyword `\\u{feff}v` (expected v, vt, vn or f; o, g, s and what is no polygon are ignored)"
    );
}

#[test]
fn utf_16_is_named() {
    let obj = cube_obj();
    let encoded = |bytes: fn(u16) -> [u8; 2], mark: &str| -> Vec<u8> {
        (mark.to_owned() + &obj).encode_utf16().flat_map(bytes).collect()
    };
    for mark in ["", "\u{feff}"] {
        for bytes in [u16::to_le_bytes, u16::to_be_bytes] {
            for load in [load_obj as Load, load_ply] {
                assert_eq!(
                    message(load, encoded(bytes, mark)),
                    ": is text in UTF-16 (expected UTF-8: save it in that encoding)"
                );
            }
        }
    }
}

#[test]
fn clouds_of_points_are_no_meshes() {
    let expected = ": has no faces, only 2 points (expected polygons: a cloud of points has no surface until a \
                    program such as MeshLab makes one of it)";
    let header = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
                  property float z\n";
    let faces = "element face 0\nproperty list uchar int vertex_indices\n";
    let points = "end_header\n0 0 0\n1 0 0\n";
    assert_eq!(message(load_ply, format!("{header}{points}")), expected);
    assert_eq!(message(load_ply, format!("{header}{faces}{points}")), expected);
    assert_eq!(message(load_obj, "v 0 0 0\nv 1 0 0\n"), expected);
}

/// Of a square with a dent, whichever corner is the first.
#[test]
fn concave_faces_are_filled_in_all_formats() {
    const DENT: [[i32; 2]; 5] = [[0, 0], [4, 0], [4, 4], [2, 1], [0, 4]];
    for start in 0..5 {
        let corners: Vec<_> = (0..5).map(|i| (i + start) % 5).collect();
        let listed = |from: usize| {
            corners.iter().map(|i| (i + from).to_string()).collect::<Vec<_>>().join(" ")
        };
        let vertices = |keyword: &str| -> String {
            DENT.iter().map(|[x, y]| format!("{keyword}{x} {y} 0\n")).collect()
        };
        let obj = format!("{}f {}\n", vertices("v "), listed(1));
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
             property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{}5 {}\n",
            vertices(""),
            listed(0)
        );
        for (load, text) in [(load_obj as Load, obj), (load_ply, ply)] {
            let mesh = mesh(load, &text);
            let at = |i: u32| mesh.positions()[i as usize];
            let twice =
                mesh.triangles().iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).z);
            // 16, less the dent of 6.
            assert_eq!(
                (twice.clone().sum::<f32>(), twice.clone().all(|a| a > 0.0)),
                (20.0, true),
                "{text}"
            );
        }
    }
    let crossing = "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 1 0\nf 1 2 3 4\n";
    let loaded =
        load_bytes(load_obj, crossing.as_bytes(), &MeshOptions::default()).expect("a mesh");
    assert_eq!(
        loaded.warnings(),
        [
            "1 polygon crosses itself, and may cover too much; cut such faces into triangles in the program that \
          they come from"
        ]
    );
}
