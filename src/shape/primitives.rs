//! The rectangle and the cube of scene files, as meshes.

use glam::{DAffine3, DVec3, Vec2};

use super::mesh::{Dropped, TriangleMesh};

/// The square `[-1, 1]²` in the plane z = 0 (normal +z, texture coordinates `[0, 1]²`) under
/// `to_world`, as two triangles.
#[must_use]
pub fn rectangle(to_world: DAffine3, flip_normals: bool) -> (TriangleMesh, Dropped) {
    let face = Face { u: DVec3::X, v: DVec3::Y, normal: DVec3::Z, center: DVec3::ZERO };
    build(&[face], to_world, flip_normals)
}

/// The cube `[-1, 1]³` with outward normals under `to_world`, as twelve triangles.
///
/// Each face has texture coordinates `[0, 1]²`, turned as Mitsuba 3 turns them: seen from outside
/// they are mirrored.
#[must_use]
pub fn cube(to_world: DAffine3, flip_normals: bool) -> (TriangleMesh, Dropped) {
    let faces = [
        (DVec3::X, DVec3::Y, DVec3::NEG_Z),
        (DVec3::NEG_X, DVec3::Y, DVec3::Z),
        (DVec3::Y, DVec3::NEG_X, DVec3::NEG_Z),
        (DVec3::NEG_Y, DVec3::Z, DVec3::X),
        (DVec3::Z, DVec3::Y, DVec3::X),
        (DVec3::NEG_Z, DVec3::NEG_Y, DVec3::X),
    ];
    build(
        &faces.map(|(normal, u, v)| Face { u, v, normal, center: normal }),
        to_world,
        flip_normals,
    )
}

/// A square spanned by ±u and ±v around a centre, with texture coordinates growing along u and v.
struct Face {
    u: DVec3,
    v: DVec3,
    normal: DVec3,
    center: DVec3,
}

fn build(faces: &[Face], to_world: DAffine3, flip_normals: bool) -> (TriangleMesh, Dropped) {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut uvs = Vec::new();
    for face in faces {
        // What turns the winding, and so the normal, around: mirrored texture coordinates, a
        // mirroring map, and the wish to flip it.
        let turned = (face.u.cross(face.v).dot(face.normal) < 0.0)
            ^ (to_world.matrix3.determinant() < 0.0)
            ^ flip_normals;
        let first = positions.len() as u32;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let p = to_world.transform_point3(face.center + face.u * x + face.v * y);
            positions.push(p.as_vec3a());
            uvs.push(Vec2::new(x as f32, y as f32) * 0.5 + 0.5);
        }
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|corner| first + corner)) {
            triangles.push(if turned { [a, c, b] } else { [a, b, c] });
        }
    }
    TriangleMesh::new(positions, triangles, Vec::new(), uvs)
        .expect("indices and attributes are built to match")
}
