//! How direct light is found.

use crate::integrator::MisHeuristic;
use crate::integrator::settings::Reason;
use crate::property::named::names;
use crate::property::{Default, Given, Kind, Named, PropertyInfo, Refusal, property};

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

impl Named for Strategy {
    const ALL: &'static [(&'static str, Self)] = &[
        ("mis_power", Self::Mis(MisHeuristic::Power)),
        ("mis_balance", Self::Mis(MisHeuristic::Balance)),
        ("bsdf", Self::Bsdf),
        ("emitter", Self::Emitter),
    ];
}

pub(crate) const STRATEGY: PropertyInfo = property(
    "strategy",
    Kind::Choice(&names::<_, 4>(Strategy::ALL)),
    Default::Text(Strategy::ALL[0].0),
    "how direct light is found: by shadow rays and directions, weighted, or by one of them",
);

impl Strategy {
    /// Refuses that a number of shadow rays is given where there are none.
    pub(super) fn refuse_shadow_rays(
        self,
        told: &dyn Given,
        samples: &PropertyInfo,
    ) -> Result<(), Refusal> {
        match self {
            Self::Bsdf => Refusal::if_given(told, &[samples], "if `strategy` is `bsdf`"),
            Self::Emitter | Self::Mis(_) => Ok(()),
        }
    }

    /// What it is, for reports.
    pub(super) fn describe(self) -> &'static str {
        match self {
            Self::Bsdf => "light found by scattering",
            Self::Emitter => "light found by shadow rays",
            Self::Mis(_) => "light found by both scattering and shadow rays",
        }
    }

    /// Whether shadow rays and scattered rays are weighted.
    pub(super) fn multiple_importance_sampling(self) -> Reason {
        match self {
            Self::Mis(heuristic) => Ok(heuristic.describe().to_owned()),
            Self::Bsdf => Err("light is found by scattering alone".to_owned()),
            Self::Emitter => Err("light is found by shadow rays alone".to_owned()),
        }
    }
}
