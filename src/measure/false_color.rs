//! Differences as colours.

use super::image::Image;
use crate::math::{Rgb, luminance};

/// The relative difference that is shown in full colour, and decades below it that are shown at all.
const FULL: f32 = 1.0;
const DECADES: f32 = 3.0;

/// Where a picture is brighter (orange) or darker (blue) than a reference that covers the same pixels.
///
/// The difference of a pixel's luminance is divided by the reference's luminance plus 0.01. From black for
/// 0.1 % or less, colours rise with its logarithm to full strength for 100 % or more. What is not finite is
/// kept as it is. The colours are linear sRGB.
///
/// # Panics
/// If the pictures differ in size.
#[must_use]
pub fn false_color(image: &Image, reference: &Image) -> Image {
    assert_eq!(image.crop, reference.crop, "pictures of the same pixels");
    let pixel = |(a, r): (&Rgb, &Rgb)| {
        let (a, r) = (luminance(*a), luminance(*r));
        color((a - r) / (r.abs() + 0.01))
    };
    let pixels = image.pixels.iter().zip(&reference.pixels).map(pixel).collect();
    Image { pixels, variance: None, ..*image }
}

/// Two pictures of the same size side by side.
///
/// # Panics
/// If they differ in size.
#[must_use]
pub fn side_by_side(left: &Image, right: &Image) -> Image {
    assert_eq!(left.crop, right.crop, "pictures of the same pixels");
    let width = left.crop.width as usize;
    let rows = left.pixels.chunks(width).zip(right.pixels.chunks(width));
    let pixels = rows.flat_map(|(l, r)| l.iter().chain(r).copied()).collect();
    let mut both = Image { pixels, variance: None, ..*left };
    both.crop.width *= 2;
    (both.crop.x, both.crop.y) = (0, 0);
    (both.width, both.height) = (both.crop.width, both.crop.height);
    both
}

fn color(difference: f32) -> Rgb {
    if !difference.is_finite() {
        return Rgb::NAN;
    }
    let decades = (difference.abs() / FULL).log10() / DECADES;
    let strength = (1.0 + decades).clamp(0.0, 1.0);
    let hue = if difference > 0.0 { Rgb::new(1.0, 0.35, 0.05) } else { Rgb::new(0.05, 0.35, 1.0) };
    // Squared, so that it rises evenly for the eye.
    hue * strength * strength
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Crop;

    fn row(values: &[f32]) -> Image {
        let width = values.len() as u32;
        let crop = Crop { x: 2, y: 3, width, height: 1 };
        let pixels = values.iter().map(|&v| Rgb::splat(v)).collect();
        Image { width: 9, height: 9, crop, pixels, variance: None }
    }

    #[test]
    fn colours_say_which_way_and_how_much() {
        let shown =
            false_color(&row(&[1.0, 1.0005, 1.02, 4.0, 0.98, 0.0, f32::NAN]), &row(&[1.0; 7]));
        let strength = |i: usize| shown.pixels[i].max_element();
        assert_eq!(shown.pixels[0], Rgb::ZERO);
        assert_eq!(strength(1), 0.0);
        assert_eq!(strength(3), 1.0);
        // log10(0.02/1.01) is −1.70: (1 − 1.70/3)² = 0.187.
        assert!((strength(2) - 0.187).abs() < 2e-3 && (strength(4) - 0.187).abs() < 2e-3);
        assert!(shown.pixels[2].x > shown.pixels[2].z && shown.pixels[4].z > shown.pixels[4].x);
        assert!(strength(5) > 0.99);
        assert!(shown.pixels[6].is_nan());
    }

    #[test]
    fn rows_stay_rows_beside_each_other() {
        let (mut left, mut right) = (row(&[1.0, 2.0]), row(&[3.0, 4.0]));
        for image in [&mut left, &mut right] {
            image.crop = Crop { x: 2, y: 3, width: 1, height: 2 };
        }
        let both = side_by_side(&left, &right);
        let values: Vec<f32> = both.pixels.iter().map(|rgb| rgb.x).collect();
        assert_eq!(values, [1.0, 3.0, 2.0, 4.0]);
        assert_eq!((both.width, both.height, both.crop.width, both.crop.height), (2, 2, 2, 2));
    }
}
