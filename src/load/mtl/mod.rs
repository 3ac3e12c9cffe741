//! Wavefront's `.mtl`: the materials of OBJ files.
//!
//! `material` says what becomes of them. What is read here is what the format's description of 1995 (Wavefront, Advanced
//! Visualizer, appendix B5) and, for `norm`, today's programs say.

mod map;
mod material;

#[cfg(test)]
mod tests;

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;

pub(super) use map::Map;
pub(super) use material::{Plastics, Surface, surface};

use crate::memory::Limits;

/// The materials of a file.
#[derive(Debug, Default)]
pub(super) struct Library {
    pub(super) path: PathBuf,
    pub(super) materials: Vec<Mtl>,
    /// Statements that are read and have no effect, each once.
    pub(super) unused: Vec<String>,
}

/// A material, as far as the file describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mtl {
    pub(super) name: String,
    /// `Kd`: what is reflected in all directions.
    pub(super) diffuse: Option<DVec3>,
    /// `Ks`: what is reflected around the mirror's direction.
    pub(super) specular: Option<DVec3>,
    /// `Ke`: what it emits.
    pub(super) emission: Option<DVec3>,
    /// `Tf`: what glass lets through.
    pub(super) transmission: Option<DVec3>,
    /// `Ns`: how narrow the highlights are.
    pub(super) exponent: Option<f64>,
    /// `Ni`: the index of refraction.
    pub(super) index: Option<f64>,
    /// `d`, or 1 - `Tr`.
    pub(super) opacity: Option<f64>,
    /// `illum`: which of the format's ways to compute light is meant.
    pub(super) illumination: Option<u32>,
    pub(super) diffuse_map: Option<Map>,
    pub(super) opacity_map: Option<Map>,
    pub(super) bump_map: Option<Map>,
    pub(super) normal_map: Option<Map>,
}

/// A file of materials is text that people read.
const LARGEST_FILE: u64 = 64 << 20;

/// Materials, and different statements without effect, of one file.
const MOST: usize = 100_000;
const MOST_UNUSED: usize = 12;

impl Library {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// What is wrong, with the file and the line.
    pub(super) fn read(path: &Path, limits: &Limits) -> Result<Self, String> {
        let shown = path.display();
        let unreadable = |error| format!("{shown}: cannot be read: {error}");
        let size = fs::metadata(path).map_err(unreadable)?.len();
        if size > LARGEST_FILE {
            return Err(format!(
                "{shown}: {size} bytes of materials (expected at most {LARGEST_FILE})"
            ));
        }
        limits.claim(2 * size).map_err(|error| format!("{shown}: {error}"))?;
        let bytes = fs::read(path).map_err(unreadable)?;
        let mut library = Self::parse(&String::from_utf8_lossy(&bytes))
            .map_err(|(line, problem)| format!("{shown}:{line}: {problem}"))?;
        library.path = path.to_owned();
        Ok(library)
    }

    /// # Errors
    /// A line, from 1, and what is wrong in it.
    fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut library = Self::default();
        let mut unused = HashSet::new();
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default().trim();
            let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            if keyword.is_empty() {
                continue;
            }
            let effect = library.statement(keyword, rest.trim()).map_err(|p| (number, p))?;
            let news =
                effect.is_some_and(|what| unused.len() < MOST && unused.insert(what.clone()));
            if news && library.unused.len() < MOST_UNUSED {
                library.unused.push(shortened(keyword));
            }
        }
        library.unused.sort_unstable();
        library.unused.dedup();
        Ok(library)
    }

    /// Reads a statement; gives it back if it has no effect.
    fn statement(&mut self, keyword: &str, rest: &str) -> Result<Option<String>, String> {
        let lower = keyword.to_ascii_lowercase();
        if lower == "newmtl" {
            if rest.is_empty() {
                return Err("`newmtl` needs a name".to_owned());
            }
            if self.materials.len() == MOST {
                return Err(format!("more than {MOST} materials"));
            }
            self.materials.push(Mtl { name: rest.to_owned(), ..Mtl::default() });
            return Ok(None);
        }
        let Some(material) = self.materials.last_mut() else {
            return Err(format!("`{}` before the first `newmtl`", shortened(keyword)));
        };
        // Colours by a spectrum, or in CIE XYZ.
        let first = rest.split_whitespace().next().unwrap_or_default();
        let elsewhere = matches!(first, "spectral" | "xyz");
        match lower.as_str() {
            "kd" | "ks" | "ke" | "tf" if elsewhere => return Ok(Some(keyword.to_owned())),
            "kd" => material.diffuse = Some(color(keyword, rest)?),
            "ks" => material.specular = Some(color(keyword, rest)?),
            "ke" => material.emission = Some(color(keyword, rest)?),
            "tf" => material.transmission = Some(color(keyword, rest)?),
            "ns" => material.exponent = Some(number(keyword, rest)?.max(0.0)),
            "ni" => material.index = Some(number(keyword, rest)?),
            "d" => {
                let (halo, value) = match rest.strip_prefix("-halo") {
                    Some(value) => (true, value),
                    None => (false, rest),
                };
                material.opacity = Some(number(keyword, value)?.clamp(0.0, 1.0));
                return Ok(halo.then(|| "d -halo".to_owned()));
            }
            "tr" => {
                let opacity = 1.0 - number(keyword, rest)?.clamp(0.0, 1.0);
                material.opacity.get_or_insert(opacity);
            }
            "illum" => {
                material.illumination = Some(number(keyword, rest)?.clamp(0.0, 1e6) as u32);
            }
            "map_kd" => material.diffuse_map = Map::parse(rest)?,
            "map_d" => material.opacity_map = Map::parse(rest)?,
            "bump" | "map_bump" => material.bump_map = Map::parse(rest)?,
            "norm" => material.normal_map = Map::parse(rest)?,
            // Light from nowhere: that of the scene takes its place.
            "ka" => {}
            _ => return Ok(Some(keyword.to_owned())),
        }
        Ok(None)
    }
}

/// One number for all channels, or three.
fn color(keyword: &str, text: &str) -> Result<DVec3, String> {
    let values = text.split_whitespace().map(|word| parse(keyword, word));
    match values.collect::<Result<Vec<f64>, _>>()?.as_slice() {
        &[grey] => Ok(DVec3::splat(grey)),
        &[r, g, b] => Ok(DVec3::new(r, g, b)),
        other => Err(format!("`{keyword}` takes 3 numbers, but the line has {}", other.len())),
    }
}

fn number(keyword: &str, text: &str) -> Result<f64, String> {
    let mut words = text.split_whitespace();
    match (words.next(), words.next()) {
        (Some(word), None) => parse(keyword, word),
        (found, _) => {
            let count = if found.is_none() { 0 } else { text.split_whitespace().count() };
            Err(format!("`{keyword}` takes 1 number, but the line has {count}"))
        }
    }
}

fn parse(keyword: &str, word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.abs() <= f64::from(f32::MAX) => Ok(value),
        _ => Err(format!("`{keyword}`: expected a number, found `{}`", shortened(word))),
    }
}

/// For messages.
fn shortened(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", text[..end].escape_debug()),
        None => text.escape_debug().to_string(),
    }
}
