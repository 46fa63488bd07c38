//! A servo for a chip that is emulated: the drive's output moves it, and the encoder's counter
//! follows. It is no part of the drive: its instructions are not counted.

use core::cell::RefCell;

use cortex_m::interrupt::{Mutex, free};
use drive_chip::emulated::{self, Outputs};

use crate::board::{BOARD, STAGE};
use crate::servo_on_chip::ServoOnChip;

/// The servo, once it has moved.
static SERVO: Mutex<RefCell<Option<ServoOnChip>>> = Mutex::new(RefCell::new(None));

/// Moves the servo by a sample.
#[inline(never)]
pub fn advance() {
    free(|section| {
        if let Ok(mut servo) = SERVO.borrow(section).try_borrow_mut() {
            let count = servo
                .get_or_insert_default()
                .advance(command(&emulated::outputs()));
            // A counter of 16 bits.
            emulated::set_count(count as u16);
        }
    });
}

/// The command that acts on the servo, command units: zero unless the amplifier is enabled.
fn command(outputs: &Outputs) -> f64 {
    let Some(duty) = outputs.duty.filter(|_| emulated::is_high(BOARD.enable)) else {
        return 0.0;
    };
    let size = STAGE.full_scale * f64::from(duty) / f64::from(outputs.steps.max(1));
    if outputs.is_positive { size } else { -size }
}
