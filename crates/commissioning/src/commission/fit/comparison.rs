use super::affected::Affected;
use super::effect::Effect;
use super::effect_model::EffectModel;
use super::motion::MotionRecord;
use super::{ALL, UNKNOWNS};
use identifier_core::fit::Blocks;
use identifier_core::model::FrictionStep;
use identifier_core::number::Number;
use identifier_core::replay::NormalEquations;

/// A pass over a record with a model that has an effect. Beside it run models with one unknown slightly different. The
/// effect of the difference is the tangent, through every stop and backlash.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Comparison<N> {
    effect: Effect,
    resolution: N,
    pub(super) unknowns: [N; ALL],
    changes: [N; ALL],
    model: Affected<N>,
    changed: [Affected<N>; ALL],
    pub(super) equations: NormalEquations<N, ALL>,
    next: usize,
    position: N,
}

impl<N: Number> Comparison<N> {
    /// Before the first block. An unknown whose change is zero stays.
    pub(super) fn new(
        effect: Effect,
        resolution: N,
        unknowns: &[N; ALL],
        changes: &[N; ALL],
    ) -> Self {
        let begun = |unknowns: &[N; ALL]| {
            let effect = EffectModel::new(effect, unknowns, resolution);
            Affected::new(unknowns, &effect)
        };
        Self {
            effect,
            resolution,
            unknowns: *unknowns,
            changes: *changes,
            model: begun(unknowns),
            changed: core::array::from_fn(|i| begun(&with_change(unknowns, changes, i))),
            equations: NormalEquations::EMPTY,
            next: 0,
            position: N::ZERO,
        }
    }

    /// Continues by a block; true if there is none left.
    pub(super) fn advance<const W: usize>(
        &mut self,
        step: &FrictionStep<N>,
        motion: &MotionRecord<N, W>,
    ) -> bool {
        let Some(block) = motion.block(self.next) else {
            return true;
        };
        let middle = self.position + N::from_f64(0.5) * block.travel;
        let at = (self.next, middle);
        let effect = EffectModel::new(self.effect, &self.unknowns, self.resolution);
        self.model
            .advance(step, &self.unknowns, &effect, motion, at);
        let error = self.model.error;
        let mut row = [N::ZERO; ALL];
        for i in 0..ALL {
            let change = self.changes[i];
            if change == N::ZERO {
                continue;
            }
            let unknowns = with_change(&self.unknowns, &self.changes, i);
            let effect = EffectModel::new(self.effect, &unknowns, self.resolution);
            let model = &mut self.changed[i];
            model.advance(step, &unknowns, &effect, motion, at);
            row[i] = (error - model.error) * change.reciprocal();
        }
        self.equations.add(&row, error);
        self.position += block.travel;
        self.next += 1;
        false
    }

    /// Sum of squared errors predicted for the minimum of the linearisation.
    pub(super) fn promises(&self) -> f64 {
        let explained = self.equations.explained_by(&[true; ALL]);
        (self.equations.cost() - explained).to_f64()
    }
}

fn with_change<N: Number>(unknowns: &[N; ALL], changes: &[N; ALL], place: usize) -> [N; ALL] {
    let mut changed = *unknowns;
    for (own, &change) in changed.iter_mut().zip(changes).skip(place).take(1) {
        *own += change;
    }
    changed
}

/// The sizes among unknowns.
pub(super) fn sizes_of<N: Number>(unknowns: &[N; ALL]) -> super::effect::Sizes {
    core::array::from_fn(|i| unknowns[UNKNOWNS + i].to_f64())
}
