use std::collections::BTreeMap;

use drive_link::NoGains;
use identifier_core::commission::{
    HoldingGains, IdentifiedServo, LargestMotion, Limits, StopReason, TrialResult,
};
use identifier_core::tuning::{Cap, Promise, Tuning};
use serde::Serialize;

use super::{UNKNOWNS, truth, values};
use crate::commission::{Excursion, Outcome, Stretch};
use crate::scenario::Scenario;

/// The result of a commissioning as the command line promises it.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct Document {
    pub status: &'static str,
    pub code: Option<u8>,
    pub phase: Option<&'static str>,
    pub reason: Option<ReasonDocument>,
    pub no_gains: Option<NoGainsDocument>,
    pub arithmetic: &'static str,
    pub sample_time: f64,
    pub samples: u64,
    pub duration: Option<f64>,
    pub phases: Vec<PhaseDocument>,
    pub limits: LimitsDocument,
    pub largest_motion: MotionDocument,
    pub extremes: ExtremesDocument,
    pub servo: Option<BTreeMap<&'static str, UnknownDocument>>,
    pub unexplained: Option<f64>,
    pub truth: Option<BTreeMap<&'static str, f64>>,
    pub gains_before: Option<GainsDocument>,
    pub gains: Option<GainsDocument>,
    pub bandwidth: Option<f64>,
    pub cap: Option<&'static str>,
    pub promise: Option<Promise>,
    pub trial: Option<TrialResult>,
}

/// Why there are no new gains.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct ReasonDocument {
    pub number: u8,
    pub name: &'static str,
    pub cause: &'static str,
    pub remedy: &'static str,
}

/// Why no gains were found, with the figure that would do.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct NoGainsDocument {
    pub message: String,
    pub bandwidth: Option<f64>,
    pub most: Option<f64>,
    pub cap: Option<&'static str>,
}

/// A phase, from when to when.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct PhaseDocument {
    pub phase: &'static str,
    pub begin: f64,
    pub end: f64,
}

/// What it was allowed to do with the axis.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct LimitsDocument {
    pub travel: [f64; 2],
    pub speed: f64,
    pub command: [f64; 2],
    pub duration: f64,
    pub one_way: bool,
}

/// How far and how fast the servo can get.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct MotionDocument {
    pub travel: [f64; 2],
    pub speed: f64,
}

/// How far and how fast it got, in truth, and the commands that acted.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct ExtremesDocument {
    pub position: [f64; 2],
    pub speed: f64,
    pub command: [f64; 2],
}

/// What was identified.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct UnknownDocument {
    pub value: f64,
    pub std_error: f64,
    pub unit: &'static str,
}

/// A PID and the cut-off of its velocity estimate.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/commissioning.md"
)]
pub struct GainsDocument {
    pub kp: f64,
    pub kd: f64,
    pub ki: f64,
    pub cutoff: f64,
}

impl Document {
    /// Of a commissioning that has run.
    #[must_use]
    pub fn new(
        scenario: &Scenario,
        limits: &Limits,
        largest: &LargestMotion,
        before: Option<&HoldingGains>,
        outcome: &Outcome,
    ) -> Self {
        let end = outcome.end.as_ref();
        let named = |values: [f64; 5]| {
            let names = UNKNOWNS.iter().map(|(name, ..)| *name);
            names.zip(values).collect::<BTreeMap<_, _>>()
        };
        let servo = outcome.servo();
        let tuning = outcome.tuning.as_ref();
        Self {
            status: end.map_or("unfinished", |end| end.phase.name()),
            code: end.map(|end| end.reason.map_or(0, StopReason::number)),
            phase: end.map(|end| end.within.name()),
            reason: outcome.reason().map(ReasonDocument::of),
            no_gains: outcome.no_gains.as_ref().map(NoGainsDocument::of),
            arithmetic: scenario.identifier.arithmetic.name(),
            sample_time: scenario.sample_time(),
            samples: outcome.course.samples(),
            duration: end.map(|end| end.time),
            phases: outcome
                .course
                .phases
                .iter()
                .map(PhaseDocument::of)
                .collect(),
            limits: LimitsDocument::of(limits),
            largest_motion: MotionDocument::of(largest),
            extremes: ExtremesDocument::of(&outcome.course.excursion),
            servo: servo.map(UnknownDocument::all_of),
            unexplained: servo.map(|servo| servo.unexplained),
            truth: truth(scenario).map(named),
            gains_before: before.map(GainsDocument::of_before),
            gains: tuning.map(GainsDocument::of),
            bandwidth: tuning.map(|tuning| tuning.bandwidth),
            cap: tuning.and_then(|tuning| tuning.cap).map(Cap::name),
            promise: tuning.map(|tuning| tuning.promise),
            trial: outcome.trial,
        }
    }
}

impl UnknownDocument {
    /// All that was identified, by name.
    pub(crate) fn all_of(servo: &IdentifiedServo) -> BTreeMap<&'static str, Self> {
        let values = values(&servo.parameters, servo.delay);
        let unknowns = UNKNOWNS.iter().zip(values);
        let document = |(&(name, unit, place), value)| {
            let std_error = servo.standard_error(place);
            let unknown = Self {
                value,
                std_error,
                unit,
            };
            (name, unknown)
        };
        unknowns.map(document).collect()
    }
}

impl LimitsDocument {
    pub(crate) fn of(limits: &Limits) -> Self {
        Self {
            travel: limits.travel,
            speed: limits.speed,
            command: limits.command,
            duration: limits.duration,
            one_way: limits.one_way,
        }
    }
}

impl MotionDocument {
    pub(crate) fn of(motion: &LargestMotion) -> Self {
        Self {
            travel: motion.travel,
            speed: motion.speed,
        }
    }
}

impl ReasonDocument {
    pub(crate) fn of(reason: StopReason) -> Self {
        Self {
            number: reason.number(),
            name: reason.name(),
            cause: reason.cause(),
            remedy: reason.remedy(),
        }
    }
}

impl NoGainsDocument {
    pub(crate) fn of(no_gains: &NoGains) -> Self {
        let (bandwidth, most, cap) = match no_gains {
            NoGains::TooFast {
                bandwidth,
                most,
                cap,
            } => (Some(*bandwidth), Some(*most), Some(cap.name())),
            _ => (None, None, None),
        };
        Self {
            message: no_gains.to_string(),
            bandwidth,
            most,
            cap,
        }
    }
}

impl PhaseDocument {
    fn of(stretch: &Stretch) -> Self {
        Self {
            phase: stretch.phase.name(),
            begin: stretch.begin,
            end: stretch.end,
        }
    }
}

impl ExtremesDocument {
    fn of(excursion: &Excursion) -> Self {
        Self {
            position: excursion.position,
            speed: excursion.speed,
            command: excursion.command,
        }
    }
}

impl GainsDocument {
    pub(crate) fn of(tuning: &Tuning) -> Self {
        Self {
            kp: tuning.kp,
            kd: tuning.kd,
            ki: tuning.ki,
            cutoff: tuning.cutoff,
        }
    }

    pub(crate) fn of_before(before: &HoldingGains) -> Self {
        Self {
            kp: before.controller.kp,
            kd: before.controller.kd,
            ki: before.controller.ki,
            cutoff: before.cutoff,
        }
    }
}
