//! Identification: the one way from the samples of logs, or of a simulated servo, to what is known of the servo.

use std::path::Path;

use log_fit::GoesOn;

use crate::analysis::{Seen, Summariser};
use crate::experiment::Sample;
use crate::found_servo::FoundServo;
use crate::log::Log;
use crate::predict::predict;
use crate::replay::{fitted, replay};
use crate::result::{LogReading, Prediction, ReplayNotes, Summary};
use crate::scenario::{Fault, Scenario};
use crate::simulate;

/// An identification besides its logs.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Passes over the logs, each from the estimates of the previous one.
    pub passes: u32,
    /// Logs that are predicted.
    pub predict: &'a [Log],
    /// A fit ends with its estimates so far where this is false.
    pub goes_on: GoesOn<'a>,
}

impl std::fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut shown = f.debug_struct("Options");
        shown.field("passes", &self.passes).finish_non_exhaustive()
    }
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            passes: 1,
            predict: &[],
            goes_on: &|| true,
        }
    }
}

/// A servo that was identified.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The scenario with what only the logs know.
    pub scenario: Scenario,
    /// The result.
    pub summary: Summary,
    /// The residuals of its model over its samples, from an estimator that fits all of them.
    pub seen: Option<Seen>,
    /// The servo itself, for a [prediction](crate::predict::predict). None if there is none.
    pub found: Option<FoundServo>,
}

/// Identifies the servo of one or more logs by the estimator of a scenario and shows every sample, with its pass, to
/// `observe`.
///
/// # Errors
/// The key that does not suit the logs.
pub fn identify(
    scenario: Scenario,
    logs: &[Log],
    options: &Options<'_>,
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<Identified, Fault> {
    let scenario = fitted(scenario, logs);
    let length: f64 = logs.iter().map(Log::duration).sum();
    let duration = f64::from(options.passes) * length;
    let mut summariser = Summariser::lasting(&scenario, duration);
    let mut last_pass = 0;
    let replayed = replay(&scenario, logs, options.passes, &mut |pass, sample| {
        if pass != last_pass {
            summariser.begin_pass();
            last_pass = pass;
        }
        summariser.add(sample);
        observe(pass, sample);
    })?;
    let (mut seen, mut found) = (None, None);
    if replayed.outcome.abort.is_none() {
        found = if scenario.identifier.law.takes_whole_record() {
            summariser.fit_record(&scenario, options.goes_on)
        } else {
            // A page with the fit of a whole record has no other estimator.
            let terms = &replayed.outcome.terms;
            let of_estimates = || FoundServo::of_estimates(&scenario, &replayed.estimates, terms);
            cfg!(feature = "experiments").then(of_estimates)
        };
        seen = summariser.seen(&scenario);
    }
    let mut predictions = Vec::new();
    // Nor does it predict.
    let to_predict = found.filter(|_| cfg!(feature = "experiments"));
    for (log, found) in options
        .predict
        .iter()
        .filter_map(|log| Some((log, to_predict?)))
    {
        let learnt_from = is_among(logs, log);
        let predicted = predict(&scenario, &found, log)?;
        if let Some(open_loop) = predicted.open_loop.as_ref().filter(|_| !learnt_from) {
            summariser.predicted(open_loop.relative);
        }
        predictions.push(Prediction::new(log, learnt_from, &predicted));
    }
    let mut summary = summariser.finish(&scenario, replayed.outcome);
    let predicted_only = options.predict.iter().filter(|log| !is_among(logs, log));
    summary.replay = ReplayNotes {
        agreement: replayed.agreement,
        logs: logs
            .iter()
            .chain(predicted_only)
            .map(LogReading::new)
            .collect(),
        predictions,
    };
    Ok(Identified {
        scenario,
        summary,
        seen,
        found,
    })
}

/// Identifies the simulated servo of a scenario and shows every sample to `observe`. A fit goes on while `goes_on` is true.
///
/// # Errors
/// The key that something cannot be built from; nothing has been observed then.
pub fn identify_simulated(
    scenario: Scenario,
    goes_on: GoesOn<'_>,
    observe: &mut impl FnMut(&Sample),
) -> Result<Identified, Fault> {
    let mut summariser = Summariser::new(&scenario);
    let outcome = simulate::run(&scenario, &mut |sample| {
        summariser.add(sample);
        observe(sample);
    })?;
    let (mut seen, mut found) = (None, None);
    if outcome.abort.is_none() {
        found = summariser.fit_record(&scenario, goes_on);
        seen = summariser.seen(&scenario);
    }
    let summary = summariser.finish(&scenario, outcome);
    Ok(Identified {
        scenario,
        summary,
        seen,
        found,
    })
}

/// True for a file that is one of the logs.
fn is_among(logs: &[Log], log: &Log) -> bool {
    let file = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let wanted = file(log.path());
    logs.iter().any(|other| file(other.path()) == wanted)
}
