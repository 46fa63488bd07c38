use std::io::{self, Write};

use clap::Command;
use clap_mangen::Man;

use super::fault::Fault;
use super::standard_output;
use crate::nearest;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The verb, also `drive status`; by default the page is that of the program.
    #[arg(value_name = "VERB")]
    verb: Vec<String>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let mut command = super::documented();
    // Gives every verb its full name.
    command.build();
    for verb in &arguments.verb {
        command = named(&command, verb)?;
    }
    let title = command.get_bin_name().unwrap_or_default().replace(' ', "-");
    let mut page = Vec::new();
    Man::new(command.display_name(title))
        .render(&mut page)
        .and_then(|()| io::stdout().write_all(&page))
        .map_or_else(|error| standard_output::written(Err(error)), Ok)
}

fn named(command: &Command, verb: &str) -> Result<Command, Fault> {
    let found = command.find_subcommand(verb);
    found.cloned().ok_or_else(|| {
        let verbs = command.get_subcommands().map(Command::get_name);
        let hint = nearest::name(verb, verbs)
            .map_or_else(String::new, |near| format!("; did you mean {near}?"));
        Fault::Input(format!("{verb}: there is no such verb{hint}"))
    })
}
