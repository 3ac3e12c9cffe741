//! Objects that many refer to are built once: what follows would take years otherwise.

use super::{SENSOR, load};
use crate::bsdf::Needs;
use crate::texture::Texture;

/// More than can be followed one by one, and few enough to be no error.
const DEEP: usize = 60;

fn scene(content: &str) -> String {
    format!("<scene version='3.0.0'>{content}<emitter type='constant'/>{SENSOR}</scene>")
}

fn chain(length: usize, link: impl Fn(usize) -> String) -> String {
    (1..=length).map(link).collect()
}

#[test]
fn materials_of_materials() {
    let blends = chain(DEEP, |i| {
        let inner = format!("<ref id='b{0}'/><ref id='b{0}'/>", i - 1);
        format!("<bsdf type='blendbsdf' id='b{i}'><float name='weight' value='.5'/>{inner}</bsdf>")
    });
    // Two levels for each.
    const HALF: usize = DEEP / 2;
    let mixed = chain(HALF, |i| {
        let inner = format!("<ref id='m{0}'/><bsdf type='mask'><ref id='m{0}'/></bsdf>", i - 1);
        format!("<bsdf type='blendbsdf' id='m{i}'><float name='weight' value='.5'/>{inner}</bsdf>")
    });
    let loaded = load(&scene(&format!(
        "<bsdf type='diffuse' id='b0'><texture type='checkerboard' name='reflectance'/></bsdf>{blends}\
         <bsdf type='diffuse' id='m0'/>{mixed}\
         <shape type='disk'><ref id='b{DEEP}'/></shape><shape type='disk'><ref id='m{HALF}'/></shape>"
    )))
    .expect("valid");
    let scene = &loaded.description.scene;
    let flags = |object: usize| scene.bsdfs()[scene.objects()[object].bsdf].flags();
    assert_eq!(flags(0).needs, Needs::TextureCoordinates);
    assert!(!flags(0).transmits && flags(1).transmits);
    let warnings: Vec<_> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
    let warning = |id: &str, count: u64| {
        format!(
            "material `{id}` asks others {count} times at each point: a render will take as long"
        )
    };
    assert_eq!(
        warnings,
        [warning(&format!("b{DEEP}"), 1 << DEEP), warning(&format!("m{HALF}"), 1 << HALF)]
    );
}

/// What decides about shading normals is known of shared materials too, and found in time.
#[test]
fn interfaces_of_shared_materials() {
    let blends = chain(DEEP, |i| {
        let inner = format!("<ref id='b{0}'/><ref id='b{0}'/>", i - 1);
        format!("<bsdf type='blendbsdf' id='b{i}'><float name='weight' value='.5'/>{inner}</bsdf>")
    });
    let indices = "<float name='int_ior' value='1.5'/><float name='ext_ior' value='1'/>";
    let loaded = load(&scene(&format!(
        "<bsdf type='dielectric' id='b0'>{indices}</bsdf>{blends}\
         <bsdf type='mask' id='m'><ref id='b0'/></bsdf>\
         <shape type='disk'><ref id='b{DEEP}'/></shape><shape type='disk'><ref id='m'/></shape>"
    )))
    .expect("valid");
    let scene = &loaded.description.scene;
    for object in scene.objects() {
        assert_eq!(scene.bsdfs()[object.bsdf].interface(), Some(1.5));
    }
}

#[test]
fn textures_of_textures() {
    let boards = chain(DEEP, |i| {
        let inner = format!("<ref name='color0' id='t{0}'/><ref name='color1' id='t{0}'/>", i - 1);
        format!("<texture type='checkerboard' id='t{i}'>{inner}</texture>")
    });
    // Plastic asks for the mean, and 1.5 is clamped.
    for value in ["0.75", "1.5"] {
        let loaded = load(&scene(&format!(
            "<texture type='checkerboard' id='t0'><rgb name='color0' value='{value}'/></texture>{boards}\
             <shape type='disk'><bsdf type='plastic'><ref name='diffuse_reflectance' id='t{DEEP}'/></bsdf></shape>"
        )))
        .expect("valid");
        assert_eq!(loaded.warnings.len(), usize::from(value == "1.5"), "{:?}", loaded.warnings);
    }
}

/// Neither the file nor the stack is what such a scene is to be measured by.
#[test]
fn chains_of_references_have_an_end() {
    for (link, end) in [
        (
            "<bsdf type='mask' id='xI'><ref id='xJ'/></bsdf>",
            "<bsdf type='diffuse' id='x0'/><shape type='disk'><ref id='xN'/></shape>",
        ),
        (
            "<texture type='checkerboard' id='xI'><ref name='color0' id='xJ'/></texture>",
            "<texture type='checkerboard' id='x0'/><shape type='disk'><bsdf type='diffuse'>\
             <ref name='reflectance' id='xN'/></bsdf></shape>",
        ),
    ] {
        let text = |length: usize| {
            let links = chain(length, |i| {
                link.replace("xI", &format!("x{i}")).replace("xJ", &format!("x{}", i - 1))
            });
            scene(&(links + &end.replace("xN", &format!("x{length}"))))
        };
        assert!(load(&text(90)).is_ok());
        let error = load(&text(10_000)).map(|_| ()).expect_err("too deep").to_string();
        assert!(error.contains("objects are inside each other more than 100 deep"), "{error}");
    }
}

/// A large board's values stay within what they were clamped to.
#[test]
fn clamped_boards_are_clamped() {
    use crate::math::Rgb;
    use crate::texture::{Checkerboard, Textured};
    let grey = |v| Textured::Uniform(Rgb::splat(v));
    let board = Checkerboard::new([grey(1.5), grey(0.25)], glam::Affine2::IDENTITY);
    let clamped = board.clamped([0.0, 1.0]);
    assert_eq!((board.range(), clamped.range()), ([0.25, 1.5], [0.25, 1.0]));
    let at = glam::Vec2::splat(0.25);
    assert_eq!((clamped.rgb(at), clamped.scalar(at)), (Rgb::ONE, 0.25));
}
