use core::marker::PhantomData;

use super::super::CommissionSettings;
use super::super::conservative_pid::ConservativePid;
use super::motion::MotionRecord;
use super::motion_model::MotionFitter;
use super::prediction::PredictionRun;
use super::servo_fit::ServoFit;
use super::whitening::inverse_factor;
use super::{A, B, COULOMB, DELAY, LOAD, PARAMETERS};
use identifier_core::fit::{Blocking, FitResult, Fitter};
use identifier_core::model::FrictionStep;
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;

impl CommissionSettings {
    /// The blocks of a record that is not yet full.
    pub(crate) fn blocking<N: Number>(&self) -> Blocking<N> {
        /// s; within it a command of a few hundred rad/s is nearly even.
        const BLOCK_TIME: f64 = 4e-4;
        // Casts saturate.
        Blocking::new((BLOCK_TIME / self.sample_time) as u32)
    }
}

/// Fits the servo to the record of a motion: q̈ = −a q̇ + b u(t − τ) + d − c sign q̇. It is the fit of a running
/// drive.
///
/// The motion is short and begins at rest, or nearly. The model may therefore simulate it in open loop. Nothing is
/// lost if a count is much of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoFitter<'a, N> {
    settings: &'a CommissionSettings,
    number: PhantomData<N>,
}

impl<'a, N: Number> ServoFitter<'a, N> {
    /// Blocks of a pass in a slice of work.
    const BLOCKS: usize = 3;

    /// Standard deviation of an undeclared delay, s, but at least a sample.
    const UNKNOWN_DELAY: f64 = 1e-4;

    /// The speed of a servo at standstill, counts per sample: a count in a hundred.
    const STOOD: f64 = 0.01;

    /// The longest delay, s.
    const MAX_DELAY: f64 = 0.02;

    /// For records with these settings.
    #[must_use]
    pub(crate) fn new(settings: &'a CommissionSettings) -> Self {
        Self {
            settings,
            number: PhantomData,
        }
    }

    /// Begins a fit.
    #[must_use]
    pub(crate) fn begin<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        known: Option<&IdentifiedServo>,
    ) -> ServoFit<N> {
        /// Factor on the standard errors of an earlier estimate, because a servo may change.
        const CAUTION: f64 = 2.0;
        let fitter = self.fitter_for(motion, known, known.is_some());
        let mut fit = fitter.begin_fit(motion.len());
        if let Some(servo) = known {
            let scale = self.scale();
            let row = |factor: [f64; PARAMETERS]| {
                let mut row = [N::ZERO; PARAMETERS];
                for ((entry, factor), scale) in row.iter_mut().zip(factor).zip(scale) {
                    *entry = N::from_f64(factor / (CAUTION * scale));
                }
                row
            };
            fitter.know(&mut fit, &inverse_factor(&servo.covariance).map(row));
        }
        ServoFit {
            fitter,
            fit,
            found: None,
        }
    }

    /// Continues a fit by some blocks of the record, or by the work between two passes. Returns once it has
    /// ended.
    pub(crate) fn work<const W: usize>(
        &self,
        fit: &mut ServoFit<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Result<IdentifiedServo, Reason>> {
        for _ in 0..Self::BLOCKS {
            if let Some((result, own)) = &mut fit.found {
                if own.advance(motion) {
                    return Some(self.servo(result, own.error(motion), motion.range()));
                }
            } else if let Some(ended) = fit.fitter.work(&mut fit.fit, motion) {
                let Some(result) = ended else {
                    return Some(Err(Reason::TooLittleEvidence));
                };
                let afresh = fit.fitter.begin_fit(motion.len());
                let own = PredictionRun::begin(&fit.fitter, afresh, &result.parameters);
                fit.found = Some((result, own));
                return None;
            }
        }
        None
    }

    /// A fitter for a motion of a servo. Earlier estimates may exist, and gains may have held it before.
    fn fitter_for<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        known: Option<&IdentifiedServo>,
        is_held: bool,
    ) -> MotionFitter<N> {
        let time = self.settings.sample_time;
        let speed = self.speed_at_first(motion, is_held);
        let (mut initial, mut deviation) = ([None; PARAMETERS], [None; PARAMETERS]);
        initial[DELAY] = Some(self.expected_delay());
        deviation[DELAY] = Some(Self::UNKNOWN_DELAY.max(time) / time);
        if let Some(servo) = known {
            let (values, scale) = (servo.values(), self.scale());
            for i in 0..PARAMETERS {
                initial[i] = Some(values[i] * scale[i]);
            }
        }
        Fitter::from_rest(
            motion.samples().whole().unsigned_abs(),
            speed,
            self.bounds(motion),
            [initial, deviation],
        )
    }

    /// Samples.
    fn expected_delay(&self) -> f64 {
        self.settings.command_delay / self.settings.sample_time + 1.0
    }

    /// The standard deviation of the speed with which a record begins, counts per sample. The servo was at
    /// standstill, or conservative gains held it, under which it hunts by a count. A disabled servo may begin to
    /// move.
    fn speed_at_first<const W: usize>(&self, motion: &MotionRecord<N, W>, held: bool) -> f64 {
        let time = self.settings.sample_time;
        let hunting = if held {
            let sampled = ConservativePid::<N>::MAX_BANDWIDTH_PER_SAMPLE;
            0.5 * (ConservativePid::<N>::MAX_BANDWIDTH * time).min(sampled)
        } else {
            Self::STOOD
        };
        let first = motion.speed_at_first(N::from_f64(0.002 / time)).to_f64();
        hunting + 0.5 * first
    }

    /// Machine units per SI unit.
    fn scale(&self) -> [f64; PARAMETERS] {
        let time = self.settings.sample_time;
        let acceleration = time * time / self.settings.resolution;
        let mut scale = [acceleration; PARAMETERS];
        scale[A] = time;
        scale[DELAY] = 1.0 / time;
        scale
    }

    /// The least and the largest parameters.
    fn bounds<const W: usize>(&self, motion: &MotionRecord<N, W>) -> [[f64; PARAMETERS]; 2] {
        let mut low = [0.0; PARAMETERS];
        let mut high = [f64::from(f32::MAX); PARAMETERS];
        low[LOAD] = -high[LOAD];
        high[A] = FrictionStep::<N>::LARGEST_RATE / motion.samples().to_f64();
        high[DELAY] = Self::MAX_DELAY / self.settings.sample_time;
        [low, high]
    }

    fn servo(
        &self,
        result: &FitResult<N, PARAMETERS>,
        error: f64,
        range: N,
    ) -> Result<IdentifiedServo, Reason> {
        /// The largest relative standard error of b with which there is a servo at all.
        const UNCERTAIN: f64 = 0.2;
        /// The part of the motion's range that viscous friction at its bound may leave unexplained. If an amplifier
        /// holds a speed, it leaves 0.03. Beyond, something else moves the servo.
        const MAX_LEFT: f64 = 0.05;
        let is_explained = error <= MAX_LEFT * range.to_f64();
        let is_at_most = |at_bound: bool, value: N| at_bound && value > N::ZERO;
        let friction = is_at_most(result.at_bound[A], result.parameters[A]);
        let delay = is_at_most(result.at_bound[DELAY], result.parameters[DELAY]);
        if friction && !delay && !is_explained {
            return Err(Reason::PartlyExplained);
        }
        if friction || delay {
            return Err(Reason::EstimateAtBound);
        }
        let per_scale = self.scale().map(|scale| 1.0 / scale);
        let value = |i: usize| result.parameters[i].to_f64() * per_scale[i];
        let servo = IdentifiedServo {
            parameters: ServoParameters::new(value(A), value(B), value(COULOMB), value(LOAD)),
            delay: value(DELAY),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    result.covariance[i][j].to_f64() * per_scale[i] * per_scale[j]
                })
            }),
            unexplained: error.max(PredictionRun::<N>::rounding()) * self.settings.resolution,
        };
        let entries = servo.covariance.as_flattened().iter();
        let is_finite = (servo.values().iter().chain(entries)).all(|value| value.is_finite());
        let uncertain = servo.standard_error(B) > UNCERTAIN * servo.parameters.b;
        if is_finite && servo.parameters.b > 0.0 && !uncertain {
            Ok(servo)
        } else if is_explained {
            Err(Reason::TooLittleEvidence)
        } else {
            Err(Reason::PartlyExplained)
        }
    }
}
