use super::frequency_response::FrictionBalance;
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;

/// The model that a probing motion builds on its way: enough to brake the servo, not more. Counts and samples. By
/// default it is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct RoughModel<N> {
    /// b, counts per sample² and command unit; zero before the first estimate.
    pub gain: N,
    /// 1/b; zero before the first estimate.
    pub per_gain: N,
    /// d − c, the acceleration without a command in forward motion, counts per sample².
    pub forward: N,
    /// d + c, the same backwards.
    pub backward: N,
    /// a, 1/sample.
    pub viscous: N,
}

/// The command at which a servo broke away, and the direction in which it did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Breakaway<N> {
    pub command: N,
    pub is_forward: bool,
    /// The farthest command of standstill in the other direction, if growing commands were needed to move it there.
    pub other: Option<N>,
}

impl<N: Number> Breakaway<N> {
    pub(crate) fn to_f64(self) -> Breakaway<f64> {
        Breakaway {
            command: self.command.to_f64(),
            is_forward: self.is_forward,
            other: self.other.map(N::to_f64),
        }
    }

    /// The largest friction at rest with which a servo breaks away there, rad/s², and may have been at standstill.
    pub(crate) fn friction(&self, servo: &ServoParameters) -> f64 {
        let direction = if self.is_forward { 1.0 } else { -1.0 };
        let push = |command: N| servo.b * command.to_f64() + servo.load;
        let other = self.other.map_or(0.0, |other| -direction * push(other));
        (direction * push(self.command)).max(other)
    }

    /// It is at standstill under a command that grows in a direction.
    pub(crate) fn stand(&mut self, command: N, direction: N) {
        let is_other = self.is_forward != (direction > N::ZERO);
        let is_farther = |other| direction * (command - other) > N::ZERO;
        if is_other && self.other.is_none_or(is_farther) {
            self.other = Some(command);
        }
    }
}

impl<N: Number> RoughModel<N> {
    /// From SI parameters, for a sample time (s) and a resolution (rad).
    #[must_use]
    pub(crate) fn from_si(parameters: &ServoParameters, time: f64, resolution: f64) -> Self {
        let acceleration = time * time / resolution;
        let number = |value: f64| N::from_f64(value * acceleration);
        let gain = number(parameters.b.max(f64::MIN_POSITIVE));
        Self {
            gain,
            per_gain: N::from_f64(1.0 / gain.to_f64()),
            forward: number(parameters.load - parameters.coulomb),
            backward: number(parameters.load + parameters.coulomb),
            viscous: N::from_f64(parameters.a * time),
        }
    }

    /// The parameters in SI; none before the first estimate.
    #[must_use]
    pub(crate) fn to_si(self, time: f64, resolution: f64) -> Option<ServoParameters> {
        let acceleration = resolution / (time * time);
        let si = |value: N| value.to_f64() * acceleration;
        self.is_known().then(|| {
            ServoParameters::new(
                self.viscous.to_f64() / time,
                si(self.gain),
                si(self.coulomb()),
                si(self.load()),
            )
        })
    }

    /// True if there is an estimate.
    #[must_use]
    pub(crate) fn is_known(&self) -> bool {
        self.gain > N::ZERO
    }

    /// True if its gain is at most five times another, and at least a fifth.
    pub(crate) fn is_like(&self, gain: N) -> bool {
        let five = N::from_f64(5.0);
        self.gain < five * gain && gain < five * self.gain
    }

    /// d − c sign, in a direction of motion.
    pub(crate) fn without_command(&self, direction: N) -> N {
        if direction > N::ZERO {
            self.forward
        } else {
            self.backward
        }
    }

    /// Confines friction and load to those that commands of up to `most` overcome. For a known break-away, its command
    /// is the bound. A servo that moves barely needs more. Those commands do not bound the friction from below. They
    /// show friction at rest, and a motor in its backlash is at standstill by the encoder. The motion of a load that
    /// oscillates on a spring would give arbitrary values.
    pub(crate) fn confine(&mut self, seen: &Breakaway<N>, most: N) {
        /// The part of the command by which a motion may need more.
        const SLACK: f64 = 0.1;
        let slack = N::from_f64(SLACK) * most;
        let own = Some(seen.command);
        let (low, high) = if seen.is_forward {
            (seen.other, own)
        } else {
            (own, seen.other)
        };
        let without = |command| -(self.gain * command);
        let least = without(high.map_or(most, |high| high + slack));
        let largest = without(low.map_or(-most, |low| low - slack));
        self.forward = self.forward.limited(least, largest);
        self.backward = self.backward.limited(least, largest);
    }

    /// d, counts per sample².
    #[must_use]
    pub(crate) fn load(&self) -> N {
        N::from_f64(0.5) * (self.forward + self.backward)
    }

    /// c, counts per sample².
    #[must_use]
    pub(crate) fn coulomb(&self) -> N {
        N::from_f64(0.5) * (self.backward - self.forward)
    }

    /// The command that balances the load.
    #[must_use]
    pub(crate) fn holding(&self) -> N {
        -(self.load() * self.per_gain)
    }

    /// Bears a load that this command balances.
    pub(crate) fn set_holding_command(&mut self, holding: N) {
        let change = self.gain * (self.holding() - holding);
        self.forward += change;
        self.backward += change;
    }

    /// The acceleration under a command that acts.
    #[inline]
    pub(crate) fn acceleration(&self, command: N, velocity: N) -> N {
        if velocity == N::ZERO {
            let push = self.gain * command + self.load();
            return if push.magnitude() > self.coulomb() {
                self.gain * command + self.without_command(push)
            } else {
                N::ZERO
            };
        }
        self.gain * command + self.without_command(velocity) - self.viscous * velocity
    }

    /// Takes over the friction and load that balance a motion. The result is the change of the command for it.
    pub(crate) fn learn(&mut self, response_motion: &FrictionBalance<N>) -> N {
        let FrictionBalance {
            velocity,
            acceleration,
            command,
        } = *response_motion;
        let without = if velocity > N::ZERO {
            &mut self.forward
        } else {
            &mut self.backward
        };
        let before = *without;
        *without = acceleration + self.viscous * velocity - self.gain * command;
        (before - *without) * self.per_gain
    }

    /// The command that gives an acceleration in a direction of motion.
    #[inline]
    pub(crate) fn command(&self, acceleration: N, direction: N) -> N {
        (acceleration - self.without_command(direction)) * self.per_gain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A servo that broke away forwards at 2 of 10 command units needs neither 8 to continue nor 12 backwards.
    #[test]
    fn friction_is_confined_to_that_which_a_breakaway_shows() {
        let with = |forward, backward| RoughModel {
            gain: 3.0,
            per_gain: 1.0 / 3.0,
            forward,
            backward,
            viscous: 0.0,
        };
        for (motion_direction, found, confined) in [
            (1.0, [-24.0, 36.0], [-9.0, 30.0]),
            (-1.0, [-36.0, 24.0], [-30.0, 9.0]),
            (1.0, [-6.0, 6.0], [-6.0, 6.0]),
        ] {
            let seen = Breakaway {
                command: 2.0 * motion_direction,
                is_forward: motion_direction > 0.0,
                other: None,
            };
            let [forward, backward] = found;
            let mut servo: RoughModel<f64> = with(forward, backward);
            servo.confine(&seen, 10.0);
            let [forward, backward] = confined;
            assert_eq!(servo, with(forward, backward));
        }
    }

    /// b u + d at the break-away, forwards or backwards: the more of both where two commands are known.
    #[test]
    fn friction_at_rest_is_what_the_command_overcomes_with_the_load() {
        let servo = ServoParameters::new(0.0, 50.0, 20.0, -30.0);
        for (command, is_forward, other, expected) in [
            (2.0, true, None, 70.0),
            (-2.0, false, None, 130.0),
            (2.0, true, Some(-1.0), 80.0),
        ] {
            let seen = Breakaway {
                command,
                is_forward,
                other,
            };
            assert!((seen.friction(&servo) - expected).abs() < 1e-12);
        }
    }

    /// A servo that broke away at 2 of 10 command units in one direction. In the other it was at standstill under up to
    /// 3.
    #[test]
    fn friction_both_ways_is_that_of_both_breakaways() {
        for motion_direction in [1.0, -1.0] {
            let mut seen = Breakaway {
                command: 2.0 * motion_direction,
                is_forward: motion_direction > 0.0,
                other: None,
            };
            for command in [-1.0, -3.0, -2.0] {
                seen.stand(command * motion_direction, -motion_direction);
            }
            seen.stand(5.0 * motion_direction, motion_direction);
            // Commands that the motion seems to need that way and the other, and those that are adopted.
            for (found, confined) in [
                // Hardly more than at the break-away.
                ([8.0, -9.0], [3.0, -4.0]),
                // Much less.
                ([0.5, -0.5], [0.5, -0.5]),
            ] {
                let needing = |[own, other]: [f64; 2]| {
                    let [forward, backward] = if motion_direction > 0.0 {
                        [own, other]
                    } else {
                        [-other, -own]
                    };
                    RoughModel {
                        gain: 3.0,
                        per_gain: 1.0 / 3.0,
                        forward: -3.0 * forward,
                        backward: -3.0 * backward,
                        viscous: 0.0,
                    }
                };
                let mut servo = needing(found);
                servo.confine(&seen, 10.0);
                assert_eq!(servo, needing(confined), "{motion_direction} {found:?}");
            }
        }
    }
}
