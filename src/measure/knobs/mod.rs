//! What an experiment can turn, under the names that scene files have for it. The knobs of an integrator stand in its
//! own file.

mod turn;

use crate::film::Filter;
use crate::integrator::IntegratorSettings;
use crate::integrator::knobs::{Known, Turned};
use crate::integrator::settings::{known_knobs, plugins};
use crate::intersect::accel::{Mode, UnknownMode};
use crate::intersect::{Accel, Backend};
use crate::property::Kind;
use crate::render::{Description, Effort};
use crate::sampler::SamplerKind;

/// How a scene is rendered: all that knobs can turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    /// How light is carried; never layers, which are not measured.
    pub integrator: IntegratorSettings,
    /// Kind of the random numbers.
    pub sampler: SamplerKind,
    /// Samples per pixel.
    pub samples_per_pixel: u32,
    /// What larger samples are scaled down to.
    pub clamp: Option<f32>,
    /// Whether noisy parts of the picture get more samples than others.
    pub adaptive: bool,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Engine and its modes.
    pub accel: Accel,
    /// Threads.
    pub threads: usize,
}

/// Why a knob cannot be turned as asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KnobError {
    /// The scene makes no picture.
    #[error("the scene makes layers but no picture, and layers have no noise to be measured")]
    NoPicture,
    /// No knob has this name.
    #[error("there is no knob `{name}` (expected one of: {})", names().join(", "))]
    Unknown {
        /// The name.
        name: String,
    },
    /// The knob cannot have this value.
    #[error("knob `{name}` cannot be `{value}` (expected {expected})")]
    Value {
        /// The knob.
        name: String,
        /// The value.
        value: String,
        /// What it can be.
        expected: String,
    },
    /// No setting of the experiment has a use for the knob.
    #[error("knob `{name}` changes nothing: {reason}")]
    NoEffect {
        /// The knob.
        name: String,
        /// Why.
        reason: String,
    },
    /// A knob is named twice, or a value of it.
    #[error("{what} is given twice")]
    Twice {
        /// Knob, or knob and value.
        what: String,
    },
}

impl KnobError {
    /// No setting has a use for the knob.
    #[must_use]
    pub fn no_effect(name: &str) -> Self {
        let knob = knobs().into_iter().find(|k| k.name == name);
        let reason = knob.map_or("the engine has no such mode".to_owned(), |k| k.needs);
        Self::NoEffect { name: name.to_owned(), reason }
    }
}

/// A knob of the render around its integrator.
struct Knob {
    name: &'static str,
    /// What it can be.
    values: Words,
    set: fn(&mut Setting, &str) -> Turned,
}

/// Words for a message.
type Words = fn() -> String;

/// The knobs that are turned first, in this order.
static FIRST: &[Knob] = &[
    Knob { name: "spp", values: || "a whole number from 1".to_owned(), set: turn::spp },
    Knob { name: "backend", values: || one_of(backends()), set: turn::backend },
    Knob { name: "integrator", values: || one_of(integrators()), set: turn::integrator },
];

/// The knobs that are turned last.
static LAST: &[Knob] = &[
    Knob { name: "sampler", values: || one_of(samplers()), set: turn::sampler },
    Knob {
        name: "clamp",
        values: || "none, or a radiance above 0 that larger samples are scaled down to".to_owned(),
        set: turn::clamp,
    },
    Knob { name: "adaptive", values: || Kind::Boolean.words(), set: turn::adaptive },
    Knob { name: "filter", values: Filter::words, set: turn::filter },
    Knob { name: "threads", values: || turn::THREADS.words(), set: turn::threads },
];

fn one_of(names: impl Iterator<Item = &'static str>) -> String {
    format!("one of: {}", names.collect::<Vec<_>>().join(", "))
}

fn backends() -> impl Iterator<Item = &'static str> {
    Backend::AVAILABLE.iter().map(|backend| backend.name())
}

fn samplers() -> impl Iterator<Item = &'static str> {
    SamplerKind::ALL.iter().map(|kind| kind.name())
}

/// Those that make the same picture.
fn integrators() -> impl Iterator<Item = &'static str> {
    plugins().filter(|plugin| plugin.in_place_of.is_some()).map(|plugin| plugin.name)
}

/// The knobs, in the order in which they are turned: the integrator before its properties. After them come
/// the modes of the engines ([`Accel::modes`]).
#[must_use]
pub fn knobs() -> Vec<Known> {
    let known = |k: &Knob| Known { name: k.name, values: (k.values)(), needs: String::new() };
    let mut knobs: Vec<Known> = FIRST.iter().map(known).collect();
    knobs.extend(known_knobs());
    knobs.extend(LAST.iter().map(known));
    knobs
}

/// Names of all knobs: those of [`knobs`], then those of the engines' modes.
#[must_use]
pub fn names() -> Vec<&'static str> {
    let mut names: Vec<_> = knobs().iter().map(|k| k.name).collect();
    for &backend in Backend::AVAILABLE {
        for (key, _) in Accel::modes(backend) {
            if !names.contains(&key) {
                names.push(key);
            }
        }
    }
    names
}

impl Setting {
    /// How the scene itself is rendered by default: with `accel` on `threads` threads.
    ///
    /// # Errors
    /// [`KnobError::NoPicture`].
    pub fn of(description: &Description, accel: Accel, threads: usize) -> Result<Self, KnobError> {
        Ok(Self {
            integrator: description.integrator.picture().cloned().ok_or(KnobError::NoPicture)?,
            sampler: description.sampler.kind,
            samples_per_pixel: description.sampler.samples_per_pixel,
            clamp: description.film.clamp,
            adaptive: description.effort.adaptive,
            filter: description.film.filter,
            accel,
            threads,
        })
    }

    /// Makes `description` one that is rendered in this way, with random numbers of `seed`. Engine and
    /// threads are no part of it.
    pub fn apply(&self, description: &mut Description, seed: u64) {
        description.integrator.clone_from(&self.integrator);
        description.sampler.kind = self.sampler;
        description.sampler.samples_per_pixel = self.samples_per_pixel;
        description.sampler.seed = seed;
        description.film.clamp = self.clamp;
        description.effort = Effort { adaptive: self.adaptive, ..Effort::default() };
        description.film.filter = self.filter;
    }

    /// Turns a knob; whether the setting has a use for it.
    ///
    /// # Errors
    /// A knob that there is not, or a value that it cannot have.
    pub fn turn(&mut self, name: &str, value: &str) -> Result<bool, KnobError> {
        let own = FIRST.iter().chain(LAST).find(|k| k.name == name);
        let Some(known) = knobs().into_iter().find(|k| k.name == name) else {
            return self.turn_mode(name, value);
        };
        let turned = match own {
            Some(knob) => (knob.set)(self, value),
            None => self.integrator.turn(name, value),
        };
        match turned {
            Turned::Done => Ok(true),
            Turned::NoUse => Ok(false),
            Turned::Bad => Err(bad(name, value, &known.values)),
        }
    }

    /// A mode of an engine, as a knob. It is of no use to the engines that do not have it.
    fn turn_mode(&mut self, name: &str, value: &str) -> Result<bool, KnobError> {
        let mode = Mode { key: name.to_owned(), value: value.to_owned() };
        let mut known = false;
        for &backend in Backend::AVAILABLE {
            match Accel::from(backend).set(&mode) {
                Ok(()) => known = true,
                Err(UnknownMode::Value { expected, .. }) => {
                    return Err(bad(name, value, &format!("one of: {}", expected.join(", "))));
                }
                Err(UnknownMode::Key { .. }) => {}
            }
        }
        if !known {
            return Err(KnobError::Unknown { name: name.to_owned() });
        }
        Ok(self.accel.set(&mode).is_ok())
    }
}

fn bad(name: &str, value: &str, expected: &str) -> KnobError {
    KnobError::Value {
        name: name.to_owned(),
        value: value.to_owned(),
        expected: expected.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::{
        BranchingSettings, DirectionSampling, PathSettings, Roulette, RoulettePolicy,
    };
    use crate::render::description::tests::description;

    fn setting() -> Setting {
        Setting::of(&description(), Backend::Rust.into(), 2).expect("a picture")
    }

    fn path(setting: &Setting) -> PathSettings {
        match setting.integrator {
            IntegratorSettings::Path(path) => path,
            _ => panic!("not the path tracer"),
        }
    }

    /// Two values of each knob, on a setting that has a use for it: each changes the setting, and not as the
    /// other does.
    #[test]
    fn every_knob_has_an_effect() {
        let values = |name: &str| match name {
            "spp" => ["16", "32"],
            "backend" => ["rust", "rust"],
            "integrator" => ["direct_uniform", "branching"],
            "max_depth" => ["4", "2"],
            "branches" => ["2", "8"],
            "directions" => ["cosine", "uniform"],
            "strategy" => ["emitter", "mis_balance"],
            "emitter_choice" => ["power", "bvh"],
            "emitter_samples" => ["2", "8"],
            "rr_policy" => ["none", "fixed:0.5"],
            "rr_max_survival" => ["0.5", "0.25"],
            "rr_factor" => ["1", "2"],
            "rr_depth" => ["0", "7"],
            "sampler" => ["independent", "sobol"],
            "clamp" => ["3", "0.5"],
            "adaptive" => ["true", "false"],
            "filter" => ["tent:1", "gaussian:0.5"],
            "threads" => ["1", "4"],
            mode => Accel::modes(Backend::Rust)
                .iter()
                .find(|(key, _)| *key == mode)
                .map_or(["", ""], |(_, values)| [values[0], values[1]]),
        };
        for name in names() {
            let mut base = setting();
            if name == "branches" {
                assert_eq!(base.turn("integrator", "branching"), Ok(true));
            }
            let [first, second] = values(name);
            if first.is_empty() {
                // A mode of the other engine, which this one has no use for.
                let embree = Accel::modes(Backend::AVAILABLE[0]);
                let (_, values) = embree.iter().find(|(key, _)| *key == name).expect("a mode");
                assert_eq!(base.clone().turn(name, values[0]), Ok(false), "{name}");
                continue;
            }
            let turned = |value: &str| {
                let mut turned = base.clone();
                assert_eq!(turned.turn(name, value), Ok(true), "{name}={value}");
                turned
            };
            assert!(first == second || turned(first) != turned(second), "{name}");
        }
    }

    #[test]
    fn errors_list_what_is_known() {
        let mut s = setting();
        let mut message =
            |name: &str, value: &str| s.turn(name, value).expect_err("refused").to_string();
        assert_eq!(
            message("stratgy", "bsdf"),
            format!("there is no knob `stratgy` (expected one of: {})", names().join(", "))
        );
        assert_eq!(
            message("strategy", "lights"),
            "knob `strategy` cannot be `lights` (expected one of: mis_power, mis_balance, bsdf, emitter)"
        );
        assert_eq!(
            message("triangle", "exact"),
            "knob `triangle` cannot be `exact` (expected one of: watertight, plain)"
        );
        assert_eq!(
            message("sampler", "halton"),
            "knob `sampler` cannot be `halton` (expected one of: independent, sobol)"
        );
        for (name, value) in [
            ("spp", "0"),
            ("spp", "1.5"),
            ("max_depth", "-2"),
            ("branches", "0"),
            ("emitter_samples", "0"),
            ("emitter_samples", "65537"),
            ("rr_policy", "fixed"),
            ("rr_policy", "fixed:NaN"),
            ("rr_policy", "fixed:1.01"),
            ("rr_max_survival", "0"),
            ("rr_factor", "0.9"),
            ("rr_depth", "-1"),
            ("clamp", "0"),
            ("clamp", "inf"),
            ("adaptive", "yes"),
            ("filter", "tent"),
            ("filter", "box:1"),
            ("filter", "gaussian:inf"),
            ("threads", "1025"),
            ("integrator", "ao"),
        ] {
            assert!(message(name, value).contains("cannot be"), "{name}={value}");
        }
    }

    #[test]
    fn what_integrators_have_in_common_is_kept() {
        let mut s = setting();
        for (name, value) in
            [("max_depth", "3"), ("directions", "cosine"), ("integrator", "branching")]
        {
            assert_eq!(s.turn(name, value), Ok(true));
        }
        let expected = IntegratorSettings::Branching(BranchingSettings {
            branches: 4,
            max_depth: 3,
            directions: DirectionSampling::CosineHemisphere,
            hide_emitters: false,
        });
        assert_eq!(s.integrator, expected);
        assert_eq!(s.turn("strategy", "emitter"), Ok(false));
        assert_eq!(s.turn("max_depth", "-1"), Ok(false));
        assert_eq!(s.turn("integrator", "path"), Ok(true));
        assert_eq!(path(&s).max_depth, Some(3));
        assert_eq!(path(&s).directions, DirectionSampling::CosineHemisphere);
    }

    #[test]
    fn roulette_is_put_together() {
        let mut s = setting();
        assert_eq!(s.turn("rr_policy", "fixed:0.5"), Ok(true));
        let policy = RoulettePolicy::Fixed(0.5);
        let fixed = Roulette { policy, max_survival: 1.0, ..Roulette::default() };
        assert_eq!(path(&s).roulette, fixed);
        assert_eq!(s.turn("rr_max_survival", "0.5"), Ok(false));
        assert_eq!(s.turn("rr_factor", "2"), Ok(false));
        assert_eq!(s.turn("rr_policy", "throughput"), Ok(true));
        assert_eq!(path(&s).roulette, Roulette::default());
        assert_eq!(s.turn("rr_max_survival", "0.5"), Ok(true));
        assert_eq!(s.turn("rr_policy", "throughput"), Ok(true));
        assert_eq!(path(&s).roulette.max_survival, 0.5);
    }
}
