//! The identifier of a scenario as a log needs it, whatever numbers it computes in.

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::fixed_point::{FixedGradientIdentifier, FixedGradientState, FixedVelocity};
use identifier_core::identifier::{Event, Identify};
use identifier_core::number::Number;
use identifier_core::parameters::{ParameterSet, PerParameter, ServoParameters};
use identifier_core::settings::SettingsError;

use crate::experiment::Outcome;
use crate::loops::{Learner, gamma_of};
use crate::scenario::dispatch::with_words;
use crate::scenario::{Arithmetic, Fault, Scenario};
use crate::simulate::learner;

/// An identifier with its state that is told increments (position units) and commands in double
/// precision.
pub(super) trait Listener {
    /// Joins a motion of so much a sample; the estimates are kept.
    fn join(&mut self, increment: f64);

    /// Says where the servo is before the next sample, position units, for models with an angle.
    fn place(&mut self, _: f64) {}

    /// One sample: how far the position has moved since the last one, and the command that acts from
    /// now on.
    fn listen(&mut self, increment: f64, command: f64) -> Result<Told, StepError>;

    /// The estimates, SI.
    fn estimates(&self) -> ServoParameters;

    /// Their standard errors, SI, for laws that have them.
    fn standard_errors(&self) -> Option<ServoParameters>;

    /// Which estimates stand at a bound.
    fn at_bounds(&self) -> PerParameter<bool>;

    /// What is known of it besides its samples.
    fn outcome(&self) -> Outcome;
}

/// What an identifier says of a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Told {
    /// The command as it computes with it.
    pub(super) command: f64,
    /// Output error (position units) and what happened besides; none for a method without a model.
    pub(super) seen: Option<(f64, Event)>,
}

/// The identifier of a scenario; the settings are those of [`Scenario::settings_for`].
///
/// # Errors
/// The key that it cannot be built from.
pub(super) fn listener(
    scenario: &Scenario,
    settings: &Settings,
) -> Result<Box<dyn Listener>, Fault> {
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => Ok(Box::new(Numbers(learner::<f32>(scenario, settings)?))),
        Arithmetic::F64 => Ok(Box::new(Numbers(learner::<f64>(scenario, settings)?))),
        Arithmetic::Fixed => {
            with_words!(scenario => words(settings)).map_err(|error| scenario.fault(&error))
        }
    }
}

/// An identifier in floating point.
struct Numbers<N>(Box<dyn Learner<N>>);

impl<N: Number> Listener for Numbers<N> {
    fn join(&mut self, increment: f64) {
        self.0.join(N::from_f64(increment));
    }

    fn place(&mut self, position: f64) {
        self.0.place(N::from_f64(position));
    }

    fn listen(&mut self, increment: f64, command: f64) -> Result<Told, StepError> {
        let command = N::from_f64(command);
        let seen = self.0.learn(N::from_f64(increment), command)?;
        self.0.work();
        Ok(Told {
            command: command.to_f64(),
            seen: seen.map(|seen| (seen.output_error.to_f64(), seen.event)),
        })
    }

    fn estimates(&self) -> ServoParameters {
        self.0.estimates()
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        self.0.standard_errors()
    }

    fn at_bounds(&self) -> PerParameter<bool> {
        self.0.at_bounds()
    }

    fn outcome(&self) -> Outcome {
        self.0.outcome()
    }
}

fn words<V, S, const P: usize>(settings: &Settings) -> Result<Box<dyn Listener>, SettingsError>
where
    V: FixedVelocity + 'static,
    S: ParameterSet<P> + 'static,
{
    let identifier: FixedGradientIdentifier<V, S, P> = settings.build()?;
    Ok(Box::new(Words {
        state: identifier.start(),
        identifier,
        gamma: gamma_of::<S, P>(settings),
        position: 0.0,
        count: 0,
    }))
}

/// The identifier in fixed point, which counts.
struct Words<V: FixedVelocity, S, const P: usize> {
    identifier: FixedGradientIdentifier<V, S, P>,
    state: FixedGradientState<V::State, P>,
    gamma: Option<Vec<Vec<f64>>>,
    /// Where the servo is from the first sample, counts, and the count nearest to it.
    position: f64,
    count: i64,
}

impl<V: FixedVelocity, S: ParameterSet<P>, const P: usize> Words<V, S, P> {
    /// Whole counts of an increment, so that no fraction is lost over many.
    fn moved(&mut self, increment: f64) -> i32 {
        self.position += increment;
        let count = self.position.round() as i64;
        let moved = count - self.count;
        self.count = count;
        // A counter of 32 bits.
        moved as i32
    }
}

impl<V: FixedVelocity, S: ParameterSet<P>, const P: usize> Listener for Words<V, S, P> {
    fn join(&mut self, increment: f64) {
        let increment = self.identifier.increment(increment.round() as i32);
        self.identifier.resume_moving(&mut self.state, increment);
    }

    fn listen(&mut self, increment: f64, command: f64) -> Result<Told, StepError> {
        let moved = self.moved(increment);
        let command = self.identifier.command_word(command);
        let seen = self.identifier.process(&mut self.state, moved, command)?;
        Ok(Told {
            command: self.identifier.command(command),
            seen: Some((self.identifier.output_error(&seen), seen.event)),
        })
    }

    fn estimates(&self) -> ServoParameters {
        self.identifier.estimates(&self.state)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        None
    }

    fn at_bounds(&self) -> PerParameter<bool> {
        self.identifier.at_bounds(&self.state)
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            gamma: self.gamma.clone(),
            mu: Some(self.identifier.mu()),
            certified: self.identifier.certificate().is_some(),
            gain_margin: self.identifier.gain_margin(),
            ..Outcome::default()
        }
    }
}
