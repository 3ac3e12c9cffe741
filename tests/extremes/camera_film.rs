//! The camera at the ends of its range, and pixels that hold many samples.

use std::collections::BTreeSet;

use telamon::film::{Crop, Filter};
use telamon::integrator::{IntegratorSettings, PathSettings};
use telamon::intersect::{self, Backend};
use telamon::math::Rgb;
use telamon::render::{Description, SampleId, trace};

use crate::support::pictures::{parse, picture};

/// A closed room of albedo 1/2 that glows with 1, by paths of at most four edges without roulette: 1.875 along
/// every path.
fn room(camera: &str, width: u32, height: u32, samples: u32) -> Description {
    room_of("perspective", camera, width, height, samples)
}

fn room_of(sensor: &str, camera: &str, width: u32, height: u32, samples: u32) -> Description {
    parse(&format!(
        r#"<scene version="3.0.0">
    <integrator type="path">
        <integer name="max_depth" value="4"/>
        <string name="rr_policy" value="none"/>
        <string name="strategy" value="bsdf"/>
    </integrator>
    <sensor type="{sensor}">
        {camera}
        <sampler type="independent"><integer name="sample_count" value="{samples}"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="{width}"/>
            <integer name="height" value="{height}"/>
        </film>
    </sensor>
    <shape type="cube">
        <boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"/>
        <emitter type="area"/>
    </shape>
</scene>"#
    ))
}

/// The mean of a million samples. One path in 2²⁴ at each bounce may end early, because its direction lies in
/// the surface; that takes 4e-7 at most, and so the bound of 1e-5 has room.
#[test]
fn a_million_samples_have_their_mean() {
    let description = room(r#"<float name="fov" value="50"/>"#, 1, 1, 1_000_000);
    for &backend in Backend::AVAILABLE {
        let mean = picture(&description, backend).radiance()[0];
        let off = (mean / 1.875 - Rgb::ONE).abs().max_element();
        assert!(off < 1e-6, "{backend}: {mean}");
    }
}

/// Fields of view of next to nothing and of nearly all: each sees the room.
#[test]
fn narrow_and_wide_cameras_see() {
    for fov in ["1e-6", "1e-3", "179", "179.999999"] {
        let description = room(&format!(r#"<float name="fov" value="{fov}"/>"#), 1, 1, 100);
        for &backend in Backend::AVAILABLE {
            let mean = picture(&description, backend).radiance()[0];
            assert!((mean - 1.875).abs().max_element() < 1e-5, "{backend}, {fov}: {mean}");
        }
    }
}

/// In the middle of a film of 2²⁴ columns, samples lie within their pixel, and each at its own place: the number
/// of the pixel alone takes all bits of an f32. Directions are exact enough there, since x is nearly 0.
#[test]
fn samples_of_a_wide_film_lie_in_their_pixel() {
    const WIDTH: u32 = 1 << 24;
    let mut description = room(r#"<float name="fov" value="90"/>"#, 1, 1, 64);
    description.resize(WIDTH, 1).expect("possible");
    description.film.filter = Filter::Box;
    let x = WIDTH / 2 + 1000;
    description.film.crop = Crop { x, y: 0, width: 1, height: 1 };
    let engine = intersect::build(Backend::Rust, &description.scene.shapes()).expect("builds");
    let mut places = BTreeSet::new();
    for sample in 0..64 {
        let id = SampleId { x, y: 0, sample, seed: description.sampler.seed };
        let traced = trace(&description, engine.as_ref(), id).expect("a path");
        let direction = traced.edges[0].queries[0].ray.direction.as_dvec3();
        // Half width 1 at distance 1, and +x to the left.
        let column = 0.5 * f64::from(WIDTH) * (1.0 - direction.x / direction.z);
        // The direction is good to 1e-7 of 1000 columns.
        let place = column - f64::from(x);
        assert!((-1e-3..1.001).contains(&place), "{place}");
        places.insert((place * 1000.0).round() as i64);
    }
    assert!(places.len() > 55, "{} places", places.len());
}

/// Apertures from none to the width of the room, in and out of focus: the room looks the same from all of its
/// points. A lens as wide as the room itself would start rays in its walls.
#[test]
fn lenses_of_any_size_see() {
    for radius in ["0", "1e-30", "1e-3", "0.99"] {
        for distance in ["1e-10", "0.5", "1e10"] {
            let lens = format!(
                r#"<float name="aperture_radius" value="{radius}"/><float name="focus_distance" value="{distance}"/>"#
            );
            let description = room_of("thinlens", &lens, 2, 2, 50);
            for &backend in Backend::AVAILABLE {
                for mean in picture(&description, backend).radiance() {
                    let off = (mean - 1.875).abs().max_element();
                    assert!(off < 1e-5, "{backend}, {radius}, {distance}: {mean}");
                }
            }
        }
    }
}

/// A camera without an aperture takes no number for a point on it: its pictures are those of the pinhole, bit
/// for bit.
#[test]
fn a_closed_aperture_is_a_pinhole() {
    let closed = room_of("thinlens", r#"<float name="aperture_radius" value="0"/>"#, 4, 3, 2);
    let pinhole = room("", 4, 3, 2);
    let [closed, pinhole] = [closed, pinhole].map(|mut description| {
        description.integrator = path_with_lamps();
        picture(&description, Backend::Rust).radiance()
    });
    assert_eq!(closed, pinhole);
    assert!(closed.iter().any(|c| *c != closed[0]), "noise shows which numbers were taken");
}

/// With roulette and shadow rays.
fn path_with_lamps() -> IntegratorSettings {
    IntegratorSettings::Path(PathSettings::default())
}

/// A lamp of radius 0.02 on the axis at depth d, seen through an aperture of 0.1 that is focused at 5: the circle
/// of confusion has the radius R = 0.1 |d - 5| / d in the plane of focus, so the mean square distance from the
/// axis is R²/2, plus half the square of the lamp's radius there, plus 1/6 of a pixel's square for rounding to
/// pixels. At least 24,000 samples see the lamp; of a disk, the mean square errs by 0.58 / √24,000 = 0.37 %,
/// so 2 % is five times that.
#[test]
fn depth_of_field_is_that_of_a_thin_lens() {
    const WIDTH: u32 = 48;
    for depth in [2.5, 10.0, 5.0] {
        let description = parse(&format!(
            r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="1"/></integrator>
    <sensor type="thinlens">
        <float name="fov" value="4"/>
        <float name="aperture_radius" value="0.1"/>
        <float name="focus_distance" value="5"/>
        <sampler type="independent"><integer name="sample_count" value="4096"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="{WIDTH}"/>
            <integer name="height" value="{WIDTH}"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="disk">
        <transform name="to_world">
            <scale value="0.02"/>
            <rotate y="1" angle="180"/>
            <translate z="{depth}"/>
        </transform>
        <emitter type="area"/>
    </shape>
</scene>"#
        ));
        let pixels = f64::from(WIDTH) / (2.0 * 5.0 * 2_f64.to_radians().tan());
        let radius = 0.1 * (depth - 5.0_f64).abs() / depth * pixels;
        let lamp = 0.02 * 5.0 / depth * pixels;
        let expected = 0.5 * (radius * radius + lamp * lamp) + 1.0 / 6.0;
        for &backend in Backend::AVAILABLE {
            let (mut sum, mut squares) = (0.0, 0.0);
            for (i, rgb) in picture(&description, backend).radiance().iter().enumerate() {
                let place = |i: usize| i as f64 + 0.5 - 0.5 * f64::from(WIDTH);
                let (x, y) = (place(i % WIDTH as usize), place(i / WIDTH as usize));
                sum += f64::from(rgb.x);
                squares += f64::from(rgb.x) * (x * x + y * y);
            }
            let found = squares / sum;
            assert!(
                (found / expected - 1.0).abs() < 0.02,
                "{backend}, {depth}: {found} {expected}"
            );
        }
    }
}

/// Parallel rays start in the room, also where the filter reaches two pixels beyond the film.
#[test]
fn parallel_rays_see() {
    for scale in ["1e-6", "0.01", "0.3"] {
        let to_world =
            format!(r#"<transform name="to_world"><scale value="{scale}"/></transform>"#);
        let description = room_of("orthographic", &to_world, 2, 2, 100);
        for &backend in Backend::AVAILABLE {
            for mean in picture(&description, backend).radiance() {
                assert!((mean - 1.875).abs().max_element() < 1e-5, "{backend}, {scale}: {mean}");
            }
        }
    }
}
