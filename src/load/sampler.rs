//! Samplers of scene files.

use super::document::Place;
use super::plugins::{self, Build, Category, Plugin};
use super::problem::Issue;
use super::properties::Object;
use crate::property::{Bounds, Default, Kind, PropertyInfo, property};
use crate::render::Effort;
use crate::sampler::settings::{About, PROPERTIES, SAMPLE_COUNT, SEED};
use crate::sampler::{SamplerKind, SamplerSettings};

const JITTER: PropertyInfo = property(
    "jitter",
    Kind::Boolean,
    Default::Boolean(true),
    "not needed: points of `sobol` lie anywhere in their cells",
);

const STRENGTH: PropertyInfo = property(
    "strength",
    Kind::Integer(1, i32::MAX as i64),
    Default::Integer(2),
    "not needed: four dimensions of `sobol` are spread together",
);

const ERROR: PropertyInfo = property(
    "error",
    Kind::Float(Bounds::Positive),
    Default::Absent("all samples are taken"),
    "relMSE at which a render ends, be it before `sample_count`; see `telamon render --error` (not in Mitsuba)",
);

/// Our own, and Mitsuba's that we do not have.
pub(super) fn plugins() -> impl Iterator<Item = Plugin> {
    let ours = SamplerKind::ALL.iter().map(|&kind| {
        let About { name, help, .. } = kind.about();
        let build = Build::Sampler(kind);
        Plugin { name, help, properties: &[SAMPLE_COUNT, SEED, ERROR], parts: &[], build }
    });
    ours.chain([
        stand_in("stratified", &[SAMPLE_COUNT, SEED, JITTER]),
        stand_in("multijitter", &[SAMPLE_COUNT, SEED, JITTER]),
        stand_in("orthogonal", &[SAMPLE_COUNT, SEED, JITTER, STRENGTH]),
        stand_in("ldsampler", PROPERTIES),
    ])
}

/// The one of sensors that have none.
pub(super) fn default() -> &'static Plugin {
    let name = SamplerKind::default().name();
    plugins::find(Category::Sampler, name).expect("one of our own")
}

fn stand_in(name: &'static str, properties: &'static [PropertyInfo]) -> Plugin {
    let help = "`sobol` takes its place, with a warning.";
    Plugin { name, help, properties, parts: &[], build: Build::Sampler(SamplerKind::Sobol) }
}

/// The settings that an object describes, what ends the render, and a warning if it has another sampler's name.
pub(super) fn build(object: &Object<'_>) -> (SamplerSettings, Effort, Option<Issue>) {
    let Build::Sampler(kind) = object.plugin().build else {
        unreachable!("callers pass samplers");
    };
    let settings = SamplerSettings::read(kind, object);
    let name = object.plugin().name;
    let warning = (name != kind.name()).then(|| {
        let message = format!("sampler `{kind}` is used in place of `{name}`");
        Issue::new(object.place_of_type(), message)
    });
    // Those that are replaced have no such property.
    let error = if object.has(ERROR.name) { object.number(ERROR.name) } else { None };
    (settings, Effort { error, ..Effort::default() }, warning)
}

/// Where an object says that an error ends the render, if it does.
pub(super) fn place_of_error(object: &Object<'_>) -> Option<Place> {
    object.has(ERROR.name).then(|| object.place_of(ERROR.name))
}
