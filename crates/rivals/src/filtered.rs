use crate::recursion::{Recursion, RecursionConfig};
use crate::{DirectEstimator, FilteredSignals, LeastSquaresConfig, StateVariableFilter, plausible};
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredLeastSquares<N> {
    filter: StateVariableFilter<N>,
    recursion: Recursion<N, 2>,
    units: Units,
}

/// State of [`FilteredLeastSquares`].
pub type FilteredLeastSquaresState<N> = FilteredSignals<N, 2>;

impl<N: Number> FilteredLeastSquares<N> {
    /// Standard deviations of the initial [â, b̂], 1/s and rad/s² per command unit, for a filtered
    /// acceleration with noise of 1 rad/s²: so wide that the first second of data outweighs them.
    const UNCERTAINTY: [f64; 2] = [100.0, 1000.0];

    /// The recursion from its configuration.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    pub fn new(units: &Units, config: &LeastSquaresConfig) -> Result<Self, OutOfRange> {
        let scale = [Parameter::A, Parameter::B].map(|parameter| parameter.scale(units));
        let initial = [config.a, config.b];
        Ok(Self {
            filter: StateVariableFilter::new(units, config.cutoff)?,
            recursion: Recursion::new(&RecursionConfig {
                forgetting: config.forgetting,
                noise: units.acceleration(),
                initial: core::array::from_fn(|i| initial[i] * scale[i]),
                uncertainty: core::array::from_fn(|i| Self::UNCERTAINTY[i] * scale[i]),
            })?,
            units: *units,
        })
    }
}

impl<N: Number> DirectEstimator<N> for FilteredLeastSquares<N> {
    type State = FilteredLeastSquaresState<N>;

    const PARAMETERS: &'static [Parameter] = &[Parameter::A, Parameter::B];

    fn start(&self) -> Self::State {
        FilteredSignals::at_rest(&self.recursion)
    }

    #[inline]
    fn process(&self, state: &mut Self::State, increment: N, command: N) {
        if state.take(&self.filter, increment, command).is_none() {
            return;
        }
        let regressor = [-state.motion.value, state.drive.value];
        self.recursion
            .update(&mut state.recursion, &regressor, state.motion.rate);
    }

    fn estimates(&self, state: &Self::State) -> Option<ServoParameters> {
        let [x, gain] = Recursion::estimates(&state.recursion);
        plausible(ServoParameters {
            a: x / self.units.rate(),
            b: gain / self.units.acceleration(),
            coulomb: 0.0,
            load: 0.0,
        })
    }
}
