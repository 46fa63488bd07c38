use core::marker::PhantomData;

use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::units::Units;

use crate::recursion::{Recursion, RecursionConfig, RecursionState};
use crate::{DirectEstimator, Filtered, LeastSquaresConfig, StateVariableFilter};

/// A form of the servo's equation that is linear in P unknowns.
pub trait Form<const P: usize> {
    /// The parameters that it gives.
    const PARAMETERS: &'static [Parameter];

    /// The recursion's configuration.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    fn recursion(
        units: &Units,
        config: &LeastSquaresConfig,
    ) -> Result<RecursionConfig<P>, OutOfRange>;

    /// The factors of the unknowns, and their sum as measured; `before` is the motion and the drive of the sample
    /// before.
    fn regression<N: Number>(
        motion: &Filtered<N>,
        drive: &Filtered<N>,
        before: [&Filtered<N>; 2],
    ) -> ([N; P], N);

    /// The parameters, SI, of the unknowns, machine units.
    fn parameters(unknowns: [f64; P], units: &Units) -> Option<ServoParameters>;
}

/// Recursive least squares on filtered motion and command, by a `Form` of the servo's equation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredRegression<F, N, const P: usize> {
    filter: StateVariableFilter<N>,
    recursion: Recursion<N, P>,
    units: Units,
    form: PhantomData<F>,
}

/// State of a [`FilteredRegression`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredRegressionState<N: Number, const P: usize> {
    /// The command that acts until the next sample.
    command: N,
    motion: Filtered<N>,
    drive: Filtered<N>,
    recursion: RecursionState<N, P>,
}

impl<F: Form<P>, N: Number, const P: usize> FilteredRegression<F, N, P> {
    /// The recursion from its configuration.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    pub fn new(units: &Units, config: &LeastSquaresConfig) -> Result<Self, OutOfRange> {
        Ok(Self {
            filter: StateVariableFilter::new(units, config.cutoff)?,
            recursion: Recursion::new(&F::recursion(units, config)?)?,
            units: *units,
            form: PhantomData,
        })
    }
}

impl<F: Form<P>, N: Number, const P: usize> DirectEstimator<N> for FilteredRegression<F, N, P> {
    type State = FilteredRegressionState<N, P>;

    const PARAMETERS: &'static [Parameter] = F::PARAMETERS;

    fn start(&self) -> Self::State {
        FilteredRegressionState {
            command: N::ZERO,
            motion: Filtered::AT_REST,
            drive: Filtered::AT_REST,
            recursion: self.recursion.start(),
        }
    }

    #[inline]
    fn process(&self, state: &mut Self::State, increment: N, command: N) {
        if !(increment.is_finite() && command.is_finite()) {
            return;
        }
        let (motion, drive) = (state.motion, state.drive);
        self.filter.process(&mut state.motion, increment);
        self.filter.process(&mut state.drive, state.command);
        state.command = command;
        let (regressor, measured) = F::regression(&state.motion, &state.drive, [&motion, &drive]);
        self.recursion
            .update(&mut state.recursion, &regressor, measured);
    }

    fn estimates(&self, state: &Self::State) -> Option<ServoParameters> {
        F::parameters(Recursion::estimates(&state.recursion), &self.units)
    }
}
