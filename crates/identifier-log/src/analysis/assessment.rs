//! The evidence for an estimator's estimates at the end of a run. The record is fitted once more, from the estimates
//! and with the estimator's own model. All estimators are thus judged alike.

use identifier_core::parameters::{ServoParameters, Unknown};
use log_fit::fit::{Effect, RecordStatistics, Values};

use super::Statistics;
use super::whole_record::{UsualSizes, WholeRecord};
use crate::experiment::TermEstimate;
use crate::result::Finding;
use crate::scaled_recording::{Scale, ScaledRecording, effect, unit};
use crate::scenario::Options;
use crate::verdict::{FitEvidence, Residual};
use log_fit::{Estimated, Lacking, Logged, MAX_SAMPLES, effects, examine};

/// The run that is judged.
#[derive(Debug, Clone, Copy)]
pub struct VerifiedEstimate<'a> {
    /// What is stated.
    pub options: &'a Options,
    /// The estimates, with the model's own value for a parameter that is not estimated.
    pub servo: ServoParameters,
    /// The terms that have entered.
    pub terms: &'a [TermEstimate],
    /// The unknowns that are estimated.
    pub unknowns: &'a [Unknown],
}

/// The extent of an assessment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effort {
    /// Samples at most.
    pub samples: usize,
    /// True if it may take many passes.
    is_thorough: bool,
}

impl Effort {
    /// For a single result.
    pub const THOROUGH: Self = Self {
        // In blocks a servo that is stopped by friction would look like one that its model does not explain.
        samples: MAX_SAMPLES,
        is_thorough: true,
    };
    /// For one of many.
    pub const BRIEF: Self = Self {
        samples: 1 << 12,
        is_thorough: false,
    };
}

/// The evidence for estimates.
#[derive(Debug, Clone, PartialEq)]
pub struct Assessment {
    /// One entry for every unknown that is estimated.
    unknowns: Vec<RefitAnswer>,
    /// The output error of the model, where it was fitted again.
    pub(super) residual: Option<Residual>,
    /// The effect that the model lacks.
    pub(super) finding: Option<Finding>,
    /// The evidence of the fit.
    pub(super) fit: Option<FitEvidence>,
    /// The usual sizes beside which unknowns act.
    pub(super) scales: UsualSizes,
    covariance: ErrorCovariance,
}

/// The covariance of the errors of estimates, SI.
#[derive(Debug, Clone, PartialEq)]
struct ErrorCovariance {
    effects: Vec<Effect>,
    matrix: Vec<Vec<f64>>,
}

impl ErrorCovariance {
    /// Of estimates in the units of a record.
    fn new(estimated: &[(Effect, f64)], matrix: &[Vec<f64>], scale: &Scale) -> Self {
        let effects: Vec<Effect> = estimated.iter().map(|(effect, _)| *effect).collect();
        let rows = effects.iter().zip(matrix).map(|(one, row)| {
            let entries = effects.iter().zip(row);
            entries
                .map(|(other, entry)| entry * scale.of(*one) * scale.of(*other))
                .collect()
        });
        Self {
            matrix: rows.collect(),
            effects,
        }
    }

    /// That of two unknowns; none for one that was not estimated.
    fn of(&self, one: Unknown, other: Unknown) -> Option<f64> {
        let [row, column] = [one, other].map(|unknown| {
            let mut effects = self.effects.iter();
            effects.position(|own| effect(unknown) == Some(*own))
        });
        Some(*self.matrix.get(row?)?.get(column?)?)
    }
}

/// The evidence for an unknown, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RefitAnswer {
    unknown: Unknown,
    /// The distance from the estimate to where the record would have it, with the effect that the model lacks.
    pub(super) refit_difference: f64,
    /// Infinite where the motion says nothing of it.
    pub(super) std_error: f64,
    /// True if a command of other sizes would determine it better.
    pub(super) needs_more_amplitudes: bool,
}

impl Assessment {
    /// The evidence on an unknown; none where it is not estimated.
    pub(super) fn of(&self, unknown: Unknown) -> Option<&RefitAnswer> {
        self.unknowns.iter().find(|asked| asked.unknown == unknown)
    }

    /// The covariance of the errors of two unknowns; none for one that was not estimated. A refit moves both.
    pub(super) fn covariance(&self, one: Unknown, other: Unknown) -> Option<f64> {
        let moved = |unknown| self.of(unknown).map(|asked| asked.refit_difference);
        let known = self.covariance.of(one, other)?;
        Some(known + moved(one)? * moved(other)?)
    }

    /// Assesses the estimates at the end of a run. None if the record is too short or no servo fits it.
    pub fn of_estimator(
        judged: &VerifiedEstimate<'_>,
        samples: &[Logged],
        effort: Effort,
    ) -> Option<Self> {
        let mut command = Statistics::default();
        samples.iter().for_each(|one| command.add(one.command));
        let ScaledRecording { recording, scale } = ScaledRecording::new(judged.options, samples);
        let own: Vec<(Unknown, Effect)> = (judged.unknowns.iter())
            .filter_map(|&unknown| Some((unknown, effect(unknown)?)))
            .collect();
        let values = judged.values(&scale);
        let law = Estimated {
            values,
            free: own.iter().map(|(_, effect)| *effect).collect(),
            is_thorough: effort.is_thorough,
        };
        let residual = |noise: f64, correlation| Residual {
            rms: noise * scale.position,
            resolution_rms: scale.position / 12.0_f64.sqrt(),
            correlation,
        };
        let found = examine(&recording, &law, |noise, correlation| {
            residual(noise, correlation).is_the_encoders()
        })?;
        let asked = |&(unknown, effect): &(Unknown, Effect)| {
            let mut errors = found.estimated.iter();
            let error = errors.find(|(one, _)| *one == effect);
            RefitAnswer {
                unknown,
                refit_difference: (found.values.get(effect) - values.get(effect))
                    * scale.of(effect),
                std_error: error.map_or(f64::INFINITY, |(_, error)| error * scale.of(effect)),
                needs_more_amplitudes: found.needs_more_amplitudes.contains(&effect),
            }
        };
        let unknowns: Vec<RefitAnswer> = own.iter().map(asked).collect();
        let finding = found.lacking.as_ref();
        Some(Self {
            residual: Some(residual(found.noise, found.correlation)),
            finding: finding.map(|lacking| scale.finding(&found.values, lacking, &unknowns)),
            unknowns,
            fit: found.profile.map(|profile| FitEvidence {
                profile,
                // The model of an estimator may have nothing for which that matters.
                reverses: true,
                delay_at_bound: false,
                was_stopped: false,
                is_explained: true,
            }),
            scales: scale.scales(&found.statistics, command.deviation()?),
            covariance: ErrorCovariance::new(&found.estimated, &found.covariance, &scale),
        })
    }

    /// Assesses a fit to the whole record, which is already at its own optimum.
    pub(super) fn of_fit(whole: &WholeRecord, unknowns: &[Unknown]) -> Self {
        let asked = |&unknown: &Unknown| RefitAnswer {
            unknown,
            refit_difference: 0.0,
            std_error: whole.std_error(unknown),
            needs_more_amplitudes: effect(unknown)
                .is_some_and(|effect| whole.needs_more_amplitudes.contains(&effect)),
        };
        Self {
            unknowns: unknowns.iter().map(asked).collect(),
            residual: None,
            finding: None,
            fit: Some(whole.evidence),
            scales: whole.scales,
            covariance: ErrorCovariance::new(
                &whole.found.estimated,
                &whole.found.covariance,
                &whole.scale,
            ),
        }
    }
}

impl VerifiedEstimate<'_> {
    /// The estimator's model in the units of a record.
    pub(super) fn values(&self, scale: &Scale) -> Values {
        scale.model(self.options, &self.servo, self.terms)
    }
}

impl Scale {
    /// The usual sizes of a motion with a usual command.
    pub(super) fn scales(&self, statistics: &RecordStatistics, command: f64) -> UsualSizes {
        UsualSizes {
            velocity: 0.5 * statistics.velocity * self.position / self.time,
            command,
        }
    }

    /// An effect that an estimator's model lacks, in SI, of a model that has it.
    fn finding(&self, values: &Values, lacking: &Lacking, own: &[RefitAnswer]) -> Finding {
        let Lacking { entered, share } = lacking;
        let parts = effects(entered.cause);
        // For a size with a speed or a slope the size itself, for two masses their twist; of a wave both parts.
        let size = match parts {
            [Effect::LowSpeed, _] => values.get(Effect::LowSpeed),
            [Effect::Compliance, ..] => values.twist(),
            _ => parts
                .iter()
                .fold(0.0, |all, part| f64::hypot(all, values.get(*part))),
        };
        Finding {
            cause: entered.cause,
            or: entered.rival(),
            share: *share,
            size: parts.first().map_or(0.0, |part| size * self.of(*part)),
            unit: parts.first().map_or("", |part| unit(*part, self.unit)),
            shifts: own
                .iter()
                .map(|one| (one.unknown, one.refit_difference))
                .collect(),
        }
    }
}
