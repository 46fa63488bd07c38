//! The position sensor of the simulated servo.

use identifier_core::number::Number;
use virtual_servo::Encoder;

use crate::loops::Measurement;

/// An encoder, whose counter wraps, or an ideal sensor.
pub(super) enum Sensor {
    Encoder {
        encoder: Encoder,
        /// The count at the start of the servo.
        start: i32,
    },
    Ideal {
        /// Position units per rad.
        per_rad: f64,
        /// To the number format of the loop that it measures for.
        rounded: fn(f64) -> f64,
    },
}

impl Sensor {
    /// An encoder whose counter shows `start` where the servo starts.
    pub(super) fn encoder(counts_per_rev: f64, start: i32) -> Self {
        Self::Encoder {
            encoder: Encoder::new(counts_per_rev),
            start,
        }
    }

    /// An ideal sensor for a loop in a number format.
    pub(super) fn ideal<N: Number>(per_rad: f64) -> Self {
        Self::Ideal {
            per_rad,
            rounded: |position| N::from_f64(position).to_f64(),
        }
    }

    /// Measures a position, rad: the reading, and its distance from the start of the servo, position
    /// units.
    pub(super) fn read(&self, position: f64) -> (Measurement, f64) {
        match self {
            Self::Encoder { encoder, start } => {
                let count = encoder.read(position);
                // The counter has 32 bits.
                let counter = start.wrapping_add(count as i32);
                (Measurement::Count(counter), count as f64)
            }
            Self::Ideal { per_rad, rounded } => {
                let position = rounded(position * per_rad);
                (Measurement::Position(position), position)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_wraps_and_the_recorded_position_does_not() {
        let sensor = Sensor::encoder(std::f64::consts::TAU, i32::MAX);
        assert_eq!(sensor.read(0.5), (Measurement::Count(i32::MAX), 0.0));
        assert_eq!(sensor.read(1.5), (Measurement::Count(i32::MIN), 1.0));
        let wrapped = (Measurement::Count(i32::MAX), 4_294_967_296.0);
        assert_eq!(sensor.read(4_294_967_296.5), wrapped);
    }

    #[test]
    fn an_ideal_sensor_rounds_to_the_number_format_of_the_loop() {
        let third = 1.0 / 3.0;
        let exact = Sensor::ideal::<f64>(1.0);
        assert_eq!(exact.read(third), (Measurement::Position(third), third));
        let single = f64::from(third as f32);
        let rounded = Sensor::ideal::<f32>(1.0);
        assert_eq!(rounded.read(third), (Measurement::Position(single), single));
    }
}
