use glam::{Vec2, Vec3, Vec3A};

use super::super::tests::{load_bytes, mesh, message};
use super::super::{MeshOptions, load_obj};

const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";

fn with(lines: &str) -> String {
    VERTICES.to_owned() + lines
}

#[test]
fn vertices_split_where_attributes_differ() {
    let file = with("vt 0.5\nvt 1 0 7\nvn 0 0 2\nf 1//1 2/1/1 3/2/1\nf 2/1/1 4 3//1\n");
    let mesh = mesh(load_obj, file);
    // Of vertex 3, one with and one without texture coordinates.
    assert_eq!(mesh.triangles(), [[0, 1, 2], [1, 3, 4]]);
    assert_eq!(
        mesh.positions(),
        [Vec3A::ZERO, Vec3A::X, Vec3A::Y, Vec3A::new(1.0, 1.0, 0.0), Vec3A::Y]
    );
    let half = Vec2::new(0.5, 0.0);
    assert_eq!(mesh.uvs(), [Vec2::ZERO, half, Vec2::X, Vec2::ZERO, Vec2::ZERO]);
    assert_eq!(mesh.normals(), [Vec3::Z, Vec3::Z, Vec3::Z, Vec3::ZERO, Vec3::Z]);
}

#[test]
fn vertices_that_were_shared_are_split_later() {
    let file =
        with("vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 3/3\nf 2/2 4/1 3/3\nf 2/2 4/4 3/3\n");
    let mesh = mesh(load_obj, file);
    assert_eq!(mesh.triangles(), [[0, 1, 2], [1, 3, 2], [1, 4, 2]]);
    assert_eq!(mesh.uvs()[3..], [Vec2::ZERO, Vec2::ONE]);
}

#[test]
fn equal_indices_keep_the_vertices() {
    let file = with("vn 0 0 1\nvn 0 0 1\nvn 1 0 0\nf 1//1 2//2 3//3\n");
    let mesh = mesh(load_obj, file);
    // The fourth vertex is not used and has no normal.
    assert_eq!(mesh.positions().len(), 4);
    assert_eq!(mesh.normals(), [Vec3::Z, Vec3::Z, Vec3::X, Vec3::ZERO]);
}

#[test]
fn faces_may_come_before_their_vertices() {
    let faces = "f 1 2 3\nf 2//1 4 3\n";
    let mesh = mesh(load_obj, faces.to_owned() + VERTICES + "vn 0 0 1\n");
    let corner =
        |triangle: usize, i: usize| mesh.positions()[mesh.triangles()[triangle][i] as usize];
    assert_eq!([corner(0, 1), corner(0, 2), corner(1, 0)], [Vec3A::X, Vec3A::Y, Vec3A::X]);
}

/// A fan whose centre has a texture coordinate of its own in each triangle, as at the pole of a
/// sphere, takes linear time and stays right.
#[test]
fn poles_are_split() {
    let mut file = with("");
    for i in 0..1000 {
        file += &format!("vt {i}\n");
    }
    for i in 1..=1000 {
        file += &format!("f 1/{i} 2/1 3/1\n");
    }
    let mesh = mesh(load_obj, file);
    assert_eq!(mesh.positions().len(), 1002);
    assert!((0..1000).all(|i| mesh.uvs()[mesh.triangles()[i][0] as usize].x == i as f32));
}

/// Curves, surfaces, lines and what other programs are told of the display is no error, and no secret.
#[test]
fn what_is_no_polygon_is_named() {
    let file = with(
        "vp 0.5\nmtllib a b.mtl\nusemtl red\nf 1 2 3\nusemtl blue\nf 2 4 3\nusemtl red\ncstype bspline\n\
         deg 3\ncurv 0 1 1 \\\n 2 3 4\nparm u 0 0 0 0 1 1 1 1\nend\nl 1 2\nmg 0\nlod 3\nstech cparma 1\n",
    );
    let options = MeshOptions::default();
    let loaded = load_bytes(load_obj, file.as_bytes(), &options).expect("a good file");
    assert_eq!(loaded.mesh.triangles(), [[0, 1, 2], [1, 3, 2]]);
    assert_eq!(
        loaded.warnings(),
        [
            "free-form curves and surfaces are left out (`vp`, `cstype`, `deg`, `curv`, `parm`, `end`); let the \
             program that wrote the file make polygons of them",
            "lines and points are left out (`l`); only faces can be seen",
            "statements without effect are left out (`mg`, `lod`, `ctech`); they are about how other programs \
             show the polygons",
        ]
    );
    let materials = &loaded.remarks.materials;
    assert_eq!(materials.libraries.to_string(), "`a b.mtl`");
    assert_eq!(
        (materials.used.to_string().as_str(), materials.used.are_several()),
        ("`red`, `blue`", true)
    );
    let many: String = (0..100).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let loaded = load_bytes(load_obj, with(&many).as_bytes(), &options).expect("a good file");
    assert_eq!(loaded.remarks.materials.used.to_string(), "`m0`, `m1`, `m2`, `m3`, `m4`, …");
    assert!(loaded.warnings().is_empty());
}

/// Two squares at a right angle. `s` says whether their edge is smooth, and where it does not, the angle does.
#[test]
fn smoothing_groups_come_before_the_angle() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 -1\nv 1 1 -1\n";
    let [a, b] = ["f 1 2 3 4\n", "f 2 5 6 3\n"];
    for (angle, faces, vertices_in_all) in [
        (89.0, format!("{a}{b}"), 8),
        (91.0, format!("{a}{b}"), 6),
        (1.0, format!("s 1\n{a}{b}"), 6),
        (1.0, format!("s 7\n{a}s 2\ns 7\n{b}"), 6),
        (91.0, format!("s 1\n{a}s 2\n{b}"), 8),
        // Each triangle by itself.
        (91.0, format!("s off\n{a}{b}"), 12),
        (91.0, format!("s 0\n{a}{b}"), 12),
        (91.0, format!("{a}s 1\n{b}"), 8),
    ] {
        let options = MeshOptions { max_smooth_angle: Some(angle), ..MeshOptions::default() };
        let file = format!("{vertices}{faces}");
        let mesh = load_bytes(load_obj, file.as_bytes(), &options).expect("a good file").mesh;
        assert_eq!(mesh.positions().len(), vertices_in_all, "{angle} {faces}");
        let is_smooth = vertices_in_all == 6;
        for (p, n) in mesh.positions().iter().zip(mesh.normals()) {
            // On the first square, on the second, or on both.
            let flat = [Vec3::Z, Vec3::X].into_iter().filter(|f| f.dot((*p).into()) == f.x);
            let expected: Vec3 = flat.sum();
            let near = |e: Vec3| (*n - e.normalize()).length() < 1e-6;
            let good = if is_smooth { near(expected) } else { near(Vec3::Z) || near(Vec3::X) };
            assert!(good, "{angle} {faces} {p} {n}");
        }
    }
}

/// 1e39 and more is no f32.
#[test]
fn texture_coordinates_that_are_not_finite_count_as_0() {
    let file = with("vt nan 1\nvt 1e39 0.5\nvt 0.5 0.25\nf 1/1 2/2 3/3\n");
    let loaded = load_bytes(load_obj, file.as_bytes(), &MeshOptions::default()).expect("a mesh");
    assert_eq!(loaded.mesh.uvs()[..3], [Vec2::ZERO, Vec2::ZERO, Vec2::new(0.5, 0.25)]);
    assert_eq!(
        loaded.warnings(),
        [
            "2 vertices have texture coordinates that are not finite and count as 0; unwrap the mesh anew in the \
          program that it comes from"
        ]
    );
}

#[test]
fn every_problem_is_named() {
    for (lines, expected) in [
        ("f 1 2 0", ":5:7: index 0 (indices count from 1 forwards or from -1 backwards)"),
        ("f 1 2 5", ":5:7: vertex index 5 is out of range (there are 4)"),
        ("f 1 2 -5", ":5:7: vertex index -5 is out of range (there are 4)"),
        ("f 1 2 99999999999", ":5:7: vertex index 99999999999 is out of range (there are 4)"),
        ("f 1/1 2/1 3/1", ":5:3: texture coordinate index 1 is out of range (there are 0)"),
        ("vn 0 0 1\nf 1//1 2//2 3//1", ":6:8: normal index 2 is out of range (there are 1)"),
        ("f 1 2", ":5:5: a face needs at least 3 vertices, but this has 2"),
        ("f 1 2 x", ":5:7: expected a corner such as 3, 3/1, 3//2 or 3/1/2, found `x`"),
        ("f 1 2 3/", ":5:7: expected a corner such as 3, 3/1, 3//2 or 3/1/2, found `3/`"),
        ("f 1 2 1/1/1/1", ":5:7: expected a corner such as 3, 3/1, 3//2 or 3/1/2, found `1/1/1/1`"),
        ("v 1 2", ":5:5: a position needs at least 3 numbers, but the line has 2"),
        ("vt", ":5:1: a texture coordinate needs at least 1 numbers, but the line has 0"),
        ("vn 1 2 3 4", ":5:10: expected the end of the line, found `4`"),
        ("v 1 two 3", ":5:5: expected a number, found `two`"),
        ("v 1 2 3e", ":5:7: expected a number, found `3e`"),
        (
            "\n call other.obj",
            ":6:2: unknown keyword `call` (expected v, vt, vn or f; o, g, s and what is no polygon are ignored)",
        ),
        ("v 1 \\\n 2 \\\n  y", ":7:3: expected a number, found `y`"),
    ] {
        assert_eq!(message(load_obj, with(lines)), expected, "{lines}");
    }
}
