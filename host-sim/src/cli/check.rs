use std::path::PathBuf;

use super::call;
use super::fault::Fault;
use super::files::{self, Files};
use super::standard_output::show;
use super::terminal::width;
use crate::check;
use crate::present;
use crate::render::terminal;
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
    let result =
        check::check(&scenario).map_err(|fault| Fault::of_file(&arguments.scenario, fault))?;
    files::commit([json.map(|json| json.document(&result))])?;
    if !files.own_standard_output() {
        let title = call::title("Check of", &arguments.scenario);
        let page = present::check(&title, &call::command(), &result);
        show!("{}", terminal::brief(&page, width()))?;
    }
    Ok(())
}
