use super::block::Block;
use super::fitter::{Fit, Fitter};
use super::record::Record;
use super::{A, B, POSITION, UNKNOWNS, VELOCITY};
use crate::adaptation::NormalEquations;
use crate::model::{Acting, ListeningModel, ModelValues, Tangents, TermValues};
use crate::number::Number;
use crate::parameters::{AbCoulombLoad, ModelParameters};

/// A pass over the record: the model, its tangents and what they add up to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pass<N> {
    pub(super) model: ListeningModel<N>,
    pub(super) tangents: Tangents<N, UNKNOWNS>,
    pub(super) equations: NormalEquations<N, UNKNOWNS>,
    pub(super) last_error: N,
    pub(super) lag_one: N,
    pub(super) speed_square: N,
    pub(super) acceleration_square: N,
}

impl<N: Number> Pass<N> {
    pub(super) fn at(unknowns: &[N; UNKNOWNS]) -> Self {
        let mut tangents = Tangents::NONE;
        tangents.position[POSITION] = N::ONE;
        tangents.velocity[VELOCITY] = N::ONE;
        Self {
            model: ListeningModel {
                error: -unknowns[POSITION],
                velocity: unknowns[VELOCITY],
            },
            tangents,
            equations: NormalEquations::EMPTY,
            last_error: N::ZERO,
            lag_one: N::ZERO,
            speed_square: N::ZERO,
            acceleration_square: N::ZERO,
        }
    }

    #[inline]
    pub(super) fn measure(&mut self, free: &[bool; 4]) {
        let mut row = self.tangents.position;
        for (entry, &free) in row.iter_mut().zip(free) {
            if !free {
                *entry = N::ZERO;
            }
        }
        let error = self.model.error;
        self.equations.add(&row, error);
        self.lag_one += error * self.last_error;
        self.last_error = error;
    }
}

impl<N: Number> Fitter<N> {
    /// One block of the linear pass: the model is at rest, the servo's measured motion drives the
    /// tangents.
    pub(super) fn linear_block(&self, fit: &mut Fit<N>, block: &Block<N>, direction: N) {
        let pass = &mut fit.pass;
        let command = block.command;
        let correction = &fit.correction;
        // The model of zero gain: its velocity is that of the correction.
        let drive = correction.velocity * pass.model.error;
        let before = pass.model.velocity;
        let half = N::from_f64(0.5);
        let pull = correction.position * pass.model.error;
        pass.model.error = pass.model.error - pull - before - half * drive;
        pass.model.velocity = before + drive;
        let own = [-block.travel, command, -direction, N::ONE];
        for i in 0..UNKNOWNS {
            let position = pass.tangents.position[i];
            let mut change = -(correction.velocity * position);
            let mut ahead = N::ZERO;
            if let Some(&own) = own.get(i) {
                // A servo that friction holds does not depend on any parameter.
                if direction != N::ZERO || i == A {
                    change += own;
                    ahead = if i == B { block.lead } else { N::ZERO };
                }
            }
            let velocity = pass.tangents.velocity[i];
            pass.tangents.position[i] =
                position - correction.position * position + velocity + half * change + ahead;
            pass.tangents.velocity[i] = velocity + change;
        }
        pass.model.observe(block.travel);
        pass.measure(&self.free);
    }

    pub(super) fn model_block(&self, fit: &mut Fit<N>, block: &Block<N>) {
        let [a, b, c, d, _, _] = fit.trial;
        let values = ModelValues {
            parameters: ModelParameters {
                x: a,
                gain: b,
                coulomb: c,
                load: d,
            },
            terms: TermValues::NONE,
        };
        let acting = Acting::at_once(block.command);
        let pass = &mut fit.pass;
        let before = pass.model.velocity;
        let response = self.step.step.response(a);
        let moved = pass.model.advance::<AbCoulombLoad, 4>(
            &self.step,
            &response,
            &values,
            &acting,
            &fit.correction,
        );
        pass.tangents
            .advance::<AbCoulombLoad, 4>(&values, &acting, &fit.correction, &moved);
        let (way, phase) = (moved.way, moved.phase);
        let moving = phase.moving_part();
        pass.model.error = pass.model.error - b * block.lead * moving;
        // The tangents of first order are half a block ahead of the motion.
        pass.tangents.position[B] += block.lead * moving;
        let change = pass.model.velocity - before;
        pass.speed_square += way * way;
        pass.acceleration_square += change * change;
        pass.model.observe(block.travel);
        pass.measure(&self.free);
    }
}

/// The direction in which the servo moved during a block, zero at standstill: by its own travel, or,
/// if that is within the encoder's rounding, by that of the neighbouring blocks too.
pub(super) fn direction<N: Number, const W: usize>(record: &Record<N, W>, index: usize) -> N {
    /// Travel that exceeds crossing one edge of the encoder to and fro.
    const BEYOND: f64 = 1.5;
    let beyond = N::from_f64(BEYOND);
    let travel = |index: usize| record.get(index).map_or(N::ZERO, |block| block.travel);
    let own = travel(index);
    let around = own + travel(index + 1) + index.checked_sub(1).map_or(N::ZERO, travel);
    for way in [own, around] {
        if way > beyond {
            return N::ONE;
        }
        if way < -beyond {
            return -N::ONE;
        }
    }
    N::ZERO
}
