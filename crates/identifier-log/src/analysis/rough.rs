//! The rough answer of a record: what its time scales say, where its fit says less.

use identifier_core::parameters::{ServoParameters, Unknown};
use log_fit::fit::Effect;
use log_fit::{TimeScale, surest};

use crate::result::ScaleEstimate;
use crate::scaled_recording::{Scale, servo_of};
use crate::verdict::{Evidence, Status, Verdict, VerdictReason};

/// What a record says at its time scales, SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RoughAnswer {
    /// The gain at each, the shortest first.
    pub(super) scales: Vec<ScaleEstimate>,
    surest: Option<RoughServo>,
    /// True if that is of the command that acted by the fit.
    is_of_fit: bool,
    /// b of the command as recorded.
    recorded: Option<f64>,
}

/// A servo at the surest of some time scales, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RoughServo {
    pub(super) servo: ServoParameters,
    pub(super) std_errors: ServoParameters,
    /// The length of its windows, s.
    time: f64,
    /// The part of the acceleration of left-out windows that it predicts.
    explained: f64,
}

impl RoughServo {
    /// True if its b is one. A negative b is that of a command of the other sign.
    fn has_gain(&self) -> bool {
        is_gain(self.std_errors.b / self.servo.b)
    }
}

/// True for the standard error of a gain, part of it: an interval wider than half of it is none.
fn is_gain(error: f64) -> bool {
    const MAX_ERROR: f64 = 0.25;
    error > 0.0 && error <= MAX_ERROR
}

/// True of a position that moves towards its command as on a spring: that is a goal, and its gain is the loop's.
fn follows(found: &TimeScale, scale: &Scale) -> bool {
    /// Part of the way by which a goal may be missed.
    const OFF: f64 = 0.1;
    let gain = found.values.get(Effect::B) * scale.of(Effect::B);
    let spring = found.spring / scale.time.powi(2);
    (gain - spring).abs() < OFF * spring
}

impl RoughAnswer {
    /// That of the time scales of a record, and of the surest of those of the command that acted by its fit. A command that
    /// was computed has none of the limits that nobody stated: it `was_measured`, or there is no answer.
    pub(super) fn new(
        found: &[TimeScale],
        acting: Option<&TimeScale>,
        scale: &Scale,
        was_measured: bool,
    ) -> Self {
        /// The least standard error, part of an estimate: a servo is no rigid inertia behind the recorded command to less.
        const LEAST_ERROR: f64 = 0.05;
        let scales = found.iter().map(|of| ScaleEstimate {
            time: scale.time * of.span,
            b: of.values.get(Effect::B) * scale.of(Effect::B),
            std_error: of.std_errors.get(Effect::B) * scale.of(Effect::B),
            explained: of.explained,
        });
        let rough = |of: &TimeScale| {
            let value = |effect| of.values.get(effect) * scale.of(effect);
            let error = |effect| of.std_errors.get(effect) * scale.of(effect);
            RoughServo {
                servo: servo_of(value),
                std_errors: servo_of(|effect| error(effect).hypot(LEAST_ERROR * value(effect))),
                time: scale.time * of.span,
                explained: of.explained,
            }
        };
        let recorded = surest(found);
        let surest = acting.or(recorded);
        let surest = surest.filter(|of| was_measured && !follows(of, scale));
        Self {
            scales: scales.collect(),
            recorded: recorded.map(|of| rough(of).servo.b),
            surest: surest.map(rough).filter(RoughServo::has_gain),
            is_of_fit: acting.is_some(),
        }
    }

    /// b and its standard error, of the command that acted by the fit.
    pub(super) fn gain_of_fit(&self) -> Option<[f64; 2]> {
        let surest = self.surest.as_ref().filter(|_| self.is_of_fit);
        surest.map(|rough| [rough.servo.b, rough.std_errors.b])
    }

    /// The servo that stands in for a fit without a gain, and the verdict on it.
    pub(super) fn instead(
        &self,
        verdict: &Verdict,
        evidence: &Evidence,
    ) -> Option<(RoughServo, Verdict)> {
        let mut rough = self.surest?;
        // What acted by a fit that has no gain is a doubt.
        let off = self
            .recorded
            .map_or(0.0, |recorded| recorded - rough.servo.b);
        rough.std_errors.b = rough.std_errors.b.hypot(off);
        if !rough.has_gain() {
            return None;
        }
        let gain = evidence.unknowns().find(|(of, _)| *of == Unknown::B);
        let of_fit = gain.and_then(|(_, of)| Some(of.uncertainty()? / of.estimate));
        let is_refused = match verdict.status {
            Status::NoInformation if verdict.reason.is_of_the_motion() => false,
            Status::NoInformation if verdict.hides_all() => true,
            Status::NoInformation | Status::Partial | Status::Unexplained => {
                !of_fit.is_some_and(is_gain)
            }
            _ => false,
        };
        let reason = VerdictReason::Rough {
            time: rough.time,
            explained: rough.explained,
        };
        let status = Status::Partial;
        is_refused.then_some((rough, Verdict { status, reason }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::{Motion, UnknownEvidence};

    fn answer(b: f64, error: f64) -> RoughAnswer {
        let of = |b| ServoParameters::new(0.0, b, 0.0, 0.0);
        RoughAnswer {
            scales: Vec::new(),
            surest: Some(RoughServo {
                servo: of(b),
                std_errors: of(error),
                time: 0.05,
                explained: 0.99,
            }),
            is_of_fit: true,
            recorded: None,
        }
    }

    fn instead(rough: &RoughAnswer, samples: u64, own: f64, error: f64) -> Option<f64> {
        let motion = Motion {
            samples,
            counts_travelled: 1e4,
        };
        let mut evidence = Evidence::from_motion(motion);
        let mut of_b = UnknownEvidence::at(own);
        (of_b.estimate, of_b.std_error) = (own, Some(error));
        evidence.add(Unknown::B, of_b);
        let verdict = Verdict::on(&evidence);
        let (rough, verdict) = rough.instead(&verdict, &evidence)?;
        let found = (verdict.status, verdict.reason.code());
        assert_eq!(found, (Status::Partial, 50));
        Some(rough.servo.b)
    }

    #[test]
    fn it_stands_where_the_fit_has_no_gain() {
        let rough = answer(80.0, 4.0);
        // Samples, b of the fit, its standard error, and whether the rough answer stands.
        for (samples, own, error, stands) in [
            (10_000, f64::NAN, f64::INFINITY, true),
            (10_000, 80.0, f64::INFINITY, true),
            (10_000, 80.0, 20.1, true),
            (10_000, 80.0, 19.9, false),
            (10_000, 80.0, 0.1, false),
            (50, 80.0, 40.0, false),
        ] {
            let found = instead(&rough, samples, own, error);
            assert_eq!(found, stands.then_some(80.0), "{samples} {own} {error}");
        }
    }

    #[test]
    fn what_acted_by_a_fit_without_a_gain_is_a_doubt() {
        for (recorded, stands) in [(80.0, true), (95.0, true), (105.0, false), (-80.0, false)] {
            let rough = RoughAnswer {
                recorded: Some(recorded),
                ..answer(80.0, 4.0)
            };
            let found = instead(&rough, 10_000, f64::NAN, f64::INFINITY);
            assert_eq!(found, stands.then_some(80.0), "{recorded}");
        }
    }

    #[test]
    fn a_gain_of_half_its_size_or_of_the_other_sign_is_none() {
        for (b, error, is_one) in [
            (80.0, 20.1, false),
            (80.0, 19.9, true),
            (-80.0, 1.0, false),
            (0.0, 1.0, false),
            (f64::NAN, 1.0, false),
        ] {
            let servo = answer(b, error).surest.expect("a servo");
            assert_eq!(servo.has_gain(), is_one, "{b} {error}");
        }
    }
}
