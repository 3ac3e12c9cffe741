//! Shapes that come from mesh files.

use std::fs;

use super::super::plugins::{Category, supported};
use super::super::{LoadError, LoadOptions, Loaded, load_text};
use super::SENSOR;

/// A triangle with normals and texture coordinates, another without area.
const OBJ: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0.6 0.8\nvt 0 0.25\nf 1/1/1 2/1/1 3/1/1\nf 1 2 2\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
property float z\nproperty float nx\nproperty float ny\nproperty float nz\nproperty float u\n\
property float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
0 0 0 0 0.6 0.8 0 0.25\n1 0 0 0 0.6 0.8 0 0.25\n0 1 0 0 0.6 0.8 0 0.25\n3 0 1 2\n";

/// Loads a scene of one mesh `mesh.TYPE` with this text and these further properties.
fn load(plugin: &str, mesh: impl AsRef<[u8]>, inner: &str) -> Result<Loaded, LoadError> {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join(format!("mesh.{plugin}")), mesh).expect("can be written");
    let text = format!(
        "<scene version='3.0.0'>\n<shape type='{plugin}'>\
         <string name='filename' value='mesh.{plugin}'/>{inner}</shape>{SENSOR}<emitter type='point'/></scene>"
    );
    load_text(&text, &folder.path().join("scene.xml"), &LoadOptions::default())
}

#[test]
fn every_property_has_an_effect() {
    let serialized = super::super::mesh::serialized_example(4);
    for (plugin, mesh) in
        [("obj", OBJ.as_bytes()), ("ply", PLY.as_bytes()), ("serialized", &serialized)]
    {
        let info = supported()
            .find(|p| p.category() == Category::Shape && p.name == plugin)
            .expect("in the table");
        let shape = |inner: &str| {
            let loaded = load(plugin, mesh, inner).unwrap_or_else(|e| panic!("{e}"));
            format!("{:?}", loaded.description.scene.objects()[0].shape)
        };
        let default = shape("");
        for property in info.properties.iter().filter(|p| p.name != "filename") {
            let name = property.name;
            let set = |value| shape(&format!("<boolean name='{name}' value='{value}'/>"));
            let changed = match name {
                "to_world" => shape("<transform name='to_world'><translate x='2'/></transform>"),
                "shape_index" => shape("<integer name='shape_index' value='1'/>"),
                _ if property.default.to_string() == "true" => set(false),
                _ => set(true),
            };
            assert_ne!(changed, default, "{plugin} {name}");
        }
    }
}

#[test]
fn dropped_triangles_are_one_warning() {
    let loaded = load("obj", OBJ, "").expect("valid");
    let warnings: Vec<_> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(warnings, ["left out 1 triangle without area"]);
    assert_eq!(loaded.warnings[0].position.as_ref().map(|p| p.line), Some(2));
    // One vertex out of range takes both of the triangles with it that have it.
    for (vertex, why) in [
        ("v 1e39 0 0", "with vertices that are not finite"),
        ("v 1e38 0 0", "with coordinates of 1.844e18 or more"),
    ] {
        let far = OBJ.replace("v 1 0 0", vertex);
        let loaded = load("obj", far + "v 1 0 0\nf 1 4 3\nf 1 1 4\n", "").expect("valid");
        let warnings: Vec<_> = loaded.warnings.iter().map(|w| w.message.clone()).collect();
        assert_eq!(warnings, [format!("left out 1 triangle without area and 2 triangles {why}")]);
    }
}

#[test]
fn broken_meshes_are_located_in_both_files() {
    let error =
        load("obj", OBJ.replace("v 1 0 0", "v 1 zero 0"), "").map(|_| ()).expect_err("broken");
    let problem = &error.problems()[0];
    assert_eq!(problem.position.as_ref().map(|p| (p.line, p.column)), Some((2, 50)));
    assert!(problem.message.contains("mesh.obj:2:5: expected a number, found `zero`"), "{error}");
    assert_eq!(problem.help.as_deref(), Some("the line is `v 1 zero 0`"));
}

#[test]
fn a_mesh_without_triangles_is_refused() {
    let error = load("obj", "v 0 0 0\nf 1 1 1\n", "").map(|_| ()).expect_err("empty");
    assert!(error.to_string().contains("shape `obj` has no triangle with an area"), "{error}");
}
