//! The mesh: where its vertices are, and which way is up.

use std::collections::HashSet;
use std::path::Path;

use glam::{DAffine3, DVec3};

use super::setup::Axis;
use crate::load::mesh::{
    MeshFileError, MeshFormat, MeshOptions, ObjMaterials, load_obj_by_material,
};
use crate::load::obj_materials::Overview;
use crate::memory::Limits;
use crate::shape::TriangleMesh;

/// Meshes of other sizes, in scene units, are scaled to 1: lamps and ground around them shall stay in the range that
/// 32-bit floats resolve.
const SIZES: std::ops::RangeInclusive<f64> = 1e-3..=1e5;

/// Meshes that are farther from the origin than so many times their size are moved there.
const FARTHEST: f64 = 100.0;

/// A mesh as far as camera and light depend on it.
#[derive(Debug)]
pub(super) struct Subject {
    /// Its vertices, in the scene; not those that no triangle uses.
    pub(super) points: Vec<DVec3>,
    /// The middle of the box around it, in the scene.
    pub(super) center: DVec3,
    /// Half the diagonal of that box.
    pub(super) radius: f64,
    /// The box itself.
    pub(super) bounds: [DVec3; 2],
    /// What brings it into the scene, if its own coordinates do not suit.
    pub(super) placement: Option<Placement>,
    pub(super) has_normals: bool,
    pub(super) has_materials: bool,
    /// Whether one of its materials emits.
    pub(super) emits: bool,
    /// Parts of the area below which the mesh is flat, for each of [`Axis::ALL`] as the one that is up.
    bases: [f64; 6],
}

/// A point p of the mesh becomes (p - `center`) · `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    pub(super) center: DVec3,
    pub(super) scale: f64,
}

impl Placement {
    fn to_world(self) -> DAffine3 {
        DAffine3::from_scale(DVec3::splat(self.scale)) * DAffine3::from_translation(-self.center)
    }
}

impl Subject {
    pub(super) fn load(
        path: &Path,
        format: MeshFormat,
        limits: &Limits,
    ) -> Result<Self, MeshFileError> {
        let mut options = MeshOptions { limits: limits.clone(), ..MeshOptions::default() };
        let mut read = Read::new(path, format, &options)?;
        let mut points = read.points();
        let placement = unsuitable(bounds(&points));
        if let Some(placement) = placement {
            // Once more, since the file may have more digits than 32-bit floats keep so far out.
            options.to_world = placement.to_world();
            read = Read::new(path, format, &options)?;
            points = read.points();
        }
        let bounds @ [least, most] = bounds(&points);
        Ok(Self {
            points,
            center: (least + most) / 2.0,
            radius: (most - least).length() / 2.0,
            bounds,
            placement,
            has_normals: read.meshes.iter().any(|mesh| !mesh.normals().is_empty()),
            has_materials: read.materials.any,
            emits: read.materials.emits,
            bases: Axis::ALL.map(|up| read.meshes.iter().map(|mesh| base(mesh, bounds, up)).sum()),
        })
    }

    /// Which way is up, and why: +z in STL files, +y in others, unless the mesh stands on a flat base elsewhere.
    pub(super) fn up(&self, format: MeshFormat) -> (Axis, &'static str) {
        let usual = Axis::new(if format == MeshFormat::Stl { 2 } else { 1 }, false);
        let area = |up: Axis| {
            let at = |negative| Axis::ALL.iter().position(|a| *a == Axis::new(up.index, negative));
            [up.negative, !up.negative].map(|side| at(side).map_or(0.0, |i| self.bases[i]))
        };
        // A plate that lies flat is no statue on a base.
        let extents = self.bounds[1] - self.bounds[0];
        let is_tall = |up: Axis| extents[up.index] >= extents.max_element() / 2.0;
        let stands = |up: &Axis| {
            let [below, above] = area(*up);
            below >= 0.2 && above <= 0.02 && is_tall(*up)
        };
        if area(usual)[0] >= 0.05 {
            return (usual, "as in most such files");
        }
        let mut others = Axis::ALL.into_iter().filter(stands);
        match (others.next(), others.next()) {
            (Some(up), None) => (up, "by its flat base"),
            _ => (usual, "as in most such files"),
        }
    }
}

/// A file.
struct Read {
    /// One, or one for each material.
    meshes: Vec<TriangleMesh>,
    materials: Overview,
}

impl Read {
    fn new(path: &Path, format: MeshFormat, options: &MeshOptions) -> Result<Self, MeshFileError> {
        if format != MeshFormat::Obj {
            let meshes = vec![format.load(path, options)?.mesh];
            return Ok(Self { meshes, materials: Overview::default() });
        }
        let ObjMaterials { libraries, meshes } = load_obj_by_material(path, options)?;
        let used: HashSet<_> = meshes.iter().filter_map(|(name, _)| name.as_deref()).collect();
        let materials = Overview::of(path, &libraries, &used, &options.limits);
        Ok(Self { meshes: meshes.into_iter().map(|(_, loaded)| loaded.mesh).collect(), materials })
    }

    /// The vertices that triangles use.
    fn points(&self) -> Vec<DVec3> {
        let mut points = Vec::new();
        for mesh in &self.meshes {
            let mut used = vec![false; mesh.positions().len()];
            mesh.triangles().iter().flatten().for_each(|&i| used[i as usize] = true);
            let of_triangles = mesh.positions().iter().zip(used).filter(|(_, used)| *used);
            points.extend(of_triangles.map(|(p, _)| p.as_dvec3()));
        }
        points
    }
}

fn bounds(points: &[DVec3]) -> [DVec3; 2] {
    let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points.iter().fold(empty, |[least, most], &p| [least.min(p), most.max(p)])
}

/// What brings a mesh into reach that is too large, too small or too far away.
fn unsuitable([least, most]: [DVec3; 2]) -> Option<Placement> {
    let (center, radius) = ((least + most) / 2.0, (most - least).length() / 2.0);
    let far = center.length() > FARTHEST * radius;
    let suits = SIZES.contains(&radius) && !far;
    (!suits && radius.is_finite() && radius > 0.0).then(|| Placement {
        center,
        scale: if SIZES.contains(&radius) { 1.0 } else { 1.0 / radius },
    })
}

/// Which part of the box's underside is a flat base of the mesh.
fn base(mesh: &TriangleMesh, [least, most]: [DVec3; 2], up: Axis) -> f64 {
    let extents = most - least;
    let (down, index) = (-up.direction(), up.index);
    let bottom = if up.negative { most[index] } else { least[index] };
    let near = extents[index] * 0.01;
    let area: f64 = mesh
        .triangles()
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| mesh.positions()[i as usize].as_dvec3());
            let low = [a, b, c].iter().all(|p| (p[index] - bottom).abs() <= near);
            let normal = (b - a).cross(c - a);
            let faces_down = low && normal.dot(down) > 0.99 * normal.length();
            if faces_down { normal.length() / 2.0 } else { 0.0 }
        })
        .sum();
    let underside = extents[(index + 1) % 3] * extents[(index + 2) % 3];
    if underside > 0.0 { area / underside } else { 0.0 }
}
