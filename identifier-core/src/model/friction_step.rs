use super::{Motion, Response, ZeroOrderHoldStep};
use crate::constants::{Encode, encode};
use crate::number::Arithmetic;

/// The exact step of q̈ = −a q̇ + w − c sign(q̇): Coulomb friction that stops and breaks away.
///
/// Karnopp's model without its dead zone (Karnopp, "Computer simulation of stick-slip friction in mechanical dynamic
/// systems", Journal of Dynamic Systems, Measurement, and Control 107(1), 1985). The drive is held within a sample. So
/// a crossing of zero velocity has a closed form, and nothing needs to be smoothed. At rest the servo stays while |w| ≤
/// c. A drive only changes at a sample, so the servo can only break away there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionStep<N> {
    /// The step between events.
    pub(crate) step: ZeroOrderHoldStep<N>,
    halves: [N; 3],
}

encode! {
    [N: Encode] FrictionStep<N> as "FrictionStep" { step, halves }
}

/// The phase of friction during a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrictionPhase<N> {
    /// It moves throughout, in one direction (±1).
    Moving {
        /// The direction.
        direction: N,
    },
    /// Stood still throughout.
    Stuck,
    /// Came to rest after a part of the sample, and stayed.
    Stopped {
        /// The direction before.
        direction: N,
        /// The part of the sample, 0 to 1.
        part: N,
    },
    /// Turned round after a part of the sample.
    Turned {
        /// The direction before.
        direction: N,
        /// The part of the sample, 0 to 1.
        part: N,
        /// The acceleration after the turn over that before it, 0 to 1.
        slowing: N,
    },
}

impl<N: Arithmetic> FrictionPhase<N> {
    /// The mean of sign(q̇) over the sample.
    #[inline]
    pub(crate) fn mean_direction(&self) -> N {
        match *self {
            Self::Moving { direction } => direction,
            Self::Stuck => N::ZERO,
            Self::Stopped { direction, part } => direction.part(part),
            Self::Turned {
                direction, part, ..
            } => direction.part(part + part - N::ONE),
        }
    }

    /// The part of the sample in which it moved.
    #[inline]
    #[must_use]
    pub fn moving_part(&self) -> N {
        match *self {
            Self::Moving { .. } | Self::Turned { .. } => N::ONE,
            Self::Stuck => N::ZERO,
            Self::Stopped { part, .. } => part,
        }
    }
}

impl<N: Arithmetic> FrictionStep<N> {
    /// The largest |a T| that it is meant for.
    pub const LARGEST_RATE: f64 = ZeroOrderHoldStep::<N>::LARGEST_RATE;

    /// The step; it has no parameter.
    #[must_use]
    pub fn new() -> Self {
        Self {
            step: ZeroOrderHoldStep::new(),
            halves: [1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0].map(|part| N::signal(part, 0)),
        }
    }

    /// Moves one sample from `velocity` under the held acceleration `drive`. x is a T, and the friction is `coulomb` ≥
    /// 0.
    #[inline(always)]
    pub fn process(
        &self,
        x: N::Factor,
        drive: N,
        coulomb: N,
        velocity: N::Fine,
    ) -> (Motion<N>, FrictionPhase<N>) {
        self.process_with(&self.step.response(x), x, drive, coulomb, velocity)
    }

    /// [`FrictionStep::process`] with the response over a whole sample, [`ZeroOrderHoldStep::response`] of x,
    /// that is kept while x does not change.
    #[inline(always)]
    pub(crate) fn process_with(
        &self,
        response: &Response<N>,
        x: N::Factor,
        drive: N,
        coulomb: N,
        velocity: N::Fine,
    ) -> (Motion<N>, FrictionPhase<N>) {
        let now = N::of_fine(velocity);
        let forward = if now > N::ZERO {
            true
        } else if now < N::ZERO {
            false
        } else if drive > coulomb {
            true
        } else if drive < -coulomb {
            false
        } else {
            return (Motion::none(), FrictionPhase::Stuck);
        };
        let friction = coulomb.directed(forward);
        let motion = response.motion(x, drive - friction, velocity);
        if N::of_fine(motion.velocity).directed(forward) >= N::ZERO {
            let direction = N::ONE.directed(forward);
            (motion, FrictionPhase::Moving { direction })
        } else {
            self.through_zero(x, drive, friction, now, forward)
        }
    }

    /// The sample in which the velocity passes through zero.
    ///
    /// v + h₁ τ A = 0 is (1 − e^(−xτ))/x = −v/A =: r. So τ = −ln(1 − x r)/x = r (1 + xr/2 + (xr)²/3 + …).
    #[cold]
    fn through_zero(
        &self,
        x: N::Factor,
        drive: N,
        friction: N,
        velocity: N,
        forward: bool,
    ) -> (Motion<N>, FrictionPhase<N>) {
        let pushed = drive - friction;
        let acceleration = pushed - velocity.by(x);
        let r = velocity.magnitude().quotient(acceleration.magnitude());
        let xr = r.by(x);
        let [half, third, quarter] = self.halves;
        let series = half + xr.part(third + xr.part(quarter));
        let part = r.part(N::ONE + xr.part(series)).bounded(N::ZERO, N::ONE);
        let before = self.step.partial_response(x, part);
        let displacement = velocity.part(part) + before.displacement(acceleration);

        let beyond = drive + friction;
        let direction = N::ONE.directed(forward);
        if beyond.directed(forward) >= N::ZERO {
            let stopped = Motion {
                increment: displacement,
                velocity: N::ZERO.fine(),
            };
            return (stopped, FrictionPhase::Stopped { direction, part });
        }
        let after = self.step.partial_response(x, N::ONE - part);
        let turned = Motion {
            increment: displacement + after.displacement(beyond),
            velocity: after.velocity.part(beyond).fine(),
        };
        let slowing = beyond.magnitude().quotient(pushed.magnitude());
        (
            turned,
            FrictionPhase::Turned {
                direction,
                part,
                slowing,
            },
        )
    }
}

impl<N: Arithmetic> Default for FrictionStep<N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The same motion in ten thousand forward steps that stop at zero.
    fn in_small_steps(x: f64, drive: f64, coulomb: f64, mut velocity: f64) -> Motion<f64> {
        const STEPS: u32 = 10_000;
        let dt = 1.0 / f64::from(STEPS);
        let mut increment = 0.0;
        for _ in 0..STEPS {
            let direction = if velocity != 0.0 {
                velocity.signum()
            } else if drive.abs() > coulomb {
                drive.signum()
            } else {
                break;
            };
            let middle = velocity + 0.5 * dt * (drive - coulomb * direction - x * velocity);
            let next = velocity + dt * (drive - coulomb * direction - x * middle);
            if next * direction < 0.0 {
                increment += 0.5 * dt * velocity;
                velocity = 0.0;
            } else {
                increment += 0.5 * dt * (velocity + next);
                velocity = next;
            }
        }
        Motion {
            increment,
            velocity,
        }
    }

    proptest! {
        #[test]
        fn agrees_with_small_steps_through_every_event(
            x in 0.0_f64..0.2,
            drive in -2.0_f64..2.0,
            coulomb in 0.0_f64..1.5,
            velocity in prop_oneof![Just(0.0), -1.0_f64..1.0],
        ) {
            let (motion, phase) = FrictionStep::<f64>::new().process(x, drive, coulomb, velocity);
            let small = in_small_steps(x, drive, coulomb, velocity);
            prop_assert!((motion.increment - small.increment).abs() < 2e-4, "{phase:?}");
            prop_assert!((motion.velocity - small.velocity).abs() < 1e-3, "{phase:?} {motion:?} {small:?}");
        }

        #[test]
        fn without_friction_it_is_the_plain_step(
            x in 0.0_f64..0.2,
            drive in -2.0_f64..2.0,
            velocity in -1.0_f64..1.0,
        ) {
            let (motion, _) = FrictionStep::<f64>::new().process(x, drive, 0.0, velocity);
            let plain = ZeroOrderHoldStep::<f64>::new().process(x, drive, velocity);
            // The remainder of the crossing's series, (x r)⁴/5.
            let left_out = x * x * x * x + 1e-9;
            prop_assert!((motion.increment - plain.increment).abs() < left_out);
            prop_assert!((motion.velocity - plain.velocity).abs() < left_out);
        }
    }

    #[test]
    fn it_sticks_until_the_drive_exceeds_friction() {
        let step = FrictionStep::<f32>::new();
        assert_eq!(
            step.process(0.01, 0.9, 1.0, 0.0),
            (Motion::none(), FrictionPhase::Stuck)
        );
        let (motion, phase) = step.process(0.01, 1.1, 1.0, 0.0);
        assert!(motion.velocity > 0.0);
        assert_eq!(phase, FrictionPhase::Moving { direction: 1.0 });
    }
}
