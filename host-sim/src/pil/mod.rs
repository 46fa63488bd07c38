//! Processor in the loop: the plant here, the loop on a chip, one sample a question.

mod commission;
mod settings;

use std::fmt;

use drive_link::LoopSettings;
use identifier_core::number::Number;

pub use self::commission::{commission, commissioning};
use crate::experiment::{Abort, AbortCause, Outcome, Sample};
use crate::loops::{RemoteError, RemoteLoop};
use crate::port::Port;
use crate::scenario::dispatch::with_number;
use crate::scenario::{Fault, Scenario};
use crate::simulate::{Rig, Stop};

/// Why an experiment with a chip did not take place, or ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum PilError {
    /// The firmware cannot do what the scenario asks for.
    Scenario(Fault),
    /// The chip, or the line to it.
    Remote(RemoteError),
}

impl fmt::Display for PilError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scenario(fault) => fault.fmt(f),
            Self::Remote(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for PilError {}

impl From<Fault> for PilError {
    fn from(fault: Fault) -> Self {
        Self::Scenario(fault)
    }
}

impl From<RemoteError> for PilError {
    fn from(error: RemoteError) -> Self {
        Self::Remote(error)
    }
}

/// What a drive is told of a scenario's loop.
///
/// # Errors
/// If the firmware cannot do what the scenario asks for.
pub fn loop_settings(scenario: &Scenario) -> Result<LoopSettings, PilError> {
    Ok(settings::of(scenario)?.0)
}

/// Runs a scenario with the loop on the chip at the other end of a port, and shows every sample to
/// `observe`.
///
/// # Errors
/// [`PilError`].
pub fn run(
    scenario: &Scenario,
    port: &mut Port,
    observe: &mut dyn FnMut(&Sample),
) -> Result<Outcome, PilError> {
    let (settings, known) = settings::of(scenario)?;
    let rig = with_number!(scenario => rig(scenario))?;
    if rig.samples == 0 {
        let fault = "it is shorter than a sample, so there is nothing to compare";
        return Err(Fault::new("run.duration", fault).into());
    }
    let mut remote = RemoteLoop::begin(port, settings, known)?;
    let run = rig.run(&mut remote, &mut |sample, _| observe(sample));
    match run.stopped {
        None => Ok(run.outcome),
        Some((time, Stop::NoReading)) => Ok(Outcome {
            abort: Some(Abort {
                time,
                cause: AbortCause::NoReading,
            }),
            ..run.outcome
        }),
        Some((_, Stop::Loop(error))) => Err(error.into()),
    }
}

fn rig<N: Number>(scenario: &Scenario) -> Result<Rig<'static>, Fault> {
    Rig::of::<N>(scenario)
}
