use super::super::regression::Regression;
use super::super::{IdentifiedServo, Reason};
use super::motion::MotionRecord;
use super::prior::ServoPrior;
use super::scales::RecordScales;
use super::servo_fit::ServoFit;
use super::{A, B, COULOMB, DELAY, LOAD, POSITION, UNKNOWNS, VELOCITY};
use crate::fit::ROUNDING;
use crate::fit::colour::coloured;
use crate::model::{FrictionStep, ZeroOrderHoldStep};
use crate::number::Number;
use crate::parameters::ServoParameters;

/// Settings of a fitter, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FitSettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of a count, rad.
    pub resolution: f64,
    /// The largest magnitude of the command, command units.
    pub max_command: f64,
    /// The known part of the delay from the reading of the encoder to the change of the output, s.
    pub command_delay: f64,
}

/// A Levenberg–Marquardt fit of q̈ = −a q̇ + b u(t − τ) + d − c sign q̇, driven by the recorded command, to
/// the recorded motion.
///
/// It begins with the linear least-squares estimate where nothing is known. Only the servo's motion
/// enters, without any correction of the model by it (output error), so that nothing is lost where a
/// count is much of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ServoFitter<N> {
    settings: FitSettings,
    pub(super) step: FrictionStep<N>,
}

impl<N: Number> ServoFitter<N> {
    /// Standard deviation of the delay that is not known, s, but at least a sample.
    const UNKNOWN_DELAY: f64 = 1e-4;

    /// The time of the pieces that are fitted first, s.
    const FIRST_TIME: f64 = 0.12;

    /// The speed of a servo that stands, counts per sample: a count in a hundred.
    const STOOD: f64 = 0.01;

    /// The bandwidth of gains that hold a servo, rad/s, and the most of it per sample.
    const HELD: f64 = 250.0;
    const HELD_SAMPLED: f64 = 0.08;

    /// The largest speed with which a record begins, in standard deviations.
    pub(super) const FASTEST_AT_FIRST: f64 = 4.0;

    /// The longest delay, s.
    const MAX_DELAY: f64 = 0.02;

    /// For records with these settings.
    #[must_use]
    pub(crate) fn new(settings: &FitSettings) -> Self {
        Self {
            settings: *settings,
            step: FrictionStep::new(),
        }
    }

    /// Begins a fit.
    #[must_use]
    pub(crate) fn begin<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        prior: Option<&IdentifiedServo>,
    ) -> ServoFit<N> {
        let time = self.settings.sample_time;
        let expected = self.settings.command_delay / time + 1.0;
        let deviation = Self::UNKNOWN_DELAY.max(time) / time;
        let longest = motion.longest().to_f64();
        let speed = self.speed_at_first(motion, prior.is_some());
        let vague = ServoPrior::vague([expected, deviation], speed);
        let bounds = self.bounds(motion, speed);
        let few = motion.pieces_in(N::from_f64(Self::FIRST_TIME / time));
        let fit = match prior {
            None => {
                // Half of the time that friction, viscous and Coulomb, may need to show.
                const MEMORY: f64 = 80.0;
                let lambda = (MEMORY * time).min(0.3 / longest);
                let regression = Regression::new(lambda, 1);
                ServoFit::from_nothing(vague, bounds, regression, expected)
            }
            Some(servo) => {
                let vague = vague.knowing(servo, &self.scale());
                ServoFit::from_known(vague, bounds, self.unknowns(servo))
            }
        };
        fit.few_first(few)
    }

    /// Continues a fit by a piece of the record, or by the work between two passes. Returns once it has
    /// ended.
    pub(crate) fn work<const W: usize>(
        &self,
        fit: &mut ServoFit<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Result<IdentifiedServo, Reason>> {
        if !fit.is_over() {
            fit.advance(&self.step, motion);
            return None;
        }
        Some(self.result(fit, motion))
    }

    /// The standard deviation of the speed with which a record begins, counts per sample: of a servo that
    /// stood, or of one that conservative gains hold, which hunts by a count. A released servo may begin to move.
    pub(super) fn speed_at_first<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        held: bool,
    ) -> f64 {
        let time = self.settings.sample_time;
        let hunting = if held {
            0.5 * (Self::HELD * time).min(Self::HELD_SAMPLED)
        } else {
            Self::STOOD
        };
        let first = motion.speed_at_first(N::from_f64(0.002 / time)).to_f64();
        hunting + 0.5 * first
    }

    /// Position of a count, rad.
    pub(super) fn resolution(&self) -> f64 {
        self.settings.resolution
    }

    /// Machine units per SI unit.
    pub(super) fn scale(&self) -> [f64; 5] {
        let time = self.settings.sample_time;
        let acceleration = time * time / self.settings.resolution;
        let mut scale = [acceleration; 5];
        scale[A] = time;
        scale[DELAY] = 1.0 / time;
        scale
    }

    /// The least and the largest unknowns, for a record that begins with a speed of such a deviation.
    pub(super) fn bounds<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        speed: f64,
    ) -> [[N; UNKNOWNS]; 2] {
        let time = self.settings.sample_time;
        let fastest = Self::FASTEST_AT_FIRST * speed;
        let mut low = [-f64::from(f32::MAX); UNKNOWNS];
        let mut high = [f64::from(f32::MAX); UNKNOWNS];
        let most_rate = ZeroOrderHoldStep::<N>::LARGEST_RATE / motion.longest().to_f64();
        [low[A], low[B], low[COULOMB], low[DELAY]] = [0.0; 4];
        (high[A], high[DELAY]) = (most_rate, Self::MAX_DELAY / time);
        (low[POSITION], high[POSITION]) = (-1.0, 1.0);
        (low[VELOCITY], high[VELOCITY]) = (-fastest, fastest);
        [low, high].map(|bound| bound.map(N::from_f64))
    }

    /// Of a servo, at rest.
    pub(super) fn unknowns(&self, servo: &IdentifiedServo) -> [N; UNKNOWNS] {
        let (values, scale) = (servo.values(), self.scale());
        let mut unknowns = [N::ZERO; UNKNOWNS];
        for i in 0..5 {
            unknowns[i] = N::from_f64(values[i] * scale[i]);
        }
        unknowns
    }

    fn result<const W: usize>(
        &self,
        fit: &ServoFit<N>,
        motion: &MotionRecord<N, W>,
    ) -> Result<IdentifiedServo, Reason> {
        /// The largest relative standard error of b with which there is a servo at all.
        const UNCERTAIN: f64 = 0.2;
        /// The largest correlation from piece to piece that can be distinguished from one.
        const MAX_CORRELATION: f64 = 0.95;
        /// The part of the motion's range that viscous friction at its bound may leave unexplained: where an amplifier holds a
        /// speed it leaves 0.03. Beyond, something else moves the servo.
        const MAX_LEFT: f64 = 0.05;
        let best = fit.best().ok_or(Reason::TooLittleEvidence)?;
        let cost = best.equations.cost().to_f64();
        let [friction, delay] = fit.are_at_upper_bounds(best);
        let range = RecordScales::from_record(motion, best.unknowns[B]).range;
        let left = libm::sqrt(cost / motion.len() as f64);
        if friction && !delay && left > MAX_LEFT * range {
            return Err(Reason::TooLittleEvidence);
        }
        if friction || delay {
            return Err(Reason::EstimateAtBound);
        }
        let scale = self.scale();
        let pieces = motion.len().saturating_sub(UNKNOWNS).max(1) as f64;
        let variance = (cost / pieces).max(ROUNDING);
        let products = best.sums.products.to_f64();
        let coloured = coloured(variance, products, cost, MAX_CORRELATION);
        let inverse = best.equations.covariance();
        let per_scale = scale.map(|scale| 1.0 / scale);
        let value = |i: usize| best.unknowns[i].to_f64() * per_scale[i];
        let covariance: [[f64; 5]; 5] = core::array::from_fn(|i| {
            let per_scale_of_i = coloured * per_scale[i];
            core::array::from_fn(|j| per_scale_of_i * inverse[i][j].to_f64() * per_scale[j])
        });
        let servo = IdentifiedServo {
            parameters: ServoParameters {
                a: value(A),
                b: value(B),
                coulomb: value(COULOMB),
                load: value(LOAD),
            },
            delay: value(DELAY),
            covariance,
            unexplained: libm::sqrt(variance) * self.settings.resolution,
        };
        let finite = servo.values().iter().all(|value| value.is_finite())
            && covariance
                .as_flattened()
                .iter()
                .all(|entry| entry.is_finite());
        let uncertain = servo.standard_error(B) > UNCERTAIN * servo.parameters.b;
        if !finite || servo.parameters.b <= 0.0 || uncertain {
            return Err(Reason::TooLittleEvidence);
        }
        Ok(servo)
    }
}
