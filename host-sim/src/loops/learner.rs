//! The identifiers of the core behind one face, so that one loop serves them all.

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::identifier::{Identify, Seen};
use identifier_core::model::ServoParameters;
use identifier_core::parameters::ParameterSet;
use identifier_core::settings::PerParameter;

use crate::experiment::Outcome;
use crate::scenario::place;

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

    /// Which estimates stand at a bound.
    fn at_bounds(&self) -> PerParameter<bool> {
        PerParameter::default()
    }

    /// Joins a motion of so much a sample, before its next sample; the estimates are kept.
    fn join(&mut self, increment: N);

    /// What is known of it besides its samples.
    fn outcome(&self) -> Outcome {
        Outcome::default()
    }
}

/// An identifier of the core that listens beside a controller.
pub(crate) struct Beside<I, T> {
    identifier: I,
    state: T,
    known: Outcome,
}

impl<I, T> Beside<I, T> {
    /// At its start; `known` is what is known of it beforehand.
    pub(crate) fn new<N: Copy>(identifier: I, known: Outcome) -> Self
    where
        I: Identify<N, State = T>,
    {
        Self {
            state: identifier.start(),
            identifier,
            known,
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

    fn at_bounds(&self) -> PerParameter<bool> {
        self.identifier.at_bounds(&self.state)
    }

    fn join(&mut self, increment: N) {
        self.identifier.join(&mut self.state, increment);
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            bandwidth: self.identifier.bandwidth(&self.state),
            ..self.known.clone()
        }
    }
}

/// Γ over the parameters of a set, SI.
pub(crate) fn gamma_of<S: ParameterSet<P>, const P: usize>(
    settings: &Settings,
) -> Option<Vec<Vec<f64>>> {
    let places = S::PARAMETERS.map(place);
    settings.identifier.gamma.map(|gamma| {
        let row = |i: usize| places.iter().map(|&j| gamma[i][j]).collect();
        places.iter().map(|&i| row(i)).collect()
    })
}
