use core::f64::consts::TAU;
use core::marker::PhantomData;
use core::ops::ControlFlow;

use super::super::CommissionSettings;
use super::fitted_servo::FittedServo;
use super::force_search::{ForceSearch, Forces};
use super::motion::MotionRecord;
use super::motion_model::{
    A, B, COULOMB, DELAY, GRAVITY_COSINE, GRAVITY_SINE, LOAD, LOW_SPEED, MotionFitter, OF_SERVO,
    UNKNOWNS,
};
use super::servo_fit::ServoFit;
use identifier_core::fit::{Blocking, FitResult, Fitter, QUANTISATION_VARIANCE};
use identifier_core::model::FrictionStep;
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;
use identifier_core::tuning::AxisForces;

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

    /// Unexplained position where the model lacks something, counts.
    const UNEXPLAINED: f64 = 1.0;

    /// The same of a model with forces beside the servo, which what it lacks looks like in part.
    const NEARLY_ROUNDING: f64 = 0.5;

    /// The part of the motion's range that forces beside the servo may leave, as their shape is not known as well. A
    /// resonance looks like gravity, or a part of a wave.
    const LITTLE: f64 = 2e-3;
    const LITTLE_OF_A_BEND: f64 = 3e-4;
    /// The same of one that sticks: when it breaks away differs from time to time, and its lines decide.
    const LITTLE_OF_STICKING: f64 = 0.01;

    /// The part of the range that counts as left where there is no servo.
    const NOT_FITTED: f64 = 0.1;

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
    pub(crate) fn begin<const W: usize>(&self, motion: &MotionRecord<N, W>) -> ServoFit<N> {
        self.begin_with(ForceSearch::BEGIN, motion)
    }

    /// Begins a fit of a first motion with a wave of the angle. The servo alone leaves so much of it, rad, or there is none.
    /// None for a motion that is too short, or under a noise that hides a wave.
    #[must_use]
    pub(crate) fn begin_waves<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        unexplained: Option<f64>,
    ) -> Option<ServoFit<N>> {
        let range = motion.range().to_f64() * self.settings.resolution;
        let plain = (Reason::PartlyExplained, self.left(unexplained, motion));
        let search = ForceSearch::waves(range, plain).filter(|_| self.settings.noise == 0.0)?;
        Some(self.begin_with(search, motion))
    }

    fn begin_with<const W: usize>(
        &self,
        search: ForceSearch,
        motion: &MotionRecord<N, W>,
    ) -> ServoFit<N> {
        let fitter = self.fitter_for(motion, &search);
        ServoFit {
            fitter,
            fit: fitter.begin_fit(motion.len()),
            found: None,
            search,
        }
    }

    /// Continues a fit by some blocks of the record, or by the work between two passes. Returns once it has
    /// ended.
    pub(crate) fn work<const W: usize>(
        &self,
        fit: &mut ServoFit<N>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Result<FittedServo, Reason>> {
        for _ in 0..Self::BLOCKS {
            let ServoFit {
                fitter,
                fit: under_way,
                found,
                search,
            } = fit;
            let servo = if let Some((result, cost)) = found {
                if let Some(error) = fitter.predict(under_way, motion) {
                    *cost += error * error;
                    continue;
                }
                let error = libm::sqrt(cost.to_f64() / motion.len().max(1) as f64);
                self.servo(result, error, motion, search.forces())
            } else {
                match fitter.work(under_way, motion) {
                    None => {
                        if let Some(left) = under_way.linear_left()
                            && let Some(next) = search.take_first(left.to_f64())
                        {
                            *fit = self.begin_with(next, motion);
                            return None;
                        }
                        continue;
                    }
                    Some(Some(result)) => {
                        fitter.begin_prediction(under_way, &result.parameters);
                        *found = Some((result, N::ZERO));
                        return None;
                    }
                    Some(None) => Err(Reason::TooLittleEvidence),
                }
            };
            return self.take(fit, servo, motion);
        }
        None
    }

    /// Takes what a fit has found. Forces beside the servo count where they explain the motion, and it alone is far from
    /// that.
    fn take<const W: usize>(
        &self,
        fit: &mut ServoFit<N>,
        found: Result<FittedServo, Reason>,
        motion: &MotionRecord<N, W>,
    ) -> Option<Result<FittedServo, Reason>> {
        let left = self.left(found.ok().map(|fitted| fitted.servo.unexplained), motion);
        if self.settings.noise > 0.0 {
            return Some(found);
        }
        match fit.search.take(found, left) {
            ControlFlow::Continue(next) => {
                *fit = self.begin_with(next, motion);
                None
            }
            ControlFlow::Break(found) => Some(found),
        }
    }

    /// The squared error that a servo leaves of a motion, if there is one, without that of rounding, counts².
    fn left<const W: usize>(&self, unexplained: Option<f64>, motion: &MotionRecord<N, W>) -> f64 {
        let error = match unexplained {
            Some(unexplained) => unexplained / self.settings.resolution,
            None => Self::NOT_FITTED * motion.range().to_f64(),
        };
        error * error - QUANTISATION_VARIANCE
    }

    /// A fitter for a motion of a servo, with the forces that a search has come to.
    fn fitter_for<const W: usize>(
        &self,
        motion: &MotionRecord<N, W>,
        search: &ForceSearch,
    ) -> MotionFitter<N> {
        let time = self.settings.sample_time;
        let (forces, best) = (search.forces(), search.begins_with());
        let first = self.speed_at_first(motion);
        let (mut initial, mut deviation) = ([None; UNKNOWNS], [None; UNKNOWNS]);
        initial[DELAY] = Some(self.expected_delay());
        deviation[DELAY] = Some(Self::UNKNOWN_DELAY.max(time) / time);
        if let Some(FittedServo { servo, .. }) = &best {
            let scale = self.scale();
            for (value, place) in servo.values().into_iter().zip(OF_SERVO) {
                if let (Some(initial), Some(scale)) = (initial.get_mut(place), scale.get(place)) {
                    *initial = Some(value * scale);
                }
            }
        }
        let low_speed = self.low_speed(forces, motion);
        let beside: &[usize] = match forces {
            Forces::None => &[],
            Forces::Wave(_) => &[GRAVITY_SINE, GRAVITY_COSINE],
            Forces::LowSpeed(_) => &[LOW_SPEED],
        };
        for place in beside {
            if let Some(initial) = initial.get_mut(*place) {
                *initial = Some(0.0);
            }
        }
        if let (Some(best), Some(_)) = (best, low_speed) {
            initial[LOW_SPEED] = Some(best.forces.low_speed * self.scale()[LOW_SPEED]);
        }
        let fitter = Fitter::from_rest(
            motion.samples().whole().unsigned_abs(),
            first,
            self.bounds(motion),
            [initial, deviation],
        );
        let order = match forces {
            Forces::Wave(order) => order,
            _ => 0.0,
        };
        fitter.with_terms(order * self.settings.resolution, low_speed.unwrap_or(1.0))
    }

    /// The speed below which friction rises in a model with these forces, counts per sample.
    fn low_speed<const W: usize>(
        &self,
        forces: Forces,
        motion: &MotionRecord<N, W>,
    ) -> Option<f64> {
        match forces {
            Forces::LowSpeed(part) => Some(libm::exp(part) * motion.fastest().to_f64()),
            _ => None,
        }
    }

    /// Samples.
    fn expected_delay(&self) -> f64 {
        self.settings.command_delay / self.settings.sample_time + 1.0
    }

    /// The standard deviation of the speed with which a record begins, counts per sample. The servo was at
    /// standstill. A disabled servo may begin to move.
    fn speed_at_first<const W: usize>(&self, motion: &MotionRecord<N, W>) -> f64 {
        let samples = N::from_f64(0.002 / self.settings.sample_time);
        Self::STOOD + 0.5 * motion.speed_at_first(samples).to_f64()
    }

    /// Machine units per SI unit.
    fn scale(&self) -> [f64; UNKNOWNS] {
        let time = self.settings.sample_time;
        let acceleration = time * time / self.settings.resolution;
        let mut scale = [acceleration; UNKNOWNS];
        scale[A] = time;
        scale[DELAY] = 1.0 / time;
        scale
    }

    /// The least and the largest parameters.
    fn bounds<const W: usize>(&self, motion: &MotionRecord<N, W>) -> [[f64; UNKNOWNS]; 2] {
        let mut low = [0.0; UNKNOWNS];
        let mut high = [f64::from(f32::MAX); UNKNOWNS];
        low[LOAD] = -high[LOAD];
        low[GRAVITY_SINE] = low[LOAD];
        low[GRAVITY_COSINE] = low[LOAD];
        high[A] = FrictionStep::<N>::LARGEST_RATE / motion.samples().to_f64();
        high[DELAY] = Self::MAX_DELAY / self.settings.sample_time;
        [low, high]
    }

    fn servo<const W: usize>(
        &self,
        result: &FitResult<N, UNKNOWNS>,
        error: f64,
        motion: &MotionRecord<N, W>,
        forces: Forces,
    ) -> Result<FittedServo, Reason> {
        /// The largest relative standard error of b with which there is a servo at all.
        const UNCERTAIN: f64 = 0.2;
        /// The part of the motion's range that viscous friction at its bound may leave unexplained. If an amplifier
        /// holds a speed, it leaves 0.03. Beyond, something else moves the servo.
        const MAX_LEFT: f64 = 0.05;
        /// The relative standard error of b of a servo that sticks, as its friction may have another shape. A dead band
        /// of the bridge looks like it, with a gain that is less.
        const SHAPE: f64 = 0.04;
        let is_explained = error <= MAX_LEFT * motion.range().to_f64();
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
        let value = |i: usize| {
            let value = result.parameters.get(i).zip(per_scale.get(i));
            value.map_or(0.0, |(value, per_scale)| value.to_f64() * per_scale)
        };
        let covariance = |i: usize, j: usize| {
            let entry = result.covariance.get(i)?.get(j)?;
            Some(entry.to_f64() * per_scale.get(i)? * per_scale.get(j)?)
        };
        let mut servo = IdentifiedServo {
            parameters: ServoParameters::new(value(A), value(B), value(COULOMB), value(LOAD)),
            delay: value(DELAY),
            covariance: OF_SERVO.map(|i| OF_SERVO.map(|j| covariance(i, j).unwrap_or(0.0))),
            unexplained: error.max(libm::sqrt(QUANTISATION_VARIANCE)) * self.settings.resolution,
        };
        let entries = servo.covariance.as_flattened().iter();
        let is_finite = (servo.values().iter().chain(entries)).all(|value| value.is_finite());
        let uncertain = servo.standard_error(IdentifiedServo::B) > UNCERTAIN * servo.parameters.b;
        if is_finite && servo.parameters.b > 0.0 && !uncertain {
            let range = motion.range().to_f64() * self.settings.resolution;
            let nearly = |part| Self::NEARLY_ROUNDING.max(part * motion.range().to_f64());
            let most = match forces {
                Forces::None => Self::UNEXPLAINED,
                Forces::Wave(order) if order * range < TAU => nearly(Self::LITTLE_OF_A_BEND),
                Forces::LowSpeed(_) => nearly(Self::LITTLE_OF_STICKING),
                _ => nearly(Self::LITTLE),
            };
            let mut beside = AxisForces::default();
            match forces {
                Forces::None => {}
                Forces::Wave(order) => {
                    beside.wave = [value(GRAVITY_SINE), value(GRAVITY_COSINE)];
                    beside.order = order;
                }
                Forces::LowSpeed(_) => {
                    let time = self.settings.sample_time;
                    let speed = self.low_speed(forces, motion).unwrap_or(f64::INFINITY);
                    beside.low_speed = value(LOW_SPEED);
                    beside.per_low_speed_velocity = time / (speed * self.settings.resolution);
                    let of_shape = SHAPE * servo.parameters.b;
                    servo.covariance[IdentifiedServo::B][IdentifiedServo::B] += of_shape * of_shape;
                }
            }
            // What bends more than any gravity that can be held changes by turns.
            let [_, bends] = beside.wave;
            let [low, high] = self.settings.limits.command;
            let is_gravity = libm::fabs(bends) <= servo.parameters.b * high.max(-low);
            Ok(FittedServo {
                servo,
                forces: beside,
                explains: error <= most && (is_gravity || beside.has_cogging()),
            })
        } else if is_explained {
            Err(Reason::TooLittleEvidence)
        } else {
            Err(Reason::PartlyExplained)
        }
    }
}
