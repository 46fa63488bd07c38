//! A servo that the chip itself simulates, with its encoder: the paper's with friction.

use core::sync::atomic::{AtomicU32, Ordering};

use virtual_servo::{Encoder, Plant};

use crate::paper;

/// Coulomb friction, rad/s², besides the paper's servo.
const FRICTION: f64 = 5.0;

/// The sample time as the bits of a float, s; the drive's background sets it.
static SAMPLE_TIME: AtomicU32 = AtomicU32::new(0);

/// The servo moves by this much in every sample from now on, s.
pub fn set_sample_time(sample_time: f64) {
    SAMPLE_TIME.store((sample_time as f32).to_bits(), Ordering::Relaxed);
}

/// The servo with its encoder.
pub struct ServoOnChip {
    plant: Plant,
    sample_time: u32,
    encoder: Encoder,
}

impl Default for ServoOnChip {
    fn default() -> Self {
        let (plant, encoder) = paper::servo_with(FRICTION);
        Self {
            plant,
            sample_time: 0,
            encoder,
        }
    }
}

impl ServoOnChip {
    /// Moves by a sample under a command, command units, and returns the encoder's count.
    pub fn advance(&mut self, command: f64) -> i64 {
        let wanted = SAMPLE_TIME.load(Ordering::Relaxed);
        if wanted != self.sample_time && wanted != 0 {
            let sample_time = f64::from(f32::from_bits(wanted));
            let at = self.plant;
            self.plant = Plant::at_rest(&paper::parameters(FRICTION), sample_time);
            (self.plant.position, self.plant.velocity) = (at.position, at.velocity);
            self.sample_time = wanted;
        }
        self.plant.advance(command);
        self.encoder.read(self.plant.position)
    }
}
