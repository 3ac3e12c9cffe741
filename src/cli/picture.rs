//! Pictures out, wherever they can go.

use std::path::PathBuf;

use telamon::film::exr::{Metadata, write_exr};
use telamon::film::output::{FileFormat, Written, write_somewhere};
use telamon::film::picture::Picture;
use telamon::film::png::write_png;

use super::message::{Failure, warn};
use super::values::Output;

/// Writes a file and returns where it is: in another place, with a warning, if it cannot be where it
/// should. PNG files are brightened by so many powers of 2.
pub(super) fn write(
    Output { path, format }: &Output,
    picture: &Picture,
    metadata: &Metadata,
    exposure_stops: f32,
) -> Result<PathBuf, Failure> {
    let Written { report, instead } =
        write_somewhere(path, &std::env::temp_dir(), |path| match format {
            FileFormat::Exr => write_exr(path, picture, metadata),
            FileFormat::Png => write_png(path, picture, exposure_stops),
        })?;
    if !report.is_clean() {
        warn(format!("{}: {report}", path.display()));
    }
    let Some((place, why)) = instead else { return Ok(path.clone()) };
    warn(format!("{why}; the picture is in `{}`", place.display()));
    Ok(place)
}
