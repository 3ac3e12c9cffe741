//! `telamon man`.

use std::io;

use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;

use super::message::Failure;
use super::{CommandLine, print};

/// Print the manual page
#[derive(Args, Debug)]
#[command(after_help = "Example: telamon man | man -l -")]
pub(super) struct Arguments {}

impl Arguments {
    pub(super) fn run(&self) -> Result<(), Failure> {
        print(&page()?)
    }
}

/// One page for all subcommands, each with its own options.
fn page() -> io::Result<Vec<u8>> {
    let mut command = CommandLine::command();
    // Fills in the names with which subcommands are called.
    command.build();
    let subcommands: Vec<Command> =
        command.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect();
    let whole = Man::new(command);
    let mut page = Vec::new();
    whole.render_title(&mut page)?;
    whole.render_name_section(&mut page)?;
    whole.render_synopsis_section(&mut page)?;
    whole.render_description_section(&mut page)?;
    for subcommand in subcommands {
        section(subcommand, &mut page)?;
    }
    whole.render_extra_section(&mut page)?;
    whole.render_version_section(&mut page)?;
    Ok(page)
}

/// The parts of a subcommand's own page, as subsections of a section of its name.
fn section(subcommand: Command, page: &mut Vec<u8>) -> io::Result<()> {
    let heading = subcommand.get_name().to_uppercase();
    let man = Man::new(subcommand);
    let mut parts = Vec::new();
    man.render_synopsis_section(&mut parts)?;
    man.render_description_section(&mut parts)?;
    man.render_options_section(&mut parts)?;
    man.render_extra_section(&mut parts)?;
    page.extend(format!(".SH {heading}\n").bytes());
    page.extend(String::from_utf8_lossy(&parts).replace("\n.SH ", "\n.SS ").bytes());
    Ok(())
}
