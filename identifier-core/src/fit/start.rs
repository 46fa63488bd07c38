use super::B;
use super::fitter::{Fit, Fitter};
use super::pass::Pass;
use crate::adaptation::IdentifiableSet;
use crate::number::Number;

impl<N, S, const P: usize, const Q: usize> Fitter<N, S, P, Q>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// Standard deviations of the initial position (its rounding), counts, and of the initial
    /// velocity, in counts per block.
    pub(super) const INITIAL: [f64; 2] = [0.288_675, 1e3];

    /// Factors on the gain that the amplitudes suggest: further starts where nothing better is known.
    pub(super) const GAIN_FACTORS: [f64; 5] = [1.0, 0.2, 5.0, 0.03, 30.0];

    /// The unknowns to start from.
    pub(super) fn begin_start(&self, fit: &mut Fit<N, S::Inputs<N>, P, Q>, start: u32) {
        let mut trial = fit.linear[usize::from(start == 1)];
        // Where nothing better is known the gain is what the amplitudes suggest.
        let suggested = fit.survey.gain(fit.omega, fit.blocks);
        if trial[B] <= N::ZERO {
            trial[B] = suggested;
        }
        if start == 2 {
            if !Self::knows_a_parameter(&fit.prior) {
                fit.next = fit.blocks;
                fit.this = None;
                fit.passes = Self::MAX_PASSES;
                return;
            }
            for (value, initial) in trial.iter_mut().zip(fit.prior.initial) {
                *value = initial.unwrap_or(*value);
            }
        }
        if let Some(&factor) = start
            .checked_sub(3)
            .and_then(|step| Self::GAIN_FACTORS.get(step as usize))
        {
            trial = [N::ZERO; Q];
            trial[B] = suggested * N::from_f64(factor);
        }
        let free = self.free_unknowns(&fit.prior);
        for i in 0..P {
            let value = if free[i] {
                match S::UNKNOWNS[i].term() {
                    Some(_) => fit.prior.initial[i].unwrap_or(N::ZERO),
                    None => trial[i],
                }
            } else {
                self.prior.initial[i].unwrap_or(N::ZERO)
            };
            let value = if value.is_finite() { value } else { N::ZERO };
            trial[i] = value.limited(self.low[i], self.high[i]);
        }
        for value in &mut trial[P..] {
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

    pub(super) fn begin_pass(&self, fit: &mut Fit<N, S::Inputs<N>, P, Q>) {
        fit.next = 0;
        fit.pass = Pass::at(&fit.trial, P, fit.inputs);
        self.add_initial(fit);
        for i in 0..P {
            let weight = fit.prior.weight[i];
            if let Some(initial) = fit.prior.initial[i].filter(|_| weight > N::ZERO) {
                let mut row = [N::ZERO; Q];
                row[i] = weight;
                let error = (initial - fit.trial[i]) * weight;
                fit.pass.equations.add(&row, error);
            }
        }
    }

    /// The prior of the initial state, as two more measurements.
    pub(super) fn add_initial(&self, fit: &mut Fit<N, S::Inputs<N>, P, Q>) {
        for (place, weight) in (P..Q).zip(self.initial_weight) {
            let mut row = [N::ZERO; Q];
            if let (Some(own), Some(&value)) = (row.get_mut(place), fit.trial.get(place)) {
                *own = weight;
                fit.pass.equations.add(&row, -(value * weight));
            }
        }
    }
}
