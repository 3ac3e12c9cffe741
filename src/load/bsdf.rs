//! Materials of scene files.

use std::collections::HashMap;

use super::metals;
use super::plugins::{Build, Category, Part, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::bsdf::conductor::{ComplexIndex, Metal};
use crate::bsdf::perturbed::{Normals, PerturbedOptions};
use crate::bsdf::plastic::Coat;
use crate::bsdf::{
    Blend, Bsdf, Conductor, Dielectric, Diffuse, Mask, Null, Perturbed, Plastic, ThinDielectric,
    TwoSided,
};
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};

pub(super) const SPECULAR_REFLECTANCE: PropertyInfo = property(
    "specular_reflectance",
    Kind::RgbTexture(Bounds::Unit),
    Default::Grey(1.0),
    "factor for reflected light; 1 in nature",
);

pub(super) const SPECULAR_TRANSMITTANCE: PropertyInfo = property(
    "specular_transmittance",
    Kind::RgbTexture(Bounds::Unit),
    Default::Grey(1.0),
    "factor for transmitted light; 1 in nature",
);

pub(super) const MATERIAL: PropertyInfo =
    property("material", Kind::Metal, Default::Text(metals::MIRROR), "name of a metal, such as Au");

pub(super) const ETA: PropertyInfo = property(
    "eta",
    Kind::RgbTexture(Bounds::NotNegative),
    Default::Grey(0.0),
    "real part of the index",
);

pub(super) const K: PropertyInfo = property(
    "k",
    Kind::RgbTexture(Bounds::NotNegative),
    Default::Grey(1.0),
    "imaginary part of the index",
);

/// The index behind the surface, and that of the substance if none is given.
pub(super) const fn int_ior(substance: &'static str) -> PropertyInfo {
    let default = Default::Text(substance);
    property("int_ior", Kind::RefractiveIndex, default, "index behind the surface")
}

pub(super) const EXT_IOR: PropertyInfo =
    property("ext_ior", Kind::RefractiveIndex, Default::Text("air"), "index in front of it");

pub(super) const DIFFUSE_REFLECTANCE: PropertyInfo = property(
    "diffuse_reflectance",
    Kind::RgbTexture(Bounds::Unit),
    Default::Grey(0.5),
    "fraction of light that the base reflects",
);

pub(super) const NONLINEAR: PropertyInfo = property(
    "nonlinear",
    Kind::Boolean,
    Default::Boolean(false),
    "saturate colours each time that light is thrown back to the base",
);

pub(super) static DIFFUSE: Plugin = Plugin {
    name: "diffuse",
    help: "Ideal diffuse reflection, from the front only; also the material of shapes that have none (black if they emit).",
    properties: &[property(
        "reflectance",
        Kind::RgbTexture(Bounds::Unit),
        Default::Grey(0.5),
        "fraction of light that is reflected",
    )],
    parts: &[],
    build: Build::Bsdf(|object| Ok(Box::new(Diffuse::new(object.rgb_texture("reflectance")?)))),
};

pub(super) static CONDUCTOR: Plugin = Plugin {
    name: "conductor",
    help: "A smooth metal or an ideal mirror, from the front only.",
    properties: &[MATERIAL, ETA, K, SPECULAR_REFLECTANCE],
    parts: &[],
    build: Build::Bsdf(|object| Ok(Box::new(Conductor::new(metal(object)?)))),
};

pub(super) static DIELECTRIC: Plugin = Plugin {
    name: "dielectric",
    help: "Smooth glass: reflection and refraction at the border of two substances.",
    properties: &[int_ior("bk7"), EXT_IOR, SPECULAR_REFLECTANCE, SPECULAR_TRANSMITTANCE],
    parts: &[],
    build: Build::Bsdf(dielectric),
};

pub(super) static THIN_DIELECTRIC: Plugin = Plugin {
    name: "thindielectric",
    help: "A pane of glass, both faces at once: light is reflected or goes straight on.",
    properties: &[int_ior("bk7"), EXT_IOR, SPECULAR_REFLECTANCE, SPECULAR_TRANSMITTANCE],
    parts: &[],
    build: Build::Bsdf(thin_dielectric),
};

pub(super) static PLASTIC: Plugin = Plugin {
    name: "plastic",
    help: "A diffuse base under a smooth coat, from the front only.",
    properties: &[
        int_ior("polypropylene"),
        EXT_IOR,
        DIFFUSE_REFLECTANCE,
        SPECULAR_REFLECTANCE,
        NONLINEAR,
    ],
    parts: &[],
    build: Build::Bsdf(|object| Ok(Box::new(Plastic::new(coat(object)?)))),
};

pub(super) static NULL: Plugin = Plugin {
    name: "null",
    help: "No surface at all; shadow rays are stopped all the same.",
    properties: &[],
    parts: &[],
    build: Build::Bsdf(|_| Ok(Box::new(Null))),
};

pub(super) static MASK: Plugin = Plugin {
    name: "mask",
    help: "A material with holes; shadow rays do not pass through them, paths do.",
    properties: &[property(
        "opacity",
        Kind::FloatTexture(Bounds::Unit),
        Default::Float(0.5),
        "fraction of the material",
    )],
    parts: &[Part { category: Category::Bsdf, least: 1, most: 1 }],
    build: Build::Bsdf(|object| {
        let [material] = nested(object)?;
        Ok(Box::new(Mask::new(object.float_texture("opacity")?, material)))
    }),
};

pub(super) static BLEND: Plugin = Plugin {
    name: "blendbsdf",
    help: "A mixture of two materials.",
    properties: &[property(
        "weight",
        Kind::FloatTexture(Bounds::Unit),
        Default::Required,
        "fraction of the second material",
    )],
    parts: &[Part { category: Category::Bsdf, least: 2, most: 2 }],
    build: Build::Bsdf(|object| {
        Ok(Box::new(Blend::new(object.float_texture("weight")?, nested(object)?)))
    }),
};

const FLIP_INVALID_NORMALS: PropertyInfo = property(
    "flip_invalid_normals",
    Kind::Boolean,
    Default::Boolean(true),
    "turn round normals that are seen from behind, and bend those that would mirror or refract light to the wrong side",
);

const USE_SHADOWING_FUNCTION: PropertyInfo = property(
    "use_shadowing_function",
    Kind::Boolean,
    Default::Boolean(true),
    "darken what leaves at flat angles, except by smooth interfaces, instead of cutting it off",
);

pub(super) static BUMP_MAP: Plugin = Plugin {
    name: "bumpmap",
    help: "A material on a relief, whose heights are the values of a bitmap.",
    properties: &[
        property("scale", Kind::Float(Bounds::Any), Default::Float(1.0), "factor for the heights"),
        FLIP_INVALID_NORMALS,
        USE_SHADOWING_FUNCTION,
    ],
    parts: &[
        Part { category: Category::Texture, least: 1, most: 1 },
        Part { category: Category::Bsdf, least: 1, most: 1 },
    ],
    build: Build::Bsdf(bump_map),
};

pub(super) static NORMAL_MAP: Plugin = Plugin {
    name: "normalmap",
    help: "A material whose normals are given by a texture: (n + 1)/2 for the normal n.",
    properties: &[
        property(
            "normalmap",
            Kind::RgbTexture(Bounds::Unit),
            Default::Required,
            "the normals; bitmaps want `raw`",
        ),
        FLIP_INVALID_NORMALS,
        USE_SHADOWING_FUNCTION,
    ],
    parts: &[Part { category: Category::Bsdf, least: 1, most: 1 }],
    build: Build::Bsdf(|object| {
        let [material] = nested(object)?;
        let normals = Normals::Map(object.rgb_texture("normalmap")?);
        Ok(Box::new(Perturbed::new(normals, perturbed_options(object), material)))
    }),
};

pub(super) static TWOSIDED: Plugin = Plugin {
    name: "twosided",
    help: "One material for both sides of a surface, or one for the front and one for the back.",
    properties: &[],
    parts: &[Part { category: Category::Bsdf, least: 1, most: 2 }],
    build: Build::Bsdf(twosided),
};

/// The material that an object describes; built once, however many others it is part of.
///
/// # Errors
/// A combination that makes no sense.
pub(super) fn build(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    let Build::Bsdf(build) = object.plugin().build else { unreachable!("callers pass materials") };
    if !object.is_shared() {
        return build(object);
    }
    object.shared_material(build).map(|material| Box::new(material) as Box<dyn Bsdf>)
}

/// How many materials that hold no others are asked for a value at a point of this one.
pub(super) fn evaluations(object: &Object<'_>, known: &mut HashMap<usize, u64>) -> u64 {
    if let Some(&count) = object.index().and_then(|index| known.get(&index)) {
        return count;
    }
    let inner: Vec<_> = object.parts(Category::Bsdf).collect();
    let counts = inner.iter().map(|part| evaluations(part, known));
    // A two-sided one asks that of one side.
    let count = if std::ptr::eq(object.plugin(), &raw const TWOSIDED) {
        counts.fold(1, u64::max)
    } else {
        counts.fold(0, u64::saturating_add).max(1)
    };
    known.extend(object.index().map(|index| (index, count)));
    count
}

/// The metal of a conductor.
pub(super) fn metal(object: &Object<'_>) -> Result<Metal, Issue> {
    if object.has("material") {
        object.refuse(&["eta", "k"], "beside `material`")?;
    }
    let index = if object.has("eta") || object.has("k") {
        Some((object.rgb_texture("eta")?, object.rgb_texture("k")?))
    } else {
        let known = object.text("material").and_then(metals::find);
        known.map(|ComplexIndex { eta, k }| (eta.into(), k.into()))
    };
    Ok(Metal::new(index, object.rgb_texture("specular_reflectance")?))
}

/// The coat of plastic, and what is under it.
pub(super) fn coat(object: &Object<'_>) -> Result<Coat, Issue> {
    let [int_ior, ext_ior] = indices(object)?;
    Ok(Coat::new(
        int_ior,
        ext_ior,
        object.rgb_texture("diffuse_reflectance")?,
        object.rgb_texture("specular_reflectance")?,
        object.boolean("nonlinear"),
    ))
}

/// The materials inside one that takes so many.
fn nested<const COUNT: usize>(object: &Object<'_>) -> Result<[Box<dyn Bsdf>; COUNT], Issue> {
    let parts = object.parts(Category::Bsdf).map(|p| build(&p));
    let materials = parts.collect::<Result<Vec<_>, _>>()?;
    Ok(materials.try_into().expect("the table says how many"))
}

fn perturbed_options(object: &Object<'_>) -> PerturbedOptions {
    PerturbedOptions {
        flip_invalid_normals: object.boolean("flip_invalid_normals"),
        use_shadowing_function: object.boolean("use_shadowing_function"),
    }
}

fn bump_map(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    let texture = object.parts(Category::Texture).next().expect("the table says how many");
    if texture.plugin().name != "bitmap" {
        let name = texture.plugin().name;
        let message = format!("texture `{name}` has no slopes (expected `bitmap`)");
        return Err(Issue::new(texture.place(), message));
    }
    let normals = Normals::Bump { height: texture.texture()?, scale: object.float("scale") as f32 };
    let [material] = nested(object)?;
    Ok(Box::new(Perturbed::new(normals, perturbed_options(object), material)))
}

/// The indices behind the surface and in front of it.
///
/// # Errors
/// A ratio whose square leaves the range of f32 sooner or later.
pub(super) fn indices(object: &Object<'_>) -> Result<[f32; 2], Issue> {
    let [int_ior, ext_ior] = ["int_ior", "ext_ior"].map(|name| object.refractive_index(name));
    // Squares of a few of them, one inside the other, are still in range.
    let ratio = f64::from(int_ior) / f64::from(ext_ior);
    if (1e-6..=1e6).contains(&ratio) {
        return Ok([int_ior, ext_ior]);
    }
    let ratio = ratio as f32;
    let message = format!("the index behind the surface is {ratio:e} times the one before it");
    let place = object.place_of(if object.has("int_ior") { "int_ior" } else { "ext_ior" });
    Err(Issue::new(place, message)
        .with_help("keep the ratio between 1e-6 and 1e6: its square is a factor of the light"))
}

fn dielectric(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    let [int_ior, ext_ior] = indices(object)?;
    Ok(Box::new(Dielectric::new(
        int_ior,
        ext_ior,
        object.rgb_texture("specular_reflectance")?,
        object.rgb_texture("specular_transmittance")?,
    )))
}

fn thin_dielectric(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    let [int_ior, ext_ior] = indices(object)?;
    Ok(Box::new(ThinDielectric::new(
        int_ior,
        ext_ior,
        object.rgb_texture("specular_reflectance")?,
        object.rgb_texture("specular_transmittance")?,
    )))
}

fn twosided(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    let parts = || object.parts(Category::Bsdf);
    if parts().any(|p| std::ptr::eq(p.plugin(), &raw const TWOSIDED)) {
        let message =
            "bsdf `twosided` inside bsdf `twosided` changes nothing (expected one-sided materials)";
        return Err(Issue::new(object.place(), message));
    }
    let mut materials = parts().map(|p| build(&p)).collect::<Result<Vec<_>, _>>()?.into_iter();
    let sides = (materials.next(), materials.next());
    let both = sides.0.and_then(|front| TwoSided::new(front, sides.1));
    let both = both.ok_or_else(|| {
        let message = "bsdf `twosided` takes materials that only reflect: light that passes through one \
                       would meet the other";
        Issue::new(object.place(), message)
    })?;
    Ok(Box::new(both))
}
