use std::path::PathBuf;

use super::fault::Fault;
use super::output::{Notes, Outputs};
use crate::experiment::Sample;
use crate::replay::{self, Log};
use crate::report::Summariser;
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The log, .csv or .csv.gz.
    log: PathBuf,
    /// The scenario: identifier, the log's columns, and the controller that ran where the log has no
    /// command.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Passes over the log, each from the estimates of the one before.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    passes: u32,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let scenario = Scenario::load(&arguments.scenario, Purpose::Replay)?;
    let results = arguments
        .outputs
        .begin(&[&arguments.scenario, &arguments.log])?;
    let Some(columns) = scenario.log.clone() else {
        return Err(Fault::Input("the scenario has no [log]".to_owned()));
    };
    let declared = scenario.stated.controller.is_some();
    let log = Log::read(
        &arguments.log,
        &columns,
        declared.then_some(scenario.sample_time()),
    )
    .map_err(|error| Fault::Input(error.to_string()))?;
    let scenario = replay::fitted(scenario, &log);
    let sample_time = log.sample_time;
    let in_pass = log.records.len();
    let duration = in_pass as f64 * sample_time * f64::from(arguments.passes);

    let mut summariser = Summariser::lasting(&scenario, duration);
    let mut trace = Vec::with_capacity(in_pass);
    let replayed = replay::replay(&scenario, &log, arguments.passes, &mut |sample| {
        summariser.add(sample);
        let starts_again = trace
            .last()
            .is_some_and(|last: &Sample| sample.time - last.time > 1.5 * sample_time);
        if starts_again {
            trace.clear();
        }
        trace.push(*sample);
    })
    .map_err(|error| Fault::of_scenario(&arguments.scenario, error))?;
    let summary = summariser.finish(&scenario, replayed.outcome);
    let bridged = (log.bridged > 0).then(|| {
        format!(
            "{} missing samples were bridged by straight lines",
            log.bridged
        )
    });
    let notes = Notes {
        agreement: replayed.agreement,
        bridged,
    };
    results.conclude(&scenario, summary, &trace, &notes)
}
