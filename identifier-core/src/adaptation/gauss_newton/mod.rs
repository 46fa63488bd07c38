mod factors;

use factors::{Factors, Measurement};

use crate::error::{Allowed, OutOfRange};
use crate::number::{Number, RunningSum};

/// Recursive Gauss–Newton: the recursive prediction error method (Ljung and Söderström, Theory and
/// Practice of Recursive Identification, 1983, section 3.4) on the output error of a model, in
/// blocks of [`GaussNewton::BLOCK`] samples.
///
/// With ψ = ∂q_e/∂θ and the covariance P, both ε and ψ as means over a block:
/// K = P ψ/(r + ψᵀP ψ), θ̂ ← Proj[θ̂ + K ε], P ← (P − K ψᵀ P)/λ. The output error of one sample is
/// little more than the encoder's rounding; eight together tell as much as each by itself and cost
/// an eighth. The work on one block is spread over the samples of the next, and what those gathered
/// meanwhile is then moved to the new estimates, so that nothing is counted twice.
///
/// What keeps it sound is part of the law:
///
/// - **Forgetting** starts with a memory of [`GaussNewton::FIRST_MEMORY`], because the first
///   gradients are taken far from the truth, and tends to none, or to the memory that was asked
///   for: 1 − λ fades with the time constant [`GaussNewton::SETTLING`].
/// - **Covariance bounds**: forgetting never makes a parameter less certain than it was thought to
///   be at the start.
/// - **Dead zone**: while the model stands, the quantisation error is a constant and no noise;
///   nothing is learnt from it.
/// - **Trust**: r is at least [`GaussNewton::CAUTION`] times ψᵀP ψ, so that a block moves the
///   prediction by no more than a small part of its error: the gradients hold near the estimates
///   only, and the estimates must not run ahead of them. A surprise of more than three standard
///   deviations counts as three.
/// - **Noise level**: r is at least the encoder's noise and at least the peak, so far, of the output
///   error's mean square over [`GaussNewton::LEVEL_MEMORY`]; the peak is forgotten as the law
///   forgets. So what was learnt far from the truth weighs little beside what is learnt near it.
///   Once the peak *rises*, what was learnt before it was not as certain as it seemed, and P rises
///   with r.
/// - **Standard errors** are those of P, corrected for the mean square and the colour of the output
///   error against r.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewton<N, const P: usize> {
    noise: N,
    dead_zone: N,
    settling: N,
    least_lost: N,
    first_lost: N,
    short: N,
    caution: N,
    ninth: N,
    steepest: N,
    calming: N,
    per_block: N,
    low: [N; P],
    high: [N; P],
}

/// The configuration of [`GaussNewton`], machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonConfig<const P: usize> {
    /// The sample time T, s.
    pub sample_time: f64,
    /// Variance of the position noise; for an encoder in counts 1/12.
    pub noise: f64,
    /// Velocity below which the model counts as standing, counts per sample.
    pub dead_zone: f64,
    /// The memory that forgetting tends to, s; none for all that ever was.
    pub memory: Option<f64>,
    /// Lower bounds of the estimates.
    pub low: [f64; P],
    /// Upper bounds of the estimates.
    pub high: [f64; P],
}

/// What the law remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonState<N: Number, const P: usize> {
    estimates: [N::Sum; P],
    factors: Factors<N, P>,
    most: [N; P],
    lost_memory: N,
    level: N,
    peak: N,
    /// How many times P is still to be raised with the noise level.
    owed: N,
    /// How many times P has lately been raised with the noise level; fades to one.
    inflated: N,
    /// Sums over the block that is being gathered.
    sensitivity: [N; P],
    error: N,
    /// The block before, being worked on.
    measurement: Measurement<N, P>,
    mean_error: N,
    /// ψᵀP ψ of it.
    predicted: N,
    phase: u8,
    learning: bool,
    closed: bool,
    evidence: Evidence<N>,
}

/// The output error against the noise that it was weighed with, for standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Evidence<N> {
    error: N,
    noise: N,
    lag_one: N,
    last: N,
    blocks: u16,
}

impl<N: Number> Evidence<N> {
    /// Blocks from one halving of the sums to the next: the past fades, and no sum grows so large
    /// that it would lose a block.
    const FADING: u16 = 2000;

    const NONE: Self = Self {
        error: N::ZERO,
        noise: N::ZERO,
        lag_one: N::ZERO,
        last: N::ZERO,
        blocks: 0,
    };

    #[inline]
    fn observe(&mut self, error: N, square: N, noise: N) {
        self.error += square;
        self.noise += noise;
        self.lag_one += error * self.last;
        self.last = error;
        self.blocks += 1;
        if self.blocks == Self::FADING {
            self.fade();
        }
    }

    #[cold]
    fn fade(&mut self) {
        let half = N::from_f64(0.5);
        self.error = self.error * half;
        self.noise = self.noise * half;
        self.lag_one = self.lag_one * half;
        self.blocks = 0;
    }

    /// What the variances of P are to be multiplied by: the error's mean square over the noise's,
    /// times (1 + ρ)/(1 − ρ) for errors that go on from block to block as ρᵏ.
    fn factor(&self) -> f64 {
        /// The largest correlation that can be told from one.
        const MOST_CORRELATED: f64 = 0.98;
        let (error, noise) = (self.error.to_f64(), self.noise.to_f64());
        if error > 0.0 && noise > 0.0 {
            let correlation = (self.lag_one.to_f64() / error).clamp(0.0, MOST_CORRELATED);
            error / noise * (1.0 + correlation) / (1.0 - correlation)
        } else {
            1.0
        }
    }
}

/// What a sample did to the estimates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GaussNewtonStep<N, const P: usize> {
    /// Nothing yet.
    None,
    /// A block is complete.
    Gathered {
        /// Its mean output error.
        mean: N,
        /// The variance that the uncertainty of the estimates gives it, ψᵀP ψ.
        predicted: N,
    },
    /// The estimates moved by so much; the model is to be moved with them.
    Moved([N; P]),
}

impl<N: Number, const P: usize> GaussNewtonState<N, P> {
    /// The estimates.
    #[inline]
    #[must_use]
    pub fn estimates(&self) -> [N; P] {
        self.estimates.map(RunningSum::value)
    }

    /// Moves the last estimate to a value, and makes it less certain by a variance.
    pub fn replace_last(&mut self, value: N, variance: N) {
        if let Some(last) = self.estimates.last_mut() {
            *last = N::Sum::new(value);
        }
        self.factors.raise_last(variance);
    }

    /// Makes estimate i less certain by a variance, and those after it with which it goes.
    pub fn raise(&mut self, i: usize, variance: N) {
        self.factors.raise(i, variance);
    }

    /// Moves the last estimate.
    #[inline]
    pub fn add_to_last(&mut self, step: N) {
        if let Some(last) = self.estimates.last_mut() {
            last.add(step);
        }
    }

    /// Sets estimate i.
    pub fn replace(&mut self, i: usize, value: N) {
        if let Some(estimate) = self.estimates.get_mut(i) {
            *estimate = N::Sum::new(value);
        }
    }

    /// Makes every estimate less certain by a factor of the variance.
    pub fn doubt(&mut self, factor: N) {
        self.factors.grow(factor, &self.most);
    }

    #[inline]
    fn update_column(&mut self, column: u8) {
        self.factors
            .update_column(&mut self.measurement, usize::from(column));
    }

    /// Forgets the block that is being gathered.
    pub fn drop_block(&mut self) {
        self.sensitivity = [N::ZERO; P];
        self.error = N::ZERO;
        self.phase = 0;
        self.learning = false;
        self.closed = false;
    }

    /// Takes back the last rise of the noise level as far as P has not followed it yet: it was a step
    /// of the load, and no noise.
    pub fn forgive(&mut self) {
        self.owed = N::ONE;
    }

    /// How many times P has lately been raised with the noise level.
    #[inline]
    #[must_use]
    pub fn inflated(&self) -> N {
        self.inflated
    }

    /// The noise level, counts²: the peak of the output error's mean square.
    #[inline]
    #[must_use]
    pub fn noise_level(&self) -> N {
        self.peak
    }
}

impl<N: Number, const P: usize> GaussNewton<N, P> {
    /// Samples in a block.
    pub const BLOCK: u8 = 8;

    /// The memory at the start, s.
    pub const FIRST_MEMORY: f64 = 1.0;

    /// The time constant with which forgetting fades, s.
    pub const SETTLING: f64 = 1.0;

    /// The time over which the noise level of the moment is taken, s.
    pub const LEVEL_MEMORY: f64 = 0.03;

    /// The least memory, of whatever kind, in blocks.
    pub const LEAST_BLOCKS: f64 = 12.0;

    /// The largest factor by which P rises with the noise level in one block: a step of the load must
    /// be told from a new noise level before the estimates give way to it.
    pub const STEEPEST: f64 = 1.2;

    /// The time after which a risen noise level is no news any more, s.
    pub const CALMING: f64 = 0.5;

    /// The least r over ψᵀP ψ.
    pub const CAUTION: f64 = 20.0;

    /// The law from its configuration.
    ///
    /// # Errors
    /// `noise` must be above zero, `dead_zone` at least zero, `memory` at least
    /// [`GaussNewton::FIRST_MEMORY`].
    pub fn new(config: &GaussNewtonConfig<P>) -> Result<Self, OutOfRange> {
        const {
            assert!(
                P >= 1 && P <= 4,
                "the schedule of a block has room for four columns"
            )
        };
        Allowed::Above(0.0).check("noise", config.noise)?;
        Allowed::AtLeast(0.0).check("dead_zone", config.dead_zone)?;
        let block = config.sample_time * f64::from(Self::BLOCK);
        let blocks = |time: f64, least: f64| (time / block).max(least);
        let least_lost = match config.memory {
            Some(memory) => {
                let memory = Allowed::AtLeast(Self::FIRST_MEMORY).check("memory", memory)?;
                1.0 / blocks(memory, Self::LEAST_BLOCKS)
            }
            None => 0.0,
        };
        Ok(Self {
            noise: N::from_f64(config.noise / f64::from(Self::BLOCK)),
            dead_zone: N::from_f64(config.dead_zone),
            settling: N::from_f64(1.0 - 1.0 / blocks(Self::SETTLING, Self::LEAST_BLOCKS)),
            least_lost: N::from_f64(least_lost),
            first_lost: N::from_f64(1.0 / blocks(Self::FIRST_MEMORY, Self::LEAST_BLOCKS)),
            short: N::from_f64(1.0 / blocks(Self::LEVEL_MEMORY, 4.0)),
            caution: N::from_f64(Self::CAUTION),
            ninth: N::from_f64(1.0 / 9.0),
            steepest: N::from_f64(Self::STEEPEST),
            calming: N::from_f64(1.0 / blocks(Self::CALMING, Self::LEAST_BLOCKS)),
            per_block: N::from_f64(1.0 / f64::from(Self::BLOCK)),
            low: config.low.map(N::from_f64),
            high: config.high.map(N::from_f64),
        })
    }

    /// The state from estimates, their covariance, and the variances that forgetting never goes
    /// beyond.
    #[must_use]
    pub fn start(
        &self,
        estimates: &[N; P],
        covariance: &[[f64; P]; P],
        most: &[f64; P],
    ) -> GaussNewtonState<N, P> {
        GaussNewtonState {
            estimates: core::array::from_fn(|i| {
                N::Sum::new(estimates[i].limited(self.low[i], self.high[i]))
            }),
            factors: Factors::of(covariance),
            most: most.map(N::from_f64),
            lost_memory: self.first_lost,
            level: self.noise,
            peak: self.noise,
            owed: N::ONE,
            inflated: N::ONE,
            sensitivity: [N::ZERO; P],
            error: N::ZERO,
            measurement: Measurement::NONE,
            mean_error: N::ZERO,
            predicted: N::ZERO,
            phase: 0,
            learning: false,
            closed: false,
            evidence: Evidence::NONE,
        }
    }

    /// Whether each estimate stands at one of its bounds.
    #[must_use]
    pub fn at_bound(&self, state: &GaussNewtonState<N, P>) -> [bool; P] {
        let estimates = state.estimates();
        core::array::from_fn(|i| {
            self.low[i] < self.high[i]
                && (estimates[i] <= self.low[i] || estimates[i] >= self.high[i])
        })
    }

    /// Takes in ψ = ∂q_e/∂θ, the output error and the model's velocity of one sample, and does its
    /// share of the work on the block before.
    #[inline]
    pub fn update(
        &self,
        state: &mut GaussNewtonState<N, P>,
        sensitivity: &[N; P],
        output_error: N,
        velocity: N,
    ) -> GaussNewtonStep<N, P> {
        for i in 0..P {
            state.sensitivity[i] += sensitivity[i];
        }
        state.error += output_error;
        let phase = state.phase;
        state.phase = phase + 1;
        let columns = P as u8;
        if phase + 1 == Self::BLOCK {
            state.phase = 0;
            self.close(state, velocity);
            return GaussNewtonStep::None;
        }
        if phase == 1 && state.closed {
            if state.learning {
                state.update_column(columns - 1);
            }
            return GaussNewtonStep::Gathered {
                mean: state.mean_error,
                predicted: state.predicted,
            };
        }
        if !state.learning {
            return GaussNewtonStep::None;
        }
        if phase == 0 {
            self.weigh(state);
        } else if phase <= columns {
            state.update_column(columns - phase);
        } else if phase == columns + 1 {
            self.limit_steps(state);
        } else if phase == columns + 2 {
            return GaussNewtonStep::Moved(Self::move_estimates(state));
        }
        GaussNewtonStep::None
    }

    /// The block is complete.
    #[inline]
    fn close(&self, state: &mut GaussNewtonState<N, P>, velocity: N) {
        let error = state.error * self.per_block;
        let sensitivity = state.sensitivity.map(|sum| sum * self.per_block);
        state.sensitivity = [N::ZERO; P];
        state.error = N::ZERO;
        state.mean_error = error;
        state.learning = velocity.magnitude() >= self.dead_zone;
        let (measurement, predicted) = state.factors.project(&sensitivity);
        // A sensitivity that ran away teaches nothing.
        state.learning = state.learning && predicted <= N::REACH * N::REACH;
        state.measurement = measurement;
        state.predicted = predicted;
        state.closed = true;
    }

    #[inline]
    fn weigh(&self, state: &mut GaussNewtonState<N, P>) {
        let square = state.mean_error * state.mean_error;
        let forgetting = N::ONE - state.lost_memory;
        state.level += self.short * (square - state.level);
        let faded = larger(state.peak * forgetting, self.noise);
        state.peak = faded;
        // 1/λ = 1 + x + x² + … for λ = 1 − x, x ≤ 1/12.
        let lost = state.lost_memory;
        let mut growth = N::ONE + lost * (N::ONE + lost);
        state.lost_memory = larger(lost * self.settling, self.least_lost);
        if state.level > faded {
            state.owed = state.owed * state.level * faded.reciprocal();
            state.peak = state.level;
        }
        if state.owed > N::ONE {
            let rise = smaller(state.owed, self.steepest);
            growth = growth * rise;
            state.owed = state.owed * rise.reciprocal();
            state.inflated = state.inflated * rise;
        }
        state.factors.grow(growth, &state.most);
        let predicted = state.predicted * growth;
        state.predicted = predicted;
        state.inflated += self.calming * (N::ONE - state.inflated);
        let floor = forgetting * state.peak;
        let surprise = square * self.ninth - predicted;
        let noise = larger(floor, larger(surprise, self.caution * predicted));
        Factors::weigh(&mut state.measurement, noise);
        state.evidence.observe(state.mean_error, square, noise);
    }

    /// The steps of the estimates, no further than the box. They take the place of the gain.
    #[inline]
    fn limit_steps(&self, state: &mut GaussNewtonState<N, P>) {
        let scaled = state.measurement.precision * state.mean_error;
        let mut steps: [N; P] = core::array::from_fn(|i| state.measurement.gain[i] * scaled);
        for i in 0..P {
            let after = state.estimates[i].value() + steps[i];
            if !(after >= self.low[i] && after <= self.high[i]) {
                self.enter(state, &mut steps, i, after);
            }
        }
        state.measurement.gain = steps;
    }

    #[inline]
    fn move_estimates(state: &mut GaussNewtonState<N, P>) -> [N; P] {
        let steps = state.measurement.gain;
        for i in 0..P {
            state.estimates[i].add(steps[i]);
            // What this block has gathered so far was predicted with the old estimates.
            state.error = state.error - state.sensitivity[i] * steps[i];
        }
        steps
    }

    /// Takes back what leads out of the box through the face of estimate i, along that column of P:
    /// the other estimates move as if this one were known to be where it stays (the shortest way
    /// in the norm of P⁻¹). What then leaves through another face is taken back by itself.
    #[cold]
    fn enter(&self, state: &GaussNewtonState<N, P>, steps: &mut [N; P], i: usize, after: N) {
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
            for j in 0..P {
                steps[j] += column[j] * per;
            }
        }
        for j in 0..P {
            let inside = (before(j) + steps[j]).limited(self.low[j], self.high[j]);
            if j <= i && inside.is_finite() {
                steps[j] = inside - before(j);
            }
        }
    }

    /// The standard errors of the estimates, machine units, for a report.
    #[must_use]
    pub fn standard_errors(&self, state: &GaussNewtonState<N, P>) -> [f64; P] {
        let factor = state.evidence.factor();
        core::array::from_fn(|i| libm::sqrt(factor * state.factors.variance(i).to_f64()))
    }
}

#[inline]
fn larger<N: Number>(x: N, y: N) -> N {
    if x > y { x } else { y }
}

#[inline]
fn smaller<N: Number>(x: N, y: N) -> N {
    if x < y { x } else { y }
}
