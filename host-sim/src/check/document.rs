//! What is told of a scenario.

use serde::Serialize;

use super::closed_loop::{ClosedLoop, Response};
use super::rehearsal::Rehearsal;
use super::warnings::warnings;
use crate::scenario::{Fault, Scenario};

/// What a scenario means.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Sample time, s.
    pub sample_time: f64,
    /// The servo.
    pub servo: Servo,
    /// The loop around it, where a PID closes it.
    #[serde(rename = "loop")]
    pub closed_loop: Option<ClosedLoop>,
    /// What is certified.
    pub certificate: Certified,
    /// The encoder beside the motion.
    pub encoder: Encoder,
    /// The part of the samples in which the command is at its limit.
    pub limited: f64,
    /// What the motion shows.
    pub known: Vec<Known>,
    /// What speaks against it, in plain words.
    pub warnings: Vec<String>,
}

/// The servo's own figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Servo {
    /// Viscous friction over inertia, 1/s.
    pub a: f64,
    /// Gain over inertia, rad/s² per command unit.
    pub b: f64,
    /// 1/a, s; null for a servo without viscous friction.
    pub time_constant: Option<f64>,
    /// The speed that the largest command holds, rad/s; null without a limit or without friction.
    pub top_speed: Option<f64>,
    /// The command that friction and load take before the servo moves, command units.
    pub breakaway: f64,
}

/// What is certified of the box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Certified {
    /// Whether a box is, for every servo in it.
    pub certified: bool,
    /// The gain margin of the sampled loop over it.
    pub gain_margin: Option<f64>,
    /// μ, 1/s, of the gradient law.
    pub mu: Option<f64>,
}

/// The encoder beside the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Encoder {
    /// A count, rad; of an ideal sensor what its numbers resolve.
    pub resolution: f64,
    /// Deviation of the position, counts.
    pub motion: f64,
    /// By how much a count moves the command at once, command units.
    pub command_per_count: Option<f64>,
}

/// What the motion shows of an unknown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Known {
    /// Its name.
    pub unknown: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The least standard error at the end of the run; null where the motion says nothing of it.
    pub std_error: Option<f64>,
    /// From which standard error on it counts as known.
    pub needed: f64,
    /// When that is reached, s, perhaps after the end of the run; null for never.
    pub from: Option<f64>,
    /// Whether it is before the end of the run.
    pub within_run: bool,
}

impl Check {
    /// Looks at a scenario that can be run.
    ///
    /// # Errors
    /// The key at which it cannot be.
    pub fn of(scenario: &Scenario) -> Result<Self, Fault> {
        /// The correction's bandwidth where there is no loop to take it from: of a sample.
        const OF_A_SAMPLE: f64 = 0.05;
        let plant = scenario
            .plant
            .ok_or_else(|| Fault::new("plant", "a check needs a servo to look at"))?;
        let response = Response::of(scenario, &plant);
        let closed_loop = response.map(|response| response.figures(scenario));
        let omega = closed_loop
            .and_then(|found| found.crossover)
            .unwrap_or(OF_A_SAMPLE / scenario.sample_time());
        let rehearsal = Rehearsal::of(scenario, omega)?;
        let resolution = scenario.stated.resolution;
        let [low, high] = scenario.controller().limit;
        let largest = high.min(-low);
        let friction = plant.coulomb + plant.load.abs();
        let mut check = Self {
            sample_time: scenario.sample_time(),
            servo: Servo {
                a: plant.a,
                b: plant.b,
                time_constant: (plant.a > 0.0).then(|| 1.0 / plant.a),
                top_speed: (plant.a > 0.0 && largest.is_finite())
                    .then(|| ((plant.b * largest - friction) / plant.a).max(0.0)),
                breakaway: friction / plant.b,
            },
            closed_loop,
            certificate: Certified {
                certified: rehearsal.outcome.certified,
                gain_margin: rehearsal.outcome.gain_margin,
                mu: rehearsal.outcome.mu,
            },
            encoder: Encoder {
                resolution,
                motion: rehearsal.position / resolution,
                command_per_count: response.map(|response| response.command_of(resolution)),
            },
            limited: rehearsal.limited,
            known: rehearsal.known.clone(),
            warnings: Vec::new(),
        };
        check.warnings = warnings(&check, scenario, &rehearsal);
        Ok(check)
    }
}
