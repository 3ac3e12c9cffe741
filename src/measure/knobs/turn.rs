//! What each knob does.

use super::{Setting, Turn};
use crate::emitter::ChoicePolicy;
use crate::film::Filter;
use crate::integrator::{
    DirectionSampling, IntegratorSettings, MisHeuristic, PathSettings, Roulette, RoulettePolicy,
    Strategy,
};
use crate::intersect::Backend;

impl Setting {
    fn path(&mut self) -> Option<&mut PathSettings> {
        match &mut self.integrator {
            IntegratorSettings::Path(path) => Some(path),
            _ => None,
        }
    }

    /// Calls `set` on the path tracer, if it is one.
    fn on_path(&mut self, set: impl FnOnce(&mut PathSettings)) -> Turn {
        self.path().map(set).map_or(Turn::NoUse, |()| Turn::Done)
    }
}

pub(super) fn spp(setting: &mut Setting, value: &str) -> Turn {
    match value.parse() {
        Ok(samples) if samples > 0 => {
            setting.samples_per_pixel = samples;
            Turn::Done
        }
        _ => Turn::Bad,
    }
}

pub(super) fn backend(setting: &mut Setting, value: &str) -> Turn {
    let Ok(backend) = value.parse::<Backend>() else {
        return Turn::Bad;
    };
    if setting.accel.backend() != backend {
        setting.accel = backend.into();
    }
    Turn::Done
}

/// What integrators have in common is kept.
pub(super) fn integrator(setting: &mut Setting, value: &str) -> Turn {
    use IntegratorSettings as I;
    let (depth, directions, hide_emitters) = match setting.integrator {
        I::Path(ref p) => (p.max_depth, p.directions, p.hide_emitters),
        I::Branching { max_depth, directions, hide_emitters, .. } => {
            (Some(max_depth), directions, hide_emitters)
        }
        I::DirectUniform { hide_emitters } => (None, DirectionSampling::Bsdf, hide_emitters),
        I::AmbientOcclusion { .. } | I::Aov { .. } => (None, DirectionSampling::Bsdf, false),
    };
    let path = match setting.integrator {
        I::Path(path) => path,
        _ => PathSettings { max_depth: depth, directions, hide_emitters, ..Default::default() },
    };
    setting.integrator = match value {
        "path" => I::Path(path),
        "direct" => I::Path(PathSettings { max_depth: Some(2), ..path }),
        "direct_uniform" => I::DirectUniform { hide_emitters },
        "branching" => match setting.integrator {
            I::Branching { .. } => setting.integrator.clone(),
            _ => {
                let max_depth = depth.unwrap_or(3).min(DEEPEST_BRANCHING);
                I::Branching { branches: 4, max_depth, directions, hide_emitters }
            }
        },
        _ => return Turn::Bad,
    };
    Turn::Done
}

/// As scene files have it: beyond, not even one sample would end.
const DEEPEST_BRANCHING: u32 = 32;

pub(super) fn max_depth(setting: &mut Setting, value: &str) -> Turn {
    let limit = match value.parse::<i32>() {
        Ok(-1) => None,
        Ok(depth) if depth >= 0 => Some(depth.unsigned_abs()),
        _ => return Turn::Bad,
    };
    match (&mut setting.integrator, limit) {
        (IntegratorSettings::Path(path), _) => {
            path.max_depth = limit;
            Turn::Done
        }
        (IntegratorSettings::Branching { max_depth, .. }, Some(limit))
            if limit <= DEEPEST_BRANCHING =>
        {
            *max_depth = limit;
            Turn::Done
        }
        _ => Turn::NoUse,
    }
}

pub(super) fn emitter_samples(setting: &mut Setting, value: &str) -> Turn {
    let Ok(count @ 1..=65_536) = value.parse() else {
        return Turn::Bad;
    };
    match setting.path() {
        Some(path) if path.strategy != Strategy::Bsdf => {
            path.emitter_samples = count;
            Turn::Done
        }
        _ => Turn::NoUse,
    }
}

pub(super) fn branches(setting: &mut Setting, value: &str) -> Turn {
    match (value.parse(), &mut setting.integrator) {
        (Ok(count @ 1..=65_536), IntegratorSettings::Branching { branches, .. }) => {
            *branches = count;
            Turn::Done
        }
        (Ok(1..=65_536), _) => Turn::NoUse,
        _ => Turn::Bad,
    }
}

pub(super) fn directions(setting: &mut Setting, value: &str) -> Turn {
    let chosen = match value {
        "bsdf" => DirectionSampling::Bsdf,
        "cosine" => DirectionSampling::CosineHemisphere,
        "uniform" => DirectionSampling::UniformHemisphere,
        _ => return Turn::Bad,
    };
    match &mut setting.integrator {
        IntegratorSettings::Path(PathSettings { directions, .. })
        | IntegratorSettings::Branching { directions, .. } => {
            *directions = chosen;
            Turn::Done
        }
        _ => Turn::NoUse,
    }
}

pub(super) fn strategy(setting: &mut Setting, value: &str) -> Turn {
    let strategy = match value {
        "mis_power" => Strategy::Mis(MisHeuristic::Power),
        "mis_balance" => Strategy::Mis(MisHeuristic::Balance),
        "bsdf" => Strategy::Bsdf,
        "emitter" => Strategy::Emitter,
        _ => return Turn::Bad,
    };
    setting.on_path(|path| path.strategy = strategy)
}

pub(super) fn emitter_choice(setting: &mut Setting, value: &str) -> Turn {
    let choice = match value {
        "uniform" => ChoicePolicy::Uniform,
        "power" => ChoicePolicy::Power,
        "bvh" => ChoicePolicy::Bvh,
        _ => return Turn::Bad,
    };
    setting.on_path(|path| path.emitter_choice = choice)
}

/// Each with the largest probability that scene files give it.
pub(super) fn rr_policy(setting: &mut Setting, value: &str) -> Turn {
    let Roulette { max_survival, .. } = Roulette::default();
    let fixed = value.strip_prefix("fixed:").and_then(probability).map(RoulettePolicy::Fixed);
    let (policy, max_survival) = match (value, fixed) {
        ("none", _) => (RoulettePolicy::None, max_survival),
        ("throughput", _) => (RoulettePolicy::Throughput, max_survival),
        (_, Some(fixed)) => (fixed, 1.0),
        _ => return Turn::Bad,
    };
    setting.on_path(|path| {
        // A policy that stays keeps what the scene says of it.
        if path.roulette.policy != policy {
            path.roulette = Roulette { policy, max_survival, ..path.roulette };
        }
    })
}

fn probability(value: &str) -> Option<f32> {
    value.parse().ok().filter(|p| *p > 0.0 && *p <= 1.0)
}

pub(super) fn rr_max_survival(setting: &mut Setting, value: &str) -> Turn {
    let Some(p) = probability(value) else {
        return Turn::Bad;
    };
    match setting.path().map(|path| &mut path.roulette) {
        Some(roulette) if roulette.policy == RoulettePolicy::Throughput => {
            roulette.max_survival = p;
            Turn::Done
        }
        _ => Turn::NoUse,
    }
}

pub(super) fn rr_depth(setting: &mut Setting, value: &str) -> Turn {
    // As far as scene files go.
    let Some(depth) = value.parse::<i32>().ok().and_then(|d| u32::try_from(d).ok()) else {
        return Turn::Bad;
    };
    match setting.path().map(|path| &mut path.roulette) {
        Some(roulette) if roulette.policy != RoulettePolicy::None => {
            roulette.min_depth = depth;
            Turn::Done
        }
        _ => Turn::NoUse,
    }
}

pub(super) fn sampler(setting: &mut Setting, value: &str) -> Turn {
    value.parse().map_or(Turn::Bad, |kind| {
        setting.sampler = kind;
        Turn::Done
    })
}

pub(super) fn adaptive(setting: &mut Setting, value: &str) -> Turn {
    match value.parse() {
        Ok(adaptive) => setting.adaptive = adaptive,
        Err(_) => return Turn::Bad,
    }
    Turn::Done
}

pub(super) fn clamp(setting: &mut Setting, value: &str) -> Turn {
    let clamp = above_zero(value);
    if clamp.is_none() && value != "none" {
        return Turn::Bad;
    }
    setting.clamp = clamp;
    Turn::Done
}

fn above_zero(text: &str) -> Option<f32> {
    text.parse().ok().filter(|v: &f32| *v > 0.0 && v.is_finite())
}

pub(super) fn filter(setting: &mut Setting, value: &str) -> Turn {
    let filter = match value.split_once(':').map(|(name, text)| (name, above_zero(text))) {
        None if value == "box" => Some(Filter::Box),
        Some(("tent", Some(radius))) => Some(Filter::Tent { radius }),
        Some(("gaussian", Some(stddev))) => Some(Filter::Gaussian { stddev }),
        _ => None,
    };
    filter.map_or(Turn::Bad, |filter| {
        setting.filter = filter;
        Turn::Done
    })
}

pub(super) fn threads(setting: &mut Setting, value: &str) -> Turn {
    match value.parse() {
        Ok(threads @ 1..=1024) => {
            setting.threads = threads;
            Turn::Done
        }
        _ => Turn::Bad,
    }
}
