//! The identifiers of the core behind one face, so that one loop serves them all.

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::identifier::{Event, Identify, Seen};
use identifier_core::model::ServoParameters;
use identifier_core::parameters::ParameterSet;
use identifier_core::settings::PerParameter;
use identifier_core::unknowns::{Term, Unknown};

use crate::experiment::{Outcome, TermEstimate};
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

    /// Says where the servo is before its next sample, position units, for models with an angle.
    fn place(&mut self, _: N) {}

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
    samples: u64,
    /// When each term entered, samples, and which have.
    entered: Vec<(Term, u64)>,
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
            samples: 0,
            entered: Vec::new(),
        }
    }
}

impl<I, T> Beside<I, T> {
    /// Notes when a term that has entered did so.
    fn note_terms<N: Copy>(&mut self)
    where
        I: Identify<N, State = T>,
    {
        let entered = self.identifier.entered(&self.state);
        for term in Term::ALL.into_iter().filter(|&term| entered.has(term)) {
            if self.entered.iter().all(|(known, _)| *known != term) {
                self.entered.push((term, self.samples));
            }
        }
    }

    fn terms<N: Copy>(&self) -> Vec<TermEstimate>
    where
        I: Identify<N, State = T>,
    {
        let shown = self.identifier.show(&self.state);
        let estimate = |unknown: Unknown| {
            let (_, since) = self
                .entered
                .iter()
                .find(|(term, _)| Some(*term) == unknown.term())?;
            Some(TermEstimate {
                unknown,
                value: self.identifier.value_of(&shown, unknown)?,
                std_error: self.identifier.standard_error_of(&self.state, unknown)?,
                since: *since,
            })
        };
        Unknown::ALL.into_iter().filter_map(estimate).collect()
    }
}

impl<N: Copy, I: Identify<N>> Learner<N> for Beside<I, I::State> {
    fn learn(&mut self, increment: N, command: N) -> Result<Option<Seen<N>>, StepError> {
        let seen = self.identifier.learn(&mut self.state, increment, command)?;
        if seen.event == Event::TermEntered {
            self.note_terms();
        }
        self.samples += 1;
        Ok(Some(seen))
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

    fn place(&mut self, position: N) {
        self.identifier.place(&mut self.state, position);
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            bandwidth: self.identifier.bandwidth(&self.state),
            entered: self.entered.clone(),
            terms: self.terms(),
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
