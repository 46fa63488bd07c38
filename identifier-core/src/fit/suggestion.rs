use super::fitter::Fit;
use super::survey::larger;
use super::{Fitter, Prior};
use crate::adaptation::IdentifiableSet;
use crate::number::Number;
use crate::parameters::Term;

/// The least part of the errors that a term must explain, beyond the part explained by the estimates.
const MIN_SHARE: f64 = 0.01;

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// The terms that may enter and that a fit with this prior does not have.
    fn candidates(&self, prior: &Prior<N, P>) -> impl Iterator<Item = Term> {
        Term::ALL.into_iter().filter(move |term| {
            (0..P).any(|i| self.free[i] && prior.initial[i].is_none() && term.is_of(S::UNKNOWNS[i]))
        })
    }

    /// True if there is one.
    pub(super) fn has_candidates(&self, prior: &Prior<N, P>) -> bool {
        S::HAS_TERMS && self.candidates(prior).next().is_some()
    }

    /// The term to try next, after a pass that measured all that may enter: one that is demanded, or
    /// the one that explains most of the errors that are left (a score test).
    pub(super) fn suggestion(&self, fit: &Fit<N, S::Inputs<N>, P>) -> Option<Term> {
        let mut demanded = self.candidates(&fit.prior);
        if let Some(term) = demanded.find(|&term| self.demanded.has(term)) {
            return Some(term);
        }
        let equations = &fit.pass.equations;
        let free = self.free_unknowns(&fit.prior);
        let left = equations.cost() - equations.explained_by(&free);
        let per_left = larger(left, N::from_f64(1e-12)).reciprocal();
        let explained_with = |term: Term| {
            let with = core::array::from_fn(|i| {
                let own = S::UNKNOWNS.get(i).is_some_and(|&own| term.is_of(own));
                free[i] || (own && self.free[i])
            });
            let with_it = equations.cost() - equations.explained_by(&with);
            (left - with_it) * per_left
        };
        self.candidates(&fit.prior)
            .map(|term| (term, explained_with(term)))
            .filter(|&(_, share)| share > N::from_f64(MIN_SHARE))
            .reduce(|one, other| if other.1 > one.1 { other } else { one })
            .map(|(term, _)| term)
    }
}
