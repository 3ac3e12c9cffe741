//! The camera of plans and elevations.

use glam::{DAffine3, DVec3, Vec3A};

use super::{CameraError, check_clip, check_frame};
use crate::math::real::{Lanes, Real};
use crate::math::vector as real;
use crate::ray::CameraRays;

/// A camera of parallel rays, which start on a plane.
#[derive(Clone, Copy, Debug)]
pub struct Orthographic {
    /// Origin of the ray through the middle of the film.
    position: DVec3,
    /// From there to the middle of the film's left edge, and of its upper edge if it were square.
    left: DVec3,
    up: DVec3,
    aspect: f64,
    direction: Vec3A,
    clip: (f32, f32),
}

/// What an [`Orthographic`] camera is made from.
#[derive(Clone, Copy, Debug)]
pub struct OrthographicSettings {
    /// Camera to world. The film is as wide as the image of the segment from -1 to 1 on the x axis.
    pub to_world: DAffine3,
    /// Width over height of the whole film.
    pub aspect: f64,
    /// Surfaces nearer than this along the image of the z axis, in units of its length, are not seen.
    pub near_clip: f32,
    /// Surfaces are not seen that are farther than `far_clip - near_clip`, in units of the world, from the
    /// plane that `near_clip` puts. Both are as in Mitsuba.
    pub far_clip: f32,
}

impl Orthographic {
    /// # Errors
    /// A singular `to_world`, a film that is too far away, clip distances out of order.
    pub fn new(settings: &OrthographicSettings) -> Result<Self, CameraError> {
        let OrthographicSettings { to_world, aspect, near_clip: near, far_clip: far } = *settings;
        check_clip(near, far)?;
        let axes = to_world.matrix3;
        let units = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::try_normalize);
        let [Some(x), Some(y), Some(direction)] = units else {
            return Err(CameraError::Singular);
        };
        let (left, up) = (axes.x_axis, axes.y_axis);
        let reach = left.length() + up.length() / aspect;
        check_frame([x, y, direction], to_world.translation, reach)?;
        let start = f64::from(near) * axes.z_axis.length();
        let end = start + (f64::from(far) - f64::from(near));
        Ok(Self {
            position: to_world.translation,
            left,
            up,
            aspect,
            direction: direction.as_vec3a(),
            clip: (start as f32, end as f32),
        })
    }

    /// As [`super::Camera::with_aspect`].
    #[must_use]
    pub fn with_aspect(self, aspect: f64) -> Self {
        Self { aspect, ..self }
    }

    /// As [`super::Camera::rays`].
    #[inline(always)]
    #[must_use]
    pub fn rays<R: Real>(&self, film: real::Vec2<R::Double>) -> CameraRays<R> {
        let token = film.token();
        let vector = |v: DVec3| real::Vec3::<R::Double>::splat(token, v.into());
        let across = -(film.x * 2.0) + 1.0;
        let upwards = (-(film.y * 2.0) + 1.0) / self.aspect;
        let origin = vector(self.position) + vector(self.left) * across + vector(self.up) * upwards;
        CameraRays {
            origin: origin.narrow(),
            direction: real::Vec3::splat(token, self.direction.into()),
            t_min: R::splat(token, self.clip.0.max(f32::MIN_POSITIVE)),
            t_max: R::splat(token, self.clip.1),
            time: R::splat(token, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::ray::Ray;

    fn ray(camera: &Orthographic, film: DVec2) -> Ray {
        camera.rays::<f32>(film.into()).lane(0)
    }

    fn settings() -> OrthographicSettings {
        let (to_world, far_clip) = (DAffine3::IDENTITY, f32::INFINITY);
        OrthographicSettings { to_world, aspect: 2.0, near_clip: 0.0, far_clip }
    }

    fn camera(settings: &OrthographicSettings) -> Orthographic {
        Orthographic::new(settings).expect("valid")
    }

    /// As printed by Mitsuba 3.9.1, up to its rounding.
    #[test]
    fn rays_start_on_the_film() {
        let plain = camera(&settings());
        for (film, origin) in [
            (DVec2::new(0.0, 0.0), Vec3A::new(1.0, 0.5, 0.0)),
            (DVec2::new(1.0, 1.0), Vec3A::new(-1.0, -0.5, 0.0)),
            (DVec2::new(0.5, 0.5), Vec3A::ZERO),
        ] {
            let ray = ray(&plain, film);
            assert_eq!((ray.origin, ray.direction), (origin, Vec3A::Z));
            assert_eq!((ray.t_min, ray.t_max), (f32::MIN_POSITIVE, f32::INFINITY));
        }
        let to_world = DAffine3::from_scale(DVec3::new(2.0, 3.0, 5.0));
        let scaled =
            OrthographicSettings { to_world, near_clip: 0.5, far_clip: 10.0, ..settings() };
        let ray = ray(&camera(&scaled), DVec2::ZERO);
        assert_eq!((ray.origin, ray.direction), (Vec3A::new(2.0, 1.5, 0.0), Vec3A::Z));
        assert_eq!((ray.t_min, ray.t_max), (2.5, 12.0));
    }

    #[test]
    fn another_aspect_keeps_the_width_of_the_view() {
        let square = ray(&camera(&settings()).with_aspect(1.0), DVec2::ZERO);
        assert_eq!(square.origin, Vec3A::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn impossible_settings_are_refused() {
        let error = |settings| Orthographic::new(&settings).expect_err("refused");
        let scaled = |x, y, z| DAffine3::from_scale(DVec3::new(x, y, z));
        let with = |to_world| OrthographicSettings { to_world, ..settings() };
        assert_eq!(error(with(scaled(1.0, 0.0, 1.0))), CameraError::Singular);
        assert_eq!(error(with(scaled(1e18, 2e18, 1.0))), CameraError::TooWide(2e18));
        assert!(Orthographic::new(&with(scaled(1e-30, 1e-30, 1e30))).is_ok());
        let clip = OrthographicSettings { near_clip: 1.0, far_clip: 1.0, ..settings() };
        assert_eq!(error(clip), CameraError::Clip { near: 1.0, far: 1.0 });
    }

    /// Far from the origin, origins of neighbouring pixels round to the same.
    #[test]
    fn pixels_too_small_for_their_place_are_told() {
        let at = |x| {
            let to_world = DAffine3::from_translation(DVec3::new(x, x, x));
            super::super::Camera::Orthographic(camera(&OrthographicSettings {
                to_world,
                ..settings()
            }))
        };
        assert!(at(1.0).tells_pixels_apart(1000, 500));
        assert!(!at(1e5).tells_pixels_apart(1000, 500));
    }
}
