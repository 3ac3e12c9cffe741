//! Telamon: a CPU path tracer for triangle meshes and simple shapes.
//!
//! Embree, or a BVH of this crate's own, answers ray queries; everything else is Rust. Scenes are
//! Mitsuba 3 files ([`load`]), or are put together from [`render::Description`].
//!
//! ```
//! use std::path::Path;
//! use std::sync::atomic::AtomicBool;
//!
//! use telamon::intersect::{self, Backend};
//! use telamon::load::{LoadOptions, load_text};
//! use telamon::render::render;
//!
//! // A room that glows with radiance 1 and reflects half of it: 1 + 1/2 + 1/4 + … = 2 everywhere.
//! let scene = r#"<scene version="3.0.0">
//!     <integrator type="path"/>
//!     <sensor type="perspective">
//!         <film type="hdrfilm"><integer name="width" value="4"/><integer name="height" value="3"/></film>
//!         <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
//!     </sensor>
//!     <shape type="cube">
//!         <boolean name="flip_normals" value="true"/>
//!         <bsdf type="diffuse"><rgb name="reflectance" value="0.5"/></bsdf>
//!         <emitter type="area"><rgb name="radiance" value="1"/></emitter>
//!     </shape>
//! </scene>"#;
//! let loaded = load_text(scene, Path::new("room.xml"), &LoadOptions::default())?;
//! let engine = intersect::build(Backend::Rust, &loaded.description.scene.shapes())?;
//! let never = AtomicBool::new(false);
//! let (film, statistics) = render(&loaded.description, engine.as_ref(), &|_| (), &never);
//!
//! let pixels = film.radiance();
//! let mean = pixels.iter().map(|rgb| rgb.x).sum::<f32>() / pixels.len() as f32;
//! // The standard deviation of a path is 1.4 at most, so 0.05 for the mean of 768.
//! assert!((mean - 2.0).abs() < 0.25);
//! assert_eq!(statistics.non_finite, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Conventions
//!
//! - Directions are unit vectors and point away from the surface: `wi` to where a path came from, `wo` to
//!   where it goes. In a local frame z is the shading normal.
//! - Lengths are in scene units, angles in radians (degrees only where a name ends in `deg`), the time of
//!   a ray in `[0, 1]` of the shutter.
//! - Colours are linear sRGB: radiance in W·m⁻²·sr⁻¹, or a reflectance without unit.
//! - Densities are per solid angle (sr⁻¹) unless the name says per area.
//! - `sample` returns a weight f·|cosθ|/pdf and not a quotient to be formed; `None` means that there is no
//!   sample, never that it is black.
//!
//! # Features
//!
//! `embree` (default) makes Debian's Embree available as an engine. Without it nothing but Rust is needed.

pub mod bsdf;
pub mod camera;
pub mod emitter;
pub mod film;
pub mod integrator;
pub mod intersect;
pub mod load;
pub mod math;
pub mod measure;
pub mod memory;
pub mod parity;
pub mod property;
pub mod ray;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod shape;
pub mod studio;
pub mod texture;
