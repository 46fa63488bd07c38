use super::fitter::{Fit, Fitter};
use super::pass::Pass;
use crate::adaptation::IdentifiableSet;
use crate::fit::levenberg_marquardt::{bounded_step, judge, moved};
use crate::linalg::NormalEquations;
use crate::number::Number;

/// The unknowns that explain the motion best so far, and the pass that showed it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BestFit<N, I, const Q: usize> {
    pub(super) unknowns: [N; Q],
    pub(super) pass: Pass<N, I, Q>,
}

impl<N, S, const P: usize, const Q: usize> Fitter<N, S, P, Q>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// A pass that changes the cost by less than this fraction is the last.
    const MIN_CHANGE: f64 = 1e-4;

    /// Judges the pass; true if it was the last from this start.
    pub(super) fn end_pass(&self, fit: &mut Fit<N, S::Inputs<N>, P, Q>) -> bool {
        if fit.passes >= Self::MAX_PASSES {
            return true;
        }
        let least = fit.this.as_ref().map(|best| best.pass.equations.cost());
        let cost = fit.pass.equations.cost();
        let judged = judge(cost, least, Self::MIN_CHANGE, &mut fit.damping);
        if judged.helped {
            fit.this = Some(BestFit {
                unknowns: fit.trial,
                pass: fit.pass,
            });
        }
        fit.passes += 1;
        let Some(best) = &fit.this else {
            return true;
        };
        if judged.was_little || fit.passes >= Self::MAX_PASSES {
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

    /// A trial and a step from it.
    fn next_trial(
        &self,
        unknowns: &[N; Q],
        equations: &NormalEquations<N, Q>,
        damping: N,
        free: [bool; Q],
    ) -> [N; Q] {
        let step = bounded_step(equations, unknowns, damping, free, &self.low, &self.high);
        let mut trial = moved(unknowns, &step);
        for i in 0..P {
            trial[i] = trial[i].limited(self.low[i], self.high[i]);
        }
        trial
    }
}
