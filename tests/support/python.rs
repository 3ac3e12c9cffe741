//! Python programs that answer through pipes, so that each loads and warms up only once.
//!
//! The benchmarks use this file too.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::{fmt, fs};

/// The interpreter of `tests/peers/venv`, which has all that `tests/peers/requirements.txt` names.
///
/// # Errors
/// How to make the environment, if there is none or one for other requirements.
pub(crate) fn peers() -> Result<PathBuf, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers");
    let read = |name: &str| fs::read(folder.join(name)).ok();
    let pins = read("requirements.txt");
    if pins.is_some() && pins == read("venv/requirements.txt") {
        return Ok(folder.join("venv/bin/python"));
    }
    Err(format!(
        "{} is missing or out of date; this makes it: ./setup.sh --peers",
        folder.join("venv").display()
    ))
}

/// A running program. It reads questions from its standard input and writes answers to its standard
/// output; what it complains about goes to ours.
pub(crate) struct Python {
    process: Child,
    questions: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Python {
    /// Starts `script` with `arguments` as its `sys.argv[1:]`.
    pub(crate) fn start(
        interpreter: &Path,
        script: &str,
        arguments: &[String],
    ) -> io::Result<Self> {
        let mut process = Command::new(interpreter)
            .args(["-c", script])
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| {
                let name = interpreter.display();
                io::Error::new(error.kind(), format!("{name} does not start: {error}"))
            })?;
        let questions = process.stdin.take();
        let answers = process.stdout.take().ok_or(io::ErrorKind::BrokenPipe)?;
        Ok(Self { process, questions, answers: BufReader::new(answers) })
    }

    /// Writes to its standard input.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let questions = self.questions.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        questions.write_all(bytes)
    }

    /// The next line of its standard output, without its end.
    pub(crate) fn line(&mut self) -> io::Result<String> {
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            let message = "the Python process ended without an answer";
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, message));
        }
        Ok(line.trim_end().to_owned())
    }

    /// The next bytes of its standard output.
    pub(crate) fn bytes(&mut self, count: usize) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; count];
        self.answers.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

impl fmt::Debug for Python {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Python process {}", self.process.id())
    }
}

impl Drop for Python {
    fn drop(&mut self) {
        // It ends when its input does; how, does not matter any more.
        drop(self.questions.take());
        let _ = self.process.wait();
    }
}
