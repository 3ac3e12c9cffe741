//! Which settings are measured, and in which order.

use std::collections::HashSet;

use super::knobs::{KnobError, Setting};
use crate::sampler::{Independent, Sampler};

/// A knob with the values that it is to have, one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variation {
    /// Name of the knob.
    pub knob: String,
    /// At least one value.
    pub values: Vec<String>,
}

/// How several knobs are varied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Design {
    /// Every value of each with every value of the others.
    Grid,
    /// Each by itself, while the others stay as in the base.
    OneAtATime,
}

/// A setting to be measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Knobs that it turns, with their values; those that it has no use for are left out.
    pub choices: Vec<(String, String)>,
    /// What they make of the base.
    pub setting: Setting,
    /// Whether that is the base itself.
    pub is_base: bool,
    /// Whether it is the base up to the number of samples.
    pub in_base_series: bool,
}

impl Candidate {
    /// Its name: `strategy=bsdf, spp=4`, or `base`.
    #[must_use]
    pub fn label(&self) -> String {
        label(self.choices.iter())
    }

    /// The name of all that differ from it in the number of samples only.
    #[must_use]
    pub fn series(&self) -> String {
        label(self.choices.iter().filter(|(knob, _)| knob != "spp"))
    }

    /// The same with another number of samples, which is not the base.
    #[must_use]
    pub fn with_samples(&self, samples_per_pixel: u32) -> Self {
        let mut choices = self.choices.clone();
        let value = samples_per_pixel.to_string();
        match choices.iter_mut().find(|(knob, _)| knob == "spp") {
            Some((_, old)) => *old = value,
            None => choices.push(("spp".to_owned(), value)),
        }
        let setting = Setting { samples_per_pixel, ..self.setting.clone() };
        Self { choices, setting, is_base: false, ..*self }
    }
}

/// Appends those of the settings with these `labels` that `candidates` does not hold and that differ from one of
/// them in the number of samples only: what an earlier search has measured.
pub fn adopt<'a>(candidates: &mut Vec<Candidate>, labels: impl Iterator<Item = &'a str>) {
    for label in labels {
        let samples = label.split(", ").find_map(|part| part.strip_prefix("spp="));
        let Some(samples) = samples.and_then(|value| value.parse().ok()) else { continue };
        if candidates.iter().all(|c| c.label() != label) {
            let parent = candidates.iter().map(|c| c.with_samples(samples));
            let found = parent.into_iter().find(|c| c.label() == label);
            candidates.extend(found);
        }
    }
}

/// The name of the base.
pub const BASE: &str = "base";

fn label<'a>(choices: impl Iterator<Item = &'a (String, String)>) -> String {
    let parts: Vec<_> = choices.map(|(knob, value)| format!("{knob}={value}")).collect();
    if parts.is_empty() { BASE.to_owned() } else { parts.join(", ") }
}

/// The settings that `variations` make of `base`, each once, and `base` itself if it is not among them: it
/// is what the others are compared with. Where a grid varies `spp`, the base has the most samples of that.
///
/// # Errors
/// Knobs or values that there are not, that are given twice, or that no setting has a use for.
pub fn candidates(
    base: &Setting,
    variations: &[Variation],
    design: Design,
) -> Result<Vec<Candidate>, KnobError> {
    check_names(variations)?;
    let base = &with_most_samples(base, variations, design)?;
    let one = |value: &String, knob: &String| (knob.clone(), value.clone());
    let combinations: Vec<Vec<(String, String)>> = match design {
        Design::OneAtATime => {
            let all = variations.iter().flat_map(|v| v.values.iter().map(|x| one(x, &v.knob)));
            all.map(|choice| vec![choice]).collect()
        }
        Design::Grid => variations.iter().fold(vec![Vec::new()], |so_far, v| {
            let extended = |choices: &Vec<(String, String)>| {
                let choices = choices.clone();
                v.values.iter().map(move |x| {
                    let mut choices = choices.clone();
                    choices.push(one(x, &v.knob));
                    choices
                })
            };
            so_far.iter().flat_map(extended).collect()
        }),
    };
    let mut used = HashSet::new();
    let mut found: Vec<Candidate> = Vec::new();
    for choices in combinations {
        let candidate = turned(base, &choices)?;
        used.extend(candidate.choices.iter().map(|(knob, _)| knob.clone()));
        if !found.iter().any(|c| c.setting == candidate.setting) {
            found.push(candidate);
        }
    }
    if let Some(v) = variations.iter().find(|v| !used.contains(&v.knob)) {
        return Err(KnobError::no_effect(&v.knob));
    }
    if !found.iter().any(|c| c.is_base) {
        let own = variations.iter().filter(|v| v.knob == "spp" && design == Design::Grid);
        let spp = base.samples_per_pixel.to_string();
        let choices = own.map(|v| (v.knob.clone(), spp.clone())).collect();
        let (is_base, in_base_series) = (true, true);
        found.insert(0, Candidate { choices, setting: base.clone(), is_base, in_base_series });
    }
    Ok(found)
}

/// `base` with some knobs turned, in the order in which knobs are listed and not in that of `choices`.
///
/// # Errors
/// Knobs or values that there are not.
pub fn turned(base: &Setting, choices: &[(String, String)]) -> Result<Candidate, KnobError> {
    let names = super::knobs::names();
    let mut ordered: Vec<_> = choices.to_vec();
    ordered.sort_by_key(|(knob, _)| names.iter().position(|n| n == knob));
    let mut setting = base.clone();
    let mut taken = Vec::new();
    for (knob, value) in ordered {
        if setting.turn(&knob, &value)? {
            taken.push((knob, value));
        }
    }
    // As the user wrote them.
    taken.sort_by_key(|choice| choices.iter().position(|c| c == choice));
    let in_base_series = {
        let samples_per_pixel = base.samples_per_pixel;
        Setting { samples_per_pixel, ..setting.clone() } == *base
    };
    let is_base = setting == *base;
    Ok(Candidate { choices: taken, setting, is_base, in_base_series })
}

/// The base of a grid.
fn with_most_samples(
    base: &Setting,
    variations: &[Variation],
    design: Design,
) -> Result<Setting, KnobError> {
    let mut most = base.clone();
    if design == Design::Grid {
        let values = variations.iter().filter(|v| v.knob == "spp").flat_map(|v| &v.values);
        let mut samples = Vec::new();
        for value in values {
            most.turn("spp", value)?;
            samples.push(most.samples_per_pixel);
        }
        most.samples_per_pixel = samples.into_iter().max().unwrap_or(base.samples_per_pixel);
    }
    Ok(most)
}

fn check_names(variations: &[Variation]) -> Result<(), KnobError> {
    let mut seen = HashSet::new();
    for v in variations {
        if !seen.insert(&v.knob) {
            return Err(KnobError::Twice { what: format!("knob `{}`", v.knob) });
        }
        let mut values = HashSet::new();
        if let Some(twice) = v.values.iter().find(|value| !values.insert(*value)) {
            return Err(KnobError::Twice { what: format!("`{}={twice}`", v.knob) });
        }
    }
    Ok(())
}

/// One run: the index of its candidate, and which repetition of it.
pub type Slot = (usize, u32);

/// The order of all runs: in rounds of one run of each candidate, each round in an order of its own, so that
/// whatever slows the machine down for a while falls on all alike.
#[must_use]
pub fn order(candidates: usize, repeats: u32, seed: u64) -> Vec<Slot> {
    let numbers = Independent::new(seed);
    let round = |repeat: u32| {
        let path = numbers.path(0, repeat);
        let mut round: Vec<usize> = (0..candidates).collect();
        // Fisher and Yates 1938, from the end.
        for last in (1..candidates).rev() {
            let u = numbers.get_1d(path, last as u32);
            round.swap(last, ((u * (last + 1) as f32) as usize).min(last));
        }
        round.into_iter().map(move |candidate| (candidate, repeat))
    };
    (0..repeats).flat_map(round).collect()
}

/// The seed of one run: unrelated for any two of them, and the same again for the same label, so that an
/// experiment can be continued and extended.
#[must_use]
pub fn run_seed(seed: u64, label: &str, repeat: u32) -> u64 {
    // FNV-1a over the label (Fowler, Noll and Vo 1991), then the sampler's own mixing.
    let hash = label.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    // Scene files take seeds up to 2⁶³ − 1.
    Independent::new(seed ^ hash).path(0, repeat).0 >> 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::Backend;
    use crate::render::description::tests::description;

    fn base() -> Setting {
        Setting::of(&description(), Backend::Rust.into(), 1).expect("a picture")
    }

    fn vary(text: &str) -> Variation {
        let (knob, values) = text.split_once('=').expect("KNOB=VALUES");
        Variation { knob: knob.to_owned(), values: values.split(',').map(str::to_owned).collect() }
    }

    fn labels(variations: &[&str], design: Design) -> Vec<String> {
        let variations: Vec<_> = variations.iter().map(|v| vary(v)).collect();
        let found = candidates(&base(), &variations, design).expect("valid");
        found.iter().map(Candidate::label).collect()
    }

    #[test]
    fn a_grid_holds_every_combination_that_makes_sense() {
        assert_eq!(
            labels(&["strategy=bsdf,emitter", "spp=2,4"], Design::Grid),
            [
                "spp=4",
                "strategy=bsdf, spp=2",
                "strategy=bsdf, spp=4",
                "strategy=emitter, spp=2",
                "strategy=emitter, spp=4"
            ]
        );
        // The path tracer has no branches, and without other knobs it is the base; the order of the
        // knobs on the command line does not matter.
        assert_eq!(
            labels(&["branches=2,8", "integrator=path,branching"], Design::Grid),
            [
                "integrator=path",
                "branches=2, integrator=branching",
                "branches=8, integrator=branching"
            ]
        );
    }

    #[test]
    fn a_grid_of_samples_has_its_base_within() {
        let variations = [vary("strategy=mis_power,bsdf"), vary("spp=2,8,4")];
        let found = candidates(&base(), &variations, Design::Grid).expect("valid");
        let named = |what: fn(&Candidate) -> bool| -> Vec<String> {
            found.iter().filter(|c| what(c)).map(Candidate::label).collect()
        };
        assert_eq!(named(|c| c.is_base), ["strategy=mis_power, spp=8"]);
        assert_eq!(
            named(|c| c.in_base_series),
            ["strategy=mis_power, spp=2", "strategy=mis_power, spp=8", "strategy=mis_power, spp=4"]
        );
    }

    #[test]
    fn one_at_a_time_leaves_the_others_alone() {
        assert_eq!(
            labels(&["strategy=mis_power,bsdf", "spp=1,4"], Design::OneAtATime),
            // `spp=1` is the base again.
            ["strategy=mis_power", "strategy=bsdf", "spp=4"]
        );
        assert_eq!(labels(&[], Design::OneAtATime), ["base"]);
    }

    #[test]
    fn series_differ_in_more_than_samples() {
        let found = candidates(&base(), &[vary("strategy=bsdf"), vary("spp=2,4")], Design::Grid);
        let series: Vec<_> = found.expect("valid").iter().map(Candidate::series).collect();
        assert_eq!(series, ["base", "strategy=bsdf", "strategy=bsdf"]);
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let message = |variations: &[&str], design| {
            let variations: Vec<_> = variations.iter().map(|v| vary(v)).collect();
            candidates(&base(), &variations, design).expect_err("refused").to_string()
        };
        assert_eq!(
            message(&["branches=2,4"], Design::Grid),
            "knob `branches` changes nothing: only integrator `branching` has it"
        );
        assert_eq!(
            message(&["branches=2", "integrator=branching"], Design::OneAtATime),
            "knob `branches` changes nothing: only integrator `branching` has it"
        );
        assert_eq!(message(&["spp=2,4,2"], Design::Grid), "`spp=2` is given twice");
        assert_eq!(message(&["spp=2", "spp=4"], Design::Grid), "knob `spp` is given twice");
    }

    #[test]
    fn rounds_hold_each_setting_once_and_differ() {
        let order = order(7, 20, 3);
        let rounds: Vec<Vec<usize>> =
            order.chunks(7).map(|round| round.iter().map(|slot| slot.0).collect()).collect();
        for (repeat, round) in rounds.iter().enumerate() {
            let mut sorted = round.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..7).collect::<Vec<_>>());
            assert!(order[7 * repeat..][..7].iter().all(|slot| slot.1 as usize == repeat));
        }
        let distinct: HashSet<_> = rounds.iter().collect();
        // Of 5040 orders, 20 are all different with a probability of 0.96.
        assert!(distinct.len() > 17, "{rounds:?}");
        // Each setting comes first now and then.
        let first: HashSet<_> = rounds.iter().map(|round| round[0]).collect();
        assert!(first.len() > 4, "{first:?}");
        assert_eq!(super::order(7, 20, 3), order);
    }

    #[test]
    fn seeds_are_unrelated_and_repeatable() {
        let all: HashSet<u64> = ["base", "spp=2", "spp=4"]
            .iter()
            .flat_map(|label| {
                (0..8).flat_map(move |k| [run_seed(0, label, k), run_seed(1, label, k)])
            })
            .collect();
        assert_eq!(all.len(), 48);
        assert_eq!(run_seed(5, "spp=2", 3), run_seed(5, "spp=2", 3));
        assert!(all.iter().all(|&seed| seed <= i64::MAX as u64));
    }
}
