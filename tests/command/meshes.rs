//! A mesh in the place of a scene.

use std::fs;

use crate::support::command::Folder;

/// A pyramid with a square base.
const PYRAMID: &str = "v -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nv 0 2 0\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";

const MTL: &str =
    "newmtl red\nKd 0.8 0.1 0.1\nnewmtl blue\nKd 0.1 0.1 0.8\nKs 0.5 0.5 0.5\nNs 100\n";

fn folder() -> Folder {
    let folder = Folder::new();
    let faces =
        PYRAMID.replace("f 1 2", "usemtl red\nf 1 2").replace("f 3 4", "usemtl blue\nf 3 4");
    for (name, text) in [
        ("a.obj", PYRAMID.to_owned()),
        ("b.OBJ", format!("mtllib b.mtl\n{faces}")),
        ("b.mtl", MTL.to_owned()),
        ("broken.obj", PYRAMID.replace("v 0 2 0", "v 0 two 0")),
        ("c.stl", stl()),
    ] {
        fs::write(folder.path(name), text).expect("writable");
    }
    folder
}

fn stl() -> String {
    let facet = |[a, b, c]: [&str; 3]| {
        format!(
            "facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n"
        )
    };
    let (a, b, c, d) = ("0 0 0", "1 0 0", "0 1 0", "0 0 1");
    let facets = [[a, c, b], [a, b, d], [b, c, d], [c, a, d]].map(facet).concat();
    format!("solid\n{facets}endsolid\n")
}

/// For all formats and whatever is asked for, `telamon scene` writes what a render of the mesh shows, to the last bit.
#[test]
fn the_scene_of_a_mesh_is_its_picture() {
    let folder = folder();
    for (mesh, options) in [
        ("a.obj", ""),
        ("b.OBJ", "--view front --fov 50 --size 20x30"),
        ("b.OBJ", "--material gold --light sky --background 0.2,0.1,0"),
        ("c.stl", "--up -z --ground off --background transparent"),
        ("c.stl", "--view -120,-20 --material glass"),
    ] {
        let size = if options.contains("--size") { "" } else { "--size 24x18" };
        let written = folder.succeed(&format!("scene {mesh} {options} {size}"));
        assert_eq!(written.stderr, "");
        fs::write(folder.path("made.xml"), &written.stdout).expect("writable");
        folder.succeed(&format!("render {mesh} {options} {size} --spp 4 -o mesh.png -o mesh.exr"));
        folder.succeed("render made.xml --spp 4 -o scene.png -o scene.exr");
        let read = |name: &str| {
            let image = telamon::film::read::read_exr(&folder.path(name)).expect("written");
            format!("{image:?}")
        };
        assert_eq!(folder.png("mesh.png"), folder.png("scene.png"), "{mesh} {options}");
        assert_eq!(read("mesh.exr"), read("scene.exr"), "{mesh} {options}");
    }
}

/// One line says what was chosen and with what it is changed.
#[test]
fn what_was_chosen_is_said() {
    let folder = folder();
    let said = |arguments: &str| {
        let run = folder.succeed(&format!("render {arguments} --size 16x12 --spp 1 -o a.png"));
        run.stderr.lines().next().expect("a line").to_owned()
    };
    assert_eq!(
        said("a.obj"),
        "a.obj: seen from three-quarter (--view), +y is up, as in most such files (--up), 30 degrees across (--fov); light \
         studio (--light), ground on (--ground), background by the light (--background), material clay (--material), 16x12 \
         pixels (--size)"
    );
    assert_eq!(
        said("b.OBJ --view 10,-5 --up z --fov 12.5 --light sky --background black"),
        "b.OBJ: seen from 10,-5 (--view), +z is up, as asked (--up), 12.5 degrees across (--fov); light sky (--light), ground \
         off (--ground), background 0,0,0 (--background), material file (--material), 16x12 pixels (--size)"
    );
    assert!(said("c.stl").contains("+z is up"));
    let quiet = folder.succeed("render a.obj --size 16x12 --spp 1 -o a.png --quiet");
    assert_eq!(quiet.stderr, "");
}

/// A mesh is taken wherever a scene is.
#[test]
fn all_commands_take_meshes() {
    let folder = folder();
    folder.succeed("render c.stl --size 16x12 --spp 1");
    assert!(folder.names().contains(&"c.png".to_owned()), "{:?}", folder.names());
    let inspected = folder.succeed("inspect b.OBJ").stdout;
    for part in [
        "red",
        "blue",
        "800x600 pixels",
        "sobol, until the relMSE is 0.000625, at most 256 samples per pixel",
        "perspective",
    ] {
        assert!(inspected.contains(part), "{part}: {inspected}");
    }
    let traced = folder.succeed("trace a.obj --size 16x12 --pixel 8,6").stdout;
    assert!(traced.contains("radiance"), "{traced}");
    folder
        .succeed("measure a.obj --size 8x6 --vary spp=1,2 --reference-spp 16 --repeats 2 --quiet");
    // And not 256, which a render would not take either.
    let measured =
        folder.succeed("measure a.obj --size 8x6 --reference-spp 64 --repeats 2 --quiet");
    assert!(measured.stdout.contains(" 16 "), "{}", measured.stdout);
    let rays = folder.succeed("parity c.stl --rays 2000").stdout;
    assert!(rays.contains("watertight"), "{rays}");
}

#[test]
fn a_turntable_is_numbered_pictures() {
    let folder = folder();
    folder.succeed("render b.OBJ --turntable 3 --size 16x12 --spp 1 -o t%02d.png -o t%d.exr");
    let names = folder.names();
    for name in ["t00.png", "t01.png", "t02.png", "t0.exr", "t1.exr", "t2.exr"] {
        assert!(names.contains(&name.to_owned()), "{name}: {names:?}");
    }
    assert_ne!(folder.png("t00.png"), folder.png("t01.png"));
    let error = folder.fail("render a.obj --turntable 3 -o t.png", 2);
    assert!(error.contains("needs a place for the number in the name of each picture"), "{error}");
    let error = folder.fail("render scene.xml --turntable 3 -o t%d.png", 2);
    assert!(
        error.contains("`--turntable` is for meshes, and `scene.xml` is a scene file"),
        "{error}"
    );
}

#[test]
fn what_is_wrong_is_said() {
    let folder = folder();
    for option in [
        "--up x",
        "--view top",
        "--fov 20",
        "--light sky",
        "--ground off",
        "--material clay",
        "--background white",
    ] {
        for command in ["render", "inspect", "measure --vary spp=1", "trace --pixel 0,0", "scene"] {
            let (command, more) = command.split_once(' ').unwrap_or((command, ""));
            let error = folder.fail(&format!("{command} scene.xml {option} {more}"), 2);
            let (name, _) = option.split_once(' ').expect("a value");
            let expected = format!(
                "`{name}` is for meshes, and `scene.xml` is a scene file, which says it itself"
            );
            assert!(error.contains(&expected), "{command} {option}: {error}");
        }
    }
    let error = folder.fail("scene scene.xml", 2);
    assert!(
        error.contains("`scene.xml` is no mesh (expected .obj, .ply, .stl or .serialized"),
        "{error}"
    );
    let error = folder.fail("render broken.obj -o a.png", 1);
    assert!(error.contains("broken.obj:5:5: expected a number, found `two`"), "{error}");
    fs::write(folder.path("mesh.txt"), "v 0 0 0\n").expect("writable");
    let error = folder.fail("render mesh.txt -o a.png", 1);
    assert!(
        error.contains("help: a scene file begins with `<`; a mesh is told by its name"),
        "{error}"
    );
    let error = folder.fail("render none.stl -o a.png", 1);
    assert!(error.contains("none.stl: cannot be read: No such file"), "{error}");
    let error = folder.fail("render x.glb", 1);
    assert!(
        error.contains("x.glb: the format glTF is not read (expected a scene file, .xml, or a mesh: .obj, .ply, .stl or"),
        "{error}"
    );
    let error = folder.fail("render a.obj --live terminal -o a.png", 1);
    assert!(
        error.contains("`--live terminal` needs a terminal, and standard error is none"),
        "{error}"
    );
    // Nobody wrote the scene that is made of a mesh, so nothing is shown of it.
    fs::write(folder.path("d.obj"), format!("{PYRAMID}f 1 1 2\nf 1 2 2\n")).expect("writable");
    let run = folder.succeed("render d.obj --size 8x6 --spp 1 -o d.png --quiet");
    assert_eq!(run.stderr, "warning: d.obj: left out 2 triangles without area\n");
    let error = folder.fail("render a.obj -o a.png --light none.exr", 1);
    assert!(error.starts_with("a.obj: "), "{error}");
    for (option, expected) in [
        ("--fov 0", "expected degrees from 1 to 170"),
        ("--up w", "expected an axis: +x, +y, +z, -x, -y or -z"),
        ("--material cheese", "[possible values: file, clay, plaster,"),
        ("--ground maybe", "[possible values: on, off]"),
        ("--light none", "without a light the picture is black"),
    ] {
        let code = if option.starts_with("--light") { 1 } else { 2 };
        let error = folder.fail(&format!("render a.obj -o a.png {option}"), code);
        assert!(error.contains(expected), "{option}: {error}");
    }
}
