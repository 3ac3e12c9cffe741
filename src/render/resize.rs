//! The same scene on a film of another size, or on another part of it.

use super::Description;
use crate::film::Crop;

/// Why a film cannot be as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// No pixels, or more than have an index.
    #[error(
        "a film of {width}x{height} pixels is not possible (expected at least 1x1, and at most \
         4294967295 pixels)"
    )]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A crop without pixels, or one that leaves the film.
    #[error(
        "a crop of {}x{} pixels at {},{} does not lie within the film of {width}x{height} pixels",
        crop.width, crop.height, crop.x, crop.y
    )]
    Crop {
        /// The crop.
        crop: Crop,
        /// Columns of the film.
        width: u32,
        /// Rows of the film.
        height: u32,
    },
}

impl Description {
    /// Changes the size of the whole film. The crop keeps showing the same part of the picture, as
    /// nearly as whole pixels allow; the camera keeps its field of view across the width.
    ///
    /// # Errors
    /// [`FilmError::Size`].
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), FilmError> {
        if width == 0 || height == 0 || width.checked_mul(height).is_none() {
            return Err(FilmError::Size { width, height });
        }
        let film = &mut self.film;
        let crop = film.crop;
        (film.crop.x, film.crop.width) = scale_span((crop.x, crop.width), film.width, width);
        (film.crop.y, film.crop.height) = scale_span((crop.y, crop.height), film.height, height);
        (film.width, film.height) = (width, height);
        self.camera = self.camera.with_aspect(f64::from(width) / f64::from(height));
        Ok(())
    }

    /// Changes the part of the film that is rendered.
    ///
    /// # Errors
    /// [`FilmError::Crop`].
    pub fn crop_to(&mut self, crop: Crop) -> Result<(), FilmError> {
        let (width, height) = (self.film.width, self.film.height);
        let fits = |start: u32, length: u32, whole: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= whole)
        };
        if !fits(crop.x, crop.width, width) || !fits(crop.y, crop.height, height) {
            return Err(FilmError::Crop { crop, width, height });
        }
        self.film.crop = crop;
        Ok(())
    }
}

/// `(start, length)` of a part of `from` pixels as a part of `to` pixels: both ends rounded to the
/// nearest pixel, and at least one pixel long.
fn scale_span((start, length): (u32, u32), from: u32, to: u32) -> (u32, u32) {
    let scale = |end: u64| {
        let nearest = (2 * end * u64::from(to) + u64::from(from)) / (2 * u64::from(from).max(1));
        u32::try_from(nearest).unwrap_or(to).min(to)
    };
    let start_scaled = scale(u64::from(start)).min(to - 1);
    let end_scaled = scale(u64::from(start) + u64::from(length)).max(start_scaled + 1);
    (start_scaled, end_scaled - start_scaled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::description::tests::description;

    fn crop(x: u32, y: u32, width: u32, height: u32) -> Crop {
        Crop { x, y, width, height }
    }

    #[test]
    fn the_crop_shows_the_same_part() {
        let mut d = description();
        d.resize(100, 50).expect("possible");
        assert_eq!(d.film.crop, crop(0, 0, 100, 50));
        d.crop_to(crop(10, 20, 30, 10)).expect("within");
        d.resize(200, 25).expect("possible");
        assert_eq!((d.film.width, d.film.height), (200, 25));
        assert_eq!(d.film.crop, crop(20, 10, 60, 5));
        // 0.7 to 2.8 of 7 columns is 1 to 3; of the rows, 2.8 to 4.2 of 7 is 3 to 4.
        d.resize(7, 7).expect("possible");
        assert_eq!(d.film.crop, crop(1, 3, 2, 1));
        d.resize(1, 1).expect("possible");
        assert_eq!(d.film.crop, crop(0, 0, 1, 1));
    }

    #[test]
    fn a_part_at_the_far_edge_keeps_a_pixel() {
        assert_eq!(scale_span((99, 1), 100, 2), (1, 1));
        assert_eq!(scale_span((u32::MAX - 1, 1), u32::MAX, 1), (0, 1));
        assert_eq!(scale_span((0, 1), 1, u32::MAX), (0, u32::MAX));
    }

    #[test]
    fn impossible_films_are_refused() {
        let mut d = description();
        d.resize(100, 50).expect("possible");
        let before = d.film.clone();
        for (width, height) in [(0, 1), (1, 0), (65536, 65536)] {
            let error = d.resize(width, height).expect_err("impossible").to_string();
            let expected = format!(
                "a film of {width}x{height} pixels is not possible (expected at least 1x1, and at \
                 most 4294967295 pixels)"
            );
            assert_eq!(error, expected);
        }
        for part in
            [crop(0, 0, 0, 1), crop(71, 0, 30, 1), crop(0, 50, 1, 1), crop(1, 0, u32::MAX, 1)]
        {
            let error = d.crop_to(part).expect_err("outside").to_string();
            let expected = format!(
                "a crop of {}x{} pixels at {},{} does not lie within the film of 100x50 pixels",
                part.width, part.height, part.x, part.y
            );
            assert_eq!(error, expected);
        }
        assert_eq!(d.film, before);
    }
}
