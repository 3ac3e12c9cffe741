//! Materials of scene files.

use super::metals;
use super::plugins::{
    Bounds, Build, Category, Default, Kind, Part, Plugin, PropertyInfo, property,
};
use super::problem::Issue;
use super::properties::Object;
use crate::bsdf::conductor::ComplexIndex;
use crate::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, TwoSided};

const SPECULAR_REFLECTANCE: PropertyInfo = property(
    "specular_reflectance",
    Kind::Rgb(Bounds::Unit),
    Default::Grey(1.0),
    "factor for reflected light; 1 in nature",
);

pub(super) static DIFFUSE: Plugin = Plugin {
    name: "diffuse",
    help: "Ideal diffuse reflection, from the front only; also the material of shapes that have none (black if they emit).",
    properties: &[property(
        "reflectance",
        Kind::Rgb(Bounds::Unit),
        Default::Grey(0.5),
        "fraction of light that is reflected",
    )],
    parts: &[],
    build: Build::Bsdf(|object| Ok(Box::new(Diffuse::new(object.rgb("reflectance"))))),
};

pub(super) static CONDUCTOR: Plugin = Plugin {
    name: "conductor",
    help: "A smooth metal or an ideal mirror, from the front only.",
    properties: &[
        property(
            "material",
            Kind::Metal,
            Default::Text(metals::MIRROR),
            "name of a metal, such as Au",
        ),
        property(
            "eta",
            Kind::Rgb(Bounds::NotNegative),
            Default::Grey(0.0),
            "real part of the index",
        ),
        property(
            "k",
            Kind::Rgb(Bounds::NotNegative),
            Default::Grey(1.0),
            "imaginary part of the index",
        ),
        SPECULAR_REFLECTANCE,
    ],
    parts: &[],
    build: Build::Bsdf(conductor),
};

pub(super) static DIELECTRIC: Plugin = Plugin {
    name: "dielectric",
    help: "Smooth glass: reflection and refraction at the border of two substances.",
    properties: &[
        property(
            "int_ior",
            Kind::RefractiveIndex,
            Default::Text("bk7"),
            "index behind the surface",
        ),
        property("ext_ior", Kind::RefractiveIndex, Default::Text("air"), "index in front of it"),
        SPECULAR_REFLECTANCE,
        property(
            "specular_transmittance",
            Kind::Rgb(Bounds::Unit),
            Default::Grey(1.0),
            "factor for transmitted light; 1 in nature",
        ),
    ],
    parts: &[],
    build: Build::Bsdf(dielectric),
};

pub(super) static TWOSIDED: Plugin = Plugin {
    name: "twosided",
    help: "One material for both sides of a surface, or one for the front and one for the back.",
    properties: &[],
    parts: &[Part { category: Category::Bsdf, least: 1, most: 2 }],
    build: Build::Bsdf(twosided),
};

/// The material that an object describes.
///
/// # Errors
/// A combination that makes no sense.
pub(super) fn build(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    match object.plugin().build {
        Build::Bsdf(build) => build(object),
        _ => unreachable!("callers pass materials"),
    }
}

fn conductor(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    if object.has("material") {
        object.refuse(&["eta", "k"], "beside `material`")?;
    }
    let index = if object.has("eta") || object.has("k") {
        Some(ComplexIndex { eta: object.rgb("eta"), k: object.rgb("k") })
    } else {
        object.text("material").and_then(metals::find)
    };
    Ok(Box::new(Conductor::new(index, object.rgb("specular_reflectance"))))
}

fn dielectric(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    let [int_ior, ext_ior] = ["int_ior", "ext_ior"].map(|name| object.refractive_index(name));
    // Squares of a few of them, one inside the other, are still in range.
    let ratio = f64::from(int_ior) / f64::from(ext_ior);
    if !(1e-6..=1e6).contains(&ratio) {
        let ratio = ratio as f32;
        let message = format!("the index behind the surface is {ratio:e} times the one before it");
        let place = object.place_of(if object.has("int_ior") { "int_ior" } else { "ext_ior" });
        return Err(Issue::new(place, message).with_help(
            "keep the ratio between 1e-6 and 1e6: its square is a factor of the light",
        ));
    }
    Ok(Box::new(Dielectric::new(
        int_ior,
        ext_ior,
        object.rgb("specular_reflectance"),
        object.rgb("specular_transmittance"),
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
