//! A recorded motion through the model, sample by sample: prediction, innovation and regressor.
//!
//! The model is that of the identifiers with every term and with parameters that do not change. With
//! [`ReplayModel::corrected`] it follows the record. Its [innovations](ReplaySample::innovation) then show how certain
//! the parameters are and which effects the model lacks. Without it the model predicts.

pub use crate::linalg::NormalEquations;

use crate::measurement::angle::AngleSettings;
use crate::model::IdentifiableSet;
use crate::model::{
    Acting, Amplifier, AmplifierState, FrictionPhase, FrictionStep, Innovation, KnownInputs,
    ModelStep, ModelValues, MovingStep, ObserverModel, Response, sensitivity,
};
use crate::parameters::{AllUnknowns, ServoParameters, Unknown};
use crate::settings::TermSettings;
use crate::units::Units;

/// The commands that a delay reaches back to, and the angle.
type Inputs = <AllUnknowns as IdentifiableSet<{ Unknown::COUNT }>>::Inputs<f64>;

/// A servo of constant parameters, with every term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayModel {
    values: ModelValues<f64>,
    /// All unknowns are finite.
    is_finite: bool,
    angle: AngleSettings<f64>,
    step: FrictionStep<f64>,
    response: Response<f64>,
    /// The declared dead band and current loop, in the order of the identifiers. A delay, declared or identified, and
    /// an identified dead band are terms of the model.
    amplifier: Amplifier<f64, 4>,
    innovation: Innovation<f64>,
}

/// The state of a [`ReplayModel`], position units and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayState {
    /// Measured position less the model's: after the last measured increment before a sample, before the
    /// next one after it.
    pub error: f64,
    /// Velocity of the model.
    pub velocity: f64,
    inputs: Inputs,
    amplifier: AmplifierState<f64, 4>,
}

/// One sample of a [`ReplayModel`], position units and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplaySample {
    /// Output error: measured position less predicted position, before it corrects the model.
    pub innovation: f64,
    /// The model's own motion.
    pub displacement: f64,
    /// The mean of sign q̇ over the sample.
    pub direction: f64,
    /// The mean of the command that acts, behind delay and dead band, command units.
    pub command: f64,
    /// b T²/ρ.
    pub gain: f64,
    acting: Acting<f64>,
    moved: ModelStep<f64>,
}

impl ReplayModel {
    /// The longest delay that it can represent, samples.
    pub const MAX_DELAY: f64 = <Inputs as KnownInputs<f64>>::MAX_DELAY;

    /// The largest a T that the model's step is meant for.
    const LARGEST_RATE: f64 = 0.5;

    /// A servo with these parameters, its declared terms, and the identified sizes of terms, SI. An identified size
    /// replaces a declared one.
    #[must_use]
    pub fn new(
        units: &Units,
        servo: &ServoParameters,
        declared: &TermSettings,
        found: impl IntoIterator<Item = (Unknown, f64)>,
    ) -> Self {
        let place = |wanted| Unknown::ALL.iter().position(|&one| one == wanted);
        let mut sizes = Unknown::ALL.map(|unknown| match unknown.parameter() {
            Some(parameter) => parameter.value_in(servo),
            None if unknown == Unknown::Delay => declared.delay,
            // A declared dead band is the amplifier's.
            None => 0.0,
        });
        let mut dead_band = declared.dead_band;
        for (unknown, size) in found {
            if unknown == Unknown::DeadBand {
                dead_band = 0.0;
            }
            if let Some(place) = place(unknown) {
                sizes[place] = size;
            }
        }
        for (size, unknown) in sizes.iter_mut().zip(Unknown::ALL) {
            *size *= unknown.scale(units);
        }
        let mut values = ModelValues::from_values::<AllUnknowns, { Unknown::COUNT }>(&sizes);
        let delay = values.terms.delay;
        if delay.is_finite() {
            values.terms.delay = delay.clamp(0.0, Self::MAX_DELAY);
        }
        if let Some(speed) = declared.low_speed_velocity {
            values.terms.per_low_speed_velocity = 1.0 / (speed * units.velocity());
        }
        let step = FrictionStep::new();
        Self {
            values,
            is_finite: sizes.iter().all(|size| size.is_finite()),
            angle: AngleSettings::new(
                declared.revolution * units.position(),
                declared.ripple_order.unwrap_or(0.0),
            ),
            response: step.step.response(values.parameters.x),
            step,
            amplifier: Amplifier::new(dead_band, 0.0, declared.current_loop / units.sample_time()),
            innovation: Innovation {
                position: 0.0,
                velocity: 0.0,
            },
        }
    }

    /// The same, with a critically damped correction towards the measured motion. Its double pole is at `omega`,
    /// radians per sample.
    #[must_use]
    pub fn corrected(self, omega: f64) -> Self {
        Self {
            innovation: Innovation::critically_damped(omega),
            ..self
        }
    }

    /// True if the model can move as this servo. Its gain is positive, no friction is negative, and its viscous
    /// friction is within the range of the model's step.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let parameters = &self.values.parameters;
        self.is_finite
            && parameters.x.abs() <= Self::LARGEST_RATE
            && parameters.gain > 0.0
            && parameters.coulomb >= 0.0
    }

    /// b T²/ρ.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.values.parameters.gain
    }

    /// Rad per position unit; zero for an axis without angle.
    #[must_use]
    pub fn angle_resolution(&self) -> f64 {
        self.angle.resolution
    }

    /// At a position with a velocity, before the first command.
    #[must_use]
    pub fn start(&self, position: f64, velocity: f64) -> ReplayState {
        let mut inputs = Inputs::START;
        inputs.place(&self.angle, position);
        ReplayState {
            error: 0.0,
            velocity,
            inputs,
            amplifier: self.amplifier.start(),
        }
    }

    /// The mean over a sample of a command behind the declared dead band and current loop.
    pub fn amplify(&self, state: &mut ReplayState, command: f64) -> f64 {
        self.amplifier.process(&mut state.amplifier, command)
    }

    /// Takes the increment of a sample and the [amplified](Self::amplify) command from there on, without
    /// a motion of the model.
    pub fn record(&self, state: &mut ReplayState, increment: f64, command: f64) {
        self.take(state, increment, command);
    }

    /// The same, and moves the model until the next sample.
    pub fn process(&self, state: &mut ReplayState, increment: f64, command: f64) -> ReplaySample {
        let mut model = ObserverModel {
            error: state.error,
            velocity: state.velocity,
        };
        model.observe(increment);
        let innovation = model.error;
        let acting = self.take(state, increment, command);
        let moved = model.advance::<AllUnknowns, { Unknown::COUNT }>(
            &self.step,
            &self.response,
            &self.values,
            &acting,
            &self.innovation,
        );
        (state.error, state.velocity) = (model.error, model.velocity);
        ReplaySample {
            innovation,
            displacement: moved.displacement,
            direction: moved.phase.mean_direction(),
            command: acting.command,
            gain: self.gain(),
            acting,
            moved,
        }
    }

    /// The regressor: the acceleration over a sample per unit of an unknown.
    #[must_use]
    pub fn regressor(&self, sample: &ReplaySample, unknown: Unknown) -> f64 {
        let moving = MovingStep {
            displacement: sample.displacement,
            direction: sample.direction,
            stribeck_factor: sample.moved.stribeck_factor,
        };
        sensitivity(&self.values, unknown, &sample.acting, &moving)
    }

    /// The sensitivities of the model's position and velocity to the size of an effect, one sample later. In the sample
    /// a unit of the effect accelerates the servo by `push` and shifts the measured position by `output`. They are of
    /// first order in the sample time, which is enough for a direction.
    #[must_use]
    pub fn propagate(
        &self,
        sample: &ReplaySample,
        [position, velocity]: [f64; 2],
        push: f64,
        output: f64,
    ) -> [f64; 2] {
        let kept = match sample.moved.phase {
            FrictionPhase::Moving { .. } => 1.0,
            FrictionPhase::Turned { slowing, .. } => slowing,
            FrictionPhase::Stuck | FrictionPhase::Stopped { .. } => 0.0,
        };
        let braked = 1.0 - self.values.parameters.x;
        let velocity = match sample.moved.phase {
            FrictionPhase::Stuck => 0.0,
            _ => braked * velocity - self.innovation.velocity * output + push,
        };
        let position = position + (velocity - self.innovation.position * output);
        [position, kept * velocity]
    }

    fn take(&self, state: &mut ReplayState, increment: f64, command: f64) -> Acting<f64> {
        let (terms, velocity) = (&self.values.terms, state.velocity);
        state
            .inputs
            .take(&self.angle, terms, increment, command, velocity)
    }
}
