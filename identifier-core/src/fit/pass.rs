use super::B;
use super::block::Block;
use super::colour::Colour;
use super::command::{HeldCommand, moments};
use super::early::{EarlySums, EarlyTangent};
use super::fitter::{Fit, Fitter};
use super::gain::KalmanGain;
use super::record::Blocks;
use super::survey::Turns;
use crate::adaptation::IdentifiableSet;
use crate::linalg::NormalEquations;
use crate::model::{ObserverModel, Tangents};
use crate::number::Number;
use crate::parameters::Unknown;

/// A pass over the record: the model, its tangents and their sums.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pass<N, I, const P: usize> {
    /// The known inputs besides the blocks.
    pub(super) inputs: I,
    pub(super) gain: KalmanGain<N>,
    pub(super) model: ObserverModel<N>,
    pub(super) tangents: Tangents<N, P>,
    pub(super) equations: NormalEquations<N, P>,
    early: EarlyTangent<N>,
    pub(super) sums: PassSums<N, P>,
    pub(super) turns: Turns<N>,
}

/// What a pass sums besides its equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PassSums<N, const P: usize> {
    pub(super) colour: Colour<N>,
    pub(super) speed_square: N,
    pub(super) acceleration_square: N,
    pub(super) early: EarlySums<N, P>,
}

impl<N: Number, I, const P: usize> Pass<N, I, P> {
    /// Before the first block: a model at the measured position.
    pub(super) fn at_first(inputs: I, gain: KalmanGain<N>, reversal: N) -> Self {
        Self {
            inputs,
            gain,
            model: ObserverModel::alongside(N::ZERO),
            tangents: Tangents::NONE,
            equations: NormalEquations::EMPTY,
            early: EarlyTangent::NONE,
            sums: PassSums {
                colour: Colour::NONE,
                speed_square: N::ZERO,
                acceleration_square: N::ZERO,
                early: EarlySums::NONE,
            },
            turns: Turns::beyond(reversal),
        }
    }

    #[inline]
    pub(super) fn measure(&mut self, free: &[bool; P]) {
        self.gain.advance();
        let weight = self.gain.weight;
        let mut row = self.tangents.position;
        for (entry, &free) in row.iter_mut().zip(free) {
            *entry = if free { *entry * weight } else { N::ZERO };
        }
        let jump = self.gain.jump;
        if jump > N::ZERO {
            self.model.velocity += jump * self.model.error;
            for (velocity, &position) in
                (self.tangents.velocity.iter_mut()).zip(&self.tangents.position)
            {
                *velocity = *velocity - jump * position;
            }
            self.early.velocity = self.early.velocity - jump * self.early.position;
        }
        let error = self.model.error * weight;
        self.equations.add(&row, error);
        self.sums.colour.add(error);
        let early = self.early.position * weight;
        self.sums.early.add(early, error, &row);
    }
}

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// One block of the linear pass: the model is at rest, the servo's measured motion drives the
    /// tangents.
    pub(super) fn linear_block(
        &self,
        fit: &mut Fit<N, S::Inputs<N>, P>,
        record: &impl Blocks<N>,
        block: &Block<N>,
        direction: N,
    ) {
        let free = self.free_unknowns(&fit.prior);
        let values = self.values(&self.begin_values(&fit.prior));
        let [command, lead] = if Self::IS_LATE {
            moments(&HeldCommand::late(record, fit.next, values.terms.delay))
        } else {
            let acting = self.acting(&mut fit.pass.inputs, block, &values);
            [acting.command, block.lead]
        };
        let pass = &mut fit.pass;
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
                    ahead = lead;
                    command
                }
                Some(Unknown::Coulomb) => -direction,
                Some(Unknown::Load) => N::ONE,
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
        fit: &mut Fit<N, S::Inputs<N>, P>,
        record: &impl Blocks<N>,
        block: &Block<N>,
    ) {
        if Self::IS_LATE {
            return self.late_block(fit, record, block);
        }
        let free = self.free_unknowns(&fit.prior);
        let values = self.values(&fit.trial);
        let acting = self.acting(&mut fit.pass.inputs, block, &values);
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
        let (way, phase) = (moved.displacement, moved.phase);
        let moving = phase.moving_part();
        pass.model.error = pass.model.error - gain * block.lead * moving;
        // The tangents of first order are half a block ahead of the motion.
        pass.tangents.position[B] += block.lead * moving;
        let change = pass.model.velocity - before;
        pass.turns.observe(block.travel);
        pass.sums.speed_square += way * way;
        pass.sums.acceleration_square += change * change;
        pass.model.observe(block.travel);
        pass.measure(&free);
    }
}
