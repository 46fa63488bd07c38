use std::fmt;

use identifier_core::parameters::{Tolerance, Unknown};
use identifier_core::reason::Reason;
use log_fit::SEPARATED;
use serde::Serialize;

use crate::motion_unit::{AxisKind, MotionUnit};

use super::{Evidence, UnknownEvidence, VerdictReason};

/// The reliability of estimates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    /// Every estimate is within tolerance and settled, no missing effect was found, and no unit is assumed.
    Converged,
    /// The gain is known, and another unknown is not: the motion says too little of it.
    Partial,
    /// The estimates keep still, but the model lacks something that moves them.
    Unexplained,
    /// The data say too little of an unknown, whatever its estimate.
    NoInformation,
    /// Some estimate still moves.
    Moving,
    /// The run ended early.
    Aborted,
}

impl Status {
    /// Its name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Partial => "partial",
            Self::Unexplained => "unexplained",
            Self::NoInformation => "no-information",
            Self::Moving => "moving",
            Self::Aborted => "aborted",
        }
    }
}

/// A status with its reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The status.
    pub status: Status,
    /// The evidence that led to it.
    pub reason: VerdictReason,
}

/// The standard error up to which an unknown is within tolerance. It is wider than [`Tolerance::STD_ERROR`] because it
/// contains model errors and not chance alone. An interval of two of them is 8 % of b, 20 % of friction or load, or 1 %
/// of the acceleration by the command.
const MAX_STD_ERROR: Tolerance = Tolerance {
    gain: 0.04,
    force: [0.1, 0.005],
    other: [0.1, 0.025],
};

/// The change up to which an estimate counts as settled.
const MAX_MOVEMENT: Tolerance = Tolerance {
    gain: 0.02,
    force: [0.04, 0.003],
    other: [0.02, 0.003],
};

/// The distance up to which an estimate is where the data say. It does not grow with the standard error, which holds model
/// errors and not chance alone.
const MAX_REFIT_DIFFERENCE: Tolerance = Tolerance {
    gain: 0.02,
    force: [0.08, 0.003],
    other: [0.05, 0.01],
};

/// The same for a refit with an effect that the estimator's model lacks. Its difference is no chance.
const MAX_SHIFT: Tolerance = Tolerance {
    force: [0.08, 0.001],
    ..MAX_REFIT_DIFFERENCE
};

/// Minimum samples for a verdict.
const MIN_SAMPLES: u64 = 100;

/// Encoder counts that must have been travelled, forth and back, before anything can be known.
pub const MIN_TRAVEL_COUNTS: f64 = 20.0;

/// The prediction error from which estimates do not hold outside the data that they come from.
const MAX_PREDICTION_ERROR: f64 = 0.1;

/// The same for a model that explains its own data down to the encoder. Without a loop the least error of an estimate
/// accumulates.
const MAX_ACCUMULATED_ERROR: f64 = 0.3;

impl Verdict {
    /// True if no estimate means anything.
    #[must_use]
    pub const fn hides_all(&self) -> bool {
        let is_a_guess = matches!(self.status, Status::NoInformation)
            && matches!(self.reason, VerdictReason::NotSeparated { .. });
        is_a_guess || self.reason.hides_all()
    }

    /// The verdict on the evidence. If several facts speak against the estimates, the first to be corrected is the
    /// reason.
    #[must_use]
    pub fn on(evidence: &Evidence) -> Self {
        let (status, reason) = aborted(evidence)
            .or_else(|| without_estimate(evidence))
            .or_else(|| stopped(evidence))
            .or_else(|| not_separated(evidence))
            .or_else(|| not_entered(evidence))
            .or_else(|| lacking(evidence))
            .or_else(|| {
                not_excited(evidence).filter(|(status, _)| *status == Status::NoInformation)
            })
            .or_else(|| loop_differs(evidence))
            .or_else(|| scales_differ(evidence))
            .or_else(|| moving(evidence))
            .or_else(|| unexplained(evidence))
            .or_else(|| one_direction(evidence))
            .or_else(|| not_excited(evidence))
            .or_else(|| assumed(evidence))
            .unwrap_or((Status::Converged, explained(evidence)));
        Self { status, reason }
    }
}

/// The state of knowledge of an unknown from a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum State {
    /// Two standard errors are within a quarter of it.
    Known,
    /// It is uncertain, but beside the command that does not matter.
    Small,
    /// Its interval is an answer, if a wide one.
    Bounded,
    /// It is the answer of a time scale, where a fit has none.
    Rough,
    /// This motion does not determine it.
    Unknown,
}

/// The standard error up to which an estimate is known, part of it.
const KNOWN: f64 = 0.125;

impl UnknownEvidence {
    /// The state of knowledge of an unknown from the motion.
    #[must_use]
    pub fn state(&self, unknown: Unknown) -> State {
        let size = self.estimate.abs();
        let limit = MAX_STD_ERROR.limit(unknown, self.estimate, self.scale);
        match self.uncertainty() {
            _ if self.at_bound => State::Unknown,
            Some(error) if within(error, KNOWN * size) => State::Known,
            Some(error) if within(error, limit) => State::Small,
            Some(error) if within(2.0 * error, size.max(self.scale)) => State::Bounded,
            _ => State::Unknown,
        }
    }

    /// The change up to which an estimate counts as settled.
    #[must_use]
    pub fn still(&self, unknown: Unknown) -> f64 {
        MAX_MOVEMENT.limit(unknown, self.estimate, self.scale)
    }

    /// True if a refit agrees with the estimate, with an effect that the model `lacks` or without one.
    #[must_use]
    pub fn is_in_place(&self, unknown: Unknown, lacks: bool) -> bool {
        let tolerance = if lacks {
            MAX_SHIFT
        } else {
            MAX_REFIT_DIFFERENCE
        };
        let limit = tolerance.limit(unknown, self.estimate, self.scale);
        self.refit_difference
            .is_some_and(|refit_difference| within(refit_difference, limit))
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = self.reason.text(MotionUnit::Stated(AxisKind::Rotary));
        write!(f, "{}: {reason}", self.status.name())
    }
}

fn aborted(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    evidence
        .aborted
        .then_some((Status::Aborted, VerdictReason::EndedEarly))
}

fn stopped(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let was_stopped = evidence.fit.is_some_and(|fit| fit.was_stopped);
    was_stopped.then_some((Status::Moving, VerdictReason::Stopped))
}

fn without_estimate(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let motion = &evidence.motion;
    let reason = if motion.samples < MIN_SAMPLES {
        VerdictReason::TooShort {
            samples: motion.samples,
            needed: MIN_SAMPLES,
        }
    } else if motion.counts_travelled.is_nan() || motion.counts_travelled < MIN_TRAVEL_COUNTS {
        VerdictReason::NoMotion {
            counts: motion.counts_travelled,
            needed: MIN_TRAVEL_COUNTS,
        }
    } else if evidence.not_a_servo {
        VerdictReason::NotAServo
    } else {
        first(evidence, |unknown, of| {
            let rejection_reason = evidence.rejection_reason;
            let is_bounded = rejection_reason.is_none_or(|of| of == Reason::EstimateAtBound)
                && of.at_bound
                && of.estimate.abs() > Tolerance::ZERO_SHARE * of.scale;
            if is_bounded {
                let estimate = of.estimate;
                return Some(VerdictReason::AtBound { unknown, estimate });
            }
            let is_none = rejection_reason.is_some() || !of.estimate.is_finite();
            is_none.then_some(VerdictReason::NoEstimate {
                unknown,
                rejection_reason,
            })
        })?
    };
    Some((Status::NoInformation, reason))
}

fn not_separated(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let fit = evidence.fit.as_ref().or(evidence.judged_by.as_ref())?;
    let increase = fit.profile[0].min(fit.profile[1]);
    if fit.delay_at_bound {
        return Some((Status::NoInformation, VerdictReason::LongestDelay));
    }
    let reason = VerdictReason::NotSeparated {
        increase,
        needed: SEPARATED,
    };
    let is_separated = increase >= SEPARATED;
    (!is_separated).then(|| (unless_gain_is_known(evidence), reason))
}

/// The status of a result of which not all is known.
fn unless_gain_is_known(evidence: &Evidence) -> Status {
    let mut unknowns = evidence.unknowns();
    let gain = unknowns.find(|(unknown, _)| *unknown == Unknown::B);
    match gain {
        Some((unknown, of)) if of.state(unknown) == State::Known => Status::Partial,
        _ => Status::NoInformation,
    }
}

/// Friction and load are one force in a motion that does not turn back.
fn one_direction(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let fit = evidence.fit.as_ref().or(evidence.judged_by.as_ref())?;
    (!fit.reverses).then_some((Status::Partial, VerdictReason::OneDirection))
}

fn not_entered(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let term = evidence.missing_term?;
    Some((
        Status::NoInformation,
        VerdictReason::TermNotEntered { term },
    ))
}

fn not_excited(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let reason = first(evidence, |unknown, of| {
        // In a fit the errors of the four hold what the size of an effect leaves open.
        if evidence.fit.is_some() && unknown.parameter().is_none() {
            return None;
        }
        let limit = MAX_STD_ERROR.limit(unknown, of.estimate, of.scale);
        let std_error = of.std_error.filter(|error| !within(*error, limit))?;
        Some(VerdictReason::NotExcited {
            unknown,
            std_error,
            limit,
            needs_more_amplitudes: of.needs_more_amplitudes,
        })
    })?;
    Some((unless_gain_is_known(evidence), reason))
}

/// The effect that the model lacks, if it biases an estimate against the data. It is the reason for movement, too.
fn lacking(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let lack = evidence.lack.as_ref()?;
    let reason = first(evidence, |unknown, of| {
        let shift = of.refit_difference?;
        (!of.is_in_place(unknown, true)).then_some(VerdictReason::Lacks {
            cause: lack.cause,
            share: lack.share,
            unknown,
            shift,
        })
    })?;
    Some((Status::Unexplained, reason))
}

/// True if the fit explains the log down to the sensor's noise.
fn explains_all(evidence: &Evidence) -> bool {
    let innovation = evidence.innovation;
    innovation.is_none_or(|of| !of.is_large() || !of.is_autocorrelated())
}

/// The stated loop computes another command than the servo's: the log is not explained down to the encoder.
fn loop_differs(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let is_other = evidence.command_was_computed && !explains_all(evidence);
    is_other.then_some((Status::Unexplained, VerdictReason::LoopDiffers))
}

/// The fit and the time scales have gains that exclude each other. A model that explains the log down to the encoder is not
/// doubted.
fn scales_differ(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let [scales, error] = evidence.gain_of_scales?;
    (!explains_all(evidence)).then_some(())?;
    let (_, of) = evidence.unknowns().find(|(of, _)| *of == Unknown::B)?;
    let apart = 2.0 * (of.std_error? + error);
    let reason = VerdictReason::ScalesDiffer {
        fit: of.estimate,
        scales,
    };
    (!within(of.estimate - scales, apart)).then_some((Status::Unexplained, reason))
}

/// No number holds whose unit nothing shows.
fn assumed(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    (evidence.is_assumed).then_some((Status::Partial, VerdictReason::Assumed))
}

/// The reason of a verdict that nothing speaks against.
fn explained(evidence: &Evidence) -> VerdictReason {
    match (evidence.fit, evidence.innovation) {
        (Some(fit), Some(left)) if !fit.is_explained => VerdictReason::Left {
            ratio: left.rms / left.resolution_rms,
        },
        _ => VerdictReason::Explained,
    }
}

fn moving(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let reason = first(evidence, |unknown, of| {
        let limit = MAX_MOVEMENT.limit(unknown, of.estimate, of.scale);
        let movement = of.movement;
        (is_excited(unknown, of) && !within(movement, limit)).then_some(
            VerdictReason::StillMoving {
                unknown,
                movement,
                limit,
            },
        )
    })?;
    Some((Status::Moving, reason))
}

fn unexplained(evidence: &Evidence) -> Option<(Status, VerdictReason)> {
    let reason = elsewhere(evidence).or_else(|| unpredicted(evidence))?;
    Some((Status::Unexplained, reason))
}

fn elsewhere(evidence: &Evidence) -> Option<VerdictReason> {
    first(evidence, |unknown, of| {
        let refit_difference = of.refit_difference?;
        (is_excited(unknown, of) && !of.is_in_place(unknown, false)).then(|| {
            VerdictReason::RefitDiffers {
                unknown,
                refit_difference,
                limit: MAX_REFIT_DIFFERENCE.limit(unknown, of.estimate, of.scale),
            }
        })
    })
}

fn unpredicted(evidence: &Evidence) -> Option<VerdictReason> {
    let error = evidence.prediction?;
    let is_large = (evidence.residual).is_none_or(|residual| residual.is_large());
    let limit = if is_large {
        MAX_PREDICTION_ERROR
    } else {
        MAX_ACCUMULATED_ERROR
    };
    (!within(error, limit)).then_some(VerdictReason::NotPredicted { error, limit })
}

fn first<T>(
    evidence: &Evidence,
    rejection_reason: impl Fn(Unknown, &UnknownEvidence) -> Option<T>,
) -> Option<T> {
    evidence
        .unknowns()
        .find_map(|(unknown, of)| rejection_reason(unknown, of))
}

/// True if it is within tolerance. The value of one that is not does not matter.
fn is_excited(unknown: Unknown, of: &UnknownEvidence) -> bool {
    let limit = MAX_STD_ERROR.limit(unknown, of.estimate, of.scale);
    of.std_error.is_none_or(|error| within(error, limit))
}

/// NaN is within no limit.
fn within(value: f64, limit: f64) -> bool {
    value.abs() <= limit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::{Motion, Residual};

    /// The verdict's code on a b of 1 ± 0.04, of a command that was computed or not, beside b of the time scales and what the fit
    /// leaves of the log: deviations of the sensor's noise, and the correlation.
    fn code(computed: bool, scales: Option<[f64; 2]>, left: Option<[f64; 2]>) -> u8 {
        let mut evidence = Evidence::from_motion(Motion {
            samples: 10_000,
            counts_travelled: 1e4,
        });
        let of_b = UnknownEvidence {
            estimate: 1.0,
            std_error: Some(0.02),
            ..UnknownEvidence::at(1.0)
        };
        evidence.add(Unknown::B, of_b);
        evidence.command_was_computed = computed;
        evidence.gain_of_scales = scales;
        evidence.innovation = left.map(|[rms, correlation]| Residual {
            rms,
            resolution_rms: 1.0,
            correlation,
        });
        Verdict::on(&evidence).reason.code()
    }

    #[test]
    fn a_fit_that_does_not_explain_its_log_is_judged_by_loop_and_time_scales() {
        let (other, alike) = (Some([2.0, 0.05]), Some([1.13, 0.05]));
        for (computed, scales, left, expected) in [
            (false, None, Some([3.0, 0.9]), 0),
            (false, alike, Some([3.0, 0.9]), 0),
            (false, other, Some([3.0, 0.9]), 44),
            (false, Some([0.4, 0.05]), Some([3.0, 0.9]), 44),
            (true, None, Some([3.0, 0.9]), 45),
            (true, other, Some([3.0, 0.9]), 45),
            // Down to the sensor's noise, or white.
            (true, other, Some([1.4, 0.9]), 0),
            (true, other, Some([3.0, 0.2]), 0),
            (true, other, None, 0),
        ] {
            let found = code(computed, scales, left);
            assert_eq!(found, expected, "{computed} {scales:?} {left:?}");
        }
    }

    #[test]
    fn what_does_not_matter_beside_the_command_is_small_and_not_known() {
        for (estimate, error, expected) in [
            (10.0, 1.2, State::Known),
            (10.0, 1.3, State::Bounded),
            (0.1, 0.4, State::Small),
            (0.0, 0.4, State::Small),
            (0.1, 0.6, State::Bounded),
            (0.1, 60.0, State::Unknown),
            (0.1, f64::INFINITY, State::Unknown),
        ] {
            let of = UnknownEvidence {
                estimate,
                std_error: Some(error),
                ..UnknownEvidence::at(100.0)
            };
            let found = of.state(Unknown::Coulomb);
            assert_eq!(found, expected, "{estimate} {error}");
        }
    }
}
