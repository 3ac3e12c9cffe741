//! What the film is told.

use super::Filter;

/// The picture that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSettings {
    /// Width of the whole film in pixels.
    pub width: u32,
    /// Height of the whole film in pixels.
    pub height: u32,
    /// The part of the film that is rendered.
    pub crop: Crop,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Whether the picture has an alpha channel: the fraction of camera rays that hit something.
    pub alpha: bool,
    /// Precision of colours in an EXR file.
    pub component: ComponentFormat,
    /// Whether layers say how much the samples of each pixel vary, and how many there are. Scene files
    /// have no property for it.
    pub variance: bool,
    /// Samples whose largest component exceeds this, above 0, are scaled down to it: less noise, and a
    /// picture that is too dark. None are unless asked for; scene files have no property for it.
    pub clamp: Option<f32>,
}

/// A rectangle of pixels of the whole film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// First column.
    pub x: u32,
    /// First row, from the top.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// How a number is stored in an EXR file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComponentFormat {
    /// 16 bits.
    Half,
    /// 32 bits.
    Float,
}
