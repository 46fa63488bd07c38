//! The equation of motion, while a command is held.

use crate::friction::Friction;

/// Position and velocity of the motor, and twist and twist rate of the spring, by which the load leads it. The units
/// are rad, rad/s, rad, rad/s. Without a spring the last two stay zero.
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

/// A function s sin Nq + c cos Nq of the angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Angular {
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
    pub(crate) order: f64,
}

impl Angular {
    /// From [s, c] and the order N.
    pub(crate) fn new([sine, cosine]: [f64; 2], order: u32) -> Self {
        Self {
            sine,
            cosine,
            order: f64::from(order),
        }
    }

    /// Its value, in the unit of s and c.
    pub(crate) fn at(&self, angle: f64) -> f64 {
        if self.is_zero() {
            return 0.0;
        }
        let (sin, cos) = libm::sincos(self.order * angle);
        self.sine * sin + self.cosine * cos
    }

    /// Its derivative by the angle.
    fn slope_at(&self, angle: f64) -> f64 {
        let (sin, cos) = libm::sincos(self.order * angle);
        self.order * (self.sine * cos - self.cosine * sin)
    }

    fn is_zero(&self) -> bool {
        self.sine == 0.0 && self.cosine == 0.0
    }
}

/// The spring between motor and load. The load is a share ρ of both as one rigid body of inertia 1. With ω the
/// resonance of both free and ζ its damping, stiffness is ω² ρ (1 − ρ) and damping 2 ζ ω ρ (1 − ρ). Within its backlash
/// neither side feels the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spring {
    stiffness: f64,
    damping: f64,
    load_share: f64,
    /// Half of the twist without force, rad.
    half_backlash: f64,
}

impl Spring {
    /// From a resonance (rad/s), its damping ratio, the load's share of the inertia and the backlash from end to end,
    /// rad.
    pub(crate) fn new(resonance: f64, damping: f64, load_share: f64, backlash: f64) -> Self {
        let reduced = load_share * (1.0 - load_share);
        Self {
            stiffness: resonance * resonance * reduced,
            damping: 2.0 * damping * resonance * reduced,
            load_share,
            half_backlash: 0.5 * backlash,
        }
    }

    /// The acceleration of the whole inertia by which it takes the motor along, rad/s².
    fn force(&self, twist: f64, twist_rate: f64) -> f64 {
        let beyond = twist - twist.clamp(-self.half_backlash, self.half_backlash);
        let force = self.stiffness * beyond + self.damping * twist_rate;
        // Flanks that part do not pull.
        if self.half_backlash > 0.0 && force * beyond <= 0.0 {
            return 0.0;
        }
        force
    }
}

/// The accelerations of the servo, rad/s² of the whole inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Equation {
    /// b.
    pub(crate) gain: f64,
    /// Half of what it has more for positive commands, as a share.
    pub(crate) gain_asymmetry: f64,
    /// Its deviation from the mean at an angle, as a share.
    pub(crate) torque_ripple: Angular,
    pub(crate) acting: Acting,
    pub(crate) load: f64,
    pub(crate) friction: Friction,
    pub(crate) gravity: Angular,
    pub(crate) ripple: Angular,
    /// The deviation of the inertia from its mean at an angle, as a share. With a spring it is the load's.
    pub(crate) inertia: Angular,
    pub(crate) spring: Option<Spring>,
}

impl Equation {
    /// Acceleration by the command, b u.
    fn drive(&self, time: f64, position: f64) -> f64 {
        let command = self.acting.at(time);
        let mut gain = self.gain * (1.0 + self.torque_ripple.at(position));
        if self.gain_asymmetry != 0.0 {
            gain *= 1.0 + self.gain_asymmetry * command.signum();
        }
        gain * command
    }

    /// Acceleration of the motor without friction, by its drive, and of the load.
    fn pushes(&self, drive: f64, &[position, _, twist, twist_rate]: &State) -> (f64, f64) {
        let motor = drive + self.ripple.at(position);
        let load = self.load + self.gravity.at(position + twist);
        match &self.spring {
            None => (motor + load, 0.0),
            Some(spring) => {
                let force = spring.force(twist, twist_rate);
                (motor + force, load - force)
            }
        }
    }

    /// The derivative of the state.
    pub(crate) fn rates(&self, mode: Mode, time: f64, state: &State) -> State {
        let &[_, velocity, _, twist_rate] = state;
        let drive = self.drive(time, state[0]);
        let (motor, load) = self.pushes(drive, state);
        let (velocity, pushed) = match mode {
            Mode::Standing => (0.0, 0.0),
            Mode::Moving(direction) => {
                let brake = self.friction.deceleration(velocity, direction, drive);
                (velocity, motor - brake)
            }
        };
        let &[position, _, twist, _] = state;
        match &self.spring {
            None => {
                let acceleration = self.with_inertia_at(position, velocity, pushed);
                [velocity, acceleration, 0.0, 0.0]
            }
            Some(spring) => {
                let motor = pushed / (1.0 - spring.load_share);
                let of_mean = load / spring.load_share;
                let load = self.with_inertia_at(position + twist, velocity + twist_rate, of_mean);
                [velocity, motor, twist_rate, load - motor]
            }
        }
    }

    /// The acceleration of a body whose inertia depends on its angle, from that of its mean inertia. With J = 1 + j, J
    /// q̈ + j′ q̇²/2 = w (Lagrange).
    fn with_inertia_at(&self, angle: f64, velocity: f64, of_mean: f64) -> f64 {
        if self.inertia.is_zero() {
            return of_mean;
        }
        let centrifugal = 0.5 * self.inertia.slope_at(angle) * velocity * velocity;
        (of_mean - centrifugal) / (1.0 + self.inertia.at(angle))
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
        if self.hold_margin(time, state) < 0.0 {
            let (push, _) = self.pushes(self.drive(time, state[0]), state);
            Mode::Moving(push.signum())
        } else {
            Mode::Standing
        }
    }

    /// Distance from a change of the mode; negative once the mode must change.
    pub(crate) fn margin(&self, mode: Mode, time: f64, state: &State) -> f64 {
        match mode {
            Mode::Standing => self.hold_margin(time, state),
            Mode::Moving(direction) => direction * state[1],
        }
    }

    /// The acceleration that friction could hold in addition, at rest, rad/s²: negative once the motor breaks away.
    fn hold_margin(&self, time: f64, state: &State) -> f64 {
        let drive = self.drive(time, state[0]);
        let (push, _) = self.pushes(drive, state);
        self.friction.breakaway(drive) - push.abs()
    }
}
