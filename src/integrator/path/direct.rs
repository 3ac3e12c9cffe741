//! `direct` of scene files: the path tracer with paths of two edges.

use super::strategy::STRATEGY;
use super::{PathSettings, Strategy};
use crate::emitter::choice_policy::EMITTER_CHOICE;
use crate::integrator::directions::DIRECTIONS;
use crate::integrator::plugin::{HIDE_EMITTERS, MOST_SAMPLES, Plugin};
use crate::property::given::chosen;
use crate::property::{At, Default, Given, Kind, PropertyInfo, Refusal, property};

const SHADING_SAMPLES: PropertyInfo = property(
    "shading_samples",
    Kind::Integer(1, MOST_SAMPLES),
    Default::Integer(1),
    "shadow rays and as many directions",
);

const EMITTER_SAMPLES: PropertyInfo =
    property("emitter_samples", Kind::Integer(0, MOST_SAMPLES), Default::Integer(1), "shadow rays");

const BSDF_SAMPLES: PropertyInfo = property(
    "bsdf_samples",
    Kind::Integer(0, MOST_SAMPLES),
    Default::Integer(1),
    "directions that are followed until they meet something",
);

pub(super) const DIRECT: Plugin = Plugin {
    name: "direct",
    help: "The path tracer with direct light only.",
    properties: &[
        SHADING_SAMPLES,
        EMITTER_SAMPLES,
        BSDF_SAMPLES,
        HIDE_EMITTERS,
        STRATEGY,
        DIRECTIONS,
        EMITTER_CHOICE,
    ],
    contains: false,
    read: |told| Ok(read(told)?.into()),
    in_place_of: Some(|other| {
        PathSettings { max_depth: DEPTH, ..PathSettings::in_place_of(other) }.into()
    }),
};

const DEPTH: Option<u32> = Some(2);

fn read(told: &dyn Given) -> Result<PathSettings, Refusal> {
    let counted = [&EMITTER_SAMPLES, &BSDF_SAMPLES];
    let counts = if told.has(&SHADING_SAMPLES) {
        Refusal::if_given(told, &counted, "beside `shading_samples`")?;
        [told.count(&SHADING_SAMPLES); 2]
    } else {
        counted.map(|property| told.count(property))
    };
    let strategy = match counts {
        [0, 0] => {
            let message =
                "integrator `direct` needs `emitter_samples` or `bsdf_samples` to be above 0";
            return Err(Refusal::new(At::Object, message));
        }
        [0, _] | [_, 0] if told.has(&STRATEGY) => {
            let name = counted[usize::from(counts[0] > 0)].name;
            let message = format!("`{name}` is 0 (expected at least 1 beside `strategy`)");
            return Err(Refusal::new(At::Value(name), message));
        }
        [0, _] => Strategy::Bsdf,
        [_, 0] => Strategy::Emitter,
        _ => chosen(told, &STRATEGY),
    };
    match strategy {
        Strategy::Bsdf if counts[0] > 0 => strategy.refuse_shadow_rays(told, &EMITTER_SAMPLES)?,
        Strategy::Emitter if counts[1] > 0 => {
            Refusal::if_given(told, &[&BSDF_SAMPLES], "if `strategy` is `emitter`")?;
        }
        _ => {}
    }
    Ok(PathSettings {
        max_depth: DEPTH,
        strategy,
        directions: chosen(told, &DIRECTIONS),
        emitter_choice: chosen(told, &EMITTER_CHOICE),
        // What a strategy does not have is asked for once: mirrors are followed by all of them.
        emitter_samples: if strategy == Strategy::Bsdf { 1 } else { counts[0] },
        bsdf_samples: if strategy == Strategy::Emitter { 1 } else { counts[1] },
        hide_emitters: told.boolean(&HIDE_EMITTERS),
        ..PathSettings::default()
    })
}
