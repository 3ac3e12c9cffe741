//! What is measured: the settings, and what an earlier command has measured of them.

use std::fs;
use std::path::Path;

use flate2::Crc;
use telamon::film::Crop;
use telamon::measure::knobs::Setting;
use telamon::measure::plan::{self, Candidate};
use telamon::measure::record::{Origin, Record, ReferenceOrigin};
use telamon::measure::store::Store;
use telamon::render::Description;

use super::Arguments;
use crate::cli::machine;
use crate::cli::message::{Failure, warn};

/// What is measured, and how.
pub(super) struct Experiment {
    pub(super) base: Setting,
    /// Those that were asked for, then those that the search for the target has added.
    pub(super) candidates: Vec<Candidate>,
    /// How many were asked for.
    pub(super) planned: usize,
    pub(super) record: Record,
    pub(super) store: Option<Store>,
    /// Whether the measurements are in another folder than they should be.
    pub(super) elsewhere: bool,
}

impl Arguments {
    /// What was measured before, if it belongs to this experiment, or nothing so far.
    pub(super) fn experiment(
        &self,
        description: &Description,
        base: Setting,
        candidates: Vec<Candidate>,
    ) -> Result<Experiment, Failure> {
        let store = self.report.as_deref().map(Store::open).transpose()?;
        let stored = store.as_ref().map(Store::record).transpose()?.flatten();
        let most = candidates.iter().map(|c| c.setting.samples_per_pixel).max().unwrap_or(1);
        let reference = match (&self.reference, self.reference_spp, &stored) {
            (Some(path), ..) => {
                ReferenceOrigin::File { path: path.display().to_string(), crc32: crc32(path)? }
            }
            (None, Some(samples_per_pixel), _) => ReferenceOrigin::Rendered { samples_per_pixel },
            // More settings may have come, but not a reason to render another reference.
            (None, None, Some(Record { origin, .. })) => origin.reference.clone(),
            (None, None, None) => {
                ReferenceOrigin::Rendered { samples_per_pixel: most.saturating_mul(16).max(256) }
            }
        };
        let coarse = match reference {
            ReferenceOrigin::Rendered { samples_per_pixel: n } => Some(n).filter(|n| n / 4 < most),
            ReferenceOrigin::File { .. } => None,
        };
        if let Some(n) = coarse {
            warn(format!(
                "the reference has {n} samples per pixel, and settings have up to {most}: it does not tell how small \
                 their errors are (expected {} or more)",
                4 * u64::from(most)
            ));
        }
        let Crop { x, y, width, height } = description.film.crop;
        let origin = Origin {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: machine::COMMIT.map(str::to_owned),
            debug_build: cfg!(debug_assertions),
            embree: env!("TELAMON_EMBREE").to_owned(),
            processor: machine::processor(),
            processor_threads: machine::threads(),
            scene: self.input.scene.display().to_string(),
            scene_crc32: crc32(&self.input.scene)?,
            defines: self.input.defines_of_record(),
            film: (description.film.width, description.film.height),
            crop: (x, y, width, height),
            base: format!("{base:?}"),
            seed: self.seed.unwrap_or(description.sampler.seed),
            reference,
        };
        let mut record = match (stored, &store) {
            (Some(stored), Some(store)) => {
                store.check(&stored.origin, &origin)?;
                stored
            }
            _ => Record { origin, commands: Vec::new(), engines: Vec::new(), runs: Vec::new() },
        };
        let command: Vec<String> = std::env::args().collect();
        let command = command.join(" ");
        if !record.commands.contains(&command) {
            record.commands.push(command);
        }
        let planned = candidates.len();
        let mut candidates = candidates;
        plan::adopt(&mut candidates, record.runs.iter().map(|r| r.setting.as_str()));
        Ok(Experiment { base, candidates, planned, record, store, elsewhere: false })
    }
}

/// CRC-32 of a file's contents.
fn crc32(path: &Path) -> Result<u32, Failure> {
    let contents = fs::read(path)
        .map_err(|e| Failure::new(format!("cannot read `{}`: {e}", path.display())))?;
    let mut crc = Crc::new();
    crc.update(&contents);
    Ok(crc.sum())
}
