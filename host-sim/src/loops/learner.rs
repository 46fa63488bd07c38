//! The identifiers of the core behind one face, so that one loop serves them all.

use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::identifier::{Event, Identify, Update};
use identifier_core::parameters::{
    ParameterSet, PerParameter, ServoParameters, Term, Terms, Unknown,
};

use crate::experiment::{Outcome, TermEstimate};
use crate::scenario::place;

/// An identifier with its state: what [`Identify`] is, whatever the types.
pub(crate) trait Learner<N> {
    /// One sample: the increment of the position, position units, and the whole command that acts
    /// from now on. What a method without a model sees is nothing.
    fn learn(&mut self, increment: N, command: N) -> Result<Option<Update<N>>, StepError>;

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
    entered: Entries,
}

/// The terms that have entered, and the sample in which each did. What is not of an identifier's type
/// is compiled once here, and not for every identifier.
#[derive(Default)]
struct Entries(Vec<(Term, u64)>);

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
            entered: Entries::default(),
        }
    }
}

impl<I, T> Beside<I, T> {
    fn terms<N: Copy>(&self) -> Vec<TermEstimate>
    where
        I: Identify<N, State = T>,
    {
        let shown = self.identifier.snapshot(&self.state);
        self.entered.estimates(&mut |unknown| {
            let value = self.identifier.value_in(&shown, unknown)?;
            Some((
                value,
                self.identifier.standard_error_of(&self.state, unknown)?,
            ))
        })
    }
}

impl Entries {
    /// Notes which terms have entered by now.
    fn note(&mut self, entered: Terms, samples: u64) {
        for term in Term::ALL.into_iter().filter(|&term| entered.has(term)) {
            if self.0.iter().all(|(known, _)| *known != term) {
                self.0.push((term, samples));
            }
        }
    }

    /// The unknowns of the terms that have entered, by what tells their value and standard error.
    fn estimates(&self, told: &mut dyn FnMut(Unknown) -> Option<(f64, f64)>) -> Vec<TermEstimate> {
        let since = |unknown: Unknown| {
            let mut entries = self.0.iter();
            entries.find(|(term, _)| Some(*term) == unknown.term())
        };
        let estimate = |unknown| {
            let (_, since) = since(unknown)?;
            let (value, std_error) = told(unknown)?;
            Some(TermEstimate {
                unknown,
                value,
                std_error,
                since: *since,
            })
        };
        Unknown::ALL.into_iter().filter_map(estimate).collect()
    }
}

impl<N: Copy, I: Identify<N>> Learner<N> for Beside<I, I::State> {
    fn learn(&mut self, increment: N, command: N) -> Result<Option<Update<N>>, StepError> {
        let seen = self.identifier.learn(&mut self.state, increment, command)?;
        if seen.event == Event::TermEntered {
            let entered = self.identifier.entered(&self.state);
            self.entered.note(entered, self.samples);
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
        self.identifier.resume_moving(&mut self.state, increment);
    }

    fn place(&mut self, position: N) {
        self.identifier.place(&mut self.state, position);
    }

    fn outcome(&self) -> Outcome {
        Outcome {
            bandwidth: self.identifier.bandwidth(&self.state),
            entered: self.entered.0.clone(),
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
