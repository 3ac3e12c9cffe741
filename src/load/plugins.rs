//! What a scene file can name: one table of all plugins, from which files are checked, defaults are read
//! and documentation is written.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use super::emitter::Light;
use super::problem::Issue;
use super::properties::Object;
use super::shape::BuiltShape;
use super::spectrum::Role;
use super::{bsdf, deformable, emitter, film, integrator, rough, sampler, sensor, shape, texture};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::film::{FilmSettings, Filter};
use crate::integrator::IntegratorSettings;
use crate::sampler::SamplerKind;
use crate::texture::Texture;

/// Every plugin that a scene file can name: a new material is one new line here.
static PLUGINS: &[&Plugin] = &[
    &shape::OBJ,
    &shape::PLY,
    &shape::SERIALIZED,
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
    &film::BOX,
    &film::TENT,
    &film::GAUSSIAN,
    &sampler::INDEPENDENT,
    &sampler::SOBOL,
    &sampler::STRATIFIED,
    &sampler::MULTIJITTER,
    &sampler::ORTHOGONAL,
    &sampler::LDSAMPLER,
    &integrator::PATH,
    &integrator::DIRECT,
    &integrator::DIRECT_UNIFORM,
    &integrator::BRANCHING,
    &integrator::AMBIENT_OCCLUSION,
    &integrator::AOV,
    &integrator::MOMENT,
];

/// Every plugin that a scene file can name, category by category.
pub fn supported() -> impl Iterator<Item = &'static Plugin> {
    PLUGINS.iter().copied()
}

/// The plugin of that name.
pub(super) fn find(category: Category, name: &str) -> Option<&'static Plugin> {
    supported().find(|p| p.category() == category && p.name == name)
}

/// A kind of object that a scene file can name.
#[derive(Debug)]
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
            Build::Integrator(_) => Category::Integrator,
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

/// A property of a plugin.
#[derive(Debug)]
pub struct PropertyInfo {
    /// Its `name`.
    pub name: &'static str,
    /// The values that it takes.
    pub kind: Kind,
    /// What holds if it is not given.
    pub default: Default,
    /// What it means, in a sentence.
    pub help: &'static str,
}

/// A property in one line of the tables.
pub(super) const fn property(
    name: &'static str,
    kind: Kind,
    default: Default,
    help: &'static str,
) -> PropertyInfo {
    PropertyInfo { name, kind, default, help }
}

/// The values that a property takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `<boolean>`
    Boolean,
    /// `<integer>` from the first number to the second.
    Integer(i64, i64),
    /// `<float>` or `<integer>`.
    Float(Bounds),
    /// `<string>`
    Text,
    /// `<string>` that is one of these.
    Choice(&'static [&'static str]),
    /// `<string>` that names a file.
    File,
    /// `<point>` or `<vector>`.
    Point,
    /// `<transform>`
    Transform,
    /// `<transform>` or `<animation>`
    Motion,
    /// `<rgb>`, `<srgb>`, `<spectrum>`, or one number for all channels.
    Rgb(Bounds),
    /// The same, or `<texture>`.
    RgbTexture(Bounds),
    /// `<float>`, a colour whose mean counts, or `<texture>`.
    FloatTexture(Bounds),
    /// A number, or the name of a substance.
    RefractiveIndex,
    /// `<string>` that names a metal, or is `none`.
    Metal,
}

impl Kind {
    /// Where the channels of a colour must lie; `None` if it takes none.
    pub(super) fn color_bounds(self) -> Option<Bounds> {
        match self {
            Self::Rgb(bounds) | Self::RgbTexture(bounds) | Self::FloatTexture(bounds) => {
                Some(bounds)
            }
            _ => None,
        }
    }
}

/// A range of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Bounds {
    /// All that an f32 can hold.
    Any,
    /// Above 0.
    Positive,
    /// 0 or above.
    NotNegative,
    /// From 0 to 1.
    Unit,
    /// Above 0, up to 1.
    Probability,
}

impl Bounds {
    pub(super) fn contain(self, value: f64) -> bool {
        value.abs() <= f64::from(f32::MAX)
            && match self {
                Self::Any => true,
                // What rounds to 0 as f32 would not be above 0 where it is used.
                Self::Positive => value as f32 > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::Unit => (0.0..=1.0).contains(&value),
                Self::Probability => value as f32 > 0.0 && value <= 1.0,
            }
    }
}

impl Bounds {
    /// The smallest and the largest number within; 0 also where only what is above it is.
    pub(super) fn limits(self) -> [f32; 2] {
        match self {
            Self::Any => [f32::MIN, f32::MAX],
            Self::Positive | Self::NotNegative => [0.0, f32::MAX],
            Self::Unit | Self::Probability => [0.0, 1.0],
        }
    }

    /// The closest colour within.
    pub(super) fn clamp(self, rgb: DVec3) -> DVec3 {
        match self {
            Self::Any => rgb,
            Self::Positive | Self::NotNegative => rgb.max(DVec3::ZERO),
            Self::Unit | Self::Probability => rgb.clamp(DVec3::ZERO, DVec3::ONE),
        }
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Any => "any finite",
            Self::Positive => "above 0",
            Self::NotNegative => "of 0 or above",
            Self::Unit => "from 0 to 1",
            Self::Probability => "above 0, up to 1",
        })
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Boolean => f.write_str("boolean"),
            Self::Integer(min, max) if *max >= i64::from(i32::MAX) => {
                write!(f, "integer of {min} or above")
            }
            Self::Integer(min, max) => write!(f, "integer from {min} to {max}"),
            Self::Float(Bounds::Any) => f.write_str("float"),
            Self::Float(bounds) => write!(f, "float {bounds}"),
            Self::Text => f.write_str("string"),
            Self::Choice(names) => write!(f, "one of {}", names.join(", ")),
            Self::File => f.write_str("file name"),
            Self::Point => f.write_str("point"),
            Self::Transform => f.write_str("transform"),
            Self::Motion => f.write_str("transform or animation"),
            Self::Rgb(Bounds::Any) => f.write_str("colour"),
            Self::RgbTexture(bounds) => write!(f, "colour {bounds}, or texture"),
            Self::FloatTexture(bounds) => write!(f, "float {bounds}, or texture"),
            Self::Rgb(bounds) => write!(f, "colour {bounds}"),
            Self::RefractiveIndex => f.write_str("float above 0, or name of a substance"),
            Self::Metal => f.write_str("name of a metal, or none"),
        }
    }
}

/// What holds if a property is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    /// It must be given.
    Required,
    /// Nothing; in words, what happens then.
    Absent(&'static str),
    /// A truth value.
    Boolean(bool),
    /// A whole number.
    Integer(i64),
    /// A number.
    Float(f64),
    /// A text.
    Text(&'static str),
    /// A grey of this value.
    Grey(f64),
    /// The origin.
    Origin,
    /// The map that changes nothing.
    Identity,
}

impl fmt::Display for Default {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Required => f.write_str("required"),
            Self::Absent(words) => f.write_str(words),
            Self::Boolean(value) => write!(f, "{value}"),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Float(value) | Self::Grey(value) => write!(f, "{value}"),
            Self::Text(value) => f.write_str(value),
            Self::Origin => f.write_str("0, 0, 0"),
            Self::Identity => f.write_str("identity"),
        }
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
    Filter(fn(&Object<'_>) -> Filter),
    Sampler(SamplerKind),
    Integrator(fn(&Object<'_>) -> Result<IntegratorSettings, Issue>),
}

#[cfg(test)]
mod tests {
    use super::*;

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
