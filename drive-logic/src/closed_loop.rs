//! The loop in single precision, with or without friction: the choice is made once, when it is
//! built, and costs one branch a sample.

use drive_link::{Estimates, Format, LoopSettings, NotAllowed};
use identifier_core::adaptation::GradientUpdate;
use identifier_core::drive::{Actuator, PositionSensor, Tick, TickError, TickState, Ticked};
use identifier_core::identifier::{
    DiagonalGradientIdentifier, GradientIdentifierState, IdentifierError,
};
use identifier_core::measurement::velocity::{LowPass, LowPassState};
use identifier_core::parameters::{Ab, AbCoulomb, ParameterSet};

use crate::parts;

type Velocity = LowPass<f32>;
type Filter = LowPassState<f32>;
type Learnt<const P: usize> = GradientIdentifierState<f32, Filter, P>;

/// Controller and identifier of a servo, with their states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedLoop {
    control: TickState<f32, Filter>,
    identifier: Identifier,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Identifier {
    Plain(DiagonalGradientIdentifier<f32, Velocity, Ab, 2>, Learnt<2>),
    Friction(
        DiagonalGradientIdentifier<f32, Velocity, AbCoulomb, 3>,
        Learnt<3>,
    ),
}

/// What a sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// What the control step did.
    pub ticked: Ticked<f32>,
    /// Output error, counts.
    pub output_error: f32,
    /// Whether the guard shortened the law's step.
    pub slowed: bool,
    /// Whether the model had to be started again.
    pub restarted: bool,
}

impl ClosedLoop {
    /// A loop at rest at a count.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub fn new(settings: &LoopSettings, count: i64) -> Result<Self, NotAllowed> {
        if settings.format != Format::Single {
            return Err(parts::refusal("format", 1.0, 0.0, 0.0));
        }
        Self::build(settings, count).map_err(parts::not_allowed)
    }

    fn build(settings: &LoopSettings, count: i64) -> Result<Self, IdentifierError> {
        let config = parts::config(settings)?;
        let velocity = Velocity::new(&config.units, settings.cutoff)?;
        let identifier = if settings.friction {
            let law = parts::law(settings)?;
            let built = DiagonalGradientIdentifier::new(&config, &law, velocity)?;
            Identifier::Friction(built, built.start())
        } else {
            let law = parts::law(settings)?;
            let built = DiagonalGradientIdentifier::new(&config, &law, velocity)?;
            Identifier::Plain(built, built.start())
        };
        Ok(Self {
            control: TickState::at_rest(count),
            identifier,
        })
    }

    /// At rest at a count, which is where positions are measured from.
    #[must_use]
    pub fn started_at(self, count: i64) -> Self {
        Self {
            control: TickState::at_rest(count),
            ..self
        }
    }

    /// One sample towards a reference, counts from the origin.
    ///
    /// # Errors
    /// [`TickError`]; the actuator was released.
    #[inline]
    pub fn step<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        reference: f32,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<Seen, TickError<S::Error, A::Error>> {
        let control = &mut self.control;
        match &mut self.identifier {
            Identifier::Plain(identifier, learnt) => {
                let tick = Tick::new(identifier.controller());
                let ticked = tick.step(control, reference, sensor, actuator)?;
                Ok(learn(identifier, learnt, ticked))
            }
            Identifier::Friction(identifier, learnt) => {
                let tick = Tick::new(identifier.controller());
                let ticked = tick.step(control, reference, sensor, actuator)?;
                Ok(learn(identifier, learnt, ticked))
            }
        }
    }

    /// The estimates, SI.
    #[must_use]
    pub fn estimates(&self) -> Estimates {
        parts::estimates(&match &self.identifier {
            Identifier::Plain(identifier, learnt) => identifier.estimates(learnt),
            Identifier::Friction(identifier, learnt) => identifier.estimates(learnt),
        })
    }
}

#[inline]
fn learn<S: ParameterSet<P>, const P: usize>(
    identifier: &DiagonalGradientIdentifier<f32, Velocity, S, P>,
    learnt: &mut Learnt<P>,
    ticked: Ticked<f32>,
) -> Seen {
    let seen = identifier.process(learnt, &ticked.sample);
    Seen {
        ticked,
        output_error: seen.output_error,
        slowed: seen.update == GradientUpdate::Slowed,
        restarted: seen.restarted,
    }
}
