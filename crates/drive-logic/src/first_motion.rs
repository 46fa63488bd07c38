//! The command of an unknown servo until its encoder counts: what moves it is not seen if the encoder is dead.

use commissioning::CommandRamp;
use identifier_core::control::ControlSample;
use identifier_core::number::Number;

use crate::protection::Protection;

/// Has the command grow no faster than in the first motion of a commissioning, until the first count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirstMotion {
    /// True until the encoder counts, if the servo is unknown.
    is_awaited: bool,
    ramp: CommandRamp<f32>,
    /// The command from which it grows, and its distance from there, with its sign.
    from: f32,
    given: f32,
}

impl FirstMotion {
    /// For an unknown servo, with these limits of the command, at a sample time (s).
    pub(crate) fn new([low, high]: [f64; 2], sample_time: f64) -> Self {
        Self {
            is_awaited: true,
            ramp: CommandRamp::new(high.min(-low), sample_time),
            from: 0.0,
            given: 0.0,
        }
    }

    /// Samples beyond the breakaway within which it must move.
    pub(crate) fn patience(&self) -> u32 {
        self.ramp.jammed()
    }

    /// Takes over with a command that holds the servo.
    pub(crate) fn take_over(&mut self, command: f32) {
        self.from = command;
    }

    /// The servo is identified.
    pub(crate) fn know(&mut self) {
        self.is_awaited = false;
    }

    /// The command that acts in place of the controller's.
    #[inline]
    pub(crate) fn acting(
        &mut self,
        control: &ControlSample<f32>,
        protection: &mut Protection,
    ) -> f32 {
        if self.is_awaited {
            // Its address would put the sample into memory.
            self.ramped(control.command, control.increment, protection)
        } else {
            control.command
        }
    }

    #[cold]
    #[inline(never)]
    fn ramped(&mut self, command: f32, increment: f32, protection: &mut Protection) -> f32 {
        if increment != 0.0 {
            self.is_awaited = false;
            protection.end_first_motion();
            return command;
        }
        let wanted = command - self.from;
        // To the other side it grows anew.
        let distance = if wanted * self.given > 0.0 {
            self.given.abs()
        } else {
            0.0
        };
        let most = distance + self.ramp.step(distance);
        self.given = wanted.limited(-most, most);
        self.from + self.given
    }
}
