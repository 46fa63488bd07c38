//! The results of a drive, serialised unchanged: its fields are the keys of `--json`.

use commissioning::servo_change::ServoChange;
use drive_link::{Commissioning, Estimates, InterruptCycles, Outcome, State, Status};
use host_sim::result::{CommissioningEnd, CommissioningOutcome, Untuned};
use identifier_core::reason::Reason;
use identifier_log::result::Gains;
use serde::{Serialize, Serializer};

/// The result of a drive's commissioning.
#[derive(Debug, Clone, Serialize)]
pub struct DriveCommissioningResult {
    /// Its end.
    #[serde(flatten)]
    pub end: CommissioningEnd,
    /// True if the gains survive a loss of power.
    pub kept: bool,
}

/// What a drive's commissioning found.
#[must_use]
pub fn commissioning_outcome(outcome: &Outcome) -> CommissioningOutcome {
    let Commissioning { phase, reason } = outcome.commissioning;
    CommissioningOutcome {
        phase,
        reason,
        servo: outcome.servo,
        tuning: outcome.tuning,
        untuned: outcome.no_gains.as_ref().map(Untuned::from),
        trial: outcome.trial,
        noise: outcome.noise,
    }
}

/// The state of a drive.
#[derive(Debug, Clone, Serialize)]
pub struct DriveStatus {
    /// `disabled`, `running`, `commissioning` or `faulted`.
    pub status: &'static str,
    /// Number of the fault; 0 without one.
    pub code: u8,
    /// The fault that holds.
    #[serde(serialize_with = "identifier_log::result::serialize_reason")]
    pub reason: Option<Reason>,
    /// The drive simulates its servo, and no motor is driven.
    pub simulated: bool,
    /// From the edge of the home switch to the index pulse, rad.
    pub index_from_edge: Option<f32>,
    /// Estimates of the servo, of this run or of the last.
    pub estimates: Option<Estimates>,
    /// Standard deviation of the encoder's noise in motion by the run's first fit, encoder counts; rounding alone is 0.29.
    pub noise_counts: Option<f32>,
    /// The gains in force.
    pub gains: Option<Gains>,
    /// How the servo differs from the one for which the gains' prediction holds.
    #[serde(serialize_with = "change")]
    pub servo_change: Option<ServoChange>,
    /// Cycles of the sample interrupt: `last`, and `longest` since the start. None where no counter runs.
    pub interrupt_cycles: Option<InterruptCycles>,
}

impl From<&Status> for DriveStatus {
    fn from(status: &Status) -> Self {
        let (state, reason) = match status.state {
            State::Disabled => ("disabled", None),
            State::Running => ("running", None),
            State::Commissioning => ("commissioning", None),
            State::Faulted(fault) => ("faulted", Some(fault)),
        };
        Self {
            status: state,
            code: reason.map_or(0, Reason::number),
            reason,
            simulated: status.simulated,
            index_from_edge: status.index_from_edge,
            estimates: status.estimates,
            noise_counts: status.noise,
            gains: status
                .gains
                .map(|gains| Gains::of(&gains.controller, gains.cutoff)),
            servo_change: status.servo_change,
            interrupt_cycles: status.interrupt_cycles,
        }
    }
}

fn change<S: Serializer>(change: &Option<ServoChange>, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Keys {
        #[serde(serialize_with = "identifier_log::result::serialize_reason")]
        reason: Option<Reason>,
        predicted: f64,
        found: f64,
        standard_errors: f64,
    }
    let keys = change.map(|change| Keys {
        reason: Some(change.reason),
        predicted: change.predicted,
        found: change.found,
        standard_errors: change.standard_errors,
    });
    keys.serialize(serializer)
}
