//! Passes of an estimator over a log.

use identifier_core::Settings;
use identifier_core::excitation::Excitation;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::parameters::ServoParameters;
use identifier_log::experiment::{Outcome, Sample};
use identifier_log::log::Log;
use identifier_log::replay::{Agreement, Player, Stopped};
use identifier_log::with_velocity;

use crate::scenario::{Fault, LoopKind, Scenario};
use crate::simulate::identifier;

/// The result of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    /// The outcome of the run.
    pub outcome: Outcome,
    /// Agreement of the declared controller with the recorded command, where there are both.
    pub agreement: Option<Agreement>,
    /// The estimates at the end, SI.
    pub estimates: ServoParameters,
}

/// The scenario completed from the logs, as [`Options::fitted`](identifier_log::scenario::Options::fitted).
#[must_use]
pub fn fitted(mut scenario: Scenario, logs: &[Log]) -> Scenario {
    let own = scenario.is_log_of_simulated_run();
    scenario.options = scenario.options.fitted(logs, own);
    scenario
}

/// Runs `passes` passes over logs of one servo, one after the other, with a scenario that is [`fitted`] to them. It
/// shows every sample to `observe`, with the number of its pass from 0. Behind a break the model joins the motion that
/// it finds, and the estimates are kept.
///
/// # Errors
/// The key that does not suit the logs; nothing has been observed then.
pub fn replay(
    scenario: &Scenario,
    logs: &[Log],
    passes: u32,
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<Replayed, Fault> {
    with_velocity!(scenario, f64 => run(scenario, logs, passes, observe))
}

fn run<V: VelocityEstimate<f64>>(
    scenario: &Scenario,
    logs: &[Log],
    passes: u32,
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<Replayed, Fault> {
    let Some(log) = logs.first() else {
        return Err(Fault::new("log", "there is no log"));
    };
    let settings = settings(scenario, log)?;
    let command_recorded = log.first().command.is_some();
    let is_declared = log.first().reference.is_some() && ran(scenario, &settings, command_recorded);
    let mut identifier = identifier(scenario, &settings)?;
    let mut outcome = identifier.outcome();
    let mut player = Player::<V>::new(scenario, &settings, is_declared, command_recorded)?;
    let unit = player.unit();
    let played = player.play(scenario, logs, passes, &mut |played| {
        let (row, input) = (played.row, played.input);
        identifier.join(&input);
        let step = identifier.step(input.increment, input.command, None)?;
        outcome.count(step.event);
        let reference = row.reference.unwrap_or(f64::NAN);
        let begins = input.beginning.is_some();
        let sample = step.sample(played.time, begins, reference, row.position, unit);
        observe(played.pass, &sample);
        Ok(())
    });
    if let Err(Stopped { time, error }) = played {
        outcome.end_early(time, error);
    }
    Ok(Replayed {
        outcome: Outcome {
            samples: outcome.samples,
            events: outcome.events,
            abort: outcome.abort,
            ..identifier.outcome()
        },
        agreement: player.agreement(),
        estimates: identifier.estimates(),
    })
}

/// The settings of identifier and controller: for a run's own log those of the run.
fn settings(scenario: &Scenario, log: &Log) -> Result<Settings, Fault> {
    if scenario.is_log_of_simulated_run() {
        return scenario.settings();
    }
    let units = scenario.checked_units()?;
    scenario.settings_for(RecordedReference::new(log, units.position()).as_ref())
}

/// True if the declared controller is the one whose command the log has, or would have.
fn ran(scenario: &Scenario, settings: &Settings, command_recorded: bool) -> bool {
    let closes_its_own = scenario.identifier.law.closing() == LoopKind::Relay;
    let other = scenario.is_log_of_simulated_run() && closes_its_own && command_recorded;
    settings.controller.is_some() && !other
}

/// Plays the recorded reference, machine units from the first position; holds its last value.
pub(super) struct RecordedReference<'a> {
    references: &'a [f64],
    first: f64,
    per_unit: f64,
}

impl<'a> RecordedReference<'a> {
    /// The reference of a log, if it has one, in position units, `per_unit` of them per rad.
    pub(super) fn new(log: &'a Log, per_unit: f64) -> Option<Self> {
        let references = log.references();
        (!references.is_empty()).then_some(Self {
            references,
            first: log.first().position,
            per_unit,
        })
    }
}

impl Excitation<f64> for RecordedReference<'_> {
    type State = usize;

    fn start(&self) -> usize {
        0
    }

    fn process(&self, next: &mut usize) -> f64 {
        let index = (*next).min(self.references.len() - 1);
        *next += 1;
        (self.references[index] - self.first) * self.per_unit
    }
}
