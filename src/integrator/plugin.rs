//! How scene files ask for an integrator, and `measure` for another one.

use super::IntegratorSettings;
use super::directions::DirectionSampling;
use crate::property::{Default, Given, Kind, PropertyInfo, Refusal, property};

/// A name under which scene files ask for an integrator.
#[derive(Debug)]
pub struct Plugin {
    /// The value of its `type`.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub help: &'static str,
    /// The properties that it takes.
    pub properties: &'static [PropertyInfo],
    /// Whether another integrator may stand inside it.
    pub contains: bool,
    /// The settings of one that was told something.
    pub read: Read,
    /// What it makes of other settings for the same scene: what both have is kept. `None` for one that `measure` does
    /// not compare with others, as it makes another picture.
    pub in_place_of: Option<fn(&IntegratorSettings) -> IntegratorSettings>,
}

/// See [`Plugin::read`].
pub type Read = fn(&dyn Told) -> Result<IntegratorSettings, Refusal>;

/// What an integrator was told.
pub trait Told: Given {
    /// The settings of the integrator inside it, if there is one.
    fn inner(&self) -> Option<Result<IntegratorSettings, Refusal>>;
}

/// What integrators may have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Common {
    /// Longest path in edges; `None`: no limit.
    pub max_depth: Option<u32>,
    /// How directions are chosen.
    pub directions: DirectionSampling,
    /// Leave emitters out of the camera's view.
    pub hide_emitters: bool,
}

impl Common {
    /// What holds for an integrator that says nothing of it.
    pub const UNSAID: Self =
        Self { max_depth: None, directions: DirectionSampling::Bsdf, hide_emitters: false };
}

/// The property of integrators whose paths begin by what the camera sees.
pub(super) const HIDE_EMITTERS: PropertyInfo = property(
    "hide_emitters",
    Kind::Boolean,
    Default::Boolean(false),
    "leave emitters out of the camera's view",
);

/// The most edges of a path that can be asked for, as in Mitsuba.
pub(super) const MOST_EDGES: i64 = i32::MAX as i64;

/// The most directions or shadow rays at one surface.
pub(super) const MOST_SAMPLES: i64 = 65_536;
