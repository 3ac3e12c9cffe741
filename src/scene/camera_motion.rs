//! A camera that moves while the shutter is open.

use glam::{DAffine3, DMat3, DVec3};

use crate::camera::CameraError;
use crate::math::Motion;
use crate::ray::Ray;

/// Carries the rays of a camera that was made at the origin to where it is at their moment. The lengths of the
/// axes do not matter, as those of a camera at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraMotion {
    camera_to_world: Motion,
}

impl CameraMotion {
    /// # Errors
    /// A map that is singular at some moment, a position too far away.
    pub fn new(camera_to_world: Motion) -> Result<Self, CameraError> {
        for time in camera_to_world.moments() {
            let map = camera_to_world.at(time);
            let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            let longest = x.length().max(y.length()).max(z.length());
            let volume = (map.matrix3 * longest.recip()).determinant();
            // NaN, of an axis that is not finite, is not above.
            let spans_space = volume.abs() > LEAST_VOLUME;
            if !spans_space {
                return Err(CameraError::Singular);
            }
            let position = map.translation;
            let near = position.abs().max_element() < Ray::LARGEST_COORDINATE.into();
            if !near {
                return Err(CameraError::TooFar(position));
            }
        }
        Ok(Self { camera_to_world })
    }

    /// The camera's `ray` at `time`, in the scene.
    #[must_use]
    pub fn carry(&self, ray: &Ray, time: f32) -> Ray {
        let map = self.camera_to_world.at(time.into());
        let map = DAffine3 { matrix3: unit_axes(map.matrix3), ..map };
        Ray { time, ..ray.mapped(&map).0 }
    }
}

/// Below, in units of the longest axis, an axis has passed through 0 or lies in the plane of the others.
const LEAST_VOLUME: f64 = 1e-9;

fn unit_axes(map: DMat3) -> DMat3 {
    let unit = DVec3::normalize_or_zero;
    DMat3::from_cols(unit(map.x_axis), unit(map.y_axis), unit(map.z_axis))
}
