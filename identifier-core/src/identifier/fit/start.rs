use super::fitter::{Fit, Fitter};
use super::pass::Pass;
use super::{B, POSITION, UNKNOWNS, VELOCITY};
use crate::number::Number;

impl<N: Number> Fitter<N> {
    /// Standard deviations of the initial position (its rounding), counts, and of the initial
    /// velocity, in counts per block.
    const INITIAL: [f64; 2] = [0.288_675, 1e3];

    /// Factors on the gain that the amplitudes suggest: further starts where nothing better is known.
    pub(super) const LADDER: [f64; 5] = [1.0, 0.2, 5.0, 0.03, 30.0];

    /// The unknowns to start from.
    pub(super) fn begin_start(&self, fit: &mut Fit<N>, start: u32) {
        let mut trial = fit.linear[usize::from(start == 1)];
        // Where nothing better is known the gain is what the amplitudes suggest.
        let suggested = fit.survey.gain(fit.omega, fit.blocks);
        if trial[B] <= N::ZERO {
            trial[B] = suggested;
        }
        if start == 2 {
            if fit.prior.initial.iter().all(Option::is_none) {
                fit.next = fit.blocks;
                fit.this = None;
                fit.passes = Self::PASSES;
                return;
            }
            for (value, initial) in trial.iter_mut().zip(fit.prior.initial) {
                *value = initial.unwrap_or(*value);
            }
        }
        if let Some(&factor) = start
            .checked_sub(3)
            .and_then(|step| Self::LADDER.get(step as usize))
        {
            trial = [N::ZERO; UNKNOWNS];
            trial[B] = suggested * N::from_f64(factor);
        }
        for i in 0..4 {
            let value = if self.free[i] {
                trial[i]
            } else {
                self.prior.initial[i].unwrap_or(N::ZERO)
            };
            let value = if value.is_finite() { value } else { N::ZERO };
            trial[i] = value.limited(self.low[i], self.high[i]);
        }
        for value in &mut trial[POSITION..] {
            if !value.is_finite() {
                *value = N::ZERO;
            }
        }
        fit.trial = trial;
        fit.damping = N::from_f64(Self::FIRST_DAMPING);
        fit.passes = 0;
        fit.this = None;
        self.begin_pass(fit);
    }

    pub(super) fn begin_pass(&self, fit: &mut Fit<N>) {
        fit.next = 0;
        fit.pass = Pass::at(&fit.trial);
        self.add_initial(fit);
        for i in 0..4 {
            let weight = fit.prior.weight[i];
            if let Some(initial) = fit.prior.initial[i].filter(|_| weight > N::ZERO) {
                let mut row = [N::ZERO; UNKNOWNS];
                row[i] = weight;
                let error = (initial - fit.trial[i]) * weight;
                fit.pass.equations.add(&row, error);
            }
        }
    }

    /// The prior of the initial state, as two more measurements.
    pub(super) fn add_initial(&self, fit: &mut Fit<N>) {
        let noise = libm::sqrt(self.noise.to_f64());
        for (place, deviation) in [POSITION, VELOCITY].into_iter().zip(Self::INITIAL) {
            let mut row = [N::ZERO; UNKNOWNS];
            row[place] = N::from_f64(noise / deviation);
            let error = -(fit.trial[place] * row[place]);
            fit.pass.equations.add(&row, error);
        }
    }
}
