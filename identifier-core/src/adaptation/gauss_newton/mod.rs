mod noise;

use noise::{Balance, Batches};

use super::Covariance;
use crate::error::{Allowed, OutOfRange};
use crate::interval::Interval;
use crate::number::{Number, RunningSum};

/// Recursive Gauss–Newton: the recursive prediction error method (Ljung and Söderström, Theory and
/// Practice of Recursive Identification, 1983, section 3.4) on the model loop's output error.
///
/// With ψ = ∂q_e/∂θ and the covariance P (in units of the noise), per sample:
/// K = P ψ/(λ r + ψᵀP ψ), θ̂ ← Proj[θ̂ + K ε], P ← (P − K ψᵀ P)/λ, in the factored form of
/// [`Covariance`]. What keeps it sound is part of the law:
///
/// - **Forgetting** starts at [`GaussNewton::FIRST_MEMORY`] samples, because the first gradients
///   are taken far from the truth, and tends to none: λ ← 1 − (1 − λ)·[`GaussNewton::SETTLING`].
/// - **Covariance bounds**: forgetting never makes a parameter less certain than it was at the
///   start.
/// - **Dead zone**: while the model stands still, the quantisation error is a constant and no
///   noise; nothing is learnt from it.
/// - **Trust**: r is at least [`GaussNewton::CAUTION`] times ψᵀP ψ, so that a sample moves the
///   prediction by no more than a small part of its error: the gradients hold near the estimates
///   only, and the estimates must not run ahead of them. A surprise of more than three standard
///   deviations counts as three.
/// - **Noise level**: r is at least the encoder's noise and at least the peak, so far, of the output
///   error's mean square over [`GaussNewton::LEVEL_MEMORY`] samples; the peak is forgotten as the
///   law forgets. So what was learnt far from the truth, where the output error is large, weighs
///   little beside what is learnt near it. Once the peak *rises*, what was learnt before it was not
///   as certain as it seemed, and P rises with r: where the model lacks something, every phase of
///   the motion weighs alike, whichever comes first.
/// - **Standard errors** are those of P, corrected for the mean square and the colour of the output
///   error against r.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewton<N, const P: usize> {
    noise: N,
    dead_zone: N,
    settling: N,
    short: N,
    caution: N,
    ninth: N,
    low: [N; P],
    high: [N; P],
    prior: [N; P],
}

/// The machine-unit configuration of [`GaussNewton`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonConfig<const P: usize> {
    /// Variance of the position noise; for an encoder in counts 1/12.
    pub noise: f64,
    /// Velocity below which the servo counts as standing, position units per sample.
    pub dead_zone: f64,
    /// Standard deviations of the initial estimates; zero for a parameter that is known.
    pub uncertainty: [f64; P],
    /// Box of the estimates.
    pub bounds: [Interval; P],
}

/// What the law remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonState<N: Number, const P: usize> {
    estimates: [N::Sum; P],
    covariance: Covariance<N, P>,
    lost_memory: N,
    level: N,
    peak: N,
    balance: Balance<N>,
    batches: Batches<N, P>,
}

impl<N: Number, const P: usize> GaussNewtonState<N, P> {
    /// The estimates, machine units.
    #[inline]
    #[must_use]
    pub fn estimates(&self) -> [N; P] {
        self.estimates.map(RunningSum::value)
    }
}

impl<N: Number, const P: usize> GaussNewton<N, P> {
    /// Samples that the law remembers at the start.
    pub const FIRST_MEMORY: f64 = 100.0;

    /// Factor by which the forgetting shrinks each sample.
    pub const SETTLING: f64 = 0.999;

    /// Samples over which the noise level of the moment is taken.
    pub const LEVEL_MEMORY: f64 = 30.0;

    /// The least r over ψᵀP ψ.
    pub const CAUTION: f64 = 20.0;

    /// The law from its configuration.
    ///
    /// # Errors
    /// `noise` must be above zero, `dead_zone` and `uncertainty` at least zero.
    pub fn new(config: &GaussNewtonConfig<P>) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("noise", config.noise)?;
        Allowed::AtLeast(0.0).check("dead_zone", config.dead_zone)?;
        for deviation in config.uncertainty {
            Allowed::AtLeast(0.0).check("uncertainty", deviation)?;
        }
        Ok(Self {
            noise: N::from_f64(config.noise),
            dead_zone: N::from_f64(config.dead_zone),
            settling: N::from_f64(Self::SETTLING),
            short: N::from_f64(1.0 / Self::LEVEL_MEMORY),
            caution: N::from_f64(Self::CAUTION),
            ninth: N::from_f64(1.0 / 9.0),
            low: config.bounds.map(|bound| N::from_f64(bound.min())),
            high: config.bounds.map(|bound| N::from_f64(bound.max())),
            prior: config
                .uncertainty
                .map(|deviation| N::from_f64(deviation * deviation)),
        })
    }

    /// The state with initial estimates, machine units.
    #[must_use]
    pub fn start(&self, estimates: [f64; P]) -> GaussNewtonState<N, P> {
        GaussNewtonState {
            estimates: estimates.map(|value| N::Sum::new(N::from_f64(value))),
            covariance: Covariance::diagonal(self.prior.map(N::to_f64)),
            lost_memory: N::from_f64(1.0 / Self::FIRST_MEMORY),
            level: self.noise,
            peak: self.noise,
            balance: Balance::EMPTY,
            batches: Batches::new(),
        }
    }

    /// The state with estimates and a covariance that are already known, machine units, from a fit
    /// that left errors of this standard deviation. Nothing is forgotten any more.
    #[must_use]
    pub fn resume(
        &self,
        estimates: &[N; P],
        covariance: &[[N; P]; P],
        unexplained: N,
    ) -> GaussNewtonState<N, P> {
        let noise = larger(unexplained * unexplained, self.noise);
        GaussNewtonState {
            covariance: Covariance::of(covariance.map(|row| row.map(N::to_f64))),
            lost_memory: N::ZERO,
            level: noise,
            peak: noise,
            ..self.start(estimates.map(N::to_f64))
        }
    }

    /// One update from ψ = ∂q_e/∂θ, the output error ε and the model's velocity, machine units.
    /// Returns by how much the estimates moved.
    #[inline]
    pub fn update(
        &self,
        state: &mut GaussNewtonState<N, P>,
        sensitivity: &[N; P],
        output_error: N,
        velocity: N,
    ) -> [N; P] {
        let square = output_error * output_error;
        let forgetting = N::ONE - state.lost_memory;
        self.follow_noise(state, square, forgetting);
        if velocity.magnitude() < self.dead_zone {
            return [N::ZERO; P];
        }
        let floor = forgetting * state.peak;
        let mut noise = floor;
        let innovation = state.covariance.measure(sensitivity, |predicted| {
            let surprise = square * self.ninth - predicted;
            noise = larger(floor, larger(surprise, self.caution * predicted));
            noise
        });
        state.balance.observe(square, noise);
        // 1/λ = 1 + x + x² + … for λ = 1 − x, x ≤ 1/100.
        let lost = state.lost_memory;
        let growth = N::ONE + lost * (N::ONE + lost);
        state.covariance.forget(growth, &self.prior);
        state.lost_memory = state.lost_memory * self.settling;
        let steps = innovation.gain.map(|gain| gain * output_error);
        state.batches.observe(&steps);
        core::array::from_fn(|i| {
            let before = state.estimates[i].value();
            let step = steps[i];
            let after = before + step;
            if after >= self.low[i] && after <= self.high[i] {
                state.estimates[i].add(step);
                step
            } else if after.is_finite() {
                let limited = after.limited(self.low[i], self.high[i]);
                state.estimates[i] = N::Sum::new(limited);
                limited - before
            } else {
                N::ZERO
            }
        })
    }

    #[inline]
    fn follow_noise(&self, state: &mut GaussNewtonState<N, P>, square: N, forgetting: N) {
        state.level += self.short * (square - state.level);
        let faded = larger(state.peak * forgetting, self.noise);
        state.peak = larger(state.level, faded);
        if state.level > faded {
            state
                .covariance
                .forget(state.level * faded.reciprocal(), &self.prior);
        }
    }

    /// The standard error of a combination gᵀθ of the parameters, machine units, for a report.
    #[must_use]
    pub fn standard_error(&self, state: &GaussNewtonState<N, P>, combination: &[N; P]) -> f64 {
        let coloured = core::array::from_fn(|i| {
            combination[i] * N::from_f64(libm::sqrt(state.batches.factors[i].to_f64()))
        });
        libm::sqrt(state.balance.ratio() * state.covariance.variance_of(&coloured).to_f64())
    }
}

#[inline]
fn larger<N: Number>(x: N, y: N) -> N {
    if x > y { x } else { y }
}
