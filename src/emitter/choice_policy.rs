//! How the emitter that a shadow ray goes to is picked: the ways, by name.

use crate::property::named::names;
use crate::property::{Default, Kind, Named, PropertyInfo, property};

/// How one emitter is picked.
///
/// Where directions of surfaces find light as well (multiple importance sampling), a uniform environment beside other
/// lights is left to them, whichever way it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChoicePolicy {
    /// All alike.
    Uniform,
    /// In proportion to emitted power, but none a thousand times less often than if all were alike: a dim
    /// light may be the nearest. The environment, of which no power can be told, half of the time.
    Power,
    /// By intensity, distance and orientation, among the emitters inside the scene and the primitives of those that have
    /// many: through a [`LightBvh`](super::LightBvh), or where they are at most 32 by weighing each. Each emitter
    /// outside, such as an environment, is as likely as all of these together.
    Bvh,
    /// Two or three emitters are each asked for a candidate, of which one is taken in proportion to the light that it would
    /// bring if nothing were between (resampled importance sampling; Talbot, Cline and Egbert 2005); of two emitters, both are
    /// taken at the first surface of a path that is no ideal mirror or glass. Up to 16 emitters are asked there if it is
    /// glossy. Elsewhere as [`ChoicePolicy::Bvh`].
    Ris,
}

impl Named for ChoicePolicy {
    const ALL: &'static [(&'static str, Self)] = &[
        ("uniform", Self::Uniform),
        ("power", Self::Power),
        ("bvh", Self::Bvh),
        ("ris", Self::Ris),
    ];
}

/// The property of integrators that send shadow rays.
pub(crate) const EMITTER_CHOICE: PropertyInfo = property(
    "emitter_choice",
    Kind::Choice(&names::<_, 4>(ChoicePolicy::ALL)),
    Default::Text(ChoicePolicy::ALL[3].0),
    "how the emitter that a shadow ray goes to is picked: all alike, by emitted power, by a light BVH, which knows of \
     distance and orientation, or by resampled importance sampling of one direction to each, where they are few",
);
