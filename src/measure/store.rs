//! The folder of an experiment. Its files are replaced as wholes, so that a crash leaves what was there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::image::{Image, ImageError};
use super::record::{Origin, Record, runs_csv};
use super::summary::Findings;
use crate::film::exr::{Metadata, write_exr};
use crate::film::output::{OutputError, write_whole};
use crate::film::read::{InputError, read_exr};

/// Names of the files.
const RECORD: &str = "measurements.json";
const RUNS: &str = "runs.csv";
const FINDINGS: &str = "findings.json";
const REFERENCE: &str = "reference.exr";
const PAGE: &str = "report.html";

/// Why an experiment cannot be stored or continued.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The folder cannot be made.
    #[error("cannot create the folder `{path}`: {error}")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
    /// A file of it cannot be read.
    #[error("cannot read `{path}`: {reason}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// It holds another experiment.
    #[error(
        "`{folder}` holds measurements of something else: {difference} (expected another folder)"
    )]
    Other {
        /// The folder.
        folder: PathBuf,
        /// What differs.
        difference: String,
    },
    /// A file of it cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The reference cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The reference is not one.
    #[error("`{path}`: {error}")]
    Image {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: ImageError,
    },
}

/// A folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// A folder, made if it is not there; the one around it must be.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        match fs::create_dir(folder) {
            Err(_) if folder.is_dir() => {}
            Err(error) => return Err(StoreError::Folder { path: folder.to_owned(), error }),
            Ok(()) => {}
        }
        Ok(Self { folder: folder.to_owned() })
    }

    /// The experiment that it holds; `None` if there is none.
    ///
    /// # Errors
    /// A file that cannot be read or understood.
    pub fn record(&self) -> Result<Option<Record>, StoreError> {
        let path = self.folder.join(RECORD);
        let malformed = |reason| StoreError::Malformed { path: path.clone(), reason };
        let text = match fs::read(&path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            other => other.map_err(|e| malformed(e.to_string()))?,
        };
        serde_json::from_slice(&text).map(Some).map_err(|e| malformed(e.to_string()))
    }

    /// Refuses to go on with an experiment that was measured otherwise.
    ///
    /// # Errors
    /// [`StoreError::Other`].
    pub fn check(&self, stored: &Origin, now: &Origin) -> Result<(), StoreError> {
        match stored.difference(now) {
            Some(difference) => Err(StoreError::Other { folder: self.folder.clone(), difference }),
            None => Ok(()),
        }
    }

    /// Writes all runs so far.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn save(&self, record: &Record) -> Result<(), StoreError> {
        write_whole(&self.folder.join(RECORD), &json(record))?;
        Ok(write_whole(&self.folder.join(RUNS), runs_csv(&record.runs).as_bytes())?)
    }

    /// Writes what they say.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn save_findings(&self, findings: &Findings, page: &str) -> Result<PathBuf, StoreError> {
        write_whole(&self.folder.join(FINDINGS), &json(findings))?;
        let path = self.folder.join(PAGE);
        write_whole(&path, page.as_bytes())?;
        Ok(path)
    }

    /// The reference that was rendered for the experiment, if it was.
    ///
    /// # Errors
    /// A file that is no picture.
    pub fn reference(&self) -> Result<Option<Image>, StoreError> {
        let path = self.folder.join(REFERENCE);
        if !path.exists() {
            return Ok(None);
        }
        load_image(&path).map(Some)
    }

    /// Keeps it. `samples_per_pixel` is the number of samples that its variance is that of the mean of.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn save_reference(&self, image: &Image, metadata: &Metadata) -> Result<(), StoreError> {
        let picture = image.to_picture(metadata.samples_per_pixel.0);
        write_exr(&self.folder.join(REFERENCE), &picture, metadata)?;
        Ok(())
    }
}

/// The colours of an OpenEXR file.
///
/// # Errors
/// A file that cannot be read, or that has no colours.
pub fn load_image(path: &Path) -> Result<Image, StoreError> {
    let picture = read_exr(path)?;
    Image::from_picture(&picture)
        .map_err(|error| StoreError::Image { path: path.to_owned(), error })
}

fn json(value: &impl serde::Serialize) -> Vec<u8> {
    let mut text = serde_json::to_vec_pretty(value).expect("plain data has a form in JSON");
    text.push(b'\n');
    text
}
