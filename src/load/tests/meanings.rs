//! What values mean: as in Mitsuba, and so do those that a file does not give.

use glam::{DVec2, DVec3, Vec3A};

use super::super::plugins::Category;
use super::effects::{LENS, scene_with};
use super::{description, load};
use crate::bsdf::{Bsdf, Place};
use crate::camera::{Camera, Lens};
use crate::emitter::Sight;
use crate::film::{AovKind, AovLayer, ComponentFormat, Crop, Filter};
use crate::integrator::{
    AmbientOcclusionSettings, AovSettings, IntegratorSettings, MisHeuristic, PathSettings,
    RoulettePolicy, Strategy,
};
use crate::render::Description;
use crate::sampler::SamplerKind;
use crate::scene::Scene;

/// Values as printed by Mitsuba 3.9.1 for a scene that names none of them.
#[test]
fn defaults_are_mitsubas() {
    let Description { scene, film, sampler, integrator, .. } = description("<shape type='cube'/>");
    assert_eq!(film.crop, Crop { x: 0, y: 0, width: 768, height: 576 });
    assert_eq!((film.width, film.height, film.alpha), (768, 576, false));
    assert_eq!(film.filter, Filter::Gaussian { stddev: 0.5 });
    assert_eq!(film.component, ComponentFormat::Half);
    assert_eq!((sampler.samples_per_pixel, sampler.seed), (4, 0));
    // Mitsuba's is `independent`: what is measured to be better is the default.
    assert_eq!(sampler.kind, SamplerKind::Sobol);
    assert_eq!(integrator, IntegratorSettings::Path(PathSettings::default()));
    assert_eq!(albedo(&scene, 0), Vec3A::splat(0.5));
    // A <path> without properties is the path tracer's own default, too.
    let named = description("<integrator type='path'/>").integrator;
    assert_eq!(named, IntegratorSettings::Path(PathSettings::default()));
}

fn albedo(scene: &Scene, object: usize) -> Vec3A {
    scene.bsdfs()[scene.objects()[object].bsdf].albedo(&Place::default(), Vec3A::Z)
}

/// The same spectrum is another colour as a light than as a material, and a number is always grey.
#[test]
fn spectra_become_colours() {
    let scene = |reflectance: &str, radiance: &str| {
        let text = format!(
            "<scene version='3.0.0'>\n<shape type='cube'><bsdf type='diffuse'>{reflectance}</bsdf></shape>\
             <emitter type='constant'>{radiance}</emitter><sensor type='perspective'/></scene>"
        );
        let loaded = load(&text).unwrap_or_else(|e| panic!("{text}\n{e}"));
        let warnings: Vec<_> = loaded.warnings.iter().map(ToString::to_string).collect();
        let scene = loaded.description.scene;
        let sight = Sight { from: DVec3::ZERO, direction: Vec3A::Z, surface: None };
        let (_, sky) = scene.environment().expect("there is one");
        (albedo(&scene, 0), sky.radiance(&sight), warnings)
    };
    let of = |value: &str| {
        scene(
            &format!("<spectrum name='reflectance' {value}/>"),
            &format!("<spectrum name='radiance' {value}/>"),
        )
    };
    // Figures of Mitsuba 3.9.1 (scalar_rgb).
    let (reflectance, radiance, warnings) = of("value='400:0.5,700:0.8'");
    assert!(reflectance.abs_diff_eq(Vec3A::new(0.738_916, 0.642_815, 0.538_267), 1e-5));
    assert!(radiance.x > radiance.z && warnings.is_empty(), "{radiance}");
    let (reflectance, radiance, warnings) = of("value='400:0.1, 500:0.8, 600:0.3'");
    assert!(reflectance.abs_diff_eq(Vec3A::new(0.0, 0.634_591, 0.473_492), 1e-5));
    assert!(radiance.abs_diff_eq(Vec3A::new(0.0, 0.603_007, 0.420_922), 1e-5));
    assert_eq!(
        warnings,
        [
            "scene.xml:2:77: `reflectance` is a spectrum whose colour (-0.0939, 0.6346, 0.4735) is out of \
             gamut; (0.0000, 0.6346, 0.4735) is taken",
            "scene.xml:2:178: `radiance` is a spectrum whose colour (-0.0539, 0.6030, 0.4209) is out of \
             gamut; (0.0000, 0.6030, 0.4209) is taken",
        ]
    );
    let (reflectance, radiance, _) = of("value='0.5'");
    assert_eq!(reflectance, Vec3A::splat(0.5));
    assert!(radiance.abs_diff_eq(Vec3A::new(0.602_397, 0.474_146, 0.454_458), 1e-6));
    let typed = |name: &str, kind: &str, parameter: &str| {
        format!(
            "<spectrum type='{kind}' name='{name}'><float name='{parameter}' value='0.25'/></spectrum>"
        )
    };
    for (kind, parameter) in [("uniform", "value"), ("d65", "scale")] {
        let name = |name| typed(name, kind, parameter);
        let (reflectance, radiance, _) = scene(&name("reflectance"), &name("radiance"));
        assert_eq!((reflectance, radiance), (Vec3A::splat(0.25), Vec3A::splat(0.25)));
    }
    // (0.5 + 0.055 over 1.055) to the power of 2.4, and 0x80 / 255 likewise.
    let (reflectance, radiance, _) = scene(
        "<srgb name='reflectance' value='0.5 0 1'/>",
        "<srgb name='radiance' value='#80ff00'/>",
    );
    assert!(reflectance.abs_diff_eq(Vec3A::new(0.214_041, 0.0, 1.0), 1e-6), "{reflectance}");
    assert!(radiance.abs_diff_eq(Vec3A::new(0.215_861, 1.0, 0.0), 1e-6), "{radiance}");
    // Where a number is asked for, it is the mean.
    let rough = |alpha: &str| {
        format!("{:?}", description(&format!("<bsdf type='roughconductor'>{alpha}</bsdf>")).scene)
    };
    let spectrum = rough("<spectrum name='alpha' value='0.25'/>");
    assert_eq!(spectrum, rough("<float name='alpha' value='0.25'/>"));
}

#[test]
fn materials_mean_what_they_say() {
    let of = |bsdf: &str| {
        let d = description(&format!("<shape type='sphere'>{bsdf}</shape>"));
        albedo(&d.scene, 0)
    };
    assert_eq!(of("<bsdf type='conductor'/>"), Vec3A::ONE);
    assert_eq!(
        of("<bsdf type='conductor'><string name='material' value='none'/></bsdf>"),
        Vec3A::ONE
    );
    // ((1.5 - 1)² + 4) / ((1.5 + 1)² + 4), from Fresnel's equations at normal incidence.
    let metal = of(
        "<bsdf type='conductor'><float name='eta' value='1.5'/><float name='k' value='2'/></bsdf>",
    );
    assert!((metal.x - 4.25 / 10.25).abs() < 1e-6, "{metal}");
    let glass = "<bsdf type='dielectric'><float name='specular_transmittance' value='0'/>\
                 <float name='int_ior' value='2'/><string name='ext_ior' value='vacuum'/></bsdf>";
    // ((2 - 1) / (2 + 1))²
    assert!((of(glass).x - 1.0 / 9.0).abs() < 1e-6, "{}", of(glass));
    let two = description(
        "<shape type='sphere'><bsdf type='twosided'><bsdf type='conductor'/>\
         <bsdf type='diffuse'><rgb name='reflectance' value='.1'/></bsdf></bsdf></shape>",
    );
    let bsdf: &dyn Bsdf = two.scene.bsdfs()[0].as_ref();
    assert_eq!(
        (bsdf.albedo(&Place::default(), Vec3A::Z), bsdf.albedo(&Place::default(), -Vec3A::Z)),
        (Vec3A::ONE, Vec3A::splat(0.1))
    );
}

/// Tangents of half the angle across the width, from the `x_fov` that Mitsuba 3.9.1 reports (in degrees,
/// to f32) for the default film of 4:3.
#[test]
fn fields_of_view_are_mitsubas() {
    let width = |inner: &str| {
        let text = scene_with(Category::Sensor, "perspective", inner);
        let camera = load(&text).expect("valid").description.camera;
        let left = camera.ray(DVec2::new(0.0, 0.5)).direction;
        f64::from(left.x / left.z).atan().to_degrees() * 2.0
    };
    let fov = |axis: &str| {
        width(&format!("<float name='fov' value='40'/><string name='fov_axis' value='{axis}'/>"))
    };
    let focal = |length: &str| width(&format!("<string name='focal_length' value='{length}'/>"));
    for (ours, mitsubas) in [
        (fov("x"), 40.0),
        (fov("y"), 51.774_010),
        (fov("diagonal"), 32.468_605),
        (fov("smaller"), 51.774_010),
        (fov("larger"), 40.0),
        (focal("50mm"), 38.184_841),
        (focal("35"), 52.622_543),
        (focal("50 mm"), 38.184_841),
        (width(""), 38.184_841),
    ] {
        // Directions are f32: an error of 6e-8 of the tangent, below 1e-5 degrees; Mitsuba's own figures
        // have seven digits.
        assert!((ours - mitsubas).abs() < 2e-5, "{ours} {mitsubas}");
    }
}

#[test]
fn cameras_are_placed_and_may_be_scaled() {
    let camera = |steps: &str| {
        let inner = format!("<transform name='to_world'>{steps}</transform>");
        load(&scene_with(Category::Sensor, "perspective", &inner))
            .expect("valid")
            .description
            .camera
    };
    let lookat = "<lookat origin='1 2 3' target='1 2 0' up='0 1 0'/>";
    let ray = camera(lookat).ray(DVec2::splat(0.5));
    assert_eq!((ray.origin, ray.direction), (Vec3A::new(1.0, 2.0, 3.0), Vec3A::NEG_Z));
    // Seen from the front, the world's -x is to the left of a camera that looks along -z.
    assert!(camera(lookat).ray(DVec2::new(0.0, 0.5)).direction.x < 0.0);
    let scaled = camera(&format!("<scale value='5'/>{lookat}")).ray(DVec2::new(0.1, 0.7));
    assert_eq!(scaled.direction, camera(lookat).ray(DVec2::new(0.1, 0.7)).direction);
}

/// What is not given is as Mitsuba has it: without `focus_distance`, what is as far as the scene goes is sharp.
#[test]
fn lenses_are_read() {
    let lens = |inner: &str| {
        let camera = load(&scene_with(Category::Sensor, "thinlens", inner));
        match camera.expect("valid").description.camera {
            Camera::Perspective(camera) => camera.lens(),
            Camera::Orthographic(_) => None,
        }
    };
    let expected = |focus_distance| Some(Lens { aperture_radius: 1.0, focus_distance });
    assert_eq!(lens(LENS), expected(f64::INFINITY));
    assert_eq!(lens(&format!("{LENS}<float name='far_clip' value='9'/>")), expected(9.0));
    assert_eq!(lens(&format!("{LENS}<integer name='focus_distance' value='2'/>")), expected(2.0));
    assert_eq!(lens("<float name='aperture_radius' value='0'/>"), None);
}

/// Without `up`, `lookat` turns the camera as Mitsuba 3.9.1 does, whose matrix for this one is printed to
/// six digits.
#[test]
fn lookat_without_up_is_mitsubas() {
    let text = scene_with(
        Category::Sensor,
        "perspective",
        "<transform name='to_world'><lookat origin='1, 2, 3' target='0, 0.5, 0'/></transform>",
    );
    let camera = load(&text).expect("valid").description.camera;
    let (left, center) =
        (camera.ray(DVec2::new(0.0, 0.5)).direction, camera.ray(DVec2::splat(0.5)).direction);
    let forward = Vec3A::new(-0.285_714, -0.428_571, -0.857_143);
    assert!(center.abs_diff_eq(forward, 1e-6), "{center}");
    let across = (left - center * left.dot(center)).normalize();
    assert!(across.abs_diff_eq(Vec3A::new(-0.065_934, 0.901_099, -0.428_571), 2e-6), "{across}");
}

#[test]
fn steps_of_a_transform_are_applied_in_order() {
    let center = |steps: &str| {
        let d = description(&format!(
            "<shape type='sphere'><float name='radius' value='1e-3'/>\
             <transform name='to_world'>{steps}</transform></shape>"
        ));
        let bounds = d.scene.bounds().expect("one shape");
        (bounds.min.as_dvec3() + bounds.max.as_dvec3()) * 0.5
    };
    for (steps, expected) in [
        ("<translate x='1'/><scale value='2'/>", DVec3::new(2.0, 0.0, 0.0)),
        ("<scale value='2'/><translate x='1'/>", DVec3::new(1.0, 0.0, 0.0)),
        ("<translate value='1 2 3'/>", DVec3::new(1.0, 2.0, 3.0)),
        ("<translate x='1'/><rotate z='2' angle='90'/>", DVec3::new(0.0, 1.0, 0.0)),
        ("<matrix value='1 0 0 4  0 1 0 5  0 0 1 6  0 0 0 1'/>", DVec3::new(4.0, 5.0, 6.0)),
        ("<translate x='1'/><matrix value='0 -1 0, 1 0 0, 0 0 1'/>", DVec3::new(0.0, 1.0, 0.0)),
        ("<lookat origin='7 8 9' target='7 8 10' up='0 1 0'/>", DVec3::new(7.0, 8.0, 9.0)),
    ] {
        // Bounds are f32 with a margin of a few ulp of 10.
        assert!(center(steps).abs_diff_eq(expected, 1e-5), "{steps} {}", center(steps));
    }
}

#[test]
fn mirrored_spheres_face_inwards() {
    let debug = |inner: &str| {
        let d = description(&format!("<shape type='sphere'>{inner}</shape>"));
        format!("{:?}", d.scene.objects()[0].shape)
    };
    let mirrored = debug("<transform name='to_world'><scale x='-1'/></transform>");
    assert!(mirrored.contains("side: -1.0"), "{mirrored}");
    let twice = debug(
        "<transform name='to_world'><scale x='-1'/></transform><boolean name='flip_normals' value='true'/>",
    );
    assert!(twice.contains("side: 1.0"), "{twice}");
}

#[test]
fn integrators_mean_what_they_say() {
    let of = |object: &str| description(object).integrator;
    let direct = |inner: &str| match of(&format!("<integrator type='direct'>{inner}</integrator>"))
    {
        IntegratorSettings::Path(path) => path,
        other => panic!("{other:?}"),
    };
    assert_eq!(direct(""), PathSettings { max_depth: Some(2), ..PathSettings::default() });
    assert_eq!(direct("<integer name='shading_samples' value='1'/>"), direct(""));
    let only = |name: &str| direct(&format!("<integer name='{name}' value='0'/>")).strategy;
    assert_eq!(only("emitter_samples"), Strategy::Bsdf);
    assert_eq!(only("bsdf_samples"), Strategy::Emitter);
    let counts = |inner: &str| {
        let path = direct(inner);
        (path.strategy, path.emitter_samples, path.bsdf_samples)
    };
    let both = Strategy::Mis(MisHeuristic::Power);
    assert_eq!(counts("<integer name='shading_samples' value='3'/>"), (both, 3, 3));
    assert_eq!(counts("<integer name='emitter_samples' value='4'/>"), (both, 4, 1));
    let lights =
        "<integer name='emitter_samples' value='4'/><integer name='bsdf_samples' value='0'/>";
    assert_eq!(counts(lights), (Strategy::Emitter, 4, 1));
    let scattered =
        "<integer name='bsdf_samples' value='5'/><string name='strategy' value='bsdf'/>";
    assert_eq!(counts(scattered), (Strategy::Bsdf, 1, 5));
    let fixed = of("<integrator type='path'><string name='rr_policy' value='fixed'/>\
         <integer name='max_depth' value='9'/><float name='rr_survival' value='1'/></integrator>");
    let IntegratorSettings::Path(path) = fixed else { panic!("{fixed:?}") };
    assert_eq!(
        (path.roulette.policy, path.roulette.max_survival),
        (RoulettePolicy::Fixed(1.0), 1.0)
    );
    let aov =
        of("<integrator type='aov'><string name='aovs' value='dd:depth, nn.s : sh_normal,'/>\
         <integrator type='ao'/></integrator>");
    let layer = |name: &str, kind| AovLayer { name: name.into(), kind };
    assert_eq!(
        aov,
        IntegratorSettings::Aov(AovSettings {
            layers: vec![layer("dd", AovKind::Depth), layer("nn.s", AovKind::ShadingNormal)],
            picture: Some(Box::new(IntegratorSettings::AmbientOcclusion(
                AmbientOcclusionSettings { ray_length: f32::INFINITY }
            ))),
        }),
    );
}
