//! The lecture's first tracer: direct light by uniform hemisphere sampling, which is one branch at one bounce.

use super::branching::Branching;
use super::directions::DirectionSampling;
use super::plugin::{Common, HIDE_EMITTERS, Plugin};
use super::{Parts, Settings};
use crate::property::{Given, Nothing};
use crate::scene::Scene;

/// All that it can be told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectUniformSettings {
    /// Leave emitters out of the camera's view.
    pub hide_emitters: bool,
}

static DIRECT_UNIFORM: Plugin = Plugin {
    name: "direct_uniform",
    help: "Direct light by one uniform direction of the hemisphere: the simplest tracer (not in Mitsuba).",
    properties: &[HIDE_EMITTERS],
    contains: false,
    read: |told| Ok(DirectUniformSettings::read(told).into()),
    in_place_of: Some(|other| {
        let Common { hide_emitters, .. } = other.about().common();
        DirectUniformSettings { hide_emitters }.into()
    }),
};

impl DirectUniformSettings {
    fn read(told: &dyn Given) -> Self {
        Self { hide_emitters: told.boolean(&HIDE_EMITTERS) }
    }
}

impl Default for DirectUniformSettings {
    fn default() -> Self {
        Self::read(&Nothing)
    }
}

impl Settings for DirectUniformSettings {
    fn plugins() -> &'static [Plugin] {
        std::slice::from_ref(&DIRECT_UNIFORM)
    }

    fn build<'a>(&'a self, _: &Scene) -> Parts<'a> {
        let branching =
            Branching::new(1, 2, DirectionSampling::UniformHemisphere, self.hide_emitters);
        (Some(Box::new(branching)), None)
    }

    fn describe(&self) -> String {
        "direct light by uniform directions".to_owned()
    }

    fn common(&self) -> Common {
        Common { hide_emitters: self.hide_emitters, ..Common::UNSAID }
    }
}
