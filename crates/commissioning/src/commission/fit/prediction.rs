use super::PARAMETERS;
use super::motion::MotionRecord;
use super::motion_model::{MotionFit, MotionFitter};
use identifier_core::fit::{Blocks, QUANTISATION_VARIANCE};
use identifier_core::number::Number;

/// The prediction of its own motion by a servo that was fitted to it, under way. Only position and velocity at its
/// beginning are estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PredictionRun<N> {
    fitter: MotionFitter<N>,
    fit: MotionFit<N>,
    /// Sum of the squares of the errors.
    cost: N,
}

impl<N: Number> PredictionRun<N> {
    /// The standard deviation of the encoder's rounding, counts.
    pub(super) fn rounding() -> f64 {
        libm::sqrt(QUANTISATION_VARIANCE)
    }

    /// Begins the prediction of a motion, by unknowns in machine units of a sample.
    pub(super) fn begin(
        fitter: &MotionFitter<N>,
        mut fit: MotionFit<N>,
        unknowns: &[N; PARAMETERS],
    ) -> Self {
        fitter.begin_prediction(&mut fit, unknowns);
        Self {
            fitter: *fitter,
            fit,
            cost: N::ZERO,
        }
    }

    /// Continues by a block; true if there is none left.
    pub(super) fn advance(&mut self, motion: &impl Blocks<N>) -> bool {
        let predicted = self.fitter.predict(&mut self.fit, motion);
        if let Some(predicted) = &predicted {
            self.cost += predicted.error * predicted.error;
        }
        predicted.is_none()
    }

    /// Root mean square of the errors over the motion, counts.
    pub(super) fn error<const W: usize>(&self, motion: &MotionRecord<N, W>) -> f64 {
        libm::sqrt(self.cost.to_f64() / motion.len().max(1) as f64)
    }
}
