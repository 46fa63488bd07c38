use super::B;
use super::block::Block;
use super::colour::Colour;
use super::fitter::{Fit, Fitter};
use crate::adaptation::IdentifiableSet;
use crate::linalg::NormalEquations;
use crate::model::{ObserverModel, Tangents};
use crate::number::Number;
use crate::parameters::Unknown;

/// A pass over the record: the model, its tangents and their sums.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pass<N, I, const Q: usize> {
    /// The known inputs besides the blocks.
    pub(super) inputs: I,
    pub(super) model: ObserverModel<N>,
    pub(super) tangents: Tangents<N, Q>,
    pub(super) equations: NormalEquations<N, Q>,
    pub(super) sums: PassSums<N>,
}

/// What a pass sums besides its equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PassSums<N> {
    pub(super) colour: Colour<N>,
    pub(super) speed_square: N,
    pub(super) acceleration_square: N,
}

impl<N: Number, I, const Q: usize> Pass<N, I, Q> {
    /// Before the first block: a model of `unknowns`, the initial position and velocity from a place on.
    pub(super) fn at(unknowns: &[N; Q], initial: usize, inputs: I) -> Self {
        let mut tangents = Tangents::NONE;
        tangents.position[initial] = N::ONE;
        tangents.velocity[initial + 1] = N::ONE;
        Self {
            inputs,
            model: ObserverModel {
                error: -unknowns[initial],
                velocity: unknowns[initial + 1],
            },
            tangents,
            equations: NormalEquations::EMPTY,
            sums: PassSums {
                colour: Colour::NONE,
                speed_square: N::ZERO,
                acceleration_square: N::ZERO,
            },
        }
    }

    #[inline]
    pub(super) fn measure(&mut self, free: &[bool; Q]) {
        let mut row = self.tangents.position;
        for (entry, &free) in row.iter_mut().zip(free) {
            if !free {
                *entry = N::ZERO;
            }
        }
        let error = self.model.error;
        self.equations.add(&row, error);
        self.sums.colour.add(error);
    }
}

impl<N, S, const P: usize, const Q: usize> Fitter<N, S, P, Q>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// One block of the linear pass: the model is at rest, the servo's measured motion drives the
    /// tangents.
    pub(super) fn linear_block(
        &self,
        fit: &mut Fit<N, S::Inputs<N>, P, Q>,
        block: &Block<N>,
        direction: N,
    ) {
        let free = self.free_unknowns(&fit.prior);
        let values = self.values(&self.begin_values(&fit.prior));
        let acting = self.acting(&mut fit.pass.inputs, block, &values);
        let pass = &mut fit.pass;
        let correction = &fit.correction;
        // The model of zero gain: its velocity is that of the correction.
        let drive = correction.velocity * pass.model.error;
        let before = pass.model.velocity;
        let half = N::from_f64(0.5);
        let pull = correction.position * pass.model.error;
        pass.model.error = pass.model.error - pull - before - half * drive;
        pass.model.velocity = before + drive;
        for i in 0..Q {
            let position = pass.tangents.position[i];
            let mut change = -(correction.velocity * position);
            let mut ahead = N::ZERO;
            let own = match S::UNKNOWNS.get(i) {
                Some(Unknown::A) => -block.travel,
                // A servo that friction holds does not depend on any other parameter.
                _ if direction == N::ZERO => N::ZERO,
                Some(Unknown::B) => {
                    ahead = block.lead;
                    acting.command
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

    pub(super) fn model_block(&self, fit: &mut Fit<N, S::Inputs<N>, P, Q>, block: &Block<N>) {
        let free = self.measured_unknowns(fit);
        let values = self.values(&fit.trial);
        let acting = self.acting(&mut fit.pass.inputs, block, &values);
        let pass = &mut fit.pass;
        let before = pass.model.velocity;
        let response = self.step.step.response(values.parameters.x);
        let moved =
            pass.model
                .advance::<S, P>(&self.step, &response, &values, &acting, &fit.correction);
        pass.tangents
            .advance::<S, P>(&values, &acting, &fit.correction, &moved);
        let (way, phase) = (moved.displacement, moved.phase);
        let moving = phase.moving_part();
        pass.model.error = pass.model.error - values.parameters.gain * block.lead * moving;
        // The tangents of first order are half a block ahead of the motion.
        pass.tangents.position[B] += block.lead * moving;
        let change = pass.model.velocity - before;
        pass.sums.speed_square += way * way;
        pass.sums.acceleration_square += change * change;
        pass.model.observe(block.travel);
        pass.measure(&free);
    }
}
