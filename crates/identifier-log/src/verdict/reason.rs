use std::fmt::{self, Write};

use identifier_core::parameters::{Term, Unknown};
use identifier_core::reason::Reason;

use super::Cause;
use crate::motion_unit::MotionUnit;

/// The reason of a verdict: the unknown that it concerns, the figure, and the acceptable figure in the unknown's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VerdictReason {
    /// No rejection reason.
    Explained,
    /// Estimates are within tolerance, with the errors of what the model leaves of the motion.
    Left {
        /// What it leaves from one sample to the next over the sensor's noise.
        ratio: f64,
    },
    /// The run ended early.
    EndedEarly,
    /// There is no estimate.
    NoEstimate {
        /// Of this unknown.
        unknown: Unknown,
        /// Why an estimator that begins by a fit has none.
        rejection_reason: Option<Reason>,
    },
    /// Too few samples.
    TooShort {
        /// Samples that there are.
        samples: u64,
        /// Samples that are needed.
        needed: u64,
    },
    /// The servo barely moved.
    NoMotion {
        /// Encoder counts travelled.
        counts: f64,
        /// Counts that are needed.
        needed: f64,
    },
    /// The motion barely depends on an unknown, so that its estimate means little.
    NotExcited {
        /// The unknown.
        unknown: Unknown,
        /// Its standard error.
        std_error: f64,
        /// The largest allowed one.
        limit: f64,
        /// True if a command of other sizes would determine it.
        needs_more_amplitudes: bool,
    },
    /// An estimate is at a bound.
    AtBound {
        /// The unknown.
        unknown: Unknown,
        /// Its estimate.
        estimate: f64,
    },
    /// Another gain explains the record as well, with friction and load to match.
    NotSeparated {
        /// Increase of −2 ln L over another gain.
        increase: f64,
        /// The smallest allowed one.
        needed: f64,
    },
    /// The servo moved in one direction: friction and load are one then.
    OneDirection,
    /// No servo explains the record.
    NotAServo,
    /// The delay is the longest that is looked for.
    LongestDelay,
    /// A required term did not enter the model.
    TermNotEntered {
        /// The term.
        term: Term,
    },
    /// An estimate still moves.
    StillMoving {
        /// The unknown.
        unknown: Unknown,
        /// The distance that it moved, or has still to go.
        movement: f64,
        /// The most that counts as still.
        limit: f64,
    },
    /// The fit of a whole record was stopped before its end.
    Stopped,
    /// The model lacks an effect that would move an estimate.
    Lacks {
        /// The effect; none if none is distinct.
        cause: Option<Cause>,
        /// The part of the output error that it explains.
        share: f64,
        /// The unknown whose motion would be most informative.
        unknown: Unknown,
        /// The distance.
        shift: f64,
    },
    /// A refit of the data differs from the estimate.
    RefitDiffers {
        /// The unknown.
        unknown: Unknown,
        /// The distance from where it is.
        refit_difference: f64,
        /// The most that chance explains, or that does not matter.
        limit: f64,
    },
    /// The fit and the time scales have gains that exclude each other.
    ScalesDiffer {
        /// b of the fit.
        fit: f64,
        /// b of the time scales.
        scales: f64,
    },
    /// The servo's own loop is not the one that was stated.
    LoopDiffers,
    /// The fit has no gain, but a time scale has.
    Rough {
        /// Length of its windows, s.
        time: f64,
        /// The part of the acceleration that it explains.
        explained: f64,
    },
    /// The model does not predict data that the estimates have not seen.
    NotPredicted {
        /// Error relative to the position's deviation.
        error: f64,
        /// The largest allowed one.
        limit: f64,
    },
    /// The log was read by what nothing in it shows.
    Assumed,
}

impl VerdictReason {
    /// The number of [`VerdictReason::Rough`].
    pub(crate) const ROUGH: u8 = 50;

    /// Its number in results, the same in every version. 0 and 1 are converged; from 10 aborted, from 20 no information, from
    /// 30 moving, from 40 unexplained, 50 rough, 51 assumed.
    ///
    /// | code | reason |
    /// |---|---|
    /// | 0 | no rejection reason |
    /// | 1 | the same, and the model leaves more of the motion than the sensor's noise |
    /// | 10 | the run ended early |
    /// | 20 | there is no estimate |
    /// | 21 | too few samples |
    /// | 22 | the servo moved too little |
    /// | 23 | an unknown was not excited |
    /// | 24 | an estimate is at a bound |
    /// | 25 | another gain explains the record as well |
    /// | 26 | the servo moved in one direction |
    /// | 27 | no servo explains the record |
    /// | 28 | the delay is the longest that is looked for |
    /// | 29 | a required term did not enter the model |
    /// | 30 | an estimate still moves |
    /// | 31 | the fit was stopped before its end |
    /// | 40 | the model lacks an effect that has a name |
    /// | 41 | the model lacks an effect that has no name |
    /// | 42 | a refit gives another estimate |
    /// | 43 | the model does not predict other data |
    /// | 44 | fit and time scales have gains that exclude each other |
    /// | 45 | the servo's own loop is not the one that was stated |
    /// | 50 | the fit has no gain, but a time scale has |
    /// | 51 | the log was read by what nothing in it shows |
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::Explained => 0,
            Self::Left { .. } => 1,
            Self::EndedEarly => 10,
            Self::NoEstimate { .. } => 20,
            Self::TooShort { .. } => 21,
            Self::NoMotion { .. } => 22,
            Self::NotExcited { .. } => 23,
            Self::AtBound { .. } => 24,
            Self::NotSeparated { .. } => 25,
            Self::OneDirection => 26,
            Self::NotAServo => 27,
            Self::LongestDelay => 28,
            Self::TermNotEntered { .. } => 29,
            Self::StillMoving { .. } => 30,
            Self::Stopped => 31,
            Self::Lacks { cause: Some(_), .. } => 40,
            Self::Lacks { cause: None, .. } => 41,
            Self::RefitDiffers { .. } => 42,
            Self::NotPredicted { .. } => 43,
            Self::ScalesDiffer { .. } => 44,
            Self::LoopDiffers => 45,
            Self::Rough { .. } => Self::ROUGH,
            Self::Assumed => 51,
        }
    }

    /// True if no estimate means anything, whatever the status is.
    pub(super) const fn hides_all(&self) -> bool {
        matches!(
            self,
            Self::EndedEarly
                | Self::TooShort { .. }
                | Self::NoMotion { .. }
                | Self::NotAServo
                | Self::LongestDelay
                | Self::NoEstimate { .. }
        )
    }

    /// True if the servo did not move enough for any answer.
    pub(crate) const fn is_of_the_motion(&self) -> bool {
        matches!(self, Self::TooShort { .. } | Self::NoMotion { .. })
    }

    /// The unknown that it concerns, if it concerns one.
    #[must_use]
    pub const fn unknown(&self) -> Option<Unknown> {
        match self {
            Self::NoEstimate { unknown, .. }
            | Self::NotExcited { unknown, .. }
            | Self::AtBound { unknown, .. }
            | Self::StillMoving { unknown, .. }
            | Self::Lacks { unknown, .. }
            | Self::RefitDiffers { unknown, .. } => Some(*unknown),
            _ => None,
        }
    }

    /// The reason in words, for positions in a unit.
    pub(crate) fn text(self, unit: MotionUnit) -> String {
        let mut text = String::new();
        // Writing into memory cannot fail.
        let _ = self.write(&mut text, unit);
        text
    }

    fn write(self, f: &mut String, unit: MotionUnit) -> fmt::Result {
        match self {
            Self::Explained => f.write_str(
                "all estimates are within tolerance and settled; no missing effect was found",
            ),
            Self::Left { ratio } => write!(
                f,
                "all estimates are within tolerance and settled; from one sample to the next the model leaves {ratio:.1} times the \
                 sensor's noise, which is in the errors"
            ),
            Self::EndedEarly => f.write_str("the run ended early"),
            Self::Assumed => f.write_str(
                "the unit of the log's time is assumed, and nothing in the log checks it: state it with --time-unit",
            ),
            Self::NoEstimate { unknown, rejection_reason } => {
                write!(f, "no estimate of {}", unknown.name())?;
                let texts = rejection_reason.and_then(Reason::cause_and_remedy_of_first_fit);
                texts.map_or(Ok(()), |(cause, remedy)| write!(f, ": {cause}; {remedy}"))
            }
            Self::TooShort { samples, needed } => write!(
                f,
                "{samples} samples are too few: at least {needed} are needed, and some seconds are better"
            ),
            Self::NoMotion { counts, needed } => write!(
                f,
                "the servo travelled {counts:.0} encoder counts: at least {needed:.0} are needed; let it move \
                 further, with reversals"
            ),
            Self::NotExcited {
                unknown,
                std_error,
                limit,
                needs_more_amplitudes,
            } => write!(
                f,
                "{} is uncertain by ± {} (95 %), at most ± {} is within tolerance; {}",
                unknown.name(),
                Quantity(2.0 * std_error, unit.of(unknown)),
                Quantity(2.0 * limit, unit.of(unknown)),
                if needs_more_amplitudes {
                    "a dead band, friction that grows with the load or a gain that differs between the directions \
                     would look the same: use commands of several sizes"
                } else {
                    "move further, faster or longer"
                }
            ),
            Self::AtBound { unknown, estimate } => write!(
                f,
                "{} = {} is at a bound: widen it, or find the effect that the model lacks",
                unknown.name(),
                Quantity(estimate, unit.of(unknown))
            ),
            Self::NotSeparated { increase, needed } => write!(
                f,
                "a gain that differs by a quarter explains the log nearly as well, with friction and load refitted \
                 (likelihood ratio {increase:.1}, at least {needed:.0} is needed): move faster, with commands of \
                 several sizes well above friction, or longer"
            ),
            Self::OneDirection => f.write_str(
                "the servo moved in one direction only, which does not separate friction and load: let it reverse",
            ),
            Self::NotAServo => f.write_str(
                "no servo with friction, load and delay explains how the position follows the command: move much \
                 further than the encoder's resolution and noise, and check that both columns belong to this axis, \
                 their signs and units",
            ),
            Self::LongestDelay => f.write_str(
                "the delay is beyond the longest that is tested: check that command and position have the same clock",
            ),
            Self::TermNotEntered { term } => write!(
                f,
                "the required term {} is not in the model: the motion does not show it; let the servo move further, \
                 with reversals, or remove it from identifier.required_terms",
                term.name()
            ),
            Self::StillMoving {
                unknown,
                movement,
                limit,
            } if movement.is_infinite() => write!(
                f,
                "{} changed over the last quarter of the run in steps that did not decrease; settled means below {}: \
                 run longer",
                unknown.name(),
                Quantity(limit, unit.of(unknown))
            ),
            Self::StillMoving {
                unknown,
                movement,
                limit,
            } => write!(
                f,
                "{} still changed by {} over the last quarter of the run, or has that change left; settled means \
                 below {}: run longer",
                unknown.name(),
                Quantity(movement, unit.of(unknown)),
                Quantity(limit, unit.of(unknown))
            ),
            Self::Stopped => f.write_str(
                "the fit was stopped before its end: these are its estimates so far, and effects may be missing; run \
                 it to its end",
            ),
            Self::Lacks {
                cause,
                share,
                unknown,
                shift,
            } => {
                match cause {
                    Some(cause) => write!(
                        f,
                        "the model lacks {cause}, which explains {:.0} % of the residual; a model with it",
                        100.0 * share
                    )?,
                    None => f.write_str(
                        "the model lacks something, but no single effect explains it; a refit to the residual",
                    )?,
                }
                write!(
                    f,
                    " would change {} by {}",
                    unknown.name(),
                    Quantity(shift, unit.of(unknown))
                )?;
                cause.map_or(Ok(()), |cause| write!(f, ": {}", cause.remedy()))
            }
            Self::RefitDiffers {
                unknown,
                refit_difference,
                limit,
            } => write!(
                f,
                "a refit would change {} by {}, at most {} is within tolerance: run longer, or find the effect that \
                 the model lacks",
                unknown.name(),
                Quantity(refit_difference, unit.of(unknown)),
                Quantity(limit, unit.of(unknown))
            ),
            Self::ScalesDiffer { fit, scales } => write!(
                f,
                "the fit has a b of {}, but the equation of motion {}, and their intervals exclude each other",
                Quantity(fit, unit.of(Unknown::B)),
                Quantity(scales, unit.of(Unknown::B))
            ),
            Self::LoopDiffers => f.write_str(
                "the command was computed by the servo's own loop as stated, and the log is not explained down to the \
                 encoder: that loop has something else, such as a filter of its velocity",
            ),
            Self::Rough { time, explained } => write!(
                f,
                "rough: from windows of {} in which {:.0} % of the acceleration is explained",
                Quantity(time, "s"),
                100.0 * explained
            ),
            Self::NotPredicted { error, limit } => write!(
                f,
                "other data are predicted to {:.1} % of the motion, at most {:.1} % is within tolerance: the \
                 estimates are valid only for motions like those of the fit",
                100.0 * error,
                100.0 * limit
            ),
        }
    }
}

/// A value with its unit, to four figures.
struct Quantity(f64, &'static str);

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value, unit) = *self;
        if value == 0.0 || !value.is_finite() {
            return write!(f, "{value} {unit}");
        }
        let order = libm::floor(libm::log10(value.abs()));
        if (-4.0..6.0).contains(&order) {
            let digits = (3.0 - order).max(0.0) as usize;
            write!(f, "{value:.digits$} {unit}")
        } else {
            write!(f, "{value:.3e} {unit}")
        }
    }
}
