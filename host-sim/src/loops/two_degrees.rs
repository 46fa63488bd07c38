//! A loop with two degrees of freedom, tuned from what is known, off-line least squares over what
//! it recorded, tuned again: Iwasaki, Sato, Morita and Maruyama, "Autotuning of two degree of freedom
//! motor control for high accuracy trajectory motion", Control Engineering Practice 4(4), 1996.
//!
//! The first controller knows the rotor's inertia alone (the initial b̂), its viscous and Coulomb
//! friction are zero. The reference passes a reference model, a feedforward moves the servo along it
//! by the model u = (q̈ + â q̇ + ĉ sign q̇)/b̂, and a feedback with two equal poles takes what is left.
//! After each stage the least squares of u_f = (q̈_f + a q̇_f + c s_f)/b over the stage's samples
//! gives the next controller.

use std::collections::VecDeque;

use identifier_core::ControllerSettings;
use identifier_core::error::{OutOfRange, StepError};
use identifier_core::parameters::ServoParameters;
use identifier_core::replay::NormalEquations;
use identifier_core::units::Units;
use rivals::{Filtered, StateVariableFilter};

use super::feedback::Feedback;
use super::{Measurement, SimLoop, Step};
use crate::experiment::Outcome;

/// Stages of a run.
const STAGES: u64 = 4;

/// Cut-off of the velocity that the feedback sees, times its poles.
const VELOCITY_CUTOFF: f64 = 10.0;

/// The loop, stage by stage.
pub(crate) struct TwoDegreesLoop {
    feedback: Feedback<f64>,
    controller: Controller,
    limit: [f64; 2],
    known: ServoParameters,
    /// True if the last stage found a servo.
    found: bool,
    fit: Fit,
    /// Samples of a stage, and those that this one has had.
    stage: u64,
    done: u64,
}

impl TwoDegreesLoop {
    /// For a run of `samples` samples, from prior knowledge of b. The limit and the bandwidth
    /// are the declared controller's; the least squares look at signals below `cutoff`, rad/s.
    ///
    /// # Errors
    /// The cut-off must be below what the sample time allows.
    pub(crate) fn new(
        units: &Units,
        declared: &ControllerSettings,
        b: f64,
        cutoff: f64,
        samples: u64,
    ) -> Result<Self, OutOfRange> {
        Ok(Self {
            feedback: Feedback::starting_at(0),
            controller: Controller::new(units, declared.kp, b)?,
            limit: declared.limit,
            known: ServoParameters {
                a: 0.0,
                b,
                coulomb: 0.0,
                load: 0.0,
            },
            found: false,
            fit: Fit::new(units, cutoff)?,
            stage: samples.div_ceil(STAGES).max(1),
            done: 0,
        })
    }
}

impl SimLoop for TwoDegreesLoop {
    fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
        if self.done == self.stage {
            // A stage that gives no servo leaves the controller as it is.
            let next = self.fit.solve();
            self.found = next.is_some();
            self.known = next.unwrap_or(self.known);
            self.fit.begin_anew();
            self.done = 0;
        }
        self.done += 1;
        let motion = self.feedback.read(reference, measured);
        let [low, high] = self.limit;
        let command = self
            .controller
            .process(&self.known, reference, motion.position, motion.increment)
            .clamp(low, high);
        self.fit.process(motion.increment, command);
        Ok(Step::direct(command, self.found.then_some(self.known)))
    }

    fn outcome(&self) -> Outcome {
        let failure = "the last stage's least squares gave no servo";
        Outcome {
            failure: (!self.found).then_some(failure),
            ..Outcome::default()
        }
    }
}

/// Feedforward along a reference model and feedback with two equal poles.
struct Controller {
    units: Units,
    poles: f64,
    filter: StateVariableFilter<f64>,
    wanted: Filtered<f64>,
    velocity_filter: StateVariableFilter<f64>,
    velocity: Filtered<f64>,
}

impl Controller {
    /// Poles where the declared proportional gain would have the natural frequency of the servo
    /// that is assumed at first.
    fn new(units: &Units, kp: f64, b: f64) -> Result<Self, OutOfRange> {
        let nyquist = std::f64::consts::PI / units.sample_time();
        let poles = (b * kp).sqrt().min(0.5 * nyquist / VELOCITY_CUTOFF);
        Ok(Self {
            units: *units,
            poles,
            filter: StateVariableFilter::new(units, poles)?,
            wanted: Filtered::AT_REST,
            velocity_filter: StateVariableFilter::new(units, VELOCITY_CUTOFF * poles)?,
            velocity: Filtered::AT_REST,
        })
    }

    /// The command for a reference, a position and its increment, machine units.
    fn process(
        &mut self,
        known: &ServoParameters,
        reference: f64,
        position: f64,
        increment: f64,
    ) -> f64 {
        let unit = self.units.position_unit();
        let per_sample = 1.0 / self.units.velocity();
        self.velocity_filter.process(&mut self.velocity, increment);
        let velocity = self.velocity.value * per_sample;
        self.filter.process(&mut self.wanted, reference);
        let wanted = self.wanted.value * unit;
        let wanted_velocity = self.wanted.rate * per_sample;
        let square = self.poles * self.poles;
        let acceleration =
            square * (reference * unit - wanted) - 2.0 * self.poles * wanted_velocity;
        let friction = known.a * wanted_velocity + known.coulomb * direction(wanted_velocity);
        let feedback =
            square * (wanted - position * unit) + 2.0 * self.poles * (wanted_velocity - velocity);
        (acceleration + friction + feedback) / known.b
    }
}

/// sign x, zero at zero.
fn direction(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Least squares of u_f = J q̈_f + F q̇_f + C s_f, s = sign q̇.
///
/// It is done off-line, so the direction of a sample may be that of the motion from some time before
/// to as much after it: an encoder's single counts are too coarse.
struct Fit {
    units: Units,
    filter: StateVariableFilter<f64>,
    /// Samples to each side from which a direction is taken.
    around: usize,
    /// Increments and commands of the last samples, the newest last.
    recent: VecDeque<(f64, f64)>,
    motion: Filtered<f64>,
    drive: Filtered<f64>,
    friction: Filtered<f64>,
    /// Samples until the filters have settled, at the start and now.
    settling: u32,
    unsettled: u32,
    equations: NormalEquations<f64, 3>,
}

impl Fit {
    /// Time constants of the filter before the first sample counts.
    const SETTLING: f64 = 10.0;

    /// Time to each side from which a direction is taken, s.
    const AROUND: f64 = 0.004;

    fn new(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        let samples = |time: f64| time / units.sample_time();
        let around = samples(Self::AROUND).round().max(1.0) as usize;
        let mut fit = Self {
            units: *units,
            filter: StateVariableFilter::new(units, cutoff)?,
            around,
            recent: VecDeque::with_capacity(2 * around + 1),
            motion: Filtered::AT_REST,
            drive: Filtered::AT_REST,
            friction: Filtered::AT_REST,
            settling: samples(Self::SETTLING / cutoff) as u32,
            unsettled: 0,
            equations: NormalEquations::EMPTY,
        };
        fit.begin_anew();
        Ok(fit)
    }

    /// Forgets every sample.
    fn begin_anew(&mut self) {
        self.recent.clear();
        self.recent.resize(2 * self.around + 1, (0.0, 0.0));
        self.motion = Filtered::AT_REST;
        self.drive = Filtered::AT_REST;
        self.friction = Filtered::AT_REST;
        self.unsettled = self.settling;
        self.equations = NormalEquations::EMPTY;
    }

    fn process(&mut self, increment: f64, command: f64) {
        self.recent.pop_front();
        self.recent.push_back((increment, command));
        let around: f64 = self.recent.iter().map(|(increment, _)| increment).sum();
        let (increment, _) = self.recent[self.around];
        // The command that was held while the position moved by it.
        let (_, command) = self.recent[self.around - 1];
        self.filter.process(&mut self.motion, increment);
        self.filter.process(&mut self.drive, command);
        self.filter.process(&mut self.friction, direction(around));
        if self.unsettled > 0 {
            self.unsettled -= 1;
            return;
        }
        let row = [self.motion.rate, self.motion.value, self.friction.value];
        self.equations.add(&row, self.drive.value);
    }

    fn solve(&self) -> Option<ServoParameters> {
        let [inertia, viscous, coulomb] = self.equations.solve(0.0, &[true; 3]);
        (inertia > 0.0 && viscous.is_finite() && coulomb.is_finite()).then(|| ServoParameters {
            a: viscous / inertia / self.units.rate(),
            b: 1.0 / inertia / self.units.acceleration(),
            coulomb: coulomb / inertia / self.units.acceleration(),
            load: 0.0,
        })
    }
}
