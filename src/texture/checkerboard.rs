//! Checkerboards.

use std::sync::Arc;

use glam::Affine2;

use super::{Pattern, Texture, Textured, mapped};
use crate::math::Rgb;
use crate::math::real::{Lanes, Mask, Real};
use crate::math::vector::{Vec2, Vec3};

/// Four fields to the unit square, of two colours in turn.
#[derive(Clone, Debug)]
pub struct Checkerboard {
    colors: [Textured<Rgb>; 2],
    to_uv: Affine2,
    /// What lies outside is clamped, behind all that other textures interpolate.
    limits: [f32; 2],
    /// Both are found once: boards of boards that share parts would be asked exponentially often.
    range: [f32; 2],
    mean: f32,
}

impl Checkerboard {
    /// The first of `colors` holds where both coordinates, mapped by `to_uv`, are in the same half of a
    /// unit.
    #[must_use]
    pub fn new(colors: [Textured<Rgb>; 2], to_uv: Affine2) -> Self {
        let [[least_a, most_a], [least_b, most_b]] = colors.each_ref().map(Textured::range);
        let range = [least_a.min(least_b), most_a.max(most_b)];
        let mean = 0.5 * (colors[0].mean() + colors[1].mean());
        Self { colors, to_uv, limits: [f32::MIN, f32::MAX], range, mean }
    }

    #[inline(always)]
    fn same_halves<R: Real>(&self, uv: Vec2<R>) -> R::Mask {
        let [u, v] = mapped(&self.to_uv, uv).map(|x| (x - x.floor()).gt(0.5)).to_array();
        !(u ^ v)
    }
}

/// The number that a colour stands for.
#[inline(always)]
fn number<R: Real>(color: &Textured<Rgb>, uv: Vec2<R>) -> R {
    match color {
        // The mean of the channels, as wherever a colour stands for a number.
        Textured::Uniform(color) => R::splat(uv.token(), color.element_sum() / 3.0),
        Textured::Varying(texture) => texture.number(uv),
    }
}

impl Pattern for Checkerboard {
    #[inline(always)]
    fn rgb<R: Real>(&self, uv: Vec2<R>) -> Vec3<R> {
        let [first, second] = &self.colors;
        let same = self.same_halves(uv);
        let color = same.either(
            #[inline(always)]
            || first.at(uv),
            #[inline(always)]
            || second.at(uv),
        );
        color.map(|value| value.clamp(self.limits[0], self.limits[1]))
    }

    /// The other colour than that of [`Checkerboard::rgb`], as in Mitsuba 3.9.1: scenes are made to look
    /// right there.
    #[inline(always)]
    fn scalar<R: Real>(&self, uv: Vec2<R>) -> R {
        let [first, second] = &self.colors;
        let value = self.same_halves(uv).either(
            #[inline(always)]
            || number(second, uv),
            #[inline(always)]
            || number(first, uv),
        );
        value.clamp(self.limits[0], self.limits[1])
    }

    fn range(&self) -> [f32; 2] {
        self.range
    }

    fn clamped(&self, limits: [f32; 2]) -> Arc<dyn Texture> {
        let [least, most] = limits;
        let range = self.range.map(|value| value.clamp(least, most));
        let mean = self.mean.clamp(least, most);
        Arc::new(Self { limits, range, mean, ..self.clone() })
    }

    #[inline(always)]
    fn gradient<R: Real>(&self, uv: Vec2<R>) -> Vec2<R> {
        Vec2::splat(uv.token(), Vec2::default())
    }

    fn mean(&self) -> f32 {
        self.mean
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::{Affine2, Checkerboard, Rgb, Texture, Textured};

    /// Values of Mitsuba 3.9.1, also for what lies on a border.
    #[test]
    fn fields_take_turns() {
        let grey = |v| Textured::Uniform(Rgb::splat(v));
        let board = Checkerboard::new([grey(0.4), grey(0.2)], Affine2::IDENTITY);
        for (u, v, rgb, scalar) in [
            (0.1, 0.1, 0.4, 0.2),
            (0.6, 0.1, 0.2, 0.4),
            (0.5, 0.1, 0.4, 0.2),
            (0.1, 0.6, 0.2, 0.4),
            (0.6, 0.6, 0.4, 0.2),
            (-0.4, 1.1, 0.2, 0.4),
        ] {
            let uv = Vec2::new(u, v);
            assert_eq!(board.rgb(uv), Rgb::splat(rgb), "{uv}");
            assert!((board.scalar(uv) - scalar).abs() < 1e-7, "{uv}");
        }
        assert!((board.mean() - 0.3).abs() < 1e-6);
    }
}
