use core::marker::PhantomData;

use super::super::halves::FitBlocks;
use super::recorder::{WindowFitted, WindowSolution};
use crate::adaptation::IdentifiableSet;
use crate::fit::{FitResult, Fits, Fitter, MIN_TRAVEL_COUNTS, NumberedBlock};
use crate::number::Number;
use crate::parameters::{AbCoulombLoad, Term, Terms};
use crate::reason::Reason;

/// The background's half of the windowed identifier: it collects the blocks that a
/// [`WindowRecorder`](super::WindowRecorder) of the same settings has recorded, at most W of them, and
/// fits to them again and again, as long as the servo moves.
///
/// F is the set of the model that is fitted, with U unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowFitter<
    N,
    S,
    const P: usize,
    const W: usize = 256,
    F = AbCoulombLoad,
    const U: usize = 4,
> {
    pub(crate) fitter: Fitter<N, F, U>,
    pub(crate) set: PhantomData<S>,
}

/// State of the background's half: the record, the fit under way and the last result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowFitterState<N, const W: usize = 256, I = (), const U: usize = 4> {
    fits: Fits<N, W, I, U>,
    result: Option<FitResult<N, U>>,
}

impl<N, S, const P: usize, const W: usize, F, const U: usize> WindowFitter<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    /// The default time span of the window, s.
    pub const TIME: f64 = 0.5;

    /// Blocks that the first fit needs.
    pub const MIN_BLOCKS: usize = 32;

    /// The largest relative standard error of b with which a fit counts.
    pub const UNCERTAIN: f64 = 0.2;

    /// True while a fit is under way.
    #[must_use]
    pub fn is_fitting(&self, state: &WindowFitterState<N, W, F::Inputs<N>, U>) -> bool {
        state.fits.is_under_way()
    }

    /// True if a fit is due: there are enough new blocks, and the servo has moved meanwhile. While it stands the
    /// window loses the motion that it knew, and a fit would rest on the last of it.
    fn is_due(&self, fits: &Fits<N, W, F::Inputs<N>, U>) -> bool {
        let blocks = fits.blocks();
        blocks >= Self::MIN_BLOCKS
            && fits.fresh() >= (blocks / 32).max(2)
            && fits.fresh_path() >= N::from_f64(MIN_TRAVEL_COUNTS)
    }

    /// Begins a fit: with the term that the last result suggests, if it does.
    fn begin(&self, state: &mut WindowFitterState<N, W, F::Inputs<N>, U>) {
        let prior = match &state.result {
            None => self.fitter.given(),
            Some(result) => match result.suggests {
                Some(term) => {
                    let known = self.fitter.known_from(result);
                    self.fitter.admitting(known, result, term)
                }
                None => self.fitter.known_from(result),
            },
        };
        self.fitter.begin(&mut state.fits, prior);
    }

    /// Replaces the last result by a good one that is as certain; true if it did.
    fn takes(&self, last: &mut Option<FitResult<N, U>>, result: &FitResult<N, U>) -> bool {
        let before = last.map_or(Terms::NONE, |last| last.entered::<F>());
        let same_model = result.entered::<F>() == before;
        let mut sure = *result;
        if let Some(last) = last
            && same_model
        {
            last.age();
            if !result.is_as_sure_as(last) {
                return false;
            }
            sure = result.as_sure_as(last);
        } else if !same_model && !self.admits(before, result) {
            if let Some(last) = last {
                // It may be suggested again.
                last.suggests = None;
            }
            return false;
        }
        *last = Some(sure);
        true
    }

    /// True if there is evidence for every new term of a result: each is known better than guessed and,
    /// if it was not demanded, differs from zero.
    fn admits(&self, before: Terms, result: &FitResult<N, U>) -> bool {
        /// The least square of a size over its variance.
        const MIN_SCORE: f64 = 30.0;
        /// The largest standard error of a size, over a usual size.
        const MAX_RELATIVE_ERROR: f64 = 0.5;
        let now = result.entered::<F>();
        let new = |term: &Term| now.has(*term) && !before.has(*term);
        Term::ALL.into_iter().filter(new).all(|term| {
            let mut own = (0..U).filter(|&i| term.is_of(F::UNKNOWNS[i]));
            let known = own.clone().all(|i| {
                let most = N::from_f64(MAX_RELATIVE_ERROR) * result.usual_size::<F>(F::UNKNOWNS[i]);
                result.covariance[i][i] < most * most
            });
            let significant = own.any(|i| {
                let size = result.parameters[i];
                size * size > N::from_f64(MIN_SCORE) * result.covariance[i][i]
            });
            known && (significant || self.fitter.demands(term))
        })
    }
}

impl<N: Number, const U: usize> WindowSolution<N, U> {
    fn from_result(result: &FitResult<N, U>, entered: Terms) -> Self {
        Self {
            parameters: result.parameters,
            deviations: core::array::from_fn(|i| {
                N::from_f64(libm::sqrt(result.covariance[i][i].to_f64()))
            }),
            entered,
            unexplained: result.unexplained,
            output_error: result.output_error,
        }
    }
}

impl<N, S, const P: usize, const W: usize, F, const U: usize> FitBlocks<N>
    for WindowFitter<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    type State = WindowFitterState<N, W, F::Inputs<N>, U>;
    type Fitted = WindowFitted<N, U>;

    fn start(&self) -> Self::State {
        WindowFitterState {
            fits: Fits::none(),
            result: None,
        }
    }

    fn place(&self, state: &mut Self::State, position: N) {
        self.fitter.place(&mut state.fits, position);
    }

    fn take(&self, state: &mut Self::State, block: &NumberedBlock<N>) {
        self.fitter.take(&mut state.fits, block);
    }

    fn begin_anew(&self, state: &mut Self::State) {
        self.fitter.begin_anew(&mut state.fits);
    }

    /// Begins a fit as soon as a thirty-second of the window, at least two blocks, is new and has
    /// motion in it.
    fn work(&self, state: &mut Self::State, budget: u32) -> Option<Self::Fitted> {
        if !state.fits.is_under_way() {
            if !self.is_due(&state.fits) {
                return None;
            }
            self.begin(state);
        }
        let ended = self.fitter.advance(&mut state.fits, budget)?;
        let result = ended.result?;
        let explained = result.is_good(Self::UNCERTAIN);
        // A motion both ways separates friction from load, and more of it tells when the command acts. Estimates from an
        // earlier one last.
        let separated = !result.is_open() || ended.full || state.result.is_some();
        let good = explained && separated && !result.is_at_bound();
        if F::HAS_TERMS
            && !good
            && ended.full
            && let Some(term) = result.suggests
        {
            // A result that is rejected without a term may be good with it.
            let prior = self.fitter.admitting(self.fitter.given(), &result, term);
            self.fitter.begin(&mut state.fits, prior);
            return None;
        }
        if !good && state.result.is_none() && !self.fitter.object(&mut state.fits, &ended) {
            return None;
        }
        if good {
            if !self.takes(&mut state.result, &result) {
                return None;
            }
            state.fits.end_wait();
        }
        (explained && separated || ended.full).then(|| WindowFitted {
            last: ended.last,
            at_bound: result.at_bound,
            explained: good.then(|| WindowSolution::from_result(&result, result.entered::<F>())),
        })
    }

    fn obstacle(&self, state: &Self::State) -> Option<Reason> {
        self.fitter.obstacle(&state.fits)
    }

    fn noise(&self, state: &Self::State) -> Option<f64> {
        Some(libm::sqrt(state.result.as_ref()?.noise.to_f64()))
    }
}
