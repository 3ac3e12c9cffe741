//! The camera of photographs.

use glam::{DAffine3, DVec3, Vec2};

use super::{CameraError, check_clip, check_frame};
use crate::math::real::{Double, Lanes, Real};
use crate::math::vector as real;
use crate::math::warp::square_to_uniform_disk;
use crate::ray::CameraRays;

/// A camera with a pinhole, or with a thin lens, which is sharp at one distance (Potmesil and Chakravarty,
/// "A Lens and Aperture Camera Model for Synthetic Image Generation", 1981). A point at depth d is spread
/// over a disk whose radius, in the plane of focus at depth f, is the aperture's times |d - f| / d.
#[derive(Clone, Copy, Debug)]
pub struct Perspective {
    position: DVec3,
    /// World vectors such that `left * x + up * y + forward` points through film position (x, y) of
    /// the plane at distance 1, whose half width and half height they hold.
    left: DVec3,
    up: DVec3,
    forward: DVec3,
    principal_point_offset: Vec2,
    lens: Option<Aperture>,
    /// Distances along the optical axis.
    clip: (f32, f32),
}

/// A disk around the camera's position.
#[derive(Clone, Copy, Debug)]
struct Aperture {
    lens: Lens,
    /// From its middle to its rim, along the camera's axes.
    left: DVec3,
    up: DVec3,
}

/// A lens without thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the disk through which light enters, in scene units; with 0 the camera is a pinhole.
    pub aperture_radius: f64,
    /// What is at this distance along the optical axis is sharp; may be infinite.
    pub focus_distance: f64,
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
    /// Its lens, if it is no pinhole.
    pub lens: Option<Lens>,
    /// Surfaces nearer than this along the optical axis are not seen. 0 by default, unlike
    /// Mitsuba's 0.01, so that a scene looks the same at every scale.
    pub near_clip: f32,
    /// Surfaces farther than this along the optical axis are not seen. Infinite by default,
    /// unlike Mitsuba's 10,000, for the same reason.
    pub far_clip: f32,
}

impl Perspective {
    /// # Errors
    /// A field of view outside (0, 180), a singular `to_world`, a position too far away, an aperture or a focus
    /// distance out of range, clip distances out of order.
    pub fn new(settings: &PerspectiveSettings) -> Result<Self, CameraError> {
        let s = settings;
        if !(s.fov_x_deg > 0.0 && s.fov_x_deg < 180.0) {
            return Err(CameraError::FieldOfView(s.fov_x_deg));
        }
        check_clip(s.near_clip, s.far_clip)?;
        let axes = s.to_world.matrix3;
        let units = [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::try_normalize);
        let [Some(left), Some(up), Some(forward)] = units else {
            return Err(CameraError::Singular);
        };
        let lens = s.lens.map(check_lens).transpose()?.flatten();
        let radius = lens.map_or(0.0, |lens| lens.aperture_radius);
        check_frame([left, up, forward], s.to_world.translation, radius)?;
        let half_width = (0.5 * s.fov_x_deg).to_radians().tan();
        Ok(Self {
            position: s.to_world.translation,
            left: left * half_width,
            up: up * (half_width / s.aspect),
            forward,
            principal_point_offset: s.principal_point_offset,
            lens: lens.map(|lens| Aperture { lens, left: left * radius, up: up * radius }),
            clip: (s.near_clip, s.far_clip),
        })
    }

    /// Its lens; `None` for a pinhole.
    #[must_use]
    pub fn lens(&self) -> Option<Lens> {
        self.lens.map(|aperture| aperture.lens)
    }

    /// As [`super::Camera::with_aspect`].
    #[must_use]
    pub fn with_aspect(self, aspect: f64) -> Self {
        Self { up: self.up.normalize() * (self.left.length() / aspect), ..self }
    }

    /// As [`super::Camera::rays`].
    #[inline(always)]
    #[must_use]
    pub fn rays<R: Real>(
        &self,
        film: real::Vec2<R::Double>,
        lens: Option<real::Vec2<R>>,
    ) -> CameraRays<R> {
        let token = film.token();
        let vector = |v: DVec3| real::Vec3::<R::Double>::splat(token, v.into());
        let (left, up, forward) = (vector(self.left), vector(self.up), vector(self.forward));
        let offset = self.principal_point_offset.as_dvec2();
        let across = -((film.x + offset.x) * 2.0) + 1.0;
        let upwards = -((film.y + offset.y) * 2.0) + 1.0;
        // From the centre of the lens to a point at distance 1 along the axis.
        let mut through = left * across + up * upwards + forward;
        let mut origin = vector(self.position);
        if let (Some(Aperture { lens, left, up }), Some(u)) = (self.lens, lens) {
            let p = square_to_uniform_disk(u).widen();
            let shift = vector(left) * p.x + vector(up) * p.y;
            origin = origin + shift;
            // Meets the ray through the centre at the distance of focus.
            through = through - shift / R::Double::splat(token, lens.focus_distance);
        }
        let length = through.length();
        // Along the axis `through` advances by 1, so along the unit direction by 1 / length.
        let [near, far] =
            [self.clip.0, self.clip.1].map(|clip| (length * f64::from(clip)).narrow());
        CameraRays {
            origin: origin.narrow(),
            direction: (through / length).narrow(),
            t_min: near.max(f32::MIN_POSITIVE),
            t_max: far,
            time: R::splat(token, 0.0),
        }
    }
}

/// The lens if there is light to come through.
fn check_lens(lens: Lens) -> Result<Option<Lens>, CameraError> {
    let Lens { aperture_radius, focus_distance } = lens;
    if aperture_radius >= 0.0 && focus_distance > 0.0 {
        Ok((aperture_radius > 0.0).then_some(lens))
    } else {
        Err(CameraError::Lens { aperture_radius, focus_distance })
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, Vec3A};

    use super::super::Camera;
    use super::*;
    use crate::ray::Ray;

    fn ray(camera: &Perspective, film: DVec2) -> Ray {
        camera.rays::<f32>(film.into(), None).lane(0)
    }

    fn through_lens(camera: &Perspective, film: DVec2, u: Vec2) -> Ray {
        camera.rays::<f32>(film.into(), Some(u.into())).lane(0)
    }

    fn settings() -> PerspectiveSettings {
        PerspectiveSettings {
            to_world: DAffine3::IDENTITY,
            fov_x_deg: 90.0,
            aspect: 2.0,
            principal_point_offset: Vec2::ZERO,
            lens: None,
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
            let ray = ray(&camera, film);
            assert!(ray.direction.abs_diff_eq(through.normalize(), 1e-7), "{film}");
            assert_eq!((ray.t_min, ray.t_max), (f32::MIN_POSITIVE, f32::INFINITY));
        }
    }

    #[test]
    fn another_aspect_keeps_the_width_of_the_view() {
        let wide = Perspective::new(&settings()).expect("valid");
        let square = Perspective::new(&PerspectiveSettings { aspect: 1.0, ..settings() });
        let expected = ray(&square.expect("valid"), DVec2::ZERO).direction;
        assert!(ray(&wide.with_aspect(1.0), DVec2::ZERO).direction.abs_diff_eq(expected, 1e-7));
        assert!(!ray(&wide, DVec2::ZERO).direction.abs_diff_eq(expected, 1e-3));
    }

    #[test]
    fn principal_point_moves_the_centre() {
        let offset = Vec2::new(0.25, -0.5);
        let camera =
            Perspective::new(&PerspectiveSettings { principal_point_offset: offset, ..settings() })
                .expect("valid");
        assert_eq!(ray(&camera, DVec2::splat(0.5) - offset.as_dvec2()).direction, Vec3A::Z);
    }

    #[test]
    fn clip_distances_are_measured_along_the_axis() {
        let camera =
            Perspective::new(&PerspectiveSettings { near_clip: 2.0, far_clip: 4.0, ..settings() })
                .expect("valid");
        let ray = ray(&camera, DVec2::ZERO);
        assert!((ray.direction.z * ray.t_min - 2.0).abs() < 1e-6);
        assert!((ray.direction.z * ray.t_max - 4.0).abs() < 1e-6);
    }

    /// A thousandth of a degree over 1000 pixels is 1.7e-8 to a pixel, less than the spacing of f32 in an
    /// oblique direction. Along an axis the directions' small coordinates are finer.
    #[test]
    fn pixels_too_narrow_for_directions_are_told() {
        let narrow = PerspectiveSettings { fov_x_deg: 1e-3, ..settings() };
        let along = Camera::Perspective(Perspective::new(&narrow).expect("valid"));
        assert!(along.tells_pixels_apart(1000, 500));
        let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
        let oblique = |fov_x_deg| {
            let settings = PerspectiveSettings { to_world: turn, fov_x_deg, ..settings() };
            Camera::Perspective(Perspective::new(&settings).expect("valid"))
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

    fn with_lens(aperture_radius: f64, focus_distance: f64) -> Result<Perspective, CameraError> {
        let lens = Some(Lens { aperture_radius, focus_distance });
        Perspective::new(&PerspectiveSettings { fov_x_deg: 40.0, lens, ..settings() })
    }

    /// Points of the square whose images are the middle of the lens and eight places on its rim.
    fn rim() -> impl Iterator<Item = Vec2> {
        let side = [0.0, 0.5, 1.0 - f32::EPSILON / 2.0];
        side.into_iter().flat_map(move |x| side.map(|y| Vec2::new(x, y)))
    }

    /// The circle of confusion: the radius R |d - F| / d in the plane of focus, on a film of 256 pixels.
    #[test]
    fn blur_is_that_of_a_thin_lens() {
        let camera = with_lens(0.1, 5.0).expect("valid");
        let pixels_per_unit = 128.0 / (5.0 * 20_f64.to_radians().tan());
        for (depth, pixels) in [(10.0, 3.517), (2.5, 7.033), (1e6, 7.033), (5.0, 0.0)] {
            // A closed form: the position on the film from where a point on the axis is seen through the
            // lens at `l` is where the line from `l` to the point passes the plane of focus.
            assert!(
                (0.1 * (depth - 5.0_f64).abs() / depth * pixels_per_unit - pixels).abs() < 1e-3
            );
            for u in rim().filter(|u| *u != Vec2::splat(0.5)) {
                let on_lens = through_lens(&camera, DVec2::splat(0.5), u).origin.as_dvec3();
                // The largest number below 1, and an origin in f32, are 2e-8 off.
                assert!((on_lens.length() - 0.1).abs() < 2e-8);
                let seen = on_lens * (1.0 - 5.0 / depth) / (5.0 * 20_f64.to_radians().tan());
                // Half height is half of half width.
                let film = DVec2::new(0.5 - 0.5 * seen.x, 0.5 - seen.y);
                let shift = (film - 0.5) * DVec2::new(256.0, 128.0);
                assert!((shift.length() - pixels).abs() < 1e-3, "{depth}: {shift}");
                let ray = through_lens(&camera, film, u);
                let at = ray.origin.as_dvec3()
                    + ray.direction.as_dvec3() * (depth / f64::from(ray.direction.z));
                // Directions are rounded to 6e-8.
                assert!((at - DVec3::Z * depth).length() < 1e-7 * depth, "{depth}: {at}");
            }
        }
    }

    /// Bit for bit, whatever the distance of focus.
    #[test]
    fn without_an_aperture_it_is_a_pinhole() {
        let plain = PerspectiveSettings { fov_x_deg: 40.0, ..settings() };
        let plain = Perspective::new(&plain).expect("valid");
        let closed = with_lens(0.0, 3.0).expect("valid");
        assert_eq!(closed.lens(), None);
        for u in rim() {
            let film = u.as_dvec2() * 0.7;
            assert_eq!(through_lens(&closed, film, u), ray(&plain, film));
        }
    }

    /// From tiny to huge every ray can be traced; focused at infinity, all of a position are parallel.
    #[test]
    fn apertures_and_distances_of_any_size_make_rays() {
        for aperture_radius in [1e-30, 1e-3, 1.0, 1e6, 1e18] {
            for focus_distance in [1e-30, 1.0, 1e30, f64::INFINITY] {
                let camera = with_lens(aperture_radius, focus_distance).expect("valid");
                for u in rim() {
                    let film = u.as_dvec2();
                    let through = through_lens(&camera, film, u);
                    let length = through.direction.length();
                    assert!(through.is_traceable() && (length - 1.0).abs() < 1e-6, "{through:?}");
                    let central = ray(&camera, film).direction;
                    assert!(focus_distance < 1e30 || through.direction == central);
                }
            }
        }
    }

    #[test]
    fn impossible_lenses_are_refused() {
        for (radius, distance) in
            [(-0.1, 1.0), (f64::NAN, 1.0), (0.1, 0.0), (0.1, -1.0), (0.1, f64::NAN)]
        {
            let refused = with_lens(radius, distance);
            assert!(matches!(refused, Err(CameraError::Lens { .. })), "{radius} {distance}");
        }
        let message = with_lens(1e19, 1.0).expect_err("too wide").to_string();
        assert_eq!(
            message,
            "the camera's rays start up to 1e19 from its position (expected coordinates below 1.844e18)"
        );
        let message = with_lens(1.0, -2.0).expect_err("no distance").to_string();
        assert_eq!(
            message,
            "`aperture_radius` is 1 and `focus_distance` is -2 (expected 0 or more, and more than 0)"
        );
    }
}
