//! Shapes that emit, each with a place from which its irradiance has a closed form.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{Affine2, DAffine3, DMat3, DVec3, Mat3A, Vec3A};
use telamon::emitter::spot::SpotSettings;
use telamon::emitter::{Area, Constant, Directional, Emitter, EnvironmentMap, Point, Spot};
use telamon::math::Frame;
use telamon::shape::{Cylinder, Disk, Shape, Sphere, TriangleMesh, primitives};
use telamon::texture::bitmap::{BitmapFilter, BitmapSettings, Encoding, Wrap};
use telamon::texture::image::Texels;
use telamon::texture::{Bitmap, Image, Textured};

/// A light of radiance 1 and a receiver.
pub(crate) struct Light {
    /// Names of the plugins in scene files that make such a shape.
    pub(crate) plugins: &'static [&'static str],
    pub(crate) name: String,
    pub(crate) shape: Arc<dyn Shape>,
    /// Position of the receiver.
    pub(crate) from: Vec3A,
    /// Which way the receiver faces.
    pub(crate) normal: Vec3A,
    pub(crate) irradiance: f64,
}

impl Light {
    /// How far the density at a point hit at this cosine may be off because the direction, good to 2⁻²⁴, leads
    /// to another point. For the light that is nearly in contact: nearly twice the angle over the smallest
    /// cosine. On a cylinder n radii away the other point lies n · 2⁻²⁴ over the cosine beside the first, the
    /// normal is turned by that angle, and the cosine, which the density is divided by, is changed by as much.
    pub(crate) fn direction_error(&self, cosine: f64) -> f64 {
        let radii = match self.name.split(' ').collect::<Vec<_>>()[..] {
            ["sphere", "around"] => return 1e-5,
            ["cylinder", "around"] => 5.0,
            ["cylinder", radius, "by", length, "at", distance] => {
                let [r, l, d] =
                    [radius, length, distance].map(|n| n.parse::<f64>().expect("a number"));
                d.hypot(l) / r
            }
            _ => return 0.0,
        };
        radii * f64::from(f32::EPSILON) / 2.0 / (cosine * cosine)
    }
}

/// The square of half side `half` around `center` that faces −z.
pub(crate) fn square(half: f64, center: Vec3A) -> Arc<dyn Shape> {
    let to_world =
        DAffine3::from_translation(center.as_dvec3()) * DAffine3::from_scale(DVec3::splat(half));
    Arc::new(primitives::rectangle(to_world, true).0)
}

pub(crate) fn sphere(center: Vec3A, radius: f32) -> Arc<dyn Shape> {
    Arc::new(Sphere::new(center, radius, Frame::from_normal(Vec3A::Y.into()), false))
}

/// A triangle that faces those who see its corners counter-clockwise.
pub(crate) fn triangle(corners: [Vec3A; 3]) -> Arc<dyn Shape> {
    let positions = corners.map(Into::into).into();
    let (mesh, _) = TriangleMesh::new(positions, vec![[0, 1, 2]], Vec::new(), Vec::new())
        .expect("one triangle");
    Arc::new(mesh)
}

/// The lights of the table.
pub(crate) fn lights() -> Vec<Light> {
    let light = |plugins, name: String, shape, irradiance| Light {
        plugins,
        name,
        shape,
        from: Vec3A::ZERO,
        normal: Vec3A::Z,
        irradiance,
    };
    let mut lights = Vec::new();
    // A square of side a at height h. That of side 2 at 0.001 is left out: only one point in a
    // million lies where its light comes from.
    for (side, height) in [(2.0, 1.0), (0.2, 1.0), (0.002, 1.0), (2.0, 1000.0)] {
        let shape = square(0.5 * side, Vec3A::Z * height as f32);
        lights.push(light(
            &["rectangle"],
            format!("square {side} at {height}"),
            shape,
            above_square(0.5 * side, height),
        ));
    }
    // What is read from a file is a mesh as the cube is one.
    let mesh: &[&str] = &["cube", "obj", "ply", "serialized", "stl"];
    // The same square, seen as the underside of a cube.
    let raised = DAffine3::from_translation(DVec3::Z * 3.0);
    let cube = Arc::new(primitives::cube(raised, false).0);
    lights.push(light(mesh, "cube".into(), cube, above_square(1.0, 2.0)));
    // From inside, a closed surface fills the hemisphere, whatever its shape.
    let inside = DAffine3::from_translation(DVec3::new(0.3, -0.2, 0.4));
    lights.push(light(mesh, "cube around".into(), Arc::new(primitives::cube(inside, true).0), PI));
    for radius in [1.0f32, 0.5] {
        // Ellipse of half axes a and b on the axis at h: π a b / √((a² + h²)(b² + h²)).
        let (a, b, h) = (1.5, f64::from(radius), 2.0);
        let mirrored = DMat3::from_diagonal(DVec3::new(a, b, -1.0));
        let to_world = DAffine3::from_mat3_translation(mirrored, DVec3::Z * h);
        let disk = Disk::new(to_world, false).expect("not singular");
        let expected = PI * a * b / ((a * a + h * h) * (b * b + h * h)).sqrt();
        lights.push(light(&["disk"], format!("disk {a} by {b}"), Arc::new(disk), expected));
    }
    for (radius, distance) in [(1.0f32, 3.0f32), (1.0, 1.5), (1.0, 1.001), (1e-4, 1.0), (1e-6, 1.0)]
    {
        let ratio = f64::from(radius) / f64::from(distance);
        let shape = sphere(Vec3A::Z * distance, radius);
        lights.push(light(
            &["sphere"],
            format!("sphere {radius} at {distance}"),
            shape,
            PI * ratio * ratio,
        ));
    }
    let around =
        Sphere::new(Vec3A::new(0.5, 0.3, -0.6), 2.0, Frame::from_normal(Vec3A::Y.into()), true);
    lights.push(light(&["sphere"], "sphere around".into(), Arc::new(around), PI));
    // From the middle of its lower end, all but the upper end: 1 − r²/(r² + l²).
    let axes = [DVec3::X * 0.5, DVec3::Y * 0.5, DVec3::Z * 2.0];
    let around = Arc::new(Cylinder::new(DVec3::ZERO, axes, true).expect("has an area"));
    lights.push(light(&["cylinder"], "cylinder around".into(), around, PI * 4.0 / 4.25));
    for (radius, length, distance) in [(1.0, 2.0, 3.0), (1e-3, 1.0, 1.0), (0.5, 1e-3, 2.0)] {
        // One end is straight above, the axis is level.
        let axes = [DVec3::Y * radius, DVec3::Z * radius, DVec3::X * length];
        let shape = Cylinder::new(DVec3::Z * distance, axes, false).expect("has an area");
        lights.push(light(
            &["cylinder"],
            format!("cylinder {radius} by {length} at {distance}"),
            Arc::new(shape),
            below_cylinder(length / radius, distance / radius),
        ));
    }
    lights
}

/// Irradiance under the middle of a square of half side s at height h: 4 A atan A, A = s/√(s² + h²).
fn above_square(s: f64, h: f64) -> f64 {
    let a = s / s.hypot(h);
    4.0 * a * a.atan()
}

/// Irradiance below one end of a level cylinder of length l and with its axis at height h, both over its radius
/// (Hamilton and Morgan, "Radiant-interchange Configuration Factors", NACA TN 2836, 1952).
fn below_cylinder(l: f64, h: f64) -> f64 {
    let (x, y) = ((1.0 + h).powi(2) + l * l, (1.0 - h).powi(2) + l * l);
    let ends = (h - 1.0) / (h + 1.0);
    (l / (h * h - 1.0).sqrt()).atan() / h
        + l * ((x - 2.0 * h) / (h * (x * y).sqrt()) * (x / y * ends).sqrt().atan()
            - ends.sqrt().atan() / h)
}

/// Every emitter: its plugin in scene files, and the irradiance at the origin on a surface that faces +z.
pub(crate) fn emitters() -> Vec<(&'static str, Box<dyn Emitter>, f64)> {
    let area = Area::new(square(1.0, Vec3A::Z), Vec3A::ONE).expect("has an area");
    vec![
        ("area", Box::new(area), above_square(1.0, 1.0)),
        // π L from a hemisphere.
        ("constant", Box::new(Constant::new(Vec3A::new(1.0, 2.0, 3.0))), PI),
        // π (L₀ + L₁)/2, with L from L₀ at the zenith to L₁ at the horizon linear in the angle.
        ("envmap", Box::new(three_rows()), 2.0 * PI),
        // I cosθ / d² = 10 · 0.8 / 25.
        ("point", Box::new(Point::new(Vec3A::new(3.0, 0.0, 4.0), Vec3A::splat(10.0))), 0.32),
        // E cosθ = 2 · 0.8.
        (
            "directional",
            Box::new(Directional::new(Vec3A::new(0.6, 0.0, -0.8), Vec3A::splat(2.0))),
            1.6,
        ),
        // As the point light, halfway from the axis to the rim.
        ("spot", Box::new(spot()), 0.16),
    ]
}

/// An environment of 3 at the zenith (+z), 1 at the horizon and 0.5 below.
fn three_rows() -> EnvironmentMap {
    let image = Image::new(1, 3, 1, Texels::Float(vec![3.0, 1.0, 0.5])).expect("three pixels");
    let settings = BitmapSettings {
        encoding: Encoding::Linear,
        filter: BitmapFilter::Bilinear,
        wrap: Wrap::Clamp,
        to_uv: Affine2::IDENTITY,
    };
    let up = Mat3A::from_cols(Vec3A::X, Vec3A::Z, Vec3A::NEG_Y);
    EnvironmentMap::new(Bitmap::new(Arc::new(image), settings), 1.0, up).expect("finite")
}

/// A light that shines past the origin, which is 30° from its axis.
fn spot() -> Spot {
    let to_origin = Vec3A::new(-0.6, 0.0, -0.8);
    let across = Vec3A::new(0.8, 0.0, -0.6);
    let axis = to_origin * 0.75f32.sqrt() + across * 0.5;
    Spot::new(SpotSettings {
        position: Vec3A::new(3.0, 0.0, 4.0),
        axes: Mat3A::from_cols(axis.cross(Vec3A::Y), Vec3A::Y, axis),
        intensity: Vec3A::splat(10.0),
        cutoff_angle: PI / 3.0,
        beam_width: 0.0,
        texture: Textured::Uniform(Vec3A::ONE),
    })
}

/// Lambert: E = ½ Σ θₖ (Γₖ·n) for unit radiance, over the edges of a polygon that lies above the
/// horizon and whose front faces the receiver.
pub(crate) fn lambert(polygon: &[DVec3], from: DVec3, normal: DVec3) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let edges = polygon.iter().zip(next).map(|(&a, &b)| {
        let (a, b) = (a - from, b - from);
        let across = a.cross(b);
        across.length().atan2(a.dot(b)) * across.normalize().dot(normal)
    });
    0.5 * edges.sum::<f64>().abs()
}
