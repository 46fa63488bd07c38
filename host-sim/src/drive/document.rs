//! What a drive's commissioning came to, as JSON.

use std::collections::BTreeMap;

use drive_link::Outcome;
use identifier_core::commission::{
    CommissionSettings, HoldingGains, LargestMotion, StopReason, TrialResult,
};
use identifier_core::tuning::{Cap, Promise};
use serde::Serialize;

use crate::report::commission::document::{
    GainsDocument, LimitsDocument, MotionDocument, NoGainsDocument, ReasonDocument, UnknownDocument,
};

/// The result of a drive's commissioning: the keys of a simulated one's that a drive can tell, and whether
/// it is kept.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct CommissionDocument {
    pub status: &'static str,
    pub code: u8,
    pub reason: Option<ReasonDocument>,
    pub no_gains: Option<NoGainsDocument>,
    pub kept: bool,
    pub sample_time: f64,
    pub limits: LimitsDocument,
    pub largest_motion: MotionDocument,
    pub servo: Option<BTreeMap<&'static str, UnknownDocument>>,
    pub unexplained: Option<f64>,
    pub gains_before: Option<GainsDocument>,
    pub gains: Option<GainsDocument>,
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
            code: reason.map_or(0, StopReason::number),
            reason: reason.map(ReasonDocument::of),
            no_gains: outcome.no_gains.as_ref().map(NoGainsDocument::of),
            kept: outcome.kept,
            sample_time: order.sample_time,
            limits: LimitsDocument::of(&order.limits),
            largest_motion: MotionDocument::of(largest),
            servo: outcome.servo.as_ref().map(UnknownDocument::all_of),
            unexplained: outcome.servo.map(|servo| servo.unexplained),
            gains_before: before.map(GainsDocument::of_before),
            gains: tuning.map(GainsDocument::of),
            bandwidth: tuning.map(|tuning| tuning.bandwidth),
            cap: tuning.and_then(|tuning| tuning.cap).map(Cap::name),
            promise: tuning.map(|tuning| tuning.promise),
            trial: outcome.trial,
        }
    }
}
