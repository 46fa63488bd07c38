//! A servo for a chip that is emulated: the drive's output moves it, and the encoder's counter
//! follows. It is no part of the drive: its instructions are not counted.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::interrupt::{Mutex, free};
use drive_chip::emulated::{self, Outputs};
use virtual_servo::{Encoder, Plant};

use crate::board::{BOARD, STAGE};
use crate::paper;

/// Coulomb friction, rad/s², besides the paper's servo.
const FRICTION: f64 = 5.0;

/// The sample time as the bits of a float, s; the drive's background sets it.
static SAMPLE_TIME: AtomicU32 = AtomicU32::new(0);

/// The servo moves by this much in every sample from now on, s.
pub fn set_sample_time(sample_time: f64) {
    SAMPLE_TIME.store((sample_time as f32).to_bits(), Ordering::Relaxed);
}

/// The servo, once it has moved.
static SERVO: Mutex<RefCell<Option<EmulatedServo>>> = Mutex::new(RefCell::new(None));

/// Moves the servo by a sample.
#[inline(never)]
pub fn advance() {
    free(|section| {
        if let Ok(mut servo) = SERVO.borrow(section).try_borrow_mut() {
            servo.get_or_insert_default().advance();
        }
    });
}

/// The servo with its encoder.
struct EmulatedServo {
    plant: Plant,
    sample_time: u32,
    encoder: Encoder,
}

impl Default for EmulatedServo {
    fn default() -> Self {
        let (plant, encoder) = paper::servo_with(FRICTION);
        Self {
            plant,
            sample_time: 0,
            encoder,
        }
    }
}

impl EmulatedServo {
    fn advance(&mut self) {
        let wanted = SAMPLE_TIME.load(Ordering::Relaxed);
        if wanted != self.sample_time && wanted != 0 {
            let sample_time = f64::from(f32::from_bits(wanted));
            let at = self.plant;
            self.plant = Plant::at_rest(&paper::parameters(FRICTION), sample_time);
            (self.plant.position, self.plant.velocity) = (at.position, at.velocity);
            self.sample_time = wanted;
        }
        self.plant.advance(command(&emulated::outputs()));
        // A counter of 16 bits.
        emulated::set_count(self.encoder.read(self.plant.position) as u16);
    }
}

/// The command that acts on the servo, command units: zero unless the amplifier is enabled.
fn command(outputs: &Outputs) -> f64 {
    let Some(duty) = outputs.duty.filter(|_| emulated::is_high(BOARD.enable)) else {
        return 0.0;
    };
    let size = STAGE.full_scale * f64::from(duty) / f64::from(outputs.steps.max(1));
    if outputs.is_positive { size } else { -size }
}
