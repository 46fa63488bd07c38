use super::arithmetic::{
    Accumulator, FULL, Fraction, Word, between, is_within, limit, narrow, product, quarter_product,
    quotient, wide, with_product, word,
};
use crate::constants::encode;
use crate::unrolled::each;

/// Terms of the series of a step.
const TERMS: usize = 6;

/// The exact zero-order-hold step on words, with Coulomb friction that stops and breaks away: the
/// equations of [`ZeroOrderHoldStep`](crate::model::ZeroOrderHoldStep) and [`FrictionStep`](crate::model::FrictionStep).
///
/// Velocities, and accelerations per sample, are of one full scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedStep {
    /// Halved: with 31 fraction bits.
    series: [Word; TERMS],
    parts: [Word; 3],
}

encode! {
    [] FixedStep as "FixedStep" { series, parts }
}

/// A motion over one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedMotion {
    pub(super) increment: Word,
    pub(super) velocity: Accumulator,
}

impl FixedMotion {
    pub(super) const NONE: Self = Self {
        increment: Word::ZERO,
        velocity: Accumulator::ZERO,
    };

    /// True if it is within the full scale.
    #[inline]
    pub(super) fn is_within(&self) -> bool {
        // The velocity's high half, in quarters of a word.
        let velocity = (self.velocity.to_bits() >> 32) as i32;
        let one = Word::ONE.to_bits() >> 2;
        is_within(self.increment) && velocity < one && velocity >= -one
    }
}

/// Friction during a sample: the mean of sign(q̇) and the part in which the model moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedPhase {
    pub(super) direction: Word,
    pub(super) moving: Word,
}

impl FixedPhase {
    const STUCK: Self = Self {
        direction: Word::ZERO,
        moving: Word::ZERO,
    };
}

/// The response to an acceleration over a time: twice the displacement, and the velocity, per acceleration.
#[derive(Debug, Clone, Copy)]
struct FixedResponse {
    double_way: Word,
    velocity: Word,
}

impl FixedStep {
    pub(super) fn new() -> Self {
        let mut factorial = 1.0;
        let mut sign = 1.0;
        Self {
            series: core::array::from_fn(|k| {
                factorial *= (k + 2) as f64;
                let coefficient = sign / factorial;
                sign = -sign;
                word(2.0 * coefficient, 0)
            }),
            parts: [1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0].map(|part| word(part, 0)),
        }
    }

    /// Moves one sample under the held acceleration `drive` without friction, with x = a T.
    #[inline]
    pub(super) fn step_frictionless(
        &self,
        x: Fraction,
        drive: Word,
        velocity: Accumulator,
    ) -> FixedMotion {
        let response = self.response(x);
        let now = narrow(velocity);
        let acceleration = drive - x.times(now);
        FixedMotion {
            increment: now + way(response, acceleration),
            velocity: with_product(velocity, response.velocity, acceleration),
        }
    }

    /// Moves one sample under the held acceleration `drive` with friction `coulomb` ≥ 0.
    #[inline]
    pub(super) fn step_with_friction(
        &self,
        x: Fraction,
        drive: Word,
        coulomb: Word,
        velocity: Accumulator,
    ) -> (FixedMotion, FixedPhase) {
        let forward = if velocity != Accumulator::ZERO {
            velocity > Accumulator::ZERO
        } else if drive > coulomb {
            true
        } else if drive < -coulomb {
            false
        } else {
            return (FixedMotion::NONE, FixedPhase::STUCK);
        };
        let friction = if forward { coulomb } else { -coulomb };
        let pushed = drive - friction;
        let motion = self.step_frictionless(x, pushed, velocity);
        let keeps_direction = if forward {
            motion.velocity >= Accumulator::ZERO
        } else {
            motion.velocity <= Accumulator::ZERO
        };
        if keeps_direction {
            let phase = FixedPhase {
                direction: directed(FULL, forward),
                moving: FULL,
            };
            (motion, phase)
        } else {
            self.through_zero(x, pushed, drive + friction, velocity, forward)
        }
    }

    /// The sample in which the velocity passes through zero. This happens at τ = r (1 + xr/2 + (xr)²/3 + …), r = −v/A.
    #[cold]
    fn through_zero(
        &self,
        x: Fraction,
        pushed: Word,
        beyond: Word,
        velocity: Accumulator,
        forward: bool,
    ) -> (FixedMotion, FixedPhase) {
        let now = narrow(velocity);
        let acceleration = pushed - x.times(now);
        let braking = limit(acceleration).abs().max(Word::DELTA);
        let r = quotient(limit(now).abs(), braking);
        let xr = x.times(r);
        let [half, third, quarter] = self.parts;
        let series = [third, half]
            .into_iter()
            .fold(quarter, |sum, part| part + product(sum, xr));
        let exact = r + product(product(series, xr), r);
        let part = between(exact, Word::ZERO, FULL);
        let before = product(now, part) + way(self.partial_response(x, part), acceleration);
        let turns = if forward {
            beyond < Word::ZERO
        } else {
            beyond > Word::ZERO
        };
        if !turns {
            let stopped = FixedMotion {
                increment: before,
                velocity: Accumulator::ZERO,
            };
            let phase = FixedPhase {
                direction: directed(part, forward),
                moving: part,
            };
            return (stopped, phase);
        }
        let after = self.partial_response(x, FULL - part);
        let turned = FixedMotion {
            increment: before + way(after, beyond),
            velocity: wide(product(after.velocity, beyond)),
        };
        let phase = FixedPhase {
            direction: directed(part - (FULL - part), forward),
            moving: FULL,
        };
        (turned, phase)
    }

    /// h₂ = ½ − x/6 + x²/24 − … and h₁ = 1 − x h₂.
    #[inline]
    fn response(&self, x: Fraction) -> FixedResponse {
        let [head @ .., last] = self.series;
        let mut double_way = last;
        each::<{ TERMS - 1 }>(|i| double_way = head[TERMS - 2 - i] + x.times(double_way));
        FixedResponse {
            double_way,
            velocity: Word::ONE - (x.times(double_way) >> 1),
        }
    }

    fn partial_response(&self, x: Fraction, part: Word) -> FixedResponse {
        let FixedResponse {
            double_way,
            velocity,
        } = self.response(x.part(part));
        FixedResponse {
            double_way: product(product(double_way, part), part),
            velocity: product(velocity, part),
        }
    }
}

/// The displacement that an acceleration adds.
#[inline]
fn way(response: FixedResponse, acceleration: Word) -> Word {
    quarter_product(response.double_way, acceleration) << 1
}

#[inline]
fn directed(x: Word, forward: bool) -> Word {
    if forward { x } else { -x }
}
