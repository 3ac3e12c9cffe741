//! The picture that `telamon measure` measures against: rendered, or from a file.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use telamon::film::exr::Metadata;
use telamon::measure::Image;
use telamon::measure::bench::{Bench, REFERENCE_PARTS, render_reference};
use telamon::measure::knobs::Setting;
use telamon::measure::record::ReferenceOrigin;
use telamon::measure::store::{Store, load_image};

use super::{Arguments, Experiment};
use crate::cli::compare::warn_of_even_samples;
use crate::cli::message::{Failure, warn};
use crate::cli::progress::Runs;

impl Arguments {
    /// The picture to measure against; `None` if Ctrl-C came before it was done.
    pub(super) fn reference(
        &self,
        bench: &mut Bench<'_>,
        experiment: &Experiment,
        cancel: &AtomicBool,
    ) -> Result<Option<Image>, Failure> {
        let samples_per_pixel = match &experiment.record.origin.reference {
            ReferenceOrigin::File { path, .. } => {
                return self.reference_file(Path::new(path), bench).map(Some);
            }
            ReferenceOrigin::Rendered { samples_per_pixel } => *samples_per_pixel,
        };
        if let Some(image) = experiment.store.as_ref().map(Store::reference).transpose()?.flatten()
        {
            return Ok(Some(image));
        }
        let setting = Setting { samples_per_pixel, ..experiment.base.clone() };
        let bar = Runs::new(1000, self.quiet);
        let seed = experiment.record.origin.seed;
        let on_progress = |done: f64| bar.update((1000.0 * done) as u64, "reference".to_owned());
        let image = render_reference(bench, &setting, seed, &on_progress, cancel);
        bar.finish();
        if let (Some(image), Some(store)) = (&image, &experiment.store) {
            // What the mean of its parts has.
            let samples =
                samples_per_pixel.div_ceil(REFERENCE_PARTS).saturating_mul(REFERENCE_PARTS);
            let metadata = Metadata {
                scene: experiment.record.origin.scene.clone(),
                seed,
                samples_per_pixel: (samples, samples),
                backend: experiment.record.engines.join(", "),
                ..Metadata::default()
            };
            // It is here all the same, and costs more than the measurements.
            if let Err(error) = store.save_reference(image, &metadata) {
                warn(format!("{error}; the reference is not kept"));
            }
        }
        Ok(image)
    }

    fn reference_file(&self, path: &Path, bench: &Bench<'_>) -> Result<Image, Failure> {
        let image = load_image(path)?;
        let film = &bench.description().film;
        let (width, height, crop) = (film.width, film.height, film.crop);
        let wanted = Image { width, height, crop, pixels: Vec::new(), variance: None };
        let image = image.cut_to(&wanted).map_err(|e| {
            let scene = self.input.scene.display();
            Failure::new(format!("cannot measure `{scene}` against `{}`: {e}", path.display()))
        })?;
        warn_of_even_samples(&image, path);
        if image.variance.is_none() {
            warn(format!(
                "`{}` does not say how noisy it is: it counts as exact (expected the layers of `telamon \
                 render --variance`)",
                path.display()
            ));
        }
        Ok(image)
    }
}
