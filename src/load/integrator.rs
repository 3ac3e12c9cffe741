//! Integrators of scene files.

use super::document::Place;
use super::plugins::{
    Bounds, Build, Category, Default, Kind, Part, Plugin, PropertyInfo, property,
};
use super::problem::{Issue, did_you_mean, quoted};
use super::properties::Object;
use crate::emitter::ChoicePolicy;
use crate::film::{AovKind, AovLayer};
use crate::integrator::{
    DirectionSampling, IntegratorSettings, MisHeuristic, PathSettings, Roulette, RoulettePolicy,
    Strategy,
};

const MAX_DEPTH: i64 = i32::MAX as i64;

const HIDE_EMITTERS: PropertyInfo = property(
    "hide_emitters",
    Kind::Boolean,
    Default::Boolean(false),
    "leave emitters out of the camera's view",
);

const STRATEGY: PropertyInfo = property(
    "strategy",
    Kind::Choice(&["mis_power", "mis_balance", "bsdf", "emitter"]),
    Default::Text("mis_power"),
    "how direct light is found: by shadow rays and directions, weighted, or by one of them",
);

const DIRECTIONS: PropertyInfo = property(
    "directions",
    Kind::Choice(&["bsdf", "cosine", "uniform"]),
    Default::Text("bsdf"),
    "how directions are chosen: by the material, cosine-weighted or uniform in the hemisphere",
);

const EMITTER_CHOICE: PropertyInfo = property(
    "emitter_choice",
    Kind::Choice(&["uniform", "power", "bvh"]),
    Default::Text("bvh"),
    "how the emitter that a shadow ray goes to is picked: all alike, by emitted power, or by a light BVH, \
     which knows of distance and orientation",
);

/// As many as `branching` may have rays.
const MOST_SAMPLES: i64 = 65_536;

pub(super) static PATH: Plugin = Plugin {
    name: "path",
    help: "The path tracer; also the integrator of scenes that name none.",
    properties: &[
        property(
            "max_depth",
            Kind::Integer(-1, MAX_DEPTH),
            Default::Integer(-1),
            "longest path in edges: 1 shows emitters only, 2 adds direct light; -1: no limit",
        ),
        property(
            "rr_depth",
            Kind::Integer(1, MAX_DEPTH),
            Default::Integer(5),
            "paths with fewer edges are not ended by Russian roulette",
        ),
        HIDE_EMITTERS,
        STRATEGY,
        DIRECTIONS,
        EMITTER_CHOICE,
        property(
            "emitter_samples",
            Kind::Integer(1, MOST_SAMPLES),
            Default::Integer(1),
            "shadow rays at each surface (not in Mitsuba)",
        ),
        property(
            "rr_policy",
            Kind::Choice(&["throughput", "fixed", "none"]),
            Default::Text("throughput"),
            "where the probability to go on comes from",
        ),
        property(
            "rr_survival",
            Kind::Float(Bounds::Probability),
            Default::Absent("required by rr_policy `fixed`"),
            "probability to go on of rr_policy `fixed`",
        ),
        property(
            "rr_max_survival",
            Kind::Float(Bounds::Probability),
            Default::Float(0.99),
            "largest probability to go on of rr_policy `throughput`",
        ),
    ],
    parts: &[],
    build: Build::Integrator(path),
};

pub(super) static DIRECT: Plugin = Plugin {
    name: "direct",
    help: "The path tracer with direct light only.",
    properties: &[
        property(
            "shading_samples",
            Kind::Integer(1, MOST_SAMPLES),
            Default::Integer(1),
            "shadow rays and as many directions",
        ),
        property(
            "emitter_samples",
            Kind::Integer(0, MOST_SAMPLES),
            Default::Integer(1),
            "shadow rays",
        ),
        property(
            "bsdf_samples",
            Kind::Integer(0, MOST_SAMPLES),
            Default::Integer(1),
            "directions that are followed until they meet something",
        ),
        HIDE_EMITTERS,
        STRATEGY,
        DIRECTIONS,
        EMITTER_CHOICE,
    ],
    parts: &[],
    build: Build::Integrator(direct),
};

pub(super) static DIRECT_UNIFORM: Plugin = Plugin {
    name: "direct_uniform",
    help: "Direct light by one uniform direction of the hemisphere: the simplest tracer (not in Mitsuba).",
    properties: &[HIDE_EMITTERS],
    parts: &[],
    build: Build::Integrator(|object| {
        Ok(IntegratorSettings::DirectUniform { hide_emitters: object.boolean("hide_emitters") })
    }),
};

pub(super) static BRANCHING: Plugin = Plugin {
    name: "branching",
    help: "Many rays at each bounce, whose cost grows as branches^depth (not in Mitsuba).",
    properties: &[
        property("branches", Kind::Integer(1, 65_536), Default::Integer(4), "rays at each bounce"),
        property("max_depth", Kind::Integer(0, 32), Default::Integer(3), "longest path in edges"),
        DIRECTIONS,
        HIDE_EMITTERS,
    ],
    parts: &[],
    build: Build::Integrator(|object| {
        Ok(IntegratorSettings::Branching {
            branches: object.count("branches"),
            max_depth: object.count("max_depth"),
            directions: directions(object),
            hide_emitters: object.boolean("hide_emitters"),
        })
    }),
};

pub(super) static AMBIENT_OCCLUSION: Plugin = Plugin {
    name: "ao",
    help: "Ambient occlusion: the fraction of the cosine-weighted hemisphere that is free.",
    properties: &[property(
        "ray_length",
        Kind::Float(Bounds::Positive),
        Default::Absent("infinity"),
        "how far an occluder counts, in scene units",
    )],
    parts: &[],
    build: Build::Integrator(|object| {
        let ray_length = object.number("ray_length").map_or(f32::INFINITY, |v| v as f32);
        Ok(IntegratorSettings::AmbientOcclusion { ray_length })
    }),
};

pub(super) static AOV: Plugin = Plugin {
    name: "aov",
    help: "Properties of the first surface, as layers beside the picture of the integrator inside it.",
    properties: &[property(
        "aovs",
        Kind::Text,
        Default::Required,
        "name:kind, with commas between; kinds are depth, position, uv, geo_normal, sh_normal, albedo, \
         shape_index and prim_index",
    )],
    parts: &[Part::optional(Category::Integrator)],
    build: Build::Integrator(aov),
};

pub(super) static MOMENT: Plugin = Plugin {
    name: "moment",
    help: "The integrator inside it. The second moments of Mitsuba's are left out: `render --variance` has more.",
    properties: &[],
    parts: &[Part { category: Category::Integrator, least: 1, most: 1 }],
    build: Build::Integrator(moment),
};

/// Kinds of layers by the names that Mitsuba gives them.
const AOV_KINDS: [(&str, AovKind); 8] = [
    ("depth", AovKind::Depth),
    ("position", AovKind::Position),
    ("uv", AovKind::Uv),
    ("geo_normal", AovKind::GeometricNormal),
    ("sh_normal", AovKind::ShadingNormal),
    ("albedo", AovKind::Albedo),
    ("shape_index", AovKind::ShapeIndex),
    ("prim_index", AovKind::PrimitiveIndex),
];

/// The integrator that an object describes.
///
/// # Errors
/// A combination that makes no sense.
pub(super) fn build(object: &Object<'_>) -> Result<IntegratorSettings, Issue> {
    match object.plugin().build {
        Build::Integrator(build) => build(object),
        _ => unreachable!("callers pass integrators"),
    }
}

fn path(object: &Object<'_>) -> Result<IntegratorSettings, Issue> {
    // Only -1, which stands for no limit, is below 0.
    let max_depth = u32::try_from(object.integer("max_depth")).ok();
    let roulette = roulette(object)?;
    if max_depth.is_none() {
        check_that_paths_end(object, roulette)?;
    }
    let strategy = strategy(object);
    if strategy == Strategy::Bsdf {
        object.refuse(&["emitter_samples"], "if `strategy` is `bsdf`")?;
    }
    Ok(IntegratorSettings::Path(PathSettings {
        max_depth,
        roulette,
        strategy,
        directions: directions(object),
        emitter_choice: emitter_choice(object),
        emitter_samples: object.count("emitter_samples"),
        bsdf_samples: 1,
        hide_emitters: object.boolean("hide_emitters"),
    }))
}

fn roulette(object: &Object<'_>) -> Result<Roulette, Issue> {
    let policy = match object.choice("rr_policy") {
        "fixed" => {
            let p = object.number("rr_survival").ok_or_else(|| {
                Issue::new(
                    object.place_of("rr_policy"),
                    "rr_policy `fixed` needs the property `rr_survival`",
                )
            })?;
            RoulettePolicy::Fixed(p as f32)
        }
        "none" => RoulettePolicy::None,
        _ => RoulettePolicy::Throughput,
    };
    if !matches!(policy, RoulettePolicy::Fixed(_)) {
        object.refuse(&["rr_survival"], "unless `rr_policy` is `fixed`")?;
    }
    if policy != RoulettePolicy::Throughput {
        object.refuse(&["rr_max_survival"], "unless `rr_policy` is `throughput`")?;
    }
    let max_survival = match policy {
        // A fixed probability is what the file asks for, up to 1.
        RoulettePolicy::Fixed(_) => 1.0,
        _ => object.float("rr_max_survival") as f32,
    };
    Ok(Roulette { policy, min_depth: object.count("rr_depth"), max_survival })
}

/// Refuses roulette that lets a path between white walls go on for ever.
fn check_that_paths_end(object: &Object<'_>, roulette: Roulette) -> Result<(), Issue> {
    let (property, cause) = match roulette.policy {
        RoulettePolicy::None => ("rr_policy", "`rr_policy` is `none`"),
        RoulettePolicy::Fixed(p) if p >= 1.0 => ("rr_survival", "`rr_survival` is 1"),
        RoulettePolicy::Throughput if roulette.max_survival >= 1.0 => {
            ("rr_max_survival", "`rr_max_survival` is 1")
        }
        RoulettePolicy::Fixed(_) | RoulettePolicy::Throughput => return Ok(()),
    };
    let message = format!("{cause} and `max_depth` has no limit, so that a path may never end");
    Err(Issue::new(object.place_of(property), message)
        .with_help("give `max_depth` a number, such as 1000"))
}

fn direct(object: &Object<'_>) -> Result<IntegratorSettings, Issue> {
    let names = ["emitter_samples", "bsdf_samples"];
    let counts = if object.has("shading_samples") {
        object.refuse(&names, "beside `shading_samples`")?;
        [object.count("shading_samples"); 2]
    } else {
        names.map(|name| object.count(name))
    };
    let strategy = match counts {
        [0, 0] => {
            let message =
                "integrator `direct` needs `emitter_samples` or `bsdf_samples` to be above 0";
            return Err(Issue::new(object.place(), message));
        }
        [0, _] | [_, 0] if object.has("strategy") => {
            let name = if counts[0] == 0 { names[0] } else { names[1] };
            let message = format!("`{name}` is 0 (expected at least 1 beside `strategy`)");
            return Err(Issue::new(object.place_of(name), message));
        }
        [0, _] => Strategy::Bsdf,
        [_, 0] => Strategy::Emitter,
        _ => strategy(object),
    };
    match strategy {
        Strategy::Bsdf if counts[0] > 0 => {
            object.refuse(&["emitter_samples"], "if `strategy` is `bsdf`")?;
        }
        Strategy::Emitter if counts[1] > 0 => {
            object.refuse(&["bsdf_samples"], "if `strategy` is `emitter`")?;
        }
        _ => {}
    }
    Ok(IntegratorSettings::Path(PathSettings {
        max_depth: Some(2),
        strategy,
        directions: directions(object),
        emitter_choice: emitter_choice(object),
        // What a strategy does not have is asked for once: mirrors are followed by all of them.
        emitter_samples: if strategy == Strategy::Bsdf { 1 } else { counts[0] },
        bsdf_samples: if strategy == Strategy::Emitter { 1 } else { counts[1] },
        hide_emitters: object.boolean("hide_emitters"),
        ..PathSettings::default()
    }))
}

fn strategy(object: &Object<'_>) -> Strategy {
    match object.choice("strategy") {
        "mis_balance" => Strategy::Mis(MisHeuristic::Balance),
        "bsdf" => Strategy::Bsdf,
        "emitter" => Strategy::Emitter,
        _ => Strategy::Mis(MisHeuristic::Power),
    }
}

fn directions(object: &Object<'_>) -> DirectionSampling {
    match object.choice("directions") {
        "cosine" => DirectionSampling::CosineHemisphere,
        "uniform" => DirectionSampling::UniformHemisphere,
        _ => DirectionSampling::Bsdf,
    }
}

fn emitter_choice(object: &Object<'_>) -> ChoicePolicy {
    match object.choice("emitter_choice") {
        "uniform" => ChoicePolicy::Uniform,
        "power" => ChoicePolicy::Power,
        _ => ChoicePolicy::Bvh,
    }
}

fn aov(object: &Object<'_>) -> Result<IntegratorSettings, Issue> {
    let text = object.text("aovs").unwrap_or_default();
    let mut layers: Vec<AovLayer> = Vec::new();
    for item in text.split(',').map(str::trim).filter(|item| !item.is_empty()) {
        let layer = aov_layer(item, object.place_of("aovs"))?;
        if layers.iter().any(|l| l.name == layer.name) {
            let message = format!("there is more than one layer with the name `{}`", layer.name);
            return Err(Issue::new(object.place_of("aovs"), message));
        }
        layers.push(layer);
    }
    if layers.is_empty() {
        let message = "`aovs` names no layer (expected some, as in dd:depth, nn:sh_normal)";
        return Err(Issue::new(object.place_of("aovs"), message));
    }
    let picture = object.parts(Category::Integrator).next();
    let picture = picture.map(|inner| match build(&inner)? {
        IntegratorSettings::Aov { .. } => {
            let message =
                "integrator `aov` inside integrator `aov`: put all layers into one of them";
            Err(Issue::new(inner.place(), message))
        }
        settings => Ok(Box::new(settings)),
    });
    let picture = picture.transpose()?;
    Ok(IntegratorSettings::Aov { layers, picture })
}

fn moment(object: &Object<'_>) -> Result<IntegratorSettings, Issue> {
    let inner = object.parts(Category::Integrator).next();
    let settings = build(&inner.expect("the table asks for one"))?;
    let message = "second moments are left out";
    let help = "`telamon render --variance` adds layers with the variance";
    object.warn(Issue::new(object.place_of_type(), message).with_help(help));
    Ok(settings)
}

fn aov_layer(item: &str, place: Place) -> Result<AovLayer, Issue> {
    let (name, kind) = item.split_once(':').unwrap_or((item, ""));
    let (name, kind) = (name.trim(), kind.trim());
    if name.is_empty() || kind.is_empty() {
        return Err(Issue::new(place, format!("`{item}` is not of the form name:kind")));
    }
    let names = AOV_KINDS.map(|(n, _)| n);
    let found = AOV_KINDS.iter().find(|(n, _)| *n == kind);
    found.map(|&(_, kind)| AovLayer { name: name.to_owned(), kind }).ok_or_else(|| {
        let message =
            format!("there is no layer of the kind `{kind}`{}", did_you_mean(kind, names));
        Issue::new(place, message).with_help(format!("expected one of {}", quoted(names)))
    })
}
