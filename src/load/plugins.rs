//! What a scene file can name: one table of all plugins, from which files are checked, defaults are read
//! and documentation is written.

use std::sync::{Arc, LazyLock};

use super::emitter::Light;
use super::problem::Issue;
use super::properties::Object;
use super::shape::BuiltShape;
use super::spectrum::Role;
use super::{
    bsdf, deformable, emitter, film, integrator, mesh_shape, rough, sampler, sensor, shape, texture,
};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::film::{FilmSettings, filter};
use crate::integrator::plugin::Read as ReadIntegrator;
use crate::property::PropertyInfo;
use crate::sampler::SamplerKind;
use crate::texture::Texture;

/// Plugins whose tables stand in this room: a new material is one new line here.
static PLUGINS: &[&Plugin] = &[
    &mesh_shape::OBJ,
    &mesh_shape::PLY,
    &mesh_shape::STL,
    &mesh_shape::SERIALIZED,
    &shape::RECTANGLE,
    &shape::CUBE,
    &shape::SPHERE,
    &shape::DISK,
    &shape::CYLINDER,
    &deformable::DEFORMABLE,
    &shape::SHAPEGROUP,
    &shape::INSTANCE,
    &bsdf::DIFFUSE,
    &bsdf::CONDUCTOR,
    &rough::ROUGH_CONDUCTOR,
    &bsdf::DIELECTRIC,
    &rough::ROUGH_DIELECTRIC,
    &bsdf::THIN_DIELECTRIC,
    &bsdf::PLASTIC,
    &rough::ROUGH_PLASTIC,
    &bsdf::TWOSIDED,
    &bsdf::BLEND,
    &bsdf::MASK,
    &bsdf::NULL,
    &bsdf::BUMP_MAP,
    &bsdf::NORMAL_MAP,
    &texture::BITMAP,
    &texture::CHECKERBOARD,
    &emitter::AREA,
    &emitter::CONSTANT,
    &emitter::ENVIRONMENT_MAP,
    &emitter::POINT,
    &emitter::DIRECTIONAL,
    &emitter::SPOT,
    &sensor::PERSPECTIVE,
    &sensor::THIN_LENS,
    &sensor::ORTHOGRAPHIC,
    &film::HDRFILM,
];

/// Filters, samplers and integrators: their own rooms list them.
static FROM_ROOMS: LazyLock<Vec<Plugin>> = LazyLock::new(|| {
    film::filters().chain(sampler::plugins()).chain(integrator::plugins()).collect()
});

/// Every plugin that a scene file can name, category by category.
pub fn supported() -> impl Iterator<Item = &'static Plugin> {
    PLUGINS.iter().copied().chain(FROM_ROOMS.iter())
}

/// The plugin of that name.
pub(super) fn find(category: Category, name: &str) -> Option<&'static Plugin> {
    supported().find(|p| p.category() == category && p.name == name)
}

/// A kind of object that a scene file can name.
#[derive(Clone, Copy, Debug)]
pub struct Plugin {
    /// The value of its `type`.
    pub name: &'static str,
    /// What it is, in a sentence.
    pub help: &'static str,
    /// The properties that it takes.
    pub properties: &'static [PropertyInfo],
    /// The objects that it takes.
    pub parts: &'static [Part],
    pub(super) build: Build,
}

impl Plugin {
    /// What kind of object it is.
    #[must_use]
    pub fn category(&self) -> Category {
        match self.build {
            Build::Shape(_) | Build::Group | Build::Instance => Category::Shape,
            Build::Bsdf(_) => Category::Bsdf,
            Build::Texture(_) => Category::Texture,
            Build::Emitter(_) => Category::Emitter,
            Build::Sensor(_) => Category::Sensor,
            Build::Film(_) => Category::Film,
            Build::Filter(_) => Category::Filter,
            Build::Sampler(_) => Category::Sampler,
            Build::Integrator(_) | Build::InnerIntegrator => Category::Integrator,
        }
    }

    /// What spectra among its properties describe.
    pub(super) fn light(&self) -> Role {
        if self.category() == Category::Emitter { Role::Emission } else { Role::Material }
    }

    pub(super) fn property(&self, name: &str) -> Option<&'static PropertyInfo> {
        self.properties.iter().find(|p| p.name == name)
    }
}

/// Objects that a plugin takes inside it.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Their kind.
    pub category: Category,
    /// The fewest.
    pub least: usize,
    /// The most.
    pub most: usize,
}

impl Part {
    /// At most one.
    pub(super) const fn optional(category: Category) -> Self {
        Self { category, least: 0, most: 1 }
    }
}

/// Kinds of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Category {
    /// What can be hit.
    Shape,
    /// A material.
    Bsdf,
    /// What varies over a surface.
    Texture,
    /// A light.
    Emitter,
    /// A camera.
    Sensor,
    /// What the camera exposes.
    Film,
    /// How samples become pixels.
    Filter,
    /// Where samples come from.
    Sampler,
    /// How light is carried.
    Integrator,
}

impl Category {
    /// All of them, in the order of [`supported`].
    pub const ALL: [Self; 9] = [
        Self::Shape,
        Self::Bsdf,
        Self::Texture,
        Self::Emitter,
        Self::Sensor,
        Self::Film,
        Self::Filter,
        Self::Sampler,
        Self::Integrator,
    ];

    /// The name of its element.
    #[must_use]
    pub fn tag(self) -> &'static str {
        match self {
            Self::Shape => "shape",
            Self::Bsdf => "bsdf",
            Self::Texture => "texture",
            Self::Emitter => "emitter",
            Self::Sensor => "sensor",
            Self::Film => "film",
            Self::Filter => "rfilter",
            Self::Sampler => "sampler",
            Self::Integrator => "integrator",
        }
    }
}

/// How an object that has been checked is built.
#[derive(Clone, Copy, Debug)]
pub(super) enum Build {
    Shape(fn(&Object<'_>) -> Result<BuiltShape, Issue>),
    /// A group of shapes, by those inside it.
    Group,
    /// A shape, by the group inside it.
    Instance,
    Bsdf(fn(&Object<'_>) -> Result<Box<dyn Bsdf>, Issue>),
    Texture(fn(&Object<'_>) -> Result<Arc<dyn Texture>, Issue>),
    Emitter(fn(&Object<'_>) -> Result<Light, Issue>),
    Sensor(fn(&Object<'_>, &FilmSettings) -> Result<Camera, Issue>),
    Film(fn(&Object<'_>) -> Result<FilmSettings, Issue>),
    Filter(&'static filter::About),
    Sampler(SamplerKind),
    Integrator(ReadIntegrator),
    /// The integrator inside it.
    InnerIntegrator,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::property::{Default, Kind};

    #[test]
    fn names_are_unique_and_categories_stand_together() {
        let names: Vec<_> = supported().map(|p| (p.category().tag(), p.name)).collect();
        for (i, name) in names.iter().enumerate() {
            assert!(!names[..i].contains(name), "{name:?} twice");
        }
        let mut categories: Vec<_> = supported().map(Plugin::category).collect();
        categories.dedup();
        assert_eq!(categories, Category::ALL);
    }

    /// Every default lies within what its property takes, and is of its kind.
    #[test]
    fn defaults_are_allowed_values() {
        for plugin in supported() {
            for p in plugin.properties {
                let fits = match (p.kind, p.default) {
                    (_, Default::Required | Default::Absent(_))
                    | (Kind::Boolean, Default::Boolean(_))
                    | (Kind::Text | Kind::RefractiveIndex | Kind::Metal, Default::Text(_))
                    | (Kind::Point, Default::Origin)
                    | (Kind::Transform | Kind::Motion, Default::Identity) => true,
                    (Kind::Integer(min, max), Default::Integer(v)) => (min..=max).contains(&v),
                    (Kind::Float(bounds) | Kind::FloatTexture(bounds), Default::Float(v))
                    | (Kind::Rgb(bounds) | Kind::RgbTexture(bounds), Default::Grey(v)) => {
                        bounds.contain(v)
                    }
                    (Kind::Choice(names), Default::Text(name)) => names.contains(&name),
                    _ => false,
                };
                assert!(fits, "{} {}: {:?} as {:?}", plugin.name, p.name, p.default, p.kind);
                assert!(!p.help.is_empty() && !p.kind.to_string().is_empty());
            }
        }
    }
}
