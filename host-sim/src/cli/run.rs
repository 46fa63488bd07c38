use std::path::PathBuf;

use super::fault::Fault;
use super::output::{Notes, Outputs};
use crate::report::Summariser;
use crate::scenario::{Purpose, Scenario, keys};
use crate::simulate;

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
    let results = arguments.outputs.begin(&[&arguments.scenario])?;

    let mut summariser = Summariser::new(&scenario);
    let mut trace = Vec::new();
    let outcome = simulate::run(&scenario, &mut |sample| {
        summariser.add(sample);
        trace.push(*sample);
    })
    .map_err(|fault| Fault::of_scenario(&arguments.scenario, fault))?;
    let summary = summariser.finish(&scenario, outcome);
    results.conclude(&scenario, summary, &trace, &Notes::default())
}
