//! What is wrong with a scene file, and where.

use std::collections::HashSet;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use super::document::{Place, Sources};

/// Why a scene cannot be loaded: everything that was found wrong, in the order of the files.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", Listing(.problems, *.more))]
pub struct LoadError {
    problems: Vec<Problem>,
    more: usize,
}

impl LoadError {
    /// What is wrong; at least one entry, at most [`LoadError::MOST`].
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// How many problems were found beyond those listed.
    #[must_use]
    pub fn more(&self) -> usize {
        self.more
    }

    /// The most problems that are listed: nobody reads further.
    pub const MOST: usize = 50;

    pub(super) fn new(issues: &[Issue], sources: &Sources) -> Self {
        let mut issues: Vec<_> = issues.iter().collect();
        issues.sort_by_key(|issue| issue.place.order());
        let problems = issues.iter().take(Self::MOST).map(|i| i.resolve(sources)).collect();
        Self { problems, more: issues.len().saturating_sub(Self::MOST) }
    }
}

/// One thing that is wrong, or (as a warning) that may not be as meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file.
    pub path: PathBuf,
    /// Where in the file; `None` if it concerns the file as a whole.
    pub position: Option<Position>,
    /// What is wrong: a fragment without a full stop.
    pub message: String,
    /// What would be right.
    pub help: Option<String>,
}

/// Something that may not be as meant, but does not stop a render.
pub type Warning = Problem;

/// A stretch of a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The text of the whole file.
    pub source: Arc<str>,
    /// The stretch in bytes; within `source`, at character boundaries.
    pub span: Range<usize>,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.path.display())?;
        if let Some(position) = &self.position {
            write!(f, ":{}:{}", position.line, position.column)?;
        }
        write!(f, ": {}", self.message)
    }
}

/// Problems below each other, each with its help.
struct Listing<'a>(&'a [Problem], usize);

impl fmt::Display for Listing<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.0.iter().enumerate() {
            write!(f, "{}{problem}", if i > 0 { "\n" } else { "" })?;
            if let Some(help) = &problem.help {
                write!(f, "\n  help: {}", help.replace('\n', "\n  "))?;
            }
        }
        if self.1 > 0 {
            write!(f, "\nand {} more problems", self.1)?;
        }
        Ok(())
    }
}

/// A problem as the stages of the loader pass it on: the place is looked up only when it is shown.
#[derive(Clone, Debug)]
pub(super) struct Issue {
    place: Place,
    message: String,
    help: Option<String>,
    /// Whether the message names what it is about, and so is said once, wherever that is used.
    once: bool,
}

impl Issue {
    pub(super) fn new(place: Place, message: impl Into<String>) -> Self {
        Self { place, message: message.into(), help: None, once: false }
    }

    pub(super) fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// The same, whose message names what it is about and is said once.
    pub(super) fn once(self) -> Self {
        Self { once: true, ..self }
    }

    /// In the order of the files, each that is said once the first time.
    pub(super) fn in_order(mut issues: Vec<Self>) -> Vec<Self> {
        issues.sort_by_key(|issue| issue.place.order());
        let mut said = HashSet::new();
        issues.retain(|issue| !issue.once || said.insert(issue.message.clone()));
        issues
    }

    pub(super) fn resolve(&self, sources: &Sources) -> Problem {
        let (path, position) = sources.locate(self.place);
        Problem { path, position, message: self.message.clone(), help: self.help.clone() }
    }
}
