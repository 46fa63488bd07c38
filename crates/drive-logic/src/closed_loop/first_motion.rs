//! The command of an unknown servo until its encoder counts: what moves it is not seen if the encoder is dead.

use commissioning::CommandRamp;
use drive_link::Fault;
use identifier_core::control::ControlSample;
use identifier_core::number::Number;

/// Has the command grow no faster than in the first motion of a commissioning, until the first count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FirstMotion {
    /// True until the encoder counts, if the servo is unknown.
    is_awaited: bool,
    ramp: CommandRamp<f32>,
    /// The change of the command by which a servo must move.
    breakaway: f32,
    /// The command from which it grows, and its distance from there, with its sign.
    from: f32,
    given: f32,
    /// Samples beyond the breakaway.
    beyond: u32,
}

impl FirstMotion {
    /// For an unknown servo, with these limits of the command and the part of them by which it must move, at a sample time (s).
    pub(crate) fn new(limit: [f64; 2], breakaway: f64, sample_time: f64) -> Self {
        let [low, high] = limit;
        let limit = high.min(-low);
        Self {
            is_awaited: true,
            ramp: CommandRamp::new(limit, sample_time),
            breakaway: f32::from_f64(breakaway * limit),
            from: 0.0,
            given: 0.0,
            beyond: 0,
        }
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
    pub(crate) fn acting(&mut self, control: &ControlSample<f32>) -> f32 {
        if self.is_awaited {
            self.ramped(control)
        } else {
            control.command
        }
    }

    #[cold]
    #[inline(never)]
    fn ramped(&mut self, control: &ControlSample<f32>) -> f32 {
        if control.increment != 0.0 {
            self.is_awaited = false;
            self.beyond = 0;
            return control.command;
        }
        let wanted = control.command - self.from;
        // To the other side it grows anew.
        let distance = if wanted * self.given > 0.0 {
            self.given.abs()
        } else {
            0.0
        };
        let most = distance + self.ramp.step(distance);
        self.given = wanted.limited(-most, most);
        self.beyond = if self.given.abs() >= self.breakaway {
            self.beyond.saturating_add(1)
        } else {
            0
        };
        self.from + self.given
    }

    /// # Errors
    /// A command that must move it has not.
    #[inline]
    pub(crate) fn check(&self) -> Result<(), Fault> {
        if self.ramp.is_jammed(self.beyond) {
            Err(Fault::EncoderSilent)
        } else {
            Ok(())
        }
    }
}
