//! Telamon: a CPU path tracer for large meshes.

pub mod bsdf;
pub mod camera;
pub mod emitter;
pub mod film;
pub mod integrator;
pub mod intersect;
pub mod load;
pub mod math;
pub mod ray;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod shape;
