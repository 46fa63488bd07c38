//! A motion that the model predicts, sample by sample. The model is that of the identifiers with every term and with
//! parameters that do not change.

pub use crate::linalg::NormalEquations;

use crate::measurement::angle::AngleSettings;
use crate::model::{
    Acting, Amplifier, AmplifierState, FrictionStep, IdentifiableSet, Innovation, KnownInputs,
    ModelValues, ObserverModel, Response,
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
    angle: AngleSettings<f64>,
    step: FrictionStep<f64>,
    response: Response<f64>,
    /// The declared dead band and current loop, in the order of the identifiers. A delay, declared or identified, and
    /// an identified dead band are terms of the model.
    amplifier: Amplifier<f64, 4>,
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

impl ReplayModel {
    /// The longest delay that it can represent, samples.
    pub const MAX_DELAY: f64 = <Inputs as KnownInputs<f64>>::MAX_DELAY;

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
            Some(parameter) => servo.get(parameter),
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
            angle: AngleSettings::new(
                declared.revolution * units.position(),
                declared.ripple_order.unwrap_or(0.0),
            ),
            response: step.step.response(values.parameters.x),
            step,
            amplifier: Amplifier::new(dead_band, 0.0, declared.current_loop / units.sample_time()),
        }
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
    pub fn process(&self, state: &mut ReplayState, increment: f64, command: f64) {
        const NONE: Innovation<f64> = Innovation {
            position: 0.0,
            velocity: 0.0,
        };
        let mut model = ObserverModel {
            error: state.error,
            velocity: state.velocity,
        };
        model.observe(increment);
        let acting = self.take(state, increment, command);
        model.advance::<AllUnknowns, { Unknown::COUNT }>(
            &self.step,
            &self.response,
            &self.values,
            &acting,
            &NONE,
        );
        (state.error, state.velocity) = (model.error, model.velocity);
    }

    fn take(&self, state: &mut ReplayState, increment: f64, command: f64) -> Acting<f64> {
        let (terms, velocity) = (&self.values.terms, state.velocity);
        state
            .inputs
            .take(&self.angle, terms, increment, command, velocity)
    }
}
