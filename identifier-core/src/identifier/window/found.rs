use crate::model::{ModelState, Sensitivity};
use crate::number::Number;

/// A finished fit, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found<N: Number, F, const P: usize> {
    /// The model, moved to the sample after the window's last: a recursive identifier that goes on
    /// from there needs not wait for a transient to die.
    pub model: ModelState<N, F>,
    /// The model's motion per unit of each parameter, there.
    pub sensitivity: Sensitivity<N, F, P>,
    /// The estimates.
    pub estimates: [N; P],
    /// Their covariance.
    pub covariance: [[N; P]; P],
    /// The standard deviation of what the fit could not explain; at least a count's rounding.
    pub unexplained: N,
    pub(super) load_command: N,
    pub(super) output_error: N,
    pub(super) fits: u32,
}

impl<N: Number, F, const P: usize> Found<N, F, P> {
    pub(super) fn deviations(&self) -> [N; P] {
        core::array::from_fn(|i| N::from_f64(libm::sqrt(self.covariance[i][i].to_f64())))
    }
}
