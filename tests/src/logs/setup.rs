//! The loop of a log: servo, controller, reference, encoder and record.

use virtual_servo::{Effects, SensorEffects, ServoParameters};

use super::{Controller, Effect, Reference};

/// The loop of a log, from which its run follows.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopSetup {
    /// The seed of what is random in its run.
    pub seed: u32,
    /// The true servo.
    pub servo: ServoParameters,
    /// Its effects.
    pub effects: Effects,
    /// The errors of its encoder.
    pub sensor: SensorEffects,
    /// Counts per revolution.
    pub counts_per_rev: f64,
    /// S.
    pub sample_time: f64,
    /// Samples recorded.
    pub samples: usize,
    /// Samples before the record.
    pub skipped: usize,
    /// |u| ≤ limit, command units, which the controller knows.
    pub limit: f64,
    /// The controller.
    pub controller: Controller,
    /// Cut-off of its velocity filter, rad/s.
    pub cutoff: f64,
    /// Bandwidth that the controller is designed for, rad/s.
    pub bandwidth: f64,
    /// The reference.
    pub reference: Reference,
    /// Samples from a row to the action of its command: negative if it is recorded late.
    pub shift: f64,
    /// Steps of the load, in order.
    pub load_steps: Vec<LoadStep>,
    /// The effects that it has.
    pub present: Vec<Effect>,
}

/// A step of the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadStep {
    /// Sample of the record from which on it acts.
    pub sample: usize,
    /// In addition to the servo's own load, rad/s².
    pub load: f64,
}
