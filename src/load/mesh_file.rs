//! The file of a mesh, as far as what uses the mesh has to know of it.

use std::path::PathBuf;

use super::mesh::Remarks;
use super::plugins::Category;
use super::problem::Issue;
use super::properties::Object;

/// Where a mesh comes from.
#[derive(Clone, Debug)]
pub(super) struct MeshFile {
    pub(super) path: PathBuf,
    pub(super) remarks: Remarks,
    pub(super) has_uvs: bool,
}

impl MeshFile {
    /// Why a shape of it, with this material, may not look as meant.
    pub(super) fn warnings(&self, object: &Object<'_>, varies: bool) -> Vec<Issue> {
        let issue = |message: String, help: &str| {
            let message = format!("{}: {message}", self.path.display());
            Issue::new(object.place_of("filename"), message).with_help(help).once()
        };
        let mut issues = Vec::new();
        let lack = match (self.has_uvs, self.remarks.some_lack_uvs) {
            (false, _) => Some(("the mesh has", "each triangle shows the texture by itself")),
            (true, true) => Some(("some faces have", "each shows one point of the texture")),
            (true, false) => None,
        };
        if let Some((who, what)) = lack.filter(|_| varies) {
            let message =
                format!("{who} no texture coordinates, by which the material varies: {what}");
            let help = "unwrap the mesh in the program that it comes from, or give it a material without \
                        textures";
            issues.push(issue(message, help));
        }
        let materials = &self.remarks.materials;
        let why = if materials.libraries.is_empty() {
            "the file names no .mtl file (`mtllib`)"
        } else if materials.used.is_empty() {
            "no face asks for one (`usemtl`)"
        } else {
            "no such file is beside the mesh, or it does not define them"
        };
        let names = match (materials.used.is_empty(), materials.libraries.is_empty()) {
            (true, true) => return issues,
            (true, false) => format!("the materials in {}", materials.libraries),
            (false, true) => format!("the materials {} (`usemtl`)", materials.used),
            (false, false) => {
                format!("the materials {} in {}", materials.used, materials.libraries)
            }
        };
        if object.parts(Category::Bsdf).next().is_none() {
            let help = "put the .mtl file beside the mesh, or a <bsdf> into the shape";
            issues.push(issue(format!("{names} are not used: {why}"), help));
        } else if materials.used.are_several() {
            let help =
                "for several materials, write a file for each, and give each a shape of its own";
            issues.push(issue(
                format!("{names} are not used: all faces have that of the shape"),
                help,
            ));
        }
        issues
    }
}
