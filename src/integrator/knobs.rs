//! What `measure` can turn of an integrator's settings.

use super::{IntegratorSettings, Settings};
use crate::property::{PropertyInfo, Value};

/// What `measure` can turn of the settings `S`.
#[derive(Debug)]
pub struct Knob<S: 'static> {
    /// The property that it is in scene files.
    pub property: &'static PropertyInfo,
    /// Why it may change nothing.
    pub needs: Needs,
    /// How it is turned.
    pub turn: Turn<S>,
}

/// Why a knob may change nothing.
#[derive(Debug)]
pub enum Needs {
    /// Only the integrators of these names have it, with what else there is to say.
    Integrators(&'static [&'static str], fn() -> String),
    /// For another reason.
    Reason(&'static str),
}

/// How a knob is turned.
#[derive(Debug)]
pub enum Turn<S: 'static> {
    /// By a value that the property takes; whether the settings have a use for it.
    Value(fn(&mut S, Value) -> bool),
    /// By what stands here in words.
    Words(&'static str, fn(&mut S, &str) -> Turned),
}

/// What became of an attempt to turn a knob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turned {
    /// It was turned.
    Done,
    /// The settings have no use for the knob.
    NoUse,
    /// It cannot have this value.
    Bad,
}

/// A knob as users see it, whatever has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Known {
    /// Its name.
    pub name: &'static str,
    /// What it can be.
    pub values: String,
    /// Why it may change nothing.
    pub needs: String,
}

impl Turned {
    /// Done, if there is a use for it.
    #[must_use]
    pub fn if_used(used: bool) -> Self {
        if used { Self::Done } else { Self::NoUse }
    }
}

/// Turns a knob of `settings`; `None` if they do not have it.
pub(super) fn turn<S: Settings>(settings: &mut S, name: &str, text: &str) -> Option<Turned> {
    let knob = S::knobs().iter().find(|k| k.property.name == name)?;
    Some(match knob.turn {
        Turn::Value(set) => match knob.property.kind.parse(text) {
            Some(value) => Turned::if_used(set(settings, value)),
            None => Turned::Bad,
        },
        Turn::Words(_, set) => set(settings, text),
    })
}

impl IntegratorSettings {
    /// Turns a knob. Those of other integrators, and values that only others take, are of no use.
    pub fn turn(&mut self, name: &str, text: &str) -> Turned {
        match self.turn_own(name, text) {
            Some(turned @ (Turned::Done | Turned::NoUse)) => turned,
            _ => {
                let mut others = Self::defaults().into_iter();
                let taken = |mut s: Self| s.turn_own(name, text).is_some_and(|t| t != Turned::Bad);
                if others.any(taken) { Turned::NoUse } else { Turned::Bad }
            }
        }
    }
}

/// What one kind of settings says of a knob.
pub(super) struct Part {
    name: &'static str,
    values: String,
    needs: &'static Needs,
}

/// What settings `S` say of their knobs.
pub(super) fn parts<S: Settings>() -> Vec<Part> {
    let part = |knob: &'static Knob<S>| Part {
        name: knob.property.name,
        values: match knob.turn {
            Turn::Value(_) => knob.property.kind.words(),
            Turn::Words(words, _) => words.to_owned(),
        },
        needs: &knob.needs,
    };
    S::knobs().iter().map(part).collect()
}

/// All knobs of integrators, those of the path tracer last, which stands first among `integrators`.
pub(super) fn known(integrators: &[Vec<Part>]) -> Vec<Known> {
    let mut known: Vec<Known> = Vec::new();
    for part in integrators.iter().rev().flatten() {
        if known.iter().any(|k| k.name == part.name) {
            continue;
        }
        let same: Vec<&Part> =
            integrators.iter().flatten().filter(|p| p.name == part.name).collect();
        known.push(Known { name: part.name, values: values(&same), needs: needs(&same) });
    }
    known
}

/// What a knob can be: what the first integrator says, with what is different with others.
fn values(parts: &[&Part]) -> String {
    let first = &parts[0].values;
    let (range, rest) = first.split_at(first.find(',').unwrap_or(first.len()));
    let others = parts[1..].iter().filter(|p| p.values != *first).map(|p| {
        let differs = p.values.strip_prefix(range).unwrap_or(&p.values).trim_start();
        format!(" ({differs} for {})", integrators(&owners(&[p])))
    });
    let others: String = others.collect();
    if others.is_empty() { first.clone() } else { format!("{range}{others}{rest}") }
}

fn needs(parts: &[&Part]) -> String {
    if let Needs::Reason(reason) = parts[0].needs {
        return (*reason).to_owned();
    }
    let owners = owners(parts);
    let have = if owners.len() == 1 { "has" } else { "have" };
    let more = parts.iter().map(|p| match p.needs {
        Needs::Integrators(_, more) => more(),
        Needs::Reason(_) => String::new(),
    });
    format!("only {} {have} it{}", integrators(&owners), more.collect::<String>())
}

/// The names of the integrators that have a knob.
fn owners(parts: &[&Part]) -> Vec<&'static str> {
    let names = parts.iter().flat_map(|p| match p.needs {
        Needs::Integrators(names, _) => *names,
        Needs::Reason(_) => &[],
    });
    names.copied().collect()
}

/// `` integrators `a`, `b` and `c` ``
fn integrators(names: &[&str]) -> String {
    let quoted: Vec<_> = names.iter().map(|n| format!("`{n}`")).collect();
    match quoted.split_last() {
        Some((last, [])) => format!("integrator {last}"),
        Some((last, before)) => format!("integrators {} and {last}", before.join(", ")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::settings::known_knobs;
    use crate::integrator::{BranchingSettings, PathSettings};

    /// Every knob as users see it, put together from what each integrator says.
    #[test]
    fn knobs_say_what_they_can_be_and_who_has_them() {
        let both = "only integrators `path` and `direct` have it";
        let expected = [
            (
                "max_depth",
                "a whole number from 0 (to 32 for integrator `branching`), or -1 for no limit",
                "only integrators `path` and `branching` have it, and the latter a limit up to 32",
            ),
            ("branches", "a whole number from 1 to 65536", "only integrator `branching` has it"),
            (
                "directions",
                "one of: bsdf, cosine, uniform",
                "integrator `direct_uniform` has only one way",
            ),
            ("strategy", "one of: mis_power, mis_balance, bsdf, emitter", both),
            ("emitter_choice", "one of: uniform, power, bvh, ris", both),
            (
                "emitter_samples",
                "a whole number from 1 to 65536",
                "only integrators `path` and `direct` have it, unless `strategy=bsdf`",
            ),
            (
                "rr_policy",
                "none, throughput, or fixed:P with a probability P above 0, up to 1",
                both,
            ),
            ("rr_max_survival", "a number above 0, up to 1", "only `rr_policy=throughput` has it"),
            ("rr_factor", "a number of 1 or above", "only `rr_policy=throughput` has it"),
            (
                "rr_depth",
                "a whole number from 0",
                "only `rr_policy=throughput` and `rr_policy=fixed:P` have it",
            ),
        ];
        let known = known_knobs();
        let found = expected.map(|(name, ..)| {
            let knob = known.iter().find(|k| k.name == name);
            knob.map(|k| (k.name, k.values.as_str(), k.needs.as_str()))
        });
        assert_eq!(found, expected.map(Some));
    }

    /// A value that another integrator takes is not wrong, but of no use.
    #[test]
    fn values_of_other_integrators_are_of_no_use() {
        let mut path = IntegratorSettings::from(PathSettings::default());
        let mut branching = IntegratorSettings::from(BranchingSettings::default());
        for (knob, value, by_path, by_branching) in [
            ("max_depth", "32", Turned::Done, Turned::Done),
            ("max_depth", "33", Turned::Done, Turned::NoUse),
            ("max_depth", "-1", Turned::Done, Turned::NoUse),
            ("max_depth", "-2", Turned::Bad, Turned::Bad),
            ("branches", "2", Turned::NoUse, Turned::Done),
            ("branches", "65537", Turned::Bad, Turned::Bad),
            ("strategy", "bsdf", Turned::Done, Turned::NoUse),
            ("emitter_samples", "2", Turned::NoUse, Turned::NoUse),
            ("emitter_samples", "0", Turned::Bad, Turned::Bad),
            ("rr_policy", "none", Turned::Done, Turned::NoUse),
            ("rr_depth", "3", Turned::NoUse, Turned::NoUse),
            ("rr_depth", "x", Turned::Bad, Turned::Bad),
        ] {
            assert_eq!(path.turn(knob, value), by_path, "{knob}={value}");
            assert_eq!(branching.turn(knob, value), by_branching, "{knob}={value}");
        }
    }
}
