mod fitter;
mod recorder;

pub use fitter::WindowFitter;
pub(crate) use fitter::WindowFitterState;
pub use recorder::WindowRecorder;
pub(crate) use recorder::WindowRecorderState;

use super::combined::{Combined, CombinedState};
use crate::adaptation::IdentifiableSet;
use crate::number::Number;
use crate::parameters::AbCoulombLoad;

/// The windowed identifier: Levenberg–Marquardt passes of the model, driven by the recorded command,
/// over the last W blocks of samples, for the parameter set S; load and friction are parameters of
/// their own, and the model's initial position and velocity are fitted with them.
///
/// A window uses the same samples again and again, so it identifies a servo from a sixth of a second
/// of motion, without a first guess.
/// [`IdentifierSettings::start_time`](crate::settings::IdentifierSettings::start_time) is the time it
/// spans; each fit result is the prior of the next. The work is cut into slices
/// ([`Identify::work`](super::Identify::work)) and never delays a sample. Nothing is fitted to a servo
/// that does not move.
///
/// It consists of two halves: a chip whose interrupt records while its background fits uses
/// [`WindowRecorder`] and [`WindowFitter`] separately.
///
/// F is the model that is fitted, with U unknowns: without optional terms one for all sets of
/// parameters. With every optional term, for a PC, it is that of
/// [`AllUnknowns`](crate::parameters::AllUnknowns): a term enters when a fit with it is well determined and it was demanded, or is significant. Terms are exact
/// where a block is one sample.
pub type WindowIdentifier<
    N,
    S,
    const P: usize,
    const W: usize = 256,
    F = AbCoulombLoad,
    const U: usize = 4,
> = Combined<WindowRecorder<N, S, P, W, F, U>, WindowFitter<N, S, P, W, F, U>>;

/// State of the identifier.
pub(super) type WindowState<N, const W: usize = 256, I = (), const U: usize = 4> =
    CombinedState<WindowRecorderState<N, U>, WindowFitterState<N, W, I, U>>;

impl<N, S, const P: usize, const W: usize, F, const U: usize> WindowIdentifier<N, S, P, W, F, U>
where
    N: Number,
    S: IdentifiableSet<P>,
    F: IdentifiableSet<U>,
{
    /// Fits that have ended with a result.
    #[must_use]
    pub fn fits(&self, state: &WindowState<N, W, F::Inputs<N>, U>) -> u32 {
        self.recorder().fits(&state.recorder)
    }

    /// True while a fit is under way.
    #[must_use]
    pub fn is_fitting(&self, state: &WindowState<N, W, F::Inputs<N>, U>) -> bool {
        self.fitter().is_fitting(&state.fitter)
    }

    /// The standard deviation of the last fit's errors, rad; at least a count's rounding. None before
    /// the first fit.
    #[must_use]
    pub fn unexplained(&self, state: &WindowState<N, W, F::Inputs<N>, U>) -> Option<f64> {
        self.recorder().unexplained(&state.recorder)
    }
}
