//! Identification from logs by a recursive estimator.

use identifier_log::FoundServo;
use identifier_log::experiment::Sample;
use identifier_log::log::Log;
use identifier_log::predict::predict_logs;
use identifier_log::result::{LogReading, ReplayNotes, Summary};

use super::passes::{Replayed, replay};
use crate::analysis::Summariser;
use crate::scenario::{Fault, Scenario};

/// Identifies the servo of one or more logs by the estimator of a scenario that is [`fitted`](super::fitted) to them, in
/// so many passes. It predicts the logs of `predictions`, and shows every sample to `observe`, with the number of its
/// pass from 0.
///
/// # Errors
/// The key that does not suit the logs.
pub fn identify(
    scenario: &Scenario,
    logs: &[Log],
    predictions: &[Log],
    passes: u32,
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<(Summary, Option<FoundServo>), Fault> {
    let length: f64 = logs.iter().map(Log::duration).sum();
    let mut summariser = Summariser::lasting(scenario, f64::from(passes) * length);
    let mut current = 0;
    let Replayed {
        outcome,
        agreement,
        estimates,
    } = replay(scenario, logs, passes, &mut |pass, sample| {
        if pass != current {
            summariser.begin_pass();
            current = pass;
        }
        summariser.add(sample);
        observe(pass, sample);
    })?;
    let found = (outcome.abort.is_none())
        .then(|| FoundServo::of_estimates(scenario, &estimates, &outcome.terms));
    let predicted = predict_logs(scenario, found.as_ref(), logs, predictions)?;
    if let Some(error) = predicted.largest_error {
        summariser.predicted(error);
    }
    let mut summary = summariser.finish(scenario, outcome);
    summary.replay = ReplayNotes {
        agreement,
        logs: LogReading::all(logs, predictions),
        predictions: predicted.predictions,
    };
    Ok((summary, found))
}
