//! Options that end a render early, and what is said of them in the end.

use std::time::Duration;

use clap::Args;
use telamon::film::error::Estimate;
use telamon::render::requirements::Feature;
use telamon::render::{Description, Effort, Ended, Errors, FIRST_ALLOCATION, Requirements};

use super::message::warn;
use super::values;

/// Samples per pixel at most where nothing says how many: as many as a film can sum without loss if the
/// time is limited, and fewer if the error alone ends the render, which it may not do at all.
const MOST_IN_TIME: u32 = 1 << 20;
const MOST: u32 = 1 << 16;

#[derive(Args, Debug)]
pub(super) struct Options {
    /// Samples per pixel, with --time, --error or --noise-level at most [default: the scene's, and for a
    /// mesh as many, up to 256, as --error 0.000625 takes; with --time 1048576, with --error or
    /// --noise-level alone 65536]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..),
        help_heading = "Sampling"
    )]
    spp: Option<u32>,

    /// Render for this long, such as 90s, 5m or 1.5h
    #[arg(
        long,
        value_name = "TIME",
        value_parser = values::time,
        help_heading = "Sampling",
        long_help = "Render for this long, such as 90s, 5m or 1.5h. Loading the scene and building the \
                     engine come on top. Each pixel gets as many samples as every other, at least one."
    )]
    time: Option<Duration>,

    /// Render until the relMSE is at most this, such as 0.01
    #[arg(
        long,
        value_name = "RELMSE",
        value_parser = values::positive,
        help_heading = "Sampling",
        long_help = "Render until the relMSE is at most this, such as 0.01, in 95 of 100 pictures or more. \
                     It is the mean over pixels and channels of (I - R)^2 / (R^2 + 0.01) with the \
                     picture's value I and the true value R, estimated from the picture's two independent \
                     halves. Light that no sample has met so far cannot be in the estimate.\n\
                     What is made of a mesh asks for 0.000625 by itself: noise of 1/40 of the signal, the \
                     square root, is what viewers of prints called excellent for ISO 12232. 0.01, noise of \
                     1/10, was acceptable to them."
    )]
    error: Option<f64>,

    /// Render until 95 % of the pixels are this near to their true value, such as 0.05
    #[arg(
        long,
        value_name = "LEVEL",
        value_parser = values::positive,
        help_heading = "Sampling",
        long_help = "Render until 95 % of the pixels are this near to their true value, such as 0.05. What \
                     counts is the root of a pixel's (I - R)^2 / (R^2 + 0.01), averaged over the channels; \
                     see --error. Unlike the relMSE it does not depend on a few very noisy pixels. The \
                     picture must have 103 pixels or more."
    )]
    noise_level: Option<f64>,

    /// Give noisy parts of the picture more samples than others, at the same number on average; begins
    /// after 16 samples per pixel
    #[arg(
        long,
        help_heading = "Sampling",
        long_help = "Give noisy parts of the picture more samples than others, at the same number on \
                     average; begins after 16 samples per pixel. Parts are tiles of 16x16 pixels, and get a \
                     quarter of the average up to 8 times it. The picture stays unbiased, since each half \
                     of the samples goes where the other half found noise."
    )]
    adaptive: bool,
}

/// An error is to be reached of a scene that has none.
#[derive(Debug, thiserror::Error)]
#[error(
    "`--error`, `--noise-level` and `--adaptive` need a picture, and the scene makes layers alone"
)]
pub(super) struct NoPicture;

impl Options {
    /// Puts options in the place of the scene's own settings.
    pub(super) fn adjust(&self, description: &mut Description) -> Result<(), NoPicture> {
        let Self { spp, time, error, noise_level, adaptive } = *self;
        let asked = Effort { time, error, noise_level, ..Effort::default() };
        let of_scene = description.effort;
        let none_asked = spp.is_none() && asked == Effort::default();
        description.effort = Effort { adaptive, ..if none_asked { of_scene } else { asked } };
        let default = match (time, asked.needs_error()) {
            (Some(_), _) => MOST_IN_TIME,
            (None, true) => MOST,
            (None, false) => description.sampler.samples_per_pixel,
        };
        let most = spp.unwrap_or(default);
        description.sampler.samples_per_pixel = most;
        let modelled = Requirements::of(description).models(Feature::Variance);
        if description.effort.needs_halves() && !modelled {
            return Err(NoPicture);
        }
        if adaptive && most <= FIRST_ALLOCATION {
            warn(format!(
                "`--adaptive` changes nothing: it begins after {FIRST_ALLOCATION} samples per pixel"
            ));
        }
        Ok(())
    }
}

/// What a render that ended before its picture was good enough has to be told of.
pub(super) fn shortfall(asked: &Effort, ended: Ended, errors: Option<Errors>) -> Option<String> {
    let ended = match ended {
        Ended::Samples => "all samples were taken",
        Ended::Time => "the time was over",
        Ended::Error | Ended::Cancelled => return None,
    };
    let Errors { rel_mse, noise_level } = errors?;
    let parts = [("relMSE", rel_mse, asked.error), ("noise level", noise_level, asked.noise_level)];
    let missed = parts.into_iter().filter_map(|(name, estimate, asked)| {
        let asked = asked.filter(|&a| estimate.bound > a)?;
        Some(format!("the {name} is at most {}, not {asked}", significant(estimate.bound)))
    });
    let missed: Vec<_> = missed.collect();
    (!missed.is_empty())
        .then(|| format!("{ended} before the picture was good enough: {}", missed.join(", ")))
}

/// For the line that sums up a render.
pub(super) fn describe(errors: &Errors) -> String {
    let describe = |Estimate { value, bound }| {
        format!("{} (at most {})", significant(value), significant(bound))
    };
    let Errors { rel_mse, noise_level } = *errors;
    format!("relMSE {}, noise level {}", describe(rel_mse), describe(noise_level))
}

/// With three digits that count.
fn significant(value: f64) -> String {
    if !value.is_finite() {
        return "unknown".to_owned();
    }
    let magnitude = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    let decimals = (2.0 - magnitude).clamp(0.0, 12.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0.00"),
            (0.012_345, "0.0123"),
            (9.876e-5, "0.0000988"),
            (1234.5, "1234"),
            (1.0, "1.00"),
            (f64::INFINITY, "unknown"),
        ] {
            assert_eq!(significant(value), text);
        }
    }
}
