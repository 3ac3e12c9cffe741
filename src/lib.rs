//! Telamon: a CPU path tracer for large meshes.

pub mod bsdf;
pub mod camera;
pub mod emitter;
pub mod intersect;
pub mod load;
pub mod math;
pub mod ray;
pub mod scene;
pub mod sampler;
pub mod shape;
