//! Rough materials of scene files.

use super::bsdf::{
    DIFFUSE_REFLECTANCE, ETA, EXT_IOR, K, MATERIAL, NONLINEAR, SPECULAR_REFLECTANCE,
    SPECULAR_TRANSMITTANCE, coat, indices, int_ior, metal,
};
use super::plugins::{Build, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::bsdf::microfacet::{Distribution, LEAST_ALPHA, Roughness};
use crate::bsdf::{Bsdf, RoughConductor, RoughDielectric, RoughPlastic};
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};
use crate::texture::Textured;

const DISTRIBUTION: PropertyInfo = property(
    "distribution",
    Kind::Choice(&["beckmann", "ggx"]),
    Default::Text("beckmann"),
    "of the normals of microfacets",
);

/// Roughness that may vary.
const ALPHA: PropertyInfo = property(
    "alpha",
    Kind::FloatTexture(Bounds::NotNegative),
    Default::Float(0.1),
    "roughness: \u{221a}2 times the root mean square slope",
);

const ALPHA_U: PropertyInfo = property(
    "alpha_u",
    Kind::FloatTexture(Bounds::NotNegative),
    Default::Absent("`alpha`"),
    "roughness along the first texture coordinate",
);

const ALPHA_V: PropertyInfo = property(
    "alpha_v",
    Kind::FloatTexture(Bounds::NotNegative),
    Default::Absent("`alpha`"),
    "roughness across",
);

const SAMPLE_VISIBLE: PropertyInfo = property(
    "sample_visible",
    Kind::Boolean,
    Default::Boolean(true),
    "choose among the normals that are seen; the picture is the same without, and so it is always done",
);

pub(super) static ROUGH_CONDUCTOR: Plugin = Plugin {
    name: "roughconductor",
    help: "A rough metal, from the front only.",
    properties: &[
        MATERIAL,
        ETA,
        K,
        SPECULAR_REFLECTANCE,
        DISTRIBUTION,
        ALPHA,
        ALPHA_U,
        ALPHA_V,
        SAMPLE_VISIBLE,
    ],
    parts: &[],
    build: Build::Bsdf(|object| {
        Ok(Box::new(RoughConductor::new(metal(object)?, roughness(object)?)))
    }),
};

pub(super) static ROUGH_DIELECTRIC: Plugin = Plugin {
    name: "roughdielectric",
    help: "Rough glass.",
    properties: &[
        int_ior("bk7"),
        EXT_IOR,
        SPECULAR_REFLECTANCE,
        SPECULAR_TRANSMITTANCE,
        DISTRIBUTION,
        ALPHA,
        ALPHA_U,
        ALPHA_V,
        SAMPLE_VISIBLE,
    ],
    parts: &[],
    build: Build::Bsdf(rough_dielectric),
};

pub(super) static ROUGH_PLASTIC: Plugin = Plugin {
    name: "roughplastic",
    help: "A diffuse base under a rough coat, from the front only.",
    properties: &[
        int_ior("polypropylene"),
        EXT_IOR,
        DIFFUSE_REFLECTANCE,
        SPECULAR_REFLECTANCE,
        NONLINEAR,
        DISTRIBUTION,
        property(
            "alpha",
            Kind::Float(Bounds::NotNegative),
            Default::Float(0.1),
            "roughness: \u{221a}2 times the root mean square slope",
        ),
        SAMPLE_VISIBLE,
    ],
    parts: &[],
    build: Build::Bsdf(|object| {
        let alpha = object.float("alpha") as f32;
        warn_if_smooth(object, "alpha", alpha);
        Ok(Box::new(RoughPlastic::new(coat(object)?, distribution(object), alpha)))
    }),
};

fn rough_dielectric(object: &Object<'_>) -> Result<Box<dyn Bsdf>, Issue> {
    let [inside, outside] = indices(object)?;
    let material = RoughDielectric::new(
        inside / outside,
        roughness(object)?,
        object.rgb_texture("specular_reflectance")?,
        object.rgb_texture("specular_transmittance")?,
    );
    let Some(material) = material else {
        let message = "`int_ior` and `ext_ior` are the same, so nothing is refracted";
        return Err(Issue::new(object.place(), message)
            .with_help("use bsdf `null`, or `dielectric`, which may have the same on both sides"));
    };
    Ok(Box::new(material))
}

fn distribution(object: &Object<'_>) -> Distribution {
    if !object.boolean("sample_visible") {
        let message = "visible normals are sampled all the same: the picture has less noise";
        object.warn(Issue::new(object.place_of("sample_visible"), message));
    }
    match object.choice("distribution") {
        "ggx" => Distribution::Ggx,
        _ => Distribution::Beckmann,
    }
}

fn roughness(object: &Object<'_>) -> Result<Roughness, Issue> {
    let distribution = distribution(object);
    let alpha = |name: &str| -> Result<Textured<f32>, Issue> {
        let alpha = object.float_texture(name)?;
        match &alpha {
            Textured::Uniform(alpha) => warn_if_smooth(object, name, *alpha),
            Textured::Varying(texture) => warn_if_smooth(object, name, texture.range()[0]),
        }
        Ok(alpha)
    };
    match (object.has("alpha_u"), object.has("alpha_v")) {
        (false, false) => Ok(Roughness::new(distribution, alpha("alpha")?)),
        (true, true) => {
            object.refuse(&["alpha"], "beside `alpha_u` and `alpha_v`")?;
            Ok(Roughness::anisotropic(distribution, alpha("alpha_u")?, alpha("alpha_v")?))
        }
        (u, _) => {
            let (given, missing) = if u { ("alpha_u", "alpha_v") } else { ("alpha_v", "alpha_u") };
            let message = format!("`{given}` needs `{missing}` beside it");
            Err(Issue::new(object.place_of(given), message))
        }
    }
}

fn warn_if_smooth(object: &Object<'_>, name: &str, alpha: f32) {
    if alpha < LEAST_ALPHA {
        let message = format!("`{name}` is raised to {LEAST_ALPHA}, the least roughness there is");
        let help = "use the smooth material for no roughness at all";
        object.warn(Issue::new(object.place_of(name), message).with_help(help));
    }
}
