//! Textures and the materials that hold them. Images are written to files, because files are what is read.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3A};
use image::{DynamicImage, ImageFormat};

use super::super::{LoadOptions, Loaded, load_scene};
use super::SENSOR;
use crate::bsdf::Place;
use crate::emitter::Sight;

/// Texels of a picture of 4 by 3 pixels.
const COLORS: [u8; 36] = [
    0, 1, 255, 243, 8, 36, 210, 242, 63, 79, 222, 108, 69, 211, 65, 104, 164, 140, 21, 7, 221, 192,
    214, 137, 209, 84, 115, 201, 31, 77, 31, 116, 250, 34, 98, 103,
];

/// Of 2 by 2 pixels.
const FLOATS: [f32; 12] =
    [0.03125, 0.1875, 0.0, 0.25, 0.5, 1.0, 0.0625, 0.015625, 0.125, 0.375, 0.09375, 0.0078125];

pub(super) struct Folder(tempfile::TempDir);

impl Folder {
    pub(super) fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes images in all formats.
    fn with_images() -> Self {
        let folder = Self::new();
        let save = |name: &str, picture: DynamicImage, format| {
            picture.save_with_format(folder.path(name), format).expect("writable");
        };
        let rgb8 = image::RgbImage::from_raw(4, 3, COLORS.to_vec()).expect("the right size");
        save("t8.png", rgb8.clone().into(), ImageFormat::Png);
        save("t8.bmp", rgb8.clone().into(), ImageFormat::Bmp);
        let rgba8 = DynamicImage::from(rgb8).into_rgba8();
        save("rgba.png", rgba8.into(), ImageFormat::Png);
        let wide = COLORS.map(|c| u16::from(c) * 257).to_vec();
        let rgb16 = image::ImageBuffer::from_raw(4, 3, wide).expect("the right size");
        save("t16.png", DynamicImage::ImageRgb16(rgb16), ImageFormat::Png);
        let grey = vec![0, 100, 200, 50, 150, 250];
        let grey = image::GrayImage::from_raw(3, 2, grey).expect("the right size");
        save("g8.png", grey.into(), ImageFormat::Png);
        let flat = image::RgbImage::from_pixel(16, 16, image::Rgb([200, 100, 50]));
        save("flat.jpg", flat.into(), ImageFormat::Jpeg);
        let floats = image::Rgb32FImage::from_raw(2, 2, FLOATS.to_vec()).expect("the right size");
        save("r.hdr", floats.into(), ImageFormat::Hdr);
        for (name, half) in [("h.exr", true), ("f.exr", false)] {
            write_exr(&folder.path(name), half);
        }
        folder
    }

    /// Loads a scene whose rectangle has this material.
    pub(super) fn load(&self, bsdf: &str) -> Result<Loaded, String> {
        let text = format!(
            "<scene version='3.0.0'>\n<shape type='rectangle'>{bsdf}</shape>{SENSOR}<emitter type='point'/></scene>"
        );
        self.load_text(&text)
    }

    pub(super) fn load_text(&self, text: &str) -> Result<Loaded, String> {
        fs::write(self.path("scene.xml"), text).expect("writable");
        let path = self.path("scene.xml");
        load_scene(&path, &LoadOptions::default()).map_err(|e| self.without_folder(&e.to_string()))
    }

    pub(super) fn without_folder(&self, text: &str) -> String {
        text.replace(&format!("{}/", self.0.path().display()), "")
    }
}

fn write_exr(path: &Path, half: bool) {
    use exr::prelude::*;
    let pixel = |at: Vec2<usize>| {
        let first = 3 * (2 * at.y() + at.x());
        (FLOATS[first], FLOATS[first + 1], FLOATS[first + 2])
    };
    let halves = |at| {
        let (r, g, b) = pixel(at);
        (f16::from_f32(r), f16::from_f32(g), f16::from_f32(b))
    };
    let (size, attributes) = ((2, 2), LayerAttributes::default());
    if half {
        let channels = SpecificChannels::rgb(halves);
        let layer = Layer::new(size, attributes, Encoding::FAST_LOSSLESS, channels);
        Image::from_layer(layer).write().to_file(path).expect("writable");
    } else {
        let channels = SpecificChannels::rgb(pixel);
        let layer = Layer::new(size, attributes, Encoding::FAST_LOSSLESS, channels);
        Image::from_layer(layer).write().to_file(path).expect("writable");
    }
}

pub(super) fn bitmap(file: &str, more: &str) -> String {
    format!(
        "<bsdf type='diffuse'><texture name='reflectance' type='bitmap'>\
         <string name='filename' value='{file}'/>{more}</texture></bsdf>"
    )
}

/// The albedo at texture coordinates.
pub(super) fn albedo(loaded: &Loaded, u: f32, v: f32) -> Vec3A {
    let scene = &loaded.description.scene;
    let place = Place { uv: Vec2::new(u, v).into(), ..Place::default() };
    scene.bsdfs()[scene.objects()[0].bsdf].albedo(&place, Vec3A::Z)
}

const RAW: &str = "<boolean name='raw' value='true'/>";
/// How Mitsuba shall store pixels, which is of no matter here.
const STORAGE: &str = "<string name='format' value='auto'/><boolean name='accel' value='false'/>";
const NEAREST: &str =
    "<boolean name='raw' value='true'/><string name='filter_type' value='nearest'/>";
const MIRROR: &str = "<boolean name='raw' value='true'/><string name='wrap_mode' value='mirror'/>";
const CLAMP: &str = "<boolean name='raw' value='true'/><string name='wrap_mode' value='clamp'/>";

/// `eval` of Mitsuba 3.9.1 (`scalar_rgb`) for the same files. It keeps integers as halves, so its values are
/// rounded to 2⁻¹² of themselves.
#[test]
fn bitmaps_are_those_of_mitsuba() {
    let folder = Folder::with_images();
    for (file, more, u, v, expected) in [
        ("t8.png", "", 0.1, 0.1, [0.121_342, 0.077_056, 0.765_569]),
        ("t8.png", "", -0.3, 1.4, [0.256_746, 0.394_46, 0.430_765]),
        ("t8.png", STORAGE, 0.1, 0.1, [0.121_342, 0.077_056, 0.765_569]),
        ("t8.bmp", "", 0.1, 0.1, [0.121_342, 0.077_056, 0.765_569]),
        ("rgba.png", "", 0.9, 0.95, [0.075_431, 0.307_32, 0.172_727]),
        ("t8.png", RAW, 0.1, 0.1, [0.174_98, 0.139_451, 0.843_137]),
        ("t8.png", RAW, 0.5, 0.5, [0.245_098, 0.335_294, 0.707_843]),
        ("t8.png", RAW, 2.6, -1.2, [0.180_902, 0.388_314, 0.904_784]),
        ("t8.png", NEAREST, 0.5, 0.5, [0.082_353, 0.027_451, 0.866_667]),
        ("t8.png", NEAREST, 0.9, 0.95, [0.133_333, 0.384_314, 0.403_922]),
        ("t8.png", NEAREST, 2.6, -1.2, [0.121_569, 0.454_902, 0.980_392]),
        ("t8.png", MIRROR, 0.1, 0.1, [0.0, 0.003_922, 1.0]),
        ("t8.png", MIRROR, -0.3, 1.4, [0.495_961, 0.544_078, 0.426_549]),
        ("t8.png", CLAMP, -0.3, 1.4, [0.819_608, 0.329_412, 0.450_98]),
        ("t8.png", CLAMP, 2.6, -1.2, [0.309_804, 0.870_588, 0.423_529]),
        ("t16.png", "", 0.1, 0.1, [0.121_36, 0.077_062, 0.765_554]),
        ("t16.png", "", 0.5, 0.5, [0.072_964, 0.186_731, 0.492_676]),
        ("g8.png", "", 0.1, 0.1, [0.145_875; 3]),
        ("g8.png", "", 0.9, 0.95, [0.647_521; 3]),
        ("h.exr", "", 0.1, 0.1, [0.114_688, 0.208_594, 0.236_953]),
        ("h.exr", RAW, -0.3, 1.4, [0.262_813, 0.353_906, 0.635_86]),
        ("f.exr", "", 0.9, 0.95, [0.242_5, 0.204_688, 0.305_781]),
        ("r.hdr", "", 2.6, -1.2, [0.271_563, 0.103_906, 0.108_672]),
    ] {
        let loaded = folder.load(&bitmap(file, more)).expect("valid");
        let (found, expected) = (albedo(&loaded, u, v), Vec3A::from(expected));
        let off = (found - expected).abs() / expected.max(Vec3A::splat(1e-3));
        assert!(off.max_element() < 5e-4, "{file} {more} ({u}, {v}): {found}, not {expected}");
    }
    // JPEG rounds colours to other colours.
    let loaded = folder.load(&bitmap("flat.jpg", RAW)).expect("valid");
    let expected = Vec3A::new(200.0, 100.0, 50.0) / 255.0;
    assert!((albedo(&loaded, 0.3, 0.6) - expected).length() < 4.0 / 255.0);
}

/// Only x and y of the map count, as in Mitsuba.
#[test]
fn texture_coordinates_are_mapped() {
    let folder = Folder::with_images();
    let plain = folder.load(&bitmap("t8.png", RAW)).expect("valid");
    for (steps, [u, v]) in [
        ("<translate x='0.1' y='0.2' z='5'/>", [0.4, 0.6]),
        ("<scale x='2' y='3'/><translate x='0.1'/>", [0.7, 1.2]),
        ("<matrix value='1 2 3 4 5 6 7 8 0 0 1 0 0 0 0 1'/>", [5.1, 11.9]),
        ("<rotate z='1' angle='90'/>", [-0.4, 0.3]),
    ] {
        let more = format!("{RAW}<transform name='to_uv'>{steps}</transform>");
        let mapped = folder.load(&bitmap("t8.png", &more)).expect("valid");
        let off = (albedo(&mapped, 0.3, 0.4) - albedo(&plain, u, v)).length();
        assert!(off < 1e-5, "{steps}");
    }
}

#[test]
fn old_offsets_and_scales_become_a_map() {
    let folder = Folder::with_images();
    let plain = folder.load(&bitmap("t8.png", RAW)).expect("valid");
    let old = bitmap(
        "t8.png",
        &format!(
            "{RAW}<float name='uscale' value='2'/><float name='voffset' value='0.25'/>\
             <string name='filterType' value='bilinear'/><string name='wrapMode' value='repeat'/>"
        ),
    );
    let text =
        format!("<scene version='0.6.0'>\n<shape type='rectangle'>{old}</shape>{SENSOR}</scene>");
    let loaded = folder.load_text(&text).expect("valid");
    assert!((albedo(&loaded, 0.3, 0.4) - albedo(&plain, 0.6, 0.65)).length() < 1e-6);
}

/// However often a file is named and a texture referred to.
/// Filters over many pixels and gammas, which version 3 does not have.
#[test]
fn old_bitmaps_become_new_ones() {
    let folder = Folder::with_images();
    let value = |version: &str, more: &str| {
        let text = format!(
            "<scene version='{version}'><shape type='rectangle'>{}</shape>{SENSOR}</scene>",
            bitmap("t8.png", more)
        );
        albedo(&folder.load_text(&text).expect("valid"), 0.1, 0.1)
    };
    for (old, new) in [
        ("<string name='filterType' value='trilinear'/>", ""),
        ("<string name='filterType' value='ewa'/><float name='gamma' value='-1'/>", ""),
        ("<float name='gamma' value='1'/>", RAW),
        ("<float name='gamma' value='1.0'/><string name='filterType' value='nearest'/>", NEAREST),
    ] {
        assert_eq!(value("0.5.0", old), value("3.0.0", new), "{old}");
    }
}

#[test]
fn images_are_shared() {
    let folder = Folder::with_images();
    let inner = "<string name='filename' value='t8.png'/>";
    let text = format!(
        "<scene version='3.0.0'><texture type='bitmap' id='a'>{inner}</texture>\
         <shape type='rectangle'><bsdf type='plastic'><ref name='diffuse_reflectance' id='a'/>\
         <texture type='bitmap' name='specular_reflectance'>{inner}{RAW}</texture></bsdf></shape>\
         <shape type='disk'><bsdf type='mask'><ref name='opacity' id='a'/>\
         <bsdf type='diffuse'><ref name='reflectance' id='a'/></bsdf></bsdf></shape>{SENSOR}</scene>"
    );
    let loaded = folder.load_text(&text).expect("valid");
    // What is shared would be counted by its owners; it can be seen from here only as the same texels.
    let scene = &loaded.description.scene;
    let needs: Vec<_> = scene.bsdfs().iter().map(|b| b.flags().needs).collect();
    assert_eq!(needs, [crate::bsdf::Needs::TextureCoordinates; 2]);
}

#[test]
fn numbers_come_from_textures_and_colours() {
    let folder = Folder::with_images();
    let mask = |opacity: &str| {
        folder.load(&format!("<bsdf type='mask'>{opacity}<bsdf type='diffuse'/></bsdf>"))
    };
    // A half of what is opaque is reflected, the rest passes.
    let opacity = |opacity: &str| 2.0 * (1.0 - albedo(&mask(opacity).expect("valid"), 0.1, 0.1).x);
    let bitmap = "<texture name='opacity' type='bitmap'><string name='filename' value='t8.png'/>";
    // `eval_1` of Mitsuba 3.9.1: the luminance of the colour.
    assert!((opacity(&format!("{bitmap}</texture>")) - 0.136_164).abs() < 1e-4);
    // The mean of the channels.
    assert!((opacity("<rgb name='opacity' value='.1 .5 .9'/>") - 0.5).abs() < 1e-6);
    assert!((opacity("<spectrum name='opacity' value='.25'/>") - 0.25).abs() < 1e-6);
}

fn environment(file: &str, more: &str) -> String {
    format!(
        "<scene version='3.0.0'>\n<emitter type='envmap'><string name='filename' value='{file}'/>\
         {more}</emitter>{SENSOR}</scene>"
    )
}

/// `eval` of Mitsuba 3.9.1 (`scalar_rgb`) for the same file.
#[test]
fn environments_are_those_of_mitsuba() {
    let folder = Folder::with_images();
    let turned = "<transform name='to_world'><rotate y='1' angle='40'/><rotate x='1' angle='30'/>\
                  <translate x='5'/></transform>";
    let mirrored = "<transform name='to_world'><scale x='-1'/></transform>";
    let [a, b, c] = [[0.0, 0.8, -0.6], [0.6, 0.0, 0.8], [-0.48, -0.6, 0.64]];
    for (more, direction, expected) in [
        ("", a, [0.286_477, 0.973_731, 0.802_997]),
        ("", b, [0.253_208, 0.675_788, 0.607_754]),
        ("", c, [0.076_261, 0.173_058, 1.522_537]),
        (turned, a, [0.129_270, 0.990_731, 0.584_568]),
        (turned, b, [0.514_573, 0.509_606, 0.737_901]),
        (turned, c, [0.261_754, 0.360_831, 1.225_981]),
        (mirrored, a, [0.286_477, 0.973_731, 0.802_997]),
        (mirrored, b, [0.038_654, 0.070_937, 1.362_857]),
        (mirrored, c, [0.585_815, 0.422_08, 0.484_846]),
    ] {
        let more = format!("<float name='scale' value='2'/>{more}");
        let loaded = folder.load_text(&environment("t8.png", &more)).expect("valid");
        let (_, sky) = loaded.description.scene.environment().expect("there is one");
        let from = glam::DVec3::ZERO;
        let found = sky.radiance(&Sight { from, direction: direction.into(), surface: None });
        let off = (found - Vec3A::from(expected)).abs().max_element();
        // Mitsuba's angles are f32, whose error is stretched by the slope of the picture.
        assert!(off < 5e-6, "{more} {direction:?}: {found}, not {expected:?}");
    }
}

#[test]
fn wrong_environments_are_errors() {
    let folder = Folder::with_images();
    let bright = folder.path("bright.exr");
    exr::prelude::write_rgb_file(&bright, 1, 1, |_, _| (8.0f32, 8.0f32, 8.0f32)).expect("writable");
    let error = |file: &str, more: &str| {
        folder.load_text(&environment(file, more)).map(|_| ()).expect_err("wrong")
    };
    assert_eq!(
        error("t8.png", "<transform name='to_world'><scale value='2'/></transform>"),
        "scene.xml:2:64: `to_world` stretches directions (expected that it turns or mirrors them)"
    );
    assert_eq!(
        error("bright.exr", "<float name='scale' value='1e38'/>"),
        "scene.xml:2:95: `scale` makes more of a pixel than an f32 can hold"
    );
    assert_eq!(
        error("none.exr", ""),
        format!(
            "scene.xml:2:55: there is no file `none.exr`\n  help: looked in `{}`",
            folder.0.path().display()
        )
    );
    let path = folder.path("negative.exr");
    exr::prelude::write_rgb_file(&path, 1, 1, |_, _| (1.0f32, -2.0f32, 3.0f32)).expect("writable");
    let loaded = folder.load_text(&environment("negative.exr", "")).expect("valid");
    let warnings: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings.iter().map(|w| folder.without_folder(w)).collect::<Vec<_>>(),
        ["scene.xml:2:55: there are pixels below 0, which count as 0"]
    );
}

#[test]
fn wrong_textures_are_errors() {
    let folder = Folder::with_images();
    fs::write(folder.path("text.png"), "no picture").expect("writable");
    let png = fs::read(folder.path("t8.png")).expect("is there");
    fs::write(folder.path("cut.png"), &png[..60]).expect("writable");
    let bump =
        |texture: &str| format!("<bsdf type='bumpmap'>{texture}<bsdf type='diffuse'/></bsdf>");
    for (bsdf, expected) in [
        (
            bitmap("none.png", ""),
            format!(
                "scene.xml:2:119: there is no file `none.png`\n  help: looked in `{}`",
                folder.0.path().display()
            ),
        ),
        (
            bitmap("text.png", ""),
            "scene.xml:2:119: text.png is no image in a known format (expected PNG, JPEG, BMP, OpenEXR or HDR)"
                .to_owned(),
        ),
        (
            bump("<texture type='checkerboard'/>"),
            "scene.xml:2:46: texture `checkerboard` has no slopes (expected `bitmap`)".to_owned(),
        ),
        (bump(""), "scene.xml:2:25: bsdf `bumpmap` needs a texture inside it".to_owned()),
        (
            "<bsdf type='roughplastic'><texture type='checkerboard' name='alpha'/></bsdf>".into(),
            "scene.xml:2:51: `alpha` is a texture (expected: float of 0 or above)".to_owned(),
        ),
        (
            "<bsdf type='diffuse'><texture type='checkerboard'/></bsdf>".into(),
            "scene.xml:2:46: bsdf `diffuse`: a texture inside it needs a `name`\n  \
             help: textures can be `reflectance`"
                .to_owned(),
        ),
        (
            "<bsdf type='diffuse'><texture type='checkerboard' name='reflect'/></bsdf>".into(),
            "scene.xml:2:46: bsdf `diffuse`: unexpected property `reflect`\n  \
             help: textures can be `reflectance`"
                .to_owned(),
        ),
        (
            "<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'/>\
             <float name='reflectance' value='1'/></bsdf>"
                .into(),
            "scene.xml:2:46: `reflectance` is given more than once".to_owned(),
        ),
    ] {
        assert_eq!(folder.load(&bsdf).map(|_| ()), Err(expected), "{bsdf}");
    }
    let cut = folder.load(&bitmap("cut.png", "")).map(|_| ()).expect_err("half a file");
    assert!(cut.starts_with("scene.xml:2:119: cut.png cannot be decoded: "), "{cut}");
}

#[test]
fn what_is_changed_is_said() {
    let folder = Folder::new();
    let warnings = |bsdf: &str| {
        let loaded = folder.load(bsdf).expect("valid");
        let warnings: Vec<_> =
            loaded.warnings.iter().map(|w| folder.without_folder(&w.to_string())).collect();
        warnings
    };
    assert_eq!(
        warnings("<bsdf type='roughconductor'><float name='alpha' value='1e-5'/></bsdf>"),
        ["scene.xml:2:80: `alpha` is raised to 0.0001, the least roughness there is"]
    );
    assert_eq!(
        warnings("<bsdf type='roughplastic'><boolean name='sample_visible' value='false'/></bsdf>"),
        ["scene.xml:2:89: visible normals are sampled all the same: the picture has less noise"]
    );
    assert!(warnings("<bsdf type='roughplastic'/>").is_empty());
}
