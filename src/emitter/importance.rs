//! How much light may arrive from bounded lights: what a choice among them goes by.
//!
//! Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018), section 4.2.

use glam::Vec3 as GlamVec3;

use super::{EmitterBounds, Receivers};
use crate::math::Aabb;
use crate::math::real::{Lanes, Real};
use crate::math::vector::Vec3;

/// Lights as a receiver sees them: a ball around them and a cone around their normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBounds {
    center: GlamVec3,
    radius_squared: f32,
    /// Of the cone of normals.
    axis: GlamVec3,
    /// Half angle of the cone.
    normals: Angle<f32>,
    /// Cosine of the largest angle between a normal and a direction of its light.
    cos_emission: f32,
    /// As a fraction of that of all lights.
    intensity: f32,
}

/// Cosines count from here on, so that no light is left out that can be of use: nothing that is near the limit of
/// what shines or receives is called dark because of rounding. Sines that are found from a cosine are off by up to
/// √2⁻²³ = 3.5e-4, and two such are added.
const LEAST_COSINE: f32 = 1e-3;

impl LightBounds {
    pub(super) fn new(bounds: &EmitterBounds) -> Self {
        let Aabb { min, max } = bounds.space;
        let center = 0.5 * min + 0.5 * max;
        // The centre is rounded, and so is a receiver's place against it.
        let rounding = 4.0 * f32::EPSILON * min.abs().max(max.abs()).max_element();
        let radius = 0.5 * (max - min).length() * (1.0 + 4.0 * f32::EPSILON) + rounding;
        let (sin, cos) = bounds.normals.angle.sin_cos();
        Self {
            center,
            radius_squared: (radius * radius).min(f32::MAX),
            axis: bounds.normals.axis,
            normals: Angle { sin, cos },
            cos_emission: bounds.emission.cos(),
            intensity: (bounds.intensity as f32).max(f32::MIN_POSITIVE),
        }
    }

    /// A guess of the irradiance: intensity over squared distance, times a bound of the cosines at both ends. 0 only
    /// where nothing can arrive; finite, also at the emitter itself.
    #[inline(always)]
    pub(super) fn importance<R: Real>(&self, receivers: &Receivers<R>) -> R::Double {
        let token = receivers.normal.token();
        let vector = |v: GlamVec3| Vec3::splat(token, Vec3::new(v.x, v.y, v.z));
        let to_receiver = receivers.position.narrow() - vector(self.center);
        let squared = to_receiver.length_squared();
        // Within the ball nothing is known of directions, and half of its size stands for the distance.
        let is_inside = squared.le(self.radius_squared);
        let direction = to_receiver * squared.sqrt().recip();
        // Half of the angle under which the ball is seen.
        let sin_squared = R::splat(token, self.radius_squared) / squared;
        let ball = Angle { sin: sin_squared.sqrt(), cos: sin_squared.one_minus().sqrt() };
        let normals = Angle {
            sin: R::splat(token, self.normals.sin),
            cos: R::splat(token, self.normals.cos),
        };
        let to_axis = Angle::of_cosine(vector(self.axis).dot(direction));
        let cos_emitter = to_axis.less(normals).less(ball).cos;
        let above = -receivers.normal.dot(direction);
        let above = R::select(receivers.both_sides, above.abs(), above);
        let cos_receiver = Angle::of_cosine(above).less(ball).cos;
        let is_dark =
            cos_emitter.lt(self.cos_emission - LEAST_COSINE) | cos_receiver.lt(-LEAST_COSINE);
        let cosines = cos_emitter.max(LEAST_COSINE) * cos_receiver.max(LEAST_COSINE);
        let cosines = R::select(is_inside, 1.0, R::select(is_dark, 0.0, cosines));
        let squared = R::select(is_inside, self.radius_squared, squared);
        let intensity = R::Double::splat(token, self.intensity.into());
        intensity / squared.max(f32::MIN_POSITIVE).widen() * cosines.widen()
    }
}

/// The sine and the cosine of an angle in `[0, π]`.
#[derive(Clone, Copy, Debug)]
struct Angle<R> {
    sin: R,
    cos: R,
}

impl<R: Real> Angle<R> {
    #[inline(always)]
    fn of_cosine(cos: R) -> Self {
        Self { sin: (cos * cos).one_minus().max(0.0).sqrt(), cos }
    }

    /// The difference, or 0 if it is below.
    #[inline(always)]
    fn less(self, other: Self) -> Self {
        let is_less = self.cos.gt(other.cos);
        let sin = self.sin * other.cos - self.cos * other.sin;
        let cos = self.cos * other.cos + self.sin * other.sin;
        Self { sin: R::select(is_less, 0.0, sin), cos: R::select(is_less, 1.0, cos) }
    }
}
