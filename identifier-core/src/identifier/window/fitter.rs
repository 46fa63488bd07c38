use core::marker::PhantomData;

use super::super::IdentifierError;
use super::super::fit::{FitResult, Fits, Fitter, NumberedBlock, Prior};
use super::super::halves::FitBlocks;
use super::super::settings::Listening;
use super::recorder::{Explained, WindowFitted};
use crate::number::Number;
use crate::parameters::ParameterSet;
use crate::settings::{FromSettings, Settings};

/// The background's half of the windowed identifier: it collects the blocks that a
/// [`WindowRecorder`](super::WindowRecorder) of the same settings has recorded, at most W of them, and
/// fits to them again and again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowFitter<N, S, const P: usize, const W: usize = 256> {
    fitter: Fitter<N>,
    set: PhantomData<S>,
}

/// What the background's half remembers: the record, the fit under way and the last result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowFitterState<N, const W: usize = 256> {
    fits: Fits<N, W>,
    result: Option<FitResult<N>>,
}

impl<N, S, const P: usize, const W: usize> FromSettings for WindowFitter<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// # Errors
    /// See [`IdentifierError`]; every value out of range is named.
    fn from_settings(settings: &Settings) -> Result<Self, IdentifierError> {
        const {
            assert!(
                W >= Self::LEAST_BLOCKS,
                "a window of fewer blocks tells too little"
            )
        };
        let config = Listening::new(settings)?;
        Ok(Self {
            fitter: Fitter::new(&config.fitter(
                |parameter| S::PARAMETERS.contains(&parameter),
                W,
                Self::TIME,
            )?),
            set: PhantomData,
        })
    }
}

impl<N, S, const P: usize, const W: usize> WindowFitter<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// The default time span of the window, s.
    pub const TIME: f64 = 0.5;

    /// Blocks that the first fit needs.
    pub const LEAST_BLOCKS: usize = 32;

    /// The largest relative standard error of b with which a fit counts.
    pub const UNCERTAIN: f64 = 0.2;

    /// Whether a fit is under way.
    #[must_use]
    pub fn is_fitting(&self, state: &WindowFitterState<N, W>) -> bool {
        state.fits.is_under_way()
    }

    fn prior(&self, state: &WindowFitterState<N, W>) -> Prior<N> {
        match &state.result {
            Some(result) => self.fitter.known_from(result),
            None => self.fitter.given(),
        }
    }
}

impl<N: Number> Explained<N> {
    fn of(result: &FitResult<N>) -> Self {
        Self {
            parameters: result.parameters,
            deviations: core::array::from_fn(|i| {
                N::from_f64(libm::sqrt(result.covariance[i][i].to_f64()))
            }),
            at_bound: result.at_bound,
            unexplained: result.unexplained,
            output_error: result.output_error,
        }
    }
}

impl<N, S, const P: usize, const W: usize> FitBlocks<N> for WindowFitter<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    type State = WindowFitterState<N, W>;
    type Fitted = WindowFitted<N>;

    fn start(&self) -> Self::State {
        WindowFitterState {
            fits: Fits::none(),
            result: None,
        }
    }

    fn take(&self, state: &mut Self::State, block: &NumberedBlock<N>) {
        state.fits.take(block);
    }

    fn begin_anew(&self, state: &mut Self::State) {
        state.fits.begin_anew();
    }

    /// Begins a fit as soon as a thirty-second of the window, at least two blocks, is new.
    fn work(&self, state: &mut Self::State, budget: u32) -> Option<Self::Fitted> {
        if !state.fits.is_under_way() {
            let blocks = state.fits.blocks();
            if blocks < Self::LEAST_BLOCKS || state.fits.fresh() < (blocks / 32).max(2) {
                return None;
            }
            let prior = self.prior(state);
            state.fits.begin(&self.fitter, prior);
        }
        let ended = state.fits.go_on(&self.fitter, budget)?;
        let result = ended.result?;
        let good = result.is_good(Self::UNCERTAIN);
        if good {
            state.result = Some(result);
        }
        (good || ended.full).then(|| WindowFitted {
            last: ended.last,
            explained: good.then(|| Explained::of(&result)),
        })
    }
}
