//! What integrators are told, and the list of them.

use std::fmt::Debug;

use super::Parts;
use super::knobs::{self, Knob, Known, Turned};
use super::plugin::{Common, Plugin};
use crate::film::AovLayer;
use crate::scene::Scene;

/// What the file of an integrator says of its settings.
pub trait Settings: Debug + 'static {
    /// The names under which scene files ask for it.
    fn plugins() -> &'static [Plugin]
    where
        Self: Sized;

    /// What `measure` can turn.
    fn knobs() -> &'static [Knob<Self>]
    where
        Self: Sized,
    {
        &[]
    }

    /// Builds what they ask for, for use with `scene`.
    fn build<'a>(&'a self, scene: &Scene) -> Parts<'a>;

    /// What they ask for: a fragment.
    fn describe(&self) -> String;

    /// What other integrators may have too.
    fn common(&self) -> Common {
        Common::UNSAID
    }

    /// Whether the picture of a scene without light is black.
    fn shows_light(&self) -> bool {
        true
    }

    /// The same with paths of at most so many edges, if each sample is one path.
    fn up_to(&self, _edges: u32) -> Option<IntegratorSettings> {
        None
    }

    /// Whether it sends shadow rays to emitters.
    fn next_event_estimation(&self, _scene: &Scene) -> Reason {
        Err(ONLY_PATH.to_owned())
    }

    /// Whether it weights them against scattered rays.
    fn multiple_importance_sampling(&self, _scene: &Scene) -> Reason {
        Err(ONLY_PATH.to_owned())
    }

    /// What its paths carry from one surface to the next, and what they leave out; nothing where one path after the other
    /// is followed.
    fn carried(&self, _scene: &Scene) -> Vec<Part> {
        Vec::new()
    }

    /// Whether its paths end by chance.
    fn russian_roulette(&self) -> Reason {
        Err(ONLY_PATH.to_owned())
    }
}

/// Why a feature is modelled (`Ok`) or not (`Err`): a fragment.
pub type Reason = Result<String, String>;

/// A part of what paths carry from one surface to the next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// What it is.
    pub name: &'static str,
    /// Its size.
    pub bytes: usize,
    /// Why it is carried, or left out.
    pub reason: Reason,
}

const ONLY_PATH: &str = "only the path tracer has it";

macro_rules! integrators {
    ($($(#[$doc:meta])* $name:ident($settings:ty),)*) => {
        /// How light is carried.
        #[derive(Clone, Debug, PartialEq)]
        pub enum IntegratorSettings {
            $($(#[$doc])* $name($settings),)*
        }

        $(impl From<$settings> for IntegratorSettings {
            fn from(settings: $settings) -> Self {
                Self::$name(settings)
            }
        })*

        impl IntegratorSettings {
            /// What there is to know about them.
            #[must_use]
            pub fn about(&self) -> &dyn Settings {
                match self {
                    $(Self::$name(settings) => settings,)*
                }
            }

            /// Each kind with its defaults.
            pub(super) fn defaults() -> Vec<Self> {
                vec![$(<$settings>::default().into()),*]
            }

            /// Turns a knob that these settings have.
            pub(super) fn turn_own(&mut self, name: &str, text: &str) -> Option<Turned> {
                match self {
                    $(Self::$name(settings) => knobs::turn(settings, name, text),)*
                }
            }
        }

        /// All names under which scene files ask for an integrator.
        pub fn plugins() -> impl Iterator<Item = &'static Plugin> {
            [$(<$settings>::plugins()),*].into_iter().flatten()
        }

        /// All knobs of integrators.
        #[must_use]
        pub fn known_knobs() -> Vec<Known> {
            knobs::known(&[$(knobs::parts::<$settings>()),*])
        }
    };
}

// A new integrator is a file of its own, which `mod.rs` declares, and a line here.
integrators! {
    /// The path tracer.
    Path(super::path::PathSettings),
    /// Direct light by one uniform direction of the hemisphere: the lecture's first tracer.
    DirectUniform(super::direct_uniform::DirectUniformSettings),
    /// Many rays at each bounce: the lecture's recursive estimator, whose cost grows as N^depth.
    Branching(super::branching::BranchingSettings),
    /// Ambient occlusion: the fraction of the cosine-weighted hemisphere that is free.
    AmbientOcclusion(super::ambient_occlusion::AmbientOcclusionSettings),
    /// Properties of the first surface, beside the picture of another integrator.
    Aov(super::aov::AovSettings),
}

impl IntegratorSettings {
    /// The integrator that makes the picture; `None`: layers alone.
    #[must_use]
    pub fn picture(&self) -> Option<&Self> {
        match self {
            Self::Aov(aov) => aov.picture.as_deref(),
            other => Some(other),
        }
    }

    /// The layers beside the picture.
    #[must_use]
    pub fn layers(&self) -> &[AovLayer] {
        match self {
            Self::Aov(aov) => &aov.layers,
            _ => &[],
        }
    }
}

/// The integrator of scenes that name none.
impl Default for IntegratorSettings {
    fn default() -> Self {
        Self::Path(Default::default())
    }
}

/// Builds what `settings` ask for, for use with `scene`.
#[must_use]
pub fn build<'a>(settings: &'a IntegratorSettings, scene: &Scene) -> Parts<'a> {
    settings.about().build(scene)
}

/// A limit of the length of paths, in words.
pub(super) fn edges(limit: Option<u32>) -> String {
    match limit {
        Some(edges) => format!("paths of at most {edges} edges"),
        None => "paths of any length".to_owned(),
    }
}
