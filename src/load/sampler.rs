//! Samplers of scene files.

use super::plugins::{Build, Default, Kind, Plugin, property};
use crate::scene::settings::{SamplerKind, SamplerSettings};

pub(super) static INDEPENDENT: Plugin = Plugin {
    name: "independent",
    help: "Independent uniform numbers.",
    properties: &[
        property(
            "sample_count",
            Kind::Integer(1, u32::MAX as i64),
            Default::Integer(4),
            "samples per pixel",
        ),
        property(
            "seed",
            Kind::Integer(0, i64::MAX),
            Default::Integer(0),
            "which of many random sequences",
        ),
    ],
    parts: &[],
    build: Build::Sampler(|object| SamplerSettings {
        kind: SamplerKind::Independent,
        samples_per_pixel: object.count("sample_count"),
        seed: object.integer("seed").unsigned_abs(),
    }),
};
