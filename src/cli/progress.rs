//! The progress bar.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use telamon::render::Progress;

/// Shows how far a long command has come, if standard error is a terminal. Copies are the same bar.
#[derive(Clone, Debug)]
pub(super) struct Bar(ProgressBar);

impl Bar {
    pub(super) fn new(quiet: bool) -> Self {
        if quiet {
            return Self(ProgressBar::hidden());
        }
        // Indicatif itself draws on standard error, a few times a second, and only on a terminal.
        let bar = ProgressBar::no_length();
        let template = "{wide_bar} {percent:>3} %  {eta} left  {msg}";
        bar.set_style(ProgressStyle::with_template(template).expect("a valid template"));
        Self(bar)
    }

    /// Begins anew.
    pub(super) fn begin(&self) {
        self.0.reset();
    }

    pub(super) fn update(&self, progress: &Progress<'_>) {
        let Progress { samples_done, samples_total, rays, .. } = *progress;
        self.show(samples_done, samples_total, |elapsed| {
            let [samples, rays] =
                [samples_done, rays].map(|count| millions_per_second(count, elapsed));
            format!("{samples} Msamples/s, {rays} Mrays/s")
        });
    }

    /// `message` says how fast it goes, from the time since the beginning.
    pub(super) fn show(&self, done: u64, total: u64, message: impl FnOnce(Duration) -> String) {
        self.0.set_length(total);
        self.0.set_position(done);
        self.0.set_message(message(self.0.elapsed()));
    }

    /// Makes room for what `say` writes to standard error.
    pub(super) fn suspend(&self, say: impl FnOnce()) {
        self.0.suspend(say);
    }

    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Shows how many runs of an experiment are done, if standard error is a terminal.
#[derive(Debug)]
pub(super) struct Runs(ProgressBar);

impl Runs {
    pub(super) fn new(count: u64, quiet: bool) -> Self {
        if quiet {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(count);
        let template = "{wide_bar} {percent:>3} %  {msg}";
        bar.set_style(ProgressStyle::with_template(template).expect("a valid template"));
        Self(bar)
    }

    pub(super) fn update(&self, done: u64, message: String) {
        self.0.set_position(done);
        self.0.set_message(message);
    }

    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// How many `rays` are traced in a second, with its unit: in millions unless they are few.
pub(super) fn rays_per_second(rays: u64, elapsed: Duration) -> String {
    let rate = rays as f64 / elapsed.as_secs_f64().max(1e-9);
    if rate < 1e5 { format!("{rate:.0} rays/s") } else { format!("{:.2} Mrays/s", rate * 1e-6) }
}

/// `count` per second of `elapsed`, in millions.
pub(super) fn millions_per_second(count: u64, elapsed: Duration) -> String {
    let seconds = elapsed.as_secs_f64().max(1e-9);
    format!("{:.2}", count as f64 / seconds * 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_in_millions() {
        assert_eq!(millions_per_second(3_000_000, Duration::from_secs(2)), "1.50");
        assert_eq!(millions_per_second(0, Duration::ZERO), "0.00");
        assert_eq!(rays_per_second(3_000_000, Duration::from_secs(2)), "1.50 Mrays/s");
        assert_eq!(rays_per_second(500, Duration::from_secs(2)), "250 rays/s");
    }
}
