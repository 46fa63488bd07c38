//! A run of a loop, and its record.

use std::f64::consts::TAU;

use virtual_servo::{Encoder, SensorErrors, Servo};

use super::LoopSetup;
use super::controller::ControlLoop;
use crate::Random;

/// The record of a loop, with its truth.
#[derive(Debug, Clone)]
pub struct RecordedLog {
    /// The loop.
    pub setup: LoopSetup,
    /// Encoder counts, one per sample.
    pub counts: Vec<i64>,
    /// Commands as recorded, one per sample.
    pub commands: Vec<f64>,
    /// Root mean square of the velocity at the encoder, rad/s.
    pub velocity_rms: f64,
    /// The distance from the lowest to the highest position at the encoder, without its errors, rad.
    pub range: f64,
    /// Moves at the encoder from below three tenths of it to above seven tenths, or back.
    pub crossings: u32,
    /// The share of the samples in which the command is at the limit.
    pub limited: f64,
}

impl RecordedLog {
    /// Position at a sample, rad.
    #[must_use]
    pub fn position(&self, sample: usize) -> f64 {
        self.counts[sample] as f64 * TAU / self.setup.counts_per_rev
    }

    /// The magnitude of the command that is exceeded by a share of the samples, command units.
    #[must_use]
    pub fn command_exceeded_by(&self, share: f64) -> f64 {
        let mut magnitudes: Vec<f64> = self.commands.iter().map(|u| u.abs()).collect();
        magnitudes.sort_by(f64::total_cmp);
        let place = ((1.0 - share) * (magnitudes.len() - 1) as f64) as usize;
        magnitudes[place]
    }

    /// Root mean square of the command, command units.
    #[must_use]
    pub fn command_rms(&self) -> f64 {
        let squares: f64 = self.commands.iter().map(|u| u * u).sum();
        (squares / self.commands.len() as f64).sqrt()
    }
}

/// The distance from the lowest to the highest of some positions, and the moves from below three tenths of it to above
/// seven tenths, or back.
fn range_and_crossings(positions: &[f64]) -> (f64, u32) {
    let low = positions.iter().copied().fold(f64::INFINITY, f64::min);
    let high = positions.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let range = high - low;
    let (near, far) = (low + 0.3 * range, low + 0.7 * range);
    let (mut crossings, mut is_far) = (0, false);
    for &position in positions {
        if (position > far && !is_far) || (position < near && is_far) {
            is_far = !is_far;
            crossings += 1;
        }
    }
    (range, crossings)
}

impl LoopSetup {
    /// Runs the loop and records it.
    ///
    /// The command that is given at a sample acts from there on after the servo's own delay. A record that is
    /// shifted by s samples has s of them between a row and the action of its command: whole samples are a shift of
    /// the rows, and the fraction is a delay of the actuator. Recorded late, s is negative.
    #[must_use]
    pub fn record(&self) -> RecordedLog {
        let mut random = Random::new(self.seed);
        let late = (-self.shift).ceil();
        let fraction = self.shift + late;
        let mut effects = self.effects;
        effects.delay += fraction * self.sample_time;
        let holding = -self.servo.load / self.servo.b;
        let seed = random.seed();
        let mut servo = Servo::at_rest(&self.servo, &effects, self.sample_time, seed)
            .expect("drawn effects are allowed")
            .held_by(holding);
        let mut sensor = SensorErrors::new(&self.sensor, self.sample_time, random.seed())
            .expect("drawn errors of a sensor are allowed");
        let encoder = Encoder::new(self.counts_per_rev);
        let count = TAU / self.counts_per_rev;
        // Rows before and behind the log, for commands that are recorded late or early.
        let margin = late.abs() as usize;
        let first = self.skipped + margin;
        let all = first + self.samples + margin;
        let references = self.reference.values(all, self.sample_time, &mut random);
        let mut control = ControlLoop::at_rest(
            self.controller,
            self.cutoff,
            self.limit,
            self.sample_time,
            (0.0, holding),
        );
        let (mut counts, mut commands) = (Vec::with_capacity(all), Vec::with_capacity(all));
        let (mut positions, mut squares) = (Vec::with_capacity(all), 0.0);
        for (sample, reference) in references.iter().enumerate() {
            let steps = self.load_steps.iter();
            if let Some(step) = steps.rev().find(|step| first + step.sample == sample) {
                servo.disturb(step.load, 0.0);
            }
            positions.push(servo.position());
            let read = encoder.read(sensor.seen(servo.position(), servo.velocity()));
            let command = control.process(*reference, (read as f64 + 0.5) * count);
            servo.advance(command);
            counts.push(read);
            commands.push(command);
            squares += servo.velocity() * servo.velocity();
        }
        let at_limit = |u: &&f64| u.abs() >= 0.999_999 * self.limit;
        let limited = commands.iter().filter(at_limit).count() as f64 / all as f64;
        let (range, crossings) = range_and_crossings(&positions[first..first + self.samples]);
        let recorded_from = (first as f64 - late) as usize;
        RecordedLog {
            setup: self.clone(),
            counts: counts[first..first + self.samples].to_vec(),
            commands: commands[recorded_from..recorded_from + self.samples].to_vec(),
            velocity_rms: (squares / all as f64).sqrt(),
            range,
            crossings,
            limited,
        }
    }
}
