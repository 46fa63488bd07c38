//! What measures the simulated servo.

use identifier_core::control::position_error;
use identifier_core::number::Number;
use virtual_servo::Encoder;

use crate::scenario::Scenario;

/// An encoder, whose counts wrap, or an ideal sensor.
pub(super) struct Sensor<N> {
    encoder: Option<Encoder>,
    per_unit: f64,
    count: i32,
    position: N,
}

/// What is measured in a sample, position units.
pub(super) struct Measured<N> {
    /// How far the servo is from where it is wanted.
    pub(super) error: N,
    /// How far it has moved since the last sample.
    pub(super) increment: N,
    /// Where it is.
    pub(super) position: f64,
}

impl<N: Number> Sensor<N> {
    /// That of a scenario, the servo at zero.
    pub(super) fn new(scenario: &Scenario) -> Self {
        Self {
            encoder: scenario.counts_per_rev.map(Encoder::new),
            per_unit: scenario.units().position(),
            count: 0,
            position: N::ZERO,
        }
    }

    /// Measures a position (rad) against a reference (position units).
    pub(super) fn read(&mut self, position: f64, wanted: N) -> Measured<N> {
        match &self.encoder {
            Some(encoder) => {
                let count = encoder.read(position);
                // A counter of 32 bits.
                let register = count as i32;
                let moved = register.wrapping_sub(self.count);
                self.count = register;
                Measured {
                    error: position_error(0, wanted, register),
                    increment: N::from_count(moved),
                    position: count as f64,
                }
            }
            None => {
                let position = N::from_f64(position * self.per_unit);
                let increment = position - self.position;
                self.position = position;
                Measured {
                    error: wanted - position,
                    increment,
                    position: position.to_f64(),
                }
            }
        }
    }
}
