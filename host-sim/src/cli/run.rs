use std::path::PathBuf;

use super::fault::Fault;
use super::output::Outputs;
use crate::experiment;
use crate::report::{Status, Summariser, residual, table};
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file (its keys: `host-sim run --help`).
    scenario: PathBuf,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    arguments.outputs.check()?;

    let mut summariser = Summariser::new(&scenario);
    let mut trace = Vec::new();
    let outcome = experiment::run(&scenario, &mut |sample| {
        summariser.add(sample);
        trace.push(*sample);
    });
    let summary = summariser.finish(&scenario, outcome);
    let residual = summary
        .output_error
        .map(|_| residual::Report::new(&scenario, &summary, &trace));

    arguments
        .outputs
        .write(&summary, &trace, residual.as_ref())?;
    if !arguments.outputs.is_quiet() {
        say!("{}", table::estimates(&[(summary.law, &summary)]));
        say!("{}: {}", summary.status.name(), summary.reason);
        if let Some(residual) = residual {
            say!("{residual}");
        }
    }
    match summary.status {
        Status::Aborted => Err(Fault::Other(summary.reason)),
        Status::Converged | Status::NotConverged => Ok(()),
    }
}
