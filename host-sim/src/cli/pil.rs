use std::path::PathBuf;

use super::fault::Fault;
use super::output::{Notes, Outputs};
use crate::pil::{self, PilError};
use crate::port::Port;
use crate::report::Summariser;
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The scenario, a TOML file (its keys: `host-sim run --help`).
    scenario: PathBuf,
    /// Where the chip is: a serial device, or tcp:HOST:PORT for an emulator.
    #[arg(long, value_name = "PORT")]
    port: String,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Run)?;
    let results = arguments.outputs.begin(&[&arguments.scenario])?;
    let fault = |error| match error {
        PilError::Scenario(fault) => Fault::of_scenario(&arguments.scenario, fault),
        other => Fault::Other(other.to_string()),
    };
    pil::loop_settings(&scenario).map_err(fault)?;
    let mut port = Port::open(&arguments.port).map_err(|error| Fault::Input(error.to_string()))?;

    let mut summariser = Summariser::new(&scenario);
    let mut trace = Vec::new();
    let outcome = pil::run(&scenario, &mut port, &mut |sample| {
        summariser.add(sample);
        trace.push(*sample);
    })
    .map_err(fault)?;
    let summary = summariser.finish(&scenario, outcome);
    results.conclude(&scenario, summary, &trace, &Notes::default())
}
