use std::fmt;

use identifier_core::tuning::{Goal, TuningSettings};

use super::IdentifiedResult;
use crate::scenario::Scenario;

/// What gains are looked for under, SI, as far as it is stated; the rest is taken from the scenario or the
/// result, or has a default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// What is asked for.
    pub goal: Goal,
    /// Sample time, s.
    pub sample_time: Option<f64>,
    /// Position of a count, rad; zero for an ideal sensor.
    pub resolution: Option<f64>,
    /// |u| ≤ limit, command units; infinite for none.
    pub limit: Option<f64>,
    /// Delay that was not identified, s.
    pub command_delay: Option<f64>,
    /// Cut-off of the velocity estimate, rad/s.
    pub cutoff: Option<f64>,
    /// The largest sensitivity.
    pub most_sensitivity: Option<f64>,
    /// The largest part of the command that the encoder's rounding may make up.
    pub most_noise: Option<f64>,
    /// The lowest resonance, rad/s.
    pub resonance: Option<f64>,
    /// The step that is promised, rad.
    pub step: Option<f64>,
}

/// What is not known and must be stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ConditionError {
    /// Neither result nor options say how fine the encoder is.
    Resolution,
    /// Nor how large a command may be.
    Limit,
    /// The load takes all of it.
    Overloaded {
        /// What holds the load, command units.
        holding: f64,
        /// Lowest and highest command.
        limit: [f64; 2],
    },
}

impl fmt::Display for ConditionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Resolution => f.write_str(
                "the result does not hold the encoder's resolution: state --counts N (a revolution, 0 for an \
                 ideal sensor), --resolution R (rad a count), or --scenario S",
            ),
            Self::Limit => f.write_str(
                "the result does not hold the largest command: state --limit U (command units, inf for none), \
                 or --scenario S",
            ),
            Self::Overloaded {
                holding,
                limit: [low, high],
            } => write!(
                f,
                "the load is held by a command of {holding:.4}, which the limit of {low} to {high} does not \
                 allow: state a larger --limit"
            ),
        }
    }
}

impl std::error::Error for ConditionError {}

impl Conditions {
    /// The step that is promised where none is stated, rad.
    pub const STEP: f64 = 0.1;

    /// As stiff as the servo bears, with everything else from result and scenario.
    pub const STIFFEST: Self = Self {
        goal: Goal::Stiffest,
        sample_time: None,
        resolution: None,
        limit: None,
        command_delay: None,
        cutoff: None,
        most_sensitivity: None,
        most_noise: None,
        resonance: None,
        step: None,
    };

    /// Everything that the tuner is to know of a result.
    ///
    /// # Errors
    /// What is not known.
    pub fn settings(
        &self,
        result: &IdentifiedResult,
        scenario: Option<&Scenario>,
    ) -> Result<TuningSettings, ConditionError> {
        let resolution = self.resolution.or_else(|| scenario.map(resolution));
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
        let step = Self::STEP.max(TuningSettings::LEAST_COUNTS * resolution);
        let command_delay = self.command_delay.unwrap_or_else(|| {
            scenario.map_or(0.0, |scenario| declared_delay(scenario, result.has_delay))
        });
        Ok(TuningSettings {
            sample_time: self.sample_time.unwrap_or(result.sample_time),
            resolution,
            cutoff: self.cutoff,
            command,
            command_delay,
            goal: self.goal,
            max_sensitivity: self
                .most_sensitivity
                .unwrap_or(TuningSettings::MAX_SENSITIVITY),
            max_noise: self.most_noise.unwrap_or(TuningSettings::MAX_NOISE),
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

/// What a limit leaves to either side of the command that holds the load.
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
