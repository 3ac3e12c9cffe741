//! An experiment as it is stored: what was measured, and all that is needed to measure it again.

use serde::{Deserialize, Serialize};

use super::bench::Run;

/// What must be the same for two runs to belong to one experiment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// Version of this program.
    pub version: String,
    /// Commit that it was built from, where that is known.
    pub commit: Option<String>,
    /// Whether it was compiled without optimisation of the whole, as for development.
    pub debug_build: bool,
    /// Version of Embree, or that there is none.
    pub embree: String,
    /// Name of the processor.
    pub processor: String,
    /// Threads that it can run.
    pub processor_threads: usize,
    /// Scene file.
    pub scene: String,
    /// CRC-32 of its contents; files that it includes do not count.
    pub scene_crc32: u32,
    /// Parameters of the scene file that were set.
    pub defines: Vec<(String, String)>,
    /// Columns and rows of the film.
    pub film: (u32, u32),
    /// First column and row, columns and rows of the part that was rendered.
    pub crop: (u32, u32, u32, u32),
    /// What the base is, in full.
    pub base: String,
    /// Seed that the seeds of all runs come from.
    pub seed: u64,
    /// What pictures were measured against.
    pub reference: ReferenceOrigin,
}

/// Where a reference comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReferenceOrigin {
    /// A file.
    File {
        /// Its name.
        path: String,
        /// CRC-32 of its contents.
        crc32: u32,
    },
    /// The base with many samples.
    Rendered {
        /// How many per pixel.
        samples_per_pixel: u32,
    },
}

/// An experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// What it was measured with.
    pub origin: Origin,
    /// The commands that measured it, each once, in order.
    pub commands: Vec<String>,
    /// Names and versions of the engines.
    pub engines: Vec<String>,
    /// Runs in the order in which they were made.
    pub runs: Vec<Run>,
}

impl Origin {
    /// The first difference to another origin, in words; `None` if there is none.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<String> {
        let differing = self.fields().into_iter().zip(other.fields()).find(|(a, b)| a != b);
        differing.map(|((name, stored), (_, now))| format!("its {name} is {stored}, now {now}"))
    }

    /// Everything by name.
    fn fields(&self) -> [(&'static str, String); 13] {
        let reference = match &self.reference {
            ReferenceOrigin::File { path, crc32 } => format!("{path} ({crc32:08x})"),
            ReferenceOrigin::Rendered { samples_per_pixel } => {
                format!("rendered with {samples_per_pixel} samples per pixel")
            }
        };
        let build = if self.debug_build { "for development" } else { "a release" };
        let (x, y, width, height) = self.crop;
        [
            ("version", self.version.clone()),
            ("commit", self.commit.clone().unwrap_or_else(|| "unknown".to_owned())),
            ("build", build.to_owned()),
            ("library", self.embree.clone()),
            ("processor", self.processor.clone()),
            ("number of processors", self.processor_threads.to_string()),
            ("scene", format!("{} ({:08x})", self.scene, self.scene_crc32)),
            ("list of definitions", format!("{:?}", self.defines)),
            ("film", format!("{}x{}", self.film.0, self.film.1)),
            ("crop", format!("{width}x{height} at {x},{y}")),
            ("base", self.base.clone()),
            ("seed", self.seed.to_string()),
            ("reference", reference),
        ]
    }
}

/// A table of all runs, with a line of names: comma-separated values as in RFC 4180.
#[must_use]
pub fn runs_csv(runs: &[Run]) -> String {
    let mut text = String::from(
        "setting,repeat,seed,seconds,build_seconds,rays,samples,non_finite_samples,peak_bytes,\
         pixels,mse,reference_mse,rel_mse,reference_rel_mse,rel_mse_trimmed,rel_se_quantile,\
         rel_se_max,smape,flip,bias,bias_error,reference_mean\r\n",
    );
    for r in runs {
        let m = &r.metrics;
        let noise = m.reference_noise;
        let number = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        let cells = [
            quoted(&r.setting),
            r.repeat.to_string(),
            r.seed.to_string(),
            r.seconds.to_string(),
            r.build_seconds.to_string(),
            r.rays.to_string(),
            r.samples.to_string(),
            r.non_finite_samples.to_string(),
            r.peak_bytes.map_or(String::new(), |b| b.to_string()),
            m.pixels.to_string(),
            m.mse.to_string(),
            number(noise.map(|n| n.mse)),
            m.rel_mse.to_string(),
            number(noise.map(|n| n.rel_mse)),
            m.rel_mse_trimmed.to_string(),
            m.rel_se_quantile.to_string(),
            m.rel_se_max.to_string(),
            m.smape.to_string(),
            m.flip.to_string(),
            m.bias.to_string(),
            m.bias_error.to_string(),
            m.reference_mean.to_string(),
        ];
        text += &cells.join(",");
        text += "\r\n";
    }
    text
}

fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
