//! Samplers of scene files.

use super::plugins::{Build, Default, Kind, Plugin, PropertyInfo, property};
use super::problem::Issue;
use super::properties::Object;
use crate::sampler::{SamplerKind, SamplerSettings};

const SAMPLE_COUNT: PropertyInfo = property(
    "sample_count",
    Kind::Integer(1, u32::MAX as i64),
    Default::Integer(4),
    "samples per pixel",
);

const SEED: PropertyInfo = property(
    "seed",
    Kind::Integer(0, i64::MAX),
    Default::Integer(0),
    "which of many random sequences",
);

const JITTER: PropertyInfo = property(
    "jitter",
    Kind::Boolean,
    Default::Boolean(true),
    "not needed: points of `sobol` lie anywhere in their cells",
);

pub(super) static INDEPENDENT: Plugin = Plugin {
    name: "independent",
    help: "Independent uniform numbers.",
    properties: &[SAMPLE_COUNT, SEED],
    parts: &[],
    build: Build::Sampler(SamplerKind::Independent),
};

pub(super) static SOBOL: Plugin = Plugin {
    name: "sobol",
    help: "Sobol' points with Owen's scrambling, spread evenly for any number of samples and best for powers \
           of 2; the sampler of sensors that have none (not in Mitsuba).",
    properties: &[SAMPLE_COUNT, SEED],
    parts: &[],
    build: Build::Sampler(SamplerKind::Sobol),
};

pub(super) static STRATIFIED: Plugin = Plugin {
    name: "stratified",
    help: "`sobol` takes its place, with a warning.",
    properties: &[SAMPLE_COUNT, SEED, JITTER],
    parts: &[],
    build: Build::Sampler(SamplerKind::Sobol),
};

pub(super) static MULTIJITTER: Plugin = Plugin {
    name: "multijitter",
    help: "`sobol` takes its place, with a warning.",
    properties: &[SAMPLE_COUNT, SEED, JITTER],
    parts: &[],
    build: Build::Sampler(SamplerKind::Sobol),
};

pub(super) static ORTHOGONAL: Plugin = Plugin {
    name: "orthogonal",
    help: "`sobol` takes its place, with a warning.",
    properties: &[
        SAMPLE_COUNT,
        SEED,
        JITTER,
        property(
            "strength",
            Kind::Integer(1, i32::MAX as i64),
            Default::Integer(2),
            "not needed: four dimensions of `sobol` are spread together",
        ),
    ],
    parts: &[],
    build: Build::Sampler(SamplerKind::Sobol),
};

pub(super) static LDSAMPLER: Plugin = Plugin {
    name: "ldsampler",
    help: "`sobol` takes its place, with a warning.",
    properties: &[SAMPLE_COUNT, SEED],
    parts: &[],
    build: Build::Sampler(SamplerKind::Sobol),
};

/// The settings that an object describes, and a warning if it has another sampler's name.
pub(super) fn build(object: &Object<'_>) -> (SamplerSettings, Option<Issue>) {
    let Build::Sampler(kind) = object.plugin().build else {
        unreachable!("callers pass samplers");
    };
    let settings = SamplerSettings {
        kind,
        samples_per_pixel: object.count("sample_count"),
        seed: object.integer("seed").unsigned_abs(),
    };
    let name = object.plugin().name;
    let warning = (name != kind.name()).then(|| {
        let message = format!("sampler `{kind}` is used in place of `{name}`");
        Issue::new(object.place_of_type(), message)
    });
    (settings, warning)
}
