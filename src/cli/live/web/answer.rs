//! What a page gets: how far the render is, and the tiles that have changed.
//!
//! First comes the length of a JSON object as an unsigned number of 32 bits, which 4 divides, then the object, then for
//! each tile its column, row, width and height on the crop, likewise, and 32-bit floats, channel by channel. All are
//! little-endian.

use std::io::{self, Write};
use std::ops::Range;
use std::time::Duration;

use serde::Serialize;
use telamon::film::Crop;
use telamon::film::error::Estimate;
use telamon::property::Named;
use telamon::render::Ended;

use crate::cli::live::{Shared, Status};

/// An answer.
pub(super) struct Answer {
    head: Vec<u8>,
    tiles: Vec<u8>,
}

#[derive(Serialize)]
struct Head<'a> {
    /// To ask with the next time.
    version: u64,
    scene: &'a str,
    /// The crop, on the whole film.
    x: u32,
    y: u32,
    width: u32,
    height: u32,
    layers: Vec<Layer<'a>>,
    /// Which of them the tiles are of, and how many channels they have.
    layer: usize,
    channels: usize,
    /// Samples per pixel so far, and in the end as far as is known.
    samples: f64,
    samples_total: f64,
    seconds: f64,
    seconds_left: Option<f64>,
    errors: Vec<Error>,
    ended: Option<&'static str>,
}

#[derive(Serialize)]
struct Layer<'a> {
    name: &'a str,
    kind: &'static str,
}

#[derive(Serialize)]
struct Error {
    name: &'static str,
    /// Not known before the first look; JSON has no infinity.
    value: Option<f64>,
    bound: Option<f64>,
    /// At which the render ends.
    target: Option<f64>,
}

impl Answer {
    pub(super) fn new(shared: &Shared, since: u64, layer: usize, has_ended: bool) -> Self {
        let layers = layers(shared);
        let layer = if layer < layers.len() { layer } else { 0 };
        let Range { start, end } = layers[layer].1.clone();
        let crop = shared.preview.crop();
        let mut tiles = Vec::new();
        let version = shared.preview.changes(since, |area, values| {
            let Crop { x, y, width, height } = area;
            for number in [x - crop.x, y - crop.y, width, height] {
                tiles.extend_from_slice(&number.to_le_bytes());
            }
            let pixels = (width * height) as usize;
            let values = &values[start * pixels..end * pixels];
            tiles.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        });
        let status = shared.status().clone();
        let pixels = f64::from(crop.width) * f64::from(crop.height);
        let seconds = seconds(&status);
        let (done, total) = (status.samples_done as f64, status.samples_total as f64);
        // Where an error is to be reached, nobody knows before the first look at it.
        let is_known = done > 0.0 && (!shared.effort.needs_error() || status.errors.is_some());
        let left = (is_known && !has_ended).then(|| seconds * (total / done - 1.0).max(0.0));
        let head = Head {
            version,
            scene: &shared.scene,
            x: crop.x,
            y: crop.y,
            width: crop.width,
            height: crop.height,
            layers: layers.into_iter().map(|(layer, _)| layer).collect(),
            layer,
            channels: end - start,
            samples: done / pixels,
            samples_total: total / pixels,
            seconds,
            seconds_left: left,
            errors: errors(shared, &status),
            ended: status.ended.filter(|_| has_ended).map(|(why, _)| words(why)),
        };
        // Numbers, texts and lists of them: nothing that JSON has no form for.
        let mut json = serde_json::to_vec(&head).unwrap_or_default();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut head = (json.len() as u32).to_le_bytes().to_vec();
        head.append(&mut json);
        Self { head, tiles }
    }

    pub(super) fn len(&self) -> usize {
        self.head.len() + self.tiles.len()
    }

    pub(super) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        to.write_all(&self.head)?;
        to.write_all(&self.tiles)
    }
}

/// The picture, if there is one, and the layers beside it, each with its channels.
fn layers(shared: &Shared) -> Vec<(Layer<'_>, Range<usize>)> {
    let of_layers: usize = shared.layers.iter().map(|l| l.kind.components().len()).sum();
    let mut at = shared.preview.channels().len() - of_layers;
    let picture = (at > 0).then_some((Layer { name: "picture", kind: "picture" }, 0..at));
    let mut layers: Vec<_> = picture.into_iter().collect();
    for layer in &shared.layers {
        let begin = at;
        at += layer.kind.components().len();
        layers.push((Layer { name: &layer.name, kind: layer.kind.name() }, begin..at));
    }
    layers
}

fn seconds(status: &Status) -> f64 {
    let so_far = status.begun.map_or(Duration::ZERO, |begun| begun.elapsed());
    status.ended.map_or(so_far, |(_, after)| after).as_secs_f64()
}

fn errors(shared: &Shared, status: &Status) -> Vec<Error> {
    let effort = shared.effort;
    if !effort.needs_error() && status.errors.is_none() {
        return Vec::new();
    }
    let error = |name, estimate: Option<Estimate>, target| Error {
        name,
        value: estimate.map(|e| e.value).filter(|v| v.is_finite()),
        bound: estimate.map(|e| e.bound).filter(|v| v.is_finite()),
        target,
    };
    vec![
        error("relMSE", status.errors.map(|e| e.rel_mse), effort.error),
        error("noise level", status.errors.map(|e| e.noise_level), effort.noise_level),
    ]
}

/// Why a render has ended.
fn words(why: Option<Ended>) -> &'static str {
    match why {
        Some(Ended::Samples) => "all samples taken",
        Some(Ended::Error) => "good enough",
        Some(Ended::Time) => "time is over",
        Some(Ended::Cancelled) => "interrupted",
        None => "failed",
    }
}
