//! One experiment: which settings of which scene are rendered, and how often.

use std::error::Error;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use telamon::intersect::{self, Accel};
use telamon::measure::bench::{Bench, Run, mean_error, render_reference};
use telamon::measure::knobs::Setting;
use telamon::measure::plan::{Candidate, order, turned};
use telamon::measure::summary::{Findings, Summary};
use telamon::render::Description;

use crate::leaks::{Leaks, count_leaks};
use crate::machine::{self, ProcessMemory};
use crate::subject::Subject;

/// Knobs with their values.
pub(crate) type Choices = &'static [(&'static str, &'static str)];

/// Settings of one scene.
pub(crate) struct Trial {
    /// Names its files.
    pub(crate) name: &'static str,
    pub(crate) subject: Subject,
    /// Columns and rows.
    pub(crate) size: (u32, u32),
    /// What all settings have in common, the reference among them.
    pub(crate) fixed: Choices,
    /// The first is what the others are compared with.
    pub(crate) settings: &'static [Choices],
    /// What the reference is rendered with beside [`Trial::fixed`].
    pub(crate) reference: Choices,
    pub(crate) repeats: u32,
    /// Whether the time to build is of interest, or else the time is all for rendering.
    pub(crate) builds: bool,
    /// Whether rays are counted that its engines get wrong.
    pub(crate) leaks: bool,
}

/// What a trial gave, as it is stored.
#[derive(Serialize, Deserialize)]
pub(crate) struct Stored {
    pub(crate) date: String,
    pub(crate) commit: String,
    pub(crate) processor: String,
    pub(crate) threads: usize,
    pub(crate) engines: Vec<String>,
    pub(crate) reference_samples_per_pixel: u32,
    /// Standard error of the reference's mean.
    reference_error: f64,
    /// Seconds to build the engine of each setting, once in each round; empty unless they are of interest.
    builds: Vec<Vec<f64>>,
    pub(crate) leaks: Vec<Leaks>,
    runs: Vec<Run>,
}

/// That, and what it shows.
pub(crate) struct Measured {
    pub(crate) stored: Stored,
    pub(crate) findings: Findings,
}

impl Measured {
    /// What was found of the setting with this label.
    pub(crate) fn of(&self, label: &str) -> &Summary {
        let found = self.findings.settings.iter().find(|s| s.setting == label);
        found.unwrap_or_else(|| panic!("`{label}` is not among the settings that were measured"))
    }

    /// Seconds to build the engine of a setting, once in each round; none unless they are of interest.
    pub(crate) fn builds(&self, label: &str) -> &[f64] {
        let place = self.findings.settings.iter().position(|s| s.setting == label);
        place.and_then(|i| self.stored.builds.get(i)).map_or(&[], Vec::as_slice)
    }

    /// A number of each run of a setting, round by round.
    pub(crate) fn values(&self, label: &str, value: fn(&Run) -> f64) -> Vec<f64> {
        self.stored.runs.iter().filter(|r| r.setting == label).map(value).collect()
    }
}

/// The same numbers each time.
const SEED: u64 = 2026;

/// How the settings of a trial are rendered.
struct Plan {
    /// The first is what the others are compared with.
    candidates: Vec<Candidate>,
    reference: Setting,
}

impl Trial {
    /// Renders everything.
    pub(crate) fn measure(&self, root: &Path) -> Result<Stored, Box<dyn Error>> {
        let mut description = self.subject.load(root)?;
        description.resize(self.size.0, self.size.1)?;
        let shapes = description.scene.shapes();
        let threads = machine::threads();
        let Plan { candidates, reference: precise } = self.plan(&description, threads)?;
        let settings = candidates.iter().map(|c| &c.setting).chain([&precise]);
        let mut bench = Bench::new(description, settings, &ProcessMemory)?;
        let never = AtomicBool::new(false);
        let reference = render_reference(&mut bench, &precise, SEED, &|_| (), &never)
            .ok_or("the reference was not rendered")?;
        let mut runs = Vec::new();
        let mut builds = vec![Vec::new(); if self.builds { candidates.len() } else { 0 }];
        for (candidate, repeat) in order(candidates.len(), self.repeats, SEED) {
            let label = candidates[candidate].label();
            let subject = (label.as_str(), &candidates[candidate].setting);
            let run = bench.run(subject, repeat, SEED, &reference, &never);
            runs.push(run.ok_or_else(|| format!("{label}: no pixel is finite"))?);
            if let Some(builds) = builds.get_mut(candidate) {
                let start = Instant::now();
                intersect::build(candidates[candidate].setting.accel, &shapes)?;
                builds.push(start.elapsed().as_secs_f64());
            }
        }
        let leaks = if self.leaks {
            let engines: Vec<_> = candidates.iter().map(|c| (c.label(), c.setting.accel)).collect();
            count_leaks(&engines, &shapes)?
        } else {
            Vec::new()
        };
        Ok(Stored {
            date: today()?,
            commit: machine::COMMIT.unwrap_or("unknown").to_owned(),
            processor: machine::processor(),
            threads,
            engines: bench.engines(),
            reference_samples_per_pixel: precise.samples_per_pixel,
            reference_error: mean_error(&reference),
            builds,
            leaks,
            runs,
        })
    }

    /// What the runs show.
    pub(crate) fn judge(&self, root: &Path, stored: Stored) -> Result<Measured, Box<dyn Error>> {
        let plan = self.plan(&self.subject.load_outline(root)?, stored.threads)?;
        let findings = Findings::of(&plan.candidates, &stored.runs, stored.reference_error);
        Ok(Measured { stored, findings })
    }

    fn plan(&self, scene: &Description, threads: usize) -> Result<Plan, Box<dyn Error>> {
        let scene = Setting::of(scene, Accel::default(), threads)?;
        let fixed = turn(&scene, self.fixed)?.setting;
        let base = turn(&fixed, self.settings[0])?.setting;
        let candidates = self.settings.iter().map(|s| turn(&base, s)).collect::<Result<_, _>>()?;
        Ok(Plan { candidates, reference: turn(&fixed, self.reference)?.setting })
    }
}

fn turn(base: &Setting, choices: Choices) -> Result<Candidate, Box<dyn Error>> {
    let choices: Vec<_> = choices.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect();
    let candidate = turned(base, &choices)?;
    match choices.iter().find(|c| !candidate.choices.contains(c)) {
        Some((knob, value)) => Err(format!("`{knob}={value}` changes nothing").into()),
        None => Ok(candidate),
    }
}

fn today() -> Result<String, Box<dyn Error>> {
    let output = std::process::Command::new("date").args(["-u", "+%F"]).output()?;
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
}
