use super::fitter::{Fit, Fitter};
use super::pass::Pass;
use crate::adaptation::NormalEquations;
use crate::number::Number;
use crate::unknowns::UnknownSet;

/// The unknowns that explain the motion best so far, and the pass that showed it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Best<N, I, const Q: usize> {
    pub(super) unknowns: [N; Q],
    pub(super) pass: Pass<N, I, Q>,
}

impl<N, S, const P: usize, const Q: usize> Fitter<N, S, P, Q>
where
    N: Number,
    S: UnknownSet<P>,
{
    /// A pass that lowers the cost by less than this fraction is the last.
    const ENOUGH: f64 = 1e-4;

    /// The factor by which a better or worse pass changes the damping.
    const CHANGE: f64 = 10.0;

    /// Judges the pass; true if it was the last from this start.
    pub(super) fn end_pass(&self, fit: &mut Fit<N, S::Inputs<N>, P, Q>) -> bool {
        if fit.passes >= Self::PASSES {
            return true;
        }
        let cost = fit.pass.equations.cost();
        let mut little = false;
        let mut helped = cost.is_finite();
        if let Some(best) = &fit.this {
            let least = best.pass.equations.cost();
            little = (least - cost).magnitude() <= N::from_f64(Self::ENOUGH) * least;
            helped = helped && cost < least;
        }
        if helped {
            fit.this = Some(Best {
                unknowns: fit.trial,
                pass: fit.pass,
            });
        }
        let factor = if helped {
            1.0 / Self::CHANGE
        } else {
            Self::CHANGE
        };
        fit.damping = fit.damping * N::from_f64(factor);
        fit.passes += 1;
        let Some(best) = &fit.this else {
            return true;
        };
        if little || fit.passes >= Self::PASSES {
            return true;
        }
        fit.trial = self.next_trial(
            &best.unknowns,
            &best.pass.equations,
            fit.damping,
            self.free_unknowns(&fit.prior),
        );
        false
    }

    /// A trial and a step from it. A parameter at a bound that would leave it is kept there, and the
    /// step is taken without it, so that the others do not compensate for it.
    fn next_trial(
        &self,
        unknowns: &[N; Q],
        equations: &NormalEquations<N, Q>,
        damping: N,
        mut free: [bool; Q],
    ) -> [N; Q] {
        let mut step = equations.solve(damping, &free);
        for _ in 0..P {
            let mut held = false;
            for i in 0..P {
                let at = unknowns[i];
                let outward = (at <= self.low[i] && step[i] < N::ZERO)
                    || (at >= self.high[i] && step[i] > N::ZERO);
                if free[i] && outward {
                    free[i] = false;
                    held = true;
                }
            }
            if !held {
                break;
            }
            step = equations.solve(damping, &free);
        }
        core::array::from_fn(|i| {
            let moved = unknowns[i] + step[i];
            if i < P && moved.is_finite() {
                moved.limited(self.low[i], self.high[i])
            } else if moved.is_finite() {
                moved
            } else {
                unknowns[i]
            }
        })
    }
}
