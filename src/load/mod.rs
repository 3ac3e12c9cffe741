//! Files in: scenes and meshes become validated values.

pub mod mesh;
