//! Spotlights.

use std::f64::consts::PI;

use glam::{DVec3, Mat3A, Vec2 as GlamVec2, Vec3A};

use super::{EmitterBounds, EmitterSamples, Light};
use crate::math::real::{Double, Float, Lanes, Real};
use crate::math::vector::{Vec2, Vec3};
use crate::math::{Cone, Rgb, luminance};
use crate::texture::Textured;

/// Light from a point into a cone around an axis, weaker towards the rim; no ray hits it.
///
/// As in Mitsuba: the intensity is full up to the angle `beam_width` from the axis, and falls linearly in the
/// angle to 0 at `cutoff_angle`. A texture is multiplied with it, and laid over the square around the cone's
/// section across the axis.
#[derive(Clone, Debug)]
pub struct Spot {
    settings: SpotSettings,
}

/// What a [`Spot`] is made from.
#[derive(Clone, Debug)]
pub struct SpotSettings {
    /// Where it is.
    pub position: Vec3A,
    /// Its axes in the world, orthonormal; z is that of the cone.
    pub axes: Mat3A,
    /// Intensity on the axis in W·sr⁻¹.
    pub intensity: Rgb,
    /// Half angle of the whole cone in radians, in (0, π].
    pub cutoff_angle: f64,
    /// Half angle of the part without loss, in radians, in [0, `cutoff_angle`].
    pub beam_width: f64,
    /// A factor; if it varies, the cutoff angle is below π/2.
    pub texture: Textured<Rgb>,
}

impl Spot {
    /// A spotlight.
    #[must_use]
    pub fn new(settings: SpotSettings) -> Self {
        Self { settings }
    }

    /// Intensity towards directions (world, of any length) that leave the light. The angle's sine and cosine are in f64,
    /// so that narrow beams keep their rims.
    #[inline(always)]
    fn intensity<R: Real>(&self, direction: Vec3<R::Double>) -> Vec3<R> {
        let s = &self.settings;
        let token = direction.token();
        let axis = |axis: Vec3A| Vec3::splat(token, axis.as_dvec3().into());
        let [x, y, z] = [s.axes.x_axis, s.axes.y_axis, s.axes.z_axis].map(axis);
        let local = Vec3::new(x.dot(direction), y.dot(direction), z.dot(direction));
        let across = (local.x * local.x + local.y * local.y).sqrt();
        let angle = across.narrow().atan2(local.z.narrow()).widen();
        let fading = (-angle + s.cutoff_angle) / (s.cutoff_angle - s.beam_width);
        let falloff = R::Double::select(angle.le(s.beam_width), 1.0, fading).narrow();
        let factor = match &s.texture {
            Textured::Uniform(factor) => Vec3::splat(token, (*factor).into()),
            Textured::Varying(texture) => Vec3::from_fn(token, |i| {
                let local = DVec3::from(local.lane(i));
                let across = local.truncate() / (local.z * s.cutoff_angle.tan());
                texture.rgb(GlamVec2::splat(0.5) + 0.5 * across.as_vec2()).into()
            }),
        };
        let intensity = Vec3::splat(token, s.intensity.into()).times(factor) * falloff;
        intensity.only_where(angle.lt(s.cutoff_angle))
    }
}

impl Light for Spot {
    #[inline(always)]
    fn sample<R: Real>(&self, from: Vec3<R::Double>, _u: Vec2<R::Double>) -> EmitterSamples<R> {
        let position = self.settings.position;
        let out = from - Vec3::splat(from.token(), position.as_dvec3().into());
        let mut samples = EmitterSamples::of_intensity(position, self.intensity::<R>(out), from);
        let Vec3 { x, y, z } = samples.weight.map(|channel| channel.eq(0.0));
        samples.exists &= !(x & y & z);
        samples
    }

    /// The beam, and light that fades from there to the cutoff.
    fn parts(&self) -> Vec<EmitterBounds> {
        let SpotSettings { position, axes, intensity, cutoff_angle, beam_width, texture } =
            &self.settings;
        let beam = Cone { axis: axes.z_axis.normalize().into(), angle: *beam_width as f32 };
        let fading = (cutoff_angle - beam_width).max(0.0) as f32;
        let intensity = f64::from(luminance(*intensity)) * f64::from(texture.mean());
        vec![EmitterBounds::point(*position, beam, fading, intensity)]
    }

    /// With the mean of a texture as if it were laid over directions.
    fn power(&self) -> Option<f64> {
        let SpotSettings { intensity, cutoff_angle: outer, beam_width: inner, texture, .. } =
            &self.settings;
        // ∫ sinθ up to the inner angle, and of the falloff times sinθ from there to the outer one.
        let slope =
            if outer > inner { (outer.sin() - inner.sin()) / (outer - inner) } else { inner.cos() };
        let solid_angle = 2.0 * PI * (1.0 - slope);
        Some(solid_angle * f64::from(luminance(*intensity)) * f64::from(texture.mean()))
    }
}
