use std::f64::consts::PI;
use std::fs;

use glam::{DVec3, Vec2, Vec3A};

use super::super::{LoadError, LoadOptions, Loaded, load_text};
use super::material::{Kind, Plastics};
use super::{Library, Map, Mtl};
use crate::bsdf::microfacet::Distribution;
use crate::bsdf::plastic::Coat;
use crate::bsdf::{Bsdf, Place, RoughPlastic};
use crate::math::Rgb;

fn parse(text: &str) -> Library {
    Library::parse(text).unwrap_or_else(|(line, problem)| panic!("{line}: {problem}"))
}

fn kind(statements: &str) -> Kind {
    parse(&format!("newmtl a\n{statements}")).materials[0].kind()
}

#[test]
fn statements_are_read() {
    let library = parse(
        "\u{feff}# exported\r\nnewmtl  my red \n\tKd 0.5 0.25 0 # not grey\n Ks .5\nKe 1 2 3\nNs 98\nNi 1.4\nTr 0.25\nillum \
         2\nTf 1 1 1\nKa 1 1 1\nmap_Kd -s 2 3 -o 0.5 -clamp on -mm 0 1 a picture.png\nbump -bm 0.3 -imfchan l \
         b.png\nnorm c.png\nmap_d\nPr 0.5\nPm 1\nPr 0.1\nmap_Ks d.png\nnewmtl second\nd 0.5\nTr 0.9\nKd xyz 1 1 1\n",
    );
    let [first, second] = library.materials.as_slice() else { panic!("two") };
    let map = |file: &str| Map {
        file: file.to_owned(),
        scale: [1.0; 2],
        offset: [0.0; 2],
        clamp: false,
        bump: 1.0,
    };
    let expected = Mtl {
        name: "my red".to_owned(),
        diffuse: Some(DVec3::new(0.5, 0.25, 0.0)),
        specular: Some(DVec3::splat(0.5)),
        emission: Some(DVec3::new(1.0, 2.0, 3.0)),
        transmission: Some(DVec3::ONE),
        exponent: Some(98.0),
        index: Some(1.4),
        opacity: Some(0.75),
        illumination: Some(2),
        diffuse_map: Some(Map {
            scale: [2.0, 3.0],
            offset: [0.5, 0.0],
            clamp: true,
            ..map("a picture.png")
        }),
        opacity_map: None,
        bump_map: Some(Map { bump: 0.3, ..map("b.png") }),
        normal_map: Some(map("c.png")),
    };
    assert_eq!(*first, expected);
    assert_eq!((second.opacity, second.diffuse), (Some(0.5), None));
    assert_eq!(library.unused, ["Kd", "Pm", "Pr", "map_Ks"]);
}

/// What becomes of a material, and the roughness α with α² = 2/(Ns + 2).
#[test]
fn kinds_follow_the_format() {
    let (half, grey) = (DVec3::splat(0.5), DVec3::splat(0.8));
    let plastic = |index, exponent: f64| Kind::Plastic {
        diffuse: half,
        specular: DVec3::ONE,
        index,
        alpha: (2.0 / (exponent + 2.0)).sqrt(),
    };
    let glass = |index, transmission| Kind::Glass { index, transmission };
    for (statements, expected) in [
        ("", Kind::Diffuse { diffuse: grey }),
        ("Kd 2 -1 .5", Kind::Diffuse { diffuse: DVec3::new(1.0, 0.0, 0.5) }),
        ("Kd .5\nKs 0\nNs 10\nillum 2", Kind::Diffuse { diffuse: half }),
        ("Kd .5\nKs 1\nillum 1", Kind::Diffuse { diffuse: half }),
        ("Kd .5\nKs 1\nNs 98\nillum 2", plastic(1.5, 98.0)),
        ("Kd .5\nKs 1\nNs 0\nNi 1.3", plastic(1.3, 0.0)),
        ("Kd .5\nKs 1\nNi 1\nillum 10", plastic(1.5, 30.0)),
        ("Kd .25\nKs .5\nillum 3", Kind::Mirror { diffuse: DVec3::splat(0.25), specular: half }),
        // Together more than all: scaled to all.
        ("Kd 1\nKs 1\nillum 5", Kind::Mirror { diffuse: half, specular: half }),
        ("Kd 0\nKs .5\nillum 8", Kind::Mirror { diffuse: DVec3::ZERO, specular: half }),
        ("Kd .5\nNi 1.33\nillum 7", glass(1.33, DVec3::ONE)),
        ("Kd .5\nd 0.1\nTf .5 1 1\nillum 4", glass(1.5, DVec3::new(0.5, 1.0, 1.0))),
        // What Maya writes for everything.
        ("Kd .5\nTf 1 1 1\nNi 1\nillum 4", Kind::Diffuse { diffuse: half }),
        // The map is not black, whatever stands beside it.
        ("Kd 0 0 0\nmap_Kd a.png", Kind::Diffuse { diffuse: DVec3::ONE }),
    ] {
        assert_eq!(kind(statements), expected, "{statements}");
    }
}

#[test]
fn every_problem_is_named() {
    for (text, expected) in [
        ("Kd 1 1 1", (1, "`Kd` before the first `newmtl`")),
        ("newmtl", (1, "`newmtl` needs a name")),
        ("newmtl a\nKd red", (2, "`Kd`: expected a number, found `red`")),
        ("newmtl a\n\nKd nan", (3, "`Kd`: expected a number, found `nan`")),
        ("newmtl a\nKs 1 1", (2, "`Ks` takes 3 numbers, but the line has 2")),
        ("newmtl a\nNs", (2, "`Ns` takes 1 number, but the line has 0")),
        ("newmtl a\nNi 1 2", (2, "`Ni` takes 1 number, but the line has 2")),
        ("newmtl a\nmap_Kd -wide a.png", (2, "unknown option `-wide` of a texture")),
        ("newmtl a\nbump -bm a.png", (2, "`-bm`: expected a number, found `a.png`")),
    ] {
        let (line, problem) = Library::parse(text).map(|_| ()).expect_err(text);
        assert_eq!((line, problem.as_str()), expected, "{text}");
    }
}

/// A square of two materials, one left of x = 0 and one right of it.
const OBJ: &str = "mtllib a b.mtl\nv -1 0 0\nv 0 0 0\nv 1 0 0\nv -1 1 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
usemtl red\nf 1/1 2/2 5/3 4/4\nusemtl blue\nf 2/1 3/2 6/3 5/4\n";

/// The scene of [`OBJ`] with these materials; `picture.png` is 2x2 pixels, the upper ones 51/255 and the lower ones white;
/// `normals.png` shows the normal (0, 0.6, 0.8) everywhere, and `ridge.png` (0, -0.6, 0.8) in its lower pixels.
fn load(obj: &str, mtl: Option<&str>, inner: &str) -> Result<Loaded, LoadError> {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).expect("can be written");
    };
    write("mesh.obj", obj);
    if let Some(mtl) = mtl {
        write("a b.mtl", mtl);
    }
    let pixels = image::GrayImage::from_raw(2, 2, vec![51, 51, 255, 255]).expect("four");
    pixels.save(folder.path().join("picture.png")).expect("can be written");
    let normals = |rows: [u8; 2]| {
        image::RgbImage::from_fn(2, 2, |_, y| image::Rgb([128, rows[y as usize], 230]))
    };
    normals([204; 2]).save(folder.path().join("normals.png")).expect("can be written");
    normals([204, 51]).save(folder.path().join("ridge.png")).expect("can be written");
    let text = format!(
        "<scene version='3.0.0'><shape type='obj'><string name='filename' value='mesh.obj'/>{inner}</shape>\
         <sensor type='perspective'/><emitter type='point'/></scene>"
    );
    load_text(&text, &folder.path().join("scene.xml"), &LoadOptions::default())
}

fn messages(loaded: &Loaded) -> Vec<String> {
    let last = |w: &crate::load::Warning| w.message.rsplit('/').next().unwrap_or("").to_owned();
    loaded.warnings.iter().map(last).collect()
}

/// The reflected fraction of light that comes straight down.
fn albedo(bsdf: &dyn Bsdf, uv: Vec2) -> Rgb {
    let place = Place { uv: uv.into(), ..Place::default() };
    bsdf.albedo(&place, Vec3A::Z)
}

#[test]
fn each_group_has_its_material() {
    let mtl =
        "newmtl blue\nKd 0 0 1\nnewmtl red\nKd 1 0 0\nKe 2 1 0\nnewmtl other\nKd 0 1 0\nPr 1\n";
    let loaded = load(OBJ, Some(mtl), "").expect("good files");
    let scene = &loaded.description.scene;
    let objects: Vec<_> = scene.objects().iter().map(|o| (o.name.as_str(), o.emitter)).collect();
    assert_eq!(objects, [("red", Some(0)), ("blue", None)]);
    for (object, (left, right, color)) in
        scene.objects().iter().zip([(-1.0, 0.0, Rgb::X), (0.0, 1.0, Rgb::Z)])
    {
        let bounds = object.shape.bounds();
        assert_eq!((bounds.min.x, bounds.max.x), (left, right));
        let found = albedo(scene.bsdfs()[object.bsdf].as_ref(), Vec2::ZERO);
        assert!((found - color).abs().max_element() < 1e-6, "{found}");
    }
    assert_eq!(messages(&loaded), ["a b.mtl: without effect: `Pr`"]);
    // Power of the lamp: π times area times radiance.
    let power = scene.emitters()[0].power().expect("a lamp");
    let expected = PI * f64::from(crate::math::luminance(Rgb::new(2.0, 1.0, 0.0)));
    assert!((power / expected - 1.0).abs() < 1e-3, "{power} {expected}");
}

/// `Kd` times the picture, whose first row is the upper one, as in the file's coordinates.
#[test]
fn pictures_lie_as_the_format_says() {
    for (statement, inner, low, high) in [
        ("map_Kd picture.png", "", 1.0, 0.033_104_767),
        ("Kd .5 .5 .5\nmap_Kd picture.png", "", 0.5, 0.5 * 0.033_104_767),
        // Half a picture up.
        ("map_Kd -o 0 0.5 picture.png", "", 0.033_104_767, 1.0),
    ] {
        let mtl = format!("newmtl red\n{statement}\n");
        let loaded = load(OBJ, Some(&mtl), inner).expect("good files");
        let scene = &loaded.description.scene;
        let object = &scene.objects()[0];
        let bsdf = scene.bsdfs()[object.bsdf].as_ref();
        // Our v counts from the upper edge.
        for (v, expected) in [(0.25, high), (0.75, low)] {
            let found = albedo(bsdf, Vec2::new(0.25, v)).x;
            assert!((found / expected - 1.0).abs() < 1e-3, "{statement} {v} {found} {expected}");
        }
        assert_eq!(
            messages(&loaded),
            ["mesh.obj: no material is defined for `blue`"],
            "{statement}"
        );
    }
}

#[test]
fn what_is_missing_or_broken_is_said() {
    let missing = load(OBJ, None, "").expect("a good mesh");
    assert_eq!(missing.description.scene.objects().len(), 1);
    assert_eq!(
        messages(&missing),
        [
            "mesh.obj: the materials `red`, `blue` in `a b.mtl` are not used: no such file is beside the mesh, or it \
             does not define them"
        ]
    );
    let broken = load(OBJ, Some("newmtl red\nKd one\n"), "").map(|_| ()).expect_err("broken");
    let message = &broken.problems()[0].message;
    assert!(message.ends_with("a b.mtl:2: `Kd`: expected a number, found `one`"), "{message}");
    let lost = load(OBJ, Some("newmtl red\nmap_Kd none.png\n"), "").map(|_| ()).expect_err("lost");
    let message = &lost.problems()[0].message;
    assert!(
        message.contains("a b.mtl: material `red`: ") && message.contains("none.png"),
        "{message}"
    );
    // A material of the scene counts for all faces.
    let scene =
        load(OBJ, Some("newmtl red\nKd one\n"), "<bsdf type='diffuse'/>").expect("not read");
    assert_eq!(scene.description.scene.objects().len(), 1);
    let moving = "<animation name='to_world'><transform time='0'/><transform time='1'><translate x='1'/></transform>\
                  </animation>";
    let text = "newmtl red\nKe 1\n";
    let error = load(OBJ, Some(text), moving);
    // Without an open shutter nothing moves.
    assert!(error.is_ok());
}

/// 300 materials that differ in colour alone share what takes long to compute.
#[test]
fn plastics_of_one_roughness_are_quick() {
    let mtl: String =
        (0..300).map(|i| format!("newmtl m{i}\nKd 0.{i} 0 0\nKs 1 1 1\nNs 50\n")).collect();
    let faces: String = (0..300).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let obj = format!("mtllib a b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
    let loaded = load(&obj, Some(&mtl), "").expect("good files");
    assert_eq!(loaded.description.scene.objects().len(), 300);
}

/// Light that comes straight down and leaves towards each of these directions.
fn scattered(loaded: &Loaded, uv: Vec2) -> Vec<Rgb> {
    let scene = &loaded.description.scene;
    let bsdf = scene.bsdfs()[scene.objects()[0].bsdf].as_ref();
    // Our v counts from the upper edge of the picture, so the surface goes down with it.
    let place = Place { uv: uv.into(), dp_dv: Vec3A::NEG_Y.into(), ..Place::default() };
    let outgoing = [(0.0, 0.6), (0.0, -0.6), (0.6, 0.0), (-0.3, 0.0)];
    let unit = |(x, y): (f32, f32)| Vec3A::new(x, y, (1.0 - x * x - y * y).sqrt());
    outgoing.into_iter().map(|o| bsdf.eval(&place, Vec3A::Z, unit(o))).collect()
}

/// What a `.mtl` file says of relief is the same as what a scene file can say, and leans to the right side: the normal of
/// `normals.png` is turned towards the upper edge, and so is a surface that rises towards the lower one.
#[test]
fn reliefs_are_normals_and_heights() {
    let scale = |factor: f64| factor * 0.01 * 5.0_f64.sqrt();
    let texture = |name: &str, file: &str| {
        format!(
            "<texture type='bitmap' name='{name}'><string name='filename' value='{file}'/><boolean name='raw' value='true'/>\
             </texture>"
        )
    };
    let base = "<bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf>";
    let normals =
        |file: &str| format!("<bsdf type='normalmap'>{}{base}</bsdf>", texture("normalmap", file));
    let heights = |factor: f64| {
        let (scale, texture) = (scale(factor), texture("height", "picture.png"));
        format!("<bsdf type='bumpmap'><float name='scale' value='{scale}'/>{texture}{base}</bsdf>")
    };
    for (statement, inner) in [
        ("norm normals.png", normals("normals.png")),
        // What many programs write there.
        ("map_Bump -bm 3 ridge.png", normals("ridge.png")),
        ("map_Bump picture.png", heights(1.0)),
        ("bump -bm 10 picture.png", heights(10.0)),
        ("map_bump -bm -10 picture.png", heights(-10.0)),
        // Normals say more than heights.
        ("bump picture.png\nnorm normals.png", normals("normals.png")),
    ] {
        let mtl = format!("newmtl red\nKd .5 .5 .5\n{statement}\n");
        let ours = load(OBJ, Some(&mtl), "").expect("good files");
        let inner = format!("<bsdf type='twosided'>{inner}</bsdf>");
        let same = load(OBJ, None, &inner).unwrap_or_else(|e| panic!("{inner}: {e}"));
        // Where heights are not level and normals almost those of the upper pixels.
        let at = Vec2::new(0.25, 0.3);
        let (ours, same) = (scattered(&ours, at), scattered(&same, at));
        for (a, b) in ours.iter().zip(&same) {
            assert!((*a - *b).abs().max_element() < 1e-6, "{statement}: {ours:?} {same:?}");
        }
        let [up, down] = [ours[0].x, ours[1].x];
        let leans_up = !statement.contains("-bm -10");
        assert!(up != down && (up > down) == leans_up, "{statement}: {up} {down}");
    }
}

/// Black with holes: what is not reflected went through.
#[test]
fn holes_are_where_the_picture_says() {
    for (statements, upper, lower) in [
        ("map_d picture.png", 0.8, 0.0),
        ("d 0.5", 0.5, 0.5),
        ("Tr 0.75", 0.75, 0.75),
        ("d 0.5\nmap_d picture.png", 0.9, 0.5),
    ] {
        let mtl = format!("newmtl red\nKd 0 0 0\n{statements}\n");
        let loaded = load(OBJ, Some(&mtl), "").expect("good files");
        let scene = &loaded.description.scene;
        let bsdf = scene.bsdfs()[scene.objects()[0].bsdf].as_ref();
        for (v, expected) in [(0.25, upper), (0.75, lower)] {
            let passes = albedo(bsdf, Vec2::new(0.25, v)).x;
            assert!((passes - expected).abs() < 1e-3, "{statements} {v}: {passes}");
        }
    }
}

/// After the first plastics of a file, further ones lie between those of a grid, and no eye sees a difference: what the coat
/// lets through is off by less than one step of 8 bits.
#[test]
fn plastics_of_a_grid_are_good_enough() {
    let coat = |index: f32| Coat::new(index, 1.0, Rgb::splat(0.5), Rgb::ONE, false);
    let mut plastics = Plastics::default();
    for (index, alpha) in [(1.5, 0.2), (1.31, 0.0117), (1.03, 0.93), (2.4, 0.045)] {
        let exact = RoughPlastic::new(coat(index), Distribution::Beckmann, alpha);
        let between = plastics.between(coat(index), index, alpha);
        for i in 0..=50 {
            let cos = i as f32 / 50.0;
            let wi = Vec3A::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let [a, b] = [&exact, &between].map(|p| Bsdf::albedo(p, &Place::default(), wi).x);
            assert!((a - b).abs() < 1.0 / 255.0, "{index} {alpha} {cos}: {a} {b}");
        }
    }
}

/// More pairs of `Ns` and `Ni` than are computed one by one.
#[test]
fn a_file_may_have_any_number_of_plastics() {
    let mtl: String =
        (0..500).map(|i| format!("newmtl m{i}\nKd 0.5 0 0\nKs 1 1 1\nNs 50.{i:03}\n")).collect();
    let faces: String = (0..500).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect();
    let obj = format!("mtllib a b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}");
    let loaded = load(&obj, Some(&mtl), "").expect("good files");
    assert_eq!(loaded.description.scene.objects().len(), 500);
}
