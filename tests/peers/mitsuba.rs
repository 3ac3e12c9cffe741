//! The same scene file in Telamon and in Mitsuba 3, several times with unrelated random numbers.

use std::collections::BTreeMap;
use std::path::Path;

use telamon::film::picture::{Picture, Values};
use telamon::intersect::Backend;

use crate::support::pictures::{picture, read};
use crate::support::python::{self, Python};

/// Renders of one scene that differ in their seeds only.
#[derive(Clone, Debug)]
pub(crate) struct Renders {
    /// Pixels in a row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// In each render.
    pub(crate) samples_per_pixel: u32,
    /// For each channel, by name, the pixels of each render.
    pub(crate) channels: BTreeMap<String, Vec<Vec<f32>>>,
}

impl Renders {
    /// Ours of `scene`, with the parameters that its line `<!-- telamon: NAME=VALUE ... -->` gives to us
    /// alone, and with `defines`. Channels of whole numbers are left out: they are no means.
    pub(crate) fn ours(scene: &Path, defines: &[(&str, &str)], runs: u32) -> Self {
        let text = std::fs::read_to_string(scene).expect("readable");
        let line = text.split_once("<!-- telamon:").and_then(|(_, rest)| rest.split_once("-->"));
        let own = line.map_or("", |(line, _)| line).split_whitespace();
        let own = own.map(|word| word.split_once('=').expect("NAME=VALUE"));
        let defines: Vec<_> = own.chain(defines.iter().copied()).collect();
        let mut description = read(scene, &defines);
        let mut renders = Self {
            width: description.film.crop.width as usize,
            height: description.film.crop.height as usize,
            samples_per_pixel: description.sampler.samples_per_pixel,
            channels: BTreeMap::new(),
        };
        for run in 0..runs {
            description.sampler.seed = u64::from(run);
            let picture = Picture::from_film(&picture(&description, Backend::default()));
            for channel in picture.channels {
                let (Values::Color(values) | Values::Float(values)) = channel.values else {
                    continue;
                };
                renders.channels.entry(channel.name).or_default().push(values);
            }
        }
        renders
    }
}

/// Mitsuba's threads: a number of ours, because the random numbers of its pictures depend on it.
const THREADS: u32 = 2;

/// A Mitsuba that renders one scene after the other.
#[derive(Debug)]
pub(crate) struct Mitsuba(Python);

impl Mitsuba {
    /// Starts it.
    pub(crate) fn start() -> Self {
        let interpreter = python::peers().unwrap_or_else(|message| panic!("{message}"));
        let script = include_str!("render_scenes.py");
        Self(Python::start(&interpreter, script, &[THREADS.to_string()]).expect("starts"))
    }

    /// Its renders of `scene`.
    ///
    /// # Errors
    /// What Mitsuba does not like about the scene.
    pub(crate) fn renders(&mut self, scene: &Path, runs: u32) -> Result<Renders, String> {
        let question = format!("{runs} {}\n", scene.display());
        self.0.send(question.as_bytes()).expect("listens");
        let header = self.0.line().expect("answers");
        let words: Vec<_> = header.split(' ').collect();
        let ["ok", width, height, samples, names @ ..] = words.as_slice() else {
            return Err(format!("Mitsuba: {header}"));
        };
        let [width, height, samples] =
            [width, height, samples].map(|n| n.parse::<u32>().expect("a number"));
        let (width, height) = (width as usize, height as usize);
        let mut channels: BTreeMap<String, Vec<Vec<f32>>> = BTreeMap::new();
        for _ in 0..runs {
            let bytes = self.0.bytes(width * height * names.len() * 4).expect("a picture");
            let numbers: Vec<_> = bytes
                .chunks_exact(4)
                .map(|b| f32::from_le_bytes(b.try_into().expect("four bytes")))
                .collect();
            for (channel, &name) in names.iter().enumerate() {
                let values = numbers.iter().skip(channel).step_by(names.len());
                channels.entry(name.to_owned()).or_default().push(values.copied().collect());
            }
        }
        Ok(Renders { width, height, samples_per_pixel: samples, channels })
    }
}
