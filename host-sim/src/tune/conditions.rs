use std::f64::consts::TAU;

use identifier_core::tuning::{Goal, TuningSettings};

use super::IdentifiedResult;
use crate::scenario::Scenario;

/// The conditions that gains are computed for, SI, as options; the rest is taken from the scenario or the result,
/// or has a default.
#[derive(Debug, Clone, Copy, PartialEq, Default, clap::Args)]
pub struct Conditions {
    /// Sample time of the loop, s; the result's by default.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub sample_time: Option<f64>,
    /// Counts of the encoder per revolution; 0 for an ideal sensor.
    #[arg(
        long,
        value_name = "N",
        group = "encoder",
        allow_negative_numbers = true
    )]
    pub counts: Option<f64>,
    /// Position of a count, rad (m on a linear axis); 0 for an ideal sensor.
    #[arg(
        long,
        value_name = "R",
        group = "encoder",
        allow_negative_numbers = true
    )]
    pub resolution: Option<f64>,
    /// The largest command, command units; inf for none.
    #[arg(long, value_name = "U", allow_negative_numbers = true)]
    pub limit: Option<f64>,
    /// Delay from encoder reading to output that was not identified, s; the scenario's, or none, by default.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub command_delay: Option<f64>,
    /// Cut-off of the velocity estimate, rad/s; chosen with the gains by default.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub cutoff: Option<f64>,
    /// Largest sensitivity Ms; 1.6 by default.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub max_sensitivity: Option<f64>,
    /// Largest share of the encoder's rounding in the command, as a fraction of the limit; 0.03 by default.
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    pub max_noise: Option<f64>,
    /// Lowest known resonance, rad/s.
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub resonance: Option<f64>,
    /// Step of the predicted response, rad; 0.1 by default, at least 10 counts.
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    pub step: Option<f64>,
}

/// A condition that is not known and must be stated.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ConditionError {
    /// The resolution of the encoder.
    #[error(
        "the result does not hold the encoder's resolution: state --counts N (a revolution, 0 for an ideal \
         sensor), --resolution R (rad a count), or --scenario S"
    )]
    Resolution,
    /// The largest command.
    #[error(
        "the result does not hold the largest command: state --limit U (command units, inf for none), or \
         --scenario S"
    )]
    Limit,
    /// The load takes all of it.
    #[error(
        "the load is held by a command of {holding:.4}, which the limit of {} to {} does not allow: state a \
         larger --limit",
        limit[0],
        limit[1]
    )]
    Overloaded {
        /// The command that holds the load, command units.
        holding: f64,
        /// Lowest and highest command.
        limit: [f64; 2],
    },
}

impl Conditions {
    /// The step that is promised where none is stated, rad.
    pub const STEP: f64 = 0.1;

    /// The tuner's settings for a goal.
    ///
    /// # Errors
    /// The condition that is not known.
    pub fn settings(
        &self,
        goal: Goal,
        result: &IdentifiedResult,
        scenario: Option<&Scenario>,
    ) -> Result<TuningSettings, ConditionError> {
        let of_counts = |counts: f64| if counts == 0.0 { 0.0 } else { TAU / counts };
        let stated = self.resolution.or_else(|| self.counts.map(of_counts));
        let resolution = stated.or_else(|| scenario.map(resolution));
        let resolution = resolution.ok_or(ConditionError::Resolution)?;
        let limit = match self.limit {
            Some(limit) => Some([-limit, limit]),
            None => scenario.map(|scenario| {
                let controller = scenario.stated.controller;
                controller.map_or([f64::NEG_INFINITY, f64::INFINITY], |pid| pid.limit)
            }),
        };
        let limit = limit.ok_or(ConditionError::Limit)?;
        let command = beyond_the_load(result, limit)?;
        let step = Self::STEP.max(TuningSettings::MIN_STEP_COUNTS * resolution);
        let command_delay = self.command_delay.unwrap_or_else(|| {
            scenario.map_or(0.0, |scenario| declared_delay(scenario, result.has_delay))
        });
        Ok(TuningSettings {
            sample_time: self.sample_time.unwrap_or(result.sample_time),
            resolution,
            cutoff: self.cutoff,
            command,
            command_delay,
            goal,
            max_sensitivity: self
                .max_sensitivity
                .unwrap_or(TuningSettings::MAX_SENSITIVITY),
            max_noise: self.max_noise.unwrap_or(TuningSettings::MAX_NOISE),
            step: self.step.unwrap_or(step),
            resonance: self.resonance,
        })
    }
}

fn resolution(scenario: &Scenario) -> f64 {
    match scenario.counts_per_rev {
        Some(_) => scenario.stated.resolution,
        None => 0.0,
    }
}

/// Room that a limit leaves to either side of the command that holds the load.
fn beyond_the_load(
    result: &IdentifiedResult,
    [low, high]: [f64; 2],
) -> Result<f64, ConditionError> {
    let parameters = result.servo.parameters;
    let holding = -parameters.load / parameters.b;
    let command = (high - holding).min(holding - low);
    // A limit that is no number or below zero is the tuner's to refuse.
    if command <= 0.0 && high > 0.0 {
        return Err(ConditionError::Overloaded {
            holding,
            limit: [low, high],
        });
    }
    Ok(command)
}

/// The delay that a scenario declares besides what was identified, s: an identified delay contains the
/// declared one, but not the current loop's.
fn declared_delay(scenario: &Scenario, identified: bool) -> f64 {
    let terms = &scenario.stated.identifier.terms;
    terms.current_loop + if identified { 0.0 } else { terms.delay }
}
