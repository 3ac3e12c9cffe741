//! What a scene requires of the renderer, and what it does not, so that no time is spent on it.

use std::collections::HashSet;
use std::fmt::{self, Display, Formatter};
use std::sync::Arc;

use super::settings::{
    AovKind, IntegratorSettings, MisHeuristic, PathSettings, RoulettePolicy, Strategy,
};
use super::{Description, Object, Scene};
use crate::bsdf::Needs;
use crate::camera::{Camera, Lens};
use crate::shape::{Geometry, Shape};

/// For each feature whether a render of a [`Description`] models it, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Requirements {
    decisions: Vec<Decision>,
}

/// One feature.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Decision {
    /// What it is about.
    pub feature: Feature,
    /// Whether the render models it, or skips it.
    pub modelled: bool,
    /// Why: a fragment.
    pub reason: String,
}

/// Something that costs time or memory, and that not every scene needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feature {
    /// Motion within the shutter.
    Time,
    /// A lens that is no pinhole.
    Lens,
    /// Shapes that are stored once and placed many times.
    Instances,
    /// Materials that vary over a surface.
    Textures,
    /// Shading normals that are interpolated between vertices.
    VertexNormals,
    /// Texture coordinates of hits.
    TextureCoordinates,
    /// Light from outside of the scene.
    EnvironmentLight,
    /// Shadow rays to emitters.
    NextEventEstimation,
    /// Weights between shadow rays and scattered rays.
    MultipleImportanceSampling,
    /// Paths that end by chance.
    RussianRoulette,
    /// Camera rays that pass through emitters.
    HiddenEmitters,
    /// An alpha channel.
    Alpha,
    /// Layers beside the picture.
    Layers,
    /// An estimate of each pixel's error.
    Variance,
}

impl Display for Feature {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Time => "time",
            Self::Lens => "lens",
            Self::Instances => "instances",
            Self::Textures => "textures",
            Self::VertexNormals => "vertex normals",
            Self::TextureCoordinates => "texture coordinates",
            Self::EnvironmentLight => "environment light",
            Self::NextEventEstimation => "next-event estimation",
            Self::MultipleImportanceSampling => "multiple importance sampling",
            Self::RussianRoulette => "Russian roulette",
            Self::HiddenEmitters => "hidden emitters",
            Self::Alpha => "alpha",
            Self::Layers => "layers",
            Self::Variance => "variance",
        })
    }
}

/// The reason for a decision: `Ok` to model, `Err` to skip.
type Reason = Result<String, String>;

impl Requirements {
    /// What a render of `description` requires.
    #[must_use]
    pub fn of(description: &Description) -> Self {
        let Description { scene, film, integrator, .. } = description;
        let skipped = |reason: &str| Err(reason.to_owned());
        let next_event = next_event_estimation(integrator, scene);
        let importance = importance(integrator, &next_event);
        let alpha = if film.alpha {
            Ok("the film has an alpha channel".to_owned())
        } else {
            skipped("the film has no alpha channel")
        };
        let decisions = [
            (Feature::Time, time(description)),
            (Feature::Lens, lens(&description.camera)),
            (Feature::Instances, instances(scene)),
            (Feature::Textures, textures(scene)),
            (Feature::VertexNormals, vertex_normals(scene)),
            (Feature::TextureCoordinates, texture_coordinates(integrator, scene)),
            (Feature::EnvironmentLight, environment_light(scene)),
            (Feature::NextEventEstimation, next_event),
            (Feature::MultipleImportanceSampling, importance),
            (Feature::RussianRoulette, roulette(integrator)),
            (Feature::HiddenEmitters, hidden_emitters(integrator)),
            (Feature::Alpha, alpha),
            (Feature::Layers, layers(integrator)),
            (Feature::Variance, variance(description)),
        ];
        let decide = |(feature, reason): (Feature, Reason)| Decision {
            feature,
            modelled: reason.is_ok(),
            reason: reason.unwrap_or_else(|why| why),
        };
        Self { decisions: decisions.into_iter().map(decide).collect() }
    }

    /// All features, modelled or not.
    #[must_use]
    pub fn decisions(&self) -> &[Decision] {
        &self.decisions
    }

    /// Whether a feature is modelled.
    #[must_use]
    pub fn models(&self, feature: Feature) -> bool {
        self.decisions.iter().any(|d| d.feature == feature && d.modelled)
    }
}

fn lens(camera: &Camera) -> Reason {
    match camera {
        Camera::Orthographic(_) => Err("the camera's rays are parallel".to_owned()),
        Camera::Perspective(camera) => match camera.lens() {
            None => Err("the camera is a pinhole".to_owned()),
            Some(Lens { aperture_radius, focus_distance }) => Ok(format!(
                "the aperture has a radius of {aperture_radius}, the focus is at {focus_distance}"
            )),
        },
    }
}

fn time(description: &Description) -> Reason {
    let objects = description.scene.objects();
    let shapes = objects.iter().filter(|o| o.shape.moves()).count();
    let shapes = format!("{shapes} of {} shapes", objects.len());
    match (description.moves(), &description.camera_motion) {
        (false, _) => Err("nothing moves while the shutter is open".to_owned()),
        (true, None) => Ok(format!("while the shutter is open move {shapes}")),
        (true, Some(_)) => Ok(format!("while the shutter is open move the camera and {shapes}")),
    }
}

fn instances(scene: &Scene) -> Reason {
    let groups = scene.objects().iter().filter_map(|o| match o.shape.geometry() {
        Geometry::Instance(instance) => Some(Arc::as_ptr(instance.group())),
        Geometry::Triangles { .. } | Geometry::Deforming(_) | Geometry::Analytic(_) => None,
    });
    let groups: Vec<_> = groups.collect();
    match (groups.len(), groups.iter().collect::<HashSet<_>>().len()) {
        (0, _) => Err("every shape is placed once".to_owned()),
        (count, 1) => Ok(format!("{count} of one group of shapes")),
        (count, different) => Ok(format!("{count} of {different} groups of shapes")),
    }
}

fn vertex_normals(scene: &Scene) -> Reason {
    let triangles = |shape: &dyn Shape| {
        matches!(shape.geometry(), Geometry::Triangles { .. } | Geometry::Deforming(_))
    };
    let is_mesh = |o: &&Object| match o.shape.geometry() {
        Geometry::Instance(i) => i.group().shapes().iter().any(|s| triangles(s.as_ref())),
        _ => triangles(o.shape.as_ref()),
    };
    let meshes = scene.objects().iter().filter(is_mesh).count();
    let smooth = scene.objects().iter().filter(|o| o.shape.has_vertex_normals()).count();
    match (smooth, meshes) {
        (0, 0) => Err("there is no mesh".to_owned()),
        (0, _) => Err("no mesh has them".to_owned()),
        _ => Ok(format!("{smooth} of {meshes} meshes have them")),
    }
}

/// How many surfaces have a material that has to be told so much of the place.
fn surfaces_that_need(scene: &Scene, needs: Needs) -> usize {
    let needed = |&bsdf: &usize| scene.bsdfs()[bsdf].flags().needs >= needs;
    scene.objects().iter().filter(|o| o.bsdfs().iter().any(needed)).count()
}

fn textured_lights(scene: &Scene) -> usize {
    scene.emitters().iter().filter(|e| e.is_textured()).count()
}

fn textures(scene: &Scene) -> Reason {
    let materials =
        || format!("of {} surfaces have materials that depend on the place", scene.objects().len());
    match (surfaces_that_need(scene, Needs::TextureCoordinates), textured_lights(scene)) {
        (0, 0) => Err("every material and light is the same all over its surface".to_owned()),
        (count, 0) => Ok(format!("{count} {}", materials())),
        (count, lights) => Ok(format!("{count} {}, and {lights} lights do", materials())),
    }
}

fn texture_coordinates(integrator: &IntegratorSettings, scene: &Scene) -> Reason {
    let shown = match integrator {
        IntegratorSettings::Aov { layers, .. } => layers.iter().any(|l| l.kind == AovKind::Uv),
        _ => false,
    };
    let read = surfaces_that_need(scene, Needs::TextureCoordinates);
    match (shown, read, surfaces_that_need(scene, Needs::Tangents)) {
        (true, ..) => Ok("a layer shows them".to_owned()),
        (false, 0, _) if textured_lights(scene) > 0 => Ok("lights read them".to_owned()),
        (false, 0, _) => Err("no texture and no layer reads them".to_owned()),
        (false, _, 0) => Ok(format!("{read} surfaces have materials that read them")),
        (false, _, tangents) => {
            Ok(format!("{tangents} surfaces of {read} need their tangents too"))
        }
    }
}

fn environment_light(scene: &Scene) -> Reason {
    match scene.environment() {
        Some((_, emitter)) => Ok(format!("rays that leave the scene see `{}`", emitter.kind())),
        None => Err("rays that leave the scene see black".to_owned()),
    }
}

/// The integrator that makes the picture.
fn picture(integrator: &IntegratorSettings) -> Option<&IntegratorSettings> {
    match integrator {
        IntegratorSettings::Aov { picture, .. } => picture.as_deref(),
        other => Some(other),
    }
}

/// The path tracer's settings, or why there are none.
fn path(integrator: &IntegratorSettings) -> Result<&PathSettings, String> {
    match picture(integrator) {
        Some(IntegratorSettings::Path(path)) => Ok(path),
        Some(_) => Err("only the path tracer has it".to_owned()),
        None => Err("layers alone are asked for".to_owned()),
    }
}

fn next_event_estimation(integrator: &IntegratorSettings, scene: &Scene) -> Reason {
    let path = path(integrator)?;
    if path.strategy == Strategy::Bsdf {
        return Err("the integrator looks for light by scattering alone".to_owned());
    }
    if path.max_depth.is_some_and(|max| max < 2) {
        return Err("paths of one edge show emitters only".to_owned());
    }
    if scene.emitters().is_empty() {
        return Err("there is no emitter".to_owned());
    }
    let smooth = |&bsdf: &usize| scene.bsdfs()[bsdf].flags().smooth;
    if !scene.objects().iter().any(|o| o.bsdfs().iter().any(smooth)) {
        return Err("all surfaces are ideal mirrors or glass".to_owned());
    }
    Ok("one shadow ray from each surface that is no ideal mirror or glass".to_owned())
}

fn importance(integrator: &IntegratorSettings, next_event: &Reason) -> Reason {
    let heuristic = match path(integrator)?.strategy {
        Strategy::Mis(heuristic) => heuristic,
        Strategy::Bsdf => return Err("light is found by scattering alone".to_owned()),
        Strategy::Emitter => return Err("light is found by shadow rays alone".to_owned()),
    };
    if next_event.is_err() {
        return Err("there are no shadow rays".to_owned());
    }
    Ok(match heuristic {
        MisHeuristic::Balance => "by the balance heuristic".to_owned(),
        MisHeuristic::Power => "by the power heuristic".to_owned(),
    })
}

fn roulette(integrator: &IntegratorSettings) -> Reason {
    let PathSettings { roulette, max_depth, .. } = path(integrator)?;
    let survival = match roulette.policy {
        RoulettePolicy::None => return Err("the integrator's policy is to play none".to_owned()),
        RoulettePolicy::Fixed(p) => format!("{p}"),
        RoulettePolicy::Throughput => "the path's throughput".to_owned(),
    };
    match max_depth {
        Some(max) if *max <= roulette.min_depth => {
            Err(format!("paths end at {max} edges, before it begins"))
        }
        _ => Ok(format!(
            "from edge {} on, survival by {survival}, at most {}",
            roulette.min_depth.max(1),
            roulette.max_survival
        )),
    }
}

fn hidden_emitters(integrator: &IntegratorSettings) -> Reason {
    let hidden = match picture(integrator) {
        Some(IntegratorSettings::Path(path)) => path.hide_emitters,
        Some(
            IntegratorSettings::DirectUniform { hide_emitters }
            | IntegratorSettings::Branching { hide_emitters, .. },
        ) => *hide_emitters,
        Some(IntegratorSettings::AmbientOcclusion { .. } | IntegratorSettings::Aov { .. })
        | None => false,
    };
    if hidden {
        Ok("camera rays pass through emitters".to_owned())
    } else {
        Err("the camera sees emitters as other surfaces".to_owned())
    }
}

fn layers(integrator: &IntegratorSettings) -> Reason {
    match integrator {
        IntegratorSettings::Aov { layers, .. } if !layers.is_empty() => {
            let names: Vec<_> = layers.iter().map(|l| l.name.as_str()).collect();
            Ok(names.join(", "))
        }
        _ => Err("none is asked for".to_owned()),
    }
}

fn variance(description: &Description) -> Reason {
    let Description { film, effort, .. } = description;
    let reasons = [
        (film.variance, "the film has layers for it"),
        (effort.needs_error(), "an error is to be reached"),
        (effort.adaptive, "noisy parts get more samples"),
    ];
    let asked: Vec<_> = reasons.iter().filter(|(asked, _)| *asked).map(|(_, why)| *why).collect();
    if asked.is_empty() {
        return Err("nothing asks for an estimate of the error".to_owned());
    }
    match picture(&description.integrator) {
        Some(_) => Ok(asked.join(", ")),
        None => Err("layers alone are asked for".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DAffine3, Vec2, Vec3, Vec3A};

    use super::*;
    use crate::bsdf::conductor::Metal;
    use crate::bsdf::microfacet::{Distribution, Roughness};
    use crate::bsdf::{Bsdf, Conductor, Diffuse, RoughConductor};
    use crate::camera::{Orthographic, OrthographicSettings, Perspective, PerspectiveSettings};
    use crate::emitter::{Area, Constant, Emitter};
    use crate::math::Rgb;
    use crate::scene::settings::{AovLayer, Roulette};
    use crate::scene::tests::description;
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
        let object = |bsdf| Object::new("", triangle(smooth), bsdf, None);
        let objects = (0..bsdfs.len()).map(object).collect();
        let sky: Box<dyn Emitter> = Box::new(Constant::new(Rgb::ONE));
        Scene::new(objects, bsdfs, vec![sky], Some(0)).expect("valid")
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
        d.integrator = IntegratorSettings::DirectUniform { hide_emitters: true };
        assert_eq!(reason(&d, next_event), skipped("only the path tracer has it"));
        assert!(reason(&d, Feature::HiddenEmitters).0);
    }

    #[test]
    fn roulette_is_played_only_where_paths_get_that_far() {
        let mut d = description();
        let roulette =
            Roulette { policy: RoulettePolicy::Throughput, min_depth: 5, max_survival: 0.9 };
        let with = |max_depth, roulette| {
            path(PathSettings { max_depth, roulette, ..PathSettings::default() })
        };
        d.integrator = with(Some(5), roulette);
        let expected = skipped("paths end at 5 edges, before it begins");
        assert_eq!(reason(&d, Feature::RussianRoulette), expected);
        d.integrator = with(Some(6), roulette);
        let expected = "from edge 5 on, survival by the path's throughput, at most 0.9";
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
        d.scene = scene(false, vec![diffuse()]);
        let lamp = Area::new(triangle(false), Textured::Varying(board)).expect("has an area");
        d.scene.emitters.push(Box::new(lamp));
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
        d.integrator = IntegratorSettings::Aov { layers, picture: None };
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
}
