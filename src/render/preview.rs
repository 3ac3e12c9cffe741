//! The picture so far, for who watches a render.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use super::{Description, content};
use crate::film::{Content, Crop, TILE, Tile};

/// What a film holds so far, as means that can be read while it grows.
///
/// The threads of a render write into it, and any number of readers, each at its own pace, copy what has
/// changed since they looked last. There is no queue: a reader that is late gets the newest values, and no
/// reader keeps a render waiting for longer than it takes to copy one tile.
///
/// ```
/// use std::sync::atomic::AtomicBool;
///
/// use telamon::intersect::{self, Backend};
/// use telamon::render::{Description, Preview, render};
///
/// fn watch(description: &Description) -> Result<(), Box<dyn std::error::Error>> {
///     let engine = intersect::build(Backend::Rust, &description.scene.shapes())?;
///     let preview = Preview::new(description);
///     let done = AtomicBool::new(false);
///     std::thread::scope(|scope| {
///         scope.spawn(|| {
///             let mut version = 0;
///             while !done.load(std::sync::atomic::Ordering::Relaxed) {
///                 version = preview.changes(version, |area, values| {
///                     // Show `values` in `area`.
///                 });
///                 std::thread::sleep(std::time::Duration::from_millis(250));
///             }
///         });
///         let never = AtomicBool::new(false);
///         render(description, engine.as_ref(), &|now| preview.update(now.tile), &never);
///         done.store(true, std::sync::atomic::Ordering::Relaxed);
///     });
///     Ok(())
/// }
/// ```
#[derive(Debug)]
pub struct Preview {
    crop: Crop,
    content: Content,
    channels: Vec<String>,
    has_alpha: bool,
    tiles: Vec<Mutex<Seen>>,
    /// How many times a tile was updated.
    version: AtomicU64,
}

/// A tile as it was seen last.
#[derive(Debug, Default)]
struct Seen {
    /// [`Preview::version`] then; 0 before.
    version: u64,
    values: Vec<f32>,
}

impl Preview {
    /// Of a render of `description` that has not begun.
    #[must_use]
    pub fn new(description: &Description) -> Self {
        let content = content(description);
        let (crop, has_alpha) = (description.film.crop, description.film.alpha);
        let picture = if content.picture { "RGB" } else { "" }.chars();
        let alpha = (content.picture && has_alpha).then_some('A');
        let layers = content.layers.iter().flat_map(|layer| {
            layer.kind.components().iter().map(|component| format!("{}.{component}", layer.name))
        });
        let channels = picture.chain(alpha).map(String::from).chain(layers).collect();
        let tiles = crop.width.div_ceil(TILE) as usize * crop.height.div_ceil(TILE) as usize;
        let tiles = std::iter::repeat_with(Mutex::default).take(tiles).collect();
        Self { crop, content, channels, has_alpha, tiles, version: AtomicU64::new(0) }
    }

    /// Bytes that the preview of a render of `description` takes once it has all tiles.
    #[must_use]
    pub fn bytes(description: &Description) -> u64 {
        let Self { crop, channels, .. } = Self::new(description);
        let pixels = u64::from(crop.width) * u64::from(crop.height);
        pixels.saturating_mul((channels.len() * size_of::<f32>()) as u64)
    }

    /// Names of the channels, in their order: R, G and B, A if the film has it, then `layer.component` of each
    /// layer. It is how [`Picture`](crate::film::picture::Picture) names them.
    #[must_use]
    pub fn channels(&self) -> &[String] {
        &self.channels
    }

    /// The part of the film that is rendered.
    #[must_use]
    pub fn crop(&self) -> Crop {
        self.crop
    }

    /// A number that grows with each update; 0 before the first one.
    #[must_use]
    pub fn version(&self) -> u64 {
        self.version.load(Ordering::Acquire)
    }

    /// Takes over what `tile` holds, which must be one of the film that the preview is of. Pixels without a
    /// sample look like the nearest one of the tile that has some, and are 0 if none has.
    pub fn update(&self, tile: &Tile) {
        let Crop { x, y, .. } = tile.area();
        let (column, row) = ((x - self.crop.x) / TILE, (y - self.crop.y) / TILE);
        let index = row * self.crop.width.div_ceil(TILE) + column;
        let mut seen = self.tiles[index as usize].lock().unwrap_or_else(PoisonError::into_inner);
        // Not before the lock, nor after the values: who reads this version gets them.
        seen.version = self.version.fetch_add(1, Ordering::AcqRel) + 1;
        self.read(tile, &mut seen.values);
    }

    /// Calls `visit` with each tile that has changed since the version `since`, row by row: with its area on
    /// the whole film, and its values channel by channel, those of a channel row by row. Since version 0 all
    /// tiles have changed that have any sample. Returns the version to ask with the next time.
    ///
    /// Colours are linear and multiplied by alpha; indices are rounded to the nearest f32.
    pub fn changes(&self, since: u64, mut visit: impl FnMut(Crop, &[f32])) -> u64 {
        let version = self.version();
        let mut values = Vec::new();
        let columns = self.crop.width.div_ceil(TILE) as usize;
        for (index, tile) in self.tiles.iter().enumerate() {
            {
                let seen = tile.lock().unwrap_or_else(PoisonError::into_inner);
                if seen.version <= since {
                    continue;
                }
                values.clone_from(&seen.values);
            }
            let x = (index % columns) as u32 * TILE;
            let y = (index / columns) as u32 * TILE;
            let area = Crop {
                x: self.crop.x + x,
                y: self.crop.y + y,
                width: TILE.min(self.crop.width - x),
                height: TILE.min(self.crop.height - y),
            };
            visit(area, &values);
        }
        version
    }

    /// Replaces `values` by those of a tile, channel by channel.
    fn read(&self, tile: &Tile, values: &mut Vec<f32>) {
        let area = tile.area();
        let pixels = (area.width * area.height) as usize;
        values.clear();
        values.resize(self.channels.len() * pixels, 0.0);
        let mut channels = values.chunks_exact_mut(pixels);
        if self.content.picture {
            let [red, green, blue] = [0; 3].map(|_| channels.next().expect("as many as are named"));
            for pixel in 0..pixels {
                let rgb = tile.radiance(pixel).as_vec3();
                (red[pixel], green[pixel], blue[pixel]) = (rgb.x, rgb.y, rgb.z);
            }
        }
        let mut fill = |value: &dyn Fn(usize) -> f32| {
            let channel = channels.next().expect("as many as are named");
            channel.iter_mut().enumerate().for_each(|(pixel, slot)| *slot = value(pixel));
        };
        if self.content.picture && self.has_alpha {
            fill(&|pixel| tile.alpha(pixel) as f32);
        }
        // The film counts averaged components and indices apart.
        let (mut numbers, mut indices) = (0.., 0..);
        for layer in &self.content.layers {
            for _ in layer.kind.components() {
                if layer.kind.is_index() {
                    indices.next().into_iter().for_each(|i| fill(&|p| tile.index(p, i) as f32));
                } else {
                    numbers.next().into_iter().for_each(|i| fill(&|p| tile.number(p, i) as f32));
                }
            }
        }
        if (0..pixels).any(|pixel| tile.samples(pixel) == 0) {
            let like = nearest(tile);
            for channel in values.chunks_exact_mut(pixels) {
                let known = channel.to_vec();
                channel.iter_mut().zip(&like).for_each(|(slot, &pixel)| *slot = known[pixel]);
            }
        }
    }
}

/// For each pixel of a tile the nearest one that has samples; itself, if none has.
fn nearest(tile: &Tile) -> Vec<usize> {
    let known: Vec<_> =
        tile.pixels().enumerate().filter(|&(pixel, _)| tile.samples(pixel) > 0).collect();
    let like = |(pixel, (x, y)): (usize, (u32, u32))| {
        let distance =
            |&&(_, (u, v)): &&(usize, (u32, u32))| x.abs_diff(u).pow(2) + y.abs_diff(v).pow(2);
        known.iter().min_by_key(distance).map_or(pixel, |&(nearest, _)| nearest)
    };
    tile.pixels().enumerate().map(like).collect()
}
