//! `telamon completions`.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::message::Failure;
use super::{CommandLine, print};

/// Print a script that completes this command's options in a shell
#[derive(Args, Debug)]
#[command(
    after_help = "Example: telamon completions bash > ~/.local/share/bash-completion/completions/telamon"
)]
pub(super) struct Arguments {
    /// Shell that is to read the script
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<(), Failure> {
        // Into memory first, since the generator panics where it cannot write.
        let mut script = Vec::new();
        let mut command = CommandLine::command();
        clap_complete::generate(self.shell, &mut command, "telamon", &mut script);
        print(&script)
    }
}
