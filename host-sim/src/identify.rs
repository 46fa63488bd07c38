//! Identification by the estimator of a scenario, from a simulated run or from logs.

use identifier_log::analysis::Seen;
use identifier_log::experiment::Sample;
use identifier_log::log::Log;
use identifier_log::result::{LogReading, ReplayNotes, Summary};
use identifier_log::{FoundServo, Identified, RecordedSamples, predict_logs};

use crate::analysis::Summariser;
use crate::replay::{fitted, replay};
use crate::scenario::{Fault, Scenario};
use crate::simulate;

/// What an estimator found.
#[derive(Debug, Clone)]
pub struct IdentifiedScenario {
    /// The scenario with what only the logs know.
    pub scenario: Scenario,
    /// The result.
    pub summary: Summary,
    /// The residuals of a fit; none of another estimator, or if nothing explains the samples.
    pub seen: Option<Seen>,
    /// The servo itself, of logs. None if there is none.
    pub servo: Option<FoundServo>,
}

impl IdentifiedScenario {
    fn by_fit(
        mut scenario: Scenario,
        found: Identified,
        observe: &mut dyn FnMut(u32, &Sample),
    ) -> Self {
        for sample in found.samples() {
            observe(0, &sample);
        }
        let truth = scenario.plant;
        scenario.options = found.options;
        Self {
            scenario,
            summary: Summary {
                truth,
                ..found.summary
            },
            seen: found.seen,
            servo: found.found,
        }
    }
}

/// Identifies the servo of one or more logs, in so many passes if the estimator is recursive. It predicts the logs of
/// `predictions` and shows every sample to `observe`, with the number of its pass from 0. A fit goes on while `goes_on`
/// is true.
///
/// # Errors
/// The key that does not suit the logs.
pub fn identify_logs(
    scenario: Scenario,
    logs: &[Log],
    predictions: &[Log],
    passes: u32,
    goes_on: &(dyn Fn() -> bool + Sync),
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<IdentifiedScenario, Fault> {
    let scenario = fitted(scenario, logs);
    if scenario.identifier.law.takes_whole_record() {
        let found = identifier_log::identify(logs, predictions, &scenario, goes_on)?;
        return Ok(IdentifiedScenario::by_fit(scenario, found, observe));
    }
    let length: f64 = logs.iter().map(Log::duration).sum();
    let mut summariser = Summariser::lasting(&scenario, f64::from(passes) * length);
    let mut current = 0;
    let replayed = replay(&scenario, logs, passes, &mut |pass, sample| {
        if pass != current {
            summariser.begin_pass();
            current = pass;
        }
        summariser.add(sample);
        observe(pass, sample);
    })?;
    let outcome = replayed.outcome;
    let servo = (outcome.abort.is_none())
        .then(|| FoundServo::of_estimates(&scenario, &replayed.estimates, &outcome.terms));
    let predicted = predict_logs(&scenario, servo.as_ref(), logs, predictions)?;
    if let Some(error) = predicted.largest_error {
        summariser.predicted(error);
    }
    let mut summary = summariser.finish(&scenario, outcome);
    summary.replay = ReplayNotes {
        agreement: replayed.agreement,
        logs: LogReading::all(logs, predictions),
        predictions: predicted.predictions,
    };
    Ok(IdentifiedScenario {
        scenario,
        summary,
        seen: None,
        servo,
    })
}

/// Runs a scenario and identifies its servo. See [`identify_logs`].
///
/// # Errors
/// The key that something cannot be built from; nothing has been observed then.
pub fn identify_run(
    scenario: Scenario,
    goes_on: &(dyn Fn() -> bool + Sync),
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<IdentifiedScenario, Fault> {
    if scenario.identifier.law.takes_whole_record() {
        let mut recorded = RecordedSamples::default();
        let outcome = simulate::run(&scenario, &mut |sample| recorded.add(sample))?;
        let unstable = scenario.unstable_loop();
        let found = identifier_log::identify_run(&scenario, recorded, outcome, unstable, goes_on);
        return Ok(IdentifiedScenario::by_fit(scenario, found, observe));
    }
    let mut summariser = Summariser::new(&scenario);
    let outcome = simulate::run(&scenario, &mut |sample| {
        summariser.add(sample);
        observe(0, sample);
    })?;
    Ok(IdentifiedScenario {
        summary: summariser.finish(&scenario, outcome),
        scenario,
        seen: None,
        servo: None,
    })
}
