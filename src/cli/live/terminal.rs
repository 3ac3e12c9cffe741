//! The picture in the terminal itself: by kitty's graphics protocol (<https://sw.kovidgoyal.net/kitty/graphics-protocol/>)
//! where the terminal says that it has it, else two pixels a character, as half blocks in 24-bit colours.

use std::env;
use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::Instant;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rustix::termios::tcgetwinsize;
use telamon::film::Crop;
use telamon::film::png::encode_pixel;
use telamon::render::Preview;

use super::{Pace, Shared};

/// Characters across, at most.
const WIDEST: u32 = 80;
/// Lines that stay free below, for the progress bar and what was typed.
const FREE: u32 = 3;
/// Bytes of text that kitty takes at once.
const CHUNK: usize = 4096;

/// A terminal behind standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Terminal {
    protocol: Protocol,
    /// Characters across and up.
    size: [u32; 2],
    /// Pixels of a character.
    cell: [u32; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Protocol {
    Kitty,
    HalfBlocks,
}

impl Terminal {
    pub(super) fn open() -> Result<Self, &'static str> {
        let terminal = io::stderr();
        if !terminal.is_terminal() {
            return Err("`--live terminal` needs a terminal, and standard error is none");
        }
        let variable = |name: &str| env::var(name).unwrap_or_default();
        let Some(protocol) = protocol(&variable("TERM"), &variable("TERM_PROGRAM")) else {
            return Err("`--live terminal` needs a terminal with colours, and TERM says `dumb`");
        };
        // One that does not say its size has that of the oldest.
        let told = tcgetwinsize(&terminal).ok().filter(|told| told.ws_col > 0 && told.ws_row > 0);
        let size = told.map_or([80, 24], |told| [told.ws_col.into(), told.ws_row.into()]);
        let pixels = told.map_or([0; 2], |told| [told.ws_xpixel.into(), told.ws_ypixel.into()]);
        let cell = if pixels.contains(&0) {
            [8, 16]
        } else {
            [0, 1].map(|axis: usize| (pixels[axis] / size[axis]).clamp(1, 64))
        };
        Ok(Self { protocol, size, cell })
    }

    /// Characters that a picture of `[width, height]` pixels takes.
    fn fit(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let [across, up] = self.size;
        // Half blocks are square, whatever the terminal says of its font.
        let [x, y] = if self.protocol == Protocol::Kitty { self.cell } else { [1, 2] };
        let shape = f64::from(height) * f64::from(x) / (f64::from(width) * f64::from(y));
        let highest = up.saturating_sub(FREE).max(1);
        let columns = across.min(WIDEST).min(width.max(2));
        let rows = (f64::from(columns) * shape).ceil().max(1.0);
        if rows <= f64::from(highest) {
            return [columns, rows as u32];
        }
        let columns = (f64::from(highest) / shape).floor().clamp(1.0, f64::from(columns));
        [columns as u32, highest]
    }

    /// What draws the canvas, from the beginning of a line and back to one below.
    fn draw(&self, canvas: &Canvas, id: u32) -> String {
        let [columns, rows] = self.fit([canvas.width, canvas.height]);
        match self.protocol {
            Protocol::HalfBlocks => half_blocks(&canvas.scaled(columns, 2 * rows), columns),
            Protocol::Kitty => {
                let [x, y] = self.cell;
                let (width, height) =
                    ((columns * x).min(canvas.width), (rows * y).min(canvas.height));
                let rgb = canvas.scaled(width, height);
                // Space for it first, as the screen may have to scroll.
                let lines = "\n".repeat(rows as usize);
                let image = kitty(&rgb, [width, height], [columns, rows], id);
                format!("{lines}\x1b[{rows}A{image}\x1b[{rows}B")
            }
        }
    }
}

/// What is known of terminals by their names; `None` of one that shows letters alone. Within `tmux` and `screen`, which
/// change `TERM`, pictures do not come through.
fn protocol(term: &str, program: &str) -> Option<Protocol> {
    match (term, program) {
        ("dumb", _) => None,
        (term, _) if term.starts_with("screen") || term.starts_with("tmux") => {
            Some(Protocol::HalfBlocks)
        }
        ("xterm-kitty" | "xterm-ghostty", _) | (_, "WezTerm" | "ghostty") => Some(Protocol::Kitty),
        _ => Some(Protocol::HalfBlocks),
    }
}

/// Shows a render to its end. `aside` runs what writes to the terminal while nothing else does.
pub(super) fn show(shared: &Shared, terminal: &Terminal, aside: &dyn Fn(&dyn Fn())) {
    let mut canvas = Canvas::new(shared.preview.crop());
    let mut pace = Pace::new();
    let mut since = 0;
    // What had been said when it was drawn: below that the picture is drawn anew.
    let mut drawn = None;
    let id = std::process::id().max(1);
    loop {
        // Before the look at the picture: what it has then is all of it.
        let has_ended = shared.wait(pace.left());
        let begin = Instant::now();
        let version = canvas.take(&shared.preview, since);
        if version > since {
            let said = std::cell::Cell::new(0);
            let image = terminal.draw(&canvas, id);
            let [_, rows] = terminal.fit([canvas.width, canvas.height]);
            aside(&|| {
                let lines = shared.said.lock().unwrap_or_else(PoisonError::into_inner);
                said.set(*lines);
                let up =
                    if drawn == Some(*lines) { format!("\x1b[{rows}A") } else { String::new() };
                let mut out = io::stderr().lock();
                // If nobody can see it, nobody misses it.
                let _ = out.write_all(format!("\r{up}{image}").as_bytes());
                let _ = out.flush();
            });
            drawn = Some(said.get());
            since = version;
        }
        shared.drawn.store(version, Ordering::Release);
        pace.worked(begin, begin.elapsed());
        if has_ended {
            return;
        }
    }
}

/// A picture that tiles are put into.
struct Canvas {
    crop: Crop,
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Canvas {
    fn new(crop: Crop) -> Self {
        let Crop { width, height, .. } = crop;
        let pixels = vec![[0.0; 3]; width as usize * height as usize];
        Self { crop, width, height, pixels }
    }

    /// Takes over what has changed; the version that it then has.
    fn take(&mut self, preview: &Preview, since: u64) -> u64 {
        let (crop, width) = (self.crop, self.width as usize);
        preview.changes(since, |area, values| {
            let (columns, count) = (area.width as usize, (area.width * area.height) as usize);
            let corner = (area.y - crop.y) as usize * width + (area.x - crop.x) as usize;
            for pixel in 0..count {
                let at = corner + pixel / columns * width + pixel % columns;
                self.pixels[at] = [0, 1, 2].map(|channel| values[channel * count + pixel]);
            }
        })
    }

    /// In so many pixels, each the mean of those that it stands for, as sRGB.
    fn scaled(&self, width: u32, height: u32) -> Vec<[u8; 3]> {
        let range = |i: u32, of: u32, from: u32| {
            let at = |i: u32| (u64::from(i) * u64::from(from) / u64::from(of)) as u32;
            at(i)..at(i + 1).max(at(i) + 1)
        };
        let mean = |x: u32, y: u32| {
            let (mut sum, mut count) = ([0.0_f64; 3], 0.0);
            for row in range(y, height, self.height) {
                for column in range(x, width, self.width) {
                    let pixel = self.pixels[row as usize * self.width as usize + column as usize];
                    sum = [0, 1, 2].map(|c| sum[c] + f64::from(pixel[c]));
                    count += 1.0;
                }
            }
            encode_pixel(sum.map(|sum| (sum / count) as f32), 1.0, 1.0)
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect()
    }
}

/// Rows of pixels, two to a line.
fn half_blocks(pixels: &[[u8; 3]], columns: u32) -> String {
    let mut text = String::new();
    for rows in pixels.chunks_exact(2 * columns as usize) {
        let (upper, lower) = rows.split_at(columns as usize);
        for ([r, g, b], [s, h, c]) in upper.iter().zip(lower) {
            let _ = write!(text, "\x1b[38;2;{r};{g};{b};48;2;{s};{h};{c}m▀");
        }
        text.push_str("\x1b[0m\x1b[K\n");
    }
    text
}

/// An image in the place of the one that `id` named before, over so many characters; the cursor stays.
fn kitty(pixels: &[[u8; 3]], [w, h]: [u32; 2], [columns, rows]: [u32; 2], id: u32) -> String {
    let data = STANDARD.encode(pixels.as_flattened());
    let mut text = String::new();
    let mut keys = format!("a=T,f=24,s={w},v={h},c={columns},r={rows},i={id},p=1,q=2,C=1,");
    let mut rest = data.as_str();
    loop {
        let (chunk, after) = rest.split_at(rest.len().min(CHUNK));
        let more = u8::from(!after.is_empty());
        let _ = write!(text, "\x1b_G{keys}m={more};{chunk}\x1b\\");
        if after.is_empty() {
            return text;
        }
        keys.clear();
        rest = after;
    }
}

#[cfg(test)]
mod tests;
