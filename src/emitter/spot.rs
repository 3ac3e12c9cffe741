//! Spotlights.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Mat3A, Vec2, Vec3A};

use super::{Emitter, EmitterBounds, EmitterSample, LightOrigin, Sight};
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
    to_local: Mat3A,
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
        Self { to_local: settings.axes.transpose(), settings }
    }

    /// Intensity towards a unit direction (world) that leaves the light.
    fn intensity(&self, direction: DVec3) -> Rgb {
        let s = &self.settings;
        let local = self.to_local.as_dmat3() * direction;
        let angle = local.truncate().length().atan2(local.z);
        if angle >= s.cutoff_angle {
            return Rgb::ZERO;
        }
        let falloff = if angle <= s.beam_width {
            1.0
        } else {
            (s.cutoff_angle - angle) / (s.cutoff_angle - s.beam_width)
        };
        let factor = match &s.texture {
            Textured::Uniform(factor) => *factor,
            Textured::Varying(texture) => {
                let across = local.truncate() / (local.z * s.cutoff_angle.tan());
                texture.rgb(Vec2::splat(0.5) + 0.5 * across.as_vec2())
            }
        };
        s.intensity * factor * falloff as f32
    }
}

impl Emitter for Spot {
    fn sample_toward(&self, from: DVec3, _u: DVec2) -> Option<EmitterSample> {
        let to = self.settings.position.as_dvec3() - from;
        let distance_squared = to.length_squared();
        let direction = to / distance_squared.sqrt();
        let weight = (self.intensity(-direction).as_dvec3() / distance_squared).as_vec3a();
        // At the light itself the direction is undefined.
        (distance_squared > 0.0 && weight != Rgb::ZERO && weight.is_finite()).then(|| {
            EmitterSample {
                direction: direction.as_vec3a(),
                weight,
                pdf: 0.0,
                origin: LightOrigin::Point(self.settings.position),
            }
        })
    }

    fn pdf_toward(&self, _sight: &Sight<'_>) -> f32 {
        0.0
    }

    fn radiance(&self, _sight: &Sight<'_>) -> Rgb {
        Rgb::ZERO
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
