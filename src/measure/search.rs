//! Which further counts of samples tell when a series reaches an error.

use super::bench::Run;
use super::curve::{Bracket, Curve};
use super::plan::Candidate;
use super::summary::Findings;

/// Two counts whose quotient is no larger than this need none between them.
const FINEST: f64 = 1.1;
/// Where errors themselves are uncertain counts may be this far apart.
const COARSEST: f64 = 1.5;
/// How far one step goes beyond what was measured.
const STRIDE: f64 = 8.0;

/// The settings that are to be measured next so that [`Findings::reach`] knows when each series comes to
/// `target`: one more of each series that does not say so yet, with at most `most` samples. Empty if all do.
///
/// Each is between two that were measured, or beyond all of them, so that asking again with its runs comes to an
/// end. What it asks for depends on errors alone, and not on times.
#[must_use]
pub fn next(
    findings: &Findings,
    candidates: &[Candidate],
    runs: &[Run],
    target: f64,
    most: u32,
) -> Vec<Candidate> {
    let next = |label: &str| {
        let is_biased = findings.members(label).any(|s| s.bias.is_biased);
        let curve = Some(findings.curve(label, runs)).filter(|_| !is_biased)?;
        let samples = next_count(&curve, target, most)?;
        let member = candidates.iter().find(|c| c.series() == label)?;
        Some(member.with_samples(samples))
    };
    findings.series.iter().filter_map(|series| next(&series.label)).collect()
}

/// The next count of one series: where its mean error, then either end of its interval, comes to the target.
fn next_count(curve: &Curve, target: f64, most: u32) -> Option<u32> {
    let uncertainty = curve.uncertainty(target);
    // Where two runs differ widely the ends of the interval may be anywhere.
    let uncertainty = uncertainty.min(STRIDE);
    let apart = uncertainty.clamp(FINEST, COARSEST);
    let factors = [1.0, uncertainty, 1.0 / uncertainty];
    factors.into_iter().find_map(|factor| between(curve, factor, target, apart, most))
}

/// A count between the two where errors that are `factor` times as large come below the target, unless they are
/// no farther than `apart` from each other.
fn between(curve: &Curve, factor: f64, target: f64, apart: f64, most: u32) -> Option<u32> {
    let point = |index: usize| {
        (f64::from(curve.0[index].samples_per_pixel), factor * curve.0[index].rel_mse)
    };
    // As if samples were independent. How many are enough is said by those that are measured.
    let guess = |(samples, error): (f64, f64)| samples * (error / target).max(1.0 / STRIDE);
    let Bracket { above, below } = curve.bracket(factor, target);
    match (above.map(point), below.map(point)) {
        (None, Some(fewest)) => {
            let guess = (guess(fewest) / apart).floor().max(1.0);
            (fewest.0 > 1.0).then(|| guess.min(fewest.0 - 1.0) as u32)
        }
        (Some(last), None) => {
            let guess = (guess(last) * apart).min(last.0 * STRIDE).ceil().min(most.into());
            (last.0 < most.into()).then(|| guess.max(last.0 + 1.0) as u32)
        }
        (Some((a, above)), Some((b, below))) => {
            if b - a <= 1.0 || b <= a * apart {
                return None;
            }
            let share =
                if below > 0.0 { (above / target).ln() / (above / below).ln() } else { 0.5 };
            let guess = a * (b / a).powf(share);
            // Nearer to an end than counts are to be, it would leave the other where it is.
            let inset = apart.min((b / a).cbrt());
            Some(guess.clamp(a * inset, b / inset).round().clamp(a + 1.0, b - 1.0) as u32)
        }
        (None, None) => None,
    }
}
