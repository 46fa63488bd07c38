use crate::recursion::RecursionConfig;
use crate::regression::{FilteredRegression, FilteredRegressionState, Form};
use crate::{Filtered, LeastSquaresConfig, plausible};
use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::units::Units;

/// Recursive least squares with forgetting factor on filtered input and output: the method that
/// the paper compares itself with.
///
/// Dividing (2) with d = 0 by Λ(s) = (s + λ)²/λ² leaves signals that follow from
/// position and command: q̈_f = −a q̇_f + b u_f. Both filters are the exact zero-order-hold step
/// of the same Λ over the sample just passed: the command was held, and a position taken as
/// straight between two samples has the held velocity Δq. The prediction error
/// q̈_f − θ̂ᵀ[−q̇_f, u_f] drives the usual recursion with forgetting factor (Nelles, Nonlinear
/// System Identification, 2001, section 3.2).
///
/// It has no term for a constant load: a load biases it.
pub type FilteredLeastSquares<N> = FilteredRegression<InputOutput, N, 2>;

/// State of [`FilteredLeastSquares`].
pub type FilteredLeastSquaresState<N> = FilteredRegressionState<N, 2>;

/// q̈_f = −a q̇_f + b u_f.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputOutput;

impl InputOutput {
    /// Standard deviations of the initial [â, b̂], 1/s and rad/s² per command unit, for a filtered
    /// acceleration with noise of 1 rad/s²: so wide that the first second of data outweighs them.
    const UNCERTAINTY: [f64; 2] = [100.0, 1000.0];
}

impl Form<2> for InputOutput {
    const PARAMETERS: &'static [Parameter] = &[Parameter::A, Parameter::B];

    fn recursion(
        units: &Units,
        config: &LeastSquaresConfig,
    ) -> Result<RecursionConfig<2>, OutOfRange> {
        let scale = [Parameter::A, Parameter::B].map(|parameter| parameter.scale(units));
        let initial = [config.a, config.b];
        Ok(RecursionConfig {
            forgetting: config.forgetting,
            noise: units.acceleration(),
            initial: core::array::from_fn(|i| initial[i] * scale[i]),
            uncertainty: core::array::from_fn(|i| Self::UNCERTAINTY[i] * scale[i]),
        })
    }

    #[inline]
    fn regression<N: Number>(
        motion: &Filtered<N>,
        drive: &Filtered<N>,
        _: [&Filtered<N>; 2],
    ) -> ([N; 2], N) {
        ([-motion.value, drive.value], motion.rate)
    }

    fn parameters([x, gain]: [f64; 2], units: &Units) -> Option<ServoParameters> {
        plausible(ServoParameters {
            a: x / units.rate(),
            b: gain / units.acceleration(),
            coulomb: 0.0,
            load: 0.0,
        })
    }
}
