//! Tests a servo that is at standstill although its command must move it. A command in the opposite direction shows
//! whether it moves at all.
//!
//! A spring, a new load or higher friction may hold a servo without a fault. It then moves in the opposite direction,
//! and the commissioning continues. With a stuck encoder or a dead actuator it moves in neither direction.

use super::RoughModel;
use super::least_motion::MISSED;
use super::noise::EDGE_COUNTS;
use crate::watch::LOW_SPEED;
use identifier_core::number::Number;
use identifier_core::reason::Reason;

/// Limits of the test: when the servo must have moved, and the opposite command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StandingTest<N> {
    /// The command beyond friction that moves a servo, command units.
    least_push: N,
    /// The travel beyond whose ends none is pushed outwards, counts.
    inner: [N; 2],
    /// Samples for which it may be at standstill under that command, and behind a moving reference.
    least: u32,
    behind: u32,
    /// Samples of the push, those before it grows, and the growth of its growth in each, command units.
    push: u32,
    steady: u32,
    growth: N,
}

/// The test under way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Standing<N> {
    /// Position of the standstill, counts, its length, samples, and the command under which it began.
    at: N,
    still: u32,
    under: N,
    /// Since then: speed and distance that the command beyond friction would give by the model, and samples with such
    /// a command.
    velocity: N,
    displacement: N,
    pushed: u32,
    /// Samples behind a moving reference.
    behind: u32,
    /// Samples of the opposite command, that command and its growth,
    tried: u32,
    push: N,
    growth: N,
    /// and samples left until the servo is braked again.
    braking: u32,
}

impl<N: Number> StandingTest<N> {
    /// The part of the command's limit beyond friction that moves a servo.
    const LEAST_PUSH: f64 = 0.05;

    /// The part of the travel beyond which a servo is not pushed outwards.
    const INNER: f64 = 0.85;

    /// The times for which it may be at standstill under such a command, and behind a moving reference, s.
    const LEAST: f64 = 0.015;
    const BEHIND: f64 = 0.1;

    /// The push begins as large as what should move the servo. It stays so for this time, s, and until it should have moved
    /// the servo by twice the counts of a motion.
    const STEADY: f64 = 4e-3;
    /// The time in which it then grows to twice the command's limit, s: slowly at first, as friction may have risen.
    const GROWS: f64 = 0.014;

    /// For a command up to a limit and a travel (counts), at a sample time (s); a command may act this late (samples).
    pub(super) fn new(limit: f64, travel: [f64; 2], sample_time: f64, delay: f64) -> Self {
        /// The fewest samples of each.
        const FEWEST: f64 = 3.0;
        let samples = |time: f64| libm::ceil((time / sample_time).max(FEWEST));
        let [steady, grows] = [Self::STEADY, Self::GROWS].map(samples);
        Self {
            least_push: N::from_f64(Self::LEAST_PUSH * limit),
            inner: travel.map(|end| N::from_f64(Self::INNER * end)),
            least: (samples(Self::LEAST) + delay) as u32,
            behind: (samples(Self::BEHIND) + delay) as u32,
            push: (steady + grows + delay) as u32,
            steady: steady as u32,
            growth: N::from_f64(4.0 * limit / (grows * grows)),
        }
    }

    /// Takes a sample of a servo: its position, the command that acts, and its distance behind a moving reference.
    /// For a servo that is held, the load is unknown. The command then counts relative to the one at which the
    /// standstill began.
    ///
    /// # Errors
    /// It moves in neither direction.
    pub(super) fn take(
        &self,
        state: &mut Standing<N>,
        servo: &RoughModel<N>,
        position: N,
        command: N,
        led_behind: Option<N>,
    ) -> Result<(), Reason> {
        if (position - state.at).magnitude() > N::from_f64(EDGE_COUNTS) {
            let braking = if state.tried > 0 {
                self.push
            } else {
                state.braking
            };
            *state = Standing {
                braking,
                ..Standing::at(position)
            };
        }
        if state.braking > 0 {
            state.braking -= 1;
            return Ok(());
        }
        if state.still < self.least {
            (state.still, state.under) = (state.still + 1, command);
        }
        let range = N::from_f64(LOW_SPEED) * servo.coulomb();
        let (origin, friction, error) = match led_behind {
            Some(error) => (servo.holding(), range, error),
            // From the one edge of its friction to the other.
            None => (state.under, range + range, N::ZERO),
        };
        if state.tried == 0 {
            let force = servo.gain * (command - origin);
            let least = friction + self.least_push * servo.gain;
            let beyond = force.magnitude() - least;
            if beyond > N::ZERO {
                state.velocity += beyond;
                state.displacement += state.velocity;
                state.pushed = state.pushed.saturating_add(1);
            }
            let missed = N::from_f64(MISSED);
            if error.magnitude() > missed {
                state.behind = state.behind.saturating_add(1);
            }
            let is_pushed = state.displacement > missed && state.pushed > self.least;
            if !is_pushed && state.behind < self.behind {
                return Ok(());
            }
            let [low, high] = self.inner;
            let is_outer = if force > N::ZERO {
                position < low
            } else {
                position > high
            };
            if is_outer {
                return Ok(());
            }
            let least = least * servo.per_gain;
            state.push = origin + if force > N::ZERO { -least } else { least };
            (state.velocity, state.displacement) = (N::ZERO, N::ZERO);
        }
        state.velocity += self.least_push * servo.gain;
        state.displacement += state.velocity;
        if state.tried >= self.steady {
            if state.displacement < N::from_f64(2.0 * EDGE_COUNTS) {
                return Ok(());
            }
            let is_up = state.push > origin;
            state.growth += if is_up { self.growth } else { -self.growth };
            state.push += state.growth;
        }
        state.tried += 1;
        if state.tried > self.push {
            return Err(Reason::ActuatorDead);
        }
        Ok(())
    }

    /// True if it moves in neither direction.
    pub(super) fn is_final(&self, state: &Standing<N>) -> bool {
        state.tried > self.push
    }
}

impl<N: Number> Standing<N> {
    /// Nothing moved it yet.
    pub(super) fn at(position: N) -> Self {
        Self {
            at: position,
            ..Self::default()
        }
    }

    /// True while a push acts, and until the servo is braked again.
    pub(super) fn is_at_work(&self) -> bool {
        self.tried > 0 || self.braking > 0
    }

    /// The command of the push, instead of the loop's; none while there is no push.
    pub(super) fn push(&self) -> Option<N> {
        (self.tried > 0).then_some(self.push)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::parameters::ServoParameters;

    const RATES: [f64; 4] = [250.0, 1e3, 4e3, 20e3];
    const LIMIT: f64 = 2.0;
    const RESOLUTION: f64 = 1e-3;
    const B: f64 = 500.0;

    /// A servo with friction of 20 % of the limit and a load of 10 %.
    fn servo(time: f64) -> RoughModel<f64> {
        let truth = ServoParameters::new(1.0, B, 0.2 * LIMIT * B, 0.1 * LIMIT * B);
        RoughModel::from_si(&truth, time, RESOLUTION)
    }

    /// The time, s, at which the test reports no motion in either direction, if within 2 s. `position` gives its
    /// position by time and acting command.
    fn found(
        rate: f64,
        command: f64,
        led_behind: Option<f64>,
        mut position: impl FnMut(f64, f64) -> f64,
    ) -> Option<f64> {
        let time = 1.0 / rate;
        let test = StandingTest::new(LIMIT, [-1e3, 1e3], time, 2.0);
        let mut state = Standing::at(0.0);
        (0..(2.0 * rate) as u32).find_map(|sample| {
            let now = f64::from(sample) * time;
            let acting = state.push().unwrap_or(command).clamp(-LIMIT, LIMIT);
            let position = position(now, acting);
            let taken = test.take(&mut state, &servo(time), position, acting, led_behind);
            (taken == Err(Reason::ActuatorDead)).then(|| {
                assert!(test.is_final(&state));
                now
            })
        })
    }

    #[test]
    fn a_servo_that_moves_neither_way_is_found_in_time() {
        for (rate, command) in RATES
            .iter()
            .flat_map(|&rate| [0.5, -0.7].map(|part| (rate, part)))
        {
            let command = command * LIMIT;
            // Eight samples and a command that is late at the lowest rate.
            let most = 0.05_f64.max(24.0 / rate);
            let pushed = found(rate, command, Some(0.0), |_, _| 0.0);
            assert!(pushed.is_some_and(|time| time < most), "{rate} {pushed:?}");
            // By a command within friction the reference alone tells.
            let led = found(rate, 0.1 * command, Some(50.0), |_, _| 0.0);
            let [least, most] = [0.1, 0.1 + most];
            assert!(
                led.is_some_and(|time| (least..most).contains(&time)),
                "{rate} {led:?}"
            );
        }
    }

    #[test]
    fn a_servo_that_moves_the_other_way_or_need_not_move_goes_on() {
        for rate in RATES {
            for command in [0.5 * LIMIT, -0.7 * LIMIT] {
                // Held in the direction of the command, it moves once it is pushed the other way.
                let mut away = 0.0;
                let held = found(rate, command, Some(50.0), |_, acting| {
                    if acting * command < 0.0 {
                        away -= 1.0_f64.copysign(command) * 2000.0 / rate;
                    }
                    away
                });
                assert_eq!(held, None, "{rate} {command}");
                assert!(away.abs() > 4.0, "{rate}: it was not pushed");
            }
            // Near an end of its travel it is pushed inwards alone.
            for (command, is_pushed) in [(0.5 * LIMIT, true), (-0.7 * LIMIT, false)] {
                let near_end = found(rate, command, Some(50.0), |_, _| 900.0);
                assert_eq!(near_end.is_some(), is_pushed, "{rate} {command}");
            }
            // A held servo may have any load: the command counts from that at the beginning of the standstill.
            assert_eq!(found(rate, 0.9 * LIMIT, None, |_, _| 0.0), None, "{rate}");
            // Friction and a tenth more, with the load.
            for command in [0.25 * LIMIT, -0.44 * LIMIT] {
                assert_eq!(
                    found(rate, command, Some(10.0), |_, _| 0.0),
                    None,
                    "{rate} {command}"
                );
            }
        }
    }
}
