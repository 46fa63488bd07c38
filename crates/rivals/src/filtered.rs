use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::units::Units;

use crate::recursion::{Recursion, RecursionConfig, RecursionState};
use crate::{Filtered, LeastSquaresConfig, StateVariableFilter};

/// Recursive least squares with forgetting factor on filtered input and output: the method that
/// the paper compares itself with.
///
/// Dividing (2) with d = 0 by Λ(s) = (s + λ)²/λ² leaves signals that follow from position and command: q̈_f = −a q̇_f +
/// b u_f. Both filters are the exact zero-order-hold step of the same Λ over the last sample. The command was held. A
/// position that is linear between two samples has the held velocity Δq. The prediction error q̈_f − θ̂ᵀ[−q̇_f, u_f]
/// drives the usual recursion with forgetting factor (Nelles, Nonlinear System Identification, 2001, section 3.2).
///
/// It needs command and motion of the servo, not the controller, so it takes recorded logs too. It has no term for a
/// constant load: a load biases it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredLeastSquares<N> {
    filter: StateVariableFilter<N>,
    recursion: Recursion<N, 2>,
    units: Units,
}

/// State of a [`FilteredLeastSquares`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredLeastSquaresState<N: Number> {
    /// The command that acts until the next sample.
    command: N,
    motion: Filtered<N>,
    drive: Filtered<N>,
    recursion: RecursionState<N, 2>,
}

impl<N: Number> FilteredLeastSquares<N> {
    /// Standard deviations of the initial [â, b̂], 1/s and rad/s² per command unit, for a filtered acceleration with
    /// noise of 1 rad/s². They are so wide that the first second of data outweighs them.
    const UNCERTAINTY: [f64; 2] = [100.0, 1000.0];

    /// The recursion from its configuration.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    pub fn new(units: &Units, config: &LeastSquaresConfig) -> Result<Self, OutOfRange> {
        let scale = [Parameter::A, Parameter::B].map(|parameter| parameter.scale(units));
        let initial = [config.a, config.b];
        let recursion = RecursionConfig {
            forgetting: config.forgetting,
            noise: units.acceleration(),
            initial: core::array::from_fn(|i| initial[i] * scale[i]),
            uncertainty: core::array::from_fn(|i| Self::UNCERTAINTY[i] * scale[i]),
        };
        Ok(Self {
            filter: StateVariableFilter::new(units, config.cutoff)?,
            recursion: Recursion::new(&recursion)?,
            units: *units,
        })
    }

    /// The state before the first sample.
    #[must_use]
    pub fn start(&self) -> FilteredLeastSquaresState<N> {
        FilteredLeastSquaresState {
            command: N::ZERO,
            motion: Filtered::AT_REST,
            drive: Filtered::AT_REST,
            recursion: self.recursion.start(),
        }
    }

    /// One sample: the increment of the measured position since the last (machine units), and the command
    /// that is held from now on.
    #[inline]
    pub fn process(&self, state: &mut FilteredLeastSquaresState<N>, increment: N, command: N) {
        if !(increment.is_finite() && command.is_finite()) {
            return;
        }
        self.filter.process(&mut state.motion, increment);
        self.filter.process(&mut state.drive, state.command);
        state.command = command;
        let regressor = [-state.motion.value, state.drive.value];
        self.recursion
            .update(&mut state.recursion, &regressor, state.motion.rate);
    }

    /// a and b, SI, the others zero; none while they cannot be those of a servo: finite, and b above zero.
    #[must_use]
    pub fn estimates(&self, state: &FilteredLeastSquaresState<N>) -> Option<ServoParameters> {
        let [a, b] = Recursion::estimates(&state.recursion);
        let (a, b) = (a / self.units.rate(), b / self.units.acceleration());
        let found = a.is_finite() && b.is_finite() && b > 0.0;
        found.then_some(ServoParameters::new(a, b, 0.0, 0.0))
    }
}
