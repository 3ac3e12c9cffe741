//! What samplers are told.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

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

/// A family of point sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// Independent uniform numbers.
    Independent,
    /// Sobol' points, scrambled as Owen does.
    Sobol,
}

impl SamplerKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Independent, Self::Sobol];

    /// Its name in scene files, options and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Independent => "independent",
            Self::Sobol => "sobol",
        }
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
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| UnknownSampler(name.to_owned()))
    }
}
