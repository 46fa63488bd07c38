//! Controllers as users have them: none, PID, cascade, relay; in SI, and apart from the core's.

/// The structure and gains of a controller, which takes the position and gives the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Controller {
    /// None: the reference is the command.
    Open,
    /// u = kp e + ki ∫e − kd v.
    Pid {
        /// Proportional gain, 1/rad of the limit's unit.
        kp: f64,
        /// Integral gain, 1/s.
        ki: f64,
        /// Damping, s.
        kd: f64,
    },
    /// A position loop around a velocity loop: u = kp (kv e − v) + ki ∫(kv e − v).
    Cascade {
        /// Gain of the position loop, 1/s.
        kv: f64,
        /// Proportional gain of the velocity loop.
        kp: f64,
        /// Its integral gain.
        ki: f64,
    },
    /// u = ±level by the sign of e − τ v, with hysteresis; the level changes with time.
    Relay {
        /// The levels, in turn.
        levels: [f64; 2],
        /// Time for which a level holds, s.
        hold: f64,
        /// Half of the hysteresis, rad.
        hysteresis: f64,
        /// τ, s.
        lead: f64,
    },
}

/// A controller at work.
#[derive(Debug, Clone, Copy)]
pub(super) struct ControlLoop {
    controller: Controller,
    sample_time: f64,
    limit: f64,
    /// Share of a new difference in the filtered velocity.
    fresh: f64,
    velocity: f64,
    last_position: f64,
    integral: f64,
    sign: f64,
    time: f64,
}

impl ControlLoop {
    /// At rest at a position (rad) with an initial command; its velocity is a low-pass derivative with a cut-off,
    /// rad/s.
    pub(super) fn at_rest(
        controller: Controller,
        cutoff: f64,
        limit: f64,
        sample_time: f64,
        (position, command): (f64, f64),
    ) -> Self {
        Self {
            controller,
            sample_time,
            limit,
            fresh: -(-cutoff * sample_time).exp_m1(),
            velocity: 0.0,
            last_position: position,
            integral: command,
            sign: 1.0,
            time: 0.0,
        }
    }

    /// The command of a sample, from reference and position, rad.
    pub(super) fn process(&mut self, reference: f64, position: f64) -> f64 {
        let difference = (position - self.last_position) / self.sample_time;
        self.velocity += self.fresh * (difference - self.velocity);
        self.last_position = position;
        self.time += self.sample_time;
        let (error, velocity) = (reference - position, self.velocity);
        match self.controller {
            Controller::Open => reference.clamp(-self.limit, self.limit),
            Controller::Pid { kp, ki, kd } => {
                self.integrate(kp * error - kd * velocity, ki * error)
            }
            Controller::Cascade { kv, kp, ki } => {
                let error = kv * error - velocity;
                self.integrate(kp * error, ki * error)
            }
            Controller::Relay {
                levels,
                hold,
                hysteresis,
                lead,
            } => {
                let switching = error - lead * velocity;
                if switching.abs() > hysteresis {
                    self.sign = switching.signum();
                }
                let turn = (self.time / hold) as usize % levels.len();
                self.sign * levels[turn].min(self.limit)
            }
        }
    }

    /// The sum of a direct part and the integral of a rate, at most the limit; beyond it the integral rests.
    fn integrate(&mut self, direct: f64, rate: f64) -> f64 {
        let next = self.integral + rate * self.sample_time;
        let command = direct + next;
        let limited = command.clamp(-self.limit, self.limit);
        if command - limited == 0.0 || rate * command < 0.0 {
            self.integral = next;
        }
        limited
    }
}
