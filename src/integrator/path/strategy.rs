//! How direct light is found.

use crate::integrator::MisHeuristic;

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
