//! Passes of the identifier over a log.

use std::fmt;

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::identifier::IdentifierError;
use identifier_core::measurement::velocity::VelocityEstimate;

use super::declared::Declared;
use super::heard::Ear;
use super::listener::{Told, listener};
use super::recorded::RecordedReference;
use super::{Agreement, Log, LogError};
use crate::experiment::{Outcome, Sample};
use crate::scenario::dispatch::with_velocity;
use crate::scenario::{Closing, Fault, Scenario, Velocity};

/// What a replay found.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    /// What is known of the run.
    pub outcome: Outcome,
    /// How well the declared controller reproduces the recorded command, where there are both.
    pub agreement: Option<Agreement>,
}

/// Why a log cannot be replayed with a scenario.
#[derive(Debug, Clone, PartialEq)]
pub enum ReplayError {
    /// The scenario does not suit the log; nothing has been observed then.
    Scenario {
        /// The key of the scenario that it is best mended at.
        key: String,
        /// What is wrong, and what is allowed.
        fault: String,
    },
    /// The log is no longer what it was when it was judged.
    Log(LogError),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scenario { key, fault } => write!(f, "{key}: {fault}"),
            Self::Log(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ReplayError {}

/// The scenario with what only the log knows: the sample time where no controller is declared, the
/// resolution of the position where no encoder is, and the time over which a first fit looks where
/// the log is shorter than what is usual. A run's own log adds nothing but the last.
#[must_use]
pub fn fitted(mut scenario: Scenario, log: &Log) -> Scenario {
    let own = scenario.is_own_log();
    let stated = &mut scenario.stated;
    if stated.controller.is_none() {
        // The cut-off that follows from a sample time; the resolution is not that of these counts.
        let of_log = Settings::new(log.sample_time, 1.0);
        stated.sample_time = of_log.sample_time;
        stated.cutoff = of_log.cutoff;
    }
    if scenario.counts_per_rev.is_none() && !own {
        stated.resolution = log.resolution();
    }
    let learnt = log.samples - settling(&scenario, log);
    let stated = &mut scenario.stated;
    let most = learnt as f64 * stated.sample_time;
    if (SHORTEST_START..USUAL_START).contains(&most) {
        stated.identifier.start_time.get_or_insert(most);
    }
    scenario
}

/// The samples of a log in which nothing is learnt yet: none if the servo stands at first, for then all
/// is known of its motion; otherwise those in which the velocity estimate settles.
fn settling(scenario: &Scenario, log: &Log) -> u64 {
    /// What a velocity estimate without a pole looks at, and the first row, of which no motion is
    /// known.
    const SEEN: u64 = 3;
    /// Time constants after which a low-pass shows all of a step but 0.7 %.
    const SETTLED: f64 = 5.0;
    /// The most that is given away: this part of the log.
    const MOST: u64 = 10;
    let stated = &scenario.stated;
    if log.begins_at_rest(stated.resolution) {
        return 0;
    }
    let needed = match scenario.velocity {
        Velocity::LowPass => SEEN + (SETTLED / (stated.cutoff * stated.sample_time)) as u64,
        Velocity::Difference | Velocity::AveragedDifference => SEEN,
    };
    needed
        .min((log.samples / MOST).max(SEEN))
        .min(log.samples - 1)
}

/// The time over which the core's first fits look where nobody says, and the least that it takes, s.
const USUAL_START: f64 = 1.0;
const SHORTEST_START: f64 = 1e-4;

/// Runs `passes` passes over a log with a scenario that is [`fitted`] to it and shows every sample to
/// `observe`, with the number of its pass from 0; time goes on from pass to pass.
///
/// # Errors
/// See [`ReplayError`].
pub fn replay(
    scenario: &Scenario,
    log: &Log,
    passes: u32,
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<Replayed, ReplayError> {
    let work = Passes {
        scenario,
        log,
        passes,
        observe,
    };
    with_velocity!(scenario, f64 => run(work)).map_err(|failure| match failure {
        Failure::Scenario(Fault { key, fault, .. }) => ReplayError::Scenario { key, fault },
        Failure::Log(error) => ReplayError::Log(error),
    })
}

fn run<V: VelocityEstimate<f64>>(work: Passes<'_>) -> Result<Replayed, Failure> {
    work.run::<V>()
}

/// Why passes end without a result.
enum Failure {
    Scenario(Fault),
    Log(LogError),
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Self::Scenario(fault)
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        Self::Log(error)
    }
}

struct Passes<'a> {
    scenario: &'a Scenario,
    log: &'a Log,
    passes: u32,
    observe: &'a mut dyn FnMut(u32, &Sample),
}

impl Passes<'_> {
    fn run<V: VelocityEstimate<f64>>(self) -> Result<Replayed, Failure> {
        let Self {
            scenario,
            log,
            passes,
            observe,
        } = self;
        let fault = |error: IdentifierError| scenario.fault(&error);
        let unit = scenario.checked_units()?.position_unit();
        let settings = settings(scenario, log)?;
        let command_recorded = log.first().command.is_some();
        let mut declared = match log.first().reference {
            Some(_) if ran(scenario, &settings, command_recorded) => {
                Some(Declared::<V>::new(&settings, command_recorded).map_err(fault)?)
            }
            _ => None,
        };
        let filter: V = settings.build().map_err(fault)?;
        let mut listener = listener(scenario, &settings)?;
        let mut outcome = listener.outcome();

        let first = log.first();
        let settling = settling(scenario, log);
        'passes: for pass in 0..passes {
            let mut ear = Ear::new(scenario, first.position, unit);
            let mut filtered = V::State::default();
            let mut velocity = 0.0;
            if !command_recorded && let Some(declared) = &mut declared {
                declared.begin();
            }
            for (k, record) in (0..).zip(log.records()?) {
                let record = record?;
                let heard = ear.hear(record);
                let time = f64::from(pass) * log.duration() + record.time - first.time;
                let command = match (record.command, &mut declared) {
                    (Some(command), declared) => {
                        if let Some(declared) = declared.as_mut().filter(|_| pass == 0) {
                            declared.compare(&heard, k >= settling);
                        }
                        Ok(command)
                    }
                    (None, Some(declared)) => declared.process(&heard),
                    // It has been refused when the scenario was read.
                    (None, None) => Err(StepError::CommandNotFinite),
                };
                if k < settling {
                    velocity = filter.process(&mut filtered, heard.increment);
                    if let Err(error) = command {
                        outcome.end_early(time, error);
                        break 'passes;
                    }
                    continue;
                }
                // A pass that is not the first joins where the log begins again.
                if k == settling && (pass > 0 || settling > 0) {
                    listener.join(velocity);
                }
                let told = command.and_then(|command| listener.listen(heard.increment, command));
                let Told { command, seen } = match told {
                    Ok(told) => told,
                    Err(error) => {
                        outcome.end_early(time, error);
                        break 'passes;
                    }
                };
                outcome.count(seen.map(|(_, event)| event));
                let sample = Sample {
                    time,
                    reference: record.reference.unwrap_or(f64::NAN),
                    position: record.position,
                    command,
                    output_error: seen.map(|(error, _)| error * unit),
                    estimates: listener.estimates(),
                    standard_errors: listener.standard_errors(),
                    at_bounds: listener.at_bounds(),
                };
                observe(pass, &sample);
            }
        }
        let known = listener.outcome();
        outcome.bandwidth = known.bandwidth;
        outcome.entered = known.entered;
        outcome.terms = known.terms;
        Ok(Replayed {
            outcome,
            agreement: declared.and_then(|declared| declared.agreement()),
        })
    }
}

/// What the core builds identifier and controller from: for a run's own log what it was for the run.
fn settings(scenario: &Scenario, log: &Log) -> Result<Settings, Fault> {
    let settings = if scenario.is_own_log() {
        scenario.settings_for(Some(&scenario.reference::<f64>()?))
    } else {
        let units = scenario.checked_units()?;
        scenario.settings_for(RecordedReference::new(log, units.position()).as_ref())
    };
    settings.map_err(|error| scenario.fault(&error))
}

/// Whether the declared controller is the one whose command the log has, or would have.
fn ran(scenario: &Scenario, settings: &Settings, command_recorded: bool) -> bool {
    let closes_its_own = matches!(
        scenario.identifier.law.closing(),
        Closing::Relay | Closing::TwoDegreesOfFreedom
    );
    let other = scenario.is_own_log() && closes_its_own && command_recorded;
    settings.controller.is_some() && !other
}
