use core::marker::PhantomData;

use super::super::halves::FitBlocks;
use super::beginning::{FirstFitSolution, GaussNewtonFitted};
use crate::adaptation::IdentifiableSet;
use crate::fit::{Ended, FitResult, Fits, Fitter, NumberedBlock, place_of};
use crate::linalg::Factors;
use crate::number::Number;
use crate::parameters::Unknown;

/// The background's half of the fast identifier: it collects the blocks that a
/// [`GaussNewtonRecursion`](super::GaussNewtonRecursion) of the same settings has recorded, at most W of them, and fits the
/// parameters with which the recursion starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonFitter<N, S, const P: usize, const W: usize = 256> {
    pub(crate) fitter: Fitter<N>,
    pub(crate) free: [bool; P],
    pub(crate) set: PhantomData<S>,
}

/// The state of the background's half: the record and the fit under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonFitterState<N, const W: usize = 256> {
    fits: Fits<N, W>,
    /// Fits to a full record that did not explain the motion.
    failures: u32,
}

impl<N, S, const P: usize, const W: usize> GaussNewtonFitter<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// True if a recursion can start from a fit result. It waits for a motion in both directions,
    /// which separates friction from load.
    fn is_good(result: &FitResult<N>, full: bool) -> bool {
        if full {
            result.is_good(0.2)
        } else {
            result.is_good(0.03) && result.only_direction == N::ZERO
        }
    }

    /// Of d − c sign(q̇), which is all that motion in one direction shows, makes c as much as it can be
    /// and d the rest, so that where the fit happened to end does not matter.
    fn take_all_for_friction(&self, estimates: &mut [N; P], direction: N) {
        let mut resistance = N::ZERO;
        let mut ambiguous = 0;
        for i in 0..P {
            match S::UNKNOWNS[i] {
                Unknown::Coulomb if self.free[i] => resistance += estimates[i],
                Unknown::Load if self.free[i] => resistance += -direction * estimates[i],
                _ => continue,
            }
            ambiguous += 1;
        }
        if ambiguous < 2 {
            return;
        }
        let friction = resistance.limited(N::ZERO, N::REACH);
        for i in 0..P {
            match S::UNKNOWNS[i] {
                Unknown::Coulomb => estimates[i] = friction,
                Unknown::Load => estimates[i] = direction * (friction - resistance),
                _ => {}
            }
        }
    }

    /// A fit result with its covariance in factors.
    fn explained(&self, result: &FitResult<N>) -> FirstFitSolution<N, S, P> {
        /// The factor on the fit's covariance: its gradients were taken far from the truth, and its
        /// errors are not white.
        const COVARIANCE_FACTOR: f64 = 4.0;
        let places = S::UNKNOWNS.map(place_of);
        let scale = result.acceleration.to_f64();
        // Motion in one direction determines only d − c sign(q̇), not c and d separately.
        let ambiguity = |i: usize| match S::UNKNOWNS[i] {
            Unknown::Coulomb => scale * 0.5,
            Unknown::Load => scale * 0.5 * result.only_direction.to_f64(),
            _ => 0.0,
        };
        let one_way = result.only_direction != N::ZERO;
        let covariance: [[f64; P]; P] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let (Some(row), Some(column)) = (places[i], places[j]) else {
                    return 0.0;
                };
                let entry = result.covariance.get(row).and_then(|row| row.get(column));
                let known = COVARIANCE_FACTOR * entry.map_or(0.0, |entry| entry.to_f64());
                if S::HAS_COULOMB && one_way && self.free[i] && self.free[j] {
                    known + ambiguity(i) * ambiguity(j)
                } else {
                    known
                }
            })
        });
        let mut estimates = places.map(|place| {
            let value = place.and_then(|i| result.parameters.get(i));
            value.copied().unwrap_or(N::ZERO)
        });
        if one_way {
            self.take_all_for_friction(&mut estimates, result.only_direction);
        }
        FirstFitSolution {
            estimates,
            covariance: Factors::from_matrix(&covariance),
            unexplained: result.unexplained,
            bandwidth: result.bandwidth,
            acceleration: result.acceleration,
            one_way,
        }
    }
}

impl<N, S, const P: usize, const W: usize> FitBlocks<N> for GaussNewtonFitter<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    type State = GaussNewtonFitterState<N, W>;
    type Fitted = GaussNewtonFitted<N, S, P>;

    fn start(&self) -> Self::State {
        GaussNewtonFitterState {
            fits: Fits::none(),
            failures: 0,
        }
    }

    fn take(&self, state: &mut Self::State, block: &NumberedBlock<N>) {
        if !state.fits.is_next(block) {
            self.begin_anew(state);
        }
        state.fits.take(block);
    }

    fn begin_anew(&self, state: &mut Self::State) {
        state.fits.begin_anew();
        state.failures = 0;
    }

    /// Begins a fit when half of the record is there, and again whenever a quarter is new. A result
    /// that the recursion can start from ends the record; results that do not explain a full record
    /// are passed on now and then.
    fn work(&self, state: &mut Self::State, budget: u32) -> Option<Self::Fitted> {
        if !state.fits.is_under_way() {
            if state.fits.blocks() < W / 2 || state.fits.fresh() < W / 4 {
                return None;
            }
            state.fits.begin(&self.fitter, self.fitter.given());
        }
        let Ended { result, last, full } = state.fits.advance(&self.fitter, budget)?;
        if let Some(result) = result.filter(|result| Self::is_good(result, full)) {
            self.begin_anew(state);
            return Some(GaussNewtonFitted {
                last,
                explained: Some(self.explained(&result)),
            });
        }
        state.failures = state.failures.saturating_add(u32::from(full));
        (full && state.failures % 4 == 2).then_some(GaussNewtonFitted {
            last,
            explained: None,
        })
    }
}
