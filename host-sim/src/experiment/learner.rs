//! The identifiers of the core behind one face, so that one loop serves them all.

use identifier_core::error::StepError;
use identifier_core::identifier::{Identify, Seen};
use identifier_core::model::ServoParameters;
use identifier_core::settings::PerParameter;

/// An identifier with its state: what [`Identify`] is, whatever the types.
pub(crate) trait Learner<N> {
    /// One sample: the increment of the position, position units, and the whole command that acts
    /// from now on. What a method without a model sees is nothing.
    fn learn(&mut self, increment: N, command: N) -> Result<Option<Seen<N>>, StepError>;

    /// What a law does in the background, between two samples: a simulator has all the time that it
    /// wants.
    fn work(&mut self) {}

    /// The estimates, SI.
    fn estimates(&self) -> ServoParameters;

    /// Their standard errors, SI, for laws that have them.
    fn standard_errors(&self) -> Option<ServoParameters> {
        None
    }

    /// Bandwidth of the model's correction, rad/s, where the law chooses it as it goes.
    fn bandwidth(&self) -> Option<f64> {
        None
    }

    /// Which estimates stand at a bound.
    fn at_bounds(&self) -> PerParameter<bool> {
        PerParameter::default()
    }

    /// Joins a motion of so much a sample, before its next sample; the estimates are kept.
    fn join(&mut self, increment: N);
}

/// An identifier with its state.
pub(super) struct Beside<I, T> {
    identifier: I,
    state: T,
}

impl<I, T> Beside<I, T> {
    pub(super) fn new<N: Copy>(identifier: I) -> Self
    where
        I: Identify<N, State = T>,
    {
        Self {
            state: identifier.start(),
            identifier,
        }
    }
}

impl<N: Copy, I: Identify<N>> Learner<N> for Beside<I, I::State> {
    fn learn(&mut self, increment: N, command: N) -> Result<Option<Seen<N>>, StepError> {
        self.identifier
            .learn(&mut self.state, increment, command)
            .map(Some)
    }

    fn work(&mut self) {
        self.identifier.work(&mut self.state, u32::MAX);
    }

    fn estimates(&self) -> ServoParameters {
        self.identifier.estimates(&self.state)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        self.identifier.standard_errors(&self.state)
    }

    fn bandwidth(&self) -> Option<f64> {
        self.identifier.bandwidth(&self.state)
    }

    fn at_bounds(&self) -> PerParameter<bool> {
        self.identifier.at_bounds(&self.state)
    }

    fn join(&mut self, increment: N) {
        self.identifier.join(&mut self.state, increment);
    }
}
