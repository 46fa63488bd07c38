//! What the tests of whole loops share: seeded random numbers and a true servo with an encoder.
#![allow(dead_code, reason = "each test takes its own part")]

use identifier_core::excitation::NormalSource;
use identifier_core::model::ServoParameters;
use virtual_servo::{Encoder, Plant};

/// A seeded stream of random numbers, the same on every machine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Random(NormalSource);

impl Random {
    pub(crate) fn new(seed: u32) -> Self {
        Self(NormalSource::new(seed))
    }

    /// Uniform between two bounds.
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.next_uniform()
    }

    /// Uniform in the logarithm between two positive bounds.
    pub(crate) fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.0.next_uniform())
    }

    /// One of the values given.
    pub(crate) fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        let at = self.uniform(0.0, values.len() as f64) as usize;
        values[at.min(values.len() - 1)]
    }
}

/// A true servo with an encoder whose counter has 32 bits and starts anywhere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bench {
    pub(crate) plant: Plant,
    encoder: Encoder,
    start: i32,
}

impl Bench {
    pub(crate) fn new(servo: &ServoParameters, sample_time: f64, counts: f64, start: i32) -> Self {
        Self {
            plant: Plant::at_rest(servo, sample_time),
            encoder: Encoder::new(counts),
            start,
        }
    }

    pub(crate) fn count(&self) -> i32 {
        self.start
            .wrapping_add(self.encoder.read(self.plant.position) as i32)
    }
}
