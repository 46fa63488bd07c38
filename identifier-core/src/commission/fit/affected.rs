use super::effect_model::{EffectModel, Memory};
use super::inputs::Inputs;
use super::motion::MotionRecord;
use super::{A, ALL, B, COULOMB, DELAY, LOAD, POSITION, VELOCITY};
use crate::model::FrictionStep;
use crate::number::Number;

/// A model with an effect that starts beside the servo and goes where the recorded command drives it.
/// Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Affected<N> {
    inputs: Inputs<N>,
    /// The servo's position less the model's.
    pub(super) error: N,
    velocity: N,
    memory: Memory<N>,
}

impl<N: Number> Affected<N> {
    /// Before the first piece of a record.
    pub(super) fn new<const W: usize>(
        unknowns: &[N; ALL],
        effect: &EffectModel<N>,
        motion: &MotionRecord<N, W>,
    ) -> Self {
        Self {
            inputs: Inputs::delayed(motion, unknowns[DELAY]),
            error: -unknowns[POSITION],
            velocity: unknowns[VELOCITY],
            memory: effect.memory(),
        }
    }

    /// Moves over a piece of the record, in whose middle the servo was at a position.
    pub(super) fn advance<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        unknowns: &[N; ALL],
        effect: &EffectModel<N>,
        motion: &MotionRecord<N, W>,
        (index, position): (usize, N),
    ) {
        let Some(piece) = motion.get(index) else {
            return;
        };
        let [a, gain] = [unknowns[A], unknowns[B]];
        let load = unknowns[LOAD] + effect.push(position, piece.travel);
        let mut inputs = self.inputs;
        inputs.over(motion, piece.samples, |acting| {
            let time = acting.time;
            if time <= N::ZERO {
                return;
            }
            let square = time * time;
            let before = self.velocity;
            let friction = unknowns[COULOMB] + effect.friction(before);
            let drive = gain * effect.command(acting.command) + load;
            let (gone, phase) =
                step.process(a * time, drive * square, friction * square, before * time);
            self.velocity = gone.velocity * time.reciprocal();
            let lead = gain * acting.lead * square * phase.moving_part();
            let way = gone.increment + lead;
            let change = self.velocity - before;
            let hidden = effect.hides(&mut self.memory, time, way, change);
            self.error = self.error - way + hidden;
        });
        self.inputs = inputs;
        self.error += piece.travel;
    }
}
