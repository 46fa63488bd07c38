//! A board of the README's programs: a simulated servo, an encoder's register of 16 bits, and a controller of its own.

use identifier_core::parameters::ServoParameters;
use virtual_servo::{Encoder, Plant};

const SAMPLE_TIME: f64 = 1e-3;

pub(super) struct Board {
    servo: Plant,
    sample: i32,
    last: i32,
    /// The cascade's.
    before: f64,
    integral: f64,
}

impl Board {
    /// Runs for a number of samples.
    pub(super) fn new(truth: &ServoParameters, last: i32) -> Self {
        Self {
            servo: Plant::at_rest(truth, SAMPLE_TIME),
            sample: -1,
            last,
            before: 0.0,
            integral: 0.0,
        }
    }

    pub(super) fn waits_for_sample(&mut self) -> bool {
        self.sample += 1;
        self.sample < self.last
    }

    pub(super) fn position(&self) -> f64 {
        self.servo.position
    }

    pub(super) fn count(&self) -> i32 {
        Encoder::new(10_000.0).read(self.servo.position) as i32
    }

    /// It wraps half a turn from the start.
    pub(super) fn encoder(&self) -> u16 {
        (self.count() as u16).wrapping_add(u16::MAX - 5000)
    }

    /// To and fro by 1000 counts.
    pub(super) fn setpoint(&self) -> i32 {
        let phase = self.sample % 680;
        3 * if phase < 340 { phase } else { 680 - phase }
    }

    /// A cascade P–PI with feed-forward and a limit.
    pub(super) fn cascade(&mut self) -> f32 {
        let time = f64::from(self.sample) * SAMPLE_TIME;
        let wanted = 0.6 * (3.1 * time).sin() + 0.4 * (7.3 * time).sin();
        let forward = 0.6 * 3.1 * (3.1 * time).cos() + 0.4 * 7.3 * (7.3 * time).cos();
        let velocity = (self.servo.position - self.before) / SAMPLE_TIME;
        self.before = self.servo.position;
        let error = 12.0 * (wanted - self.servo.position) + forward - velocity;
        let command = 0.15 * error + 1.5 * self.integral;
        let limited = command.clamp(-0.25, 0.25);
        if command.abs() < 0.25 {
            self.integral += SAMPLE_TIME * error;
        }
        limited as f32
    }

    pub(super) fn output(&mut self, command: f32) {
        self.servo.advance(command.into());
    }

    pub(super) fn disable(&mut self) {
        panic!("disabled in sample {}", self.sample);
    }
}
