use std::path::{Path, PathBuf};

use super::call;
use super::fault::Fault;
use super::output::{Notes, Outputs};
use crate::replay::{self, Log, ReplayError};
use crate::report::logs::{LogDocument, PredictionDocument};
use crate::scenario::{Purpose, Scenario, keys};

#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("Keys of a scenario:\n{}", keys::listing()))]
pub(super) struct Arguments {
    /// The log, a file, .csv or .csv.gz: what `run --csv` wrote, or what a drive recorded. Of several,
    /// all of one servo, each goes on from the estimates of the one before.
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// The scenario of the run that wrote the log; for any other log one with [log]: identifier, the
    /// log's columns, and the controller that ran where the log has no command.
    #[arg(long, value_name = "SCENARIO.toml")]
    scenario: PathBuf,
    /// Another log of the servo: nothing is learnt from it, and the estimates must predict it.
    /// May be given again.
    #[arg(long, value_name = "LOG")]
    predict: Vec<PathBuf>,
    /// Passes over the logs, each from the estimates of the one before.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    passes: u32,
    #[command(flatten)]
    outputs: Outputs,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Fault> {
    let Arguments {
        logs,
        scenario,
        predict,
        passes,
        outputs,
    } = arguments;
    let of_replay = |error: ReplayError| match error {
        ReplayError::Scenario { .. } => Fault::of_scenario(&arguments.scenario, error),
        ReplayError::Log(error) => Fault::Input(error.to_string()),
    };
    let scenario = Scenario::load(scenario, Purpose::Replay)?;
    let read = logs.iter().chain(predict);
    let inputs = read.chain([&arguments.scenario]).map(PathBuf::as_path);
    let title = call::title("Replay of", &logs[0]);
    let mut results = outputs.begin(title, &inputs.collect::<Vec<_>>())?;
    let all = read_all(logs.iter().chain(predict), &scenario)?;
    let (learnt, predicted) = all.split_at(logs.len());
    let scenario = replay::fitted(scenario, learnt);

    let length: f64 = learnt.iter().map(Log::duration).sum();
    let mut recording = results.record(&scenario, f64::from(*passes) * length, *passes);
    let mut pass_shown = 0;
    let replayed = replay::replay(&scenario, learnt, *passes, &mut |pass, sample| {
        if pass != pass_shown {
            recording.begin_pass();
            pass_shown = pass;
        }
        recording.add(sample);
    })
    .map_err(of_replay)?;
    let is_learnt = |log: &Log| {
        let mut others = learnt.iter().map(Log::path);
        others.any(|other| is_same(other, log.path()))
    };
    let mut predictions = Vec::new();
    if replayed.outcome.abort.is_none() {
        for log in predicted {
            let seen = is_learnt(log);
            let predicted = replay::predict(&scenario, &replayed, log).map_err(of_replay)?;
            if let Some(open_loop) = predicted.open_loop.filter(|_| !seen) {
                recording.predicted(open_loop.relative);
            }
            predictions.push(PredictionDocument::new(log, seen, &predicted));
        }
    }
    let notes = Notes {
        agreement: replayed.agreement,
        logs: learnt
            .iter()
            .chain(predicted.iter().filter(|log| !is_learnt(log)))
            .map(LogDocument::new)
            .collect(),
        predictions,
    };
    results.conclude(&scenario, recording, replayed.outcome, notes)
}

/// Reads logs that must have one sample time.
fn read_all<'a>(
    paths: impl Iterator<Item = &'a PathBuf>,
    scenario: &Scenario,
) -> Result<Vec<Log>, Fault> {
    /// How far sample times may differ, relative.
    const ALIKE: f64 = 0.01;
    let mut logs: Vec<Log> = Vec::new();
    for path in paths {
        let log = Log::read(path, &scenario.log_columns(), scenario.log_sample_time())
            .map_err(|error| Fault::Input(error.to_string()))?;
        if let Some(first) = logs.first()
            && (log.sample_time / first.sample_time - 1.0).abs() > ALIKE
        {
            return Err(Fault::Input(format!(
                "{}: its samples are {} s apart, those of {} {} s: logs that are replayed together \
                 must have one sample time; replay them one by one",
                path.display(),
                log.sample_time,
                first.path().display(),
                first.sample_time
            )));
        }
        logs.push(log);
    }
    Ok(logs)
}

fn is_same(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => one == other,
    }
}
