//! What a render has made, and what there is to say of it.

use std::time::Duration;

use telamon::film::exr::Metadata;
use telamon::film::picture::Picture;
use telamon::render::{Effort, SampleId, Statistics};

use super::effort;
use super::message::{warn, warn_with_help};
use super::progress::millions_per_second;

/// A finished render, with what its files need to know.
pub(super) struct Finished {
    pub(super) picture: Picture,
    pub(super) metadata: Metadata,
    pub(super) statistics: Statistics,
    /// Samples per pixel that were asked for.
    pub(super) asked: u32,
    /// What should end it before.
    pub(super) effort: Effort,
    pub(super) threads: usize,
}

impl Finished {
    /// One line on what was done, and how fast.
    pub(super) fn summary(&self, names: &str) -> String {
        let Self { metadata, statistics, threads, .. } = self;
        let seconds = |d: Duration| format!("{:.2} s", d.as_secs_f64());
        let errors = statistics.errors.map(|e| format!("; {}", effort::describe(&e)));
        let errors = errors.unwrap_or_default();
        format!(
            "{names}: {} samples per pixel with {} on {}{errors}; load {}, build {}, render {}; {} Mpaths/s, {} \
             Mrays/s",
            self.samples(),
            metadata.backend,
            if *threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") },
            seconds(metadata.load),
            seconds(metadata.build),
            seconds(metadata.render),
            millions_per_second(statistics.samples, statistics.elapsed),
            millions_per_second(statistics.rays.total(), statistics.elapsed),
        )
    }

    /// `"4"`; if pixels differ, the mean and the range.
    fn samples(&self) -> String {
        let (least, most) = self.statistics.samples_per_pixel;
        if least == most {
            return least.to_string();
        }
        let mean = self.statistics.samples as f64 / self.picture.pixels() as f64;
        format!("{mean:.1} ({least} to {most})")
    }

    /// Warns of numbers that should be 0.
    pub(super) fn warn(&self) {
        let statistics = &self.statistics;
        if let Some(first) = statistics.non_finite_examples.first() {
            let SampleId { x, y, sample, seed } = first;
            let text = format!(
                "samples that were not finite and are left out: {}; the first is sample {sample} of pixel {x},{y} \
                 with seed {seed}",
                statistics.non_finite
            );
            let help = format!(
                "`telamon trace` follows its path: give it the same scene, --define, --size, --backend and --accel, \
                 and --pixel {x},{y} --sample {sample} --seed {seed}"
            );
            warn_with_help(text, help);
        }
        if statistics.rays.untraceable > 0 {
            warn(format!(
                "rays that left the range of 32-bit floats and so hit nothing: {}",
                statistics.rays.untraceable
            ));
        }
    }
}

/// `"4"`, or `"3 to 4"`.
pub(super) fn samples_per_pixel((least, most): (u32, u32)) -> String {
    if least == most { least.to_string() } else { format!("{least} to {most}") }
}
