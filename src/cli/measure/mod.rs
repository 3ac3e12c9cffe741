//! `telamon measure`.

mod experiment;
mod reference;
mod shown;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use telamon::film::Crop;
use telamon::measure::bench::{Bench, mean_error};
use telamon::measure::knobs::{KnobError, Setting};
use telamon::measure::plan::{self, Candidate, Design, Variation};
use telamon::measure::record::{Record, ReferenceOrigin};
use telamon::measure::store::Store;
use telamon::measure::summary::Findings;
use telamon::measure::{Image, crops, report, search};
use telamon::memory::{Limits, OutOfMemory};
use telamon::render::Description;

use super::definitions::METRICS;
use super::machine::{self, ProcessMemory};
use super::message::{Failure, say, warn};
use super::progress::Runs;
use super::values::{self, Size};
use super::{Ending, Input, interrupt, print};
use experiment::Experiment;
use shown::{knobs_help, message, remaining, rows};

const HELP: &str = "Ctrl-C stops and keeps what was measured; with --report the same command goes on from there.\n\n\
                    Example: telamon measure scene.xml --vary strategy=bsdf,emitter,mis_power --vary spp=4,8,16,32 \
                    --report trade";

/// Measure what settings cost and what they give, on a scene of your own
#[derive(Args, Debug)]
#[command(
    after_help = HELP,
    after_long_help = format!(
        "{METRICS}\n\nOver the seeds of a setting: ± is the sample standard deviation, brackets are 95 % intervals \
         (bootstrap) and for times the fastest and the slowest run. RMSE, relMSE and efficiency are without the \
         reference's own noise; an error of less than half of that counts as the half, and ≥ stands before the \
         efficiency. A setting is biased if Student's t-test of its mean differences rejects chance (0.01 for all \
         settings together, after Sidak; the reference's error counts, and independent samples are as noisy as where \
         their series is noisiest) and they are more than 1e-6 of the reference's mean, which rounding explains; light \
         that none of its samples has met counts as bias. Efficiency is 1/(MSE * seconds), or 1/(trimmed * seconds), over \
         that of the base with as many samples; Welch's t-test of its logarithm tells settings apart (0.01 for \
         all). The first sentence is about the fewest samples that were measured and enough; in brackets are the \
         fewest and the most that it may take (Student's t over seeds), of which the most were measured too. What \
         takes more than was measured is said to, with what the slope and its error over three numbers of samples \
         or more leave. The slope is that of log RMSE over log samples, -0.5 for an unbiased estimator with independent \
         samples.\n\n{HELP}"
    )
)]
pub(super) struct Arguments {
    #[command(flatten)]
    input: Input,

    /// Knob to vary, with the values that it is to have; may be repeated
    #[arg(
        long,
        value_name = "KNOB=V1,V2,…",
        value_parser = values::variation,
        help_heading = "Experiment",
        long_help = knobs_help()
    )]
    vary: Vec<Variation>,

    /// Set a knob for all settings, the reference among them; may be repeated [default: as in the scene,
    /// but spp=16 where more of them end with an error, as in what is made of a mesh]
    #[arg(
        long,
        value_name = "KNOB=VALUE",
        value_parser = values::choice,
        help_heading = "Experiment"
    )]
    set: Vec<(String, String)>,

    /// Vary each knob by itself instead of every value with every other
    #[arg(long, help_heading = "Experiment")]
    one_at_a_time: bool,

    /// Seeds for each setting
    #[arg(
        long,
        value_name = "K",
        default_value_t = 8,
        value_parser = clap::value_parser!(u32).range(2..=10_000),
        help_heading = "Experiment"
    )]
    repeats: u32,

    /// Seed that those of all runs come from [default: the scene's]
    #[arg(long, value_name = "N", help_heading = "Experiment")]
    seed: Option<u64>,

    /// Columns and rows of the whole picture [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = "Experiment")]
    size: Option<Size>,

    /// Measure only this part: first column and row, columns and rows [default: the scene's]
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::crop, help_heading = "Experiment")]
    crop: Option<Crop>,

    /// OpenEXR file to measure against; with the layers of `render --variance` its noise is taken into
    /// account
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with = "reference_spp",
        help_heading = "Experiment"
    )]
    reference: Option<PathBuf>,

    /// Render the reference with N samples per pixel [default: 16 times the most of any setting]
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(16..),
        help_heading = "Experiment"
    )]
    reference_spp: Option<u32>,

    /// Find out with how many samples, and when, each setting comes to this relMSE: further numbers of samples are
    /// measured, up to four times the most [default: 0.01, by what is measured anyhow]
    #[arg(
        long,
        value_name = "RELMSE",
        value_parser = values::positive,
        help_heading = "Experiment"
    )]
    target: Option<f64>,

    /// Folder for the report, and for all runs as JSON and CSV; one that holds a part of the same
    /// experiment is completed
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    report: Option<PathBuf>,

    /// Show no progress
    #[arg(short, long, help_heading = "Output")]
    quiet: bool,
}

/// relMSE that the verdict is about unless another is asked for.
const TARGET: f64 = 0.01;
/// How many times the most samples of any setting are measured in search of a target.
const FARTHEST: u32 = 4;

/// Asks for the memory of a film with its picture, and of all engines, which are there at the same time.
fn claim(
    limits: &Limits,
    description: &Description,
    settings: &[&Setting],
) -> Result<(), OutOfMemory> {
    limits.claim(telamon::render::bytes(description))?;
    let shapes = description.scene.shapes();
    let mut accels: Vec<_> = Vec::new();
    for accel in settings.iter().map(|setting| setting.accel) {
        if !accels.contains(&accel) {
            accels.push(accel);
            limits.claim(accel.estimated_bytes(&shapes))?;
        }
    }
    Ok(())
}

/// Samples per pixel of a scene whose renders end when they are good enough, unless `--set` or `--vary` says how many.
const MOST_BESIDE_ERROR: u32 = 16;

/// Writes all runs so far; from now on into the folder for temporary files, with a warning, if their own is
/// gone or full. Whether that is so is returned.
fn save(store: &mut Store, record: &Record) -> Result<bool, Failure> {
    let Err(error) = store.save(record) else { return Ok(false) };
    let folder = std::env::temp_dir().join(format!("telamon-measure-{}", std::process::id()));
    let other = Store::open(&folder).and_then(|other| other.save(record).map(|()| other));
    let Ok(other) = other else { return Err(error.into()) };
    warn(format!("{error}; the measurements are in `{}`", folder.display()));
    *store = other;
    Ok(true)
}

impl Arguments {
    pub(super) fn run(&self) -> Result<Ending, Failure> {
        let accel = self.input.accel();
        let limits = self.input.resources.limits();
        let mut description = self.input.load(&limits, self.size, self.quiet)?.description;
        if let Some(crop) = self.crop {
            description.crop_to(crop)?;
        }
        let mut scene = Setting::of(&description, accel, machine::threads())?;
        if description.effort.error.is_some() {
            // Its number of samples is the most that it may take, and the reference would have 16 times that.
            scene.samples_per_pixel = scene.samples_per_pixel.min(MOST_BESIDE_ERROR);
        }
        let base = self.base(&scene)?;
        let design = if self.one_at_a_time { Design::OneAtATime } else { Design::Grid };
        let candidates = plan::candidates(&base, &self.vary, design)?;
        let mut experiment = self.experiment(&description, base, candidates)?;

        let cancel = interrupt::watch()?;
        let settings = experiment.candidates.iter().map(|c| &c.setting);
        let settings: Vec<&Setting> = settings.chain([&experiment.base]).collect();
        claim(&limits, &description, &settings)?;
        let mut bench = Bench::new(description, settings, &ProcessMemory)?;
        experiment.record.engines = bench.engines();
        let Some(reference) = self.reference(&mut bench, &experiment, &cancel)? else {
            return Ok(Ending::Interrupted);
        };
        self.measure(&mut bench, &mut experiment, &reference, &cancel)?;
        self.search(&mut bench, &mut experiment, &reference, &cancel)?;
        self.conclude(&mut bench, &experiment, &reference, &cancel)?;
        let interrupted = cancel.load(Ordering::Relaxed);
        Ok(match (experiment.elsewhere, interrupted) {
            (true, _) => Ending::Elsewhere,
            (false, true) => Ending::Interrupted,
            (false, false) => Ending::Done,
        })
    }

    /// The scene's own setting, with what `--set` says.
    fn base(&self, scene: &Setting) -> Result<Setting, KnobError> {
        let knob_before = |i: usize| self.set[..i].iter().any(|(knob, _)| *knob == self.set[i].0);
        if let Some(twice) = (0..self.set.len()).find(|&i| knob_before(i)) {
            return Err(KnobError::Twice { what: format!("knob `{}`", self.set[twice].0) });
        }
        let candidate = plan::turned(scene, &self.set)?;
        match self.set.iter().find(|choice| !candidate.choices.contains(choice)) {
            Some((knob, _)) => Err(KnobError::no_effect(knob)),
            None => Ok(candidate.setting),
        }
    }

    /// Makes all runs that are missing, until Ctrl-C.
    fn measure(
        &self,
        bench: &mut Bench<'_>,
        experiment: &mut Experiment,
        reference: &Image,
        cancel: &AtomicBool,
    ) -> Result<(), Failure> {
        let Experiment { candidates, record, store, elsewhere, .. } = experiment;
        let labels: Vec<String> = candidates.iter().map(Candidate::label).collect();
        let seed = record.origin.seed;
        let order: Vec<plan::Slot> = plan::order(candidates.len(), self.repeats, seed)
            .into_iter()
            .filter(|&(c, k)| !record.runs.iter().any(|r| r.setting == labels[c] && r.repeat == k))
            .collect();
        let bar = Runs::new(order.len() as u64, self.quiet);
        for (done, &(candidate, repeat)) in order.iter().enumerate() {
            let left = remaining(&record.runs, candidates, &labels, &order[done..]);
            bar.update(done as u64, message(&labels[candidate], left));
            let subject = (labels[candidate].as_str(), &candidates[candidate].setting);
            let run = bench.run(subject, repeat, seed, reference, cancel);
            if cancel.load(Ordering::Relaxed) {
                break;
            }
            let run = run.ok_or_else(|| {
                let label = &labels[candidate];
                Failure::new(format!("{label}: no pixel is finite in picture and reference"))
            })?;
            record.runs.push(run);
            if let Some(store) = store {
                *elsewhere |= save(store, record)?;
            }
        }
        bar.finish();
        Ok(())
    }

    /// Measures further numbers of samples until it is known when each series comes to the target that was asked
    /// for, or Ctrl-C.
    fn search(
        &self,
        bench: &mut Bench<'_>,
        experiment: &mut Experiment,
        reference: &Image,
        cancel: &AtomicBool,
    ) -> Result<(), Failure> {
        let Some(target) = self.target else { return Ok(()) };
        let planned = &experiment.candidates[..experiment.planned];
        let most = planned.iter().map(|c| c.setting.samples_per_pixel).max().unwrap_or(1);
        let told = match experiment.record.origin.reference {
            // With more it would be the reference whose noise is seen.
            ReferenceOrigin::Rendered { samples_per_pixel } => samples_per_pixel / 4,
            ReferenceOrigin::File { .. } => u32::MAX,
        };
        let most = most.saturating_mul(FARTHEST).min(told).max(most);
        while !cancel.load(Ordering::Relaxed) {
            let Experiment { candidates, record, .. } = &experiment;
            let findings = Findings::of(candidates, &record.runs, mean_error(reference));
            let next = search::next(&findings, candidates, &record.runs, target, most);
            if next.is_empty() {
                break;
            }
            experiment.candidates.extend(next);
            self.measure(bench, experiment, reference, cancel)?;
        }
        Ok(())
    }

    /// Shows and writes what was found.
    fn conclude(
        &self,
        bench: &mut Bench<'_>,
        experiment: &Experiment,
        reference: &Image,
        cancel: &AtomicBool,
    ) -> Result<(), Failure> {
        let Experiment { candidates, planned, record, store, .. } = experiment;
        let target = self.target.unwrap_or(TARGET);
        // What the search had just begun says nothing.
        let runs_of = |c: &Candidate| {
            let label = c.label();
            record.runs.iter().filter(|r| r.setting == label).count()
        };
        let begun = candidates.iter().zip(0..).filter(|&(c, i)| i < *planned || runs_of(c) > 1);
        let mut candidates: Vec<Candidate> = begun.map(|(c, _)| c.clone()).collect();
        candidates[*planned..].sort_by_key(|c| (c.series(), c.setting.samples_per_pixel));
        let candidates = &candidates;
        let findings = Findings::of(candidates, &record.runs, mean_error(reference));
        let enough = findings.settings.iter().all(|s| s.runs > 1);
        if findings.settings.is_empty() || !enough {
            say("too few runs to say anything: two of each setting are needed");
            return Ok(());
        }
        let sentences = report::verdict(&findings, &record.runs, target);
        let mut text = rows(&findings);
        text += "\n";
        for sentence in &sentences {
            text += &format!("{sentence}\n");
        }
        print(text.as_bytes())?;
        if let Some(store) = store {
            let subject = (&findings, record.runs.as_slice());
            let shots = crops::take(bench, candidates, subject, reference, target, cancel);
            let page = report::html(record, &findings, &sentences, shots.as_ref(), target);
            let path = store.save_findings(&findings, &page)?;
            say(&format!("report: {}", path.display()));
        }
        Ok(())
    }
}
