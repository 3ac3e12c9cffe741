//! Layers beside the picture: properties of the first surface that a camera ray meets.

use glam::{Vec2, Vec3A};

use super::tracer::Shading;
use super::{Tracer, Vertex};
use crate::film::{AovKind, AovLayer};
use crate::ray::Ray;

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
        AovKind::Albedo => Shading::new(vertex, ray).albedo(),
        AovKind::Depth | AovKind::Uv | AovKind::ShapeIndex | AovKind::PrimitiveIndex => {
            unreachable!("has one or two components")
        }
    }
}
