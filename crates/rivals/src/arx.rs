use crate::recursion::{Recursion, RecursionConfig};
use crate::{DirectEstimator, FilteredSignals, LeastSquaresConfig, StateVariableFilter, plausible};
use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::units::Units;

/// A discrete-time model of the velocity by recursive least squares in whatever loop runs, as
/// flight controllers identify themselves: ARX with one pole and two zeros on band-passed command
/// and velocity (Ljung, System Identification: Theory for the User, 2nd ed., 1999, section 4.2).
///
/// Under a held command the increments of the exact servo obey
/// Δq_k = (1 − x) Δq_{k−1} + β₁ u_{k−1} + β₂ u_{k−2}, and so do both sides after one filter. The
/// band-pass s λ²/(s + λ)² drops a constant load. The recursion works on Δq_k − Δq_{k−1}, as x is a
/// small number that 1 − x would lose in `f32`. Then a = −ln(1 − x)/T and b = (β₁ + β₂) a/(x T).
///
/// Rounding of the position is noise in the regressor: it pulls the pole inwards, â up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedLoopArx<N> {
    filter: StateVariableFilter<N>,
    recursion: Recursion<N, 3>,
    units: Units,
}

/// State of [`ClosedLoopArx`].
pub type ClosedLoopArxState<N> = FilteredSignals<N, 3>;

impl<N: Number> ClosedLoopArx<N> {
    /// Standard deviations of the initial x/T, 1/s, and of the two gains, rad/s² per command unit.
    const UNCERTAINTY: [f64; 3] = [100.0, 1000.0, 1000.0];

    /// The recursion from its configuration.
    ///
    /// # Errors
    /// The parameter out of its range, by name.
    pub fn new(units: &Units, config: &LeastSquaresConfig) -> Result<Self, OutOfRange> {
        let [x, gain] = [Parameter::A, Parameter::B].map(|parameter| parameter.scale(units));
        let initial = -libm::expm1(-config.a * units.rate());
        let half = 0.5 * config.b * gain;
        // A band-passed signal is smaller than its source by the filter's rate.
        let passed = config.cutoff * units.rate();
        Ok(Self {
            filter: StateVariableFilter::new(units, config.cutoff)?,
            recursion: Recursion::new(&RecursionConfig {
                forgetting: config.forgetting,
                noise: passed * units.acceleration(),
                initial: [initial, half, half],
                uncertainty: [
                    Self::UNCERTAINTY[0] * x,
                    Self::UNCERTAINTY[1] * gain,
                    Self::UNCERTAINTY[2] * gain,
                ],
            })?,
            units: *units,
        })
    }
}

impl<N: Number> DirectEstimator<N> for ClosedLoopArx<N> {
    type State = ClosedLoopArxState<N>;

    const PARAMETERS: &'static [Parameter] = &[Parameter::A, Parameter::B];

    fn start(&self) -> Self::State {
        FilteredSignals::at_rest(&self.recursion)
    }

    #[inline]
    fn process(&self, state: &mut Self::State, increment: N, command: N) {
        let Some([velocity_before, drive_before]) = state.take(&self.filter, increment, command)
        else {
            return;
        };
        let regressor = [-velocity_before, state.drive.rate, drive_before];
        let change = state.motion.rate - velocity_before;
        self.recursion
            .update(&mut state.recursion, &regressor, change);
    }

    fn estimates(&self, state: &Self::State) -> Option<ServoParameters> {
        let [x, first, second] = Recursion::estimates(&state.recursion);
        continuous(x, first + second, &self.units)
    }
}

/// a and b of the held servo with the pole 1 − x and the gains' sum, machine units of `units`.
pub(super) fn continuous(x: f64, gain: f64, units: &Units) -> Option<ServoParameters> {
    /// Below this x, −ln(1 − x)/x is 1 + x/2 to the last digit.
    const SERIES_BELOW: f64 = 1e-8;
    if x >= 1.0 {
        return None;
    }
    let ratio = if x.abs() < SERIES_BELOW {
        1.0 + 0.5 * x
    } else {
        -libm::log1p(-x) / x
    };
    plausible(ServoParameters {
        a: ratio * x / units.rate(),
        b: ratio * gain / units.acceleration(),
        coulomb: 0.0,
        load: 0.0,
    })
}
