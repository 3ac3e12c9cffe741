//! Pictures as metrics see them: colours, where they lie on the film, how precisely they are known.

use crate::film::picture::{Picture, Values};
use crate::film::{ComponentFormat, Crop, Film};
use crate::math::Rgb;

/// The colours of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width of the whole film in pixels.
    pub width: u32,
    /// Height of the whole film in pixels.
    pub height: u32,
    /// The part of it that the pixels cover.
    pub crop: Crop,
    /// Linear sRGB, row by row over the crop.
    pub pixels: Vec<Rgb>,
    /// Variance of each of these numbers, where it is known.
    pub variance: Option<Vec<Rgb>>,
}

/// Why a picture cannot be measured.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// A colour is missing.
    #[error("there is no channel `{0}` (expected R, G and B)")]
    NoChannel(&'static str),
    /// The films differ.
    #[error(
        "a film of {}x{} pixels cannot be compared with one of {}x{}", .0.0, .0.1, .1.0, .1.1
    )]
    Sizes((u32, u32), (u32, u32)),
    /// One does not cover the other.
    #[error("pixels {0} are not within pixels {1} of the other picture")]
    Crops(Area, Area),
}

/// A crop, as shown in messages: `64x48 at 0,16`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area(pub Crop);

impl std::fmt::Display for Area {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Crop { x, y, width, height } = self.0;
        write!(f, "{width}x{height} at {x},{y}")
    }
}

impl Image {
    /// Means over the samples of a film; their variance is not known.
    #[must_use]
    pub fn from_film(film: &Film) -> Self {
        let settings = film.settings();
        Self {
            width: settings.width,
            height: settings.height,
            crop: settings.crop,
            pixels: film.radiance(),
            variance: None,
        }
    }

    /// The colours of a picture. If it has the layers `variance.R`, `.G` and `.B` (sample variance of one
    /// sample) and `samples.N` (how many there are), the variance of a pixel is their quotient; to it
    /// comes what rounding to half precision adds.
    ///
    /// # Errors
    /// [`ImageError::NoChannel`].
    pub fn from_picture(picture: &Picture) -> Result<Self, ImageError> {
        let color = |name| picture.color(name).ok_or(ImageError::NoChannel(name));
        let (red, green, blue) = (color("R")?, color("G")?, color("B")?);
        let zip = |r: &[f32], g: &[f32], b: &[f32]| -> Vec<Rgb> {
            r.iter().zip(g).zip(b).map(|((&r, &g), &b)| Rgb::new(r, g, b)).collect()
        };
        let pixels = zip(red, green, blue);
        let layer = |name: &str| {
            let channel = picture.channels.iter().find(|c| c.name == name)?;
            match &channel.values {
                Values::Float(values) => Some(values.as_slice()),
                Values::Color(_) | Values::Index(_) => None,
            }
        };
        let samples = picture.channels.iter().find(|c| c.name == "samples.N");
        let layers = ["variance.R", "variance.G", "variance.B"].map(layer);
        let variance = match (layers, samples.map(|c| &c.values)) {
            ([Some(r), Some(g), Some(b)], Some(Values::Index(samples))) => {
                let of_mean = |(v, &n): (Rgb, &u32)| v / n as f32;
                let known = zip(r, g, b).into_iter().zip(samples).map(of_mean);
                let rounding = |rgb: &Rgb| match picture.component {
                    ComponentFormat::Half => rounding_variance(*rgb),
                    ComponentFormat::Float => Rgb::ZERO,
                };
                Some(known.zip(&pixels).map(|(v, rgb)| v + rounding(rgb)).collect())
            }
            _ => None,
        };
        let (width, height, crop) = (picture.width, picture.height, picture.crop);
        Ok(Self { width, height, crop, pixels, variance })
    }

    /// Colours as a picture in 32 bits, with the variance, if it is known, as that of `samples` samples
    /// each.
    #[must_use]
    pub fn to_picture(&self, samples: u32) -> Picture {
        use crate::film::picture::Channel;
        let plane = |pixels: &[Rgb], c: usize, scale: f32| -> Vec<f32> {
            pixels.iter().map(|rgb| rgb[c] * scale).collect()
        };
        let mut channels = Vec::new();
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push(Channel::new(name, Values::Color(plane(&self.pixels, c, 1.0))));
            if let Some(variance) = &self.variance {
                let values = Values::Float(plane(variance, c, samples as f32));
                channels.push(Channel::new(format!("variance.{name}"), values));
            }
        }
        if self.variance.is_some() {
            let counts = Values::Index(vec![samples; self.pixels.len()]);
            channels.push(Channel::new("samples.N", counts));
        }
        let (width, height, crop) = (self.width, self.height, self.crop);
        Picture { width, height, crop, channels, component: ComponentFormat::Float }
    }

    /// The part of this picture that `other` covers.
    ///
    /// # Errors
    /// Films of different size; a part of `other` that is missing here.
    pub fn cut_to(&self, other: &Self) -> Result<Self, ImageError> {
        let (mine, its) = ((self.width, self.height), (other.width, other.height));
        if mine != its {
            return Err(ImageError::Sizes(its, mine));
        }
        let (from, to) = (self.crop, other.crop);
        let within = |start: u32, length: u32, first: u32, all: u32| {
            start >= first
                && u64::from(start) + u64::from(length) <= u64::from(first) + u64::from(all)
        };
        if !within(to.x, to.width, from.x, from.width)
            || !within(to.y, to.height, from.y, from.height)
        {
            return Err(ImageError::Crops(Area(to), Area(from)));
        }
        let cut = |pixels: &[Rgb]| -> Vec<Rgb> {
            let rows = pixels.chunks_exact(from.width as usize).skip((to.y - from.y) as usize);
            rows.take(to.height as usize)
                .flat_map(|row| &row[(to.x - from.x) as usize..][..to.width as usize])
                .copied()
                .collect()
        };
        Ok(Self {
            crop: to,
            pixels: cut(&self.pixels),
            variance: self.variance.as_deref().map(cut),
            ..*self
        })
    }
}

/// Variance of the error that rounding to half precision makes: an error that is uniform over one unit
/// in the last place, 2⁻¹⁰ of the power of 2 below the number or 2⁻²⁴ near 0, has 1/12 of its square.
fn rounding_variance(rgb: Rgb) -> Rgb {
    let unit = |v: f32| (v.abs().max(6.1e-5).log2().floor() - 10.0).exp2();
    Rgb::from_array(rgb.to_array().map(|v| unit(v) * unit(v) / 12.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, crop: [u32; 4]) -> Image {
        let [x, y, w, h] = crop;
        // The colour says where on the film the pixel is.
        let pixels = (y..y + h).flat_map(|y| (x..x + w).map(move |x| (x, y)));
        let pixels = pixels.map(|(x, y)| Rgb::new(x as f32, y as f32, 0.0)).collect();
        Image { width, height, crop: Crop { x, y, width: w, height: h }, pixels, variance: None }
    }

    #[test]
    fn a_cut_is_the_same_place_of_the_film() {
        let whole = image(8, 6, [1, 1, 6, 5]);
        for crop in [[1, 1, 6, 5], [3, 2, 2, 1], [6, 5, 1, 1]] {
            let part = image(8, 6, crop);
            assert_eq!(whole.cut_to(&part), Ok(part));
        }
        let message = |other: &Image| whole.cut_to(other).expect_err("refused").to_string();
        assert_eq!(
            message(&image(8, 7, [1, 1, 1, 1])),
            "a film of 8x7 pixels cannot be compared with one of 8x6"
        );
        assert_eq!(
            message(&image(8, 6, [0, 1, 2, 2])),
            "pixels 2x2 at 0,1 are not within pixels 6x5 at 1,1 of the other picture"
        );
        assert!(whole.cut_to(&image(8, 6, [6, 1, 2, 1])).is_err());
    }

    /// Through a picture and back: the variance of the mean is what it was, and half precision adds its
    /// own.
    #[test]
    fn variance_is_that_of_the_mean() {
        let mut image = image(2, 1, [0, 0, 2, 1]);
        image.variance = Some(vec![Rgb::new(0.5, 0.25, 0.0), Rgb::ONE]);
        let mut picture = image.to_picture(4);
        assert_eq!(Image::from_picture(&picture), Ok(image.clone()));
        picture.component = ComponentFormat::Half;
        let half = Image::from_picture(&picture).expect("complete");
        let added = half.variance.expect("known")[1].x - 1.0;
        // One unit in the last place of 1.0 is 2⁻¹⁰: 2⁻²⁰/12 = 7.9e-8, within the rounding of 1 + that.
        assert!((added - 7.9e-8).abs() <= f32::EPSILON, "{added}");
        image.variance = None;
        assert_eq!(Image::from_picture(&image.to_picture(4)), Ok(image));
    }

    #[test]
    fn colours_are_needed() {
        let mut picture = image(2, 1, [0, 0, 2, 1]).to_picture(1);
        picture.channels.retain(|c| c.name != "G");
        let error = Image::from_picture(&picture).expect_err("no green").to_string();
        assert_eq!(error, "there is no channel `G` (expected R, G and B)");
    }
}
