//! How far a picture is from a reference.
//!
//! With `I` the picture and `R` the reference, linear sRGB, and means over all pixels and channels unless
//! said otherwise:
//!
//! | Metric | Definition |
//! |---|---|
//! | MSE | mean((I − R)²) |
//! | RMSE | √MSE |
//! | relMSE | mean((I − R)² / (R² + 0.01)), Rousselle et al. 2011 |
//! | trimmed relMSE | the same without the ⌊N/1000⌋ of N pixels whose own mean over channels is largest |
//! | 99.9 % quantile, maximum | of those means; the quantile is the smallest that 99.9 % do not exceed |
//! | SMAPE | mean(\|I − R\| / (\|I\| + \|R\| + 0.01)), Vogels et al. 2018 |
//! | ꟻLIP | [`flip()`] |
//! | bias | mean(I − R), with the standard error s/√N, where s is the sample standard deviation over pixels of the difference, each averaged over its channels |
//!
//! Pixels of which a number is not finite, in either picture, are left out and counted. Where the variance
//! v of the reference's numbers is known, its own noise has added mean(v) to the MSE and mean(v / (R² +
//! 0.01)) to the relMSE: both are given, to be subtracted.

use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize};

use super::flip::flip;
use super::image::Image;
use super::statistics::{Moments, p_value};
use crate::film::error::REL_MSE_FLOOR;
use crate::math::Rgb;

/// Keeps SMAPE finite where both are black.
const SMAPE_FLOOR: f64 = 0.01;
/// What is left of an error after the reference's noise is subtracted has to be at least this part of that noise
/// to be known: where ten pixels carry the noise, it is known to √((2 + 2/15)/10) = 46 % of itself, from the one
/// error of each pixel and from its variance over 16 parts.
pub const RESOLUTION: f64 = 0.5;
/// One pixel of so many counts as an outlier.
const PIXELS_PER_OUTLIER: usize = 1000;

/// Metrics of one picture; the module defines them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// Pixels that were compared.
    pub pixels: usize,
    /// Pixels that were left out.
    pub non_finite: usize,
    /// Mean squared error.
    pub mse: f64,
    /// Relative mean squared error.
    pub rel_mse: f64,
    /// Relative mean squared error without outliers.
    pub rel_mse_trimmed: f64,
    /// 99.9 % quantile of the pixels' relative squared errors.
    pub rel_se_quantile: f64,
    /// The largest of them.
    pub rel_se_max: f64,
    /// Symmetric mean absolute percentage error, in `[0, 1]`.
    pub smape: f64,
    /// ꟻLIP, in `[0, 1]`.
    pub flip: f64,
    /// Mean difference: above 0 if the picture is too bright.
    pub bias: f64,
    /// Its standard error, if the noise of different pixels is independent; NaN for a single pixel.
    #[serde(deserialize_with = "null_as_nan")]
    pub bias_error: f64,
    /// Mean of the reference.
    pub reference_mean: f64,
    /// What the reference's own noise has added.
    pub reference_noise: Option<ReferenceNoise>,
}

/// JSON has no NaN, and writers put `null` in its place.
fn null_as_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Parts of an error that the noise of the reference explains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceNoise {
    /// Of the MSE.
    pub mse: f64,
    /// Of the relMSE.
    pub rel_mse: f64,
}

impl Metrics {
    /// Metrics of `image` against `reference`, which must cover the same pixels ([`Image::cut_to`]).
    /// `None` if no pixel is left to be compared.
    ///
    /// # Panics
    /// If the pictures differ in size.
    #[must_use]
    pub fn of(image: &Image, reference: &Image) -> Option<Self> {
        assert_eq!(image.crop, reference.crop, "pictures of the same pixels");
        let finite = |rgb: &Rgb| rgb.is_finite();
        let variance = reference.variance.as_deref();
        let kept: Vec<usize> = (0..image.pixels.len())
            .filter(|&i| finite(&image.pixels[i]) && finite(&reference.pixels[i]))
            .filter(|&i| variance.is_none_or(|v| finite(&v[i])))
            .collect();
        if kept.is_empty() {
            return None;
        }
        let channels = 3.0 * kept.len() as f64;
        let floor = DVec3::splat(REL_MSE_FLOOR);
        let (mut squares, mut smape, mut brightness) = (0.0, 0.0, 0.0);
        let (mut noise, mut rel_noise) = (0.0, 0.0);
        let mut relative = Vec::with_capacity(kept.len());
        let mut differences = Vec::with_capacity(kept.len());
        for &i in &kept {
            let (a, r) = (image.pixels[i].as_dvec3(), reference.pixels[i].as_dvec3());
            let d = a - r;
            squares += (d * d).element_sum();
            relative.push((d * d / (r * r + floor)).element_sum() / 3.0);
            smape += (d.abs() / (a.abs() + r.abs() + SMAPE_FLOOR)).element_sum();
            brightness += r.element_sum();
            differences.push(d.element_sum() / 3.0);
            if let Some(variance) = variance {
                let v = variance[i].as_dvec3();
                noise += v.element_sum();
                rel_noise += (v / (r * r + floor)).element_sum();
            }
        }
        let bias = Moments::of(&differences);
        relative.sort_unstable_by(f64::total_cmp);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let usual = kept.len() - kept.len() / PIXELS_PER_OUTLIER;
        Some(Self {
            pixels: kept.len(),
            non_finite: image.pixels.len() - kept.len(),
            mse: squares / channels,
            rel_mse: mean(&relative),
            rel_mse_trimmed: mean(&relative[..usual]),
            rel_se_quantile: relative[usual - 1],
            rel_se_max: relative[kept.len() - 1],
            smape: smape / channels,
            flip: flip_of_finite(image, reference),
            bias: bias.mean,
            bias_error: bias.standard_error(),
            reference_mean: brightness / channels,
            reference_noise: variance
                .map(|_| ReferenceNoise { mse: noise / channels, rel_mse: rel_noise / channels }),
        })
    }

    /// Root of the mean squared error.
    #[must_use]
    pub fn rmse(&self) -> f64 {
        self.mse.sqrt()
    }

    /// MSE without the reference's own noise, where that is known. It can be below 0 by chance.
    #[must_use]
    pub fn true_mse(&self) -> f64 {
        self.mse - self.reference_noise.map_or(0.0, |n| n.mse)
    }

    /// relMSE likewise.
    #[must_use]
    pub fn true_rel_mse(&self) -> f64 {
        self.rel_mse - self.reference_noise.map_or(0.0, |n| n.rel_mse)
    }

    /// The smallest [true MSE](Self::true_mse) that the reference tells; 0 where its noise is not known.
    #[must_use]
    pub fn least_mse(&self) -> f64 {
        self.reference_noise.map_or(0.0, |n| RESOLUTION * n.mse)
    }

    /// relMSE likewise.
    #[must_use]
    pub fn least_rel_mse(&self) -> f64 {
        self.reference_noise.map_or(0.0, |n| RESOLUTION * n.rel_mse)
    }

    /// Probability of a mean difference as large as this one, or larger, if there is no bias; two-sided.
    #[must_use]
    pub fn bias_p_value(&self) -> f64 {
        p_value(self.bias, self.bias_error, self.pixels as f64 - 1.0)
    }
}

/// ꟻLIP with what is not finite replaced by the reference, or by black in both.
fn flip_of_finite(image: &Image, reference: &Image) -> f64 {
    let clean = |rgb: Rgb| if rgb.is_finite() { rgb } else { Rgb::ZERO };
    let pair = |(a, r): (&Rgb, &Rgb)| {
        let r = clean(*r);
        (if a.is_finite() { *a } else { r }, r)
    };
    let (a, r): (Vec<Rgb>, Vec<Rgb>) = image.pixels.iter().zip(&reference.pixels).map(pair).unzip();
    flip(&a, &r, image.crop.width as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Crop;
    use crate::measure::ZTest;
    use crate::sampler::{Independent, Sampler};

    fn image(pixels: Vec<Rgb>) -> Image {
        let width = pixels.len() as u32;
        let crop = Crop { x: 0, y: 0, width, height: 1 };
        Image { width, height: 1, crop, pixels, variance: None }
    }

    fn grey(values: &[f32]) -> Image {
        image(values.iter().map(|&v| Rgb::splat(v)).collect())
    }

    fn close(a: f64, b: f64) -> bool {
        // Colours are f32, and so carry 6e-8 each of their value into sums of a few of them.
        (a - b).abs() <= 1e-6 * b.abs().max(1e-3)
    }

    /// Two pixels: 1 against 2 and 0.5 against 0.5.
    #[test]
    fn metrics_by_hand() {
        let m = Metrics::of(&grey(&[1.0, 0.5]), &grey(&[2.0, 0.5])).expect("two pixels");
        assert_eq!((m.pixels, m.non_finite), (2, 0));
        assert!(close(m.mse, 0.5) && close(m.rmse(), 0.5_f64.sqrt()));
        assert!(close(m.rel_mse, 1.0 / 4.01 / 2.0));
        // Fewer than a thousand pixels have no outliers.
        assert_eq!(m.rel_mse_trimmed, m.rel_mse);
        assert!(close(m.rel_se_max, 1.0 / 4.01) && close(m.rel_se_quantile, 1.0 / 4.01));
        assert!(close(m.smape, 1.0 / 3.01 / 2.0));
        // Differences −1 and 0: mean −1/2, standard deviation 1/√2, of the mean 1/2.
        assert!(close(m.bias, -0.5) && close(m.bias_error, 0.5));
        assert!(close(m.reference_mean, 1.25));
        assert_eq!(m.reference_noise, None);
        // t = 1 with one degree of freedom, where Student's distribution is Cauchy's: 1/2.
        assert!((m.bias_p_value() - 0.5).abs() < 1e-9);
    }

    #[test]
    fn channels_count_alike() {
        let m = Metrics::of(
            &image(vec![Rgb::new(1.0, 2.0, 3.0)]),
            &image(vec![Rgb::new(1.0, 1.0, 1.0)]),
        );
        let m = m.expect("one pixel");
        assert!(close(m.mse, 5.0 / 3.0) && close(m.rel_mse, 5.0 / 3.0 / 1.01));
        assert!(close(m.bias, 1.0) && m.bias_error.is_nan());
        assert!(close(m.smape, (1.0 / 3.01 + 2.0 / 4.01) / 3.0));
    }

    /// 2000 pixels, three of which are wrong: by 1 (relative square 100 where the reference is black), by 2
    /// and by 3. Two outliers are dropped, the quantile is the third largest.
    #[test]
    fn outliers_are_shown_apart() {
        let mut values = vec![0.0; 2000];
        [values[5], values[700], values[1999]] = [2.0, 3.0, 1.0];
        let m = Metrics::of(&grey(&values), &grey(&[0.0; 2000])).expect("pixels");
        assert!(close(m.rel_mse, 1400.0 / 2000.0), "{m:?}");
        assert!(close(m.rel_mse_trimmed, 100.0 / 1998.0), "{m:?}");
        assert!(close(m.rel_se_quantile, 100.0) && close(m.rel_se_max, 900.0));
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let reference = grey(&[0.0, 1.0, 1.0, f32::INFINITY]);
        let m = Metrics::of(&grey(&[0.0, f32::NAN, 3.0, 1.0]), &reference).expect("two pixels");
        assert_eq!((m.pixels, m.non_finite), (2, 2));
        assert!(close(m.mse, 2.0) && m.flip.is_finite());
        assert_eq!(Metrics::of(&grey(&[f32::NAN]), &grey(&[1.0])), None);
    }

    fn normals(seed: u64, count: u32) -> impl Iterator<Item = f32> {
        let sampler = Independent::new(seed);
        // Box and Muller 1958.
        (0..count).map(move |i| {
            let u = sampler.get_2d(sampler.path(i, 0), 0);
            (-2.0 * (1.0 - u.x).ln()).sqrt() * (std::f32::consts::TAU * u.y).cos()
        })
    }

    /// A picture with the noise 0.2 against a reference with the noise 0.1 of the same truth: what is left
    /// of the MSE is 0.04. Of 30 000 numbers the mean of squares with variance 0.05 errs by
    /// 0.05·√(2/30000) = 4.1e-4; four of these are allowed.
    #[test]
    fn the_references_noise_is_subtracted() {
        let noisy = |seed, deviation: f32| {
            let pixels: Vec<f32> = normals(seed, 30_000).map(|n| 1.0 + deviation * n).collect();
            image(pixels.chunks(3).map(Rgb::from_slice).collect())
        };
        let mut reference = noisy(2, 0.1);
        reference.variance = Some(vec![Rgb::splat(0.01); 10_000]);
        let m = Metrics::of(&noisy(1, 0.2), &reference).expect("pixels");
        assert!((m.true_mse() - 0.04).abs() < 1.7e-3, "{m:?}");
        assert!((m.mse - 0.05).abs() < 1.7e-3, "{m:?}");
        assert!(m.true_rel_mse() < m.rel_mse);
    }

    /// The test passes for equal means, and fails where one pixel in 200 is off by ten standard deviations. A
    /// tenth of one in all pixels is too little for it, but not for the mean over the picture.
    #[test]
    fn differences_beyond_noise_are_found() {
        let noisy = |seed, add: &dyn Fn(usize) -> f32| {
            let pixels: Vec<Rgb> = normals(seed, 10_000)
                .enumerate()
                .map(|(i, n)| Rgb::splat(1.0 + n + add(i)))
                .collect();
            Image { variance: Some(vec![Rgb::ONE; 10_000]), ..image(pixels) }
        };
        let a = noisy(3, &|_| 0.0);
        let same = ZTest::of(&a, &noisy(4, &|_| 0.0)).expect("variances");
        assert!(same.passes() && same.beyond <= 3, "{same:?}");
        // z² has the mean 1 and the variance 2: 4·√(2/10000) = 0.057.
        assert!((same.mean_square - 1.0).abs() < 0.057, "{same:?}");
        let spots = ZTest::of(&a, &noisy(4, &|i| if i % 200 == 0 { 10.0 } else { 0.0 }));
        let spots = spots.expect("variances");
        assert!(!spots.passes() && (100..=150).contains(&spots.beyond), "{spots:?}");
        let brighter = noisy(5, &|_| 0.1);
        assert!(ZTest::of(&a, &brighter).expect("variances").passes());
        let p_value = |b: &Image| Metrics::of(&a, b).expect("pixels").bias_p_value();
        assert!(p_value(&brighter) < 0.01 && p_value(&noisy(4, &|_| 0.0)) > 0.01);
        assert_eq!(ZTest::of(&grey(&[1.0]), &grey(&[1.0])), None);
    }

    /// What is not finite in one picture alone is a difference; of what cannot be tested nothing is said.
    #[test]
    fn what_is_not_finite_is_no_agreement() {
        let with = |values: &[f32], variance: f32| Image {
            variance: Some(vec![Rgb::splat(variance); values.len()]),
            ..grey(values)
        };
        let (inf, nan) = (f32::INFINITY, f32::NAN);
        for (a, b, one_sided, unknown) in [
            (with(&[1.0, 1.0], 1.0), with(&[1.0, 1.0], 1.0), 0, 0),
            (with(&[1.0, inf], 1.0), with(&[1.0, 1.0], 1.0), 3, 0),
            (with(&[1.0, 1.0], 1.0), with(&[nan, 1.0], 1.0), 3, 0),
            (with(&[1.0, inf], 1.0), with(&[1.0, inf], 1.0), 0, 3),
            (with(&[1.0, nan], 1.0), with(&[1.0, nan], 1.0), 0, 3),
            (with(&[1.0, 1.0], inf), with(&[1.0, 1.0], 1.0), 0, 6),
            (with(&[1.0, 1.0], nan), with(&[1.0, 1.0], 1.0), 0, 6),
        ] {
            let z = ZTest::of(&a, &b).expect("variances");
            assert_eq!(
                (z.one_sided, z.unknown, z.compared),
                (one_sided, unknown, 6 - one_sided - unknown)
            );
            assert_eq!((z.fails(), z.passes()), (one_sided > 0, one_sided + unknown == 0), "{z:?}");
        }
    }
}
