//! What the path tracer is told.

use super::Strategy;
use crate::emitter::ChoicePolicy;
use crate::integrator::{DirectionSampling, MisHeuristic, Roulette};

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
