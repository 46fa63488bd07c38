//! Passes of the identifier over a log.

use identifier_core::Settings;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::SettingsError;

use super::Agreement;
use super::declared::Declared;
use super::progress::{InSegment, Progress};
use super::recorded::RecordedReference;
use super::settling::{MIN_SETTLING, settling_in_motion};
use crate::experiment::{Outcome, Sample};
use identifier_log::log::{Log, Segment};
use crate::scenario::dispatch::with_velocity;
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

/// The scenario completed from the logs. They give the sample time if no controller is declared, and the resolution of
/// the position if no encoder is. They also give the time window of a first fit if the longest segment is shorter than
/// usual. A run's own log adds nothing but the last. The first log counts where they differ.
#[must_use]
pub fn fitted(mut scenario: Scenario, logs: &(impl AsRef<[Log]> + ?Sized)) -> Scenario {
    let logs = logs.as_ref();
    let Some(log) = logs.first() else {
        return scenario;
    };
    let own = scenario.is_log_of_simulated_run();
    sampled_every(&mut scenario, log.sample_time);
    if scenario.counts_per_rev.is_none() && !own {
        scenario.stated.resolution = log.resolution();
    }
    let segments = logs.iter().flat_map(Log::segments);
    let learnt = segments.map(|segment| segment.samples - settling(&scenario, segment));
    let most = learnt.max().unwrap_or(0) as f64 * scenario.sample_time();
    if (MIN_START_TIME..DEFAULT_START_TIME).contains(&most) {
        let stated = &mut scenario.stated;
        stated.identifier.start_time.get_or_insert(most);
    }
    scenario
}

/// Gives a scenario the sample time of a log, s, where no controller declares one.
pub(super) fn sampled_every(scenario: &mut Scenario, sample_time: f64) {
    let stated = &mut scenario.stated;
    if stated.controller.is_none() {
        // The cut-off that follows from a sample time; the resolution is not that of these counts.
        let of_log = Settings::new(sample_time, 1.0);
        stated.sample_time = of_log.sample_time;
        stated.cutoff = of_log.cutoff;
    }
}

/// The samples of a segment without learning. There are none if the servo starts at standstill, because its motion is
/// then fully known. Otherwise they are those in which the velocity estimate settles.
pub(super) fn settling(scenario: &Scenario, segment: &Segment) -> u64 {
    /// At most this fraction of a segment, one over, is spent on settling.
    const SETTLING_DIVISOR: u64 = 10;
    if segment.begins_at_rest(scenario.stated.resolution) {
        return 0;
    }
    settling_in_motion(scenario)
        .min((segment.samples / SETTLING_DIVISOR).max(MIN_SETTLING))
        .min(segment.samples - 1)
}

/// The default time of the core's first fits, and the shortest that it takes, s.
const DEFAULT_START_TIME: f64 = 1.0;
const MIN_START_TIME: f64 = 1e-4;

/// Runs `passes` passes over logs of one servo, one after the other, with a scenario that is [`fitted`] to them. It
/// shows every sample to `observe`, with the number of its pass from 0. Its time continues from log to log and from
/// pass to pass, without the ranges that are left out. Behind a break the model joins the motion that it finds, and the
/// estimates are kept.
///
/// # Errors
/// The key that does not suit the logs; nothing has been observed then.
pub fn replay(
    scenario: &Scenario,
    logs: &(impl AsRef<[Log]> + ?Sized),
    passes: u32,
    observe: &mut dyn FnMut(u32, &Sample),
) -> Result<Replayed, Fault> {
    with_velocity!(scenario, f64 => run(scenario, logs.as_ref(), passes, observe))
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
    let fault = |error: SettingsError| scenario.fault(&error);
    let unit = scenario.checked_units()?.position_unit();
    let settings = settings(scenario, log)?;
    let command_recorded = log.first().command.is_some();
    let declared = match log.first().reference {
        Some(_) if ran(scenario, &settings, command_recorded) => {
            Some(Declared::<V>::new(&settings, command_recorded).map_err(fault)?)
        }
        _ => None,
    };
    let identifier = identifier(scenario, &settings)?;
    let mut progress = Progress {
        outcome: identifier.outcome(),
        identifier,
        declared,
        filter: settings
            .velocity::<f64, V>()
            .map_err(|error| fault(error.into()))?,
        unit,
        revolution: scenario.stated.identifier.terms.revolution,
        time: 0.0,
        begun: false,
    };
    'passes: for pass in 0..passes {
        for (number, log) in logs.iter().enumerate() {
            let mut segments = log.segments().iter();
            let mut on: Option<InSegment<V>> = None;
            for row in log.rows() {
                if row.begins || on.is_none() {
                    let settling = segments
                        .next()
                        .map_or(0, |segment| settling(scenario, segment));
                    if let Some(before) = on.take() {
                        progress.time += before.samples as f64 * log.sample_time;
                    }
                    progress.begin(pass == 0 || !command_recorded);
                    on = Some(InSegment::new(scenario, row, unit, settling));
                }
                let Some(on) = &mut on else { continue };
                match progress.process(on, row, number, pass) {
                    Ok(Some(sample)) => observe(pass, &sample),
                    Ok(None) => {}
                    Err(error) => {
                        progress.outcome.end_early(progress.time_of(on, row), error);
                        break 'passes;
                    }
                }
            }
            progress.time += on.map_or(0, |on| on.samples) as f64 * log.sample_time;
        }
    }
    let Progress {
        outcome: run,
        identifier,
        declared,
        ..
    } = progress;
    Ok(Replayed {
        outcome: Outcome {
            samples: run.samples,
            events: run.events,
            abort: run.abort,
            ..identifier.outcome()
        },
        agreement: declared.and_then(|declared| declared.agreement()),
        estimates: identifier.estimates(),
    })
}

/// The settings of identifier and controller: for a run's own log those of the run.
fn settings(scenario: &Scenario, log: &Log) -> Result<Settings, Fault> {
    let settings = if scenario.is_log_of_simulated_run() {
        scenario.settings_for(Some(&scenario.reference::<f64>()?))
    } else {
        let units = scenario.checked_units()?;
        scenario.settings_for(RecordedReference::new(log, units.position()).as_ref())
    };
    settings.map_err(|error| scenario.fault(&error))
}

/// True if the declared controller is the one whose command the log has, or would have.
fn ran(scenario: &Scenario, settings: &Settings, command_recorded: bool) -> bool {
    let closes_its_own = scenario.identifier.law.closing() == LoopKind::Relay;
    let other = scenario.is_log_of_simulated_run() && closes_its_own && command_recorded;
    settings.controller.is_some() && !other
}
