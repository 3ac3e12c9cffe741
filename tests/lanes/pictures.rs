//! Whole pictures of the scenes that come with the program: eight lanes at each level, and each path by itself.

use std::fs;

use glam::{DVec2, DVec3};
use telamon::integrator::path::Extras;
use telamon::integrator::{self, Estimate, Integrator, IntegratorSettings, Sample, Tracer};
use telamon::intersect::{self, Backend, Intersector};
use telamon::math::real::Level;
use telamon::render::Description;
use telamon::sampler::{self, PathSampler, Sampler};

use crate::support::meshes::{ply, sphere_mesh};
use crate::support::pictures::{parse, read, scene_files};

/// The samples of a picture of 12 x 9 pixels, three each, row by row.
fn samples<'s>(
    description: &'s Description,
    sampler: &'s dyn Sampler,
) -> impl Iterator<Item = Sample<'s>> {
    (0..12 * 9 * 3u32).map(move |i| {
        let pixel = i / 3;
        let mut numbers = PathSampler::new(sampler, pixel, i % 3);
        let corner = DVec2::new((pixel % 12).into(), (pixel / 12).into());
        let film = (corner + numbers.next_2d().as_dvec2()) / DVec2::new(12.0, 9.0);
        let mut ray = description.camera.ray_through_lens(film, numbers.next_2d());
        if description.moves() {
            ray.time = numbers.next_1d();
        }
        Sample { ray, sampler: numbers }
    })
}

fn bits(estimates: &[Estimate]) -> Vec<[u32; 4]> {
    let bits = |e: &Estimate| {
        let [r, g, b] = e.radiance.to_array();
        [r, g, b, e.alpha].map(f32::to_bits)
    };
    estimates.iter().map(bits).collect()
}

/// A ball that flies past the camera.
const MOVING: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective"><float name="shutter_close" value="1"/></sensor>
    <emitter type="constant"/>
    <shape type="sphere">
        <animation name="to_world">
            <transform time="0"><translate x="-2" z="4"/></transform>
            <transform time="1"><translate x="2" z="4"/></transform>
        </animation>
    </shape>
</scene>"#;

/// A glossy floor under lights of each kind, a sky behind: of the lights only the last so many.
fn lit(count: usize) -> Description {
    let lights = [
        r#"<shape type="cube"><transform name="to_world"><scale value=".2"/><translate x="-1" z="1"/></transform>
            <emitter type="area"><rgb name="radiance" value="3, 2, 1"/></emitter></shape>"#,
        r#"<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="180"/><translate z="2"/></transform>
            <emitter type="area"/></shape>"#,
        r#"<emitter type="point"><point name="position" x=".5" y="1" z="1"/></emitter>"#,
        r#"<emitter type="directional"><vector name="direction" x=".3" y="0" z="-1"/></emitter>"#,
        r#"<shape type="sphere"><point name="center" x="1" y="0" z=".5"/><float name="radius" value=".3"/>
            <emitter type="area"/></shape>"#,
    ];
    let lights = lights[lights.len() - count..].concat();
    parse(&format!(
        r#"<scene version="3.0.0">
        <integrator type="path"><integer name="max_depth" value="6"/></integrator>
        <sensor type="perspective"><transform name="to_world">
            <lookat origin="0, -4, 2" target="0, 0, .3" up="0, 0, 1"/></transform></sensor>
        <emitter type="constant"/>
        <shape type="rectangle"><transform name="to_world"><scale value="3"/></transform>
            <bsdf type="roughconductor"><float name="alpha" value=".3"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="0" y=".7" z=".4"/><float name="radius" value=".4"/>
            <bsdf type="plastic"/></shape>
        {lights}
    </scene>"#
    ))
}

/// The scenes with their names, one that moves, and some with few lights.
fn scenes() -> Vec<(String, Description)> {
    let folder = tempfile::tempdir().expect("a folder");
    // In the place of the meshes that are not part of the package.
    let mesh = folder.path().join("ball.ply");
    let ball = sphere_mesh(DVec3::new(0.0, 1.1, 0.0), 1.0, 6, 9);
    fs::write(&mesh, ply(&ball)).expect("writable");
    let mesh = mesh.to_str().expect("UTF-8");
    let mut scenes = vec![("moving".to_owned(), parse(MOVING))];
    scenes.extend([2, 3, 5].map(|count| (format!("{count} lights"), lit(count))));
    for path in scene_files("scenes") {
        let text = fs::read_to_string(&path).expect("readable");
        // That of `ajax.xml` has to be an OBJ file.
        if text.contains("ajax.obj") {
            continue;
        }
        let defines: &[_] = if text.contains("name=\"mesh\"") { &[("mesh", mesh)] } else { &[] };
        scenes.push((path.display().to_string(), read(&path, defines)));
    }
    scenes
}

/// The bits of all samples of a picture, whose paths are followed together.
fn together(
    description: &Description,
    integrator: &dyn Integrator,
    engine: &dyn Intersector,
    level: Level,
) -> Vec<[u32; 4]> {
    let sampler = sampler::build(&description.sampler);
    let mut estimates = Vec::new();
    integrator.estimates(
        &mut Tracer::new(&description.scene, engine).at_level(level),
        &mut samples(description, sampler.as_ref()),
        &mut |estimate, _| estimates.push(estimate),
    );
    bits(&estimates)
}

#[test]
fn pictures_have_one_form() {
    let mut pictures = 0;
    for (name, description) in scenes() {
        let (integrator, _) = integrator::build(&description.integrator, &description.scene);
        let integrator = integrator.expect("makes a picture");
        let sampler = sampler::build(&description.sampler);
        for &backend in Backend::AVAILABLE {
            let shapes = description.scene.shapes();
            let engine = intersect::build(backend, &shapes).expect("builds");
            let mut tracer = Tracer::new(&description.scene, engine.as_ref());
            let alone: Vec<_> = samples(&description, sampler.as_ref())
                .map(|mut s| integrator.estimate(&mut tracer, &s.ray, &mut s.sampler))
                .collect();
            let lit = alone.iter().filter(|estimate| estimate.radiance.max_element() > 0.0).count();
            assert!(lit > 50, "{name}: {lit} samples have light");
            for level in [Level::baseline(), Level::detect()] {
                let together = together(&description, integrator.as_ref(), engine.as_ref(), level);
                assert!(together == bits(&alone), "{name} {backend} {level:?}");
            }
            pictures += 1;
        }
    }
    assert!(pictures >= 5 * Backend::AVAILABLE.len(), "{pictures}");
}

#[test]
fn paths_carry_what_their_scene_requires_and_nothing_else() {
    // Of each extra, whether some scene is another one without it.
    let mut missed = [false; 3];
    for (name, description) in scenes() {
        let IntegratorSettings::Path(settings) = description.integrator else { continue };
        let Description { scene, .. } = &description;
        let engine = intersect::build(Backend::Rust, &scene.shapes()).expect("builds");
        let picture = |extras| {
            let path = integrator::Path::new(&settings, scene).carrying(extras);
            together(&description, &path, engine.as_ref(), Level::detect())
        };
        let required = Extras::of(&settings, scene);
        let whole = picture(Extras::ALL);
        assert!(picture(required) == whole, "{name}: {required:?}");
        let without = [
            (required.time, Extras { time: false, ..Extras::ALL }),
            (required.eta, Extras { eta: false, ..Extras::ALL }),
            (required.pdf, Extras { pdf: false, ..Extras::ALL }),
        ];
        for (missed, (is_required, extras)) in missed.iter_mut().zip(without) {
            let is_missed = picture(extras) != whole;
            assert!(is_required || !is_missed, "{name}: {extras:?}");
            *missed |= is_missed;
        }
    }
    assert_eq!(missed, [true; 3]);
}
