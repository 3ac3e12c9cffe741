//! Measures the lecture's trades and writes `docs/the-trade.md`: six tables, each with a plot, intervals
//! and two sentences on what it shows.
//!
//! `cargo run --release --example the_trade` measures everything, in about ten minutes on two cores that
//! have nothing else to do; with names of sections it measures those alone. What was measured is kept in
//! `docs/the-trade/` as JSON, and the document is written from that: with `--write` without measuring.

mod document;
mod leaks;
#[path = "../../src/cli/machine.rs"]
mod machine;
mod sections;
mod subject;
#[cfg(test)]
mod tests;
mod trial;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use telamon::film::output::write_whole;

use document::{document, figure};
use sections::{SECTIONS, Section};
use trial::{Measured, Trial};

/// Measure what the lecture's choices cost and give, and write docs/the-trade.md.
#[derive(Parser)]
struct Arguments {
    /// Sections to measure [default: all]
    #[arg(value_name = "SECTION", value_parser = clap::builder::PossibleValuesParser::new(
        SECTIONS.iter().map(|s| s.name)
    ))]
    sections: Vec<String>,
    /// Measure nothing: write the document from what is stored
    #[arg(long, conflicts_with = "sections")]
    write: bool,
}

#[expect(clippy::print_stderr, reason = "this is a command")]
fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    match run(&Arguments::parse(), root) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

#[expect(clippy::print_stderr, reason = "this is a command")]
fn run(arguments: &Arguments, root: &Path) -> Result<(), Box<dyn Error>> {
    let folder = root.join("docs/the-trade");
    fs::create_dir_all(&folder)?;
    let wanted = |s: &Section| {
        arguments.sections.is_empty() || arguments.sections.iter().any(|name| name == s.name)
    };
    for section in SECTIONS.iter().filter(|s| !arguments.write && wanted(s)) {
        for trial in section.trials {
            eprintln!("{}", trial.name);
            let mut json = serde_json::to_vec(&trial.measure(root)?)?;
            json.push(b'\n');
            write_whole(&stored(root, trial), &json)?;
        }
    }
    let all = read(root)?;
    for (section, measured) in &all {
        for (trial, measured) in section.trials.iter().zip(measured) {
            let path = folder.join(format!("{}.svg", trial.name));
            write_whole(&path, figure(trial, measured).as_bytes())?;
        }
    }
    write_whole(&root.join("docs/the-trade.md"), document(&all).as_bytes())?;
    Ok(())
}

fn stored(root: &Path, trial: &Trial) -> PathBuf {
    root.join("docs/the-trade").join(format!("{}.json", trial.name))
}

/// A section, and what each of its trials gave.
type Found = (&'static Section, Vec<Measured>);

/// What is stored of all sections.
fn read(root: &Path) -> Result<Vec<Found>, Box<dyn Error>> {
    let one = |trial: &Trial| -> Result<Measured, Box<dyn Error>> {
        let path = stored(root, trial);
        let text = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let stored =
            serde_json::from_slice(&text).map_err(|e| format!("{}: {e}", path.display()))?;
        trial.judge(root, stored)
    };
    let section = |section: &'static Section| {
        Ok((section, section.trials.iter().map(one).collect::<Result<_, Box<dyn Error>>>()?))
    };
    SECTIONS.iter().map(section).collect()
}
