use super::IdentifierError;
use crate::control::{CommandLimit, Controller, Gains, Pid};
use crate::error::{Allowed, OutOfRange};
use crate::interval::Interval;
use crate::measurement::velocity::{Transfer, VelocityEstimate};
use crate::model::{FrictionStep, HeldStep, ModelLoop, ServoParameters};
use crate::number::Number;
use crate::parameters::{Parameter, ParameterSet};
use crate::stability::sampled_loop;
use crate::stability::{Certificate, PlantBox};
use crate::units::Units;

/// What every identifier is built from, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IdentifierConfig {
    /// Sample time and position unit.
    pub units: Units,
    /// The gains of the PID that runs.
    pub gains: Gains,
    /// The amplifier's limit.
    pub limit: CommandLimit,
    /// Where the true servo may lie. With a box the identifier is built only if the box is
    /// certified; without one nothing is promised, and the bounds of the estimates stand in for it
    /// where a law needs one.
    pub plant_box: Option<PlantBox>,
    /// Initial estimates; what the model of an identifier has not got is ignored.
    pub initial: ServoParameters,
    /// Box that the estimates are kept in.
    pub bounds: Bounds,
}

/// The box that estimates are kept in, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// â, 1/s.
    pub a: Interval,
    /// b̂, rad/s² per command unit; above zero.
    pub b: Interval,
    /// ĉ, rad/s²; at least zero.
    pub coulomb: Interval,
    /// d̂, rad/s².
    pub load: Interval,
}

impl Bounds {
    /// The bounds of one parameter.
    #[must_use]
    pub fn of(&self, parameter: Parameter) -> Interval {
        match parameter {
            Parameter::A => self.a,
            Parameter::B => self.b,
            Parameter::Coulomb => self.coulomb,
            Parameter::Load => self.load,
        }
    }
}

/// What the stability checks found for the box of a configuration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Promise {
    pub(super) certificate: Certificate,
    pub(super) gain_margin: f64,
}

/// The largest b̂, ĉ and |d̂|, SI: far beyond any servo, and small enough that the model loop stays
/// in the range of single precision.
const LARGEST: f64 = 1e9;

impl IdentifierConfig {
    /// The controller that this configuration describes, with the velocity estimate that the
    /// drive uses.
    #[must_use]
    pub fn controller<N: Number, V: VelocityEstimate<N>>(&self, velocity: V) -> Controller<N, V> {
        Controller {
            pid: Pid::new(&self.units, &self.gains, &self.limit),
            velocity,
        }
    }

    /// The box, or what stands in for it.
    #[must_use]
    pub fn assumed_box(&self) -> PlantBox {
        self.plant_box
            .unwrap_or_else(|| PlantBox::spanning(self.bounds.a, self.bounds.b))
    }

    pub(super) fn model_loop<N: Number, V: VelocityEstimate<N>>(
        &self,
        velocity: V,
    ) -> ModelLoop<N, V> {
        ModelLoop {
            controller: self.controller(velocity),
            step: FrictionStep::new(),
        }
    }

    /// Initial estimates of a parameter set, machine units.
    pub(super) fn initial_of<S: ParameterSet<P>, const P: usize>(&self) -> [f64; P] {
        S::PARAMETERS.map(|parameter| parameter.of(&self.initial) * parameter.scale(&self.units))
    }

    /// Bounds of a parameter set, machine units.
    pub(super) fn bounds_of<S: ParameterSet<P>, const P: usize>(&self) -> [Interval; P] {
        S::PARAMETERS.map(|parameter| {
            self.bounds
                .of(parameter)
                .scaled(parameter.scale(&self.units))
        })
    }

    /// Checks bounds and initial estimates of a parameter set.
    pub(super) fn check<S: ParameterSet<P>, const P: usize>(&self) -> Result<(), OutOfRange> {
        let fastest = HeldStep::<f64>::LARGEST_RATE / self.units.rate();
        for parameter in S::PARAMETERS {
            let (bounds_name, initial_name, low, high) = match parameter {
                Parameter::A => ("bounds.a", "initial.a", -fastest, fastest),
                Parameter::B => ("bounds.b", "initial.b", f64::MIN_POSITIVE, LARGEST),
                Parameter::Coulomb => ("bounds.coulomb", "initial.coulomb", 0.0, LARGEST),
                Parameter::Load => ("bounds.load", "initial.load", -LARGEST, LARGEST),
            };
            let allowed = if parameter == Parameter::B {
                Allowed::PositiveUpTo(high)
            } else {
                Allowed::Within(low, high)
            };
            let bounds = self.bounds.of(parameter);
            allowed.check(bounds_name, bounds.min())?;
            allowed.check(bounds_name, bounds.max())?;
            Allowed::Within(bounds.min(), bounds.max())
                .check(initial_name, parameter.of(&self.initial))?;
        }
        Ok(())
    }

    /// Certifies the box, if there is one, for a μ, and checks its sampled loop.
    pub(super) fn certify(
        &self,
        mu: f64,
        velocity: &Transfer,
    ) -> Result<Option<Promise>, IdentifierError> {
        let Some(plant_box) = &self.plant_box else {
            return Ok(None);
        };
        let certificate = Certificate::new(&self.gains, plant_box, mu)?;
        sampled_loop::check(&self.units, &self.gains, velocity, plant_box)?;
        Ok(Some(Promise {
            certificate,
            gain_margin: sampled_loop::gain_margin(&self.units, &self.gains, velocity, plant_box),
        }))
    }
}
