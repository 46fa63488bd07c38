use super::motion::MotionRecord;
use super::{A, B, COULOMB, DELAY, LOAD, POSITION, UNKNOWNS, VELOCITY};
use identifier_core::number::Number;

/// Typical magnitudes of a record: sizes and small changes are chosen by them. Counts, samples and command
/// units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RecordScales {
    /// The largest command, and the acceleration by it.
    pub(super) command: f64,
    pub(super) acceleration: f64,
    /// The mean speed.
    pub(super) speed: f64,
    /// From the lowest to the highest position.
    pub(super) range: f64,
    /// The record, samples, its blocks, and the samples of each.
    pub(super) lasting: f64,
    pub(super) blocks: f64,
    pub(super) samples: f64,
}

impl RecordScales {
    /// A change that is small against the motion.
    pub(super) const SMALL_CHANGE: f64 = 0.003;

    /// From a record of a servo with a gain.
    pub(super) fn from_record<N: Number, const W: usize>(
        motion: &MotionRecord<N, W>,
        gain: N,
    ) -> Self {
        let (mut command, mut travel, mut time) = (N::ZERO, N::ZERO, N::ZERO);
        for block in motion.blocks() {
            if block.command.magnitude() > command {
                command = block.command.magnitude();
            }
            travel += block.travel.magnitude();
            time += motion.samples();
        }
        // Nothing is zero that something is divided by.
        let positive = |value: f64| value.max(f64::from(f32::EPSILON));
        let lasting = time.to_f64().max(1.0);
        Self {
            command: positive(command.to_f64()),
            acceleration: positive((gain * command).to_f64()),
            speed: positive(travel.to_f64() / lasting),
            range: motion.range().to_f64(),
            lasting,
            blocks: motion.len() as f64,
            samples: motion.samples().to_f64(),
        }
    }

    /// Steps of the servo's own unknowns for difference quotients.
    pub(super) fn changes(&self) -> [f64; UNKNOWNS] {
        let force = Self::SMALL_CHANGE * self.acceleration;
        let mut changes = [0.0; UNKNOWNS];
        changes[A] = force / self.speed;
        changes[B] = force / self.command;
        changes[COULOMB] = force;
        changes[DELAY] = 0.1;
        changes[LOAD] = force;
        changes[POSITION] = 0.5;
        changes[VELOCITY] = Self::SMALL_CHANGE * self.speed;
        changes
    }
}
