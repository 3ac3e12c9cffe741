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

const STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
endfacet\nendsolid\n";

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
    for (plugin, mesh) in [
        ("obj", OBJ.as_bytes()),
        ("ply", PLY.as_bytes()),
        ("stl", STL.as_bytes()),
        ("serialized", &serialized),
    ] {
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
                "max_smooth_angle" => shape("<float name='max_smooth_angle' value='30'/>"),
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

fn messages(loaded: &Loaded) -> Vec<String> {
    let message =
        |w: &crate::load::Warning| w.message.rsplit('/').next().unwrap_or_default().to_owned();
    loaded.warnings.iter().map(message).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const BOARD: &str = "<texture type='checkerboard' name='reflectance'/>";

/// Said if something varies by them: a material or a light.
#[test]
fn missing_texture_coordinates_are_said() {
    let bare = format!("{SQUARE}f 1 2 3 4\n");
    let partly = format!("{SQUARE}vt 0 0\nf 1/1 2/1 3/1\nf 1 3 4\n");
    let all = format!("{SQUARE}vt 0 0\nf 1/1 2/1 3/1 4/1\n");
    let none = "mesh.obj: the mesh has no texture coordinates, by which the material varies: each triangle shows \
                the texture by itself";
    let some = "mesh.obj: some faces have no texture coordinates, by which the material varies: each shows one \
                point of the texture";
    let board = format!("<bsdf type='diffuse'>{BOARD}</bsdf>");
    let lamp = "<emitter type='area'><texture type='checkerboard' name='radiance'/></emitter>";
    let turned = "<bsdf type='roughconductor'><float name='alpha_u' value='.1'/>\
                  <float name='alpha_v' value='.2'/></bsdf>";
    let moving = format!(
        "{board}<animation name='to_world'><transform time='0'/><transform time='1'><translate x='1'/>\
         </transform></animation>"
    );
    for (mesh, inner, expected) in [
        (&bare, board.as_str(), vec![none]),
        (&bare, lamp, vec![none]),
        (&bare, turned, vec![none]),
        (&bare, moving.as_str(), vec![none]),
        (&bare, "<bsdf type='diffuse'/>", vec![]),
        (&partly, board.as_str(), vec![some]),
        (&partly, "", vec![]),
        (&all, board.as_str(), vec![]),
    ] {
        assert_eq!(messages(&load("obj", mesh, inner).expect("valid")), expected, "{inner}");
    }
}

/// Once for a file, unless the scene gives the shape a material and the file has no more than one.
#[test]
fn materials_that_are_not_used_are_said() {
    let one = format!("mtllib my.mtl\n{SQUARE}usemtl red\nf 1 2 3\n");
    let two = format!("{one}usemtl blue\nf 1 3 4\n");
    let unnamed = format!("{SQUARE}usemtl red\nf 1 2 3\n");
    let unused = format!("mtllib my.mtl\n{SQUARE}f 1 2 3\n");
    let grey = "<bsdf type='diffuse'/>";
    for (mesh, inner, expected) in [
        (
            &one,
            "",
            vec![
                "mesh.obj: the materials `red` in `my.mtl` are not used: no such file is beside the mesh, or it does not \
                 define them",
            ],
        ),
        (&one, grey, vec![]),
        (
            &two,
            "",
            vec![
                "mesh.obj: the materials `red`, `blue` in `my.mtl` are not used: no such file is beside the mesh, or it \
                 does not define them",
            ],
        ),
        (
            &two,
            grey,
            vec![
                "mesh.obj: the materials `red`, `blue` in `my.mtl` are not used: all faces have that of the shape",
            ],
        ),
        (
            &unnamed,
            "",
            vec![
                "mesh.obj: the materials `red` (`usemtl`) are not used: the file names no .mtl file (`mtllib`)",
            ],
        ),
        (
            &unused,
            "",
            vec![
                "mesh.obj: the materials in `my.mtl` are not used: no face asks for one (`usemtl`)",
            ],
        ),
        (&unused, grey, vec![]),
    ] {
        assert_eq!(messages(&load("obj", mesh, inner).expect("valid")), expected, "{inner}");
    }
    let again = "</shape><shape type='obj'><string name='filename' value='mesh.obj'/>".repeat(3);
    assert_eq!(messages(&load("obj", &two, &again).expect("valid")).len(), 1);
}

/// Forms of one mesh whose dents are not cut alike have the same faces all the same.
#[test]
fn forms_with_dents_are_one_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, dent) in [("a.obj", "v 3 3 0"), ("b.obj", "v 1 1 0")] {
        let text = SQUARE
            .replace("v 1 1 0", dent)
            .replace("v 1 0 0", "v 4 0 0")
            .replace("v 0 1 0", "v 0 4 0");
        fs::write(folder.path().join(name), text + "f 2 3 4 1\n").expect("can be written");
    }
    let form =
        |name: &str| format!("<shape type='obj'><string name='filename' value='{name}'/></shape>");
    for [first, second] in [["a.obj", "b.obj"], ["b.obj", "a.obj"]] {
        let text = format!(
            "<scene version='3.0.0'><shape type='deformable'>{}{}</shape>\
             <sensor type='perspective'><float name='shutter_close' value='1'/></sensor></scene>",
            form(first),
            form(second)
        );
        let path = folder.path().join("scene.xml");
        load_text(&text, &path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{first}: {e}"));
    }
}

#[test]
fn a_map_that_leaves_no_area_is_named() {
    let squeezed = "<transform name='to_world'><scale value='1,0,1'/></transform>";
    for map in ["<transform name='to_world'><scale value='0'/></transform>", squeezed] {
        let error = load("obj", format!("{SQUARE}f 1 2 3 4\n"), map).map(|_| ()).expect_err("flat");
        let problem = &error.problems()[0];
        assert_eq!(
            problem.message,
            "`to_world` leaves no area of the shape: it scales an axis by 0, or by next to 0"
        );
        assert_eq!(
            problem.help.as_deref(),
            Some("scale by more than 0 along each axis in which the shape extends")
        );
    }
    // What is flat already can be flattened.
    let flat = "<transform name='to_world'><scale value='1,1,0'/></transform>";
    assert!(load("obj", format!("{SQUARE}f 1 2 3 4\n"), flat).is_ok());
}

#[test]
fn a_mesh_without_triangles_is_refused() {
    let error = load("obj", "v 0 0 0\nf 1 1 1\n", "").map(|_| ()).expect_err("empty");
    assert!(error.to_string().contains("shape `obj` has no triangle with an area"), "{error}");
}
