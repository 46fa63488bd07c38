use super::block::Block;
use crate::linalg::NormalEquations;
use crate::model::{FrictionPhase, Innovation};
use crate::number::Number;

/// The sensitivity of the model to a command that acts earlier than it was recorded. It is ∂q_e/∂s and ∂v_e/∂s for
/// u(t + s), s in blocks. Like the other [tangents](crate::model::Tangents) it is of first order in the block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EarlyTangent<N> {
    pub(super) position: N,
    pub(super) velocity: N,
    /// The command at the end of the last block; none before the first.
    end: Option<N>,
}

/// The sums of that tangent in a pass: with itself, with the error and with the tangents of the unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EarlySums<N, const P: usize> {
    square: N,
    error: N,
    with: [N; P],
}

impl<N: Number> EarlyTangent<N> {
    pub(super) const NONE: Self = Self {
        position: N::ZERO,
        velocity: N::ZERO,
        end: None,
    };

    /// Moves over a block. The model of this `gain` was in this `phase` and kept a part of its velocity.
    #[inline]
    pub(super) fn advance(
        &mut self,
        block: &Block<N>,
        gain: N,
        kept: N,
        correction: &Innovation<N>,
        phase: FrictionPhase<N>,
    ) {
        // By mean and first moment: of a straight line that is −1/12 of its slope.
        let end = block.command - N::from_f64(6.0) * block.first_moment;
        let change = self.end.replace(end).map_or(N::ZERO, |before| end - before);
        let position = self.position;
        let followed = (N::ONE - correction.position) * position;
        let velocity = kept * self.velocity - correction.velocity * position + gain * change;
        (self.position, self.velocity) = match phase {
            FrictionPhase::Stuck => (followed, N::ZERO),
            FrictionPhase::Turned { slowing, .. } => (followed + velocity, velocity * slowing),
            FrictionPhase::Moving { .. } => (followed + velocity, velocity),
            FrictionPhase::Stopped { .. } => (followed + velocity, N::ZERO),
        };
    }
}

impl<N: Number, const P: usize> EarlySums<N, P> {
    pub(super) const NONE: Self = Self {
        square: N::ZERO,
        error: N::ZERO,
        with: [N::ZERO; P],
    };

    /// Takes in a block: the tangent, the error and those of the unknowns, all weighted.
    #[inline]
    pub(super) fn add(&mut self, early: N, error: N, row: &[N; P]) {
        self.square += early * early;
        self.error += early * error;
        for (sum, &own) in self.with.iter_mut().zip(row) {
            *sum += early * own;
        }
    }
}

/// The evidence that the command acted before it was recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum EarlyCommand {
    /// There is none.
    No,
    /// Possibly: more data will decide.
    Perhaps,
    /// It has, or the command is recorded late.
    Certain,
}

/// Tests whether the command acted before it was recorded. It is then the cause of some of the residual of the pass.
/// `samples` are those of a block, `blocks` those of the pass.
pub(super) fn early_command<N: Number, const P: usize>(
    equations: &NormalEquations<N, P>,
    sums: &EarlySums<N, P>,
    free: &[bool; P],
    samples: N,
    blocks: usize,
) -> EarlyCommand {
    /// The least time that counts, in samples and as a part of a block. Below this part it may be the error of a model
    /// that moves by blocks. It is up to 0.06 if the command is not early.
    const LEAST: [f64; 2] = [0.6, 0.1];
    /// The part of the squared errors from which it counts.
    const SHARE: f64 = 0.1;
    /// Standard errors beyond half of that time from which it is certain.
    const CERTAIN: f64 = 4.0;
    let EarlySums {
        square,
        error,
        with,
    } = sums;
    let step = equations.solve(N::ZERO, free);
    let [taken] = equations.variances(&[*with]);
    let mut left = *error;
    for (with, step) in with.iter().zip(step) {
        left = left - *with * step;
    }
    // Of a tangent that those of the unknowns make up nothing is left but rounding.
    let own = *square - taken;
    if own <= N::from_f64(1e-4) * *square {
        return EarlyCommand::No;
    }
    let early = left * own.reciprocal();
    let explained = early * left;
    let cost = equations.cost();
    let [of_samples, of_block] = LEAST.map(N::from_f64);
    let least = (of_samples * samples.reciprocal()).larger(of_block);
    if early < least || explained < N::from_f64(SHARE) * cost {
        return EarlyCommand::No;
    }
    let beyond = early - N::from_f64(0.5) * least;
    let variance = (cost - explained) * N::from_count(blocks.max(1) as i32).reciprocal();
    let certain = N::from_f64(CERTAIN * CERTAIN) * variance;
    if beyond * beyond * own > certain {
        EarlyCommand::Certain
    } else {
        EarlyCommand::Perhaps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A command that rises linearly and acts early moves a mass by its increase: ∂v/∂s = b (u(t) − u(0)).
    #[test]
    fn an_earlier_command_moves_a_free_mass_by_its_increase() {
        let (gain, slope) = (2.0, 0.3);
        let (mut tangent, mut velocity, mut position) = (EarlyTangent::<f64>::NONE, 0.0, 0.0);
        for k in 0..9 {
            let block = Block {
                travel: 0.0,
                command: slope * (f64::from(k) + 0.5),
                first_moment: -slope / 12.0,
            };
            let correction = Innovation {
                position: 0.0,
                velocity: 0.0,
            };
            let phase = FrictionPhase::Moving { direction: 1.0 };
            tangent.advance(&block, gain, 1.0, &correction, phase);
            velocity = gain * slope * f64::from(k);
            position += velocity;
        }
        assert!((tangent.velocity - velocity).abs() < 1e-12, "{tangent:?}");
        assert!((tangent.position - position).abs() < 1e-12, "{tangent:?}");
        let end = tangent.end.expect("blocks");
        assert!((end - 9.0 * slope).abs() < 1e-12, "{end}");
    }
}
