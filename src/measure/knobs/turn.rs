//! What the knobs around the integrator do.

use super::Setting;
use crate::film::Filter;
use crate::integrator::knobs::Turned;
use crate::integrator::settings::plugins;
use crate::intersect::Backend;
use crate::property::Kind;
use crate::render::MOST_THREADS;

/// The numbers of threads that can be asked for.
pub(super) const THREADS: Kind = Kind::Integer(1, MOST_THREADS as i64);

pub(super) fn spp(setting: &mut Setting, value: &str) -> Turned {
    match value.parse() {
        Ok(samples) if samples > 0 => {
            setting.samples_per_pixel = samples;
            Turned::Done
        }
        _ => Turned::Bad,
    }
}

pub(super) fn backend(setting: &mut Setting, value: &str) -> Turned {
    let Ok(backend) = value.parse::<Backend>() else {
        return Turned::Bad;
    };
    if setting.accel.backend() != backend {
        setting.accel = backend.into();
    }
    Turned::Done
}

/// What integrators have in common is kept.
pub(super) fn integrator(setting: &mut Setting, value: &str) -> Turned {
    let Some(other) = plugins().find(|p| p.name == value).and_then(|p| p.in_place_of) else {
        return Turned::Bad;
    };
    setting.integrator = other(&setting.integrator);
    Turned::Done
}

pub(super) fn sampler(setting: &mut Setting, value: &str) -> Turned {
    value.parse().map_or(Turned::Bad, |kind| {
        setting.sampler = kind;
        Turned::Done
    })
}

pub(super) fn adaptive(setting: &mut Setting, value: &str) -> Turned {
    match value.parse() {
        Ok(adaptive) => setting.adaptive = adaptive,
        Err(_) => return Turned::Bad,
    }
    Turned::Done
}

pub(super) fn clamp(setting: &mut Setting, value: &str) -> Turned {
    let clamp = above_zero(value);
    if clamp.is_none() && value != "none" {
        return Turned::Bad;
    }
    setting.clamp = clamp;
    Turned::Done
}

fn above_zero(text: &str) -> Option<f32> {
    text.parse().ok().filter(|v: &f32| *v > 0.0 && v.is_finite())
}

pub(super) fn filter(setting: &mut Setting, value: &str) -> Turned {
    Filter::parse(value).map_or(Turned::Bad, |filter| {
        setting.filter = filter;
        Turned::Done
    })
}

pub(super) fn threads(setting: &mut Setting, value: &str) -> Turned {
    THREADS.parse(value).map_or(Turned::Bad, |threads| {
        setting.threads = threads.count() as usize;
        Turned::Done
    })
}
