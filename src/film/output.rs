//! Picture files: which kind a name asks for, what may go wrong, and writing that leaves either the
//! whole file or what was there before.

use std::fmt::{self, Display, Formatter};
use std::fs::{self, Permissions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

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

/// Finds out whether a file could be written to `path`, without touching it: worth asking before an
/// hour of rendering.
///
/// # Errors
/// A missing folder, a folder in the file's place, what the operating system refuses.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    temporary_beside(path).map(drop)
}

/// Writes `contents` to a file: through a temporary one, so that either all of it is there or what was
/// there before.
///
/// # Errors
/// As [`check_writable`].
pub fn write_whole(path: &Path, contents: &[u8]) -> Result<(), OutputError> {
    write_atomically(path, |writer| {
        writer.write_all(contents).map_err(|error| OutputError::Io { path: path.to_owned(), error })
    })
}

/// Writes a file through an [`AtomicFile`]. If anything fails, `path` is as it was and nothing else is left
/// behind.
pub(super) fn write_atomically(
    path: &Path,
    contents: impl FnOnce(&mut AtomicFile) -> Result<(), OutputError>,
) -> Result<(), OutputError> {
    let mut file = AtomicFile::create(path)?;
    contents(&mut file)?;
    file.finish()
}

/// A file that takes the place of its path in one step, once it is finished and its contents are on the
/// disk; until then it is a temporary one in the same folder, gone when dropped.
#[derive(Debug)]
pub(crate) struct AtomicFile {
    path: PathBuf,
    temporary: BufWriter<tempfile::NamedTempFile>,
    _listed: Listed<'static>,
}

impl AtomicFile {
    pub(crate) fn create(path: &Path) -> Result<Self, OutputError> {
        let temporary = temporary_beside(path)?;
        let _listed = TEMPORARIES.add(temporary.path());
        Ok(Self { path: path.to_owned(), temporary: BufWriter::new(temporary), _listed })
    }

    /// An error of the operating system about this file.
    pub(crate) fn error(&self, error: io::Error) -> OutputError {
        OutputError::Io { path: self.path.clone(), error }
    }

    pub(crate) fn finish(self) -> Result<(), OutputError> {
        let Self { path, temporary, _listed } = self;
        let io = |error| OutputError::Io { path: path.clone(), error };
        let temporary = temporary.into_inner().map_err(|e| io(e.into_error()))?;
        temporary.as_file().sync_all().map_err(io)?;
        temporary.persist(&path).map_err(|e| io(e.error))?;
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.temporary.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.temporary.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.temporary.seek(to)
    }
}

/// Removes the temporary files of all that is being written, which then fail: for a process that
/// ends at once.
pub fn remove_temporaries() {
    TEMPORARIES.remove();
}

static TEMPORARIES: Temporaries = Temporaries(Mutex::new(Vec::new()));

/// Temporary files that are being written. A process that is told to end at once runs no destructors, and
/// has no other way to know of them.
#[derive(Debug)]
struct Temporaries(Mutex<Vec<PathBuf>>);

/// A place in the list, free again when dropped.
#[derive(Debug)]
struct Listed<'a> {
    list: &'a Temporaries,
    path: PathBuf,
}

impl Temporaries {
    fn paths(&self) -> MutexGuard<'_, Vec<PathBuf>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, path: &Path) -> Listed<'_> {
        self.paths().push(path.to_owned());
        Listed { list: self, path: path.to_owned() }
    }

    fn remove(&self) {
        for path in self.paths().drain(..) {
            // It may have got its name just now, or be gone.
            let _ = fs::remove_file(path);
        }
    }
}

impl Drop for Listed<'_> {
    fn drop(&mut self) {
        self.list.paths().retain(|path| *path != self.path);
    }
}

/// A temporary file in the folder of `path`, gone when dropped.
fn temporary_beside(path: &Path) -> Result<tempfile::NamedTempFile, OutputError> {
    if path.is_dir() {
        return Err(OutputError::IsFolder(path.to_owned()));
    }
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    if !fs::metadata(folder).is_ok_and(|m| m.is_dir()) {
        return Err(OutputError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    tempfile::Builder::new()
        .prefix(".telamon-")
        // As any new file, less the process's umask; a temporary file would be its owner's alone.
        .permissions(Permissions::from_mode(0o666))
        .tempfile_in(folder)
        // The operating system's own words, without the temporary file's name.
        .map_err(|error| OutputError::Io { path: path.to_owned(), error: error.kind().into() })
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

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("exists").flatten();
        entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect()
    }

    fn put(writer: &mut AtomicFile, bytes: &[u8]) -> Result<(), OutputError> {
        writer.write_all(bytes).expect("there is room");
        Ok(())
    }

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
    fn a_failed_write_leaves_what_was_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        write_atomically(&path, |w| put(w, b"first")).expect("writable");
        let failed = write_atomically(&path, |w| {
            put(w, b"second")?;
            Err(OutputError::NoColors(path.clone()))
        });
        assert!(matches!(failed, Err(OutputError::NoColors(_))));
        assert_eq!(fs::read(&path).expect("still there"), b"first");
        assert_eq!(names(folder.path()), ["a.png"]);
        write_atomically(&path, |w| put(w, b"third")).expect("writable");
        assert_eq!(fs::read(&path).expect("replaced"), b"third");
        assert_eq!(names(folder.path()), ["a.png"]);
        // Readable by those who may read any new file.
        let plain = folder.path().join("plain");
        fs::write(&plain, "").expect("writable");
        let mode = |p: &Path| fs::metadata(p).expect("exists").permissions().mode();
        assert_eq!(mode(&path), mode(&plain));
    }

    #[test]
    fn who_ends_at_once_removes_what_is_half_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let [half, whole] = ["half", "whole"].map(|name| folder.path().join(name));
        let list = Temporaries(Mutex::new(Vec::new()));
        for path in [&half, &whole] {
            fs::write(path, "").expect("writable");
        }
        let _listed = list.add(&half);
        drop(list.add(&whole));
        list.remove();
        assert_eq!(names(folder.path()), ["whole"]);
    }

    #[test]
    fn what_cannot_be_written_is_said_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = |path: &Path| check_writable(path).expect_err("refused").to_string();
        let path = folder.path().join("none/a.exr");
        assert_eq!(
            message(&path),
            format!(
                "cannot write `{}`: there is no folder `{}/none`",
                path.display(),
                folder.path().display()
            )
        );
        let path = folder.path();
        assert_eq!(message(path), format!("cannot write `{}`: it is a folder", path.display()));
        // The kernel's own folder, which even root cannot write to.
        let told = message(Path::new("/proc/a.exr"));
        assert!(told.starts_with("cannot write `/proc/a.exr`: "), "{told}");
        check_writable(&folder.path().join("a.exr")).expect("writable");
        assert!(names(folder.path()).is_empty(), "a check leaves nothing behind");
    }

    #[test]
    fn reports_name_what_was_changed() {
        assert!(Report::default().is_clean());
        let report = Report { clamped: 2, not_a_number: 1 };
        assert_eq!(report.to_string(), "values clamped to ±65504: 2, values that are NaN: 1");
    }
}
