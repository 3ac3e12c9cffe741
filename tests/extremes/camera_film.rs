//! The camera at the ends of its range, and pixels that hold many samples.

use std::collections::BTreeSet;

use telamon::intersect::{self, Backend};
use telamon::math::Rgb;
use telamon::render::{SampleId, trace};
use telamon::scene::Description;
use telamon::scene::settings::{Crop, Filter};

use crate::support::pictures::{parse, picture};

/// A closed room of albedo 1/2 that glows with 1, by paths of at most four edges without roulette: 1.875 along
/// every path.
fn room(camera: &str, width: u32, height: u32, samples: u32) -> Description {
    parse(&format!(
        r#"<scene version="3.0.0">
    <integrator type="path">
        <integer name="max_depth" value="4"/>
        <string name="rr_policy" value="none"/>
        <string name="strategy" value="bsdf"/>
    </integrator>
    <sensor type="perspective">
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
