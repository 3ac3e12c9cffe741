//! What integrators are told.

use super::{DirectionSampling, PathSettings};
use crate::film::AovLayer;

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
