//! Polygons to triangles.
//!
//! Formats give them as fans around their first corner. A fan is right where all of its triangles face as
//! the polygon does, as those of convex polygons do. Of a quadrilateral where it is not, the other diagonal is
//! taken; a polygon of more corners becomes the constrained Delaunay triangulation of its projection to one of
//! the coordinate planes, inside of which it winds. Corners that share a place are told apart by the sides
//! between which a triangle lies there, so holes may be joined to the outline by sides that are passed both
//! ways.

use std::collections::HashMap;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;
use spade::handles::FixedVertexHandle;
use spade::{
    ConstrainedDelaunayTriangulation, Intersection, LineIntersectionIterator, Point2, Triangulation,
};

type Triangles = Vec<[u32; 3]>;

/// How many corners the polygons have, in their order; neighbours of one size are counted together.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons(Vec<Run>);

#[derive(Clone, Copy, Debug)]
struct Run {
    corners: usize,
    polygons: usize,
}

impl Run {
    /// Triangles of one of its polygons.
    fn fan(self) -> usize {
        self.corners - 2
    }
}

/// Triangles that took the place of a polygon's fan.
#[derive(Clone, Debug)]
pub(in crate::load) struct Replaced {
    /// The first of them.
    at: usize,
    /// How many they are.
    count: usize,
    fan: Triangles,
}

impl Replaced {
    /// The first of its triangles, among those that there are now.
    pub(super) fn at(&self) -> usize {
        self.at
    }

    /// How many more triangles it has than the fan had.
    pub(super) fn growth(&self) -> isize {
        self.count as isize - self.fan.len() as isize
    }
}

/// What became of the polygons.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    /// In the order of the triangles.
    pub(super) replaced: Vec<Replaced>,
    /// Polygons that cross themselves: they stay fans.
    pub(super) crossing: usize,
}

/// What is to be done with a fan.
enum Verdict {
    Good,
    Replace(Triangles),
    /// Its polygon crosses itself.
    Crossing,
}

impl Polygons {
    /// Adds a polygon of at least three corners.
    pub(super) fn push(&mut self, corners: usize) {
        self.push_run(Run { corners, polygons: 1 });
    }

    /// Adds the polygons of the next piece of a file.
    pub(super) fn append(&mut self, other: &Self) {
        other.0.iter().for_each(|&run| self.push_run(run));
    }

    fn push_run(&mut self, run: Run) {
        match self.0.last_mut() {
            Some(last) if last.corners == run.corners => last.polygons += run.polygons,
            _ => self.0.push(run),
        }
    }

    /// Puts better triangles in the place of fans that leave their polygons. `triangles` are the fans of all
    /// polygons, in their order; one with an index out of range is left alone.
    pub(super) fn triangulate(&self, positions: &[Vec3A], triangles: &mut Triangles) -> Outcome {
        let mut start = 0;
        let mut found = Vec::new();
        for run in &self.0 {
            let fans = &triangles[start..start + run.polygons * run.fan()];
            if run.corners > 3 {
                let better = fans.par_chunks_exact(run.fan()).enumerate();
                let better = better.filter_map(|(polygon, fan)| match judge(positions, fan) {
                    Verdict::Good => None,
                    verdict => Some((start + polygon * run.fan(), verdict)),
                });
                found.par_extend(better);
            }
            start += fans.len();
        }
        let mut outcome = Outcome::default();
        let mut fans = HashMap::new();
        for (at, verdict) in found {
            match verdict {
                Verdict::Good => {}
                Verdict::Replace(better) => drop(fans.insert(at, better)),
                Verdict::Crossing => outcome.crossing += 1,
            }
        }
        if !fans.is_empty() {
            outcome.replaced = self.splice(triangles, &fans);
        }
        outcome
    }

    /// Puts triangles into the place of the fans that begin at those indices.
    fn splice(
        &self,
        triangles: &mut Triangles,
        better: &HashMap<usize, Triangles>,
    ) -> Vec<Replaced> {
        let old = std::mem::take(triangles);
        triangles.reserve_exact(old.len());
        let mut replaced = Vec::with_capacity(better.len());
        let mut start = 0;
        for run in &self.0 {
            for fan in old[start..].chunks_exact(run.fan()).take(run.polygons) {
                match better.get(&start) {
                    None => triangles.extend_from_slice(fan),
                    Some(better) => {
                        let (at, count) = (triangles.len(), better.len());
                        replaced.push(Replaced { at, count, fan: fan.to_vec() });
                        triangles.extend_from_slice(better);
                    }
                }
                start += fan.len();
            }
        }
        replaced
    }
}

/// The fans of all polygons, given the triangles that took the place of some.
pub(in crate::load) fn fans(triangles: &[[u32; 3]], replaced: &[Replaced]) -> Triangles {
    let mut fans = Vec::with_capacity(triangles.len());
    let mut start = 0;
    for Replaced { at, count, fan } in replaced {
        fans.extend_from_slice(&triangles[start..*at]);
        fans.extend_from_slice(fan);
        start = at + count;
    }
    fans.extend_from_slice(&triangles[start..]);
    fans
}

/// Turns the fans round, as their triangles were.
pub(super) fn flip(replaced: &mut [Replaced]) {
    for triangle in replaced.iter_mut().flat_map(|r| &mut r.fan) {
        triangle.swap(1, 2);
    }
}

fn judge(positions: &[Vec3A], fan: &[[u32; 3]]) -> Verdict {
    let known = |&i: &u32| (i as usize) < positions.len();
    if !fan.iter().flatten().all(known) {
        return Verdict::Good;
    }
    let at = |i: u32| positions[i as usize].as_dvec3();
    let first = at(fan[0][0]);
    let cross = |&[_, b, c]: &[u32; 3]| (at(b) - first).cross(at(c) - first);
    // Twice the area, as a vector (Newell's normal): f64 holds the products of f32 without underflow.
    let normal: DVec3 = fan.iter().map(cross).sum();
    let faces = || fan.iter().map(|triangle| cross(triangle).dot(normal));
    // Triangles that are not finite or without area are reported by the mesh.
    if faces().all(|d| d > 0.0) || !normal.is_finite() || normal == DVec3::ZERO {
        return Verdict::Good;
    }
    let none_better = || if faces().all(|d| d >= 0.0) { Verdict::Good } else { Verdict::Crossing };
    let mut corners = vec![fan[0][0], fan[0][1]];
    corners.extend(fan.iter().map(|triangle| triangle[2]));
    if let [a, b, c, d] = corners[..] {
        let other = [[b, c, d], [b, d, a]];
        let faces = |&[a, b, c]: &[u32; 3]| (at(b) - at(a)).cross(at(c) - at(a)).dot(normal) > 0.0;
        return if other.iter().all(faces) {
            Verdict::Replace(other.to_vec())
        } else {
            none_better()
        };
    }
    let triangles = projections(positions, &corners, normal).into_iter().find_map(|p| within(&p));
    triangles.map_or_else(none_better, |triangles| {
        Verdict::Replace(triangles.into_iter().map(|t| t.map(|i| corners[i])).collect())
    })
}

/// The corners in a plane where they go round counter-clockwise: as they are, without the coordinate along
/// which the polygon is thinnest, which no rounding touches; and, in case that is not flat enough, seen along
/// its normal.
fn projections(positions: &[Vec3A], corners: &[u32], normal: DVec3) -> [Vec<Point2<f64>>; 2] {
    let size = normal.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let (mut x, mut y) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (x, y) = (y, x);
    }
    // A power of 2, so that the smallest f32 are no too small numbers for the triangulation.
    let scale = 2f64.powi(64);
    let unit = normal.normalize_or_zero();
    let first = positions[corners[0] as usize].as_dvec3();
    [false, true].map(|along_normal| {
        let project = |&i: &u32| {
            let mut p = positions[i as usize].as_dvec3();
            if along_normal {
                p -= unit * (p - first).dot(unit);
            }
            Point2::new(p[x] * scale, p[y] * scale)
        };
        corners.iter().map(project).collect()
    })
}

/// Triangles between the points of a polygon, counter-clockwise; `None` if it crosses itself.
fn within(polygon: &[Point2<f64>]) -> Option<Vec<[usize; 3]>> {
    let count = polygon.len();
    // One vertex for each place; `corners` are those that share it.
    let mut places = HashMap::new();
    let (mut vertices, mut corners) = (Vec::new(), Vec::<Vec<usize>>::new());
    let vertex_of: Vec<usize> = (0..count)
        .map(|i| {
            // -0 and 0 are one place.
            let Point2 { x, y } = polygon[i];
            let vertex = *places.entry([x + 0.0, y + 0.0].map(f64::to_bits)).or_insert_with(|| {
                vertices.push(polygon[i]);
                corners.push(Vec::new());
                vertices.len() - 1
            });
            corners[vertex].push(i);
            vertex
        })
        .collect();
    let sides = || (0..count).map(|i| [vertex_of[i], vertex_of[(i + 1) % count]]);
    let mut edges: Vec<_> =
        sides().filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.dedup();
    let mut crosses = false;
    let mesh =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(vertices, edges, |_| {
            crosses = true;
        })
        .ok()
        .filter(|_| !crosses)?;

    // How often the outline runs along each edge, counted in the edge's own direction.
    let mut runs = vec![0_i32; mesh.num_undirected_edges()];
    for [a, b] in sides().filter(|[a, b]| a != b) {
        let [a, b] = [a, b].map(FixedVertexHandle::from_index);
        for step in LineIntersectionIterator::new_from_handles(&mesh, a, b) {
            match step {
                Intersection::EdgeOverlap(edge) => {
                    let forward = edge.as_undirected().as_directed() == edge;
                    runs[edge.as_undirected().fix().index()] += if forward { 1 } else { -1 };
                }
                Intersection::VertexIntersection(_) => {}
                Intersection::EdgeIntersection(_) => return None,
            }
        }
    }
    // How often the outline goes round each face, from the outer one inwards.
    let mut windings = vec![None; mesh.num_all_faces()];
    windings[mesh.outer_face().fix().index()] = Some(0);
    let mut open: Vec<_> =
        mesh.directed_edges().filter(|e| e.is_outer_edge()).map(|e| e.fix()).collect();
    while let Some(edge) = open.pop() {
        let edge = mesh.directed_edge(edge);
        let (left, right) = (edge.face().fix().index(), edge.rev().face());
        if windings[right.fix().index()].is_some() {
            continue;
        }
        let forward = edge.as_undirected().as_directed() == edge;
        let run = runs[edge.as_undirected().fix().index()] * if forward { 1 } else { -1 };
        windings[right.fix().index()] = windings[left].map(|winding: i32| winding - run);
        if let Some(face) = right.as_inner() {
            open.extend(face.adjacent_edges().map(|e| e.fix()));
        }
    }
    let corner_at = |vertex: usize, middle: Point2<f64>| match corners[vertex][..] {
        [corner] => corner,
        ref several => {
            let between = |&&i: &&usize| {
                let (before, after) = ((i + count - 1) % count, (i + 1) % count);
                is_between(polygon[before], polygon[i], polygon[after], middle)
            };
            *several.iter().find(between).unwrap_or(&several[0])
        }
    };
    let triangles = mesh.inner_faces().filter_map(|face| {
        let middle = face.center();
        let [a, b, c] = face.vertices().map(|vertex| corner_at(vertex.fix().index(), middle));
        match windings[face.fix().index()].unwrap_or(0) {
            0 => None,
            1.. => Some([a, b, c]),
            _ => Some([a, c, b]),
        }
    });
    Some(triangles.collect())
}

/// Whether `p` lies in the angle of the corner `at`, to the left of the sides that come and go.
fn is_between(before: Point2<f64>, at: Point2<f64>, after: Point2<f64>, p: Point2<f64>) -> bool {
    let left = |a: Point2<f64>, b: Point2<f64>, c: Point2<f64>| {
        (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0.0
    };
    let (of_first, of_second) = (left(before, at, p), left(at, after, p));
    if left(before, at, after) { of_first && of_second } else { of_first || of_second }
}

#[cfg(test)]
mod tests;
