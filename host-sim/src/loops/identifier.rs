//! The identifiers of the core behind one trait object, so that one loop and one replay serve them all.

use std::marker::PhantomData;

use identifier_core::error::StepError;
use identifier_core::identifier::{Event, Identify, Update};
use identifier_core::model::{Amplifier, AmplifierState};
use identifier_core::number::Number;
use identifier_core::parameters::{PerParameter, ServoParameters, Term, Unknown};
use identifier_log::experiment::{Outcome, TermEstimate};
use identifier_log::replay::{Beginning, Input};

use super::{NO_ESTIMATE, Step};

/// An identifier with its state, whatever its types. Increments, position units, and commands are in double
/// precision, which holds the numbers of every format exactly.
pub(crate) trait DynIdentifier {
    /// One sample with the increment of the position and the whole command from now on. The background work of a drive
    /// follows, if there is any.
    ///
    /// # Errors
    /// An increment or a command that is not allowed.
    fn update(&mut self, increment: f64, command: f64) -> Result<Innovation, StepError>;

    /// The estimates, SI.
    fn estimates(&self) -> ServoParameters;

    /// Their standard errors, SI, for estimators that have them.
    fn standard_errors(&self) -> Option<ServoParameters> {
        None
    }

    /// The estimates at a bound.
    fn at_bounds(&self) -> PerParameter<bool> {
        PerParameter::default()
    }

    /// Restarts the model in a motion of `increment` per sample, before its next sample; the estimates are
    /// kept.
    fn resume_moving(&mut self, _increment: f64) {}

    /// Sets the position of the servo before its next sample, position units, for models with an angle.
    fn place(&mut self, _position: f64) {}

    /// Joins the motion of a log where the input of a sample says so.
    fn join(&mut self, input: &Input) {
        if let Some(Beginning { velocity, angle }) = input.beginning {
            if let Some(velocity) = velocity {
                self.resume_moving(velocity);
            }
            self.place(angle);
        }
    }

    /// Its outcome besides its samples.
    fn outcome(&self) -> Outcome {
        Outcome::default()
    }

    /// [`DynIdentifier::update`] with the estimates behind it, beside a controller's `velocity`.
    fn step(
        &mut self,
        increment: f64,
        command: f64,
        velocity: Option<f64>,
    ) -> Result<Step, StepError> {
        let Innovation { command, update } = self.update(increment, command)?;
        Ok(Step {
            command,
            velocity,
            output_error: update.map(|update| update.output_error),
            event: update.map(|update| update.event),
            estimates: self.estimates(),
            standard_errors: self.standard_errors(),
            at_bounds: self.at_bounds(),
        })
    }
}

/// The result of a sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Innovation {
    /// The command in the number format of the identifier.
    pub(crate) command: f64,
    /// Output error and event; none for a method without a model.
    pub(crate) update: Option<Update<f64>>,
}

/// Commands that a declared amplifier keeps.
const MAX_DELAYED: usize = 128;

/// A declared amplifier and its state.
type Amplified<N> = (Amplifier<N, MAX_DELAYED>, AmplifierState<N, MAX_DELAYED>);

/// An identifier of the core in floating point, behind the amplifier if one is declared.
pub(crate) struct Running<N: Copy, I: Identify<N>> {
    identifier: I,
    state: I::State,
    amplified: Option<Amplified<N>>,
    known: Outcome,
    samples: u64,
    /// The terms that have entered, and the sample in which each did.
    entered: Vec<(Term, u64)>,
    number: PhantomData<N>,
}

impl<N: Number, I: Identify<N>> Running<N, I> {
    /// At its start; `known` is its outcome beforehand.
    pub(crate) fn new(
        identifier: I,
        amplifier: Option<Amplifier<N, MAX_DELAYED>>,
        known: Outcome,
    ) -> Self {
        Self {
            state: identifier.start(),
            identifier,
            amplified: amplifier.map(|amplifier| (amplifier, amplifier.start())),
            known,
            samples: 0,
            entered: Vec::new(),
            number: PhantomData,
        }
    }

    /// The unknowns of the terms that have entered.
    fn terms(&self) -> Vec<TermEstimate> {
        let snapshot = self.identifier.snapshot(&self.state);
        let report = self.identifier.report(&self.state);
        let estimate = |unknown: Unknown| {
            let mut entered = self.entered.iter();
            let (_, since) = entered.find(|(term, _)| Some(*term) == unknown.term())?;
            Some(TermEstimate {
                unknown,
                value: self.identifier.value_in(&snapshot, unknown)?,
                std_error: report.standard_error_of(unknown)?,
                since: *since,
            })
        };
        Unknown::ALL.into_iter().filter_map(estimate).collect()
    }
}

impl<N: Number, I: Identify<N>> DynIdentifier for Running<N, I> {
    fn update(&mut self, increment: f64, command: f64) -> Result<Innovation, StepError> {
        let (increment, command) = (N::from_f64(increment), N::from_f64(command));
        let acts = match &mut self.amplified {
            Some((amplifier, state)) => amplifier.process(state, command),
            None => command,
        };
        let update = self.identifier.learn(&mut self.state, increment, acts)?;
        if update.event == Event::TermEntered {
            let entered = self.identifier.report(&self.state).entered;
            for term in Term::ALL.into_iter().filter(|&term| entered.has(term)) {
                if self.entered.iter().all(|(known, _)| *known != term) {
                    self.entered.push((term, self.samples));
                }
            }
        }
        self.samples += 1;
        self.identifier.work(&mut self.state, u32::MAX);
        Ok(Innovation {
            command: command.to_f64(),
            update: Some(Update {
                output_error: update.output_error.to_f64(),
                event: update.event,
            }),
        })
    }

    fn estimates(&self) -> ServoParameters {
        let snapshot = self.identifier.snapshot(&self.state);
        self.identifier.estimates_in(&snapshot)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        self.identifier.report(&self.state).errors_of_parameters()
    }

    fn at_bounds(&self) -> PerParameter<bool> {
        let snapshot = self.identifier.snapshot(&self.state);
        self.identifier.at_bounds_in(&snapshot)
    }

    fn resume_moving(&mut self, increment: f64) {
        let increment = N::from_f64(increment);
        self.identifier.resume_moving(&mut self.state, increment);
    }

    fn place(&mut self, position: f64) {
        let position = N::from_f64(position);
        self.identifier.place(&mut self.state, position);
    }

    fn outcome(&self) -> Outcome {
        let report = self.identifier.report(&self.state);
        Outcome {
            bandwidth: report.bandwidth,
            entered: self.entered.clone(),
            terms: self.terms(),
            rejection_reason: report.rejection_reason,
            ..self.known.clone()
        }
    }
}

/// The place of an identifier whose estimates come from the whole record: the command passes through.
pub(crate) struct WholeRecord;

impl DynIdentifier for WholeRecord {
    fn update(&mut self, _: f64, command: f64) -> Result<Innovation, StepError> {
        Ok(Innovation {
            command,
            update: None,
        })
    }

    fn estimates(&self) -> ServoParameters {
        NO_ESTIMATE
    }
}
