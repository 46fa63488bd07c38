use std::path::PathBuf;

use super::fault::Fault;
use super::files::{self, Files};
use super::standard_output::show;
use crate::check::{Check, Words};
use crate::scenario::{Purpose, Scenario};

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scenario, a TOML file with a [plant].
    scenario: PathBuf,
    /// Write the analysis as JSON to this file; `-` is standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let mut files = Files::reading(&[&arguments.scenario], arguments.force);
    let json = files.output(arguments.json.as_deref())?;
    let check =
        Check::of(&scenario).map_err(|fault| Fault::of_scenario(&arguments.scenario, fault))?;
    files::commit([json.map(|json| json.document(&check))])?;
    if !files.own_standard_output() {
        show!("{}", Words(&check))?;
    }
    Ok(())
}
