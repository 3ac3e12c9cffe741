//! What samplers are told, and the list of them.

use std::fmt::{self, Debug, Display, Formatter};
use std::str::FromStr;

use super::Sampler;
use crate::property::{Default, Given, Kind, PropertyInfo, property};

/// What there is to know about a kind of sampler, as its own file says it.
#[derive(Debug)]
pub struct About {
    /// Its name in scene files, options and reports.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub help: &'static str,
    /// Whether the samples of a pixel know nothing of each other, so that the error of their mean can be told from how
    /// much they vary.
    pub independent: bool,
    /// The sampler of a seed.
    pub(super) build: fn(u64) -> Box<dyn Sampler>,
}

/// The properties of all samplers.
pub(crate) const PROPERTIES: &[PropertyInfo] = &[SAMPLE_COUNT, SEED];

pub(crate) const SAMPLE_COUNT: PropertyInfo = property(
    "sample_count",
    Kind::Integer(1, u32::MAX as i64),
    Default::Integer(4),
    "samples per pixel",
);

pub(crate) const SEED: PropertyInfo = property(
    "seed",
    Kind::Integer(0, i64::MAX),
    Default::Integer(0),
    "which of many random sequences",
);

macro_rules! samplers {
    ($($(#[$doc:meta])* $name:ident: $about:path,)*) => {
        /// A family of point sets.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum SamplerKind {
            $($(#[$doc])* $name,)*
        }

        impl SamplerKind {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// What its file says of it.
            #[must_use]
            pub fn about(self) -> &'static About {
                match self {
                    $(Self::$name => &$about,)*
                }
            }
        }
    };
}

// A new sampler is a file of its own, which `mod.rs` declares, and a line here.
samplers! {
    /// Independent uniform numbers.
    Independent: super::independent::ABOUT,
    /// Sobol' points, scrambled as Owen does.
    Sobol: super::sobol::ABOUT,
}

/// The sampler of sensors that have none.
impl std::default::Default for SamplerKind {
    fn default() -> Self {
        Self::Sobol
    }
}

impl SamplerKind {
    /// Its name in scene files, options and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.about().name
    }
}

impl Display for SamplerKind {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// No sampler has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no sampler `{0}`")]
pub struct UnknownSampler(String);

impl FromStr for SamplerKind {
    type Err = UnknownSampler;

    fn from_str(name: &str) -> Result<Self, UnknownSampler> {
        let found = Self::ALL.iter().find(|kind| kind.name() == name);
        found.copied().ok_or_else(|| UnknownSampler(name.to_owned()))
    }
}

/// Random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerSettings {
    /// Their kind.
    pub kind: SamplerKind,
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// Which of many unrelated sequences.
    pub seed: u64,
}

impl SamplerSettings {
    /// A sampler of this kind, as it was told.
    pub(crate) fn read(kind: SamplerKind, given: &dyn Given) -> Self {
        Self {
            kind,
            samples_per_pixel: given.count(&SAMPLE_COUNT),
            seed: given.integer(&SEED).unsigned_abs(),
        }
    }
}
