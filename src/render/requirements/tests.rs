use std::sync::Arc;

use glam::{DAffine3, Vec2, Vec3, Vec3A};

use super::*;
use crate::bsdf::conductor::Metal;
use crate::bsdf::microfacet::{Distribution, Roughness};
use crate::bsdf::{Bsdf, Conductor, Diffuse, RoughConductor};
use crate::camera::{Orthographic, OrthographicSettings, Perspective, PerspectiveSettings};
use crate::emitter::{Area, Constant, Emitter};
use crate::film::AovLayer;
use crate::integrator::{
    AovSettings, DirectUniformSettings, PathSettings, Roulette, RoulettePolicy, Strategy,
};
use crate::math::Rgb;
use crate::render::description::tests::description;
use crate::shape::TriangleMesh;
use crate::texture::{Checkerboard, Texture, Textured};

fn triangle(smooth: bool) -> Arc<dyn Shape> {
    let corners = [Vec3A::ZERO, Vec3A::X, Vec3A::Y];
    let normals = if smooth { vec![Vec3::Z; 3] } else { Vec::new() };
    let mesh = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2]], normals, Vec::new());
    Arc::new(mesh.expect("valid").0)
}

/// A scene of triangles, one for each material, under a constant sky.
fn scene(smooth: bool, bsdfs: Vec<Box<dyn Bsdf>>) -> Scene {
    lit_scene(smooth, bsdfs, Vec::new())
}

/// The same with lights that belong to no triangle.
fn lit_scene(smooth: bool, bsdfs: Vec<Box<dyn Bsdf>>, lights: Vec<Box<dyn Emitter>>) -> Scene {
    let object = |bsdf| Object::new("", triangle(smooth), bsdf, None);
    let objects = (0..bsdfs.len()).map(object).collect();
    let mut emitters: Vec<Box<dyn Emitter>> = vec![Box::new(Constant::new(Rgb::ONE))];
    emitters.extend(lights);
    Scene::new(objects, bsdfs, emitters, Some(0)).expect("valid")
}

fn diffuse() -> Box<dyn Bsdf> {
    Box::new(Diffuse::new(Rgb::splat(0.5)))
}

fn mirror() -> Box<dyn Bsdf> {
    Box::new(Conductor::mirror(Rgb::ONE))
}

fn path(settings: PathSettings) -> IntegratorSettings {
    IntegratorSettings::Path(settings)
}

fn reason(description: &Description, feature: Feature) -> (bool, String) {
    let requirements = Requirements::of(description);
    let mut found = requirements.decisions().iter().filter(|d| d.feature == feature);
    let decision = found.next().expect("every feature is decided");
    assert!(found.next().is_none(), "{feature} is decided twice");
    assert_eq!(requirements.models(feature), decision.modelled);
    (decision.modelled, decision.reason.clone())
}

fn skipped(reason: &str) -> (bool, String) {
    (false, reason.to_owned())
}

fn modelled(reason: &str) -> (bool, String) {
    (true, reason.to_owned())
}

#[test]
fn an_empty_scene_requires_nothing() {
    let mut d = description();
    d.integrator = path(PathSettings { max_depth: Some(1), ..PathSettings::default() });
    let requirements = Requirements::of(&d);
    assert!(requirements.decisions().iter().all(|d| !d.modelled), "{requirements:?}");
}

#[test]
fn lenses_are_modelled_where_there_is_one() {
    let mut d = description();
    assert_eq!(reason(&d, Feature::Lens), skipped("the camera is a pinhole"));
    let lens = Lens { aperture_radius: 0.1, focus_distance: 5.0 };
    let settings = PerspectiveSettings {
        to_world: DAffine3::IDENTITY,
        fov_x_deg: 45.0,
        aspect: 1.0,
        principal_point_offset: Vec2::ZERO,
        lens: Some(lens),
        near_clip: 0.0,
        far_clip: f32::INFINITY,
    };
    d.camera = Camera::Perspective(Perspective::new(&settings).expect("valid"));
    let expected = "the aperture has a radius of 0.1, the focus is at 5";
    assert_eq!(reason(&d, Feature::Lens), modelled(expected));
    let settings = OrthographicSettings {
        to_world: DAffine3::IDENTITY,
        aspect: 1.0,
        near_clip: 0.0,
        far_clip: f32::INFINITY,
    };
    d.camera = Camera::Orthographic(Orthographic::new(&settings).expect("valid"));
    assert_eq!(reason(&d, Feature::Lens), skipped("the camera's rays are parallel"));
}

#[test]
fn surfaces_and_light_are_looked_at() {
    let mut d = description();
    assert_eq!(reason(&d, Feature::VertexNormals), skipped("there is no mesh"));
    d.scene = scene(false, vec![diffuse()]);
    assert_eq!(reason(&d, Feature::VertexNormals), skipped("no mesh has them"));
    d.scene = scene(true, vec![diffuse()]);
    assert_eq!(reason(&d, Feature::VertexNormals), modelled("1 of 1 meshes have them"));
    assert_eq!(
        reason(&d, Feature::EnvironmentLight),
        modelled("rays that leave the scene see `Constant`")
    );
    d.film.alpha = true;
    assert!(reason(&d, Feature::Alpha).0);
}

#[test]
fn shadow_rays_need_a_reason() {
    let mut d = description();
    let next_event = Feature::NextEventEstimation;
    let mis = Feature::MultipleImportanceSampling;
    assert_eq!(reason(&d, next_event), skipped("there is no emitter"));
    assert_eq!(reason(&d, mis), skipped("there are no shadow rays"));
    d.scene = scene(false, vec![mirror()]);
    assert_eq!(reason(&d, next_event), skipped("all surfaces are ideal mirrors or glass"));
    d.scene = scene(false, vec![mirror(), diffuse()]);
    assert!(reason(&d, next_event).0);
    assert_eq!(reason(&d, mis), modelled("by the power heuristic"));
    for (strategy, shadow_rays) in [(Strategy::Bsdf, false), (Strategy::Emitter, true)] {
        d.integrator = path(PathSettings { strategy, ..PathSettings::default() });
        assert_eq!(reason(&d, next_event).0, shadow_rays);
        assert!(!reason(&d, mis).0);
    }
    d.integrator = IntegratorSettings::DirectUniform(DirectUniformSettings { hide_emitters: true });
    assert_eq!(reason(&d, next_event), skipped("only the path tracer has it"));
    assert!(reason(&d, Feature::HiddenEmitters).0);
}

#[test]
fn roulette_is_played_only_where_paths_get_that_far() {
    let mut d = description();
    let policy = RoulettePolicy::Throughput;
    let roulette = Roulette { policy, factor: 1.0, min_depth: 5, max_survival: 0.9 };
    let with =
        |max_depth, roulette| path(PathSettings { max_depth, roulette, ..PathSettings::default() });
    d.integrator = with(Some(5), roulette);
    let expected = skipped("paths end at 5 edges, before it begins");
    assert_eq!(reason(&d, Feature::RussianRoulette), expected);
    d.integrator = with(Some(6), roulette);
    let expected = "from edge 5 on, survival by the path's throughput, at most 0.9";
    assert_eq!(reason(&d, Feature::RussianRoulette), modelled(expected));
    d.integrator = with(Some(6), Roulette { factor: 3.0, ..roulette });
    let expected = "from edge 5 on, survival by 3 times the path's throughput, at most 0.9";
    assert_eq!(reason(&d, Feature::RussianRoulette), modelled(expected));
    d.integrator = with(None, Roulette { policy: RoulettePolicy::None, ..roulette });
    assert!(!reason(&d, Feature::RussianRoulette).0);
}

#[test]
fn places_are_looked_up_where_a_material_depends_on_them() {
    let mut d = description();
    d.scene = scene(false, vec![diffuse(), mirror()]);
    let expected = "every material and light is the same all over its surface";
    assert_eq!(reason(&d, Feature::Textures), skipped(expected));
    let expected = "no texture and no layer reads them";
    assert_eq!(reason(&d, Feature::TextureCoordinates), skipped(expected));
    let colors = [0.2, 0.8].map(|v| Textured::Uniform(Rgb::splat(v)));
    let board: Arc<dyn Texture> = Arc::new(Checkerboard::new(colors, glam::Affine2::IDENTITY));
    let varying = Diffuse::new(Textured::Varying(board.clone()));
    d.scene = scene(false, vec![diffuse(), Box::new(varying.clone())]);
    let expected = "1 of 2 surfaces have materials that depend on the place";
    assert_eq!(reason(&d, Feature::Textures), modelled(expected));
    let expected = "1 surfaces have materials that read them";
    assert_eq!(reason(&d, Feature::TextureCoordinates), modelled(expected));
    let lamp = Area::new(triangle(false), Textured::Varying(board)).expect("has an area");
    d.scene = lit_scene(false, vec![diffuse()], vec![Box::new(lamp)]);
    let expected = "0 of 1 surfaces have materials that depend on the place, and 1 lights do";
    assert_eq!(reason(&d, Feature::Textures), modelled(expected));
    assert_eq!(reason(&d, Feature::TextureCoordinates), modelled("lights read them"));
    let roughness = Roughness::anisotropic(Distribution::Ggx, 0.1, 0.2);
    let brushed = RoughConductor::new(Metal::new(None, Rgb::ONE), roughness);
    d.scene = scene(false, vec![Box::new(brushed), Box::new(varying)]);
    let expected = "1 surfaces of 2 need their tangents too";
    assert_eq!(reason(&d, Feature::TextureCoordinates), modelled(expected));
}

#[test]
fn layers_are_named() {
    let mut d = description();
    let layer = |name: &str, kind| AovLayer { name: name.to_owned(), kind };
    let layers = vec![layer("z", AovKind::Depth), layer("st", AovKind::Uv)];
    d.integrator = IntegratorSettings::Aov(AovSettings { layers, picture: None });
    assert_eq!(reason(&d, Feature::Layers), modelled("z, st"));
    assert_eq!(reason(&d, Feature::TextureCoordinates), modelled("a layer shows them"));
    let expected = skipped("layers alone are asked for");
    assert_eq!(reason(&d, Feature::RussianRoulette), expected);
    d.film.variance = true;
    assert_eq!(reason(&d, Feature::Variance), expected);
}

#[test]
fn variance_has_to_be_asked_for() {
    let mut d = description();
    let expected = skipped("nothing asks for an estimate of the error");
    assert_eq!(reason(&d, Feature::Variance), expected);
    d.film.variance = true;
    assert_eq!(reason(&d, Feature::Variance), modelled("the film has layers for it"));
    d.effort.error = Some(0.01);
    let expected = "the film has layers for it, an error is to be reached";
    assert_eq!(reason(&d, Feature::Variance), modelled(expected));
    d.film.variance = false;
    assert_eq!(reason(&d, Feature::Variance), modelled("an error is to be reached"));
}
