//! What it costs to model what a scene does not require.
//!
//! ```text
//! cargo bench --bench requirements -- [--runs N]
//! ```
//!
//! A room that requires little is rendered in turn as it is and with one thing more, which is not to be seen or hardly so: a
//! lens with a pinhole's picture, a shutter within which next to nothing moves, a texture of one colour. The first
//! rows let the same paths carry what nobody reads. Ratios of times, on one thread.

#![allow(clippy::print_stdout, reason = "a benchmark's result is what it prints")]

mod support;

use std::path::Path;
use std::sync::atomic::AtomicBool;

use telamon::integrator::path::Extras;
use telamon::integrator::{self, Integrator, IntegratorSettings, Sample, Tracer};
use telamon::intersect::{self, Accel, Intersector};
use telamon::load::{LoadOptions, load_text};
use telamon::render::{self, Description};
use telamon::sampler::{self, PathSampler};

use support::{Arguments, Outcome, Spread, seconds};

const USAGE: &str = "requirements [--runs N]";

/// A room without a roof under a lamp that no path meets.
const ROOM: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, -3.8" target="0, 0, 0" up="0, 1, 0"/></transform>
        <float name="shutter_close" value="1"/>
        <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="96"/>
            <integer name="height" value="96"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <emitter type="point"><rgb name="intensity" value="1"/><point name="position" x="0" y="0.9" z="0"/></emitter>
    <bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.6"/></bsdf>
    <shape type="rectangle"><ref id="grey"/>
        <transform name="to_world"><rotate x="1" angle="-90"/><translate y="-1"/></transform>
    </shape>
    <shape type="rectangle"><ref id="grey"/>
        <transform name="to_world"><rotate x="1" angle="180"/><translate z="1"/></transform>
    </shape>
    <shape type="rectangle"><ref id="grey"/>
        <transform name="to_world"><rotate y="1" angle="90"/><translate x="-1"/></transform>
    </shape>
    <shape type="rectangle"><ref id="grey"/>
        <transform name="to_world"><rotate y="1" angle="-90"/><translate x="1"/></transform>
    </shape>
    <shape type="cube"><ref id="grey"/>
        <transform name="to_world"><scale value="0.4"/><translate x="0.2" y="-0.6"/></transform>
    </shape>
</scene>"#;

/// What else is modelled, what of the room's text makes room for it, and how.
const MORE: [(&str, &str, &str); 9] = [
    (
        "a lens",
        r#"<sensor type="perspective">"#,
        r#"<sensor type="thinlens"><float name="aperture_radius" value="1e-6"/><float name="focus_distance" value="4"/>"#,
    ),
    (
        "time",
        r#"<transform name="to_world"><scale value="0.4"/><translate x="0.2" y="-0.6"/></transform>"#,
        r#"<animation name="to_world">
            <transform time="0"><scale value="0.4"/><translate x="0.2" y="-0.6"/></transform>
            <transform time="1"><scale value="0.4"/><translate x="0.200001" y="-0.6"/></transform>
        </animation>"#,
    ),
    (
        "texture coordinates",
        r#"<rgb name="reflectance" value="0.6"/>"#,
        r#"<texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.6"/><rgb name="color1" value="0.6"/></texture>"#,
    ),
    (
        "light that paths meet, and its weights",
        r#"<emitter type="point">"#,
        r#"<shape type="rectangle"><bsdf type="diffuse"/><emitter type="area"><rgb name="radiance" value="1e-3"/></emitter>
            <transform name="to_world"><rotate x="1" angle="90"/><scale value="0.1"/><translate y="1"/></transform>
        </shape><emitter type="point">"#,
    ),
    (
        "light from outside",
        "</scene>",
        r#"<emitter type="constant"><rgb name="radiance" value="1e-3"/></emitter></scene>"#,
    ),
    (
        "Russian roulette",
        r#"<integer name="max_depth" value="6"/>"#,
        r#"<integer name="max_depth" value="6"/><integer name="rr_depth" value="1"/>
            <string name="rr_policy" value="fixed"/><float name="rr_survival" value="0.999"/>"#,
    ),
    (
        "an alpha channel",
        "<film type=\"hdrfilm\">",
        "<film type=\"hdrfilm\"><string name=\"pixel_format\" value=\"rgba\"/>",
    ),
    (
        "layers",
        r#"<integrator type="path"><integer name="max_depth" value="6"/></integrator>"#,
        r#"<integrator type="aov"><string name="aovs" value="nn:sh_normal"/>
            <integrator type="path"><integer name="max_depth" value="6"/></integrator></integrator>"#,
    ),
    (
        "glass, and relative indices",
        r#"<shape type="cube"><ref id="grey"/>"#,
        r#"<shape type="sphere"><float name="radius" value="0.01"/><bsdf type="dielectric"/></shape><shape type="cube"><ref id="grey"/>"#,
    ),
];

fn main() -> Outcome {
    let arguments = Arguments::read(&["--runs"], USAGE)?;
    let runs = arguments.count("--runs", 15)?;
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let room = read(ROOM)?;
    println!("{runs} runs; times over that of the room, median (least to largest)");
    carried(&room, runs)?;
    for (name, old, new) in MORE {
        let text = ROOM.replacen(old, new, 1);
        if text == ROOM {
            return Err(format!("{name}: nothing was added").into());
        }
        versus(name, &room, &read(&text)?, runs)?;
    }
    let mut errors = read(ROOM)?;
    errors.film.variance = true;
    versus("an estimate of the error", &room, &errors, runs)
}

fn read(text: &str) -> Outcome<Description> {
    Ok(load_text(text, Path::new("room.xml"), &LoadOptions::default())?.description)
}

/// The time of `more` over that of `room`.
fn versus(name: &str, room: &Description, more: &Description, runs: usize) -> Outcome {
    let engines = [engine(room)?, engine(more)?];
    let picture = |description, engine: &dyn Intersector| {
        seconds(|| render::render(description, engine, &|_| (), &AtomicBool::new(false)))
    };
    print(name, runs, || [picture(room, engines[0].as_ref()), picture(more, engines[1].as_ref())]);
    Ok(())
}

/// The time of paths that carry something more over that of those of `room`.
fn carried(room: &Description, runs: usize) -> Outcome {
    let IntegratorSettings::Path(settings) = &room.integrator else {
        return Err("the room has the path tracer".into());
    };
    let engine = engine(room)?;
    // Nothing moves or transmits, and no path meets a point, whose weight is 1 then.
    let none = Extras { time: false, eta: false, pdf: false };
    for (name, more) in [
        ("carried: time", Extras { time: true, ..none }),
        ("carried: relative index", Extras { eta: true, ..none }),
        ("carried: density", Extras { pdf: true, ..none }),
        ("carried: all of them", Extras::ALL),
    ] {
        let paths = [none, more]
            .map(|extras| integrator::Path::new(settings, &room.scene).carrying(extras));
        let time = |path: &integrator::Path| seconds(|| estimate(room, path, engine.as_ref()));
        print(name, runs, || [time(&paths[0]), time(&paths[1])]);
    }
    Ok(())
}

fn engine(description: &Description) -> Outcome<Box<dyn Intersector>> {
    Ok(intersect::build(Accel::default(), &description.scene.shapes())?)
}

/// The sum of a picture of many paths.
fn estimate(room: &Description, path: &integrator::Path, engine: &dyn Intersector) -> f32 {
    let sampler = sampler::build(&room.sampler);
    let (width, height) = (room.film.width, room.film.height);
    let mut samples = (0..width * height * 16).map(|i| {
        let pixel = i / 16;
        let mut numbers = PathSampler::new(sampler.as_ref(), pixel, i % 16);
        let corner = glam::DVec2::new((pixel % width).into(), (pixel / width).into());
        let film =
            (corner + numbers.next_2d().as_dvec2()) / glam::DVec2::new(width.into(), height.into());
        Sample { ray: room.camera.ray_through_lens(film, numbers.next_2d()), sampler: numbers }
    });
    let mut sum = 0.0;
    let mut tracer = Tracer::new(&room.scene, engine);
    path.estimates(&mut tracer, &mut samples, &mut |estimate, _| sum += estimate.radiance.x);
    sum
}

fn print(name: &str, runs: usize, mut turn: impl FnMut() -> [f64; 2]) {
    // The first run warms the caches.
    let ratios: Vec<_> = (0..=runs).map(|_| turn()).skip(1).map(|[one, more]| more / one).collect();
    println!("  {name:40} {}", Spread::of(ratios));
}
