use crate::recursion::{Recursion, RecursionConfig};
use crate::{DirectEstimator, FilteredSignals, LeastSquaresConfig, StateVariableFilter, plausible};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::units::Units;

/// Recursive least squares of the mechanical equation on differentiated position, as motor-control
/// firmware identifies the mechanics behind its current loop:
/// u = J q̈ + F q̇ + P with J = 1/b, F = a/b and the offset P = −d/b.
///
/// Velocity and acceleration come from one low-pass of second order over the increments, and the
/// command passes the same low-pass, so that all three lag alike. The acceleration is a *regressor*:
/// its noise pulls Ĵ towards zero, and the estimate of b up, as coarse encoders show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MechanicalLeastSquares<N> {
    filter: StateVariableFilter<N>,
    recursion: Recursion<N, 3>,
    units: Units,
}

/// State of [`MechanicalLeastSquares`].
pub type MechanicalLeastSquaresState<N> = FilteredSignals<N, 3>;

impl<N: Number> MechanicalLeastSquares<N> {
    /// Standard deviation of the initial J, relative.
    const RANGE: f64 = 10.0;

    /// An acceleration that a load may cause, rad/s².
    const LOAD: f64 = 100.0;

    /// The recursion from its configuration.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    pub fn new(units: &Units, config: &LeastSquaresConfig) -> Result<Self, OutOfRange> {
        let filter = StateVariableFilter::new(units, config.cutoff)?;
        let b = Allowed::Above(0.0).check("initial.b", config.b)?;
        let inertia = 1.0 / (b * units.acceleration());
        let widest = Self::RANGE * inertia;
        Ok(Self {
            filter,
            recursion: Recursion::new(&RecursionConfig {
                forgetting: config.forgetting,
                // That of an acceleration of 1 rad/s².
                noise: inertia * units.acceleration(),
                initial: [inertia, inertia * config.a * units.rate(), 0.0],
                uncertainty: [
                    widest,
                    widest * config.cutoff * units.rate(),
                    widest * Self::LOAD * units.acceleration(),
                ],
            })?,
            units: *units,
        })
    }
}

impl<N: Number> DirectEstimator<N> for MechanicalLeastSquares<N> {
    type State = MechanicalLeastSquaresState<N>;

    const PARAMETERS: &'static [Parameter] = &[Parameter::A, Parameter::B, Parameter::Load];

    fn start(&self) -> Self::State {
        FilteredSignals::at_rest(&self.recursion)
    }

    #[inline]
    fn process(&self, state: &mut Self::State, increment: N, command: N) {
        if state.take(&self.filter, increment, command).is_none() {
            return;
        }
        let regressor = [state.motion.rate, state.motion.value, N::ONE];
        self.recursion
            .update(&mut state.recursion, &regressor, state.drive.value);
    }

    fn estimates(&self, state: &Self::State) -> Option<ServoParameters> {
        let [inertia, viscous, offset] = Recursion::estimates(&state.recursion);
        plausible(ServoParameters {
            a: viscous / inertia / self.units.rate(),
            b: 1.0 / inertia / self.units.acceleration(),
            coulomb: 0.0,
            load: -offset / inertia / self.units.acceleration(),
        })
    }
}
