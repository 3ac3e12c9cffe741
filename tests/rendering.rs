//! What a render depends on, and what it does not.

mod support;

use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec2, Vec3A};
use support::pictures::{parse, picture, read};
use telamon::film::picture::{Picture, Values};
use telamon::film::{Crop, Film, FilterSampler};
use telamon::integrator::{self, Tracer};
use telamon::intersect::{self, Backend};
use telamon::math::Rgb;
use telamon::render::Description;
use telamon::render::render;
use telamon::sampler::{self, PathSampler};

/// Diffuse, glass and metal under a lamp, a point light and a sky, with layers: all at `scale`, in light that
/// is `brightness` times as strong.
fn scene(scale: f64, brightness: f64) -> Description {
    let text = r#"<scene version="3.0.0">
    <default name="scale" value="SCALE"/>
    <integrator type="aov">
        <string name="aovs" value="z:depth, n:sh_normal, i:shape_index, a:albedo"/>
        <integrator type="path"/>
    </integrator>
    <sensor type="perspective">
        <transform name="to_world">
            <lookat origin="0.5, 1.5, 5" target="0, 0.5, 0" up="0, 1, 0"/>
            <scale value="$scale"/>
        </transform>
        <float name="fov" value="50"/>
        <sampler type="independent"><integer name="sample_count" value="5"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="50"/>
            <integer name="height" value="35"/>
        </film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world">
            <rotate x="1" angle="-90"/>
            <scale value="3"/>
            <scale value="$scale"/>
        </transform>
        <bsdf type="diffuse"/>
    </shape>
    <shape type="sphere">
        <transform name="to_world">
            <scale value="0.75"/>
            <translate x="-0.8" y="0.76"/>
            <scale value="$scale"/>
        </transform>
        <bsdf type="dielectric"/>
    </shape>
    <shape type="cube">
        <transform name="to_world">
            <scale value="0.5"/>
            <rotate y="1" angle="30"/>
            <translate x="0.9" y="0.51"/>
            <scale value="$scale"/>
        </transform>
        <bsdf type="conductor"/>
    </shape>
    <shape type="disk">
        <transform name="to_world">
            <scale value="0.4"/>
            <lookat origin="-1, 3, 1" target="0, 0, 0" up="0, 0, 1"/>
            <scale value="$scale"/>
        </transform>
        <emitter type="area"><rgb name="radiance" value="LAMP"/></emitter>
    </shape>
    <emitter type="point">
        <transform name="to_world"><translate x="2" y="2" z="-1"/><scale value="$scale"/></transform>
        <rgb name="intensity" value="POINT"/>
    </emitter>
    <emitter type="constant"><rgb name="radiance" value="SKY"/></emitter>
</scene>"#;
    let lamp = format!("{}, {}, {}", 9.0 * brightness, 7.0 * brightness, 5.0 * brightness);
    let sky = (0.25 * brightness).to_string();
    // What arrives of a point falls with the square of the distance.
    let point = (3.0 * brightness * scale * scale).to_string();
    let text = text.replace("SCALE", &scale.to_string()).replace("POINT", &point);
    parse(&text.replace("LAMP", &lamp).replace("SKY", &sky))
}

/// Every number of a film, to the last bit.
fn bits(film: &Film) -> Vec<u32> {
    let channels = Picture::from_film(film).channels.into_iter();
    channels
        .flat_map(|channel| match channel.values {
            Values::Color(v) | Values::Float(v) => v.into_iter().map(f32::to_bits).collect(),
            Values::Index(v) => v,
        })
        .collect()
}

#[test]
fn threads_do_not_change_the_film() {
    let description = scene(1.0, 1.0);
    for &backend in Backend::AVAILABLE {
        let films = [1, 2, 7].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            bits(&pool.expect("starts").install(|| picture(&description, backend)))
        });
        assert!(films[0] == films[1], "{backend}: two threads");
        assert!(films[0] == films[2], "{backend}: seven threads");
    }
}

#[test]
fn another_seed_is_another_picture() {
    let mut description = scene(1.0, 1.0);
    let pictures = [0, 1, 1 << 63].map(|seed| {
        description.sampler.seed = seed;
        bits(&picture(&description, Backend::default()))
    });
    assert!(pictures[0] != pictures[1] && pictures[0] != pictures[2] && pictures[1] != pictures[2]);
}

/// The crop begins within a tile of the whole film, so tiles lie differently.
#[test]
fn a_crop_is_a_part_of_the_whole() {
    let mut description = scene(1.0, 1.0);
    let crop = Crop { x: 7, y: 5, width: 21, height: 18 };
    for &backend in Backend::AVAILABLE {
        let whole = description.film.crop;
        let all = picture(&description, backend);
        description.film.crop = crop;
        let part = picture(&description, backend);
        description.film.crop = whole;
        let cut = |values: Vec<Rgb>| -> Vec<Rgb> {
            let rows = values.chunks(whole.width as usize).skip(crop.y as usize);
            let columns = crop.x as usize..(crop.x + crop.width) as usize;
            rows.take(crop.height as usize).flat_map(|row| row[columns.clone()].to_vec()).collect()
        };
        assert_eq!(cut(all.radiance()), part.radiance(), "{backend}");
        let depth = |film: &Film| film.number(0).into_iter().map(Rgb::splat).collect();
        assert_eq!(cut(depth(&all)), depth(&part), "{backend}");
    }
}

/// 131 samples are nine passes; here they are taken in one, by hand.
#[test]
fn passes_do_not_change_the_film() {
    let mut description = scene(1.0, 1.0);
    description.film.crop = Crop { x: 12, y: 15, width: 5, height: 4 };
    description.sampler.samples_per_pixel = 131;
    let film = picture(&description, Backend::default());
    let engine = intersect::build(Backend::default(), &description.scene.shapes()).expect("builds");
    let (integrator, _) = integrator::build(&description.integrator, &description.scene);
    let integrator = integrator.expect("makes a picture");
    let numbers = sampler::build(&description.sampler);
    let filter = FilterSampler::new(description.film.filter);
    let mut tracer = Tracer::new(&description.scene, engine.as_ref());
    let size = DVec2::new(50.0, 35.0);
    let pixels = (15..19).flat_map(|y| (12..17).map(move |x| (x, y)));
    for ((x, y), radiance) in pixels.zip(film.radiance()) {
        let sum = (0..131).fold(glam::DVec3::ZERO, |sum, sample| {
            let mut numbers = PathSampler::new(numbers.as_ref(), y * 50 + x, sample);
            let offset = glam::Vec2::from(filter.sample::<f32>(numbers.next_2d().into()));
            let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let position = center + offset.as_dvec2();
            let ray = description.camera.ray(position / size);
            sum + integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.as_dvec3()
        });
        assert_eq!((sum / 131.0).as_vec3a(), radiance, "{x}, {y}");
    }
}

/// A power of 2 changes no digit, and nothing in a render is a length of its own.
#[test]
fn the_scale_of_the_scene_does_not_show() {
    for &backend in Backend::AVAILABLE {
        let plain = picture(&scene(1.0, 1.0), backend).radiance();
        for power in -20..=20 {
            let scaled = picture(&scene(2f64.powi(power), 1.0), backend).radiance();
            let apart = plain.iter().zip(&scaled).filter(|(a, b)| a != b).count();
            assert_eq!(apart, 0, "{backend}: pixels that change with scale 2^{power}");
        }
        // A scale that is no power of 2 shows in the last digits.
        assert_ne!(plain, picture(&scene(3.3, 1.0), backend).radiance());
    }
}

#[test]
fn twice_the_light_is_twice_the_picture() {
    for &backend in Backend::AVAILABLE {
        let plain = picture(&scene(1.0, 1.0), backend).radiance();
        for power in [-60, -40, -20, -1, 1, 20, 40, 60] {
            let factor = 2f32.powi(power);
            let bright = picture(&scene(1.0, f64::from(factor)), backend).radiance();
            let expected: Vec<_> = plain.iter().map(|p| *p * factor).collect();
            assert_eq!(bright, expected, "{backend}: 2^{power}");
        }
    }
}

/// Whoever cancels gets pixels that are each as after some number of samples.
#[test]
fn cancelling_keeps_whole_pixels() {
    let mut description = scene(1.0, 1.0);
    description.sampler.samples_per_pixel = 1 << 30;
    let engine = intersect::build(Backend::default(), &description.scene.shapes()).expect("builds");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("starts");
    let pixels = 50 * 35;
    for after in [1, 2 * pixels + 1] {
        let cancel = AtomicBool::new(false);
        let on_progress = |progress: telamon::render::Progress<'_>| {
            cancel.fetch_or(progress.samples_done >= after, Ordering::Relaxed);
        };
        let (film, statistics) =
            pool.install(|| render(&description, engine.as_ref(), &on_progress, &cancel));
        let (least, most) = statistics.samples_per_pixel;
        assert!(least < most && most <= 4, "after {after} samples: {least} {most}");
        assert!(statistics.samples >= after && statistics.samples < 4 * pixels);
        let stages: Vec<_> = (least..=most)
            .map(|count| match count {
                0 => vec![Rgb::ZERO; pixels as usize],
                _ => {
                    let mut part = scene(1.0, 1.0);
                    part.sampler.samples_per_pixel = count;
                    picture(&part, Backend::default()).radiance()
                }
            })
            .collect();
        for (i, pixel) in film.radiance().iter().enumerate() {
            assert!(stages.iter().any(|stage| stage[i] == *pixel), "pixel {i}: {pixel}");
        }
    }
    // Who cancels before the start gets a black picture.
    let (film, statistics) = render(&description, engine.as_ref(), &|_| (), &AtomicBool::new(true));
    assert_eq!((statistics.samples, statistics.samples_per_pixel), (0, (0, 0)));
    assert!(film.radiance().iter().all(|p| *p == Rgb::ZERO));
}

/// A square of half side 2 across the view, whose shading normal leans; the middle pixel of five by
/// five sees 1 to each side of the centre, the corner pixels nothing.
#[test]
fn layers_hold_the_first_surface() {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = "v -2 -2 0\nv 2 -2 0\nv 2 2 0\nv -2 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                vn 0.6 0 0.8\nf 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4/1\n";
    fs::write(folder.path().join("square.obj"), mesh).expect("writable");
    let text = r#"<scene version="3.0.0">
    <integrator type="aov">
        <string name="aovs" value="z:depth, p:position, g:geo_normal, s:sh_normal, t:uv, a:albedo,
                                   i:shape_index, k:prim_index"/>
    </integrator>
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
        <float name="fov" value="90"/>
        <sampler type="independent"><integer name="sample_count" value="1"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="5"/>
            <integer name="height" value="5"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <shape type="sphere"><point name="center" x="0" y="0" z="9"/></shape>
    <shape type="obj">
        <string name="filename" value="square.obj"/>
        <bsdf type="diffuse"><rgb name="reflectance" value="0.25, 0.5, 0.75"/></bsdf>
    </shape>
</scene>"#;
    let path = folder.path().join("scene.xml");
    fs::write(&path, text).expect("writable");
    for &backend in Backend::AVAILABLE {
        for seed in 0..8 {
            let mut description = read(&path, &[]);
            description.sampler.seed = seed;
            let film = picture(&description, backend);
            let numbers = |pixel: usize| (0..15).map(|i| film.number(i)[pixel]).collect::<Vec<_>>();
            let middle = numbers(12);
            let [x, y, z] = [middle[1], middle[2], middle[3]];
            // Coordinates up to 5 with an error of some roundings each, 2⁻²⁴ of that.
            let near = |a: f32, b: f32| (a - b).abs() <= 16.0 * 5.0 * f32::EPSILON;
            assert!(x.abs() <= 1.001 && y.abs() <= 1.001 && near(z, 0.0), "{middle:?}");
            assert!(near(middle[0], Vec3A::new(x, y, 5.0 - z).length()), "{middle:?}");
            // The loader turns v round, as Mitsuba does for OBJ files.
            let uv = [(x + 2.0) / 4.0, (2.0 - y) / 4.0];
            let expected = [0.0, 0.0, 1.0, 0.6, 0.0, 0.8, uv[0], uv[1], 0.25, 0.5, 0.75];
            for (component, (a, b)) in middle[4..].iter().zip(expected).enumerate() {
                assert!(near(*a, b), "{component}: {a}, not {b}");
            }
            let triangle = u32::from(y > x);
            assert_eq!([film.index(0)[12], film.index(1)[12]], [1, triangle], "{x} {y}");
            for corner in [0, 4, 20, 24] {
                assert_eq!(numbers(corner), [0.0; 15]);
                assert_eq!([film.index(0)[corner], film.index(1)[corner]], [u32::MAX; 2]);
            }
        }
    }
}

/// The variance layer is what 131 single samples have, and asking for it changes no pixel.
#[test]
fn variance_is_that_of_single_samples() {
    let mut description = scene(1.0, 1.0);
    description.film.crop = Crop { x: 12, y: 15, width: 5, height: 4 };
    description.sampler.samples_per_pixel = 131;
    let plain = picture(&description, Backend::default());
    description.film.variance = true;
    let film = picture(&description, Backend::default());
    assert_eq!(plain.radiance(), film.radiance());
    assert_eq!(film.samples(), [131; 20]);
    let engine = intersect::build(Backend::default(), &description.scene.shapes()).expect("builds");
    let (integrator, _) = integrator::build(&description.integrator, &description.scene);
    let integrator = integrator.expect("makes a picture");
    let numbers = sampler::build(&description.sampler);
    let filter = FilterSampler::new(description.film.filter);
    let mut tracer = Tracer::new(&description.scene, engine.as_ref());
    let pixels = (15..19).flat_map(|y| (12..17).map(move |x| (x, y)));
    for ((x, y), variance) in pixels.zip(film.variance()) {
        let samples: Vec<_> = (0..131)
            .map(|sample| {
                let mut numbers = PathSampler::new(numbers.as_ref(), y * 50 + x, sample);
                let offset = glam::Vec2::from(filter.sample::<f32>(numbers.next_2d().into()));
                let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let ray =
                    description.camera.ray((center + offset.as_dvec2()) / DVec2::new(50.0, 35.0));
                integrator.estimate(&mut tracer, &ray, &mut numbers).radiance.as_dvec3()
            })
            .collect();
        let mean = samples.iter().sum::<glam::DVec3>() / 131.0;
        let squares: glam::DVec3 = samples.iter().map(|s| (*s - mean) * (*s - mean)).sum();
        // Sums of 131 terms in f64, narrowed to f32.
        let apart = (squares / 130.0 - variance.as_dvec3()).abs().max_element();
        assert!(apart <= f64::from(f32::EPSILON) * squares.max_element(), "{x}, {y}: {apart}");
    }
}
