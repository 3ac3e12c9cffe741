//! Meshes that tests make, and the engines over them.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec3, Vec3A};
use telamon::intersect::{self, Backend, Intersector};
use telamon::shape::{Shape, TriangleMesh};

/// Every engine of this build, in its default modes, over `shapes`.
pub(crate) fn engines(shapes: &[Arc<dyn Shape>]) -> Vec<Box<dyn Intersector>> {
    let build = |&backend| intersect::build(backend, shapes).expect("builds");
    Backend::AVAILABLE.iter().map(build).collect()
}

/// A mesh without normals, none of whose triangles is defective.
pub(crate) fn mesh(positions: Vec<Vec3A>, triangles: Vec<[u32; 3]>) -> TriangleMesh {
    let count = triangles.len();
    let (mesh, _) = TriangleMesh::new(positions, triangles, Vec::new(), Vec::new()).expect("valid");
    assert_eq!(mesh.triangles().len(), count, "triangles were dropped");
    mesh
}

/// The mesh as a PLY file.
pub(crate) fn ply(mesh: &TriangleMesh) -> String {
    let vertices = mesh.positions().iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z));
    let faces = mesh.triangles().iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n"));
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n\
         {}{}",
        mesh.positions().len(),
        mesh.triangles().len(),
        vertices.collect::<String>(),
        faces.collect::<String>(),
    )
}

/// The corners of a triangle of a mesh, in f64.
pub(crate) fn corners_of(mesh: &TriangleMesh, primitive: u32) -> [DVec3; 3] {
    let corner = |i: u32| mesh.positions()[i as usize].as_dvec3();
    mesh.triangles()[primitive as usize].map(corner)
}

/// A sphere as a closed mesh of `2 (rings - 1) segments` triangles: two caps and bands between them,
/// outwards, each vertex rounded once.
pub(crate) fn sphere_mesh(center: DVec3, radius: f64, rings: u32, segments: u32) -> TriangleMesh {
    let (mesh, dropped) = sphere_mesh_and_dropped(center, radius, rings, segments);
    assert_eq!(dropped, 0, "triangles without area");
    mesh
}

/// The same, and the number of triangles that rounding has left without area: their neighbours still meet.
pub(crate) fn sphere_mesh_and_dropped(
    center: DVec3,
    radius: f64,
    rings: u32,
    segments: u32,
) -> (TriangleMesh, usize) {
    let at = |ring: u32, segment: u32| {
        let theta = PI * f64::from(ring) / f64::from(rings);
        let phi = TAU * f64::from(segment) / f64::from(segments);
        let outward = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        (center + outward * radius).as_vec3a()
    };
    let pole = |side: f64| (center + DVec3::Z * side * radius).as_vec3a();
    let mut positions = vec![pole(1.0)];
    for ring in 1..rings {
        positions.extend((0..segments).map(|segment| at(ring, segment)));
    }
    positions.push(pole(-1.0));
    let south = positions.len() as u32 - 1;
    let index = |ring: u32, segment: u32| match ring {
        0 => 0,
        _ if ring == rings => south,
        _ => 1 + (ring - 1) * segments + segment % segments,
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for segment in 0..segments {
            let (a, b) = (index(ring, segment), index(ring, segment + 1));
            let (c, d) = (index(ring + 1, segment), index(ring + 1, segment + 1));
            // At a pole one edge of the square is a point.
            if ring > 0 {
                triangles.push([a, c, b]);
            }
            if ring + 1 < rings {
                triangles.push([b, c, d]);
            }
        }
    }
    let (mesh, dropped) =
        TriangleMesh::new(positions, triangles, Vec::new(), Vec::new()).expect("valid");
    assert_eq!((dropped.not_finite, dropped.too_large), (0, 0));
    (mesh, dropped.degenerate)
}
