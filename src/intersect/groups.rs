//! What instances share: one engine, or one referee, over each group.

use std::collections::HashMap;
use std::sync::Arc;

use crate::shape::{Geometry, Shape};

/// By shape, what `build` makes of the shapes of an instance's group, once for each group. Empty if there
/// is no instance.
pub(crate) fn build_groups<E, F>(
    shapes: &[Arc<dyn Shape>],
    mut build: impl FnMut(&[Arc<dyn Shape>]) -> Result<E, F>,
) -> Result<Vec<Option<Arc<E>>>, F> {
    let mut built = HashMap::new();
    let mut engine = |shape: &Arc<dyn Shape>| {
        let Geometry::Instance(instance) = shape.geometry() else {
            return Ok(None);
        };
        let group = instance.group();
        if let Some(engine) = built.get(&Arc::as_ptr(group)) {
            return Ok(Some(Arc::clone(engine)));
        }
        let engine = Arc::new(build(group.shapes())?);
        built.insert(Arc::as_ptr(group), Arc::clone(&engine));
        Ok(Some(engine))
    };
    let is_instance = |shape: &Arc<dyn Shape>| matches!(shape.geometry(), Geometry::Instance(_));
    if shapes.iter().any(is_instance) {
        shapes.iter().map(&mut engine).collect()
    } else {
        Ok(Vec::new())
    }
}

/// Each engine once.
pub(super) fn distinct<E>(engines: &[Option<Arc<E>>]) -> impl Iterator<Item = &E> {
    let unique: HashMap<_, _> =
        engines.iter().flatten().map(|engine| (Arc::as_ptr(engine), engine.as_ref())).collect();
    unique.into_values()
}
