//! The equation of motion, while a command is held.

use crate::friction::Friction;

/// Position and velocity of the motor, and twist and twist rate of the spring, by which the load leads
/// it: rad, rad/s, rad, rad/s. Without a spring the last two stay zero.
pub(crate) type State = [f64; 4];

/// The mode of friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// It holds the motor.
    Standing,
    /// It brakes the motor, which moves in a direction: ±1, or 0 where no friction knows directions.
    Moving(f64),
}

/// The acting command, target + excess e^(−rate t), t being the time for which the target is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Acting {
    pub(crate) target: f64,
    pub(crate) excess: f64,
    /// 1/s.
    pub(crate) rate: f64,
}

impl Acting {
    /// Command units.
    pub(crate) fn at(&self, time: f64) -> f64 {
        if self.excess == 0.0 {
            return self.target;
        }
        self.target + self.excess * libm::exp(-self.rate * time)
    }
}

/// An acceleration s sin Nq + c cos Nq.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Angular {
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
    pub(crate) order: f64,
}

impl Angular {
    /// Rad/s².
    pub(crate) fn at(&self, angle: f64) -> f64 {
        if self.sine == 0.0 && self.cosine == 0.0 {
            return 0.0;
        }
        let (sin, cos) = libm::sincos(self.order * angle);
        self.sine * sin + self.cosine * cos
    }
}

/// The spring between motor and load. Of both as one rigid body of inertia 1, the load is a share ρ:
/// with ω the resonance of both free and ζ its damping, stiffness is ω² ρ (1 − ρ) and damping
/// 2 ζ ω ρ (1 − ρ).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spring {
    stiffness: f64,
    damping: f64,
    load_share: f64,
}

impl Spring {
    /// From a resonance (rad/s), its damping ratio and the load's share of the inertia.
    pub(crate) fn new(resonance: f64, damping: f64, load_share: f64) -> Self {
        let reduced = load_share * (1.0 - load_share);
        Self {
            stiffness: resonance * resonance * reduced,
            damping: 2.0 * damping * resonance * reduced,
            load_share,
        }
    }
}

/// The accelerations of the servo, rad/s² of the whole inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Equation {
    /// b.
    pub(crate) gain: f64,
    pub(crate) acting: Acting,
    pub(crate) load: f64,
    pub(crate) friction: Friction,
    pub(crate) gravity: Angular,
    pub(crate) ripple: Angular,
    pub(crate) spring: Option<Spring>,
}

impl Equation {
    /// Acceleration of the motor without friction, and of the load.
    fn pushes(&self, time: f64, &[position, _, twist, twist_rate]: &State) -> (f64, f64) {
        let motor = self.gain * self.acting.at(time) + self.ripple.at(position);
        let load = self.load + self.gravity.at(position + twist);
        match &self.spring {
            None => (motor + load, 0.0),
            Some(spring) => {
                let force = spring.stiffness * twist + spring.damping * twist_rate;
                (motor + force, load - force)
            }
        }
    }

    /// The derivative of the state.
    pub(crate) fn rates(&self, mode: Mode, time: f64, state: &State) -> State {
        let &[_, velocity, _, twist_rate] = state;
        let (motor, load) = self.pushes(time, state);
        let (velocity, pushed) = match mode {
            Mode::Standing => (0.0, 0.0),
            Mode::Moving(direction) => {
                let brake = self.friction.deceleration(velocity, direction);
                (velocity, motor - brake)
            }
        };
        match &self.spring {
            None => [velocity, pushed, 0.0, 0.0],
            Some(spring) => {
                let motor = pushed / (1.0 - spring.load_share);
                [
                    velocity,
                    motor,
                    twist_rate,
                    load / spring.load_share - motor,
                ]
            }
        }
    }

    /// The mode of friction in a state.
    pub(crate) fn mode(&self, time: f64, state: &State) -> Mode {
        let velocity = state[1];
        if !self.friction.has_directions() {
            return Mode::Moving(0.0);
        }
        if velocity != 0.0 {
            return Mode::Moving(velocity.signum());
        }
        let (push, _) = self.pushes(time, state);
        if push.abs() > self.friction.breakaway() {
            Mode::Moving(push.signum())
        } else {
            Mode::Standing
        }
    }

    /// Distance from a change of the mode: negative once it is due.
    pub(crate) fn margin(&self, mode: Mode, time: f64, state: &State) -> f64 {
        match mode {
            Mode::Standing => self.friction.breakaway() - self.pushes(time, state).0.abs(),
            Mode::Moving(direction) => direction * state[1],
        }
    }
}
