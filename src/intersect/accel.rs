//! Which engine answers, and in which mode: what `--backend` and `--accel` choose.

use std::collections::HashSet;
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;
use std::sync::Arc;

use super::Backend;
use crate::shape::{Geometry, Group, Shape};

/// An engine with its modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accel {
    /// Debian's Embree.
    #[cfg(feature = "embree")]
    Embree(EmbreeModes),
    /// The BVH of this crate.
    Rust(RustModes),
}

/// Modes of Embree.
#[cfg(feature = "embree")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EmbreeModes {
    /// Watertight tests, and boxes that are widened by their rounding errors. The default: the fast
    /// mode loses up to half of all hits far from the origin.
    pub robust: bool,
    /// Smaller nodes and triangles without copies of their vertices: less memory, slower rays.
    pub compact: bool,
    /// How much time goes into the build.
    pub quality: BuildQuality,
    /// Whether the nearest hits of many rays are looked for in packets of eight, or ray by ray.
    pub packets: bool,
}

#[cfg(feature = "embree")]
impl Default for EmbreeModes {
    fn default() -> Self {
        Self { robust: true, compact: false, quality: BuildQuality::Medium, packets: true }
    }
}

/// How much time Embree spends on its tree.
#[cfg(feature = "embree")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildQuality {
    /// By Morton codes.
    Low,
    /// By the binned surface area heuristic.
    Medium,
    /// The same with spatial splits, which cut long thin triangles.
    High,
}

/// Modes of the Rust engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RustModes {
    /// How a ray is tested against a triangle.
    pub triangle: TriangleTest,
}

/// A ray–triangle test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleTest {
    /// Woop, Benthin and Wald (2013): no ray passes between two triangles that share an edge.
    #[default]
    Watertight,
    /// Möller and Trumbore (1997) in f32: a few operations less, and a ray that meets an edge may miss
    /// both triangles.
    Plain,
}

/// One `key` of an engine: the values it may have, and how each is set.
struct Knob<Modes: 'static> {
    key: &'static str,
    values: &'static [Value<Modes>],
}

/// A value's name, and what it does.
type Value<Modes> = (&'static str, fn(&mut Modes));

#[cfg(feature = "embree")]
const EMBREE_KNOBS: &[Knob<EmbreeModes>] = &[
    Knob {
        key: "robust",
        values: &[("true", |m| m.robust = true), ("false", |m| m.robust = false)],
    },
    Knob {
        key: "compact",
        values: &[("true", |m| m.compact = true), ("false", |m| m.compact = false)],
    },
    Knob {
        key: "quality",
        values: &[
            ("low", |m| m.quality = BuildQuality::Low),
            ("medium", |m| m.quality = BuildQuality::Medium),
            ("high", |m| m.quality = BuildQuality::High),
        ],
    },
    Knob {
        key: "packets",
        values: &[("true", |m| m.packets = true), ("false", |m| m.packets = false)],
    },
];

const RUST_KNOBS: &[Knob<RustModes>] = &[Knob {
    key: "triangle",
    values: &[
        ("watertight", |m| m.triangle = TriangleTest::Watertight),
        ("plain", |m| m.triangle = TriangleTest::Plain),
    ],
}];

/// Bytes that building and keeping an engine takes at the peak, for each triangle, beside the mesh: measured
/// with a grid of 999,698 triangles. Embree's compact scenes take less.
#[cfg(feature = "embree")]
const EMBREE_BYTES: u64 = 90;
#[cfg(feature = "embree")]
const COMPACT_BYTES: u64 = 65;
const RUST_BYTES: u64 = 90;

impl Accel {
    /// Bytes of memory that an engine over `shapes` takes about, the shapes aside.
    #[must_use]
    pub fn estimated_bytes(&self, shapes: &[Arc<dyn Shape>]) -> u64 {
        let per_triangle = match self {
            #[cfg(feature = "embree")]
            Self::Embree(EmbreeModes { compact: true, .. }) => COMPACT_BYTES,
            #[cfg(feature = "embree")]
            Self::Embree(_) => EMBREE_BYTES,
            Self::Rust(_) => RUST_BYTES,
        };
        let mut groups = HashSet::new();
        let triangles: usize = shapes.iter().map(|s| triangles(s.as_ref(), &mut groups)).sum();
        per_triangle.saturating_mul(triangles as u64)
    }

    /// The engine behind these modes.
    #[must_use]
    pub fn backend(&self) -> Backend {
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(_) => Backend::Embree,
            Self::Rust(_) => Backend::Rust,
        }
    }

    /// Sets one mode by its name on the command line.
    ///
    /// # Errors
    /// A key or a value that this engine does not have; the message lists those that it has.
    pub fn set(&mut self, mode: &Mode) -> Result<(), UnknownMode> {
        let backend = self.backend();
        match self {
            #[cfg(feature = "embree")]
            Self::Embree(modes) => set(backend, EMBREE_KNOBS, modes, mode),
            Self::Rust(modes) => set(backend, RUST_KNOBS, modes, mode),
        }
    }

    /// Each mode that an engine has, with its values: `("quality", ["low", "medium", "high"])`.
    #[must_use]
    pub fn modes(backend: Backend) -> Vec<(&'static str, Vec<&'static str>)> {
        match backend {
            #[cfg(feature = "embree")]
            Backend::Embree => list(EMBREE_KNOBS),
            Backend::Rust => list(RUST_KNOBS),
        }
    }
}

/// Triangles that an engine holds for a shape; none for a group that it has already, which is stored once
/// however often it is placed.
fn triangles(shape: &dyn Shape, groups: &mut HashSet<*const Group>) -> usize {
    match shape.geometry() {
        Geometry::Triangles { triangles, .. } => triangles.len(),
        Geometry::Deforming(mesh) => mesh.triangles().len(),
        Geometry::Instance(instance) if groups.insert(Arc::as_ptr(instance.group())) => {
            instance.group().shapes().iter().map(|s| triangles(s.as_ref(), groups)).sum()
        }
        Geometry::Analytic(_) | Geometry::Instance(_) => 0,
    }
}

fn set<M>(
    backend: Backend,
    knobs: &[Knob<M>],
    modes: &mut M,
    mode: &Mode,
) -> Result<(), UnknownMode> {
    let Mode { key, value } = mode;
    let Some(knob) = knobs.iter().find(|k| k.key == key) else {
        let expected = knobs.iter().map(|k| k.key).collect();
        return Err(UnknownMode::Key { backend, key: key.clone(), expected });
    };
    let Some((_, apply)) = knob.values.iter().find(|(name, _)| name == value) else {
        let expected = knob.values.iter().map(|(name, _)| *name).collect();
        return Err(UnknownMode::Value { key: knob.key, value: value.clone(), expected });
    };
    apply(modes);
    Ok(())
}

fn list<M>(knobs: &[Knob<M>]) -> Vec<(&'static str, Vec<&'static str>)> {
    knobs.iter().map(|k| (k.key, k.values.iter().map(|(name, _)| *name).collect())).collect()
}

impl From<Backend> for Accel {
    /// The engine in its default modes.
    fn from(backend: Backend) -> Self {
        match backend {
            #[cfg(feature = "embree")]
            Backend::Embree => Self::Embree(EmbreeModes::default()),
            Backend::Rust => Self::Rust(RustModes::default()),
        }
    }
}

impl Default for Accel {
    fn default() -> Self {
        Backend::default().into()
    }
}

#[cfg(feature = "embree")]
impl Display for EmbreeModes {
    /// As in reports: `robust, quality high`. Defaults other than `robust` go without saying.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(if self.robust { "robust" } else { "fast" })?;
        f.write_str(if self.compact { ", compact" } else { "" })?;
        f.write_str(match self.quality {
            BuildQuality::Low => ", quality low",
            BuildQuality::Medium => "",
            BuildQuality::High => ", quality high",
        })?;
        f.write_str(if self.packets { "" } else { ", no packets" })
    }
}

impl Display for RustModes {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self.triangle {
            TriangleTest::Watertight => "watertight",
            TriangleTest::Plain => "plain",
        })
    }
}

/// A mode by name, as on the command line: `quality=high`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mode {
    /// Its name.
    pub key: String,
    /// What it is to be.
    pub value: String,
}

impl FromStr for Mode {
    type Err = MalformedMode;

    fn from_str(text: &str) -> Result<Self, MalformedMode> {
        match text.split_once('=') {
            Some((key, value)) if !key.is_empty() && !value.is_empty() => {
                Ok(Self { key: key.to_owned(), value: value.to_owned() })
            }
            _ => Err(MalformedMode),
        }
    }
}

/// Text that is no `KEY=VALUE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected KEY=VALUE, such as {EXAMPLE}")]
pub struct MalformedMode;

#[cfg(feature = "embree")]
const EXAMPLE: &str = "quality=high";
#[cfg(not(feature = "embree"))]
const EXAMPLE: &str = "triangle=plain";

/// A mode that the engine does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownMode {
    /// No mode of that name.
    #[error("backend `{backend}` has no mode `{key}` (expected one of: {})", expected.join(", "))]
    Key {
        /// The engine.
        backend: Backend,
        /// The name.
        key: String,
        /// Names that it knows.
        expected: Vec<&'static str>,
    },
    /// The mode cannot be that.
    #[error("mode `{key}` cannot be `{value}` (expected one of: {})", expected.join(", "))]
    Value {
        /// The mode.
        key: &'static str,
        /// The value.
        value: String,
        /// Values that it may have.
        expected: Vec<&'static str>,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each value of each mode is taken, and two values of one mode differ in what they do.
    #[test]
    fn every_mode_has_an_effect() {
        for &backend in Backend::AVAILABLE {
            for (key, values) in Accel::modes(backend) {
                let set = |value: &&str| {
                    let mut accel = Accel::from(backend);
                    let mode = format!("{key}={value}").parse().expect("well-formed");
                    accel.set(&mode).expect("listed");
                    accel
                };
                let accels: Vec<_> = values.iter().map(set).collect();
                for (i, a) in accels.iter().enumerate() {
                    assert!(!accels[..i].contains(a), "{backend} {key}: {a:?} twice");
                }
                assert!(accels.contains(&backend.into()), "{backend} {key}: no default");
            }
        }
    }

    #[test]
    fn errors_list_what_is_known() {
        let mut accel = Accel::from(Backend::Rust);
        let mut error = |text: &str| {
            let mode = text.parse().expect("well-formed");
            accel.set(&mode).expect_err("not known").to_string()
        };
        assert_eq!(
            error("robust=true"),
            "backend `rust` has no mode `robust` (expected one of: triangle)"
        );
        assert_eq!(
            error("triangle=exact"),
            "mode `triangle` cannot be `exact` (expected one of: watertight, plain)"
        );
        for text in ["robust", "=true", "robust=", ""] {
            assert_eq!(text.parse::<Mode>(), Err(MalformedMode), "{text}");
        }
    }
}
