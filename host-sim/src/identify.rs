//! Identification from logs: the one way from their samples to what is known of the servo.

use crate::analysis::{Seen, Summariser};
use crate::experiment::Sample;
use crate::found_servo::FoundServo;
use identifier_log::log::Log;
use crate::replay::{fitted, replay};
use crate::result::{LogReading, ReplayNotes, Summary};
use crate::scenario::{Fault, Scenario};

/// A servo identified from its logs.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The scenario with what only the logs know.
    pub scenario: Scenario,
    /// The result.
    pub summary: Summary,
    /// The residuals of its model over the logs, from an estimator that fits all of them.
    pub seen: Option<Seen>,
    /// The servo itself, for a [prediction](crate::predict::predict). None if there is none.
    pub found: Option<FoundServo>,
}

/// Identifies the servo of one or more logs by the estimator of a scenario and shows every sample to `observe`.
///
/// # Errors
/// The key that does not suit the logs.
pub fn identify(
    scenario: Scenario,
    logs: &[Log],
    observe: &mut dyn FnMut(&Sample),
) -> Result<Identified, Fault> {
    let scenario = fitted(scenario, logs);
    let duration = logs.iter().map(Log::duration).sum();
    let mut summariser = Summariser::lasting(&scenario, duration);
    let replayed = replay(&scenario, logs, 1, &mut |_, sample| {
        summariser.add(sample);
        observe(sample);
    })?;
    let (mut seen, mut found) = (None, None);
    if replayed.outcome.abort.is_none() {
        seen = summariser.seen(&scenario);
        found = if scenario.identifier.law.takes_whole_record() {
            summariser.fit_record(&scenario, &|| true)
        } else {
            // A page with the fit of a whole record has no other estimator.
            let terms = &replayed.outcome.terms;
            let of_estimates = || FoundServo::of_estimates(&scenario, &replayed.estimates, terms);
            cfg!(feature = "experiments").then(of_estimates)
        };
    }
    let mut summary = summariser.finish(&scenario, replayed.outcome);
    summary.replay = ReplayNotes {
        agreement: replayed.agreement,
        logs: logs.iter().map(LogReading::new).collect(),
        predictions: Vec::new(),
    };
    Ok(Identified {
        scenario,
        summary,
        seen,
        found,
    })
}
