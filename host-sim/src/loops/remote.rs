//! A loop on a chip at the other end of a line: one sample, one question.

use std::fmt;

use drive_link::{Answer, LoopSettings, Question, Reading, Refused};
use identifier_core::model::ServoParameters;

use super::{Measurement, SimLoop, Step};
use crate::experiment::Outcome;
use crate::port::{Port, PortError};

/// Why a loop elsewhere does no further sample.
#[derive(Debug)]
#[non_exhaustive]
pub enum RemoteError {
    /// The line.
    Port(PortError),
    /// The chip refuses a setting or a sample.
    Refused(String),
}

impl fmt::Display for RemoteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Port(error) => error.fmt(f),
            Self::Refused(text) => write!(f, "the chip refuses: {text}"),
        }
    }
}

impl std::error::Error for RemoteError {}

/// The loop on the chip.
pub(crate) struct RemoteLoop<'a> {
    port: &'a mut Port,
    /// The number of the next sample, which tells an answer from an earlier one.
    next: u32,
    known: Outcome,
}

impl<'a> RemoteLoop<'a> {
    /// Has the chip begin; `known` is what is known of its loop beforehand.
    ///
    /// # Errors
    /// The chip or the line refuses.
    pub(crate) fn begin(
        port: &'a mut Port,
        settings: LoopSettings,
        known: Outcome,
    ) -> Result<Self, RemoteError> {
        match ask(port, &Question::Begin(settings))? {
            Answer::Ready => Ok(Self {
                port,
                next: 0,
                known,
            }),
            other => Err(unexpected(&other)),
        }
    }
}

impl SimLoop for RemoteLoop<'_> {
    type Error = RemoteError;

    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, RemoteError> {
        let question = Question::Sample {
            number: self.next,
            setpoint: 0,
            offset: reference,
            count: measured.count(),
        };
        let Reading {
            command,
            output_error,
            estimates,
            event,
        } = match ask(self.port, &question)? {
            Answer::Command { reading, .. } => reading,
            other => return Err(unexpected(&other)),
        };
        self.next = self.next.wrapping_add(1);
        Ok(Step {
            command,
            velocity: None,
            output_error: Some(output_error),
            event: Some(event),
            estimates: ServoParameters {
                a: estimates.a,
                b: estimates.b,
                coulomb: estimates.coulomb,
                load: estimates.load,
            },
            standard_errors: estimates.standard_errors,
            at_bounds: estimates.at_bounds,
        })
    }

    fn outcome(&self) -> Outcome {
        self.known.clone()
    }
}

/// The answer to a question; an answer to an earlier one is none.
pub(crate) fn ask(port: &mut Port, question: &Question) -> Result<Answer, RemoteError> {
    let asked = match question {
        Question::Sample { number, .. } | Question::CommissionSample { number, .. } => Some(number),
        Question::Begin(_) | Question::BeginCommission { .. } => None,
    };
    let fits = |answer: &Answer| match answer {
        Answer::Command { number, .. } | Answer::Commissioned { number, .. } => {
            asked == Some(number)
        }
        Answer::Ready => asked.is_none(),
        Answer::Refused(_) => true,
    };
    port.ask(question, fits).map_err(RemoteError::Port)
}

pub(crate) fn unexpected(answer: &Answer) -> RemoteError {
    RemoteError::Refused(match answer {
        Answer::Refused(Refused::Setting(refused)) => refused.to_string(),
        Answer::Refused(Refused::NotBegun) => "it was reset in the middle".to_owned(),
        Answer::Refused(Refused::BegunOtherwise) => {
            "it was begun for something else: does somebody else use the port?".to_owned()
        }
        Answer::Refused(Refused::OutOfStep { next }) => {
            format!("it is at sample {next}: does somebody else use the port?")
        }
        Answer::Refused(Refused::OutOfReach) => {
            "the reference is further from the position than the number format counts".to_owned()
        }
        other => format!("{other:?} answers another question"),
    })
}
