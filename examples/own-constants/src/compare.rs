//! The loop of constants beside the one that the chip has built itself, around a simulated servo, in an emulator.

use cortex_m_semihosting::debug;
use identifier_core::parameters::Parameter;

use crate::run::{CONSTANTS, Number, bits, drive};
use crate::settings::{Configuration, Loop, build};

/// Samples of the comparison.
const SAMPLES: i32 = 3000;

/// A sum over the bits of all commands and estimates.
fn sum(configuration: &Configuration) -> u64 {
    const SAMPLE_TIME: f32 = 1e-3;
    const PER_RAD: f32 = 10_000.0 / core::f32::consts::TAU;
    let (mut position, mut velocity) = (0.0_f32, 0.0_f32);
    let (mut sample, mut sum) = (0, 0_u64);
    drive(configuration, |command, estimates, servo_loop| {
        for next in [command]
            .into_iter()
            .chain(Parameter::ALL.map(|parameter| estimates.get(parameter)))
        {
            sum = (sum ^ u64::from(bits(next))).wrapping_mul(0x0100_0000_01b3);
        }
        let acceleration = 257.7 * units(servo_loop, command) - 2.0 * velocity;
        position += SAMPLE_TIME * (velocity + 0.5 * SAMPLE_TIME * acceleration);
        velocity += SAMPLE_TIME * acceleration;
        sample += 1;
        let way = sample % 680;
        let setpoint = 3 * if way < 340 { way } else { 680 - way };
        (sample < SAMPLES).then_some((setpoint, (position * PER_RAD) as i32))
    });
    sum
}

/// A command in command units.
#[cfg(not(feature = "fixed-point"))]
fn units(_: &Loop, command: Number) -> f32 {
    command
}
#[cfg(feature = "fixed-point")]
fn units(servo_loop: &Loop, command: Number) -> f32 {
    servo_loop.identifier().command(command) as f32
}

pub(crate) fn run() {
    let of_constants = sum(&CONSTANTS.build());
    let same = build().is_ok_and(|built| sum(&built) == of_constants);
    debug::exit(if same {
        debug::EXIT_SUCCESS
    } else {
        debug::EXIT_FAILURE
    });
}
