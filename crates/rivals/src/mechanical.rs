use crate::recursion::RecursionConfig;
use crate::regression::{FilteredRegression, FilteredRegressionState, Form};
use crate::{Filtered, LeastSquaresConfig, plausible};
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
pub type MechanicalLeastSquares<N> = FilteredRegression<Mechanical, N, 3>;

/// State of [`MechanicalLeastSquares`].
pub type MechanicalLeastSquaresState<N> = FilteredRegressionState<N, 3>;

/// u = J q̈ + F q̇ + P.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mechanical;

impl Mechanical {
    /// Standard deviation of the initial J, relative.
    const RANGE: f64 = 10.0;

    /// An acceleration that a load may cause, rad/s².
    const LOAD: f64 = 100.0;
}

impl Form<3> for Mechanical {
    const PARAMETERS: &'static [Parameter] = &[Parameter::A, Parameter::B, Parameter::Load];

    fn recursion(
        units: &Units,
        config: &LeastSquaresConfig,
    ) -> Result<RecursionConfig<3>, OutOfRange> {
        let b = Allowed::Above(0.0).check("initial.b", config.b)?;
        let inertia = 1.0 / (b * units.acceleration());
        let widest = Self::RANGE * inertia;
        Ok(RecursionConfig {
            forgetting: config.forgetting,
            // That of an acceleration of 1 rad/s².
            noise: inertia * units.acceleration(),
            initial: [inertia, inertia * config.a * units.rate(), 0.0],
            uncertainty: [
                widest,
                widest * config.cutoff * units.rate(),
                widest * Self::LOAD * units.acceleration(),
            ],
        })
    }

    #[inline]
    fn regression<N: Number>(
        motion: &Filtered<N>,
        drive: &Filtered<N>,
        _: [&Filtered<N>; 2],
    ) -> ([N; 3], N) {
        ([motion.rate, motion.value, N::ONE], drive.value)
    }

    fn parameters([inertia, viscous, offset]: [f64; 3], units: &Units) -> Option<ServoParameters> {
        plausible(ServoParameters {
            a: viscous / inertia / units.rate(),
            b: 1.0 / inertia / units.acceleration(),
            coulomb: 0.0,
            load: -offset / inertia / units.acceleration(),
        })
    }
}
