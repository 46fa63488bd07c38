//! A servo of a few lines, in place of a timer in encoder mode and a PWM: it makes the example run in an emulator.

/// a (1/s) and b (rad/s² per command unit), which the firmware does not know.
pub(crate) const TRUE: (f32, f32) = (2.0, 257.7);

pub(crate) const SAMPLE_TIME: f32 = 1e-3;
pub(crate) const COUNTS_PER_REV: f32 = 10_000.0;

/// The servo, rad.
#[derive(Default)]
pub(crate) struct Servo {
    position: f32,
    velocity: f32,
}

impl Servo {
    /// The register of the encoder's counter, of 16 bits.
    pub(crate) fn register(&self) -> u16 {
        const PER_RAD: f32 = COUNTS_PER_REV / core::f32::consts::TAU;
        // Towards zero: an encoder's edges lie anywhere.
        ((self.position * PER_RAD) as i32) as u16
    }

    /// Outputs a command, which acts until the next sample.
    pub(crate) fn output(&mut self, command: f32) {
        let acceleration = TRUE.1 * command - TRUE.0 * self.velocity;
        self.position += SAMPLE_TIME * (self.velocity + 0.5 * SAMPLE_TIME * acceleration);
        self.velocity += SAMPLE_TIME * acceleration;
    }
}
