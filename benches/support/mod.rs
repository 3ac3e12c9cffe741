//! What the benchmarks share: arguments, times, and the two peers that they compare with.

#![allow(dead_code, reason = "each benchmark uses a part of it")]

#[path = "../../tests/support/python.rs"]
pub(crate) mod python;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use std::{env, fmt};

#[cfg(feature = "bare")]
use embree_sys::bare;
use telamon::load::{LoadOptions, load_scene};
use telamon::render::Description;
use telamon::shape::{Geometry, Shape};

#[cfg(feature = "bare")]
pub(crate) mod recorder;

use python::Python;

/// What a benchmark returns.
pub(crate) type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// Words of the command line; every option takes a value.
pub(crate) struct Arguments {
    /// What belongs to no option.
    pub(crate) paths: Vec<PathBuf>,
    options: Vec<(String, String)>,
}

impl Arguments {
    /// Reads the command line. `usage` follows after what is wrong with it.
    pub(crate) fn read(known: &[&str], usage: &str) -> Outcome<Self> {
        let mut arguments = Self { paths: Vec::new(), options: Vec::new() };
        // Cargo adds `--bench`.
        let mut words = env::args().skip(1).filter(|word| word != "--bench");
        while let Some(word) = words.next() {
            if !word.starts_with('-') {
                arguments.paths.push(word.into());
            } else if !known.contains(&word.as_str()) {
                return Err(format!("unknown option {word}; usage: {usage}").into());
            } else {
                let value = words.next().ok_or(format!("{word} needs a value; usage: {usage}"))?;
                arguments.options.push((word, value));
            }
        }
        Ok(arguments)
    }

    /// All values of an option.
    pub(crate) fn values<'a>(&'a self, option: &'a str) -> impl Iterator<Item = &'a str> {
        self.options.iter().filter(move |(name, _)| name == option).map(|(_, v)| v.as_str())
    }

    /// The last value of an option.
    pub(crate) fn value<'a>(&'a self, option: &'a str) -> Option<&'a str> {
        self.values(option).last()
    }

    /// The last value of an option that takes a number above 0.
    pub(crate) fn count(&self, option: &str, default: usize) -> Outcome<usize> {
        match self.value(option).map(str::parse) {
            None => Ok(default),
            Some(Ok(count)) if count > 0 => Ok(count),
            Some(_) => Err(format!("{option} needs a whole number above 0").into()),
        }
    }
}

/// A scene file and the values of its parameters.
pub(crate) struct SceneFile {
    pub(crate) path: PathBuf,
    pub(crate) defines: Vec<(String, String)>,
}

impl SceneFile {
    /// The Cornell box, and the dragon if there is a mesh for it.
    pub(crate) fn defaults(dragon: Option<&str>) -> Vec<Self> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let cornell_box = Self { path: root.join("scenes/cornell-box.xml"), defines: Vec::new() };
        let dragon = dragon.map(|mesh| Self {
            path: root.join("benches/scenes/dragon.xml"),
            defines: vec![("mesh".to_owned(), mesh.to_owned())],
        });
        [cornell_box].into_iter().chain(dragon).collect()
    }

    pub(crate) fn name(&self) -> String {
        self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    pub(crate) fn load(&self) -> Outcome<Description> {
        let options = LoadOptions { defines: self.defines.clone(), ..LoadOptions::default() };
        Ok(load_scene(&self.path, &options)?.description)
    }
}

/// How long something takes, in seconds.
pub(crate) fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    std::hint::black_box(work());
    start.elapsed().as_secs_f64()
}

/// Median, least and largest of some numbers.
#[derive(Clone, Copy)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    least: f64,
    largest: f64,
}

impl Spread {
    /// Of at least one number.
    pub(crate) fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let mut numbers: Vec<_> = numbers.into_iter().collect();
        numbers.sort_by(f64::total_cmp);
        let (least, largest) = (numbers[0], numbers[numbers.len() - 1]);
        Self { median: numbers[numbers.len() / 2], least, largest }
    }
}

impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} ({:.3} to {:.3})", self.median, self.least, self.largest)
    }
}

/// Vertices with their padding and triangles of a mesh, as C reads them.
pub(crate) type Buffers = (Vec<[f32; 4]>, Vec<[u32; 3]>);

/// The meshes of a scene for bare Embree, which knows nothing else.
pub(crate) fn buffers(shapes: &[Arc<dyn Shape>]) -> Outcome<Vec<Buffers>> {
    let buffers = |shape: &Arc<dyn Shape>| match shape.geometry() {
        Geometry::Triangles { positions, triangles } => {
            Ok((positions.iter().map(|p| p.extend(0.0).to_array()).collect(), triangles.to_vec()))
        }
        Geometry::Deforming(_) | Geometry::Analytic(_) | Geometry::Instance(_) => {
            Err("the scene has more than plain meshes; the bare engine is measured on meshes only"
                .into())
        }
    };
    shapes.iter().map(buffers).collect()
}

/// The same buffers, borrowed.
#[cfg(feature = "bare")]
pub(crate) fn bare_meshes(buffers: &[Buffers]) -> Vec<bare::Mesh<'_>> {
    buffers.iter().map(|(positions, triangles)| bare::Mesh { positions, triangles }).collect()
}

/// The numbers in the line that a Python program answers to the line `question`.
pub(crate) fn ask(program: &mut Python, question: &str) -> Outcome<Vec<f64>> {
    program.send(format!("{question}\n").as_bytes())?;
    Ok(program.line()?.split_whitespace().map(str::parse).collect::<Result<_, _>>()?)
}
