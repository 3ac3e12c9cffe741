//! The `telamon` command.

use std::process::ExitCode;

use clap::Parser;

mod cli;

fn main() -> ExitCode {
    match cli::CommandLine::parse().run() {
        Ok(ending) => ending.into(),
        Err(failure) => {
            failure.show();
            ExitCode::FAILURE
        }
    }
}
