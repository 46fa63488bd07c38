use std::io::{self, Write};

use clap::CommandFactory;
use clap_complete::Shell;

use super::fault::Fault;
use super::standard_output;
use crate::program;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The shell.
    shell: Shell,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let mut script = Vec::new();
    let mut command = super::Arguments::command();
    clap_complete::generate(arguments.shell, &mut command, program::NAME, &mut script);
    standard_output::written(io::stdout().write_all(&script))
}
