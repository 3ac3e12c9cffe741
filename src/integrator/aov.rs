//! Layers beside the picture: properties of the first surface that a camera ray meets.

use glam::{Vec2, Vec3A};

use super::plugin::{Plugin, Told};
use super::shading::Shading;
use super::{IntegratorSettings, Parts, Settings, Tracer, Vertex};
use crate::film::{AovKind, AovLayer};
use crate::property::named::{did_you_mean, quoted};
use crate::property::{self, At, Given, Kind, Named, PropertyInfo, Refusal, property};
use crate::ray::Ray;
use crate::scene::Scene;

/// All that they can be told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AovSettings {
    /// What to write.
    pub layers: Vec<AovLayer>,
    /// Makes the picture; `None`: layers alone.
    pub picture: Option<Box<IntegratorSettings>>,
}

const AOVS: PropertyInfo = property(
    "aovs",
    Kind::Text,
    property::Default::Required,
    "name:kind, with commas between; kinds are depth, position, uv, geo_normal, sh_normal, albedo, \
     shape_index and prim_index",
);

static AOV: Plugin = Plugin {
    name: "aov",
    help: "Properties of the first surface, as layers beside the picture of the integrator inside it.",
    properties: &[AOVS],
    contains: true,
    read: |told| Ok(AovSettings::read(told)?.into()),
    in_place_of: None,
};

impl AovSettings {
    fn read(told: &dyn Told) -> Result<Self, Refusal> {
        let layers = layers(told)?;
        let picture = told.inner().transpose()?;
        if let Some(IntegratorSettings::Aov(_)) = picture {
            let message =
                "integrator `aov` inside integrator `aov`: put all layers into one of them";
            return Err(Refusal::new(At::Object, message).inside());
        }
        Ok(Self { layers, picture: picture.map(Box::new) })
    }
}

fn layers(told: &dyn Given) -> Result<Vec<AovLayer>, Refusal> {
    let wrong = |message: String| Refusal::new(At::Value(AOVS.name), message);
    let text = told.text(&AOVS).unwrap_or_default();
    let mut layers: Vec<AovLayer> = Vec::new();
    for item in text.split(',').map(str::trim).filter(|item| !item.is_empty()) {
        let layer = layer(item)?;
        if layers.iter().any(|l| l.name == layer.name) {
            let message = format!("there is more than one layer with the name `{}`", layer.name);
            return Err(wrong(message));
        }
        layers.push(layer);
    }
    if layers.is_empty() {
        let message = "`aovs` names no layer (expected some, as in dd:depth, nn:sh_normal)";
        return Err(wrong(message.to_owned()));
    }
    Ok(layers)
}

fn layer(item: &str) -> Result<AovLayer, Refusal> {
    let wrong = |message: String| Refusal::new(At::Value(AOVS.name), message);
    let (name, kind) = item.split_once(':').unwrap_or((item, ""));
    let (name, kind) = (name.trim(), kind.trim());
    if name.is_empty() || kind.is_empty() {
        return Err(wrong(format!("`{item}` is not of the form name:kind")));
    }
    AovKind::named(kind).map(|kind| AovLayer { name: name.to_owned(), kind }).ok_or_else(|| {
        let names = || AovKind::ALL.iter().map(|(name, _)| *name);
        let hint = did_you_mean(kind, names());
        wrong(format!("there is no layer of the kind `{kind}`{hint}"))
            .with_help(format!("expected one of {}", quoted(names())))
    })
}

impl Settings for AovSettings {
    fn plugins() -> &'static [Plugin] {
        std::slice::from_ref(&AOV)
    }

    fn build<'a>(&'a self, scene: &Scene) -> Parts<'a> {
        let (picture, nested) =
            self.picture.as_deref().map_or((None, None), |p| p.about().build(scene));
        debug_assert!(nested.is_none(), "layers within layers are refused");
        (picture, Some(Aov::new(&self.layers)))
    }

    fn describe(&self) -> String {
        let beside = self.picture.as_deref().map(|p| format!(" beside {}", p.about().describe()));
        format!("{} layers{}", self.layers.len(), beside.unwrap_or_default())
    }
}

/// An index where there is no surface.
pub const NO_INDEX: u32 = u32::MAX;

/// The layers that are asked for.
#[derive(Clone, Copy, Debug)]
pub struct Aov<'a> {
    layers: &'a [AovLayer],
}

impl<'a> Aov<'a> {
    /// Evaluates `layers`, in this order.
    #[must_use]
    pub fn new(layers: &'a [AovLayer]) -> Self {
        Self { layers }
    }

    /// Evaluates the layers for `ray`. `number` gets each component of the layers that are averaged,
    /// `index` the value of each that is not, both in the layers' order.
    pub fn evaluate(
        &self,
        tracer: &mut Tracer<'_>,
        ray: &Ray,
        mut number: impl FnMut(f32),
        mut index: impl FnMut(u32),
    ) {
        let vertex = tracer.closest_vertex(ray);
        let vertex = vertex.as_ref();
        for layer in self.layers {
            match layer.kind {
                AovKind::Depth => number(vertex.map_or(0.0, |v| v.hit.t)),
                AovKind::Uv => {
                    let uv = vertex.map_or(Vec2::ZERO, |v| v.object.shape.uv(ray, &v.hit));
                    uv.to_array().into_iter().for_each(&mut number);
                }
                AovKind::ShapeIndex => index(vertex.map_or(NO_INDEX, |v| v.hit.shape)),
                AovKind::PrimitiveIndex => index(vertex.map_or(NO_INDEX, |v| v.hit.primitive)),
                AovKind::Position
                | AovKind::GeometricNormal
                | AovKind::ShadingNormal
                | AovKind::Albedo => {
                    let triple = vertex.map_or(Vec3A::ZERO, |v| triple(layer.kind, v, ray));
                    triple.to_array().into_iter().for_each(&mut number);
                }
            }
        }
    }
}

/// The layers of three components.
fn triple(kind: AovKind, vertex: &Vertex<'_>, ray: &Ray) -> Vec3A {
    match kind {
        AovKind::Position => vertex.surface.position.as_vec3a(),
        AovKind::GeometricNormal => vertex.surface.geometric_normal,
        AovKind::ShadingNormal => vertex.surface.shading_normal,
        AovKind::Albedo => Shading::of_vertex(vertex, ray).albedo(),
        AovKind::Depth | AovKind::Uv | AovKind::ShapeIndex | AovKind::PrimitiveIndex => {
            unreachable!("has one or two components")
        }
    }
}
