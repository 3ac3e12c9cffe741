//! Disagreements as a file of JSON lines, and the rays of such a file to be fired again.
//!
//! Each line is an object: `index`, `family`, `origin`, `direction`, `t_min`, `t_max` and `time` are the ray,
//! `truth` what it first crosses, and `answers` what engines said of it. Numbers that must survive to the
//! last bit are hexadecimal floats as C's `%a` writes them, `"0x1.99999ap-4"`: C's `strtof` and Python's
//! `float.fromhex` read them. A ray to be fired again needs `origin` and `direction` only, and its numbers
//! may be decimal: they are rounded to the nearest f32. Without a `family` it counts as random; without an end
//! it is a half-line.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use glam::Vec3A;
use serde::{Deserialize, Serialize};

use super::hex_float::HexFloat;
use super::oracle::Encounter;
use super::{Answer, Contender, Disagreement, Family, Judged, RaySource};
use crate::film::output::{AtomicFile, OutputError};
use crate::ray::{Hit, Ray};

/// A ray as a line of a file, with what was found out about it.
#[derive(Debug, Serialize, Deserialize)]
#[serde(expecting = "a ray")]
struct Line {
    #[serde(default)]
    index: u64,
    #[serde(default)]
    family: Family,
    origin: [HexFloat; 3],
    direction: [HexFloat; 3],
    t_min: Option<HexFloat>,
    t_max: Option<HexFloat>,
    time: Option<HexFloat>,
    #[serde(skip_deserializing)]
    truth: Option<Crossed>,
    #[serde(skip_deserializing)]
    answers: Vec<Said>,
}

/// The first primitive that a ray crosses.
#[derive(Debug, Default, Serialize)]
struct Crossed {
    t: f64,
    shape: u32,
    member: u32,
    primitive: u32,
}

/// What an engine said.
#[derive(Debug, Default, Serialize)]
struct Said {
    engine: String,
    query: &'static str,
    class: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    occluded: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hit: Option<Option<SaidHit>>,
}

/// A hit that an engine reported.
#[derive(Debug, Serialize)]
struct SaidHit {
    t: HexFloat,
    u: HexFloat,
    v: HexFloat,
    shape: u32,
    member: u32,
    primitive: u32,
}

/// Writes disagreements, one after the other.
#[derive(Debug)]
pub struct RecordWriter {
    file: AtomicFile,
    engines: Vec<String>,
}

impl RecordWriter {
    /// A file at `path` for a run of these contenders. It appears when it is finished.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn create(path: &Path, contenders: &[Contender<'_>]) -> Result<Self, OutputError> {
        let engines = contenders.iter().map(|c| c.name.clone()).collect();
        Ok(Self { file: AtomicFile::create(path)?, engines })
    }

    /// Appends a line.
    ///
    /// # Errors
    /// What the operating system refuses, such as a full disk.
    pub fn write(&mut self, disagreement: &Disagreement) -> Result<(), OutputError> {
        let Disagreement { index, family, ray, crossed, answers } = disagreement;
        let line = Line {
            index: *index,
            family: *family,
            origin: ray.origin.to_array().map(HexFloat),
            direction: ray.direction.to_array().map(HexFloat),
            t_min: Some(HexFloat(ray.t_min)),
            t_max: Some(HexFloat(ray.t_max)),
            time: Some(HexFloat(ray.time)),
            truth: crossed.and_then(|e| {
                let Encounter { shape, member, primitive, .. } = e;
                Some(Crossed { t: e.crossing?, shape, member, primitive })
            }),
            answers: answers.iter().map(|a| self.said(a)).collect(),
        };
        let text = serde_json::to_string(&line).map_err(|e| self.file.error(e.into()))?;
        writeln!(self.file, "{text}").map_err(|e| self.file.error(e))
    }

    fn said(&self, judged: &Judged) -> Said {
        let (occluded, hit) = match judged.answer {
            Answer::Occluded(occluded) => (Some(occluded), None),
            Answer::Closest(hit) => (None, Some(hit.map(SaidHit::from))),
        };
        Said {
            engine: self.engines[judged.contender].clone(),
            query: judged.query.name(),
            class: judged.class.name(),
            occluded,
            hit,
        }
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn finish(self) -> Result<(), OutputError> {
        self.file.finish()
    }
}

impl From<Hit> for SaidHit {
    fn from(hit: Hit) -> Self {
        let [t, u, v] = [hit.t, hit.u, hit.v].map(HexFloat);
        Self { t, u, v, shape: hit.shape, member: hit.member, primitive: hit.primitive }
    }
}

/// Rays of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded(Vec<(Family, Ray)>);

/// Why a file of rays cannot be fired.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The operating system refuses.
    #[error("cannot read `{path}`: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        error: io::Error,
    },
    /// A line is no ray.
    #[error("`{path}`, line {line}, column {column}: {reason}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// How many bytes of it are well-formed.
        column: usize,
        /// What is wrong.
        reason: String,
    },
}

impl Recorded {
    /// The rays of a file that a [`RecordWriter`] wrote, or of its form. Empty lines are skipped.
    ///
    /// # Errors
    /// A file that cannot be read, a line that is no ray.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let io = |error| RecordError::Io { path: path.to_owned(), error };
        let mut rays = Vec::new();
        for (text, line) in BufReader::new(File::open(path).map_err(io)?).lines().zip(1..) {
            let text = text.map_err(io)?;
            if text.trim().is_empty() {
                continue;
            }
            let read: Line = serde_json::from_str(&text).map_err(|error| {
                let (text, column) = (error.to_string(), error.column());
                // Serde counts lines as well, but has seen only one.
                let reason = text.split(" at line ").next().unwrap_or(&text).to_owned();
                RecordError::Malformed { path: path.to_owned(), line, column, reason }
            })?;
            rays.push((read.family, read.ray()));
        }
        Ok(Self(rays))
    }
}

impl RaySource for Recorded {
    fn count(&self) -> u64 {
        self.0.len() as u64
    }

    fn ray(&self, index: u64) -> (Family, Ray) {
        self.0[index as usize]
    }
}

impl Line {
    fn ray(&self) -> Ray {
        let vector = |v: &[HexFloat; 3]| Vec3A::from_array([v[0].0, v[1].0, v[2].0]);
        let half_line = Ray::new(vector(&self.origin), vector(&self.direction));
        Ray {
            t_min: self.t_min.map_or(half_line.t_min, |t| t.0),
            t_max: self.t_max.map_or(half_line.t_max, |t| t.0),
            time: self.time.map_or(half_line.time, |t| t.0),
            ..half_line
        }
    }
}
