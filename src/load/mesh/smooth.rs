//! Vertex normals for a mesh that has none, sharp along its creases.
//!
//! Where two faces that share an edge turn by no more than an angle, they share the normals at its ends; elsewhere each
//! side has its own. Normals of faces count by the angle of the face at the vertex (Thürmer and Wüthrich, "Computing
//! Vertex Normals from Polygonal Facets", 1998), so that they do not depend on how polygons were cut.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::buffers::Buffers;
use super::corners::{Attributed, Split};
use super::error::Fault;
use super::weld;

/// A corner of a triangle: where it is in the file, and which normal it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Corner {
    vertex: u32,
    /// The first corner, three to a triangle, that has the same normal.
    normal: u32,
}

impl Attributed for Corner {
    fn vertex(&self) -> u32 {
        self.vertex
    }
}

/// Gives a mesh other vertex normals, and more vertices where it has creases: edges at which it turns by more than
/// `angle` degrees, has a border, more than two faces, or two of opposite orientation. Where `groups` name a group for a
/// face, that decides in the place of the angle: the faces of a group are smooth among each other, those of group 0 are flat.
///
/// A mesh with an index out of range is left as it is.
pub(super) fn smooth(
    buffers: &mut Buffers,
    angle: f64,
    groups: Option<&[Option<u32>]>,
) -> Result<(), Fault> {
    let vertices = buffers.positions.len();
    let corners = buffers.triangles.len().saturating_mul(3);
    if corners >= u32::MAX as usize
        || buffers.triangles.as_flattened().iter().any(|&i| i as usize >= vertices)
    {
        return Ok(());
    }
    let faces: Vec<Face> =
        buffers.triangles.par_iter().map(|t| Face::new(t.map(|i| buffers.position(i)))).collect();
    // Beyond half a turn a cosine would fall again.
    let least_cosine = angle.min(180.0).to_radians().cos();
    let normal_of = shared_normals(buffers, &faces, least_cosine, groups);
    let mut sums = vec![DVec3::ZERO; corners];
    for (corner, &shared) in normal_of.iter().enumerate() {
        let face = &faces[corner / 3];
        sums[shared as usize] += face.normal * face.angles[corner % 3];
    }
    let mut split = Split::default();
    for (triangle, normals) in buffers.triangles.iter_mut().zip(normal_of.as_chunks::<3>().0) {
        let corners = [0, 1, 2].map(|k| Corner { vertex: triangle[k], normal: normals[k] });
        *triangle = split.triangle(corners, vertices)?;
    }
    let corners = split.into_vertices();
    let take = |corner: &Corner| corner.vertex as usize;
    buffers.positions = corners.iter().map(|c| buffers.positions[take(c)]).collect();
    if !buffers.uvs.is_empty() {
        buffers.uvs = corners.iter().map(|c| buffers.uvs[take(c)]).collect();
    }
    let normal = |c: &Corner| sums[c.normal as usize].normalize_or_zero().as_vec3();
    buffers.normals = corners.iter().map(normal).collect::<Vec<Vec3>>();
    Ok(())
}

/// A triangle as far as normals depend on it.
struct Face {
    /// Of unit length; 0 if it has no area.
    normal: DVec3,
    /// Angles at the corners, in radians.
    angles: [f64; 3],
}

impl Face {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        // NaN becomes 0 as well.
        let normal = (b - a).cross(c - a).try_normalize().unwrap_or_default();
        let angle = |at: DVec3, to: DVec3, and: DVec3| {
            let (u, v) = (to - at, and - at);
            u.cross(v).length().atan2(u.dot(v))
        };
        let angles = if normal == DVec3::ZERO {
            [0.0; 3]
        } else {
            [angle(a, b, c), angle(b, c, a), angle(c, a, b)]
        };
        Self { normal, angles }
    }
}

/// For each corner the first one that has the same normal.
fn shared_normals(
    buffers: &Buffers,
    faces: &[Face],
    least_cosine: f64,
    groups: Option<&[Option<u32>]>,
) -> Vec<u32> {
    let place = weld::first_at_place(&buffers.positions);
    let at = |corner: usize| place[buffers.triangles[corner / 3][corner % 3] as usize];
    let next = |corner: usize| corner - corner % 3 + (corner + 1) % 3;
    // Edges by their ends; each is named by the corner where its face begins it.
    let mut edges: Vec<(u64, u32)> = (0..3 * faces.len())
        .into_par_iter()
        .map(|corner| {
            let (a, b) = (at(corner), at(next(corner)));
            (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), corner as u32)
        })
        .collect();
    edges.par_sort_unstable();
    let mut sets = Sets::new(3 * faces.len());
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        let &[(_, p), (_, q)] = edge else { continue };
        let (p, q) = (p as usize, q as usize);
        let [n, m] = [p, q].map(|corner| faces[corner / 3].normal);
        // Faces of one orientation pass their edge in opposite directions. One without area is on no side.
        let alike = at(p) == at(next(q)) && at(p) != at(q);
        let group = |corner: usize| groups.and_then(|groups| groups[corner / 3]);
        let smooth = match (group(p), group(q)) {
            (None, None) => n.dot(m) >= least_cosine,
            (a, b) => a == b && a != Some(0),
        };
        if alike && n != DVec3::ZERO && m != DVec3::ZERO && smooth {
            sets.join(p, next(q));
            sets.join(next(p), q);
        }
    }
    (0..3 * faces.len()).map(|corner| sets.find(corner) as u32).collect()
}

/// Disjoint sets of numbers, each known by its smallest one.
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn find(&mut self, mut member: usize) -> usize {
        while self.0[member] as usize != member {
            self.0[member] = self.0[self.0[member] as usize];
            member = self.0[member] as usize;
        }
        member
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3A};

    use super::*;

    fn smoothed(positions: Vec<Vec3A>, triangles: Vec<[u32; 3]>, angle: f64) -> Buffers {
        let mut buffers = Buffers { positions, triangles, ..Buffers::default() };
        smooth(&mut buffers, angle, None).expect("few enough");
        buffers
    }

    fn cube() -> (Vec<Vec3A>, Vec<[u32; 3]>) {
        let corner = |i: u32| Vec3A::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cut = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        ((0..8).map(corner).collect(), faces.into_iter().flat_map(cut).collect())
    }

    /// Below 90 degrees a cube is flat: each face has its normal at its four corners. Above, each of its eight
    /// corners has one, along the diagonal: three right angles count the same however the squares were cut.
    #[test]
    fn a_cube_has_creases_or_not() {
        let (positions, triangles) = cube();
        let flat = smoothed(positions.clone(), triangles.clone(), 89.9);
        assert_eq!(flat.positions.len(), 24);
        for triangle in &flat.triangles {
            let [a, b, c] = triangle.map(|i| flat.positions[i as usize]);
            let normal = Vec3::from((b - a).cross(c - a).normalize());
            assert!(triangle.iter().all(|&i| (flat.normals[i as usize] - normal).length() < 1e-6));
        }
        let round = smoothed(positions, triangles, 90.1);
        assert_eq!(round.positions.len(), 8);
        for (p, n) in round.positions.iter().zip(&round.normals) {
            let expected = Vec3::from((*p - 0.5).normalize());
            assert!((*n - expected).length() < 1e-6, "{n} {expected}");
        }
    }

    /// Vertices that only differ in texture coordinates share a normal and stay apart.
    #[test]
    fn seams_of_texture_coordinates_are_smooth() {
        let positions = vec![
            Vec3A::ZERO,
            Vec3A::Y,
            Vec3A::X,
            Vec3A::Y,
            Vec3A::ZERO,
            Vec3A::new(-1.0, 0.0, 0.1),
        ];
        let mut buffers = Buffers {
            positions,
            uvs: (0..6).map(|i| Vec2::splat(i as f32)).collect(),
            triangles: vec![[0, 2, 1], [3, 5, 4]],
            ..Buffers::default()
        };
        smooth(&mut buffers, 30.0, None).expect("few enough");
        assert_eq!(buffers.positions.len(), 6);
        let normal = |uv: f32| {
            let at = buffers.uvs.iter().position(|v| v.x == uv).expect("kept");
            buffers.normals[at]
        };
        assert!((normal(0.0) - normal(4.0)).length() < 1e-6);
        assert!((normal(1.0) - normal(3.0)).length() < 1e-6);
        assert!((normal(0.0) - normal(2.0)).length() > 1e-3);
    }

    /// A third face, a face turned inside out, and one without area end what is smooth; nothing panics.
    #[test]
    fn edges_that_are_no_surface_are_creases() {
        let fin = vec![Vec3A::ZERO, Vec3A::X, Vec3A::Y, -Vec3A::Y, Vec3A::Z];
        let three = smoothed(fin.clone(), vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]], 180.0);
        assert_eq!(three.positions.len(), 9);
        let turned = smoothed(fin.clone(), vec![[0, 1, 2], [0, 1, 3]], 180.0);
        assert_eq!(turned.positions.len(), 6);
        let good = smoothed(fin.clone(), vec![[0, 1, 2], [1, 0, 3]], 1.0);
        assert_eq!(good.positions.len(), 4);
        let flat = smoothed(fin.clone(), vec![[0, 1, 2], [1, 0, 0], [2, 2, 2]], 180.0);
        assert!(flat.normals.iter().all(|n| n.is_finite()));
        let out_of_range = smoothed(fin, vec![[0, 1, 9]], 30.0);
        assert_eq!(out_of_range.triangles, [[0, 1, 9]]);
    }
}
