//! Settings of film, sampler and integrator, as plain values. What they do is written in the rooms that
//! use them.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;
use std::time::Duration;

use crate::emitter::ChoicePolicy;

/// The picture that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    /// Width of the whole film in pixels.
    pub width: u32,
    /// Height of the whole film in pixels.
    pub height: u32,
    /// The part of the film that is rendered.
    pub crop: Crop,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Whether the picture has an alpha channel: the fraction of camera rays that hit something.
    pub alpha: bool,
    /// Precision of colours in an EXR file.
    pub component: ComponentFormat,
    /// Whether layers say how much the samples of each pixel vary, and how many there are. Scene files
    /// have no property for it.
    pub variance: bool,
    /// Samples whose largest component exceeds this, above 0, are scaled down to it: less noise, and a
    /// picture that is too dark. None are unless asked for; scene files have no property for it.
    pub clamp: Option<f32>,
}

/// A rectangle of pixels of the whole film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// First column.
    pub x: u32,
    /// First row, from the top.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// A reconstruction filter, separable and not negative; lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The pixel itself.
    Box,
    /// Falls linearly to 0 at `radius`.
    Tent {
        /// Where it reaches 0.
        radius: f32,
    },
    /// A Gaussian lowered so that it reaches 0 at four standard deviations.
    Gaussian {
        /// Standard deviation.
        stddev: f32,
    },
}

/// How a number is stored in an EXR file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComponentFormat {
    /// 16 bits.
    Half,
    /// 32 bits.
    Float,
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

/// How light is carried.
#[derive(Clone, Debug, PartialEq)]
pub enum IntegratorSettings {
    /// The path tracer.
    Path(PathSettings),
    /// Direct light by one uniform direction of the hemisphere: the lecture's first tracer.
    DirectUniform {
        /// Leave emitters out of the camera's view.
        hide_emitters: bool,
    },
    /// Many rays at each bounce: the lecture's recursive estimator, whose cost grows as N^depth.
    Branching {
        /// N, at least 1.
        branches: u32,
        /// Longest path in edges, as in [`PathSettings::max_depth`]; always limited.
        max_depth: u32,
        /// How directions are chosen.
        directions: DirectionSampling,
        /// Leave emitters out of the camera's view.
        hide_emitters: bool,
    },
    /// Ambient occlusion: the fraction of the cosine-weighted hemisphere that is free.
    AmbientOcclusion {
        /// How far an occluder counts, in scene units; may be infinite.
        ray_length: f32,
    },
    /// Properties of the first surface, beside the picture of another integrator.
    Aov {
        /// What to write.
        layers: Vec<AovLayer>,
        /// Makes the picture; `None`: layers alone.
        picture: Option<Box<IntegratorSettings>>,
    },
}

/// Settings of the path tracer. `direct` of a scene file is the path tracer of depth 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Longest path in edges: 1 shows emitters only, 2 adds direct light. `None`: no limit.
    pub max_depth: Option<u32>,
    /// When a path ends by chance.
    pub roulette: Roulette,
    /// How direct light is found.
    pub strategy: Strategy,
    /// How directions are chosen.
    pub directions: DirectionSampling,
    /// Which emitter a shadow ray goes to.
    pub emitter_choice: ChoicePolicy,
    /// Shadow rays at each surface, at least 1, unless the strategy has none.
    pub emitter_samples: u32,
    /// Directions in which a path goes on from its first surface, at least 1: it splits into as many, each of which
    /// is followed by itself.
    pub bsdf_samples: u32,
    /// Leave emitters out of the camera's view.
    pub hide_emitters: bool,
}

impl Default for PathSettings {
    fn default() -> Self {
        Self {
            max_depth: None,
            roulette: Roulette::default(),
            strategy: Strategy::Mis(MisHeuristic::Power),
            directions: DirectionSampling::Bsdf,
            emitter_choice: ChoicePolicy::Bvh,
            emitter_samples: 1,
            bsdf_samples: 1,
            hide_emitters: false,
        }
    }
}

/// How direct light is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// By directions that happen to hit an emitter.
    Bsdf,
    /// By shadow rays to emitters (next-event estimation); by directions only after a mirror.
    Emitter,
    /// By both, weighted (multiple importance sampling).
    Mis(MisHeuristic),
}

/// How the two are weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MisHeuristic {
    /// In proportion to the densities.
    Balance,
    /// In proportion to their squares.
    Power,
}

/// How the next direction of a path is chosen at a surface that is no ideal mirror or glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectionSampling {
    /// By the material, in proportion to what it scatters as far as possible.
    Bsdf,
    /// Cosine-weighted in the hemisphere.
    CosineHemisphere,
    /// Uniform in the hemisphere.
    UniformHemisphere,
}

/// Russian roulette: when a path ends by chance, and with what probability it goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roulette {
    /// Where the survival probability comes from.
    pub policy: RoulettePolicy,
    /// Paths with fewer edges than this always go on.
    pub min_depth: u32,
    /// Largest survival probability, so that every path ends.
    pub max_survival: f32,
}

/// Where the survival probability comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RoulettePolicy {
    /// Every path goes on.
    None,
    /// The same for all.
    Fixed(f32),
    /// The path's throughput.
    Throughput,
}

impl Default for Roulette {
    /// Mitsuba's default depth, and the lecture's clamp.
    fn default() -> Self {
        Self { policy: RoulettePolicy::Throughput, min_depth: 5, max_survival: 0.99 }
    }
}

/// One property of the first surface, as a layer of the EXR file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AovLayer {
    /// Name of the layer: the part of its channels' names before the dot.
    pub name: String,
    /// What it holds.
    pub kind: AovKind,
}

/// A property of the first surface. Averaged over a pixel, and 0 where there is no surface, but for
/// the two indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AovKind {
    /// Distance from the camera in scene units.
    Depth,
    /// World position.
    Position,
    /// Unit normal of the geometry.
    GeometricNormal,
    /// Unit normal for shading.
    ShadingNormal,
    /// Texture coordinates.
    Uv,
    /// Fraction of light that the material scatters.
    Albedo,
    /// Index of the shape at the pixel's first sample; 4294967295 where there is none.
    ShapeIndex,
    /// Index of the primitive at the pixel's first sample; 4294967295 where there is none.
    PrimitiveIndex,
}

/// What ends a render before it has all samples of [`SamplerSettings::samples_per_pixel`], and where they
/// go. Scene files have no properties for it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Time to render in. The first sample of each pixel is always taken, and every pass finished.
    pub time: Option<Duration>,
    /// relMSE to reach, above 0: the mean over pixels and channels of (I − R)²/(R² + 0.01) with the value
    /// I and its expectation R.
    pub error: Option<f64>,
    /// Noise level to reach, above 0: what the root of the same quotient, averaged over the channels, is at
    /// most in 95 % of the pixels.
    pub noise_level: Option<f64>,
    /// Whether noisy parts of the picture get more samples than others, at the same number on average.
    pub adaptive: bool,
}

impl Effort {
    /// Whether the samples have to be kept in two independent halves.
    #[must_use]
    pub fn needs_halves(&self) -> bool {
        self.needs_error() || self.adaptive
    }

    /// Whether an estimate of the error is needed.
    #[must_use]
    pub fn needs_error(&self) -> bool {
        self.error.is_some() || self.noise_level.is_some()
    }
}
