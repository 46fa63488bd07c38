use identifier_core::Settings;
use identifier_core::fixed_point::{
    FixedServoLoop, FixedServoLoopState, FixedVelocity, split_setpoint,
};
use identifier_core::identifier::{
    GradientIdentifier, IdentifierError, Identify, ServoLoop, ServoLoopState,
};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;
use identifier_core::units::Units;

use crate::scenario::fixed::WithWords;
use crate::scenario::{Scenario, WithTypes};

/// The number formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Double precision, what the others are held against.
    F64,
    /// Single precision.
    F32,
    /// Fixed point.
    Fixed,
}

impl Format {
    /// All of them, the reference first.
    pub const ALL: [Self; 3] = [Self::F64, Self::F32, Self::Fixed];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F64 => "f64",
            Self::F32 => "f32",
            Self::Fixed => "fixed",
        }
    }
}

/// What a format makes of a sample, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Signals {
    /// Velocity estimate, rad/s.
    pub velocity: f64,
    /// Command, command units.
    pub command: f64,
    /// Output error, rad.
    pub output_error: f64,
    /// The estimates.
    pub estimates: ServoParameters,
}

/// Loop and identifier of one format.
pub(super) trait Beside {
    /// One sample: where the servo is to be, counts and an offset, and where it is.
    fn process(&mut self, setpoint: i32, offset: f64, count: i32) -> Signals;
}

/// Those of a floating-point format, at rest at a count.
pub(super) fn floating<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
    count: i32,
) -> Result<Box<dyn Beside>, IdentifierError> {
    scenario.with_types::<N, _>(Build { settings, count })
}

struct Build<'a> {
    settings: &'a Settings,
    count: i32,
}

impl<N: Number> WithTypes<N> for Build<'_> {
    type Output = Result<Box<dyn Beside>, IdentifierError>;

    fn with<V, S, const P: usize>(self) -> Self::Output
    where
        V: VelocityEstimate<N> + 'static,
        S: ParameterSet<P> + 'static,
    {
        let Self { settings, count } = self;
        let servo_loop: ServoLoop<N, V, GradientIdentifier<N, V, S, P>> = settings.build()?;
        Ok(Box::new(Floating {
            state: servo_loop.start(count),
            servo_loop,
            units: settings.units()?,
        }))
    }
}

struct Floating<N: Number, V: VelocityEstimate<N>, I: Identify<N>> {
    servo_loop: ServoLoop<N, V, I>,
    state: ServoLoopState<N, V::State, I::State>,
    units: Units,
}

impl<N: Number, V: VelocityEstimate<N>, I: Identify<N>> Beside for Floating<N, V, I> {
    fn process(&mut self, setpoint: i32, offset: f64, count: i32) -> Signals {
        let offset = N::from_f64(offset);
        let step = self
            .servo_loop
            .process(&mut self.state, setpoint, offset, count);
        let (velocity, command, output_error) =
            step.map_or((f64::NAN, f64::NAN, f64::NAN), |step| {
                (
                    step.control.velocity.to_f64(),
                    step.control.command.to_f64(),
                    step.seen.output_error.to_f64(),
                )
            });
        Signals {
            velocity: velocity / self.units.velocity(),
            command,
            output_error: output_error * self.units.position_unit(),
            estimates: self
                .servo_loop
                .identifier()
                .estimates(self.state.identification()),
        }
    }
}

/// Those of fixed point, at rest at a count.
pub(super) fn fixed(
    scenario: &Scenario,
    settings: &Settings,
    count: i32,
) -> Result<Box<dyn Beside>, IdentifierError> {
    scenario.with_words(Build { settings, count })
}

impl WithWords for Build<'_> {
    type Output = Result<Box<dyn Beside>, IdentifierError>;

    fn with<V, S, const P: usize>(self) -> Self::Output
    where
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static,
    {
        let Self { settings, count } = self;
        let servo_loop: FixedServoLoop<V, S, P> = settings.build()?;
        Ok(Box::new(Words {
            state: servo_loop.start(count),
            servo_loop,
            units: settings.units()?,
        }))
    }
}

struct Words<V: FixedVelocity, S, const P: usize> {
    servo_loop: FixedServoLoop<V, S, P>,
    state: FixedServoLoopState<V::State, P>,
    units: Units,
}

impl<V: FixedVelocity, S: ParameterSet<P>, const P: usize> Beside for Words<V, S, P> {
    fn process(&mut self, setpoint: i32, offset: f64, count: i32) -> Signals {
        let (controller, identifier) = (self.servo_loop.controller(), self.servo_loop.identifier());
        let (whole, part) = split_setpoint(offset);
        let setpoint = setpoint.wrapping_add(whole);
        let step = self
            .servo_loop
            .process(&mut self.state, setpoint, part, count);
        let (velocity, command, output_error) =
            step.map_or((f64::NAN, f64::NAN, f64::NAN), |step| {
                (
                    controller.velocity(step.control.velocity),
                    controller.command(step.control.command),
                    identifier.output_error(&step.seen),
                )
            });
        Signals {
            velocity: velocity / self.units.velocity(),
            command,
            output_error: output_error * self.units.position_unit(),
            estimates: identifier.estimates(self.state.identification()),
        }
    }
}
