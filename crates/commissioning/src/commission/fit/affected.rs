use super::effect_model::{EffectModel, Memory};
use super::motion::MotionRecord;
use super::{A, ALL, B, COULOMB, DELAY, LOAD, POSITION, VELOCITY};
use identifier_core::fit::{Blocks, HeldCommand};
use identifier_core::model::FrictionStep;
use identifier_core::number::Number;

/// A model with an effect that starts beside the servo and goes where the recorded command drives it.
/// Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Affected<N> {
    /// The servo's position less the model's.
    pub(super) error: N,
    velocity: N,
    memory: Memory<N>,
}

impl<N: Number> Affected<N> {
    /// Before the first block of a record.
    pub(super) fn new(unknowns: &[N; ALL], effect: &EffectModel<N>) -> Self {
        Self {
            error: -unknowns[POSITION],
            velocity: unknowns[VELOCITY],
            memory: effect.memory(),
        }
    }

    /// Moves over a block of the record, in whose middle the servo was at a position.
    pub(super) fn advance<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        unknowns: &[N; ALL],
        effect: &EffectModel<N>,
        motion: &MotionRecord<N, W>,
        (index, position): (usize, N),
    ) {
        let Some(block) = motion.block(index) else {
            return;
        };
        let [a, gain] = [unknowns[A], unknowns[B]];
        let load = unknowns[LOAD] + effect.push(position, block.travel);
        let samples = motion.samples();
        let delay = unknowns[DELAY] * samples.reciprocal();
        for held in HeldCommand::late(motion, index, delay).iter().flatten() {
            let time = held.time() * samples;
            if time <= N::ZERO {
                continue;
            }
            let square = time * time;
            let before = self.velocity;
            let friction = unknowns[COULOMB] + effect.friction(before);
            let drive = gain * effect.command(held.mean) + load;
            let (gone, phase) =
                step.process(a * time, drive * square, friction * square, before * time);
            self.velocity = gone.velocity * time.reciprocal();
            let lead = gain * held.lead() * square * phase.moving_part();
            let way = gone.increment + lead;
            let change = self.velocity - before;
            let hidden = effect.hides(&mut self.memory, time, way, change);
            self.error = self.error - way + hidden;
        }
        self.error += block.travel;
    }
}
