//! `telamon compare`.

use std::path::{Path, PathBuf};

use clap::Args;
use telamon::film::exr::Metadata;
use telamon::film::output::check_writable;
use telamon::film::picture::{Picture, Values};
use telamon::film::read::{read_exr, sampler};
use telamon::measure::false_color::{false_color, side_by_side};
use telamon::measure::{Image, Metrics, ZTest};
use telamon::sampler::SamplerKind;

use super::definitions::METRICS;
use super::message::{Failure, warn};
use super::table::table;
use super::values::{self, Output};
use super::{Ending, picture, print};

const HELP: &str = "Without --reference, B is the reference of A.\n\n\
                    Example: telamon compare a.exr b.exr --reference truth.exr -o difference.png";

/// Measure how far pictures are from each other
#[derive(Args, Debug)]
#[command(
    after_help = HELP,
    after_long_help = format!(
        "{}\n\nThe standard error of the bias is s/sqrt(N) with the sample standard deviation s, over N \
         pixels, of their mean differences; its p-value is that of Student's t with N - 1 degrees of freedom. \
         If A or B has the layers of `render --variance`, all numbers are tested: z = (A - B) / sqrt(v_A + v_B) \
         against the normal distribution, at the significance 0.01 for all together (Sidak); noise explains the \
         differences if 0.25 % or less are beyond that.\n\n{HELP}",
        METRICS
    )
)]
pub(super) struct Arguments {
    /// OpenEXR file
    #[arg(value_name = "A")]
    a: PathBuf,

    /// OpenEXR file of the same part of the same film
    #[arg(value_name = "B")]
    b: PathBuf,

    /// Measure both against this OpenEXR file, which may show more of the film
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,

    /// Picture to write, .png or .exr: where A is brighter (orange) or darker (blue) than its
    /// reference, from 0.1 % (black) to 100 %; with --reference the same of B to its right
    #[arg(short, long, value_name = "FILE", value_parser = values::output)]
    output: Option<Output>,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<Ending, Failure> {
        if let Some(output) = &self.output {
            check_writable(&output.path)?;
        }
        let (first, a) = load(&self.a)?;
        let (second, b) = load(&self.b)?;
        let uneven = uneven_layers(&first, &second);
        let (text, shown) = match &self.reference {
            None => {
                let b = covering(&b, &self.b, &a, &self.a)?;
                let metrics = measured(&a, &b, &self.a)?;
                let title = format!("{} against {}\n", self.a.display(), self.b.display());
                (title + &rows(&[metrics]), vec![false_color(&a, &b)])
            }
            Some(path) => {
                if (a.width, a.height, a.crop) != (b.width, b.height, b.crop) {
                    // Says which it is.
                    covering(&b, &self.b, &a, &self.a)?;
                    covering(&a, &self.a, &b, &self.b)?;
                }
                let reference = covering(&load(path)?.1, path, &a, &self.a)?;
                let metrics =
                    [measured(&a, &reference, &self.a)?, measured(&b, &reference, &self.b)?];
                let (a_name, b_name) = (self.a.display(), self.b.display());
                let title = format!("A = {a_name}, B = {b_name} against {}\n", path.display());
                let shown = vec![false_color(&a, &reference), false_color(&b, &reference)];
                (title + &rows(&metrics), shown)
            }
        };
        let z_test = covering(&b, &self.b, &a, &self.a).map(|b| ZTest::of(&a, &b))?;
        let exact = match (&a.variance, &b.variance) {
            (None, _) => "A",
            (_, None) => "B",
            _ => "",
        };
        print((text + &z_test.map_or(String::new(), |z| verdict(&z, exact, uneven))).as_bytes())?;
        match &self.output {
            Some(output) => write(output, &shown),
            None => Ok(Ending::Done),
        }
    }
}

/// Says which layers of both pictures have numbers that are finite in one of them only, and whether there are
/// such layers.
fn uneven_layers(a: &Picture, b: &Picture) -> bool {
    let mut any = false;
    for layer in a.channels.iter().filter(|_| a.crop == b.crop) {
        let other = b.channels.iter().find(|c| c.name == layer.name).map(|c| &c.values);
        if let (Values::Float(of_a), Some(Values::Float(of_b))) = (&layer.values, other) {
            let uneven =
                of_a.iter().zip(of_b).filter(|(a, b)| a.is_finite() != b.is_finite()).count();
            if uneven > 0 {
                any = true;
                let name = &layer.name;
                warn(format!(
                    "layer `{name}`: numbers that are finite in one picture only: {uneven}"
                ));
            }
        }
    }
    any
}

fn load(path: &Path) -> Result<(Picture, Image), Failure> {
    let picture = read_exr(path)?;
    let image = Image::from_picture(&picture)
        .map_err(|e| Failure::new(format!("`{}`: {e}", path.display())))?;
    warn_of_even_samples(&image, path);
    Ok((picture, image))
}

/// Says so if the noise that `image` claims to have is more than it has: samples that are spread evenly vary
/// as much as others, but their mean varies less.
pub(super) fn warn_of_even_samples(image: &Image, path: &Path) {
    let sampler = sampler(path).and_then(|name| name.parse::<SamplerKind>().ok());
    let even = sampler.filter(|kind| image.variance.is_some() && !kind.about().independent);
    if let Some(kind) = even {
        warn(format!(
            "`{}` was rendered with sampler `{kind}`, so it is less noisy than its variance says \
             (expected one of `telamon render --variance --sampler {}`)",
            path.display(),
            SamplerKind::Independent
        ));
    }
}

/// The part of `whole` that `part` covers.
fn covering(
    whole: &Image,
    whole_path: &Path,
    part: &Image,
    part_path: &Path,
) -> Result<Image, Failure> {
    whole.cut_to(part).map_err(|e| {
        let (part, whole) = (part_path.display(), whole_path.display());
        Failure::new(format!("cannot compare `{part}` with `{whole}`: {e}"))
    })
}

fn measured(image: &Image, reference: &Image, path: &Path) -> Result<Metrics, Failure> {
    let metrics = Metrics::of(image, reference).ok_or_else(|| {
        let of_what = match reference.variance {
            Some(_) => ", with a finite variance in the reference",
            None => "",
        };
        Failure::new(format!("`{}`: no pixel is finite in both pictures{of_what}", path.display()))
    })?;
    if metrics.non_finite > 0 {
        let count = metrics.non_finite;
        warn(format!("`{}`: pixels that are not finite and are left out: {count}", path.display()));
    }
    Ok(metrics)
}

/// A row for each metric, a column for each picture.
fn rows(pictures: &[Metrics]) -> String {
    // A single pixel has no spread, and a black reference no bias relative to it.
    let known = |v: f64, text: String| if v.is_finite() { text } else { "unknown".to_owned() };
    let number = |v: f64| known(v, format!("{v:.6}"));
    let scientific = |v: f64| known(v, format!("{v:.4e}"));
    let percent = |v: f64| known(v, format!("{v:+.3} %"));
    let row = |name: &str, value: &dyn Fn(&Metrics) -> String| {
        let mut cells = vec![name.to_owned()];
        cells.extend(pictures.iter().map(value));
        cells
    };
    let mut rows = vec![
        row("pixels", &|m| m.pixels.to_string()),
        row("MSE", &|m| scientific(m.mse)),
        row("RMSE", &|m| scientific(m.rmse())),
        row("relMSE", &|m| scientific(m.rel_mse)),
        row("relMSE without the worst 0.1 %", &|m| scientific(m.rel_mse_trimmed)),
        row("relative squared error, 99.9 %", &|m| scientific(m.rel_se_quantile)),
        row("relative squared error, largest", &|m| scientific(m.rel_se_max)),
        row("SMAPE", &|m| number(m.smape)),
        row("FLIP", &|m| number(m.flip)),
        row("bias", &|m| scientific(m.bias)),
        row("standard error of the bias", &|m| scientific(m.bias_error)),
        row("bias over the mean", &|m| percent(100.0 * m.bias / m.reference_mean)),
        row("p-value if there is no bias", &|m| {
            let p = m.bias_p_value();
            known(p, format!("{p:.3e}"))
        }),
    ];
    if pictures.iter().all(|m| m.reference_noise.is_some()) {
        rows.push(row("MSE without the reference's noise", &|m| scientific(m.true_mse())));
        rows.push(row("relMSE without it", &|m| scientific(m.true_rel_mse())));
    }
    if pictures.len() == 2 {
        rows.insert(0, vec![String::new(), "A".to_owned(), "B".to_owned()]);
    }
    table(&rows, &[1, 2])
}

/// What the test says; `exact` is the picture whose noise is not known, if there is one. Pictures with `uneven`
/// layers do not agree.
fn verdict(z: &ZTest, exact: &str, uneven: bool) -> String {
    let exact = match exact {
        "" => String::new(),
        name => format!(" {name} does not say how noisy it is and counts as exact."),
    };
    let verdict = if z.passes() && !uneven {
        "agree within their noise"
    } else if z.fails() {
        "differ by more than their noise"
    } else {
        "cannot be said to agree"
    };
    let counted = |count: usize, what: &str| match count {
        0 => String::new(),
        _ => format!(" {count} more numbers {what}."),
    };
    let others = counted(z.one_sided, "are finite in one of them only")
        + &counted(
            z.unknown,
            "or their variances are not finite, so that nothing can be said of them",
        );
    let mean_square = if z.mean_square.is_finite() {
        format!("{:.3}", z.mean_square)
    } else {
        "unknown".to_owned()
    };
    format!(
        "A and B {verdict}: {} of {} numbers differ beyond chance (p < {:.2e} each, {} for all; {} % may). \
         Mean z squared {mean_square}.{others}{exact}\n",
        z.beyond,
        z.compared,
        z.level,
        ZTest::SIGNIFICANCE,
        100.0 * ZTest::ALLOWANCE,
    )
}

/// Writes the picture, wherever it can go.
fn write(output: &Output, shown: &[Image]) -> Result<Ending, Failure> {
    let image = match shown {
        [left, right] => &side_by_side(left, right),
        _ => &shown[0],
    };
    let place = picture::write(output, &image.to_picture(1), &Metadata::default(), 0.0)?;
    Ok(if place == output.path { Ending::Done } else { Ending::Elsewhere })
}
