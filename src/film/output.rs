//! Picture files: which kind a name asks for, what may go wrong, and where a picture goes that cannot go
//! where it should.

use std::fmt::{self, Display, Formatter};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::atomic_file::folder_of;
pub use super::atomic_file::{AtomicFile, check_writable, remove_temporaries, write_whole};
use super::picture::Picture;

/// A kind of picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFormat {
    /// OpenEXR: linear, all channels.
    Exr,
    /// PNG: 8 bits, sRGB, the picture proper alone.
    Png,
}

/// Why a picture is not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The name's extension is none that we write.
    #[error("unknown kind of picture `{0}` (expected a name that ends in `.exr` or `.png`)")]
    UnknownExtension(PathBuf),
    /// The folder is missing.
    #[error("cannot write `{path}`: there is no folder `{folder}`")]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// The folder.
        folder: PathBuf,
    },
    /// The name belongs to a folder.
    #[error("cannot write `{0}`: it is a folder")]
    IsFolder(PathBuf),
    /// The operating system refuses.
    #[error("cannot write `{path}`: {error}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        error: io::Error,
    },
    /// A picture of layers alone is asked for in a format that has none.
    #[error(
        "cannot write `{0}`: the picture has layers but no colours (expected a name that ends in \
         `.exr`)"
    )]
    NoColors(PathBuf),
    /// The channels cannot be stored under these names, or do not cover the crop.
    #[error("cannot write `{path}`: {reason}")]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What is wrong with them.
        reason: String,
    },
}

impl OutputError {
    /// Whether the file might be written in another place.
    fn is_of_the_place(&self) -> bool {
        matches!(self, Self::NoFolder { .. } | Self::IsFolder(_) | Self::Io { .. })
    }
}

/// Numbers that a file shows otherwise than they were computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Finite or infinite numbers beyond the range of half floats, stored as its ends ±65504.
    pub clamped: usize,
    /// Numbers that are none: kept in an EXR file, magenta in a PNG file.
    pub not_a_number: usize,
}

impl FileFormat {
    /// The format that the extension of `path` asks for; upper and lower case are alike.
    ///
    /// # Errors
    /// [`OutputError::UnknownExtension`].
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        match extension.as_deref().and_then(|e| e.to_str()) {
            Some("exr") => Ok(Self::Exr),
            Some("png") => Ok(Self::Png),
            _ => Err(OutputError::UnknownExtension(path.to_owned())),
        }
    }
}

impl Report {
    /// Whether the file shows everything as it was computed.
    #[must_use]
    pub fn is_clean(&self) -> bool {
        *self == Self::default()
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let clamped =
            (self.clamped > 0).then(|| format!("values clamped to ±65504: {}", self.clamped));
        let lost =
            (self.not_a_number > 0).then(|| format!("values that are NaN: {}", self.not_a_number));
        let parts: Vec<_> = clamped.into_iter().chain(lost).collect();
        f.write_str(&parts.join(", "))
    }
}

/// Where a picture went.
#[derive(Debug)]
pub struct Written<T> {
    /// What writing it had to say.
    pub report: T,
    /// Where it is, and why not where it should be; `None` if it is there.
    pub instead: Option<(PathBuf, OutputError)>,
}

/// Writes a file to `path` by `write`, or else where the operating system lets it: beside, under a name
/// that is free, and then in the folder `elsewhere`. What has taken hours shall not be lost because a folder
/// is gone or a disk is full.
///
/// # Errors
/// That of `path`, if no other place will do either, or if no place could mend it.
pub fn write_somewhere<T>(
    path: &Path,
    elsewhere: &Path,
    mut write: impl FnMut(&Path) -> Result<T, OutputError>,
) -> Result<Written<T>, OutputError> {
    let why = match write(path) {
        Ok(report) => return Ok(Written { report, instead: None }),
        Err(why) if !why.is_of_the_place() => return Err(why),
        Err(why) => why,
    };
    for folder in [folder_of(path), elsewhere] {
        let Some(other) = free_name(folder, path) else { continue };
        if let Ok(report) = write(&other) {
            return Ok(Written { report, instead: Some((other, why)) });
        }
    }
    Err(why)
}

/// A name in `folder` that nothing has yet, after that of `path`: `a-rescued.exr`, `a-rescued-2.exr`.
fn free_name(folder: &Path, path: &Path) -> Option<PathBuf> {
    let mut names = (1..1000).map(|number| {
        let mut name = path.file_stem().unwrap_or_default().to_owned();
        name.push("-rescued");
        if number > 1 {
            name.push(format!("-{number}"));
        }
        let mut name = folder.join(name).into_os_string();
        if let Some(extension) = path.extension() {
            name.push(".");
            name.push(extension);
        }
        PathBuf::from(name)
    });
    // Not `exists`, which is false of a link that leads nowhere.
    names.find(|name| fs::symlink_metadata(name).is_err())
}

/// Refuses a picture whose channels do not cover its crop.
pub(super) fn check_shape(path: &Path, picture: &Picture) -> Result<(), OutputError> {
    let unfit = |reason| Err(OutputError::Unfit { path: path.to_owned(), reason });
    let pixels = picture.pixels();
    if pixels == 0 || picture.channels.is_empty() {
        return unfit("the picture is empty".to_owned());
    }
    for channel in &picture.channels {
        if channel.values.len() != pixels {
            let count = channel.values.len();
            return unfit(format!("channel `{}` has {count} of {pixels} pixels", channel.name));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_name_the_format() {
        assert_eq!(FileFormat::of(Path::new("a/b.exr")).expect("known"), FileFormat::Exr);
        assert_eq!(FileFormat::of(Path::new("a.b.PNG")).expect("known"), FileFormat::Png);
        for name in ["a.jpg", "exr", ".png", "a.exr.gz", ""] {
            let error = FileFormat::of(Path::new(name)).expect_err("unknown").to_string();
            let expected = format!(
                "unknown kind of picture `{name}` (expected a name that ends in `.exr` or `.png`)"
            );
            assert_eq!(error, expected);
        }
    }

    #[test]
    fn what_cannot_go_there_goes_beside_and_then_elsewhere() {
        let [folder, elsewhere] = [0; 2].map(|_| tempfile::tempdir().expect("a folder"));
        let write = |path: &Path| {
            write_somewhere(path, elsewhere.path(), |path| write_whole(path, b"hours"))
        };
        let place =
            |written: Written<()>| written.instead.map(|(path, why)| (path, why.to_string()));
        let path = folder.path().join("a.v2.exr");
        assert_eq!(place(write(&path).expect("writable")), None);
        fs::remove_file(&path).expect("there");
        fs::create_dir(&path).expect("writable");
        let why = format!("cannot write `{}`: it is a folder", path.display());
        for name in ["a.v2-rescued.exr", "a.v2-rescued-2.exr"] {
            let (place, said) = place(write(&path).expect("there is room")).expect("not there");
            assert_eq!((&place, &said), (&folder.path().join(name), &why));
            assert_eq!(fs::read(&place).expect("written"), b"hours");
        }
        // The disk of that device is full, and the link's folder is not.
        let link = folder.path().join("link.png");
        std::os::unix::fs::symlink("/dev/full", &link).expect("writable");
        let (beside, said) = place(write(&link).expect("there is room")).expect("not there");
        assert_eq!(beside, folder.path().join("link-rescued.png"));
        assert!(said.ends_with("No space left on device (os error 28)"), "{said}");
        // A folder that is gone has no room beside.
        let gone = folder.path().join("gone/b.png");
        let (place, said) = place(write(&gone).expect("there is room")).expect("not there");
        assert_eq!(place, elsewhere.path().join("b-rescued.png"));
        assert!(said.contains("there is no folder"), "{said}");
        // What no place can mend, and what finds none.
        let unfit = |path: &Path| Err::<(), _>(OutputError::NoColors(path.to_owned()));
        let refused = write_somewhere(&path, elsewhere.path(), unfit).expect_err("unfit");
        assert!(matches!(refused, OutputError::NoColors(_)));
        let refused =
            write_somewhere(&gone, &gone, |path| write_whole(path, b"")).expect_err("lost");
        assert!(refused.to_string().contains("gone/b.png"), "{refused}");
    }

    #[test]
    fn reports_name_what_was_changed() {
        assert!(Report::default().is_clean());
        let report = Report { clamped: 2, not_a_number: 1 };
        assert_eq!(report.to_string(), "values clamped to ±65504: 2, values that are NaN: 1");
    }
}
