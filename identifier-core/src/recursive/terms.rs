use super::GaussNewtonRecursion;
use super::law::GaussNewtonState;
use super::recursion::{Entered, Recursion};
use crate::model::{IdentifiableSet, ModelValues};
use crate::number::Number;
use crate::parameters::{PerQuantity, Term, Unknown, UsualSizes};

/// The factor on the variances of the estimates when a term enters: they contain its effect.
const VARIANCE_FACTOR: f64 = 100.0;

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// Counts a block in which the model moves. True if a term that is demanded enters now.
    #[inline]
    pub(super) fn count_motion(&self, state: &mut Recursion<N, S, P>) -> bool {
        if !state.law.learning {
            return false;
        }
        let entered = &mut state.entered;
        let moved = if state.model.velocity > N::ZERO {
            &mut entered.forwards
        } else {
            &mut entered.backwards
        };
        *moved = moved.saturating_add(1);
        entered.forwards.min(entered.backwards) >= self.min_motion_blocks && self.admit(state)
    }

    /// Lets the next term enter that is demanded, and returns whether there is one. It is looked for again after as much
    /// motion again.
    #[cold]
    #[inline(never)]
    fn admit(&self, state: &mut Recursion<N, S, P>) -> bool {
        let entered = state.entered.terms;
        let waits = |term: &Term| self.demanded.has(*term) && !entered.has(*term);
        let next = Term::ALL.into_iter().find(waits);
        state.entered = Entered::with(next.map_or(entered, |term| entered.with(term)));
        if let Some(term) = next {
            self.release(&mut state.law, term, state.measured, state.scale);
        }
        next.is_some()
    }

    /// Begins to learn the unknowns of a term.
    fn release(&self, law: &mut GaussNewtonState<N, S, P>, term: Term, omega: N, scale: N) {
        let estimates = law.estimates();
        self.law.settle_anew(law);
        law.factors.grow(
            N::from_f64(VARIANCE_FACTOR),
            &self.most(omega, scale, &estimates),
        );
        for (i, &unknown) in S::UNKNOWNS.iter().enumerate() {
            if term.is_of(unknown) {
                let deviation = Self::prior(unknown, omega, scale, &estimates);
                law.factors.release(i, deviation * deviation);
            }
        }
    }

    /// The standard deviation with which the size of a term enters: its usual size.
    fn prior(unknown: Unknown, omega: N, scale: N, estimates: &[N; P]) -> N {
        /// Friction is at least this part of the motion's acceleration or bandwidth.
        const MIN_FRICTION_SHARE: f64 = 0.1;
        let fine = N::from_f64(MIN_FRICTION_SHARE);
        let parameters = ModelValues::from_values::<S, P>(estimates).parameters;
        unknown.usual_size(|share: N| UsualSizes {
            coulomb: share * parameters.coulomb.larger(fine * scale),
            other: PerQuantity {
                rate: share * parameters.x.larger(fine * omega),
                gain: share * parameters.gain,
                acceleration: share * scale,
                // Of the time in which the loop settles, at least a sample.
                time: N::ONE.larger(share * omega.reciprocal()),
                command: share * scale * parameters.gain.reciprocal(),
            },
        })
    }

    /// Keeps the estimates of the entered terms when the estimator starts from a new fit.
    pub(super) fn keep_terms(
        &self,
        law: &mut GaussNewtonState<N, S, P>,
        before: &Recursion<N, S, P>,
        omega: N,
        scale: N,
    ) {
        let entered = before.entered.terms;
        let (old, new) = (before.law.estimates(), law.estimates());
        for (i, unknown) in S::UNKNOWNS.iter().enumerate() {
            let Some(term) = unknown.term() else { continue };
            law.replace(i, old[i]);
            if entered.has(term) {
                let deviation = Self::prior(*unknown, omega, scale, &new);
                law.factors.release(i, deviation * deviation);
            }
        }
    }
}
