//! The camera: from a position on the film to a ray.

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3A};

use crate::ray::Ray;

/// A pinhole camera. Camera frame: looks along +z, +y is up, +x is to the *left* of the picture
/// (Mitsuba's convention).
#[derive(Clone, Copy, Debug)]
pub struct Perspective {
    position: Vec3A,
    /// World vectors such that `left * x + up * y + forward` points through film position (x, y) of
    /// the plane at distance 1, whose half width and half height they hold.
    left: DVec3,
    up: DVec3,
    forward: DVec3,
    principal_point_offset: Vec2,
    /// Distances along the optical axis.
    clip: (f32, f32),
}

/// What a [`Perspective`] camera is made from.
#[derive(Clone, Copy, Debug)]
pub struct PerspectiveSettings {
    /// Camera to world.
    pub to_world: DAffine3,
    /// Field of view across the width of the whole film (not of its crop), in degrees, in (0, 180).
    pub fov_x_deg: f64,
    /// Width over height of the whole film.
    pub aspect: f64,
    /// Shift of the centre of projection, as a fraction of the film's width and height.
    pub principal_point_offset: Vec2,
    /// Surfaces nearer than this along the optical axis are not seen. 0 by default, unlike
    /// Mitsuba's 0.01, so that a scene looks the same at every scale.
    pub near_clip: f32,
    /// Surfaces farther than this along the optical axis are not seen. Infinite by default,
    /// unlike Mitsuba's 10,000, for the same reason.
    pub far_clip: f32,
}

/// Why settings do not make a camera.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A field of view outside (0, 180) degrees.
    #[error("the field of view is {0} degrees (expected more than 0 and less than 180)")]
    FieldOfView(f64),
    /// A map to the world that is singular or not finite.
    #[error("`to_world` does not map the camera's axes to three independent directions")]
    Singular,
    /// A position that no engine may be asked about.
    #[error("the camera is at {}, {}, {} (expected coordinates below {:e})", .0.x, .0.y, .0.z, Ray::LARGEST_COORDINATE)]
    TooFar(DVec3),
    /// Clip distances that leave nothing to see.
    #[error("`near_clip` is {near} and `far_clip` is {far} (expected 0 <= near_clip < far_clip)")]
    Clip {
        /// The near one.
        near: f32,
        /// The far one.
        far: f32,
    },
}

impl Perspective {
    /// # Errors
    /// A field of view outside (0, 180), a singular `to_world`, a position too far away, clip distances out
    /// of order.
    pub fn new(settings: &PerspectiveSettings) -> Result<Self, CameraError> {
        let s = settings;
        if !(s.fov_x_deg > 0.0 && s.fov_x_deg < 180.0) {
            return Err(CameraError::FieldOfView(s.fov_x_deg));
        }
        if !(s.near_clip >= 0.0 && s.near_clip < s.far_clip) {
            return Err(CameraError::Clip { near: s.near_clip, far: s.far_clip });
        }
        let axes = s.to_world.matrix3;
        let [left, up, forward] = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::try_normalize);
        let (Some(left), Some(up), Some(forward)) = (left, up, forward) else {
            return Err(CameraError::Singular);
        };
        let volume = left.dot(up.cross(forward));
        if volume == 0.0 || !volume.is_finite() || !s.to_world.translation.is_finite() {
            return Err(CameraError::Singular);
        }
        let position = s.to_world.translation;
        if position.abs().max_element() >= Ray::LARGEST_COORDINATE.into() {
            return Err(CameraError::TooFar(position));
        }
        let half_width = (0.5 * s.fov_x_deg).to_radians().tan();
        Ok(Self {
            position: position.as_vec3a(),
            left: left * half_width,
            up: up * (half_width / s.aspect),
            forward,
            principal_point_offset: s.principal_point_offset,
            clip: (s.near_clip, s.far_clip),
        })
    }

    /// The same view on a film of another `aspect` (width over height, finite and above 0): the field of
    /// view across its width stays.
    #[must_use]
    pub fn with_aspect(self, aspect: f64) -> Self {
        Self { up: self.up.normalize() * (self.left.length() / aspect), ..self }
    }

    /// Whether the directions of neighbouring pixels, on a film of this size, are at least four steps of
    /// f32 apart: in the middle and in the corners.
    #[must_use]
    pub fn tells_pixels_apart(&self, width: u32, height: u32) -> bool {
        let pixel = DVec2::new(1.0 / f64::from(width), 1.0 / f64::from(height));
        let apart = |from: DVec2, to: DVec2| {
            let [from, to] = [from, to].map(|p| self.ray(p).direction);
            (to - from).abs().cmpgt(from.abs() * (4.0 * f32::EPSILON)).any()
        };
        [(0.5, 0.5), (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].into_iter().all(|(x, y)| {
            let p = DVec2::new(x, y);
            (width == 1 || apart(p, p + DVec2::new(pixel.x, 0.0)))
                && (height == 1 || apart(p, p + DVec2::new(0.0, pixel.y)))
        })
    }

    /// The ray through `film`, a position on the whole film: (0, 0) is its upper left corner, (1, 1)
    /// its lower right one. In f64, since of a film of a million pixels an f32 leaves 16 steps to each.
    #[must_use]
    pub fn ray(&self, film: DVec2) -> Ray {
        let p = film + self.principal_point_offset.as_dvec2();
        let through = self.left * (1.0 - 2.0 * p.x) + self.up * (1.0 - 2.0 * p.y) + self.forward;
        let length = through.length();
        let direction = (through / length).as_vec3a();
        let ray = Ray::new(self.position, direction);
        // Along the axis `through` advances by 1, so along the unit direction by 1 / length.
        let (near, far) = (self.clip.0 * length as f32, self.clip.1 * length as f32);
        Ray { t_min: ray.t_min.max(near), t_max: far, ..ray }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> PerspectiveSettings {
        PerspectiveSettings {
            to_world: DAffine3::IDENTITY,
            fov_x_deg: 90.0,
            aspect: 2.0,
            principal_point_offset: Vec2::ZERO,
            near_clip: 0.0,
            far_clip: f32::INFINITY,
        }
    }

    #[test]
    fn corners_lie_where_the_field_of_view_says() {
        let camera = Perspective::new(&settings()).expect("valid");
        // 90 degrees across: half width 1 at distance 1; aspect 2: half height 0.5. +x is left.
        for (film, through) in [
            (DVec2::new(0.5, 0.5), Vec3A::Z),
            (DVec2::new(0.0, 0.0), Vec3A::new(1.0, 0.5, 1.0)),
            (DVec2::new(1.0, 1.0), Vec3A::new(-1.0, -0.5, 1.0)),
        ] {
            let ray = camera.ray(film);
            assert!(ray.direction.abs_diff_eq(through.normalize(), 1e-7), "{film}");
            assert_eq!((ray.t_min, ray.t_max), (f32::MIN_POSITIVE, f32::INFINITY));
        }
    }

    #[test]
    fn another_aspect_keeps_the_width_of_the_view() {
        let wide = Perspective::new(&settings()).expect("valid");
        let square = Perspective::new(&PerspectiveSettings { aspect: 1.0, ..settings() });
        let expected = square.expect("valid").ray(DVec2::ZERO).direction;
        assert!(wide.with_aspect(1.0).ray(DVec2::ZERO).direction.abs_diff_eq(expected, 1e-7));
        assert!(!wide.ray(DVec2::ZERO).direction.abs_diff_eq(expected, 1e-3));
    }

    #[test]
    fn principal_point_moves_the_centre() {
        let offset = Vec2::new(0.25, -0.5);
        let camera =
            Perspective::new(&PerspectiveSettings { principal_point_offset: offset, ..settings() })
                .expect("valid");
        assert_eq!(camera.ray(DVec2::splat(0.5) - offset.as_dvec2()).direction, Vec3A::Z);
    }

    #[test]
    fn clip_distances_are_measured_along_the_axis() {
        let camera =
            Perspective::new(&PerspectiveSettings { near_clip: 2.0, far_clip: 4.0, ..settings() })
                .expect("valid");
        let ray = camera.ray(DVec2::ZERO);
        assert!((ray.direction.z * ray.t_min - 2.0).abs() < 1e-6);
        assert!((ray.direction.z * ray.t_max - 4.0).abs() < 1e-6);
    }

    /// A thousandth of a degree over 1000 pixels is 1.7e-8 to a pixel, less than the spacing of f32 in an
    /// oblique direction. Along an axis the directions' small coordinates are finer.
    #[test]
    fn pixels_too_narrow_for_directions_are_told() {
        let narrow = PerspectiveSettings { fov_x_deg: 1e-3, ..settings() };
        let along = Perspective::new(&narrow).expect("valid");
        assert!(along.tells_pixels_apart(1000, 500));
        let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
        let oblique = |fov_x_deg| {
            let settings = PerspectiveSettings { to_world: turn, fov_x_deg, ..settings() };
            Perspective::new(&settings).expect("valid")
        };
        assert!(!oblique(1e-3).tells_pixels_apart(1000, 500));
        assert!(oblique(1.0).tells_pixels_apart(1000, 500));
        // One pixel has no neighbour.
        assert!(oblique(1e-6).tells_pixels_apart(1, 1));
    }

    #[test]
    fn impossible_settings_are_refused() {
        for fov in [0.0, 180.0, -1.0, f64::NAN, f64::INFINITY] {
            let result = Perspective::new(&PerspectiveSettings { fov_x_deg: fov, ..settings() });
            assert!(matches!(result, Err(CameraError::FieldOfView(_))), "{fov}");
        }
        // A camera of almost no field is a useful one-ray camera.
        assert!(Perspective::new(&PerspectiveSettings { fov_x_deg: 1e-6, ..settings() }).is_ok());
        let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
        let result = Perspective::new(&PerspectiveSettings { to_world: flat, ..settings() });
        assert_eq!(result.err(), Some(CameraError::Singular));
        let far = DAffine3::from_translation(DVec3::new(0.0, 1e19, 0.0));
        let result = Perspective::new(&PerspectiveSettings { to_world: far, ..settings() });
        let message = result.expect_err("too far").to_string();
        assert_eq!(
            message,
            "the camera is at 0, 10000000000000000000, 0 (expected coordinates below 1.844e18)"
        );
        let result =
            Perspective::new(&PerspectiveSettings { near_clip: 3.0, far_clip: 2.0, ..settings() });
        assert_eq!(result.err(), Some(CameraError::Clip { near: 3.0, far: 2.0 }));
    }
}
