use super::{LineRotations, Lines};
use crate::commission::{CommissionSettings, RoughModel};
use identifier_core::number::{Complex, Number};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::tuning::{AxisForces, Mode};

/// The plan of frequency-response motions of a servo that is identified as one mass, machine units. The solver makes
/// it, the interrupt carries it out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ResponsePlan<N> {
    pub(super) motion: Motion<N>,
    pub(super) lines: [PlannedLine<N>; Lines::MAX],
    pub(super) count: u8,
}

/// The motion beneath the multisine. Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Motion<N> {
    /// The identified servo.
    pub(super) servo: RoughModel<N>,
    /// The forces beside it, in command units.
    pub(super) forces: AxisForces<N>,
    /// Samples from a command to its acceleration.
    pub(super) delay: N,
    /// ω T of the loop that holds it.
    pub(super) bandwidth: N,
    /// The part of it that does once the servo has been learnt.
    pub(super) learnt_bandwidth: N,
    /// Speed and acceleration of the reference.
    pub(super) speed: N,
    pub(super) acceleration: N,
    /// Where the first motion begins.
    pub(super) start: N,
    /// Motions before them that show friction, load and amplitudes alone, and motions that are measured.
    pub(super) learning: u8,
    pub(super) response_motions: u8,
    /// Samples from constant speed to the window, and of the window.
    pub(super) settling: u32,
    pub(super) window: u32,
    /// The window's e^(j2π/n).
    pub(super) window_rotation: [N; 2],
    /// Growth of the injection in a sample, until it is whole.
    pub(super) fade: N,
    /// The error of the loop up to which the servo follows, and samples without that after which the motions are given
    /// up.
    pub(super) max_error: N,
    pub(super) patience: u32,
    /// Amplitude of a line's velocity.
    pub(super) line_speed: N,
}

/// A line of the multisine.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct PlannedLine<N> {
    /// e^(jωT).
    pub(super) rotation: [N; 2],
    /// The largest amplitude of its injection, command units.
    pub(super) amplitude: N,
}

/// A plan that is being made, a line a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ResponsePlanner<N> {
    plan: ResponsePlan<N>,
    lines: Lines,
    rotations: LineRotations,
    /// The next line.
    place: usize,
    mode: Option<Mode>,
    b: f64,
    /// Mean of the frequencies, rad/s.
    mean: f64,
    /// Amplitude of a line's velocity, rad/s, and the largest of its injection at the mean, command units.
    line_speed: f64,
    max_injection: f64,
}

impl<N: Number> ResponsePlanner<N> {
    /// Time from constant speed to the window, s, for an identified and for an uncertain servo. The transient of the
    /// turn has then decayed to a part that the inverted motions cancel.
    const SETTLING: f64 = 0.1;
    const UNCERTAIN_SETTLING: f64 = 2.0 * Self::SETTLING;

    /// Motions, both ways, that teach friction and gain of a servo that its fit does not explain.
    const LEARNING: u8 = 2;

    /// Time in which the injection grows, s.
    const FADE: f64 = 0.03;

    /// The shortest turn, s: not much shorter than the loop follows.
    const SHORTEST_TURN: f64 = 0.03;

    /// The parts of the travel for turning points, for those of an uncertain servo, and for the loop's error. The
    /// rest is the braking distance of a servo that left its reference.
    const TURNS: f64 = 0.8;
    const UNCERTAIN_TURNS: f64 = 0.75;
    const ERROR: f64 = 0.15;

    /// Time by which a servo may break away late, s, and an uncertain one.
    const PATIENCE: f64 = 0.15;
    const UNCERTAIN_PATIENCE: f64 = 1.6;

    /// The part of the largest speed: the injection adds to it.
    const SPEED: f64 = 0.4;

    /// The part of the command that friction and load leave with which the servo turns.
    const TURN: f64 = 0.35;

    /// The part of the speed to which the velocities of the lines may add up, so that the servo does not stop.
    const LINES_SPEED: f64 = 0.7;

    /// The part of the command to which the injections may add up. It is twice that of what friction and load leave.
    const INJECTION: f64 = 0.4;

    /// The largest value of the multisine over its root mean square, with the phases of its lines.
    const CREST: f64 = 3.5;

    /// The largest amplitude over that of one mass: at an antiresonance a larger one would have the load stick.
    const MAX_GROWTH: f64 = 1.5;

    /// The least speed, counts per second: with fewer the lines are lost in the rounding.
    const MIN_SPEED_COUNTS: f64 = 60.0;

    /// The largest part of the command that compensates friction and load of an uncertain servo. Too large a
    /// compensation would drive it away.
    const UNCERTAIN_FRICTION: f64 = 0.5;

    /// The least command that friction and load must leave to turn and to excite with, as a part of all.
    const MIN_FREE: f64 = 0.1;

    /// An unknown part of the command that the loop must balance, of a servo that its fit explains and of another. With the
    /// part of the travel that this may move the servo the bandwidth follows. More would drive lightly damped resonances.
    const UNKNOWN_LOAD: f64 = 0.02;
    const UNCERTAIN_LOAD: f64 = 0.1;
    const YIELD: f64 = 0.05;

    /// The largest bandwidth over the lowest of low lines: a loop that is faster leaves nothing of their injection.
    const BELOW_LINES: f64 = 3.0;

    /// The least bandwidth, rad/s, of a settling that is over by the window.
    const MIN_BANDWIDTH: f64 = 12.0;

    /// With these lines, for a servo that its fit may not explain (`is_uncertain`). `mode` is that of two masses, if they are
    /// known. None if the axis has too little travel, speed, resolution or command for frequency-response motions.
    #[must_use]
    pub(crate) fn new(
        settings: &CommissionSettings,
        servo: &IdentifiedServo,
        forces: &AxisForces,
        is_uncertain: bool,
        mode: Option<&Mode>,
        lines: &Lines,
    ) -> Option<Self> {
        let limits = &settings.limits;
        let (time, counts) = (settings.sample_time, 1.0 / settings.resolution);
        let b = servo.parameters.b;
        let [low, high] = limits.travel;
        let [least, most] = limits.command;
        let command = most.min(-least);
        let mut parameters = servo.parameters;
        if is_uncertain {
            let held = (libm::fabs(parameters.load) + parameters.coulomb) / b;
            let part = (Self::UNCERTAIN_FRICTION * command / held).min(1.0);
            (parameters.a, parameters.load) = (0.0, part * parameters.load);
            parameters.coulomb *= part;
        }
        let free = command - (libm::fabs(parameters.load) + parameters.coulomb) / b;
        let room = 0.5 * (high - low);
        if lines.count() == 0 || free.is_nan() || free < Self::MIN_FREE * command {
            return None;
        }
        // From turning point to turning point at ±(v T/2 + v²/2 a), no turn shorter than the shortest.
        let acceleration = Self::TURN * free * b;
        let (settling, turns) = if is_uncertain {
            (Self::UNCERTAIN_SETTLING, Self::UNCERTAIN_TURNS)
        } else {
            (Self::SETTLING, Self::TURNS)
        };
        let settling = settling * lines.part();
        let frequency_response = settling + lines.window_time();
        let half = 0.5 * (frequency_response + 0.5 * Self::SHORTEST_TURN);
        let turning = turns * room;
        let root = libm::sqrt(half * half + 2.0 * turning / acceleration);
        let speed = (acceleration * (root - half)).min(Self::SPEED * limits.speed);
        let acceleration = acceleration.min(2.0 * speed / Self::SHORTEST_TURN);
        if speed.is_nan() || speed * counts < Self::MIN_SPEED_COUNTS {
            return None;
        }
        let response_motion = 0.5 * speed * frequency_response;
        let turning = response_motion + 0.5 * speed * speed / acceleration;
        // As near to its position as the travel permits.
        let margin = (turning / turns).min(room);
        let middle = 0.0_f64.min(high - margin).max(low + margin);
        let (unknown, patience, learning) = if is_uncertain {
            (
                Self::UNCERTAIN_LOAD,
                Self::UNCERTAIN_PATIENCE,
                Self::LEARNING,
            )
        } else {
            (Self::UNKNOWN_LOAD, Self::PATIENCE, 0)
        };
        let per_load = b * command / (Self::YIELD * room);
        let lowest = lines.frequencies().next().unwrap_or(f64::INFINITY);
        let mut bandwidth = libm::sqrt(unknown * per_load);
        if lines.are_low() {
            bandwidth = bandwidth.min(Self::BELOW_LINES * lowest);
        }
        let [of_command, of_free] = [Self::INJECTION, 2.0 * Self::INJECTION];
        let part = libm::sqrt(2.0 / lines.count() as f64) / Self::CREST;
        let line_speed = part * Self::LINES_SPEED * speed;
        let max_injection = part * (of_command * command).min(of_free * free);
        let number = N::from_f64;
        let rotations = lines.rotations();
        let mean = lines.frequencies().sum::<f64>() / lines.count() as f64;
        let plan = ResponsePlan {
            motion: Motion {
                servo: RoughModel::from_si(&parameters, time, settings.resolution),
                forces: forces.in_units(b, settings.resolution),
                delay: number(servo.delay / time),
                learnt_bandwidth: number(libm::sqrt(Self::UNKNOWN_LOAD / unknown)),
                bandwidth: number(bandwidth.max(Self::MIN_BANDWIDTH) * time),
                speed: number(speed * time * counts),
                acceleration: number(acceleration * time * time * counts),
                start: number((middle - response_motion) * counts),
                learning,
                response_motions: 0,
                settling: libm::ceil(settling / time) as u32,
                window: lines.window(),
                window_rotation: rotations.spacing().map(number),
                fade: number((time / (Self::FADE * lines.part())).min(1.0)),
                max_error: number(Self::ERROR * room * counts),
                patience: libm::ceil(patience / time) as u32,
                line_speed: number(line_speed * time * counts),
            },
            lines: Default::default(),
            count: lines.count() as u8,
        };
        Some(Self {
            plan,
            lines: *lines,
            rotations,
            place: 0,
            mode: mode.copied(),
            b,
            mean,
            line_speed,
            max_injection,
        })
    }

    /// Plans the next line; the plan once all of them are.
    pub(crate) fn work(&mut self) -> Option<ResponsePlan<N>> {
        /// The part of the motion of one mass with which a line is excited at least: at the antiresonance the load would stick.
        const LEAST: f64 = 0.67;
        let line = self.plan.lines.get_mut(self.place);
        let next = self.lines.frequency(self.place);
        let (Some(line), Some((omega, turn))) = (line, next.zip(self.rotations.next())) else {
            return Some(self.plan);
        };
        // One mass: its velocity is b/ω of the command.
        let mode = self.mode.as_ref();
        let moved = mode.map_or(1.0, |mode| over_one_mass(mode, omega).max(LEAST));
        // The encoder sees less of higher ones.
        let most = self.max_injection * libm::sqrt(libm::sqrt(omega / self.mean));
        let amplitude = Self::MAX_GROWTH * self.line_speed * omega / (self.b * moved);
        *line = PlannedLine {
            rotation: [turn.re, turn.im].map(N::from_f64),
            amplitude: N::from_f64(amplitude.min(most)),
        };
        self.place += 1;
        None
    }

    /// All at once.
    #[cfg(test)]
    pub(crate) fn all(mut self) -> ResponsePlan<N> {
        loop {
            if let Some(plan) = self.work() {
                return plan;
            }
        }
    }
}

impl<N: Number> ResponsePlan<N> {
    /// The same with this many motions that are measured, from now on both ways by turns.
    #[must_use]
    pub(crate) fn with_motions(mut self, motions: u8) -> Self {
        self.motion.response_motions = motions;
        self
    }
}

/// The motion of the motor of two masses at a frequency, rad/s, over that of both masses as one, without friction:
/// |1 + β ω²/(ω² − ω₂² − 2jζω₂ω)|.
fn over_one_mass(mode: &Mode, frequency: f64) -> f64 {
    let square = frequency * frequency;
    let denominator = Complex::new(
        square - mode.frequency * mode.frequency,
        -2.0 * mode.damping * mode.frequency * frequency,
    );
    let moved = Complex::ONE.scaled(mode.ratio * square) / denominator + 1.0;
    libm::sqrt(moved.power())
}
