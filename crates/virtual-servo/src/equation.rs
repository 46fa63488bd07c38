//! The equation of motion, while a command is held.

use crate::effects::Effects;
use crate::friction::Friction;

/// Position and velocity of the motor, and twist and twist rate of the spring, by which the load leads it. The units
/// are rad, rad/s, rad, rad/s. Without a spring the last two stay zero.
pub(crate) type State = [f64; 4];

/// The mode of friction on a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mode {
    /// It holds the body.
    Standing,
    /// It brakes the body, which moves in a direction: ±1, or 0 where no friction knows directions.
    Moving(f64),
}

impl Mode {
    /// For a velocity, under a push against which friction could hold `breakaway`.
    fn of(velocity: f64, push: f64, breakaway: f64) -> Self {
        if velocity != 0.0 {
            Self::Moving(velocity.signum())
        } else if push.abs() > breakaway {
            Self::Moving(push.signum())
        } else {
            Self::Standing
        }
    }

    /// Distance from a change of the mode; negative once it must change.
    fn margin(self, velocity: f64, push: f64, breakaway: f64) -> f64 {
        match self {
            Self::Standing => breakaway - push.abs(),
            Self::Moving(direction) => direction * velocity,
        }
    }
}

/// The modes of friction on motor and load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Modes {
    motor: Mode,
    load: Mode,
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
    /// Coulomb friction of the load, rad/s² of the whole inertia.
    friction: f64,
}

impl Spring {
    /// From effects with a resonance.
    pub(crate) fn new(effects: &Effects) -> Self {
        let (resonance, load_share) = (effects.resonance, effects.inertia_ratio);
        let damping = effects.resonance_damping;
        let damping = damping.unwrap_or(Effects::RESONANCE_DAMPING);
        let reduced = load_share * (1.0 - load_share);
        Self {
            stiffness: resonance * resonance * reduced,
            damping: 2.0 * damping * resonance * reduced,
            load_share,
            half_backlash: 0.5 * effects.backlash,
            friction: effects.load_friction,
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
    pub(crate) ripples: [Angular; Effects::FURTHER_RIPPLES],
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
        let further: f64 = self.ripples.iter().map(|wave| wave.at(position)).sum();
        let motor = drive + self.ripple.at(position) + further;
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
    pub(crate) fn rates(&self, modes: Modes, time: f64, state: &State) -> State {
        let &[_, velocity, _, twist_rate] = state;
        let drive = self.drive(time, state[0]);
        let (motor, load) = self.pushes(drive, state);
        let (velocity, pushed) = match modes.motor {
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
                let load = match modes.load {
                    Mode::Standing => 0.0,
                    Mode::Moving(direction) => {
                        let of_mean = (load - direction * spring.friction) / spring.load_share;
                        self.with_inertia_at(position + twist, velocity + twist_rate, of_mean)
                    }
                };
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

    /// The modes of friction in a state.
    pub(crate) fn modes(&self, time: f64, state: &State) -> Modes {
        let drive = self.drive(time, state[0]);
        let (motor, load) = self.pushes(drive, state);
        Modes {
            motor: if self.friction.has_directions() {
                Mode::of(state[1], motor, self.friction.breakaway(drive))
            } else {
                Mode::Moving(0.0)
            },
            load: match self.load_friction() {
                Some(friction) => Mode::of(state[1] + state[3], load, friction),
                None => Mode::Moving(0.0),
            },
        }
    }

    /// Distance of motor and load from a change of their modes; negative once a mode must change.
    pub(crate) fn margins(&self, modes: Modes, time: f64, state: &State) -> [f64; 2] {
        let drive = self.drive(time, state[0]);
        let (motor, load) = self.pushes(drive, state);
        let friction = self.load_friction().unwrap_or(0.0);
        [
            modes
                .motor
                .margin(state[1], motor, self.friction.breakaway(drive)),
            modes.load.margin(state[1] + state[3], load, friction),
        ]
    }

    /// Ends the motion of a body whose mode must change.
    pub(crate) fn stop(&self, modes: Modes, time: f64, state: &mut State) {
        let [motor, load] = self.margins(modes, time, state);
        let load_velocity = state[1] + state[3];
        if motor < 0.0 && modes.motor != Mode::Standing {
            state[1] = 0.0;
        }
        let stops = load < 0.0 || modes.load == Mode::Standing;
        state[3] = if stops && self.load_friction().is_some() {
            -state[1]
        } else {
            load_velocity - state[1]
        };
    }

    fn load_friction(&self) -> Option<f64> {
        let friction = self.spring?.friction;
        (friction > 0.0).then_some(friction)
    }
}
