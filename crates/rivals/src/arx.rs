use crate::recursion::RecursionConfig;
use crate::regression::{FilteredRegression, FilteredRegressionState, Form};
use crate::{Filtered, LeastSquaresConfig, plausible};
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
pub type ClosedLoopArx<N> = FilteredRegression<Arx, N, 3>;

/// State of [`ClosedLoopArx`].
pub type ClosedLoopArxState<N> = FilteredRegressionState<N, 3>;

/// ARX with one pole and two zeros.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arx;

impl Arx {
    /// Standard deviations of the initial x/T, 1/s, and of the two gains, rad/s² per command unit.
    const UNCERTAINTY: [f64; 3] = [100.0, 1000.0, 1000.0];
}

impl Form<3> for Arx {
    const PARAMETERS: &'static [Parameter] = &[Parameter::A, Parameter::B];

    fn recursion(
        units: &Units,
        config: &LeastSquaresConfig,
    ) -> Result<RecursionConfig<3>, OutOfRange> {
        let [x, gain] = [Parameter::A, Parameter::B].map(|parameter| parameter.scale(units));
        let initial = -libm::expm1(-config.a * units.rate());
        let half = 0.5 * config.b * gain;
        // A band-passed signal is smaller than its source by the filter's rate.
        let passed = config.cutoff * units.rate();
        Ok(RecursionConfig {
            forgetting: config.forgetting,
            noise: passed * units.acceleration(),
            initial: [initial, half, half],
            uncertainty: [
                Self::UNCERTAINTY[0] * x,
                Self::UNCERTAINTY[1] * gain,
                Self::UNCERTAINTY[2] * gain,
            ],
        })
    }

    #[inline]
    fn regression<N: Number>(
        motion: &Filtered<N>,
        drive: &Filtered<N>,
        [motion_before, drive_before]: [&Filtered<N>; 2],
    ) -> ([N; 3], N) {
        let regressor = [-motion_before.rate, drive.rate, drive_before.rate];
        (regressor, motion.rate - motion_before.rate)
    }

    fn parameters([x, first, second]: [f64; 3], units: &Units) -> Option<ServoParameters> {
        continuous(x, first + second, units)
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
