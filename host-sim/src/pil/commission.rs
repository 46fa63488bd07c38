//! A commissioning whose machine is on a chip.

use drive_link::{Answer, NoGains, Question};
use identifier_core::commission::{CommissionInputs, CommissionReading};

use crate::commission::{Commissioner, Commissioning, Outcome, Sample};
use crate::loops::{RemoteError, ask, unexpected};
use crate::port::Port;
use crate::scenario::{Arithmetic, Fault, Scenario};

/// What a scenario describes, about to begin on a chip.
///
/// # Errors
/// The key that is missing, or that it cannot be done with there; nothing has moved then.
pub fn commissioning(scenario: &Scenario) -> Result<Commissioning, Fault> {
    if scenario.identifier.arithmetic != Arithmetic::F32 {
        return Err(Fault::new(
            "identifier.arithmetic",
            "the firmware commissions in \"f32\"",
        ));
    }
    Commissioning::of(scenario)
}

/// Runs a commissioning with its machine on the chip at the other end of a port, and shows every sample to
/// `observe`.
///
/// # Errors
/// The chip, or the line to it.
pub fn commission(
    commissioning: Commissioning,
    port: &mut Port,
    observe: &mut dyn FnMut(&Sample),
) -> Result<Outcome, RemoteError> {
    let begin = Question::BeginCommission {
        settings: *commissioning.settings(),
        before: commissioning.gains_before().copied(),
        held: commissioning.held(),
    };
    let mut there = match ask(port, &begin)? {
        Answer::Ready => There {
            port,
            next: 0,
            no_gains: None,
        },
        other => return Err(unexpected(&other)),
    };
    commissioning.run_by(&mut there, observe)
}

/// The machine on the chip.
struct There<'a> {
    port: &'a mut Port,
    /// The number of the next sample, which tells an answer from an earlier one.
    next: u32,
    no_gains: Option<NoGains>,
}

impl Commissioner for There<'_> {
    type Error = RemoteError;

    fn sample(&mut self, seen: &CommissionInputs) -> Result<CommissionReading, RemoteError> {
        let CommissionInputs { count, late, stop } = *seen;
        let question = Question::CommissionSample {
            number: self.next,
            count,
            late,
            stop,
        };
        let reading = match ask(self.port, &question)? {
            Answer::Commissioned { step, no_gains, .. } => {
                self.no_gains = no_gains;
                step
            }
            other => return Err(unexpected(&other)),
        };
        self.next = self.next.wrapping_add(1);
        Ok(reading)
    }

    fn no_gains(&self) -> Option<NoGains> {
        self.no_gains.clone()
    }
}
