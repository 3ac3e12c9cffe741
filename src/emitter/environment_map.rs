//! Environments from pictures.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, IVec2, Mat3A, Vec3A};
use rayon::prelude::*;

use super::{Emitter, EmitterBounds, EmitterSample, LightOrigin, Sight};
use crate::math::{Discrete, Rgb, luminance, warp};
use crate::texture::Bitmap;

/// Radiance from every direction outside of the scene, given by a picture in longitude and latitude.
///
/// As in Mitsuba, seen from inside with +y up: the first row of pixels is the direction +y, the last −y; the
/// picture's middle is +z, its left and right edges meet at −z, and its columns follow each other from −x over
/// +z to +x. Between the centres of four pixels, which lie on the poles in latitude and half a pixel inside in
/// longitude, the radiance is bilinear in both angles. Channels below 0 count as 0.
///
/// Directions are drawn in proportion to the luminance, with the cosine of the angle from +y in place of the
/// angle itself: then the integral over the sphere and its inverse are closed forms, no pole
/// is special, and the density is 0 only where the radiance is.
#[derive(Debug)]
pub struct EnvironmentMap {
    picture: Bitmap,
    scale: f32,
    to_world: Mat3A,
    to_local: Mat3A,
    /// `None` if the picture is black.
    cells: Option<Cells>,
}

/// The choice among the cells between four pixel centres, by the integral of their luminance.
#[derive(Debug)]
struct Cells {
    rows: Discrete,
    /// Those of a row; `None` if it is black.
    columns: Vec<Option<Discrete>>,
}

/// A place between the centres of four pixels.
struct Place {
    /// Upper left, upper right, lower left, lower right.
    pixels: [Rgb; 4],
    /// The way from left to right, and from the upper to the lower row, in angles.
    across: DVec2,
    /// The way from the upper to the lower row in the cosine from +y.
    down: f64,
}

impl EnvironmentMap {
    /// The pixels of `picture` times `scale`, turned or mirrored by the orthonormal `to_world`. `None` if that
    /// makes more of a pixel than an f32 can hold.
    #[must_use]
    pub fn new(picture: Bitmap, scale: f32, to_world: Mat3A) -> Option<Self> {
        let mut map =
            Self { picture, scale, to_world, to_local: to_world.transpose(), cells: None };
        map.cells = map.cells();
        let fits = map.all_pixels().all(|pixel| (pixel * scale).is_finite());
        fits.then_some(map)
    }

    /// Whether a channel of a pixel is below 0.
    #[must_use]
    pub fn has_negative(&self) -> bool {
        self.all_pixels().any(|pixel| pixel.min_element() < 0.0)
    }

    fn all_pixels(&self) -> impl Iterator<Item = Rgb> {
        let (width, height) = (self.width(), self.picture.image().height() as i32);
        let places = (0..height).flat_map(move |y| (0..width).map(move |x| IVec2::new(x, y)));
        places.map(|at| self.picture.pixel(at))
    }

    /// Pixels in a row.
    fn width(&self) -> i32 {
        self.picture.image().width() as i32
    }

    /// Rows of cells: one, from pole to pole, for a picture of one row.
    fn rows(&self) -> i32 {
        (self.picture.image().height() as i32 - 1).max(1)
    }

    /// Angle between two rows of pixels.
    fn row_angle(&self) -> f64 {
        PI / f64::from(self.rows())
    }

    fn cells(&self) -> Option<Cells> {
        let angle = self.row_angle();
        let rows = (0..self.rows()).into_par_iter().map(|row| {
            // cos a − cos b, without the cancellation near the poles.
            let middle = (f64::from(row) + 0.5) * angle;
            let height = 2.0 * middle.sin() * (0.5 * angle).sin();
            let means = (0..self.width()).map(|column| {
                let corners = self.pixels(column, row).map(|p| f64::from(luminance(p)));
                corners.iter().sum::<f64>() / 4.0
            });
            let columns = Discrete::new(&means.collect::<Vec<_>>());
            (columns.as_ref().map_or(0.0, |c| c.total() * height), columns)
        });
        let (weights, columns): (Vec<_>, Vec<_>) = rows.unzip();
        Some(Cells { rows: Discrete::new(&weights)?, columns })
    }

    /// Those around a cell.
    fn pixels(&self, column: i32, row: i32) -> [Rgb; 4] {
        let last_row = self.picture.image().height() as i32 - 1;
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| {
            let at = IVec2::new((column + x) % self.width(), (row + y).min(last_row));
            self.picture.pixel(at).max(Rgb::ZERO)
        })
    }

    /// What is seen in a direction (world).
    fn place(&self, direction: Vec3A) -> Place {
        let d = (self.to_local * direction).as_dvec3();
        let angle = d.x.hypot(d.z).atan2(d.y);
        let row = ((angle / self.row_angle()).floor() as i32).min(self.rows() - 1);
        let upper = f64::from(row) * self.row_angle();
        let lower = f64::from(row + 1) * self.row_angle();
        let turn = d.x.atan2(-d.z) / TAU * f64::from(self.width()) - 0.5;
        let column = turn.floor();
        // (cos a − cos θ) / (cos a − cos b), again without cancellation.
        let down = ((upper + angle) / 2.0).sin() * ((angle - upper) / 2.0).sin()
            / (((upper + lower) / 2.0).sin() * ((lower - upper) / 2.0).sin());
        Place {
            pixels: self.pixels((column as i32).rem_euclid(self.width()), row),
            across: DVec2::new(turn - column, (angle - upper) / (lower - upper)),
            down: down.clamp(0.0, 1.0),
        }
    }

    /// Density of directions at a place, in sr⁻¹.
    fn pdf(&self, place: &Place) -> f64 {
        let Some(cells) = &self.cells else { return 0.0 };
        let [a, b, c, d] = place.pixels.map(|p| f64::from(luminance(p)));
        let x = place.across.x;
        let (upper, lower) = (a + (b - a) * x, c + (d - c) * x);
        let value = upper + (lower - upper) * place.down;
        // The rows' weights are per turn of one column.
        value / (cells.rows.total() * TAU / f64::from(self.width()))
    }

    fn radiance_at(&self, place: &Place) -> Rgb {
        let [a, b, c, d] = place.pixels;
        let (x, y) = (place.across.x as f32, place.across.y as f32);
        let (upper, lower) = (a * (1.0 - x) + b * x, c * (1.0 - x) + d * x);
        (upper * (1.0 - y) + lower * y) * self.scale
    }

    /// The direction (world) for `u`, of which both numbers serve a choice and what comes after it.
    fn direction(&self, cells: &Cells, u: DVec2) -> Option<Vec3A> {
        let row = cells.rows.sample(u.y);
        let column = cells.columns[row.index].as_ref()?.sample(u.x);
        let [a, b, c, d] =
            self.pixels(column.index as i32, row.index as i32).map(|p| f64::from(luminance(p)));
        let down = warp::interval_to_linear(row.rest, a + b, c + d);
        let across = warp::interval_to_linear(column.rest, a + (c - a) * down, b + (d - b) * down);
        let [upper, lower] = [0.0, 1.0].map(|i| (row.index as f64 + i) * self.row_angle());
        let cos = upper.cos() * (1.0 - down) + lower.cos() * down;
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let turn = (column.index as f64 + 0.5 + across) / f64::from(self.width());
        let (sin_turn, cos_turn) = (turn * TAU).sin_cos();
        Some(self.to_world * DVec3::new(sin * sin_turn, cos, -sin * cos_turn).as_vec3a())
    }
}

impl Emitter for EnvironmentMap {
    fn sample_toward(&self, _from: DVec3, u: DVec2) -> Option<EmitterSample> {
        let direction = self.direction(self.cells.as_ref()?, DVec2::new(u.x, longer(u)))?;
        // Of the direction as it was rounded, so that both densities of it are one.
        let place = self.place(direction);
        let pdf = self.pdf(&place) as f32;
        (pdf > 0.0).then(|| EmitterSample {
            direction,
            weight: self.radiance_at(&place) / pdf,
            pdf,
            origin: LightOrigin::Infinity,
        })
    }

    fn pdf_toward(&self, sight: &Sight<'_>) -> f32 {
        if sight.surface.is_some() {
            return 0.0;
        }
        self.pdf(&self.place(sight.direction)) as f32
    }

    fn radiance(&self, sight: &Sight<'_>) -> Rgb {
        if sight.surface.is_some() {
            return Rgb::ZERO;
        }
        self.radiance_at(&self.place(sight.direction))
    }

    fn parts(&self) -> Vec<EmitterBounds> {
        Vec::new()
    }

    fn power(&self) -> Option<f64> {
        (self.cells.is_none() || self.scale == 0.0).then_some(0.0)
    }
}

/// The second number with the last bits of the first behind its 24: among thousands of rows, one that is hardly
/// ever chosen is chosen as often as it should be.
fn longer(u: DVec2) -> f64 {
    const BITS: f64 = (1u32 << 24) as f64;
    ((u.y * BITS).floor() + (u.x * BITS).fract()) / BITS
}
