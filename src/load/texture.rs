//! Textures of scene files.

use std::sync::Arc;

use glam::{Affine2, DAffine3, Mat2, Vec2};

use super::plugins::{Build, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};
use crate::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use crate::texture::{Bitmap, Checkerboard, Texture};

const TO_UV: PropertyInfo =
    property("to_uv", Kind::Transform, Default::Identity, "maps the texture coordinates, x and y");

pub(super) static BITMAP: Plugin = Plugin {
    name: "bitmap",
    help: "A picture: PNG, JPEG, BMP, OpenEXR or HDR. Its first row lies along v = 0.",
    properties: &[
        property("filename", Kind::File, Default::Required, "the image file"),
        property(
            "raw",
            Kind::Boolean,
            Default::Boolean(false),
            "take integers for numbers and not for colours of sRGB",
        ),
        property(
            "filter_type",
            Kind::Choice(&["bilinear", "nearest"]),
            Default::Text("bilinear"),
            "what holds between pixels",
        ),
        property(
            "wrap_mode",
            Kind::Choice(&["repeat", "mirror", "clamp"]),
            Default::Text("repeat"),
            "what holds outside of the unit square",
        ),
        TO_UV,
        property(
            "format",
            Kind::Choice(&["variant", "auto", "fp16"]),
            Default::Text("variant"),
            "read and not needed: pixels are kept in the precision of the file",
        ),
        property(
            "accel",
            Kind::Boolean,
            Default::Boolean(true),
            "read and not needed: it is for graphics cards",
        ),
    ],
    parts: &[],
    build: Build::Texture(bitmap),
};

pub(super) static CHECKERBOARD: Plugin = Plugin {
    name: "checkerboard",
    help: "Four fields to the unit square, in two colours.",
    properties: &[
        property(
            "color0",
            Kind::RgbTexture(Bounds::NotNegative),
            Default::Grey(0.4),
            "where u and v are in the same half",
        ),
        property("color1", Kind::RgbTexture(Bounds::NotNegative), Default::Grey(0.2), "elsewhere"),
        TO_UV,
    ],
    parts: &[],
    build: Build::Texture(|object| {
        let colors = [object.rgb_texture("color0")?, object.rgb_texture("color1")?];
        Ok(Arc::new(Checkerboard::new(colors, to_uv(object)?)))
    }),
};

fn bitmap(object: &Object<'_>) -> Result<Arc<dyn Texture>, Issue> {
    let image = object.image("filename")?;
    let encoding = if object.boolean("raw") { Encoding::Linear } else { Encoding::Srgb };
    let settings = BitmapSettings {
        encoding,
        filter: match object.choice("filter_type") {
            "nearest" => BitmapFilter::Nearest,
            _ => BitmapFilter::Bilinear,
        },
        wrap: match object.choice("wrap_mode") {
            "mirror" => Wrap::Mirror,
            "clamp" => Wrap::Clamp,
            _ => Wrap::Repeat,
        },
        to_uv: to_uv(object)?,
    };
    Ok(Arc::new(Bitmap::new(image, settings)))
}

/// What the map does to x and y.
fn to_uv(object: &Object<'_>) -> Result<Affine2, Issue> {
    let DAffine3 { matrix3, translation } = object.transform("to_uv");
    let axis = |v: glam::DVec3| Vec2::new(v.x as f32, v.y as f32);
    let map = Affine2::from_mat2_translation(
        Mat2::from_cols(axis(matrix3.x_axis), axis(matrix3.y_axis)),
        axis(translation),
    );
    if map.is_finite() {
        return Ok(map);
    }
    let message = "`to_uv` is larger than an f32 can hold";
    Err(Issue::new(object.place_of("to_uv"), message))
}
