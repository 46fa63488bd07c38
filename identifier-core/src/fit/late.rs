//! A block of a model whose command is late by any part of a block. The model moves separately under each command that
//! acts in the block. Friction may stop or reverse it in any of them.

use super::B;
use super::block::Block;
use super::command::HeldCommand;
use super::fitter::{Fit, Fitter};
use super::pass::Pass;
use super::record::Blocks;
use crate::model::{
    Acting, FrictionPhase, IdentifiableSet, ModelValues, MovingStep, drive, sensitivity,
    stribeck_factor as falling,
};
use crate::number::Number;
use crate::parameters::{Term, Unknown};

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// True for a model whose command is late, and whose viscous friction is that of both directions.
    pub(super) const IS_LATE: bool = S::HAS_TERMS && !S::TERMS.has(Term::Asymmetry);

    /// The waves of the angle in the middle of a block, from where the record begins: sin q and cos q − 1. The position
    /// is then that behind the block.
    pub(super) fn waves(&self, pass: &mut Pass<N, P>, travel: N) -> [N; 4] {
        let mut waves = [N::ZERO; 4];
        if S::HAS_LOAD_TERMS {
            let middle = pass.position + N::from_f64(0.5) * travel;
            pass.position += travel;
            let (sine, cosine) = (self.resolution * middle).sine_cosine();
            [waves[0], waves[1]] = [sine, cosine - N::ONE];
        }
        waves
    }

    /// One block of a pass of such a model.
    pub(super) fn late_block(
        &self,
        fit: &mut Fit<N, P>,
        record: &impl Blocks<N>,
        block: &Block<N>,
    ) {
        let free = self.free_unknowns(&fit.prior);
        let values = self.values(&fit.trial);
        let commands = HeldCommand::late(record, fit.next, values.terms.delay);
        let pass = &mut fit.pass;
        let waves = self.waves(pass, block.travel);
        let correction = pass.gain.innovation;
        let push = correction.velocity * pass.model.error;
        pass.model.error = pass.model.error - correction.position * pass.model.error;
        let pushes = pass
            .tangents
            .position
            .map(|position| correction.velocity * position);
        for position in &mut pass.tangents.position {
            *position = *position - correction.position * *position;
        }
        let before = pass.model.velocity;
        let mut displacement = N::ZERO;
        let mut last = None;
        for held in commands.iter().flatten() {
            let [begins, ends] = held.ends();
            let step = last.map_or(N::ZERO, |last| last - begins);
            last = Some(ends);
            if pass.model.velocity != N::ZERO {
                for (velocity, unknown) in pass.tangents.velocity.iter_mut().zip(S::UNKNOWNS) {
                    if unknown == Unknown::Delay {
                        *velocity += values.parameters.gain * step;
                    }
                }
            }
            if held.time() > N::ZERO {
                displacement += self.advance_under(pass, &values, held, waves, push, &pushes);
            }
        }
        pass.sums.speed_square += displacement * displacement;
        let change = pass.model.velocity - before;
        pass.sums.acceleration_square += change * change;
        // The first block is what tells the velocity at first.
        if fit.next > 0 && pass.model.velocity == N::ZERO {
            pass.gain.stand();
        }
        pass.turns.observe(block.travel);
        pass.model.observe(block.travel);
        pass.measure(&free);
    }

    /// Moves the model and its tangents for as long as a command acts; the distance.
    fn advance_under(
        &self,
        pass: &mut Pass<N, P>,
        values: &ModelValues<N>,
        held: &HeldCommand<N>,
        waves: [N; 4],
        push: N,
        pushes: &[N; P],
    ) -> N {
        let (parameters, time) = (&values.parameters, held.time());
        let (gain, square, half) = (parameters.gain, time * time, N::from_f64(0.5));
        let x = parameters.x * time;
        let before = pass.model.velocity;
        let acting = Acting {
            per_delay: held.falls,
            waves,
            ..Acting::at_once(held.mean)
        };
        let drive = drive::<N, S, P>(values, &acting) + push;
        let (mut coulomb, mut stribeck_factor) = (parameters.coulomb, N::ONE);
        if S::HAS_COULOMB_TERMS {
            // From rest it moves where the command pushes, against the higher friction.
            let (toward, friction) = if before == N::ZERO {
                (drive, coulomb + values.terms.low_speed)
            } else {
                (before, coulomb)
            };
            let friction = if toward > N::ZERO {
                friction
            } else {
                -friction
            };
            let change = drive - friction - parameters.x * before;
            let middle = before + half * time * change;
            if middle * toward > N::ZERO {
                stribeck_factor = falling(middle * values.terms.per_low_speed_velocity);
            }
            coulomb += values.terms.coulomb(stribeck_factor);
        }
        let (drive, coulomb) = (drive * square, coulomb * square);
        let (motion, phase) = self.step.process(x, drive, coulomb, before * time);
        let moving = phase.moving_part();
        let first_moment = held.first_moment() * square * moving;
        let displacement = motion.increment + gain * first_moment;
        pass.model.error = pass.model.error - displacement;
        pass.model.velocity = motion.velocity * time.reciprocal();
        let after = pass.model.velocity;
        let mut move_on = |time: N, mean: N, direction: N, kept: N| {
            let moving = MovingStep {
                displacement: mean,
                direction,
                stribeck_factor,
            };
            let whole = self.step.step.response(parameters.x * time);
            for i in 0..P {
                let Some(&unknown) = S::UNKNOWNS.get(i) else {
                    continue;
                };
                let velocity = pass.tangents.velocity[i];
                let own = sensitivity(values, unknown, &acting, &moving);
                let acceleration = (own - parameters.x * velocity - pushes[i]) * time;
                pass.tangents.position[i] += (velocity + whole.displacement * acceleration) * time;
                pass.tangents.velocity[i] = (velocity + whole.velocity * acceleration) * kept;
            }
        };
        match phase {
            FrictionPhase::Stuck => {}
            FrictionPhase::Moving { direction } => {
                move_on(time, half * (before + after), direction, N::ONE);
            }
            FrictionPhase::Stopped { direction, part } => {
                move_on(part * time, half * before, direction, N::ZERO);
            }
            FrictionPhase::Turned {
                direction,
                part,
                slowing,
            } => {
                move_on(part * time, half * before, direction, slowing);
                move_on((N::ONE - part) * time, half * after, -direction, N::ONE);
            }
        }
        pass.tangents.position[B] += first_moment;
        displacement
    }
}
