use super::GaussNewtonRecursion;
use super::recursion::Recursion;
use crate::adaptation::{Evidence, GaussNewtonState, IdentifiableSet};
use crate::model::ModelValues;
use crate::number::Number;
use crate::parameters::{PerQuantity, Term, Terms, Unknown, UsualSizes};

/// The least part of the errors that a term must explain beyond the estimates, and
/// the least square of the score over its variance.
const MIN_SHARE: f64 = 0.01;
const MIN_SCORE: f64 = 30.0;

/// The correlation of the errors from block to block above which a load wanders.
const MIN_CORRELATION: f64 = 0.8;

/// The factor on the variances of the estimates when a term enters: they contain its effect.
const VARIANCE_FACTOR: f64 = 100.0;

impl<N, S, const P: usize, const W: usize> GaussNewtonRecursion<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// Takes the mean error of a block as evidence for the terms that have not entered; whether one
    /// enters now.
    #[inline]
    pub(super) fn gather(&self, state: &mut Recursion<N, S, P>, mean: N) -> bool {
        if !state.law.is_learning() {
            state.evidence.interrupt();
            return false;
        }
        let direction = state.model.velocity;
        state
            .evidence
            .observe(state.law.sensitivity(), mean, direction);
        state.evidence.both_ways() >= self.min_motion_blocks && self.consider(state)
    }

    /// Lets a term enter, and returns whether one has. The next test follows after as much motion again.
    #[cold]
    #[inline(never)]
    fn consider(&self, state: &mut Recursion<N, S, P>) -> bool {
        let entered = state.evidence.entered();
        let absent = |&term: &Term| !entered.has(term) && S::has_term::<N>(term);
        let demanded = Term::ALL
            .into_iter()
            .filter(absent)
            .find(|&term| self.demanded.has(term));
        let term = demanded.or_else(|| {
            let settled = !state.evidence.is_settling();
            settled.then(|| self.best_explanation(state, absent))?
        });
        let Some(term) = term else {
            state.evidence.begin_anew();
            return false;
        };
        state.evidence.enter(Terms::NONE.with(term));
        self.release(&mut state.law, term, state.measured, state.scale);
        true
    }

    /// The term that explains most of the errors that are left, if it explains enough.
    fn best_explanation(
        &self,
        state: &Recursion<N, S, P>,
        absent: impl Fn(&Term) -> bool,
    ) -> Option<Term> {
        let entered = state.evidence.entered();
        let free_with = |term: Option<Term>| -> [bool; P] {
            core::array::from_fn(|i| {
                let own = S::UNKNOWNS[i].term();
                self.free[i] && own.is_none_or(|own| entered.has(own) || Some(own) == term)
            })
        };
        let left = state.evidence.left_by(&free_with(None))?;
        let independent = state.evidence.independent();
        let mut best = None;
        let mut most = 0.0;
        let wanders = Term::WanderingLoad;
        if absent(&wanders)
            && self.allowed.has(wanders)
            && state.evidence.correlation() > MIN_CORRELATION
        {
            // The last that is thought of: any other effect colours the errors too.
            best = Some(wanders);
        }
        for term in Term::ALL
            .into_iter()
            .filter(absent)
            .filter(|&term| self.allowed.has(term) && term != wanders)
        {
            let with = state.evidence.left_by(&free_with(Some(term)))?;
            let share = (left - with) / left.max(f64::MIN_POSITIVE);
            let score = independent * share / (1.0 - share).max(f64::MIN_POSITIVE);
            if share > MIN_SHARE && score > MIN_SCORE && share > most {
                most = share;
                best = Some(term);
            }
        }
        best
    }

    /// Begins to learn the unknowns of a term.
    fn release(&self, law: &mut GaussNewtonState<N, S, P>, term: Term, omega: N, scale: N) {
        if term == Term::WanderingLoad {
            law.begin_whitening();
        }
        let estimates = law.estimates();
        self.law.settle_anew(law);
        law.inflate_covariance(
            N::from_f64(VARIANCE_FACTOR),
            &self.most(omega, scale, &estimates),
        );
        for (i, &unknown) in S::UNKNOWNS.iter().enumerate() {
            if term.is_of(unknown) {
                let deviation = Self::prior(unknown, omega, scale, &estimates);
                law.release(i, deviation * deviation);
            }
        }
    }

    /// The standard deviation with which the size of a term enters: its usual size.
    fn prior(unknown: Unknown, omega: N, scale: N, estimates: &[N; P]) -> N {
        /// Friction is at least this part of the motion's acceleration or bandwidth.
        const MIN_FRICTION_SHARE: f64 = 0.1;
        let fine = N::from_f64(MIN_FRICTION_SHARE);
        let parameters = ModelValues::from_values::<S, P>(estimates).parameters;
        let larger = |x: N, y: N| if x > y { x } else { y };
        unknown.usual_size(|share: N| UsualSizes {
            coulomb: share * larger(parameters.coulomb, fine * scale),
            other: PerQuantity {
                rate: share * larger(parameters.x, fine * omega),
                gain: share * parameters.gain,
                acceleration: share * scale,
                // Of the time in which the loop settles, at least a sample.
                time: larger(N::ONE, share * omega.reciprocal()),
                command: share * scale * parameters.gain.reciprocal(),
            },
        })
    }

    /// Keeps the estimates of the terms that have entered in a law that starts from a new fit.
    pub(super) fn keep_terms(
        &self,
        law: &mut GaussNewtonState<N, S, P>,
        before: &Recursion<N, S, P>,
        omega: N,
        scale: N,
    ) {
        let entered = before.evidence.entered();
        if entered.has(Term::WanderingLoad) {
            law.begin_whitening();
        }
        let (old, new) = (before.law.estimates(), law.estimates());
        for (i, unknown) in S::UNKNOWNS.iter().enumerate() {
            let Some(term) = unknown.term() else { continue };
            law.replace(i, old[i]);
            if entered.has(term) {
                let deviation = Self::prior(*unknown, omega, scale, &new);
                law.release(i, deviation * deviation);
            }
        }
    }
}
