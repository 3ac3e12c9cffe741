//! Cameras: from a position on the film, and one on the lens, to a ray.
//!
//! Camera frame: looks along +z, +y is up, +x is to the *left* of the picture (Mitsuba's convention).
//! Positions on the film are those of the whole film, not of its crop: (0, 0) is its upper left
//! corner, (1, 1) its lower right one.

mod orthographic;
mod perspective;

use glam::{DVec2, DVec3, Vec2};

pub use orthographic::{Orthographic, OrthographicSettings};
pub use perspective::{Lens, Perspective, PerspectiveSettings};

use crate::math::real::Real;
use crate::math::vector as real;
use crate::ray::{CameraRays, Ray};

/// Any camera.
#[derive(Clone, Copy, Debug)]
pub enum Camera {
    /// Rays from one point, or from a lens around it.
    Perspective(Perspective),
    /// Parallel rays.
    Orthographic(Orthographic),
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
    /// An aperture, or parallel rays, that start where no engine may be asked about.
    #[error("the camera's rays start up to {:e} from its position (expected coordinates below {:e})", .0, Ray::LARGEST_COORDINATE)]
    TooWide(f64),
    /// A radius below 0 or a focus distance that is not above 0.
    #[error(
        "`aperture_radius` is {aperture_radius} and `focus_distance` is {focus_distance} (expected 0 or \
         more, and more than 0)"
    )]
    Lens {
        /// The radius.
        aperture_radius: f64,
        /// The distance.
        focus_distance: f64,
    },
    /// Clip distances that leave nothing to see.
    #[error("`near_clip` is {near} and `far_clip` is {far} (expected 0 <= near_clip < far_clip)")]
    Clip {
        /// The near one.
        near: f32,
        /// The far one.
        far: f32,
    },
}

impl Camera {
    /// Whether rays of one position on the film differ by where they pass the lens.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        matches!(self, Self::Perspective(camera) if camera.lens().is_some())
    }

    /// The rays from positions on the film, in f64, since of a film of a million pixels an f32 leaves 16 steps to each; through
    /// a point of the lens, if there is one: uniform over its area for uniform `lens` in [0, 1)², else its centre.
    #[inline(always)]
    #[must_use]
    pub fn rays<R: Real>(
        &self,
        film: real::Vec2<R::Double>,
        lens: Option<real::Vec2<R>>,
    ) -> CameraRays<R> {
        match self {
            Self::Perspective(camera) => camera.rays(film, lens),
            Self::Orthographic(camera) => camera.rays(film),
        }
    }

    /// One of them, through a point of the lens.
    #[must_use]
    pub fn ray_through_lens(&self, film: DVec2, u: Vec2) -> Ray {
        self.rays::<f32>(film.into(), Some(u.into())).lane(0)
    }

    /// The same through its centre.
    #[must_use]
    pub fn ray(&self, film: DVec2) -> Ray {
        self.rays::<f32>(film.into(), None).lane(0)
    }

    /// The same view on a film of another `aspect` (width over height, finite and above 0): what is seen
    /// across its width stays.
    #[must_use]
    pub fn with_aspect(self, aspect: f64) -> Self {
        match self {
            Self::Perspective(camera) => Self::Perspective(camera.with_aspect(aspect)),
            Self::Orthographic(camera) => Self::Orthographic(camera.with_aspect(aspect)),
        }
    }

    /// Whether the rays of neighbouring pixels, on a film of this size, are at least four steps of f32 apart
    /// in direction or origin: in the middle and in the corners.
    #[must_use]
    pub fn tells_pixels_apart(&self, width: u32, height: u32) -> bool {
        let pixel = DVec2::new(1.0 / f64::from(width), 1.0 / f64::from(height));
        let apart = |from: DVec2, to: DVec2| {
            let [from, to] = [from, to].map(|p| self.ray(p));
            [(from.direction, to.direction), (from.origin, to.origin)]
                .into_iter()
                .any(|(a, b)| (b - a).abs().cmpgt(a.abs() * (4.0 * f32::EPSILON)).any())
        };
        [(0.5, 0.5), (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)].into_iter().all(|(x, y)| {
            let p = DVec2::new(x, y);
            (width == 1 || apart(p, p + DVec2::new(pixel.x, 0.0)))
                && (height == 1 || apart(p, p + DVec2::new(0.0, pixel.y)))
        })
    }
}

/// Checks distances along the optical axis.
fn check_clip(near: f32, far: f32) -> Result<(), CameraError> {
    if near >= 0.0 && near < far { Ok(()) } else { Err(CameraError::Clip { near, far }) }
}

/// Checks that three axes span space, and that rays that start up to `reach` from `position` are allowed.
fn check_frame(axes: [DVec3; 3], position: DVec3, reach: f64) -> Result<(), CameraError> {
    let [a, b, c] = axes;
    let volume = a.dot(b.cross(c));
    if volume == 0.0 || !volume.is_finite() || !position.is_finite() {
        return Err(CameraError::Singular);
    }
    let most = f64::from(Ray::LARGEST_COORDINATE);
    let farthest = position.abs().max_element();
    if farthest >= most {
        return Err(CameraError::TooFar(position));
    }
    if farthest + reach < most { Ok(()) } else { Err(CameraError::TooWide(reach)) }
}
