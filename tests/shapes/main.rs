//! Surfaces: texture coordinates and normals as Mitsuba 3 has them, exact positions, and rays that
//! leave without meeting the same surface again.

mod leaving;
mod mitsuba;
#[path = "../support/mod.rs"]
mod support;

use glam::{DAffine3, DVec3, Vec3A};
use telamon::math::Frame;
use telamon::shape::Cylinder;

fn scaled(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_scale(DVec3::new(x, y, z))
}

/// A cylinder from `p0` to `p1` whose u begins where Mitsuba lets it begin.
fn cylinder(p0: [f64; 3], p1: [f64; 3], radius: f64, flip: bool) -> Cylinder {
    let along = DVec3::from(p1) - DVec3::from(p0);
    let frame = Frame::from_normal(along.normalize().as_vec3a().into());
    let [s, t] = [frame.s, frame.t].map(|v| Vec3A::from(v).as_dvec3() * radius);
    Cylinder::new(p0.into(), [s, t, along], flip).expect("has an area")
}
