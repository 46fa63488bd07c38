//! An existing firmware with its own main loop, measurement and output. The PID of this project closes the
//! loop, and the identifier estimates the servo while it runs.
#![no_std]

pub mod settings;

use identifier_core::measurement::Counter;
use servo::{Servo, setpoint};
use settings::Loop;

/// The main loop; b in the end, rad/s² per command unit.
#[inline(always)]
pub fn run(servo_loop: &Loop) -> Option<f64> {
    let mut servo = Servo::default();
    let mut encoder = Counter::new(servo.register());
    let mut state = servo_loop.start(0);
    for sample in 0..8000 {
        let count = encoder.read(servo.register());
        let step = servo_loop.process(&mut state, setpoint(sample), 0.0, count);
        servo.output(step.ok()?.control.command);
        // In the time that is left: the memory of the estimator.
        servo_loop.work(&mut state, 1);
    }
    Some(servo_loop.estimates(&state)?.b)
}
