use super::arithmetic::{
    Accumulator, Word, between, narrow, product, quotient, shifted, wide, word, word_product,
};
use super::ranges::Scales;

/// The exact zero-order-hold step on words, with Coulomb friction that stops and breaks away: the
/// equations of [`HeldStep`](crate::model::HeldStep) and [`FrictionStep`](crate::model::FrictionStep).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedStep {
    series: [Word; 6],
    parts: [Word; 3],
    scales: Scales,
}

/// A motion over one sample, of the velocity's full scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FixedMotion {
    pub(super) increment: Accumulator,
    pub(super) velocity: Accumulator,
}

impl FixedMotion {
    pub(super) const NONE: Self = Self {
        increment: Accumulator::ZERO,
        velocity: Accumulator::ZERO,
    };
}

/// What friction did during a sample: the mean of sign(q̇) and the part in which the model moved.
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

/// How an acceleration acts over a time: way and velocity per acceleration, as fractions.
#[derive(Debug, Clone, Copy)]
struct Response {
    way: Word,
    velocity: Word,
}

impl FixedStep {
    pub(super) fn new(scales: &Scales) -> Self {
        let mut factorial = 1.0;
        let mut sign = 1.0;
        Self {
            series: core::array::from_fn(|k| {
                factorial *= (k + 2) as f64;
                let coefficient = sign / factorial;
                sign = -sign;
                word(coefficient, 0)
            }),
            parts: [1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0].map(|part| word(part, 0)),
            scales: *scales,
        }
    }

    /// Moves one sample under the held acceleration `drive` without friction.
    #[inline]
    pub(super) fn slide(&self, x: Word, drive: Accumulator, velocity: Accumulator) -> FixedMotion {
        let response = self.response(x);
        let acceleration = self.acceleration(x, drive, velocity);
        FixedMotion {
            increment: self.plus(velocity, response.way, acceleration),
            velocity: self.plus(velocity, response.velocity, acceleration),
        }
    }

    /// Moves one sample under the held acceleration `drive` with friction `coulomb` ≥ 0, both of the
    /// acceleration's full scale.
    #[inline]
    pub(super) fn rub(
        &self,
        x: Word,
        drive: Accumulator,
        coulomb: Accumulator,
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
        let pushed = drive.saturating_sub(friction);
        let motion = self.slide(x, pushed, velocity);
        let goes_on = if forward {
            motion.velocity >= Accumulator::ZERO
        } else {
            motion.velocity <= Accumulator::ZERO
        };
        if goes_on {
            let phase = FixedPhase {
                direction: directed(Word::ONE, forward),
                moving: Word::ONE,
            };
            (motion, phase)
        } else {
            let beyond = drive.saturating_add(friction);
            self.through_zero(x, pushed, beyond, velocity, forward)
        }
    }

    /// The sample in which the velocity passes through zero, at τ = r (1 + xr/2 + (xr)²/3 + …) with
    /// r = −v/A.
    #[cold]
    fn through_zero(
        &self,
        x: Word,
        pushed: Accumulator,
        beyond: Accumulator,
        velocity: Accumulator,
        forward: bool,
    ) -> (FixedMotion, FixedPhase) {
        let Scales {
            velocity: of_velocity,
            acceleration: of_acceleration,
            rate,
            ..
        } = self.scales;
        let acceleration = self.acceleration(x, pushed, velocity);
        let speed = narrow(shifted(velocity, of_velocity - of_acceleration)).abs();
        let r = quotient(speed, acceleration.abs().max(Word::DELTA));
        let xr = narrow(shifted(product(x, r), rate));
        let [half, third, quarter] = self.parts;
        let series = [third, half].into_iter().fold(quarter, |sum, part| {
            part.saturating_add(word_product(sum, xr))
        });
        let exact = r.saturating_add(narrow(product(word_product(series, xr), r)));
        let part = between(exact, Word::ZERO, Word::ONE);
        let before = self.partial_response(x, part);
        let way = self.plus(product(narrow(velocity), part), before.way, acceleration);
        let turns = if forward {
            beyond < Accumulator::ZERO
        } else {
            beyond > Accumulator::ZERO
        };
        if !turns {
            let stopped = FixedMotion {
                increment: way,
                velocity: Accumulator::ZERO,
            };
            let phase = FixedPhase {
                direction: directed(part, forward),
                moving: part,
            };
            return (stopped, phase);
        }
        let after = self.partial_response(x, Word::ONE - part);
        let beyond = narrow(beyond);
        let turned = FixedMotion {
            increment: self.plus(way, after.way, beyond),
            velocity: self.plus(Accumulator::ZERO, after.velocity, beyond),
        };
        let phase = FixedPhase {
            direction: directed(part - (Word::ONE - part), forward),
            moving: Word::ONE,
        };
        (turned, phase)
    }

    /// w − x v, a word of the acceleration's full scale.
    #[inline]
    fn acceleration(&self, x: Word, drive: Accumulator, velocity: Accumulator) -> Word {
        let Scales {
            velocity: of_velocity,
            acceleration,
            rate,
            ..
        } = self.scales;
        let damping = shifted(
            product(x, narrow(velocity)),
            rate + of_velocity - acceleration,
        );
        narrow(drive.saturating_sub(damping))
    }

    /// start + response · acceleration, of the velocity's full scale and within it.
    #[inline]
    fn plus(&self, start: Accumulator, response: Word, acceleration: Word) -> Accumulator {
        let left = self.scales.acceleration - self.scales.velocity;
        let one = wide(Word::ONE);
        let moved = start.saturating_add(shifted(product(response, acceleration), left));
        between(moved, -one, one)
    }

    /// h₂ = ½ − x/6 + x²/24 − … and h₁ = 1 − x h₂.
    #[inline]
    fn response(&self, x: Word) -> Response {
        let rate = self.scales.rate;
        let [head @ .., last] = self.series;
        let way = head.iter().rev().fold(last, |sum, &coefficient| {
            coefficient + narrow(shifted(product(sum, x), rate))
        });
        Response {
            way,
            velocity: Word::ONE - narrow(shifted(product(x, way), rate)),
        }
    }

    #[inline]
    fn partial_response(&self, x: Word, part: Word) -> Response {
        let Response { way, velocity } = self.response(word_product(x, part));
        Response {
            way: narrow(product(word_product(way, part), part)),
            velocity: word_product(velocity, part),
        }
    }
}

#[inline]
fn directed(x: Word, forward: bool) -> Word {
    if forward { x } else { -x }
}
