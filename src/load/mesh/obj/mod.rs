//! Wavefront OBJ: lines that begin with a keyword, indices that count from 1 over the whole file.

mod corners;
mod parse;

#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{Vec2, Vec3, Vec3A};

use self::corners::{Corner, Corners};
use self::parse::{Counts, Part, Reference};
use super::buffers::{Buffers, PartOfMesh, Placement};
use super::error::Fault;
use super::polygons::Polygons;
use super::remarks::{Materials, Remarks, Statements};
use super::runs::{Numbered, Runs};
use super::source::Source;
use super::text::{self, Cursor, TextFormat};
use super::{LoadedMesh, MeshOptions, ObjMaterials};

/// A mesh takes at least this part of what its text does: the corner `12345678/12345678/12345678` takes 4
/// bytes.
const TEXT_TO_MEMORY: u64 = 8;

pub(super) fn load(path: &Path, options: &MeshOptions) -> Result<LoadedMesh, Fault> {
    read(path, options)?.0.loaded(options)
}

/// The meshes of all materials, each with its name, in the order in which they occur; faces before the first `usemtl`
/// have none.
pub(super) fn load_by_material(path: &Path, options: &MeshOptions) -> Result<ObjMaterials, Fault> {
    let (mut buffers, Named { used, names, libraries }) = read(path, options)?;
    let remarks = buffers.prepare(options)?;
    let count = buffers.triangles.len();
    // One more for those that have none.
    let none = names.len() as u32;
    let material = used.values(count, none, &remarks.replaced);
    let mut meshes = Vec::new();
    for PartOfMesh { number, mesh, dropped } in buffers.split(&material, names.len() + 1)? {
        let name = names.get(number as usize).cloned();
        meshes.push((name, LoadedMesh { mesh, dropped, remarks: Remarks::default() }));
    }
    // What is to be said is said of the first one.
    if let Some((_, first)) = meshes.first_mut() {
        first.remarks = remarks;
    }
    Ok(ObjMaterials { libraries, meshes })
}

/// What faces are said to be made of.
struct Named {
    used: Runs<u32>,
    names: Vec<String>,
    libraries: Vec<String>,
}

fn read(path: &Path, options: &MeshOptions) -> Result<(Buffers, Named), Fault> {
    let mut source = Source::text(path, &options.limits)?;
    source.claim(source.stored() / TEXT_TO_MEMORY)?;
    let mut obj = Obj {
        placement: Placement::new(options),
        face_normals: options.face_normals,
        attributes: Attributes::default(),
        corners: Corners::default(),
        polygons: Polygons::default(),
        materials: Materials::default(),
        statements: Statements::default(),
        libraries: Vec::new(),
        names: Numbered::default(),
        used: Runs::default(),
        smoothing: Runs::default(),
        triangles: 0,
        furthest: [None; 3],
    };
    let (_, counts) = text::read(&mut source, &mut obj, 0, Counts::default())?;
    for (reference, count) in obj.furthest.iter().zip(counts.0) {
        reference.map_or(Ok(()), |reference: Reference| reference.check(count))?;
    }
    let mut buffers = obj.corners.finish(obj.attributes);
    buffers.polygons = obj.polygons;
    buffers.remarks.materials = obj.materials;
    buffers.remarks.statements = obj.statements;
    buffers.smoothing = obj.smoothing;
    let named = Named { used: obj.used, names: obj.names.into_names(), libraries: obj.libraries };
    Ok((buffers, named))
}

/// What the lines `v`, `vt` and `vn` of a file, or a part of it, hold; each has its own indices.
#[derive(Debug, Default)]
struct Attributes {
    positions: Vec<Vec3A>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
}

struct Obj {
    placement: Placement,
    face_normals: bool,
    attributes: Attributes,
    corners: Corners,
    polygons: Polygons,
    materials: Materials,
    statements: Statements,
    libraries: Vec<String>,
    names: Numbered,
    used: Runs<u32>,
    smoothing: Runs<Option<u32>>,
    /// How many there have been.
    triangles: usize,
    /// For v, vt and vn, the largest index that was ahead of its time. Whether it refers to
    /// something is only known at the end.
    furthest: [Option<Reference>; 3],
}

impl TextFormat for Obj {
    type Count = Counts;
    type Part = Part;

    fn count(&self, part: &mut Cursor) -> Counts {
        parse::count(part)
    }

    fn parse(&self, part: &mut Cursor, before: Counts) -> Result<Part, Fault> {
        parse::parse(part, before, &self.placement)
    }

    fn take(&mut self, part: Part) -> Result<(), Fault> {
        self.attributes.positions.extend_from_slice(&part.attributes.positions);
        self.attributes.uvs.extend_from_slice(&part.attributes.uvs);
        self.attributes.normals.extend_from_slice(&part.attributes.normals);
        let known = self.attributes.positions.len();
        self.used.append(self.triangles, part.used, |name| self.names.number(name));
        self.smoothing.append(self.triangles, part.smoothing, Some);
        self.libraries.extend(part.libraries);
        self.triangles += part.triangles.len();
        for triangle in part.triangles {
            let corners = triangle.map(|corner| Corner {
                normal: corner.normal.filter(|_| !self.face_normals),
                ..corner
            });
            self.corners.push(corners, known)?;
        }
        self.polygons.append(&part.polygons);
        self.materials.append(&part.materials);
        self.statements.append(part.statements);
        for (furthest, reference) in self.furthest.iter_mut().zip(part.furthest) {
            Reference::keep_larger(furthest, reference);
        }
        Ok(())
    }
}
