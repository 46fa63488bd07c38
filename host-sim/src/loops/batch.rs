use identifier_core::error::{OutOfRange, StepError};
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use identifier_core::replay::NormalEquations;
use identifier_core::units::Units;
use rivals::{Filtered, StateVariableFilter};

use super::{DynIdentifier, Innovation, NO_ESTIMATE};

/// Off-line least squares of q̈_f = −a q̇_f + b u_f over all samples so far, in double precision:
/// what Adam and Guestrin do after an experiment in a proportional loop of low gain
/// ("Identification and robust control for an experimental servomotor", ISA Transactions 41(2),
/// 2002).
pub(crate) struct BatchLeastSquares {
    units: Units,
    /// To the number format of the loop.
    rounded: fn(f64) -> f64,
    filter: StateVariableFilter<f64>,
    command: f64,
    motion: Filtered<f64>,
    drive: Filtered<f64>,
    equations: NormalEquations<f64, 2>,
}

impl BatchLeastSquares {
    /// With filters of a cut-off, rad/s.
    ///
    /// # Errors
    /// The cut-off must be below what the sample time allows.
    pub(crate) fn new<N: Number>(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        Ok(Self {
            units: *units,
            rounded: |value| N::from_f64(value).to_f64(),
            filter: StateVariableFilter::new(units, cutoff)?,
            command: 0.0,
            motion: Filtered::AT_REST,
            drive: Filtered::AT_REST,
            equations: NormalEquations::EMPTY,
        })
    }
}

impl DynIdentifier for BatchLeastSquares {
    fn update(&mut self, increment: f64, command: f64) -> Result<Innovation, StepError> {
        let (increment, command) = ((self.rounded)(increment), (self.rounded)(command));
        self.filter.process(&mut self.motion, increment);
        self.filter.process(&mut self.drive, self.command);
        self.equations
            .add(&[-self.motion.value, self.drive.value], self.motion.rate);
        self.command = command;
        Ok(Innovation {
            command,
            update: None,
        })
    }

    fn estimates(&self) -> ServoParameters {
        let [x, gain] = self.equations.solve(0.0, &[true; 2]);
        if gain > 0.0 {
            ServoParameters {
                a: x / self.units.rate(),
                b: gain / self.units.acceleration(),
                coulomb: 0.0,
                load: 0.0,
            }
        } else {
            NO_ESTIMATE
        }
    }
}
