use std::collections::BTreeSet;

use glam::{DVec3, Vec3};

use crate::mesh::{Mesh, encode};
use crate::sculpt;

fn bytes(mesh: &Mesh, normals: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(mesh, normals, &mut bytes).expect("writing to memory cannot fail");
    bytes
}

/// What keeps a mesh from being closed, oriented and manifold along its edges.
fn flaw(mesh: &Mesh) -> Option<String> {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.vertices[i as usize].as_dvec3());
    let mut edges = BTreeSet::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = corners(triangle);
        if (b - a).cross(c - a) == DVec3::ZERO {
            return Some(format!("{triangle:?} has no area"));
        }
        let [a, b, c] = *triangle;
        for edge in [(a, b), (b, c), (c, a)] {
            if !edges.insert(edge) {
                return Some(format!("{edge:?} is in two triangles, in the same direction"));
            }
        }
    }
    let open = edges.iter().find(|&&(a, b)| !edges.contains(&(b, a)));
    open.map(|edge| format!("{edge:?} is in one triangle only"))
}

fn volume(mesh: &Mesh) -> f64 {
    let corners = |t: &[u32; 3]| t.map(|i| mesh.vertices[i as usize].as_dvec3());
    mesh.triangles.iter().map(corners).map(|[a, b, c]| a.cross(b).dot(c) / 6.0).sum()
}

#[test]
#[expect(clippy::print_stdout, reason = "the genus, for those who ask with --nocapture")]
fn every_size_is_watertight_and_as_large_as_asked() {
    for wanted in [1_000, 1_500, 2_000, 4_000, 8_000, 16_000, 64_000, 250_000] {
        let mesh = sculpt(wanted);
        let count = mesh.triangles.len();
        println!("{count} triangles for {wanted}: genus {}", mesh.genus());
        assert!(count.abs_diff(wanted) * 20 <= wanted, "{count} triangles for {wanted}");
        assert_eq!(flaw(&mesh), None, "{wanted}");
        assert_eq!(mesh.components(), 1, "{wanted}");
        assert!(mesh.genus() >= 0);
        // A ball of radius 1 has 4.19; a third of it is wall, and the plinth adds 0.2.
        assert!((0.5..4.5).contains(&volume(&mesh)), "{}", volume(&mesh));
    }
}

#[test]
fn flaws_are_found() {
    let mut mesh = sculpt(1_000);
    let last = mesh.triangles.pop().expect("it has triangles");
    assert!(flaw(&mesh).is_some_and(|flaw| flaw.contains("one triangle only")));
    let [a, b, c] = last;
    mesh.triangles.push([a, c, b]);
    assert!(flaw(&mesh).is_some_and(|flaw| flaw.contains("same direction")));
    mesh.vertices[a as usize] = mesh.vertices[b as usize];
    assert!(flaw(&mesh).is_some_and(|flaw| flaw.contains("no area")));
}

#[test]
fn threads_do_not_change_a_byte() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads can be started").install(|| bytes(&sculpt(30_000), true))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}

#[test]
fn normals_point_out_and_lie_across_the_triangles() {
    let mesh = sculpt(250_000);
    // Weighted by area: the slivers beside lattice points are turned, but nobody sees them.
    let (mut along, mut area) = (0.0, 0.0);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.vertices[i as usize]);
        let across = (b - a).cross(c - a);
        along += f64::from(across.dot(mesh.figure.normal((a + b + c) / 3.0)));
        area += f64::from(across.length());
    }
    // The mean cosine: edges of 0.014 on curves of radius 0.05 and more turn by 0.14 at most.
    assert!(along / area > 0.99, "{}", along / area);
    let worst = mesh.vertices.iter().map(|&p| (mesh.figure.normal(p).length() - 1.0).abs());
    assert!(worst.fold(0.0, f32::max) < 1e-6);
}

#[test]
fn file_has_what_its_header_says() {
    let mesh = sculpt(1_000);
    for (normals, vertex_bytes) in [(true, 24), (false, 12)] {
        let bytes = bytes(&mesh, normals);
        let end = b"end_header\n";
        let at = bytes.windows(end.len()).position(|w| w == end).expect("a header") + end.len();
        let header = String::from_utf8_lossy(&bytes[..at]);
        assert!(header.contains(&format!("element vertex {}\n", mesh.vertices.len())));
        assert!(header.contains(&format!("element face {}\n", mesh.triangles.len())));
        assert_eq!(header.contains("property float nx"), normals);
        let body = mesh.vertices.len() * vertex_bytes + mesh.triangles.len() * 13;
        assert_eq!(bytes.len() - at, body);
        let first: [f32; 3] = std::array::from_fn(|n| {
            let four = bytes[at + 4 * n..].first_chunk().expect("the file goes on");
            f32::from_le_bytes(*four)
        });
        assert_eq!(Vec3::from(first), mesh.vertices[0]);
    }
}
