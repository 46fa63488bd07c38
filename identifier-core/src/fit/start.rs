use super::B;
use super::fitter::{Fit, Fitter};
use super::gain::KalmanGain;
use super::levenberg_marquardt::Descent;
use super::pass::Pass;
use super::statistics::root;
use crate::model::IdentifiableSet;
use crate::number::Number;
use crate::parameters::Term;

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// Factors on the gain that the amplitudes suggest: further starts if there is no better one.
    pub(super) const GAIN_FACTORS: [f64; 5] = [1.0, 0.2, 5.0, 0.03, 30.0];

    /// The start from the prior, behind the two of the linear pass.
    pub(super) const FROM_PRIOR: u32 = 2;

    /// The unknowns to start from.
    pub(super) fn begin_start(&self, fit: &mut Fit<N, P>, start: u32) {
        let mut trial = fit.linear[usize::from(start == 1)];
        // Where nothing better is known the gain is what the amplitudes suggest.
        let suggested = fit.statistics.gain(fit.horizon.reciprocal(), fit.blocks);
        if trial[B] <= N::ZERO {
            trial[B] = suggested;
        }
        if start == Self::FROM_PRIOR {
            for (value, initial) in trial.iter_mut().zip(fit.prior.initial) {
                *value = initial.unwrap_or(*value);
            }
        }
        if let Some(&factor) = start
            .checked_sub(3)
            .and_then(|step| Self::GAIN_FACTORS.get(step as usize))
        {
            trial = [N::ZERO; P];
            trial[B] = suggested * N::from_f64(factor);
        }
        let free = self.free_unknowns(&fit.prior);
        for i in 0..P {
            let value = if free[i] {
                match S::UNKNOWNS[i].term() {
                    // It is linear in the linear pass too.
                    None | Some(Term::Gravity) => trial[i],
                    Some(_) => fit.prior.initial[i].unwrap_or(N::ZERO),
                }
            } else {
                self.prior.initial[i].unwrap_or(N::ZERO)
            };
            let value = if value.is_finite() { value } else { N::ZERO };
            trial[i] = value.limited(self.low[i], self.high[i]);
        }
        fit.trial = trial;
        fit.descent = Descent::begin(&Self::DESCENT);
        self.begin_pass(fit);
    }

    pub(super) fn begin_pass(&self, fit: &mut Fit<N, P>) {
        fit.next = 0;
        fit.pass = self.first_pass(fit);
        let deviation = root(fit.noise);
        for i in 0..P {
            let weight = fit.prior.weight[i] * deviation;
            if let Some(initial) = fit.prior.initial[i].filter(|_| weight > N::ZERO) {
                fit.pass.equations.expect(i, weight, initial - fit.trial[i]);
            }
        }
    }

    /// A pass before its first block.
    pub(super) fn first_pass(&self, fit: &Fit<N, P>) -> Pass<N, P> {
        let velocity = match self.at_first {
            Some(variance) => variance * fit.noise.reciprocal(),
            // More than the square of any.
            None => fit.statistics.travel_square + N::ONE,
        };
        let gain = KalmanGain::begin(fit.horizon, velocity);
        Pass::at_first(gain, self.reversal(fit))
    }
}
