use crate::adaptation::NormalEquations;
use crate::control::ControlState;
use crate::model::{ModelState, Sensitivity};
use crate::number::Number;

/// Levenberg's and Marquardt's damping at the start of a fit.
pub(super) const FIRST_DAMPING: f64 = 1e-3;

/// A fit under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit<N: Number, F, const Q: usize> {
    pub(super) next: usize,
    pub(super) samples: usize,
    pub(super) pass: u32,
    pub(super) damping: N,
    pub(super) trial: [N; Q],
    pub(super) best: Option<Best<N, F, Q>>,
    pub(super) control: ControlState<N, F>,
    pub(super) model: ModelState<N, F>,
    pub(super) sensitivity: Sensitivity<N, F, Q>,
    pub(super) equations: NormalEquations<N, Q>,
    pub(super) lag_one: N,
    pub(super) last_error: N,
    pub(super) load_command: N,
    pub(super) lost: bool,
}

impl<N: Number, F, const Q: usize> Fit<N, F, Q> {
    /// Goes on from the best trial with twice as many samples, at most `all`.
    pub(super) fn grow(&mut self, all: usize) {
        if let Some(best) = self.best.take() {
            self.trial = best.unknowns;
        }
        self.samples = (2 * self.samples).min(all);
        self.pass = 0;
        self.damping = N::from_f64(FIRST_DAMPING);
    }
}

/// The best trial so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Best<N: Number, F, const Q: usize> {
    pub(super) model: ModelState<N, F>,
    pub(super) sensitivity: Sensitivity<N, F, Q>,
    pub(super) unknowns: [N; Q],
    pub(super) equations: NormalEquations<N, Q>,
    pub(super) lag_one: N,
    pub(super) load_command: N,
    pub(super) output_error: N,
}
