//! Processor in the loop: the plant here, the loop on a chip, one sample a question.

mod settings;

use std::fmt;

use drive_link::{Answer, LoopSettings, Question, Reading, Refused};
use identifier_core::excitation::Excitation;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use virtual_servo::{Encoder, Plant};

use crate::experiment::{Outcome, Sample};
use crate::port::{Port, PortError};
use crate::scenario::{Arithmetic, Reference, Scenario};

/// Why an experiment with a chip did not take place, or ended.
#[derive(Debug)]
#[non_exhaustive]
pub enum PilError {
    /// The firmware cannot do what the scenario asks for.
    Scenario(String),
    /// The line.
    Port(PortError),
    /// The chip refuses a setting or a sample.
    Refused(String),
}

impl fmt::Display for PilError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scenario(text) => f.write_str(text),
            Self::Port(error) => error.fmt(f),
            Self::Refused(text) => write!(f, "the chip refuses: {text}"),
        }
    }
}

impl std::error::Error for PilError {}

/// What a drive is told of a scenario's loop.
///
/// # Errors
/// If the firmware cannot do what the scenario asks for.
pub fn loop_settings(scenario: &Scenario) -> Result<LoopSettings, PilError> {
    settings::of(scenario).map(|(settings, _)| settings)
}

/// Runs a scenario with the loop on the chip at the other end of a port, and shows every sample to
/// `observe`.
///
/// # Errors
/// [`PilError`].
pub fn run(
    scenario: &Scenario,
    port: &mut Port,
    observe: &mut impl FnMut(&Sample),
) -> Result<Outcome, PilError> {
    let (settings, outcome) = settings::of(scenario)?;
    if scenario.samples() == 0 {
        let fault = "run.duration: it is shorter than a sample, so there is nothing to compare";
        return Err(PilError::Scenario(fault.to_owned()));
    }
    match ask(port, &Question::Begin(settings))? {
        Answer::Ready => {}
        other => return Err(unexpected(&other)),
    }
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => play::<f32>(scenario, port, outcome, observe),
        Arithmetic::F64 | Arithmetic::Fixed => play::<f64>(scenario, port, outcome, observe),
    }
}

/// Plays the reference in a number format, sample by sample.
fn play<N: Number>(
    scenario: &Scenario,
    port: &mut Port,
    mut outcome: Outcome,
    observe: &mut impl FnMut(&Sample),
) -> Result<Outcome, PilError> {
    let fault = |what: &str| PilError::Scenario(what.to_owned());
    let units = &scenario.units();
    let sample_time = units.sample_time();
    let position_unit = units.position_unit();
    let servo = scenario
        .plant
        .ok_or_else(|| fault("plant: the host simulates the servo, so it must be given"))?;
    let counts_per_rev = scenario
        .counts_per_rev
        .ok_or_else(|| fault(settings::NO_COUNTS))?;
    let reference = Reference::<N>::new(units, &scenario.excitation)
        .map_err(|error| PilError::Scenario(format!("excitation: {error}")))?;
    let encoder = Encoder::new(counts_per_rev);
    let mut plant = Plant::at_rest(&servo, sample_time);
    let mut progress = reference.start();
    for number in 0..scenario.samples() {
        let wanted = reference.process(&mut progress).to_f64();
        let count = encoder.read(plant.position);
        let question = Question::Sample {
            number: number as u32,
            setpoint: 0,
            offset: wanted,
            // A counter of 32 bits.
            count: count as i32,
        };
        let Reading {
            command,
            output_error,
            estimates,
            event,
        } = match ask(port, &question)? {
            Answer::Command { reading, .. } => reading,
            other => return Err(unexpected(&other)),
        };
        outcome.count(Some(event));
        observe(&Sample {
            time: number as f64 * sample_time,
            reference: wanted * position_unit,
            position: count as f64 * position_unit,
            command,
            output_error: Some(output_error * position_unit),
            estimates: ServoParameters {
                a: estimates.a,
                b: estimates.b,
                coulomb: estimates.coulomb,
                load: estimates.load,
            },
            standard_errors: None,
            at_bounds: estimates.at_bounds,
        });
        plant.advance(command);
    }
    Ok(outcome)
}

/// The answer to a question; an answer to an earlier one is none.
fn ask(port: &mut Port, question: &Question) -> Result<Answer, PilError> {
    let fits = |answer: &Answer| match (question, answer) {
        (Question::Sample { number, .. }, Answer::Command { number: same, .. }) => number == same,
        (Question::Sample { .. }, Answer::Ready) | (Question::Begin(_), Answer::Command { .. }) => {
            false
        }
        _ => true,
    };
    port.ask(question, fits).map_err(PilError::Port)
}

fn unexpected(answer: &Answer) -> PilError {
    PilError::Refused(match answer {
        Answer::Refused(Refused::Setting(refused)) => refused.to_string(),
        Answer::Refused(Refused::NotBegun) => "it was reset in the middle".to_owned(),
        Answer::Refused(Refused::OutOfStep { next }) => {
            format!("it is at sample {next}: does somebody else use the port?")
        }
        Answer::Refused(Refused::OutOfReach) => {
            "the reference is further from the position than the number format counts".to_owned()
        }
        other => format!("{other:?} answers another question"),
    })
}
