//! The identifier of a scenario as a log needs it, whatever numbers it computes in.

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::fixed_point::{FixedGradientIdentifier, FixedGradientState, FixedVelocity};
use identifier_core::identifier::{Event, IdentifierError, Identify};
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;
use identifier_core::settings::PerParameter;

use crate::experiment::{Learner, Outcome, known_beforehand, learner};
use crate::scenario::fixed::WithWords;
use crate::scenario::{Arithmetic, Scenario};

/// An identifier with its state that is told increments (position units) and commands in double
/// precision.
pub(super) trait Listener {
    /// Joins a motion of so much a sample; the estimates are kept.
    fn join(&mut self, increment: f64);

    /// One sample: how far the position has moved since the last one, and the command that acts from
    /// now on.
    fn listen(&mut self, increment: f64, command: f64) -> Result<Told, StepError>;

    /// The estimates, SI.
    fn estimates(&self) -> ServoParameters;

    /// Their standard errors, SI, for laws that have them.
    fn standard_errors(&self) -> Option<ServoParameters>;

    /// Which estimates stand at a bound.
    fn at_bounds(&self) -> PerParameter<bool>;

    /// Bandwidth of the model's correction, rad/s, where the law chooses it as it goes.
    fn bandwidth(&self) -> Option<f64>;
}

/// What an identifier says of a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Told {
    /// The command as it computes with it.
    pub(super) command: f64,
    /// Output error (position units) and what happened besides; none for a method without a model.
    pub(super) seen: Option<(f64, Event)>,
}

/// A listener, with what is known of it beforehand.
pub(super) type Built = Result<(Box<dyn Listener>, Outcome), IdentifierError>;

/// The identifier of a scenario; the settings are those of [`Scenario::settings_for`].
pub(super) fn listener(scenario: &Scenario, settings: &Settings) -> Built {
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => floating::<f32>(scenario, settings),
        Arithmetic::F64 => floating::<f64>(scenario, settings),
        Arithmetic::Fixed => scenario.with_words(Fixed(settings)),
    }
}

fn floating<N: Number>(scenario: &Scenario, settings: &Settings) -> Built {
    let (learner, outcome) = learner::<N>(scenario, settings)?;
    Ok((Box::new(Numbers(learner)), outcome))
}

/// An identifier in floating point.
struct Numbers<N>(Box<dyn Learner<N>>);

impl<N: Number> Listener for Numbers<N> {
    fn join(&mut self, increment: f64) {
        self.0.join(N::from_f64(increment));
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

    fn bandwidth(&self) -> Option<f64> {
        self.0.bandwidth()
    }
}

struct Fixed<'a>(&'a Settings);

impl WithWords for Fixed<'_> {
    type Output = Built;

    fn with<V, S, const P: usize>(self) -> Built
    where
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static,
    {
        let identifier: FixedGradientIdentifier<V, S, P> = self.0.build()?;
        let outcome = known_beforehand(self.0, &identifier);
        let listener = Words {
            state: identifier.start(),
            identifier,
            position: 0.0,
            count: 0,
        };
        Ok((Box::new(listener), outcome))
    }
}

/// The identifier in fixed point, which counts.
struct Words<V: FixedVelocity, S, const P: usize> {
    identifier: FixedGradientIdentifier<V, S, P>,
    state: FixedGradientState<V::State, P>,
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
        self.identifier.join(&mut self.state, increment);
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

    fn bandwidth(&self) -> Option<f64> {
        None
    }
}
