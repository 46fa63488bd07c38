//! The loop of a design, sample by sample. It consists of the controller that will run, the exact servo with friction
//! and delay, and the encoder. The servo may have the mode of a second mass.
//!
//! The holding command is left out on both sides: a command is the excess over it.

use super::axis_forces::AxisForces;
use super::modal_motion::ModalMotion;
use super::placement::Design;
use super::possible_servos::PossibleServo;
use super::resonance::Mode;
use super::sampled_response::split;
use crate::control::{
    CommandLimit, ControlState, Controller, FeedForward, Gains, Notch, ReferenceFilter, Shaped,
    ShapedState,
};
use crate::error::OutOfRange;
use crate::measurement::velocity::{LowPass, LowPassState, VelocityEstimate};
use crate::model::{FrictionStep, Response, ZeroOrderHoldStep, stribeck_factor};
use crate::units::Units;

/// The test signal of a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TestSignal {
    /// The step of the reference in the first sample, rad.
    pub(super) step: f64,
    /// The step of the load in the first sample, rad/s².
    pub(super) load: f64,
    /// Coulomb friction, rad/s².
    pub(super) coulomb: f64,
    /// The friction that the integral balances already when the step comes, rad/s².
    pub(super) balanced: f64,
    /// Position of a count, rad; zero for an ideal sensor.
    pub(super) resolution: f64,
    /// The largest command, command units.
    pub(super) command: f64,
    /// Beside the servo.
    pub(super) forces: AxisForces,
}

/// A loop in motion. Positions are in rad, time in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ClosedLoop {
    controller: Controller<f64, LowPass<f64>, Shaped<f64>>,
    state: ControlState<f64, LowPassState<f64>, ShapedState<f64>>,
    sample_time: f64,
    signal: TestSignal,
    /// 1/v_s, samples per rad.
    per_low_speed_velocity: f64,
    gain: f64,
    step: FrictionStep<f64>,
    /// The two parts of a sample, before and after a command begins to act.
    parts: [SamplePart; 2],
    whole_delay: usize,
    commands: [f64; Self::COMMANDS],
    newest: usize,
    position: f64,
    velocity: f64,
    /// The motion of the mode, and the motor's distance from both masses as one, rad.
    modal: Option<ModalMotion>,
    twist: f64,
    measured: f64,
}

/// A part of a sample, as a sample of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SamplePart {
    length: f64,
    x: f64,
    response: Response<f64>,
}

/// A sample of the predicted loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LoopSample {
    /// As the encoder shows it, rad.
    pub(super) position: f64,
    /// Command units.
    pub(super) command: f64,
}

impl ClosedLoop {
    /// Commands that are kept while they are delayed.
    const COMMANDS: usize = 64;

    /// A loop at rest, with the sample time `sample_time`, or a multiple of it if the loop is slow.
    ///
    /// # Errors
    /// A gain or cut-off that no loop can have.
    pub(super) fn new(
        design: &Design,
        servo: &PossibleServo,
        mode: Option<&Mode>,
        sample_time: f64,
        signal: &TestSignal,
    ) -> Result<Self, OutOfRange> {
        let multiple = multiple(design.bandwidth, servo, sample_time);
        let cutoff = design
            .cutoff
            .min(Self::most_cutoff(multiple * sample_time, sample_time));
        let sample_time = multiple * sample_time;
        let units = Units::new(sample_time, 1.0)?;
        let limit = CommandLimit::from_range([-signal.command, signal.command])?;
        let gains = Gains::new(design.kp, design.kd, design.ki)?;
        let (whole_delay, part) = split(servo.delay / sample_time);
        let parts = [part, 1.0 - part];
        let zero_order_hold = ZeroOrderHoldStep::new();
        let x = servo.a * sample_time;
        let balancing = signal.balanced / servo.b;
        let integral = if design.ki > 0.0 {
            balancing / (design.ki * sample_time)
        } else {
            0.0
        };
        let state = ControlState::default().with_integral(integral);
        let velocity = LowPass::new(&units, cutoff)?;
        let reference = ReferenceFilter::new(&units, design.reference_filter)?;
        let feed_forward = match &design.feed_forward {
            Some(given) => FeedForward::new(&units, given, &gains, &velocity.transfer())?,
            None => FeedForward::default(),
        };
        let controller = Controller::new(&units, &gains, &limit, velocity).with_shaping(
            Shaped::new(reference, feed_forward, Self::notch(design, &units)),
        );
        Ok(Self {
            controller,
            state,
            sample_time,
            signal: *signal,
            per_low_speed_velocity: signal.forces.per_low_speed_velocity / sample_time,
            gain: servo.b,
            step: FrictionStep::new(),
            parts: parts.map(|length| SamplePart {
                length,
                x: x * length,
                response: zero_order_hold.response(x * length),
            }),
            whole_delay: (whole_delay as usize).min(Self::COMMANDS - 2),
            commands: [balancing; Self::COMMANDS],
            newest: 0,
            position: 0.5 * signal.resolution,
            velocity: 0.0,
            modal: mode.map(|mode| ModalMotion::new(mode, parts.map(|part| part * sample_time))),
            twist: 0.0,
            measured: 0.0,
        })
    }

    /// The notch of a design. At a multiple of the sample time there is none if its frequency is too high to make a
    /// difference.
    fn notch(design: &Design, units: &Units) -> Notch<f64> {
        Notch::new(units, design.notch).unwrap_or(Notch::NONE)
    }

    /// The highest cut-off of a loop at a multiple of the sample time. In so slow a loop a higher one makes no
    /// difference.
    fn most_cutoff(multiplied: f64, sample_time: f64) -> f64 {
        if multiplied > sample_time {
            2.0 / multiplied
        } else {
            f64::INFINITY
        }
    }

    /// The sample time that it is computed with, s.
    pub(super) fn sample_time(&self) -> f64 {
        self.sample_time
    }

    /// One sample; none if the loop leaves every range.
    pub(super) fn advance(&mut self) -> Option<LoopSample> {
        let measured = self.reading();
        let increment = measured - self.measured;
        self.measured = measured;
        let error = self.signal.step - measured;
        let sample = self
            .controller
            .process(&mut self.state, error, increment)
            .ok()?;
        self.newest = (self.newest + 1) % Self::COMMANDS;
        if let Some(newest) = self.commands.get_mut(self.newest) {
            *newest = sample.command;
        }
        let delays = [self.whole_delay + 1, self.whole_delay];
        for (place, (part, delay)) in self.parts.into_iter().zip(delays).enumerate() {
            if part.length > 0.0 {
                let change = self.move_for(&part, self.delayed(delay));
                if let Some(modal) = &mut self.modal {
                    self.twist = modal.process(place, change);
                }
            }
        }
        Some(LoopSample {
            position: measured,
            command: sample.command,
        })
    }

    fn reading(&self) -> f64 {
        let resolution = self.signal.resolution;
        let position = self.position + self.twist;
        if resolution > 0.0 {
            resolution * libm::floor(position / resolution)
        } else {
            position
        }
    }

    fn delayed(&self, samples: usize) -> f64 {
        let place = (self.newest + Self::COMMANDS - samples) % Self::COMMANDS;
        self.commands.get(place).copied().unwrap_or(0.0)
    }

    /// Moves both masses as one, and returns the change of their speed, rad per part.
    fn move_for(&mut self, part: &SamplePart, command: f64) -> f64 {
        let time = part.length * self.sample_time;
        let squared = time * time;
        let TestSignal { load, forces, .. } = self.signal;
        let drive = (self.gain * command + load + forces.load(self.position)) * squared;
        let mut friction = self.signal.coulomb;
        // Most axes have none of it, and a chip computes it in double precision.
        if forces.low_speed > 0.0 {
            let falls = self.velocity * self.per_low_speed_velocity;
            friction += forces.low_speed * stribeck_factor(falls);
        }
        let coulomb = friction * squared;
        let velocity = self.velocity * part.length;
        let (motion, _) =
            (self.step).process_with(&part.response, part.x, drive, coulomb, velocity);
        self.position += motion.increment;
        self.velocity = motion.velocity / part.length;
        motion.velocity - velocity
    }
}

/// The predicted step of the identified servo, sample by sample. It does not end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictedStep {
    closed_loop: ClosedLoop,
    samples: u32,
}

/// A sample of a predicted step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedSample {
    /// Since the reference stepped, s.
    pub time: f64,
    /// The position that the encoder shows, from the first one, rad.
    pub position: f64,
    /// Beyond the command that holds the load, command units.
    pub command: f64,
}

impl PredictedStep {
    pub(super) fn new(closed_loop: ClosedLoop) -> Self {
        Self {
            closed_loop,
            samples: 0,
        }
    }
}

impl Iterator for PredictedStep {
    type Item = PredictedSample;

    fn next(&mut self) -> Option<PredictedSample> {
        let time = f64::from(self.samples) * self.closed_loop.sample_time();
        let LoopSample { position, command } = self.closed_loop.advance()?;
        self.samples = self.samples.checked_add(1)?;
        Some(PredictedSample {
            time,
            position,
            command,
        })
    }
}

/// Samples that are computed as one. A loop that is slow against its sampling is computed at a multiple of the sample
/// time. Its hold is still little more than 1 % of 1/ω. So the response does not change, and the time to compute it is
/// bounded.
fn multiple(bandwidth: f64, servo: &PossibleServo, sample_time: f64) -> f64 {
    /// The longest sample, as a part of 1/ω.
    const MAX_SAMPLE: f64 = 0.025;
    let by_bandwidth = MAX_SAMPLE / bandwidth;
    let by_friction = 0.8 * ZeroOrderHoldStep::<f64>::LARGEST_RATE / servo.a;
    libm::floor(by_bandwidth.min(by_friction) / sample_time).max(1.0)
}
