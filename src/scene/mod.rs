//! What is rendered, as validated, immutable data. Knows no file format, and nothing of how it is rendered.

use std::collections::HashSet;
use std::sync::Arc;

use crate::bsdf::Bsdf;
use crate::emitter::Emitter;
use crate::math::Aabb;
use crate::shape::{Geometry, Shape};

pub mod camera_motion;

pub use camera_motion::CameraMotion;

/// A shape with its material and, if it is a light, its emitter.
#[derive(Clone, Debug)]
pub struct Object {
    /// Its name in the scene file, for messages; may be empty.
    pub name: String,
    /// Its geometry.
    pub shape: Arc<dyn Shape>,
    /// Index of its material; of the first one of an instance.
    pub bsdf: usize,
    /// Indices of the materials of an instance's group, one for each shape; empty for other shapes.
    pub members: Arc<[usize]>,
    /// Index of its emitter.
    pub emitter: Option<usize>,
}

/// Surfaces, materials and lights.
#[derive(Debug, Default)]
pub struct Scene {
    objects: Vec<Object>,
    bsdfs: Vec<Box<dyn Bsdf>>,
    emitters: Vec<Box<dyn Emitter>>,
    environment: Option<usize>,
    bounds: Option<Aabb>,
}

/// Why parts do not form a scene.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// An object or the environment refers to a part that is not there.
    #[error("`{object}` refers to {part} {index}, but there are {count}")]
    NoSuchPart {
        /// Name of the object.
        object: String,
        /// `"material"` or `"emitter"`.
        part: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
}

impl Object {
    /// A shape that is no instance.
    #[must_use]
    pub fn new(name: &str, shape: Arc<dyn Shape>, bsdf: usize, emitter: Option<usize>) -> Self {
        Self { name: name.to_owned(), shape, bsdf, members: Arc::default(), emitter }
    }

    /// Index of the material of a shape of the group, if this is an instance; else of the object's.
    #[inline(always)]
    #[must_use]
    pub fn bsdf_of(&self, member: u32) -> usize {
        self.members.get(member as usize).copied().unwrap_or(self.bsdf)
    }

    /// Indices of all materials, one for each shape.
    #[must_use]
    pub fn bsdfs(&self) -> &[usize] {
        if self.members.is_empty() { std::slice::from_ref(&self.bsdf) } else { &self.members }
    }
}

impl Scene {
    /// A scene of these parts. `environment` is the index of the emitter that a ray sees when it leaves
    /// the scene.
    ///
    /// # Errors
    /// An index out of range.
    pub fn new(
        objects: Vec<Object>,
        bsdfs: Vec<Box<dyn Bsdf>>,
        emitters: Vec<Box<dyn Emitter>>,
        environment: Option<usize>,
    ) -> Result<Self, SceneError> {
        let check = |object: &str, part, index: Option<usize>, count| match index {
            Some(index) if index >= count => {
                Err(SceneError::NoSuchPart { object: object.to_owned(), part, index, count })
            }
            _ => Ok(()),
        };
        for o in &objects {
            check(&o.name, "material", Some(o.bsdf), bsdfs.len())?;
            check(&o.name, "emitter", o.emitter, emitters.len())?;
            for &bsdf in o.members.iter() {
                check(&o.name, "material", Some(bsdf), bsdfs.len())?;
            }
        }
        check("environment", "emitter", environment, emitters.len())?;
        let bounds = objects.iter().fold(Aabb::EMPTY, |b, o| b.union(o.shape.bounds()));
        let bounds = (!bounds.is_empty()).then_some(bounds);
        Ok(Self { objects, bsdfs, emitters, environment, bounds })
    }

    /// The shapes, in the order in which engines number them.
    #[must_use]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// The shapes alone, for an engine.
    #[must_use]
    pub fn shapes(&self) -> Vec<Arc<dyn Shape>> {
        self.objects.iter().map(|o| Arc::clone(&o.shape)).collect()
    }

    /// Bytes held by the shapes' buffers; those of a group are counted once, however often it is placed.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let mut groups = HashSet::new();
        let bytes = |object: &Object| match object.shape.geometry() {
            Geometry::Instance(i) if groups.insert(Arc::as_ptr(i.group())) => {
                object.shape.bytes() + i.group().bytes()
            }
            _ => object.shape.bytes(),
        };
        self.objects.iter().map(bytes).sum()
    }

    /// Materials.
    #[must_use]
    pub fn bsdfs(&self) -> &[Box<dyn Bsdf>] {
        &self.bsdfs
    }

    /// Lights.
    #[must_use]
    pub fn emitters(&self) -> &[Box<dyn Emitter>] {
        &self.emitters
    }

    /// The emitter that a ray sees when it leaves the scene, with its index.
    #[must_use]
    pub fn environment(&self) -> Option<(usize, &dyn Emitter)> {
        self.environment.map(|i| (i, self.emitters[i].as_ref()))
    }

    /// The box around all shapes; `None` if there are none.
    #[must_use]
    pub fn bounds(&self) -> Option<Aabb> {
        self.bounds
    }
}
