//! The result of a drive's commissioning, as JSON.

use drive_link::{NoGains, Outcome};
use identifier_core::commission::{
    CommissionSettings, HoldingGains, LargestMotion, Limits, Reason, TrialResult,
};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::tuning::{Cap, Promise};
use serde::Serialize;

use crate::result::{Gains, commissioning as keys};

/// The result of a drive's commissioning: those keys of a simulated one's that a drive knows, and whether it was
/// saved.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct CommissionDocument {
    pub status: &'static str,
    pub code: u8,
    #[serde(serialize_with = "keys::reason")]
    pub reason: Option<Reason>,
    #[serde(serialize_with = "keys::no_gains")]
    pub no_gains: Option<NoGains>,
    pub kept: bool,
    pub sample_time: f64,
    pub limits: Limits,
    #[serde(serialize_with = "keys::motion")]
    pub largest_motion: LargestMotion,
    #[serde(serialize_with = "keys::servo")]
    pub servo: Option<IdentifiedServo>,
    pub unexplained: Option<f64>,
    pub gains_before: Option<Gains>,
    pub gains: Option<Gains>,
    pub bandwidth: Option<f64>,
    pub cap: Option<&'static str>,
    pub promise: Option<Promise>,
    pub trial: Option<TrialResult>,
}

impl CommissionDocument {
    /// Of a commissioning that is over.
    #[must_use]
    pub fn new(
        order: &CommissionSettings,
        largest: &LargestMotion,
        before: Option<&HoldingGains>,
        outcome: &Outcome,
    ) -> Self {
        let reason = outcome.commissioning.reason;
        let tuning = outcome.tuning.as_ref();
        Self {
            status: outcome.commissioning.phase.name(),
            code: reason.map_or(0, Reason::number),
            reason,
            no_gains: outcome.no_gains.clone(),
            kept: outcome.kept,
            sample_time: order.sample_time,
            limits: order.limits,
            largest_motion: *largest,
            servo: outcome.servo,
            unexplained: outcome.servo.map(|servo| servo.unexplained),
            gains_before: before.map(Gains::holding),
            gains: tuning.map(Gains::tuned),
            bandwidth: tuning.map(|tuning| tuning.bandwidth),
            cap: tuning.and_then(|tuning| tuning.cap).map(Cap::name),
            promise: tuning.map(|tuning| tuning.promise),
            trial: outcome.trial,
        }
    }
}
