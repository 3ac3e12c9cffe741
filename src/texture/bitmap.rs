//! Bitmaps.

use std::sync::{Arc, OnceLock};

use glam::{Affine2, DVec3, IVec2, Vec2};
use half::f16;
use rayon::prelude::*;

use super::Texture;
use super::image::{Image, Texels};
use crate::math::{Rgb, luminance};

/// A picture laid over the unit square of texture coordinates, its first row along v = 0. The centre of
/// the first pixel lies half a pixel inside.
#[derive(Clone, Debug)]
pub struct Bitmap {
    image: Arc<Image>,
    settings: BitmapSettings,
    /// What the integers of the image mean; empty if it has none.
    decoded: Box<[f32]>,
    /// Of all pixels, found when it is first asked for.
    mean: OnceLock<f32>,
}

/// How a [`Bitmap`] is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BitmapSettings {
    /// What the integers of the image mean. Of no effect on images of halves and floats.
    pub encoding: Encoding,
    /// Between pixels.
    pub filter: BitmapFilter,
    /// Outside of the unit square.
    pub wrap: Wrap,
    /// Maps the texture coordinates of the surface to those of the picture.
    pub to_uv: Affine2,
}

/// What the integers of an image mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Light, by the curve of sRGB (IEC 61966-2-1).
    Srgb,
    /// The number that they are.
    Linear,
}

/// What holds between pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitmapFilter {
    /// The nearest pixel.
    Nearest,
    /// Linear interpolation between the centres of four pixels.
    Bilinear,
}

/// What holds outside of the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// The picture again, every other one mirrored.
    Mirror,
    /// The pixels of the border.
    Clamp,
}

impl Bitmap {
    /// `image` as `settings` say.
    #[must_use]
    pub fn new(image: Arc<Image>, settings: BitmapSettings) -> Self {
        let largest = match image.texels() {
            Texels::Unorm8(_) => Some(255u16),
            Texels::Unorm16(_) => Some(u16::MAX),
            Texels::Half(_) | Texels::Float(_) => None,
        };
        let decode = |largest: u16| {
            (0..=largest).map(move |i| {
                let value = f64::from(i) / f64::from(largest);
                match settings.encoding {
                    Encoding::Linear => value as f32,
                    Encoding::Srgb => srgb_to_linear(value) as f32,
                }
            })
        };
        let decoded = largest.map_or_else(Box::default, |largest| decode(largest).collect());
        Self { image, settings, decoded, mean: OnceLock::new() }
    }

    /// The picture.
    #[must_use]
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Where `uv` lies, in pixels from the first corner. Within one period of the picture, or on its border:
    /// multiplied by the size, coordinates of 1e8 would leave the integers. Coordinates that are not finite
    /// count as 0.
    fn in_pixels(&self, uv: Vec2) -> Vec2 {
        let uv = self.settings.to_uv.transform_point2(uv);
        let within = |x: f32| if x.is_finite() { self.settings.wrap.period(x) } else { 0.0 };
        Vec2::new(within(uv.x), within(uv.y)) * self.size().as_vec2()
    }

    fn size(&self) -> IVec2 {
        IVec2::new(self.image.width() as i32, self.image.height() as i32)
    }

    /// The pixel in a column and a row, which may lie outside.
    #[must_use]
    pub fn pixel(&self, at: IVec2) -> Rgb {
        let [x, y] = [(at.x, self.image.width()), (at.y, self.image.height())]
            .map(|(i, count)| self.settings.wrap.index(i, count));
        let channels = self.image.channels();
        let first = (y * self.image.width() as usize + x) * channels;
        let value = |channel: usize| match self.image.texels() {
            Texels::Unorm8(values) => self.decoded[usize::from(values[first + channel])],
            Texels::Unorm16(values) => self.decoded[usize::from(values[first + channel])],
            Texels::Half(values) => values[first + channel].to_f32(),
            Texels::Float(values) => values[first + channel],
        };
        if channels == 1 { Rgb::splat(value(0)) } else { Rgb::new(value(0), value(1), value(2)) }
    }

    /// One number for a colour; that of a grey is exact.
    fn number(&self, color: Rgb) -> f32 {
        if self.image.channels() == 1 { color.x } else { luminance(color) }
    }

    /// The pixels whose centres are around `uv`, and how far it lies on the way between them.
    fn cell(&self, uv: Vec2) -> ([[Rgb; 2]; 2], Vec2) {
        let p = self.in_pixels(uv) - 0.5;
        let corner = p.floor();
        let first = corner.as_ivec2();
        let at = |x, y| self.pixel(first + IVec2::new(x, y));
        ([[at(0, 0), at(1, 0)], [at(0, 1), at(1, 1)]], p - corner)
    }
}

impl Texture for Bitmap {
    fn rgb(&self, uv: Vec2) -> Rgb {
        match self.settings.filter {
            BitmapFilter::Nearest => self.pixel(self.in_pixels(uv).floor().as_ivec2()),
            BitmapFilter::Bilinear => {
                let ([top, bottom], t) = self.cell(uv);
                let row = |[left, right]: [Rgb; 2]| left * (1.0 - t.x) + right * t.x;
                row(top) * (1.0 - t.y) + row(bottom) * t.y
            }
        }
    }

    fn scalar(&self, uv: Vec2) -> f32 {
        self.number(self.rgb(uv))
    }

    fn range(&self) -> [f32; 2] {
        let decoded = |extremes: Option<(usize, usize)>| {
            let (least, most) = extremes.unwrap_or_default();
            [self.decoded[least], self.decoded[most]]
        };
        match self.image.texels() {
            // The curve of sRGB rises.
            Texels::Unorm8(values) => decoded(extremes(values.iter().map(|&v| v.into()))),
            Texels::Unorm16(values) => decoded(extremes(values.iter().map(|&v| v.into()))),
            Texels::Half(values) => of_floats(values.iter().map(|v| v.to_f32())),
            Texels::Float(values) => of_floats(values.iter().copied()),
        }
    }

    fn clamped(&self, [least, most]: [f32; 2]) -> Arc<dyn Texture> {
        let clamp = |value: f32| value.clamp(least, most);
        let texels = match self.image.texels() {
            // Integers stand for 0 to 1, which all that is asked for includes.
            Texels::Unorm8(_) | Texels::Unorm16(_) => return Arc::new(self.clone()),
            Texels::Half(values) => {
                Texels::Half(values.iter().map(|v| f16::from_f32(clamp(v.to_f32()))).collect())
            }
            Texels::Float(values) => Texels::Float(values.iter().map(|&v| clamp(v)).collect()),
        };
        let image = self.image.with_texels(texels).expect("as many as there were");
        Arc::new(Self::new(Arc::new(image), self.settings))
    }

    fn gradient(&self, uv: Vec2) -> Vec2 {
        if self.settings.filter == BitmapFilter::Nearest {
            return Vec2::ZERO;
        }
        let (cell, t) = self.cell(uv);
        let [[f00, f10], [f01, f11]] = cell.map(|row| row.map(|color| self.number(color)));
        let by_pixel = Vec2::new(
            (f10 - f00) * (1.0 - t.y) + (f11 - f01) * t.y,
            (f01 - f00) * (1.0 - t.x) + (f11 - f10) * t.x,
        );
        self.settings.to_uv.matrix2.transpose() * (by_pixel * self.size().as_vec2())
    }

    fn mean(&self) -> f32 {
        *self.mean.get_or_init(|| {
            let (width, height) = (self.size().x, self.size().y);
            let row =
                |y| -> DVec3 { (0..width).map(|x| self.pixel(IVec2::new(x, y)).as_dvec3()).sum() };
            // Row by row, so that the sum does not depend on the number of threads.
            let rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
            let sum: DVec3 = rows.into_iter().sum();
            self.number((sum / (f64::from(width) * f64::from(height))).as_vec3a())
        })
    }
}

impl Wrap {
    /// The coordinate that shows the same as the finite `x`: in `[0, 1]`, or `[0, 2]` if every other picture is
    /// mirrored. What is subtracted is exact.
    fn period(self, x: f32) -> f32 {
        match self {
            Self::Repeat => x - x.floor(),
            Self::Mirror => x - 2.0 * (0.5 * x).floor(),
            Self::Clamp => x.clamp(0.0, 1.0),
        }
    }

    /// The index of the pixel that stands at `i` in a row of `count`.
    fn index(self, i: i32, count: u32) -> usize {
        let (i, count) = (i64::from(i), i64::from(count));
        let index = match self {
            Self::Repeat => i.rem_euclid(count),
            Self::Mirror => {
                let there_and_back = i.rem_euclid(2 * count);
                there_and_back.min(2 * count - 1 - there_and_back)
            }
            Self::Clamp => i.clamp(0, count - 1),
        };
        index as usize
    }
}

fn extremes(mut values: impl Iterator<Item = usize>) -> Option<(usize, usize)> {
    let first = values.next()?;
    Some(values.fold((first, first), |(least, most), v| (least.min(v), most.max(v))))
}

fn of_floats(values: impl Iterator<Item = f32>) -> [f32; 2] {
    values.fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], v| [least.min(v), most.max(v)])
}

/// From the code value in `[0, 1]` to linear light.
fn srgb_to_linear(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
