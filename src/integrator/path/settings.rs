//! All that the path tracer can be told.

use super::direct::DIRECT;
use super::strategy::STRATEGY;
use super::{Path, Strategy, extras};
use crate::emitter::choice_policy::EMITTER_CHOICE;
use crate::emitter::{ChoicePolicy, LightSampler};
use crate::integrator::directions::{self, DIRECTIONS};
use crate::integrator::knobs::{Knob, Needs, Turn, Turned};
use crate::integrator::plugin::{Common, HIDE_EMITTERS, MOST_EDGES, MOST_SAMPLES, Plugin};
use crate::integrator::roulette::{
    self, RR_DEPTH, RR_FACTOR, RR_MAX_SURVIVAL, RR_POLICY, RR_SURVIVAL,
};
use crate::integrator::settings::{Part, Reason, edges};
use crate::integrator::{DirectionSampling, IntegratorSettings, Parts, Roulette, Settings};
use crate::property::given::chosen;
use crate::property::{self, At, Given, Kind, Nothing, PropertyInfo, Refusal, property};
use crate::scene::Scene;

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

/// In scene files and for `measure` -1 stands for no limit.
const MAX_DEPTH: PropertyInfo = property(
    "max_depth",
    Kind::Integer(-1, MOST_EDGES),
    property::Default::Integer(-1),
    "longest path in edges: 1 shows emitters only, 2 adds direct light; -1: no limit",
);

const EMITTER_SAMPLES: PropertyInfo = property(
    "emitter_samples",
    Kind::Integer(1, MOST_SAMPLES),
    property::Default::Integer(1),
    "shadow rays at each surface (not in Mitsuba)",
);

const PATH: Plugin = Plugin {
    name: "path",
    help: "The path tracer; also the integrator of scenes that name none.",
    properties: &[
        MAX_DEPTH,
        RR_DEPTH,
        HIDE_EMITTERS,
        STRATEGY,
        DIRECTIONS,
        EMITTER_CHOICE,
        EMITTER_SAMPLES,
        RR_POLICY,
        RR_SURVIVAL,
        RR_FACTOR,
        RR_MAX_SURVIVAL,
    ],
    contains: false,
    read: |told| Ok(PathSettings::read(told)?.into()),
    in_place_of: Some(|other| PathSettings::in_place_of(other).into()),
};

static KNOBS: &[Knob<PathSettings>] = &[
    Knob {
        property: &MAX_DEPTH,
        // `direct` has one of its own.
        needs: Needs::Integrators(&[PATH.name], String::new),
        turn: Turn::Words("a whole number from 0, or -1 for no limit", |path, text| {
            MAX_DEPTH.kind.parse(text).map_or(Turned::Bad, |value| {
                path.max_depth = limit(value.integer());
                Turned::Done
            })
        }),
    },
    Knob {
        property: &DIRECTIONS,
        needs: directions::NEEDS,
        turn: Turn::Value(|path, value| {
            path.directions = value.named();
            true
        }),
    },
    Knob {
        property: &STRATEGY,
        needs: OF_BOTH,
        turn: Turn::Value(|path, value| {
            path.strategy = value.named();
            true
        }),
    },
    Knob {
        property: &EMITTER_CHOICE,
        needs: OF_BOTH,
        turn: Turn::Value(|path, value| {
            path.emitter_choice = value.named();
            true
        }),
    },
    Knob {
        property: &EMITTER_SAMPLES,
        needs: Needs::Integrators(&BOTH, || ", unless `strategy=bsdf`".to_owned()),
        turn: Turn::Value(|path, value| {
            let used = path.strategy != Strategy::Bsdf;
            if used {
                path.emitter_samples = value.count();
            }
            used
        }),
    },
    Knob {
        property: &RR_POLICY,
        needs: OF_BOTH,
        turn: Turn::Words(roulette::POLICY_WORDS, |path, text| path.roulette.turn_policy(text)),
    },
    Knob {
        property: &RR_MAX_SURVIVAL,
        needs: roulette::THROUGHPUT_NEEDS,
        turn: Turn::Value(|path, value| path.roulette.turn_max_survival(value)),
    },
    Knob {
        property: &RR_FACTOR,
        needs: roulette::THROUGHPUT_NEEDS,
        turn: Turn::Value(|path, value| path.roulette.turn_factor(value)),
    },
    Knob {
        property: &RR_DEPTH,
        needs: roulette::MIN_DEPTH_NEEDS,
        turn: Turn::Words(roulette::MIN_DEPTH_WORDS, |path, text| {
            path.roulette.turn_min_depth(text)
        }),
    },
];

const BOTH: [&str; 2] = [PATH.name, DIRECT.name];
const OF_BOTH: Needs = Needs::Integrators(&BOTH, String::new);

/// Only -1, which stands for no limit, is below 0.
fn limit(max_depth: i64) -> Option<u32> {
    u32::try_from(max_depth).ok()
}

impl PathSettings {
    /// As `path` of a scene file was told.
    fn read(told: &dyn Given) -> Result<Self, Refusal> {
        let max_depth = limit(told.integer(&MAX_DEPTH));
        let roulette = Roulette::read(told)?;
        if let (None, Some((property, cause))) = (max_depth, roulette.never_ends()) {
            let message =
                format!("{cause} and `max_depth` has no limit, so that a path may never end");
            return Err(Refusal::new(At::Value(property.name), message)
                .with_help("give `max_depth` a number, such as 1000"));
        }
        let strategy: Strategy = chosen(told, &STRATEGY);
        strategy.refuse_shadow_rays(told, &EMITTER_SAMPLES)?;
        Ok(Self {
            max_depth,
            roulette,
            strategy,
            directions: chosen(told, &DIRECTIONS),
            emitter_choice: chosen(told, &EMITTER_CHOICE),
            emitter_samples: told.count(&EMITTER_SAMPLES),
            bsdf_samples: 1,
            hide_emitters: told.boolean(&HIDE_EMITTERS),
        })
    }

    /// Whether paths take several directions from their first surface: they are followed one after the other, as each
    /// has to keep that.
    pub(super) fn splits(&self) -> bool {
        self.bsdf_samples > 1
    }

    /// What the path tracer makes of other settings.
    pub(super) fn in_place_of(other: &IntegratorSettings) -> Self {
        if let IntegratorSettings::Path(path) = other {
            return *path;
        }
        let Common { max_depth, directions, hide_emitters } = other.about().common();
        Self { max_depth, directions, hide_emitters, ..Self::default() }
    }
}

impl Default for PathSettings {
    fn default() -> Self {
        Self::read(&Nothing).expect("the defaults go together")
    }
}

impl Settings for PathSettings {
    fn plugins() -> &'static [Plugin] {
        static PLUGINS: [Plugin; 2] = [PATH, DIRECT];
        &PLUGINS
    }

    fn knobs() -> &'static [Knob<Self>] {
        KNOBS
    }

    fn build<'a>(&'a self, scene: &Scene) -> Parts<'a> {
        (Some(Box::new(Path::new(self, scene))), None)
    }

    fn describe(&self) -> String {
        format!("path, {}, {}", edges(self.max_depth), self.strategy.describe())
    }

    fn common(&self) -> Common {
        let Self { max_depth, directions, hide_emitters, .. } = *self;
        Common { max_depth, directions, hide_emitters }
    }

    fn up_to(&self, edges: u32) -> Option<IntegratorSettings> {
        // Where paths split, what is asked up to some depth is not what is asked first.
        (!self.splits()).then(|| Self { max_depth: Some(edges), ..*self }.into())
    }

    fn next_event_estimation(&self, scene: &Scene) -> Reason {
        let skipped = |reason: &str| Err(reason.to_owned());
        if self.strategy == Strategy::Bsdf {
            return skipped("the integrator looks for light by scattering alone");
        }
        if self.max_depth.is_some_and(|max| max < 2) {
            return skipped("paths of one edge show emitters only");
        }
        if scene.emitters().is_empty() {
            return skipped("there is no emitter");
        }
        let smooth = |&bsdf: &usize| scene.bsdfs()[bsdf].flags().smooth;
        if !scene.objects().iter().any(|o| o.bsdfs().iter().any(smooth)) {
            return skipped("all surfaces are ideal mirrors or glass");
        }
        let rays = match self.emitter_samples {
            1 => "one shadow ray".to_owned(),
            several => format!("{several} shadow rays"),
        };
        let beside_directions = matches!(self.strategy, Strategy::Mis(_));
        let emitters = scene.emitters();
        let both = if LightSampler::takes_both(self.emitter_choice, emitters, beside_directions) {
            ", from the first one of a path to each of both lights"
        } else {
            ""
        };
        Ok(format!("{rays} from each surface that is no ideal mirror or glass{both}"))
    }

    fn multiple_importance_sampling(&self, scene: &Scene) -> Reason {
        let weights = self.strategy.multiple_importance_sampling()?;
        match self.next_event_estimation(scene) {
            Ok(_) => Ok(weights),
            Err(_) => Err("there are no shadow rays".to_owned()),
        }
    }

    fn carried(&self, scene: &Scene) -> Vec<Part> {
        if self.splits() { Vec::new() } else { extras::parts(self, scene) }
    }

    fn russian_roulette(&self) -> Reason {
        self.roulette.reason(self.max_depth)
    }
}
