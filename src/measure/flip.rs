//! ꟻLIP: how different two pictures look to someone who flips between them.

use glam::{Mat3A, Vec3A};

use crate::math::Rgb;

/// Pixels per degree of visual angle: a display 0.7 m wide with 3840 pixels seen from 0.7 m, as in
/// Andersson et al. 2020.
const PIXELS_PER_DEGREE: f32 = 67.020_64;

/// Exponents and limits of the same paper: q_c, p_c, p_t, w and q_f.
const COLOR_EXPONENT: f32 = 0.7;
const COLOR_KNEE: f32 = 0.4;
const COLOR_KNEE_VALUE: f32 = 0.95;
const FEATURE_WIDTH_DEG: f32 = 0.082;
const FEATURE_EXPONENT: f32 = 0.5;

/// Linear sRGB to XYZ, by columns, and the XYZ of its white.
const XYZ_FROM_RGB: Mat3A = Mat3A::from_cols(
    Vec3A::new(0.412_386_56, 0.212_636_82, 0.019_330_62),
    Vec3A::new(0.357_591_5, 0.715_183, 0.119_197_16),
    Vec3A::new(0.180_450_5, 0.072_180_2, 0.950_372_6),
);
const WHITE: Vec3A = Vec3A::new(0.950_428_57, 1.0, 1.088_900_4);

/// Mean over all pixels of ꟻLIP, in `[0, 1]`: 0 for pictures that look alike.
///
/// Pictures are linear sRGB, row by row, `width` pixels to a row; what lies outside of `[0, 1]` is clamped,
/// as a display does. Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "ꟻLIP: A
/// Difference Evaluator for Alternating Images", 2020, equations 1 to 13, at 67 pixels per degree.
///
/// # Panics
/// If the pictures are empty, differ in size or do not consist of whole rows.
#[must_use]
pub fn flip(image: &[Rgb], reference: &[Rgb], width: usize) -> f64 {
    assert!(!image.is_empty() && image.len() == reference.len(), "two pictures of one size");
    assert!(width > 0 && image.len().is_multiple_of(width), "whole rows");
    let [a, b] = [image, reference].map(|pixels| Appearance::of(pixels, width));
    let largest = hyab(hunt(lab(Vec3A::Y)), hunt(lab(Vec3A::Z))).powf(COLOR_EXPONENT);
    let pixel = |i: usize| {
        let color = redistribute(hyab(a.colors[i], b.colors[i]).powf(COLOR_EXPONENT), largest);
        let (edge, point) = (a.features[i].0 - b.features[i].0, a.features[i].1 - b.features[i].1);
        let feature = edge.abs().max(point.abs()) * std::f32::consts::FRAC_1_SQRT_2;
        f64::from(color.powf(1.0 - feature.powf(FEATURE_EXPONENT)))
    };
    (0..image.len()).map(pixel).sum::<f64>() / image.len() as f64
}

/// What the eye makes of each pixel.
struct Appearance {
    /// CIELAB after the eye's blur, with Hunt's effect.
    colors: Vec<Vec3A>,
    /// Strength of edges and of points.
    features: Vec<(f32, f32)>,
}

impl Appearance {
    fn of(pixels: &[Rgb], width: usize) -> Self {
        let opponent: Vec<Vec3A> =
            pixels.iter().map(|rgb| opponent(rgb.clamp(Vec3A::ZERO, Vec3A::ONE))).collect();
        let blurred = blur(&opponent, width);
        let seen = |c: &Vec3A| hunt(lab(rgb(*c).clamp(Vec3A::ZERO, Vec3A::ONE)));
        let luminance: Vec<f32> = opponent.iter().map(|c| (c.x + 16.0) / 116.0).collect();
        Self { colors: blurred.iter().map(seen).collect(), features: features(&luminance, width) }
    }
}

/// YCxCz, the linearised CIELAB of Flohr et al. 1993.
fn opponent(rgb: Vec3A) -> Vec3A {
    let v = XYZ_FROM_RGB * rgb / WHITE;
    Vec3A::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
}

/// The inverse of [`opponent`].
fn rgb(opponent: Vec3A) -> Vec3A {
    let y = (opponent.x + 16.0) / 116.0;
    let v = Vec3A::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
    XYZ_FROM_RGB.inverse() * (v * WHITE)
}

/// CIELAB of linear sRGB.
fn lab(rgb: Vec3A) -> Vec3A {
    const DELTA: f32 = 6.0 / 29.0;
    let f = |t: f32| {
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let v = XYZ_FROM_RGB * rgb / WHITE;
    let (x, y, z) = (f(v.x), f(v.y), f(v.z));
    Vec3A::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Colours look paler where it is dark (Hunt 1952).
fn hunt(lab: Vec3A) -> Vec3A {
    let scale = 0.01 * lab.x;
    Vec3A::new(lab.x, scale * lab.y, scale * lab.z)
}

/// Distance for large differences of colour (Abasi et al. 2020).
fn hyab(a: Vec3A, b: Vec3A) -> f32 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// Maps `[0, largest]` to `[0, 1]`, with most of the range for the smaller differences.
fn redistribute(difference: f32, largest: f32) -> f32 {
    let knee = COLOR_KNEE * largest;
    if difference < knee {
        COLOR_KNEE_VALUE / knee * difference
    } else {
        let beyond = (difference - knee) / (largest - knee);
        COLOR_KNEE_VALUE + beyond * (1.0 - COLOR_KNEE_VALUE)
    }
}

/// The eye's contrast sensitivity as a blur of the opponent channels (Johnson and Fairchild 2003): one
/// Gaussian for luminance and one for red-green, the sum of two for blue-yellow.
fn blur(opponent: &[Vec3A], width: usize) -> Vec<Vec3A> {
    const LARGEST: f32 = 0.04;
    let pi_squared = std::f32::consts::PI * std::f32::consts::PI;
    let radius = (3.0 * (LARGEST / (2.0 * pi_squared)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let gaussian = |b: f32| {
        move |x: i32| {
            let degrees = x as f32 / PIXELS_PER_DEGREE;
            (-pi_squared * degrees * degrees / b).exp()
        }
    };
    let total = |b: f32| (-radius..=radius).map(gaussian(b)).sum::<f32>();
    // Weight of each of the two in the whole plane: a·√(π/b) times the sum of its values.
    let weight = |a: f32, b: f32| a / b.sqrt() * total(b) * total(b);
    let (broad, narrow) = (weight(34.1, 0.04), weight(13.5, 0.025));
    let pass = |b: Vec3A| {
        let totals = Vec3A::from_array(b.to_array().map(total));
        let kernel: Vec<Vec3A> = (-radius..=radius)
            .map(|x| Vec3A::from_array(b.to_array().map(|b| gaussian(b)(x))) / totals)
            .collect();
        let rows = convolve(opponent, width, &kernel, Axis::Row);
        convolve(&rows, width, &kernel, Axis::Column)
    };
    let first = pass(Vec3A::new(0.0047, 0.0053, 0.04));
    let second = pass(Vec3A::new(0.0047, 0.0053, 0.025));
    let mix = |(a, b): (&Vec3A, &Vec3A)| {
        Vec3A::new(a.x, a.y, (broad * a.z + narrow * b.z) / (broad + narrow))
    };
    first.iter().zip(&second).map(mix).collect()
}

/// Strength of edges (first derivative of a Gaussian) and of points (second derivative), whose positive
/// and negative weights each have the sum 1.
fn features(luminance: &[f32], width: usize) -> Vec<(f32, f32)> {
    let deviation = 0.5 * FEATURE_WIDTH_DEG * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let taps: Vec<f32> = (-radius..=radius).map(|x| x as f32).collect();
    let normalized = |weight: &dyn Fn(f32) -> f32| -> Vec<f32> {
        let values: Vec<f32> = taps.iter().map(|&x| weight(x)).collect();
        let positive: f32 = values.iter().filter(|v| **v > 0.0).sum();
        let negative: f32 = -values.iter().filter(|v| **v < 0.0).sum::<f32>();
        values
            .iter()
            .map(|&v| if v > 0.0 { v / positive } else { v / negative.max(1e-9) })
            .collect()
    };
    let squared = deviation * deviation;
    let bell = |x: f32| (-x * x / (2.0 * squared)).exp();
    let smooth = normalized(&bell);
    let edge = normalized(&|x| -x * bell(x));
    let point = normalized(&|x| (x * x / squared - 1.0) * bell(x));
    let taps = || edge.iter().zip(&point).zip(&smooth);
    let rows: Vec<Vec3A> = luminance.iter().map(|&y| Vec3A::splat(y)).collect();
    let kernel: Vec<Vec3A> = taps().map(|((&e, &p), &s)| Vec3A::new(e, p, s)).collect();
    let rows = convolve(&rows, width, &kernel, Axis::Row);
    // Across the rows what was derived along them is smoothed, and the other way round.
    let along: Vec<Vec3A> = smooth.iter().map(|&s| Vec3A::splat(s)).collect();
    let along = convolve(&rows, width, &along, Axis::Column);
    let smoothed: Vec<Vec3A> = rows.iter().map(|r| Vec3A::splat(r.z)).collect();
    let across = convolve(&smoothed, width, &kernel, Axis::Column);
    let strength = |(x, y): (&Vec3A, &Vec3A)| (x.x.hypot(y.x), x.y.hypot(y.y));
    along.iter().zip(&across).map(strength).collect()
}

#[derive(Clone, Copy)]
enum Axis {
    Row,
    Column,
}

/// Sums of neighbours along one axis, weighted channel by channel with a kernel of odd length; beyond the
/// border its pixels are repeated.
fn convolve(values: &[Vec3A], width: usize, kernel: &[Vec3A], axis: Axis) -> Vec<Vec3A> {
    let height = values.len() / width;
    let (length, stride) = match axis {
        Axis::Row => (width, 1),
        Axis::Column => (height, width),
    };
    let radius = kernel.len() / 2;
    let mut sums = Vec::with_capacity(values.len());
    for index in 0..values.len() {
        let place = index / stride % length;
        let start = index - place * stride;
        let tap = |(k, weight): (usize, &Vec3A)| {
            let neighbour = (place + k).saturating_sub(radius).min(length - 1);
            *weight * values[start + neighbour * stride]
        };
        sums.push(kernel.iter().enumerate().map(tap).sum());
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 32;
    const HEIGHT: usize = 24;

    fn picture(color: impl Fn(usize, usize) -> [f32; 3]) -> Vec<Rgb> {
        let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
        pixels.map(|(x, y)| Rgb::from_array(color(x, y))).collect()
    }

    fn ramp(x: usize, y: usize) -> [f32; 3] {
        let (x, y) = (x as f32 / WIDTH as f32, y as f32 / HEIGHT as f32);
        [x, y, 0.5 * (x + y)]
    }

    /// Means that the authors' own `flip-evaluator` 1.7 (PyPI) computes from the same linear pictures with
    /// `evaluate(reference, test, "LDR", inputsRGB=False)`. Both are 32-bit computations: 21 taps, powers
    /// and roots leave 1e-5 in values of at most 1; square roots of differences near 0 the rest.
    #[test]
    fn the_authors_program_agrees() {
        let patch = |x: usize, y: usize| {
            let inside = (8..12).contains(&y) && (10..14).contains(&x);
            if inside { [1.0, 0.2, 0.1] } else { ramp(x, y) }
        };
        let noisy = |x: usize, y: usize| {
            let sign = if (x + y).is_multiple_of(2) { 0.2 } else { -0.2 };
            ramp(x, y).map(|v| (v + sign).clamp(0.0, 1.0))
        };
        let edge = |at: usize| move |x: usize, _: usize| [if x < at { 0.1 } else { 0.8 }; 3];
        let plain = |color: [f32; 3]| picture(move |_, _| color);
        let cases = [
            ("a patch", picture(ramp), picture(patch), 0.036_524),
            ("a checkerboard", picture(ramp), picture(noisy), 0.171_020),
            ("an edge that moved", picture(edge(16)), picture(edge(18)), 0.118_012),
            ("two greys", plain([0.25; 3]), plain([0.5; 3]), 0.451_902),
            ("black and white", plain([0.0; 3]), plain([1.0; 3]), 0.967_391),
            ("green and blue", plain([0.0, 1.0, 0.0]), plain([0.0, 0.0, 1.0]), 1.0),
        ];
        for (name, reference, test, expected) in cases {
            let mean = flip(&test, &reference, WIDTH);
            assert!((mean - expected).abs() < 5e-5, "{name}: {mean} instead of {expected}");
        }
    }

    #[test]
    fn a_picture_looks_like_itself() {
        let bright = picture(|x, y| ramp(x, y).map(|v| v + 1.0));
        assert_eq!(flip(&picture(ramp), &picture(ramp), WIDTH), 0.0);
        // A display shows no difference beyond its white.
        assert_eq!(flip(&bright, &picture(|_, _| [1.0; 3]), WIDTH), 0.0);
        // A picture smaller than any kernel.
        assert!(flip(&[Rgb::ZERO], &[Rgb::ONE], 1) > 0.9);
    }
}
