//! Which of the emitters a shadow ray is sent to.

use super::Emitter;
use crate::math::{Choice, Discrete};

/// How one emitter is picked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChoicePolicy {
    /// All alike.
    #[default]
    Uniform,
    /// In proportion to emitted power, but none a thousand times less often than if all were alike: a dim
    /// light may be the nearest. The environment, of which no power can be told, half of the time.
    Power,
}

/// A distribution over the emitters of a scene.
#[derive(Clone, Debug)]
pub struct EmitterChoice {
    /// `None` if no emitter emits.
    distribution: Option<Discrete>,
}

impl EmitterChoice {
    /// A choice among `emitters`. An emitter without power is never chosen.
    #[must_use]
    pub fn new(policy: ChoicePolicy, emitters: &[Box<dyn Emitter>]) -> Self {
        let powers: Vec<_> = emitters.iter().map(|e| e.power()).collect();
        let inside: f64 = powers.iter().flatten().sum();
        let least = 1e-3 * inside / powers.len() as f64;
        let outside = powers.iter().filter(|p| p.is_none()).count();
        // Together as likely as all emitters inside the scene.
        let share = if inside > 0.0 { inside / outside as f64 } else { 1.0 };
        let weights: Vec<f64> = powers
            .iter()
            .map(|power| match policy {
                ChoicePolicy::Power => match power {
                    Some(power) if *power > 0.0 => power.max(least),
                    Some(_) => 0.0,
                    None => share,
                },
                ChoicePolicy::Uniform => f64::from(power.is_none_or(|p| p > 0.0)),
            })
            .collect();
        Self { distribution: Discrete::new(&weights) }
    }

    /// The index of an emitter, its probability, and `u` rescaled to `[0, 1)` for further use.
    #[must_use]
    pub fn sample(&self, u: f64) -> Option<(usize, f32, f64)> {
        let Choice { index, probability, rest } = self.distribution.as_ref()?.sample(u);
        Some((index, probability as f32, rest))
    }

    /// Probability with which `emitter` is chosen.
    #[must_use]
    pub fn probability(&self, emitter: usize) -> f32 {
        self.distribution.as_ref().map_or(0.0, |d| d.probability(emitter) as f32)
    }
}
