mod fitter;
mod recorder;

pub use fitter::{WindowFitter, WindowFitterState};
pub use recorder::{WindowEstimates, WindowFitted, WindowRecorder, WindowRecorderState};

use super::combined::{Combined, CombinedState};
use crate::number::Number;
use crate::parameters::ParameterSet;

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
pub type WindowIdentifier<N, S, const P: usize, const W: usize = 256> =
    Combined<WindowRecorder<N, S, P, W>, WindowFitter<N, S, P, W>>;

/// What the identifier remembers.
pub type WindowState<N, const W: usize = 256> =
    CombinedState<WindowRecorderState<N>, WindowFitterState<N, W>>;

impl<N, S, const P: usize, const W: usize> WindowIdentifier<N, S, P, W>
where
    N: Number,
    S: ParameterSet<P>,
{
    /// Fits that have ended with a result.
    #[must_use]
    pub fn fits(&self, state: &WindowState<N, W>) -> u32 {
        self.recorder().fits(&state.recorder)
    }

    /// Whether a fit is under way.
    #[must_use]
    pub fn is_fitting(&self, state: &WindowState<N, W>) -> bool {
        self.fitter().is_fitting(&state.fitter)
    }

    /// The standard deviation of the last fit's errors, rad; at least a count's rounding. None before
    /// the first fit.
    #[must_use]
    pub fn unexplained(&self, state: &WindowState<N, W>) -> Option<f64> {
        self.recorder().unexplained(&state.recorder)
    }
}
