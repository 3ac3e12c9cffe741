//! What the objects of a scene share while they are built.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use super::document::Sources;
use super::graph::Graph;
use super::plugins::Category;
use super::problem::Issue;
use super::properties::Object;
use crate::bsdf::Bsdf;
use crate::memory::Limits;
use crate::property::Bounds;
use crate::texture::{Image, Texture};

/// An image, or what is wrong with its file.
type Decoded = Result<Arc<Image>, String>;

/// What all objects of a scene share.
#[derive(Debug)]
pub(super) struct Context<'a> {
    pub(super) graph: &'a Graph,
    pub(super) sources: &'a Sources,
    pub(super) limits: &'a Limits,
    /// Images by their files, each decoded once.
    pub(super) images: Mutex<HashMap<PathBuf, Arc<OnceLock<Decoded>>>>,
    /// Textures by their objects.
    pub(super) textures: Mutex<HashMap<usize, Arc<dyn Texture>>>,
    /// Textures with values kept within bounds, by their objects.
    pub(super) clamped_textures: Mutex<HashMap<(usize, Bounds), Arc<dyn Texture>>>,
    /// Materials that are part of several objects, by their own.
    pub(super) materials: Mutex<HashMap<usize, Arc<dyn Bsdf>>>,
    pub(super) warnings: Mutex<Vec<Issue>>,
    shutter: OnceLock<(f64, f64)>,
}

impl<'a> Context<'a> {
    pub(super) fn new(graph: &'a Graph, sources: &'a Sources, limits: &'a Limits) -> Self {
        Self {
            graph,
            sources,
            limits,
            images: Mutex::default(),
            textures: Mutex::default(),
            clamped_textures: Mutex::default(),
            materials: Mutex::default(),
            warnings: Mutex::default(),
            shutter: OnceLock::new(),
        }
    }

    /// What constructors found that may not be as meant.
    pub(super) fn into_warnings(self) -> Vec<Issue> {
        self.warnings.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// When the shutter of the first sensor opens and closes.
    pub(super) fn shutter(&'a self) -> (f64, f64) {
        // Asked for by everything that moves.
        *self.shutter.get_or_init(|| self.find_shutter())
    }

    fn find_shutter(&'a self) -> (f64, f64) {
        let top = self.graph.nodes.first().map_or(&[][..], |root| &root.children);
        let sensor = top
            .iter()
            .filter_map(|child| Object::new(self, child.node))
            .find(|o| o.plugin().category() == Category::Sensor);
        let has_shutter = |o: &Object<'a>| o.plugin().property("shutter_open").is_some();
        sensor
            .filter(has_shutter)
            .map_or((0.0, 0.0), |s| (s.float("shutter_open"), s.float("shutter_close")))
    }

    /// All objects, wherever they stand.
    pub(super) fn objects(&'a self) -> impl Iterator<Item = Object<'a>> {
        (0..self.graph.nodes.len()).filter_map(|index| Object::new(self, index))
    }
}

/// What a thread that panicked left is as good as what it found.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
