//! Files that appear whole or not at all.
//!
//! Contents go to a temporary file `.telamon-…` beside the target, which takes the target's name in one
//! step. It is locked (`flock`) as long as its writer lives, so a later run can tell those that a killed
//! process left behind from those that are being written, on any machine that shares the folder, and
//! removes them.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, BufWriter, Cursor, Seek, SeekFrom, Write};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use tempfile::NamedTempFile;

use super::output::OutputError;

/// How names of temporary files begin.
const PREFIX: &str = ".telamon-";

/// Links to links, as the kernel has it.
const MOST_LINKS: usize = 40;

/// Finds out whether a file could be written to `path`, without touching it: worth asking before an
/// hour of rendering.
///
/// # Errors
/// A missing folder, a folder in the file's place, what the operating system refuses.
pub fn check_writable(path: &Path) -> Result<(), OutputError> {
    AtomicFile::create(path).map(drop)
}

/// Writes `contents` to a file through an [`AtomicFile`].
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
///
/// Links are followed: the file that they lead to is replaced. What is no file of a disk, such as a FIFO or
/// a device, is opened and written to when the contents are complete.
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    contents: Contents,
}

/// Where contents are until the file is finished.
#[derive(Debug)]
enum Contents {
    /// Beside the target.
    Temporary { target: PathBuf, writer: BufWriter<NamedTempFile>, _listed: Listed<'static> },
    /// In memory, since neither a FIFO nor a device can be sought in.
    Memory(Cursor<Vec<u8>>),
}

impl AtomicFile {
    /// A file for `path`; temporary ones of dead processes in its folder are removed.
    ///
    /// # Errors
    /// As [`check_writable`].
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let io = |error| OutputError::Io { path: path.to_owned(), error };
        let contents = match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => {
                return Err(OutputError::IsFolder(path.to_owned()));
            }
            Ok(metadata) if metadata.file_type().is_socket() => {
                let reason = "it is a socket".to_owned();
                return Err(OutputError::Unfit { path: path.to_owned(), reason });
            }
            Ok(metadata) if !metadata.is_file() => Contents::Memory(Cursor::default()),
            // What is missing may yet be the target of a link.
            _ => {
                let target = follow_links(path).map_err(io)?;
                let folder = folder_of(&target);
                if !fs::metadata(folder).is_ok_and(|m| m.is_dir()) {
                    let folder = folder.to_owned();
                    return Err(OutputError::NoFolder { path: path.to_owned(), folder });
                }
                remove_abandoned(folder);
                // The operating system's own words, without the temporary file's name.
                let (file, _listed) =
                    TEMPORARIES.create(folder).map_err(|e| io(e.kind().into()))?;
                Contents::Temporary { target, writer: BufWriter::new(file), _listed }
            }
        };
        Ok(Self { path: path.to_owned(), contents })
    }

    /// An error of the operating system about this file.
    pub(crate) fn error(&self, error: io::Error) -> OutputError {
        OutputError::Io { path: self.path.clone(), error }
    }

    /// Puts the file in its place. A FIFO is waited for until somebody reads it.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn finish(self) -> Result<(), OutputError> {
        let Self { path, contents } = self;
        contents.finish(&path).map_err(|error| OutputError::Io { path, error })
    }
}

impl Contents {
    fn finish(self, path: &Path) -> io::Result<()> {
        match self {
            Self::Temporary { target, writer, _listed } => {
                let temporary = writer.into_inner().map_err(io::IntoInnerError::into_error)?;
                temporary.as_file().sync_all()?;
                temporary.persist(&target)?;
                Ok(())
            }
            Self::Memory(bytes) => {
                let mut file = OpenOptions::new().write(true).open(path)?;
                file.write_all(bytes.get_ref())?;
                file.flush()
            }
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.contents {
            Contents::Temporary { writer, .. } => writer.write(bytes),
            Contents::Memory(memory) => memory.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.contents {
            Contents::Temporary { writer, .. } => writer.flush(),
            Contents::Memory(_) => Ok(()),
        }
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.contents {
            Contents::Temporary { writer, .. } => writer.seek(to),
            Contents::Memory(memory) => memory.seek(to),
        }
    }
}

/// The folder that a file stands in.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

/// Where the links at `path` lead to in the end, whether there is anything or not.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..=MOST_LINKS {
        if !fs::symlink_metadata(&target).is_ok_and(|m| m.is_symlink()) {
            return Ok(target);
        }
        // Relative to the link's own folder; an absolute one replaces it.
        target = folder_of(&target).join(fs::read_link(&target)?);
    }
    Err(Errno::LOOP.into())
}

/// Removes the temporary files that dead processes left in a folder: whose lock nobody holds. What cannot
/// be read or locked stays.
fn remove_abandoned(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_ours = entry.file_name().as_encoded_bytes().starts_with(PREFIX.as_bytes());
        if !is_ours || !entry.file_type().is_ok_and(|t| t.is_file()) {
            continue;
        }
        let path = entry.path();
        // Some network file systems lock only what is open for writing.
        let Ok(file) = OpenOptions::new().read(true).write(true).open(&path) else { continue };
        if flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
            // While the lock is held: its writer may be between making and locking it, and looks then.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Whether the lock of a new temporary file is ours and the file still there: another process may have
/// taken it for an abandoned one before it was locked. Where there are no locks, nobody can have.
fn is_kept(file: &File) -> io::Result<bool> {
    match flock(file, FlockOperation::NonBlockingLockExclusive) {
        Err(Errno::WOULDBLOCK) => Ok(false),
        Ok(()) | Err(_) => Ok(file.metadata()?.nlink() > 0),
    }
}

/// Removes the temporary files of all that is being written, which then fails, and lets nobody begin
/// another one: for a process that ends at once.
pub fn remove_temporaries() {
    let mut paths = TEMPORARIES.paths();
    remove_all(&mut paths);
    // Never unlocked again.
    std::mem::forget(paths);
}

fn remove_all(paths: &mut Vec<PathBuf>) {
    for path in paths.drain(..) {
        // It may have got its name just now, or be gone.
        let _ = fs::remove_file(path);
    }
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

    /// A temporary file in a folder, locked and listed; gone when dropped.
    fn create(&self, folder: &Path) -> io::Result<(NamedTempFile, Listed<'_>)> {
        // Under the lock of the list: there is no moment in which it exists and is not listed.
        let mut paths = self.paths();
        loop {
            let file = tempfile::Builder::new()
                .prefix(PREFIX)
                // As any new file, less the process's umask; a temporary file would be its owner's alone.
                .permissions(Permissions::from_mode(0o666))
                .tempfile_in(folder)?;
            if is_kept(file.as_file())? {
                let path = file.path().to_owned();
                paths.push(path.clone());
                return Ok((file, Listed { list: self, path }));
            }
        }
    }
}

impl Drop for Listed<'_> {
    fn drop(&mut self) {
        self.list.paths().retain(|path| *path != self.path);
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("exists").flatten();
        let mut names: Vec<_> =
            entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
        names.sort_unstable();
        names
    }

    fn put(writer: &mut AtomicFile, bytes: &[u8]) -> Result<(), OutputError> {
        writer.write_all(bytes).expect("there is room");
        Ok(())
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
        let list = Temporaries(Mutex::new(Vec::new()));
        let (_file, _listed) = list.create(folder.path()).expect("writable");
        let (whole, listed) = list.create(folder.path()).expect("writable");
        whole.persist(folder.path().join("whole")).expect("writable");
        drop(listed);
        assert_eq!(names(folder.path()).len(), 2);
        remove_all(&mut list.paths());
        assert_eq!(names(folder.path()), ["whole"]);
    }

    #[test]
    fn links_are_followed_and_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("far")).expect("writable");
        fs::write(path("far/target"), "old").expect("writable");
        symlink("far/target", path("near")).expect("writable");
        symlink(path("near"), path("link")).expect("writable");
        symlink("far/new", path("dangling")).expect("writable");
        symlink("circle", path("circle")).expect("writable");
        symlink("none/new", path("broken")).expect("writable");
        for (link, target) in [("link", "far/target"), ("dangling", "far/new")] {
            write_whole(&path(link), b"new").expect("writable");
            assert!(fs::symlink_metadata(path(link)).expect("there").is_symlink(), "{link}");
            assert_eq!(fs::read(path(target)).expect("written"), b"new", "{link}");
        }
        assert_eq!(names(&path("far")), ["new", "target"]);
        assert_eq!(names(folder.path()), ["broken", "circle", "dangling", "far", "link", "near"]);
        let refused = |name| write_whole(&path(name), b"").expect_err("refused").to_string();
        assert!(refused("circle").contains("symbolic link"), "{}", refused("circle"));
        let told = refused("broken");
        assert!(told.ends_with(&format!("there is no folder `{}`", path("none").display())));
    }

    #[test]
    fn devices_and_fifos_are_written_to() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        write_whole(Path::new("/dev/null"), b"gone").expect("writable");
        let full = write_whole(Path::new("/dev/full"), b"gone").expect_err("full").to_string();
        assert_eq!(full, "cannot write `/dev/full`: No space left on device (os error 28)");

        let fifo = path("fifo");
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, &fifo, rustix::fs::FileType::Fifo, mode, 0)
            .expect("writable");
        symlink("fifo", path("link")).expect("writable");
        let reader = std::thread::spawn(move || fs::read(fifo).expect("readable"));
        write_atomically(&path("link"), |w| {
            put(w, b"xbc")?;
            w.seek(SeekFrom::Start(0)).expect("possible");
            put(w, b"a")
        })
        .expect("writable");
        assert_eq!(reader.join().expect("ends"), b"abc");
        assert_eq!(names(folder.path()), ["fifo", "link"]);
    }

    #[test]
    fn what_dead_processes_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        let mut alive = AtomicFile::create(&path("alive")).expect("writable");
        put(&mut alive, b"written slowly").expect("writable");
        // A killed process holds no locks.
        fs::write(path(".telamon-dead"), "half a picture").expect("writable");
        fs::write(path(".other"), "").expect("writable");
        fs::create_dir(path(".telamon-folder")).expect("writable");
        symlink(path(".other"), path(".telamon-link")).expect("writable");
        check_writable(&path("next")).expect("writable");
        assert!(!path(".telamon-dead").exists());
        assert!([".other", ".telamon-folder", ".telamon-link"].iter().all(|n| path(n).exists()));
        alive.finish().expect("its temporary file is still there");
        assert_eq!(fs::read(path("alive")).expect("written"), b"written slowly");
        assert_eq!(names(folder.path()), [".other", ".telamon-folder", ".telamon-link", "alive"]);
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
}
