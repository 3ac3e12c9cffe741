//! Bitmaps.

use std::convert::identity;
use std::sync::{Arc, OnceLock};

use glam::{Affine2, DVec3, IVec2};
use half::f16;
use rayon::prelude::*;

use super::image::{Image, Texels};
use super::{Pattern, Texture, mapped};
use crate::math::Rgb;
use crate::math::real::{Lanes, Real};
use crate::math::vector::{Vec2, Vec3};

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
    #[inline(always)]
    fn in_pixels<R: Real>(&self, uv: Vec2<R>) -> Vec2<R> {
        let Vec2 { x: u, y: v } = mapped(&self.settings.to_uv, uv);
        let (size, wrap) = (self.size(), self.settings.wrap);
        Vec2::new(wrap.period(u) * size.x, wrap.period(v) * size.y)
    }

    fn size(&self) -> Vec2 {
        Vec2::new(self.image.width() as f32, self.image.height() as f32)
    }

    /// The pixel in a column and a row, which may lie outside.
    #[must_use]
    pub fn pixel(&self, at: IVec2) -> Rgb {
        let [x, y] = [(at.x, self.image.width()), (at.y, self.image.height())]
            .map(|(i, count)| self.settings.wrap.index(i.into(), count));
        self.texel(x, y)
    }

    /// The pixel in a column and a row of the picture.
    #[inline(always)]
    fn texel(&self, x: usize, y: usize) -> Rgb {
        let channels = self.image.channels();
        let first = (y * self.image.width() as usize + x) * channels;
        let texels = first..first + channels;
        match self.image.texels() {
            Texels::Unorm8(values) => color(&values[texels], |i| self.decoded[usize::from(i)]),
            Texels::Unorm16(values) => color(&values[texels], |i| self.decoded[usize::from(i)]),
            Texels::Half(values) => color(&values[texels], f16::to_f32),
            Texels::Float(values) => color(&values[texels], identity),
        }
    }

    /// One number for a colour; that of a grey is exact.
    #[inline(always)]
    fn number<R: Real>(&self, color: Vec3<R>) -> R {
        if self.image.channels() == 1 { color.x } else { color.luminance() }
    }

    /// The pixels whose centres are around `uv`, in rows, and how far it lies on the way between them.
    #[inline(always)]
    fn cell<R: Real>(&self, uv: Vec2<R>) -> ([[Vec3<R>; 2]; 2], Vec2<R>) {
        let p = self.in_pixels(uv).map(|x| x - 0.5);
        let corner = p.map(R::floor);
        // By row, column, channel and lane.
        let mut values = [[[[0.0; 8]; 3]; 2]; 2];
        for lane in 0..R::LANES {
            let first = corner.lane(lane);
            let (xs, ys) =
                (self.both(first.x, self.image.width()), self.both(first.y, self.image.height()));
            for (values, y) in values.iter_mut().zip(ys) {
                for (values, x) in values.iter_mut().zip(xs) {
                    for (values, value) in values.iter_mut().zip(self.texel(x, y).to_array()) {
                        values[lane] = value;
                    }
                }
            }
        }
        let load = |values: &[f32; 8]| R::load(uv.token(), &values[..R::LANES]);
        let at = |[r, g, b]: &[[f32; 8]; 3]| Vec3::new(load(r), load(g), load(b));
        let [[a, b], [c, d]] = &values;
        ([[at(a), at(b)], [at(c), at(d)]], p - corner)
    }

    /// The index of the pixel that stands at `first` in a row of `count`, and that of the next one.
    #[inline(always)]
    fn both(&self, first: f32, count: u32) -> [usize; 2] {
        let (first, wrap) = (first as i64, self.settings.wrap);
        [wrap.index(first, count), wrap.index(first + 1, count)]
    }
}

impl Pattern for Bitmap {
    #[inline(always)]
    fn rgb<R: Real>(&self, uv: Vec2<R>) -> Vec3<R> {
        match self.settings.filter {
            BitmapFilter::Nearest => {
                let at = self.in_pixels(uv).map(R::floor);
                Vec3::from_fn(uv.token(), |lane| {
                    let Vec2 { x, y } = at.lane(lane);
                    self.pixel(IVec2::new(x as i32, y as i32)).into()
                })
            }
            BitmapFilter::Bilinear => {
                let ([top, bottom], t) = self.cell(uv);
                let (top, bottom) = (top[0].lerp(top[1], t.x), bottom[0].lerp(bottom[1], t.x));
                top.lerp(bottom, t.y)
            }
        }
    }

    #[inline(always)]
    fn scalar<R: Real>(&self, uv: Vec2<R>) -> R {
        self.number(Pattern::rgb(self, uv))
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

    #[inline(always)]
    fn gradient<R: Real>(&self, uv: Vec2<R>) -> Vec2<R> {
        if self.settings.filter == BitmapFilter::Nearest {
            return Vec2::splat(uv.token(), Vec2::default());
        }
        let (cell, t) = self.cell(uv);
        let [[f00, f10], [f01, f11]] = cell;
        let (f00, f10) = (self.number(f00), self.number(f10));
        let (f01, f11) = (self.number(f01), self.number(f11));
        let size = self.size();
        let across = ((f10 - f00) * t.y.one_minus() + (f11 - f01) * t.y) * size.x;
        let down = ((f01 - f00) * t.x.one_minus() + (f11 - f10) * t.x) * size.y;
        // By the transpose of the map.
        let [x_axis, y_axis] =
            [self.settings.to_uv.matrix2.x_axis, self.settings.to_uv.matrix2.y_axis];
        Vec2::new(across * x_axis.x + down * x_axis.y, across * y_axis.x + down * y_axis.y)
    }

    fn mean(&self) -> f32 {
        *self.mean.get_or_init(|| {
            let (width, height) = (self.image.width() as usize, self.image.height() as usize);
            let row = |y| -> DVec3 { (0..width).map(|x| self.texel(x, y).as_dvec3()).sum() };
            // Row by row, so that the sum does not depend on the number of threads.
            let rows: Vec<_> = (0..height).into_par_iter().map(row).collect();
            let sum: DVec3 = rows.into_iter().sum();
            self.number::<f32>((sum / (width as f64 * height as f64)).as_vec3a().into())
        })
    }
}

/// One channel or three of a pixel.
#[inline(always)]
fn color<T: Copy>(texels: &[T], value: impl Fn(T) -> f32) -> Rgb {
    match *texels {
        [r, g, b] => Rgb::new(value(r), value(g), value(b)),
        _ => Rgb::splat(value(texels[0])),
    }
}

impl Wrap {
    /// The coordinate that shows the same as `x`: in `[0, 1]`, or `[0, 2]` if every other picture is mirrored; 0 if
    /// `x` is not finite. What is subtracted is exact.
    #[inline(always)]
    fn period<R: Real>(self, x: R) -> R {
        let period = match self {
            Self::Repeat => x - x.floor(),
            Self::Mirror => x - (x * 0.5).floor() * 2.0,
            Self::Clamp => x.clamp(0.0, 1.0),
        };
        R::select(x.abs().lt(f32::INFINITY), period, 0.0)
    }

    /// The index of the pixel that stands at `i` in a row of `count`.
    #[inline(always)]
    fn index(self, i: i64, count: u32) -> usize {
        let count = i64::from(count);
        // Nearly always, and faster than by division.
        if (0..count).contains(&i) {
            return i as usize;
        }
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
