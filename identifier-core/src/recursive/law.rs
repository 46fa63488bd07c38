use super::uncertainty::{EstimateUncertainty, WeighedErrors};
use crate::constants::{Encode, encode};
use crate::error::{Allowed, OutOfRange};
use crate::linalg::{Factors, Measurement};
use crate::model::IdentifiableSet;
use crate::number::{Number, RunningSum};
use crate::unrolled::{each, from_fn};

/// Recursive Gauss–Newton on the output error of a model, in blocks of [`GaussNewton::BLOCK`] samples. It is the
/// recursive prediction error method (Ljung and Söderström, Theory and Practice of Recursive Identification, 1983,
/// section 3.4).
///
/// ψ = ∂q_e/∂θ, P is the covariance, and ε and ψ are means over a block. K = P ψ/(r + ψᵀP ψ), θ̂ ← Proj[θ̂ + K ε], P ←
/// (P − K ψᵀ P)/λ. The output error of one sample is little more than the encoder's rounding. The mean of eight carries
/// the same information at an eighth of the cost. As ψ is smooth, its mean is that of the straight line through one
/// sample.
///
/// The work on one block is spread evenly over the samples of the next:
///
/// | sample | work on the block before |
/// |---|---|
/// | 0 | the caller's tests of its mean error |
/// | 1 | noise level, forgetting |
/// | 2 | its weight, the last quarter of the columns of P |
/// | 3 | the columns in between |
/// | 4 | the first quarter; ψ of the present block |
/// | 5 | the steps of the estimates, within their bounds |
/// | 6 | the estimates and the model move |
/// | 7 | the present block ends: its ψᵀP ψ |
///
/// When the estimates move, the error of the present block is corrected for the step. So nothing is counted twice.
///
/// These keep the estimator stable:
///
/// - **Forgetting** starts with a memory of [`GaussNewton::FIRST_MEMORY`], because the first gradients are taken far
///   from the truth. It tends to none, or to the memory in the settings. 1 − λ fades with the time constant
///   [`GaussNewton::SETTLING`].
/// - **Covariance bounds**: forgetting never makes a parameter less certain than it was at the start.
/// - **Dead zone**: while the model is at rest, the quantisation error is constant and no noise. Nothing is learnt
///   then.
/// - **Step limit**: r is at least [`GaussNewton::CAUTION`] times ψᵀP ψ. So a block moves the prediction by only a
///   small part of its error. The gradients are valid only near the estimates. An error of more than three standard
///   deviations counts as three.
/// - **Noise level**: r is at least the encoder's noise. It is also at least the past peak of the output error's mean
///   square over [`GaussNewton::LEVEL_MEMORY`]. The peak fades as the estimator forgets. So data from far off the truth
///   weigh little against data near it. When the peak *rises*, the earlier data were less certain than assumed, and P
///   rises with r.
/// - **Standard errors** are those of P with two corrections. One is the output error's mean square over r, the other
///   its autocorrelation from block to block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GaussNewton<N, const P: usize> {
    noise: N,
    dead_zone: N,
    settling: N,
    min_forgetting: N,
    initial_forgetting: N,
    level_gain: N,
    caution: N,
    outlier_threshold_inv_sq: N,
    max_inflation: N,
    inflation_decay: N,
    per_block: N,
    moved_samples: N,
    mean_offset: N,
    low: [N; P],
    high: [N; P],
}

encode! {
    [N: Encode, const P: usize] GaussNewton<N, P> as "GaussNewton" {
        noise, dead_zone, settling, min_forgetting, initial_forgetting, level_gain, caution,
        outlier_threshold_inv_sq, max_inflation, inflation_decay, per_block, moved_samples,
        mean_offset, low, high,
    }
}

/// The configuration of [`GaussNewton`], machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GaussNewtonConfig<const P: usize> {
    /// The sample time T, s.
    pub sample_time: f64,
    /// Variance of the position noise; for an encoder in counts 1/12.
    pub noise: f64,
    /// Velocity below which the model counts as at rest, counts per sample.
    pub dead_zone: f64,
    /// The memory that forgetting tends to, s; none for all that ever was.
    pub memory: Option<f64>,
    /// Lower bounds of the estimates.
    pub low: [f64; P],
    /// Upper bounds of the estimates.
    pub high: [f64; P],
}

/// State of the estimator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GaussNewtonState<N: Number, S: IdentifiableSet<P>, const P: usize> {
    /// The sum of the output errors of the block that is being gathered.
    error: N,
    /// Its mean ψ.
    sensitivity: [N; P],
    estimates: [N::Sum; P],
    /// Those of P.
    pub(super) factors: Factors<N, S::Lower<N>, P>,
    /// The block before, being worked on.
    measurement: Measurement<N, P>,
    mean_error: N,
    forgetting: N,
    level: N,
    peak: N,
    /// The factor by which P is still to rise with the noise level.
    pending_inflation: N,
    /// The factor by which P has lately risen with the noise level; fades to one.
    pub(super) inflation: N,
    weighed: WeighedErrors<N>,
    /// The number of blocks in its sums.
    blocks: u16,
    phase: u8,
    /// The last complete block is to be learnt from.
    pub(super) learning: bool,
}

/// The progress of the estimator with a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum GaussNewtonStep<N, const P: usize> {
    /// At work.
    Working,
    /// A block is complete, and nothing was learnt from it yet.
    Gathered {
        /// Its mean output error.
        mean: N,
        /// The variance that the uncertainty of the estimates gives it, ψᵀP ψ.
        predicted: N,
    },
    /// The next sample may move the estimates.
    Ready,
    /// The estimates moved by this; the model must be moved with them.
    Moved([N; P]),
}

impl<N: Number, S: IdentifiableSet<P>, const P: usize> GaussNewtonState<N, S, P> {
    /// The estimates.
    #[inline]
    pub(crate) fn estimates(&self) -> [N; P] {
        from_fn(N::ZERO, |i| self.estimates[i].value())
    }

    /// Moves the last estimate to a value, and makes it less certain by a variance.
    pub(crate) fn replace_last(&mut self, value: N, variance: N) {
        if let Some(last) = self.estimates.last_mut() {
            *last = N::Sum::new(value);
        }
        self.factors.raise_last(variance);
    }

    /// Moves the last estimate.
    #[inline]
    pub(crate) fn add_to_last(&mut self, step: N) {
        if let Some(last) = self.estimates.last_mut() {
            last.add(step);
        }
    }

    /// Sets estimate i.
    pub(crate) fn replace(&mut self, i: usize, value: N) {
        if let Some(estimate) = self.estimates.get_mut(i) {
            *estimate = N::Sum::new(value);
        }
    }

    /// Forgets the block that is being gathered and the one that is being worked on.
    pub(crate) fn drop_block(&mut self) {
        self.error = N::ZERO;
        self.mean_error = N::ZERO;
        self.phase = 0;
        self.learning = false;
    }

    /// Moves the peak of the noise level towards the present level, by a part of their distance. Errors and
    /// sensitivities become smaller together.
    pub(crate) fn forget_peak(&mut self, part: N) {
        if self.level < self.peak {
            self.peak += part * (self.level - self.peak);
        }
    }

    /// Cancels the part of the last rise of the noise level that P has not followed yet. The cause was a step of the
    /// load, not noise.
    pub(crate) fn cancel_inflation(&mut self) {
        self.pending_inflation = N::ONE;
    }
}

impl<N: Number, const P: usize> GaussNewton<N, P> {
    /// Samples in a block.
    pub(crate) const BLOCK: u8 = 8;

    /// The sample of a block from whose end ψ is taken.
    const LOOKS: u8 = 4;

    /// The sample of a block at whose end the estimates move.
    const MOVES: u8 = 6;

    /// The P columns of the covariance are updated in three parts. The last quarter comes with the weight of a block,
    /// then the middle, then the first quarter.
    const LAST_COLUMNS: usize = 3 * P / 4;
    const FIRST_COLUMNS: usize = P / 4;

    /// The memory at the start, s.
    pub(crate) const FIRST_MEMORY: f64 = 1.0;

    /// The time constant with which forgetting fades, s.
    pub(crate) const SETTLING: f64 = 1.0;

    /// The time over which the noise level of the moment is taken, s.
    pub(crate) const LEVEL_MEMORY: f64 = 0.03;

    /// The shortest memory of any kind, blocks.
    pub(crate) const MIN_BLOCKS: f64 = 12.0;

    /// The largest factor by which P rises with the noise level in one block. A step of the load must be distinguished
    /// from a new noise level before the estimates follow it.
    pub(crate) const MAX_INFLATION: f64 = 1.2;

    /// The time constant with which the memory of a risen noise level fades, s.
    pub(crate) const INFLATION_TIME: f64 = 0.5;

    /// The least r over ψᵀP ψ.
    pub(crate) const CAUTION: f64 = 20.0;

    /// The estimator from its configuration.
    ///
    /// # Errors
    /// `noise` must be above zero, `dead_zone` at least zero, `memory` at least
    /// [`GaussNewton::FIRST_MEMORY`].
    pub(crate) fn new(config: &GaussNewtonConfig<P>) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("noise", config.noise)?;
        Allowed::AtLeast(0.0).check("dead_zone", config.dead_zone)?;
        let block = config.sample_time * f64::from(Self::BLOCK);
        let blocks = |time: f64, least: f64| (time / block).max(least);
        let min_forgetting = match config.memory {
            Some(memory) => {
                let memory = Allowed::AtLeast(Self::FIRST_MEMORY).check("memory", memory)?;
                1.0 / blocks(memory, Self::MIN_BLOCKS)
            }
            None => 0.0,
        };
        Ok(Self {
            noise: N::from_f64(config.noise / f64::from(Self::BLOCK)),
            dead_zone: N::from_f64(config.dead_zone),
            settling: N::from_f64(1.0 - 1.0 / blocks(Self::SETTLING, Self::MIN_BLOCKS)),
            min_forgetting: N::from_f64(min_forgetting),
            initial_forgetting: N::from_f64(1.0 / blocks(Self::FIRST_MEMORY, Self::MIN_BLOCKS)),
            level_gain: N::from_f64(1.0 / blocks(Self::LEVEL_MEMORY, 4.0)),
            caution: N::from_f64(Self::CAUTION),
            outlier_threshold_inv_sq: N::from_f64(1.0 / 9.0),
            max_inflation: N::from_f64(Self::MAX_INFLATION),
            inflation_decay: N::from_f64(1.0 / blocks(Self::INFLATION_TIME, Self::MIN_BLOCKS)),
            per_block: N::from_f64(1.0 / f64::from(Self::BLOCK)),
            moved_samples: N::from_f64(f64::from(Self::MOVES + 1)),
            mean_offset: N::from_f64(f64::from(Self::LOOKS + 1) - 0.5 * f64::from(Self::BLOCK - 1)),
            low: config.low.map(N::from_f64),
            high: config.high.map(N::from_f64),
        })
    }

    /// The state from estimates that count as known.
    pub(crate) fn start<S: IdentifiableSet<P>>(
        &self,
        estimates: &[N; P],
    ) -> GaussNewtonState<N, S, P> {
        self.start_from(estimates, Factors::ZERO, N::ONE)
    }

    /// The same with a covariance in factors. The noise of the position is stated as a multiple of the settings'
    /// variance. Nothing is divided.
    pub(crate) fn start_from<S: IdentifiableSet<P>>(
        &self,
        estimates: &[N; P],
        covariance: Factors<N, S::Lower<N>, P>,
        noise: N,
    ) -> GaussNewtonState<N, S, P> {
        GaussNewtonState {
            error: N::ZERO,
            sensitivity: [N::ZERO; P],
            estimates: from_fn(N::Sum::new(N::ZERO), |i| {
                N::Sum::new(estimates[i].limited(self.low[i], self.high[i]))
            }),
            factors: covariance,
            measurement: Measurement::NONE,
            mean_error: N::ZERO,
            forgetting: self.initial_forgetting,
            level: self.noise * noise,
            peak: self.noise * noise,
            pending_inflation: N::ONE,
            inflation: N::ONE,
            weighed: WeighedErrors::default(),
            blocks: 0,
            phase: 0,
            learning: false,
        }
    }

    /// Which of the estimates are at a bound.
    pub(crate) fn at_bounds(&self, estimates: &[N; P]) -> [bool; P] {
        core::array::from_fn(|i| {
            self.low[i] < self.high[i]
                && (estimates[i] <= self.low[i] || estimates[i] >= self.high[i])
        })
    }

    /// Takes in the output error of one sample, and does its share of the work on the block before.
    ///
    /// `position` and `velocity` are ∂q_e/∂θ and ∂v_e/∂θ at the *end* of the sample, `speed` the
    /// model's velocity there. `most` gives, for the estimates, the variances that forgetting never
    /// goes beyond.
    #[inline]
    pub(crate) fn update<S: IdentifiableSet<P>>(
        &self,
        state: &mut GaussNewtonState<N, S, P>,
        output_error: N,
        position: &[N; P],
        velocity: &[N; P],
        speed: N,
        most: impl Fn(&[N; P]) -> [N; P],
    ) -> GaussNewtonStep<N, P> {
        state.error += output_error;
        let phase = state.phase;
        state.phase = (phase + 1) % Self::BLOCK;
        match phase {
            0 => {
                return GaussNewtonStep::Gathered {
                    mean: state.mean_error,
                    predicted: state.measurement.variance,
                };
            }
            1 if state.learning => self.forget(state, most),
            2 if state.learning => self.weigh(state),
            3 if state.learning => {
                state.factors.update(
                    &mut state.measurement,
                    Self::FIRST_COLUMNS,
                    Self::LAST_COLUMNS,
                );
            }
            Self::LOOKS => {
                if state.learning {
                    state
                        .factors
                        .update(&mut state.measurement, 0, Self::FIRST_COLUMNS);
                }
                state.sensitivity =
                    from_fn(N::ZERO, |i| position[i] - self.mean_offset * velocity[i]);
            }
            5 => {
                if state.learning {
                    self.limit_steps(state);
                }
                return GaussNewtonStep::Ready;
            }
            Self::MOVES if state.learning => {
                return GaussNewtonStep::Moved(self.move_estimates(state));
            }
            7 => self.close(state, speed),
            _ => {}
        }
        GaussNewtonStep::Working
    }

    /// The block is complete.
    #[inline]
    fn close<S: IdentifiableSet<P>>(&self, state: &mut GaussNewtonState<N, S, P>, speed: N) {
        state.mean_error = state.error * self.per_block;
        state.error = N::ZERO;
        let moves = speed.magnitude() >= self.dead_zone;
        state.measurement = state.factors.project(&state.sensitivity);
        // A sensitivity beyond the range of numbers is not used.
        state.learning = moves && state.measurement.variance <= N::REACH * N::REACH;
    }

    /// Follows the noise level. P rises with forgetting and with that level.
    #[inline]
    fn forget<S: IdentifiableSet<P>>(
        &self,
        state: &mut GaussNewtonState<N, S, P>,
        most: impl Fn(&[N; P]) -> [N; P],
    ) {
        let forgetting = state.forgetting;
        let error = state.mean_error;
        state.level += self.level_gain * (error * error - state.level);
        let faded = (state.peak - state.peak * forgetting).larger(self.noise);
        // 1/λ = 1 + x + x² + … for λ = 1 − x, x ≤ 1/12.
        let mut growth = N::ONE + forgetting * (N::ONE + forgetting);
        state.forgetting = (forgetting * self.settling).larger(self.min_forgetting);
        state.inflation += self.inflation_decay * (N::ONE - state.inflation);
        state.peak = faded;
        if state.level > faded {
            state.pending_inflation = state.pending_inflation * state.level * faded.reciprocal();
            state.peak = state.level;
        }
        if state.pending_inflation > N::ONE {
            let rise = state.pending_inflation.smaller(self.max_inflation);
            growth = growth * rise;
            state.pending_inflation = state.pending_inflation * rise.reciprocal();
            state.inflation = state.inflation * rise;
        }
        state.factors.grow(growth, &most(&state.estimates()));
        state.measurement.variance = state.measurement.variance * growth;
    }

    #[inline]
    fn weigh<S: IdentifiableSet<P>>(&self, state: &mut GaussNewtonState<N, S, P>) {
        let error = state.mean_error;
        let predicted = state.measurement.variance;
        let floor = state.peak - state.peak * state.forgetting;
        let surprise = error * error * self.outlier_threshold_inv_sq - predicted;
        let noise = floor.larger(surprise.larger(self.caution * predicted));
        state.measurement.weigh(noise);
        state.weighed.observe(error, state.measurement.precision);
        state.blocks += 1;
        if state.blocks == WeighedErrors::<N>::FADING {
            state.blocks /= 2;
            state.weighed.fade();
        }
        state
            .factors
            .update(&mut state.measurement, Self::LAST_COLUMNS, P);
    }

    /// The steps of the estimates, limited to the parameter range. They take the place of the gain.
    #[inline]
    fn limit_steps<S: IdentifiableSet<P>>(&self, state: &mut GaussNewtonState<N, S, P>) {
        let scaled = state.measurement.precision * state.mean_error;
        let mut inside = true;
        each::<P>(|i| {
            let step = state.measurement.gain[i] * scaled;
            let after = state.estimates[i].value() + step;
            inside &= after >= self.low[i];
            inside &= after <= self.high[i];
            state.measurement.gain[i] = step;
        });
        if !inside {
            self.stay_inside(state);
        }
    }

    #[cold]
    #[inline(never)]
    fn stay_inside<S: IdentifiableSet<P>>(&self, state: &mut GaussNewtonState<N, S, P>) {
        let mut steps = state.measurement.gain;
        each::<P>(|i| {
            let after = state.estimates[i].value() + steps[i];
            if !(after >= self.low[i] && after <= self.high[i]) {
                self.enter(state, &mut steps, i, after);
            }
        });
        state.measurement.gain = steps;
    }

    #[inline]
    fn move_estimates<S: IdentifiableSet<P>>(
        &self,
        state: &mut GaussNewtonState<N, S, P>,
    ) -> [N; P] {
        let steps = state.measurement.gain;
        let mut change = N::ZERO;
        each::<P>(|i| {
            state.estimates[i].add(steps[i]);
            change += state.sensitivity[i] * steps[i];
        });
        // The error of this block so far was predicted with the old estimates.
        state.error = state.error - self.moved_samples * change;
        steps
    }

    /// Removes the part of the steps by which estimate i would leave its bounds, along that column of P. The other
    /// estimates move as if this one were known to be at its bound. This is the shortest distance in the norm of P⁻¹.
    /// Those that then leave theirs are clamped.
    fn enter<S: IdentifiableSet<P>>(
        &self,
        state: &GaussNewtonState<N, S, P>,
        steps: &mut [N; P],
        i: usize,
        after: N,
    ) {
        let before = |j: usize| state.estimates[j].value();
        if !after.is_finite() {
            *steps = [N::ZERO; P];
            return;
        }
        let column = state.factors.column(i);
        let (Some(&low), Some(&high), Some(&own)) =
            (self.low.get(i), self.high.get(i), column.get(i))
        else {
            return;
        };
        let back = after.limited(low, high) - after;
        if own > N::ZERO && own.reciprocal().is_finite() {
            let per = back * own.reciprocal();
            each::<P>(|j| steps[j] += column[j] * per);
        }
        each::<P>(|j| {
            let inside = (before(j) + steps[j]).limited(self.low[j], self.high[j]);
            if j <= i && inside.is_finite() {
                steps[j] = inside - before(j);
            }
        });
    }

    /// Forgets again as at the start. The gradients were taken far from the truth.
    pub(crate) fn settle_anew<S: IdentifiableSet<P>>(&self, state: &mut GaussNewtonState<N, S, P>) {
        state.forgetting = self.initial_forgetting;
    }

    /// The errors of the estimates.
    #[inline]
    pub(crate) fn uncertainty<S: IdentifiableSet<P>>(
        &self,
        state: &GaussNewtonState<N, S, P>,
    ) -> EstimateUncertainty<N, P> {
        EstimateUncertainty {
            variances: from_fn(N::ZERO, |i| state.factors.variance(i)),
            weighed: state.weighed,
            blocks: state.blocks,
        }
    }
}
