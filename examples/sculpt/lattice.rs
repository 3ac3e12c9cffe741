//! Cuts the surface of the figure out of the tetrahedra of a lattice ("marching tetrahedra", Doi and
//! Koide 1991). Unlike marching cubes and surface nets this has no ambiguous cases, so the mesh is
//! closed and manifold by construction, and the body-centred cubic lattice keeps the triangles well
//! shaped.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::figure::{BOX_CENTER, BOX_HALF, Figure};
use crate::mesh::Mesh;

/// Points `(i, j, k)` of a body-centred cubic lattice: the sheared cubic grid that maps the unit steps
/// to (-1, 1, 1), (1, -1, 1) and (1, 1, -1) times half the cell. The six tetrahedra around
/// the diagonal of each grid cell (Kuhn) then become the lattice's Delaunay tetrahedra.
pub(crate) struct Lattice {
    figure: Figure,
    half_cell: f32,
    /// Points on each axis: indices run over [-reach, reach].
    reach: IVec3,
}

/// Layers that one task works through: many, so that few are evaluated twice; fixed, so that the
/// mesh doesn't depend on the number of threads.
const CHUNK: i32 = 16;

/// A layer of constant k: the figure at its points and, for each point and each of
/// the seven directions (a bit mask of i, j, k), the vertex on the edge that starts there.
struct Layer {
    values: Vec<f32>,
    ids: Vec<[u32; 8]>,
}

impl Lattice {
    pub(crate) fn new(half_cell: f32) -> Self {
        // i = (y + z) / 2, and so on; two more points, so that the outermost are outside.
        let h = BOX_HALF;
        let reach = Vec3::new(h.y + h.z, h.x + h.z, h.x + h.y) / (2.0 * half_cell);
        Self {
            figure: Figure::for_spacing(half_cell),
            half_cell,
            reach: reach.ceil().as_ivec3() + 2,
        }
    }

    /// The closed surface of the figure.
    pub(crate) fn surface(&self) -> Mesh {
        let starts: Vec<i32> = (-self.reach.z..self.reach.z).step_by(CHUNK as usize).collect();
        let chunks: Vec<Mesh> = starts.into_par_iter().map(|k| self.chunk(k)).collect();
        let mut whole = Mesh::of(self.figure);
        for chunk in chunks {
            let base = whole.vertices.len() as u32;
            whole.vertices.extend(chunk.vertices);
            whole.triangles.extend(chunk.triangles.iter().map(|t| t.map(|id| base + id)));
        }
        whole
    }

    /// The triangles between the layers `first` and `first + CHUNK`, and the vertices on edges that start
    /// there, but not in the last layer: those are the first vertices of the next chunk, so their
    /// numbers run on into it.
    fn chunk(&self, first: i32) -> Mesh {
        let last = (first + CHUNK).min(self.reach.z);
        let mut mesh = Mesh::of(self.figure);
        let mut lower = self.layer(first);
        self.number_edges(&mut lower, None, first, &mut mesh.vertices);
        for k in first..last {
            let mut upper = self.layer(k + 1);
            self.number_edges(&mut lower, Some(&upper), k, &mut mesh.vertices);
            let own = mesh.vertices.len();
            self.number_edges(&mut upper, None, k + 1, &mut mesh.vertices);
            self.cut_cells(&lower, &upper, &mut mesh.triangles);
            if k + 1 == last {
                mesh.vertices.truncate(own);
            }
            lower = upper;
        }
        mesh
    }

    fn width(&self) -> usize {
        (2 * self.reach.x + 1) as usize
    }

    fn height(&self) -> usize {
        (2 * self.reach.y + 1) as usize
    }

    /// Positions in a layer from which a cell starts, as offsets into its arrays.
    fn cells(&self) -> impl Iterator<Item = usize> {
        let width = self.width();
        (0..self.height() - 1).flat_map(move |j| (0..width - 1).map(move |i| j * width + i))
    }

    fn position(&self, offset: usize, k: i32) -> Vec3 {
        let i = (offset % self.width()) as i32 - self.reach.x;
        let j = (offset / self.width()) as i32 - self.reach.y;
        BOX_CENTER + IVec3::new(j + k - i, i + k - j, i + j - k).as_vec3() * self.half_cell
    }

    fn layer(&self, k: i32) -> Layer {
        let points = self.width() * self.height();
        let values =
            (0..points).map(|offset| self.figure.distance(self.position(offset, k))).collect();
        Layer { values, ids: vec![[0; 8]; points] }
    }

    /// Puts a vertex where the figure cuts an edge that starts in `layer`: the edges within the layer if
    /// there is no `upper`, else those that lead to `upper`.
    fn number_edges(&self, layer: &mut Layer, upper: Option<&Layer>, k: i32, out: &mut Vec<Vec3>) {
        let directions = if upper.is_some() { 4..8 } else { 1..4 };
        for start in self.cells() {
            let a = layer.values[start];
            for direction in directions.clone() {
                let end = start + self.step(direction);
                let b = upper.map_or(layer.values[end], |upper| upper.values[end]);
                if (a < 0.0) != (b < 0.0) {
                    layer.ids[start][direction] = out.len() as u32;
                    // Kept off the lattice points, where the triangles around one would vanish.
                    let t = (a / (a - b)).clamp(0.03, 0.97);
                    let end = self.position(end, k + (direction >> 2) as i32);
                    out.push(self.position(start, k).lerp(end, t));
                }
            }
        }
    }

    /// How far a corner (a bit mask of i, j, k) lies from its cell's first point within a layer.
    fn step(&self, corner: usize) -> usize {
        (corner & 1) + (corner >> 1 & 1) * self.width()
    }

    fn cut_cells(&self, lower: &Layer, upper: &Layer, out: &mut Vec<[u32; 3]>) {
        let steps: [usize; 8] = std::array::from_fn(|corner| self.step(corner));
        for start in self.cells() {
            let layer = |corner: usize| if corner < 4 { lower } else { upper };
            let inside = |corner: usize| layer(corner).values[start + steps[corner]] < 0.0;
            let count = (0..8).filter(|&corner| inside(corner)).count();
            if count == 0 || count == 8 {
                continue;
            }
            let vertex = |a: usize, b: usize| {
                // Tetrahedra climb from corner to corner by adding bits.
                let (a, b) = (a & b, a | b);
                layer(a).ids[start + steps[a]][a ^ b]
            };
            for tetrahedron in TETRAHEDRA {
                cut(tetrahedron, inside, vertex, out);
            }
        }
    }
}

/// Kuhn's tetrahedra of the cell, corners as bit masks: the ways to climb from 0 to 7. All are listed
/// with the same orientation, which costs every second one the exchange of its middle corners.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// The triangles that separate the inside corners of a tetrahedron from the others, seen
/// counter-clockwise from outside. `vertex` names the one on the edge between two corners.
fn cut(
    corners: [usize; 4],
    inside: impl Fn(usize) -> bool,
    vertex: impl Fn(usize, usize) -> u32,
    out: &mut Vec<[u32; 3]>,
) {
    let mask = (0..4).map(|n| usize::from(inside(corners[n])) << n).sum::<usize>();
    // Even permutations that bring the corners of the smaller side, inside if equal, to the front.
    let order = match mask {
        0b0001 | 0b1110 | 0b0011 => [0, 1, 2, 3],
        0b0010 | 0b1101 => [1, 0, 3, 2],
        0b0100 | 0b1011 | 0b1100 => [2, 3, 0, 1],
        0b1000 | 0b0111 => [3, 2, 1, 0],
        0b0101 => [0, 2, 3, 1],
        0b1001 => [0, 3, 1, 2],
        0b0110 => [1, 2, 0, 3],
        0b1010 => [1, 3, 2, 0],
        _ => return,
    };
    let [a, b, c, d] = order.map(|n| corners[n]);
    match mask.count_ones() {
        1 => out.push([vertex(a, b), vertex(a, c), vertex(a, d)]),
        3 => out.push([vertex(a, b), vertex(a, d), vertex(a, c)]),
        _ => {
            let [ac, ad, bd, bc] = [vertex(a, c), vertex(a, d), vertex(b, d), vertex(b, c)];
            out.extend([[ac, ad, bd], [ac, bd, bc]]);
        }
    }
}
