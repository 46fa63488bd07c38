use super::B;
use super::block::Block;
use super::command::{HeldCommand, moments};
use super::fitter::{Fit, Fitter};
use super::record::Blocks;
use crate::model::{Acting, IdentifiableSet};
use crate::number::Number;
use crate::parameters::Unknown;

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// One block of the linear pass: the model is at rest, the servo's measured motion drives the
    /// tangents.
    pub(super) fn linear_block(
        &self,
        fit: &mut Fit<N, P>,
        record: &impl Blocks<N>,
        block: &Block<N>,
        direction: N,
    ) {
        let free = self.free_unknowns(&fit.prior);
        let values = self.values(&self.begin_values(&fit.prior));
        let [command, first_moment] = if Self::IS_LATE {
            moments(&HeldCommand::late(record, fit.next, values.terms.delay))
        } else {
            [block.command, block.first_moment]
        };
        let pass = &mut fit.pass;
        let [sine, cosine, ..] = self.waves(pass, block.travel);
        let correction = pass.gain.innovation;
        // The model of zero gain: its velocity is that of the correction.
        let drive = correction.velocity * pass.model.error;
        let before = pass.model.velocity;
        let half = N::from_f64(0.5);
        let pull = correction.position * pass.model.error;
        pass.model.error = pass.model.error - pull - before - half * drive;
        pass.model.velocity = before + drive;
        for i in 0..P {
            let position = pass.tangents.position[i];
            let mut change = -(correction.velocity * position);
            let mut ahead = N::ZERO;
            let own = match S::UNKNOWNS.get(i) {
                Some(Unknown::A) => -block.travel,
                // A servo that friction holds does not depend on any other parameter.
                _ if direction == N::ZERO => N::ZERO,
                Some(Unknown::B) => {
                    ahead = first_moment;
                    command
                }
                Some(Unknown::Coulomb) => -direction,
                Some(Unknown::Load) => N::ONE,
                Some(Unknown::GravitySine) => sine,
                Some(Unknown::GravityCosine) => cosine,
                _ => N::ZERO,
            };
            change += own;
            let velocity = pass.tangents.velocity[i];
            pass.tangents.position[i] =
                position - correction.position * position + velocity + half * change + ahead;
            pass.tangents.velocity[i] = velocity + change;
        }
        pass.model.observe(block.travel);
        pass.measure(&free);
    }

    pub(super) fn model_block(
        &self,
        fit: &mut Fit<N, P>,
        record: &impl Blocks<N>,
        block: &Block<N>,
    ) {
        if Self::IS_LATE {
            return self.late_block(fit, record, block);
        }
        let free = self.free_unknowns(&fit.prior);
        let values = self.values(&fit.trial);
        let acting = Acting::at_once(block.command);
        let pass = &mut fit.pass;
        let correction = pass.gain.innovation;
        if fit.next == 0 {
            // Nearly that, so that friction has its direction.
            pass.model.velocity = block.travel;
        }
        let before = pass.model.velocity;
        let response = self.step.step.response(values.parameters.x);
        let moved =
            pass.model
                .advance::<S, P>(&self.step, &response, &values, &acting, &correction);
        pass.tangents
            .advance::<S, P>(&values, &acting, &correction, &moved);
        let gain = values.parameters.gain;
        let kept = N::ONE - values.parameters.x;
        pass.early
            .advance(block, gain, kept, &correction, moved.phase);
        let (displacement, phase) = (moved.displacement, moved.phase);
        let moving = phase.moving_part();
        pass.model.error = pass.model.error - gain * block.first_moment * moving;
        // The tangents of first order are half a block ahead of the motion.
        pass.tangents.position[B] += block.first_moment * moving;
        let change = pass.model.velocity - before;
        pass.sums.speed_square += displacement * displacement;
        pass.sums.acceleration_square += change * change;
        pass.turns.observe(block.travel);
        pass.model.observe(block.travel);
        pass.measure(&free);
    }
}
