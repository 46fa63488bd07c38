use std::path::PathBuf;

use identifier_core::units::Units;

use super::fault::Fault;
use super::output::Outputs;
use crate::experiment::Sample;
use crate::replay::{self, Log};
use crate::report::Summariser;
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The log, .csv or .csv.gz.
    log: PathBuf,
    /// The scenario: controller, identifier and the log's columns.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Passes over the log, each from the estimates of the one before.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    passes: u32,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let mut scenario = Scenario::load(&arguments.scenario, Purpose::Replay)?;
    arguments.outputs.check()?;
    let Some(columns) = scenario.log.clone() else {
        return Err(Fault::Input("the scenario has no [log]".to_owned()));
    };
    let sample_time = scenario.controller.units.sample_time();
    let log = Log::read(&arguments.log, &columns, sample_time)
        .map_err(|error| Fault::Input(error.to_string()))?;
    if scenario.counts_per_rev.is_none() {
        scenario.controller.units = Units::new(sample_time, log.resolution())
            .map_err(|error| Fault::Input(error.to_string()))?;
    }
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
    .map_err(|error| Fault::Input(format!("{}: {error}", arguments.log.display())))?;
    let summary = summariser.finish(&scenario, replayed.outcome);
    let agreement = replayed.agreement.map(|agreement| agreement.to_string());
    let bridged = (log.bridged > 0).then(|| {
        format!(
            "{} missing samples were bridged by straight lines",
            log.bridged
        )
    });
    let notes: Vec<String> = agreement.into_iter().chain(bridged).collect();
    arguments
        .outputs
        .conclude(&scenario, summary, &trace, &notes)
}
