use std::f64::consts::TAU;

use identifier_core::tuning::{EncoderSide, Goal, TuningSettings};

use super::known_forces::Angle;
use super::{Form, IdentifiedResult};
use crate::named;
use crate::options::{as_parsed, options};
use crate::provenance::Task;
use crate::result::{CommandSign, KeptResult};
use crate::scenario::{CommandUnit, Options};

named! {
    /// The mass that the encoder is on.
    pub enum EncoderMass {
        /// The motor.
        Motor = "motor",
        /// The load behind a shaft, belt or gear.
        Load = "load",
    }
}

named! {
    /// The direction of the command that the loop gives, in relation to the column of the log.
    pub enum CommandDirection {
        /// The same as the column.
        AsLogged = "as-logged",
        /// The opposite: a positive command moves the position up.
        Inverted = "inverted",
    }
}

options! {
    /// Goal and conditions of the gains, SI, as options. The rest comes from the scenario or the result, or has a default.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub struct Conditions {
        /// Goal: time from 10 to 90 % of a step, s.
        response_time: f64 = "S" { group = "goal", conflicts_with = "feed_forward" },
        /// Goal: ω of the loop's poles, rad/s.
        bandwidth: f64 = "W" { group = "goal" },
        /// Sample time of the loop, s; the result's by default.
        sample_time: f64 = "T",
        /// Counts of the encoder per revolution; 0 for an ideal sensor.
        counts: f64 = "N" { group = "encoder" },
        /// Position of a count, rad (m on a linear axis); 0 for an ideal sensor.
        resolution: f64 = "R" { group = "encoder" },
        /// The largest command, command units; inf for none.
        limit: f64 = "U",
        /// Delay from encoder reading to output that was not identified, s; the scenario's, or none, by default.
        command_delay: f64 = "S",
        /// Cut-off of the velocity estimate, rad/s; chosen with the gains by default.
        cutoff: f64 = "W",
        /// Largest sensitivity Ms; 1.6 by default.
        max_sensitivity: f64 = "M",
        /// Largest noise of the command due to encoder noise, as a fraction of the limit; 0.03 by default.
        max_noise: f64 = "PART",
        /// Lowest frequency at which a resonance may lie that the log does not show, rad/s; inf for none. What the log shows
        /// decides by default.
        resonance: f64 = "W",
        /// The mass that the encoder is on: motor or load. Without it a resonance that the log does not show may be either's.
        encoder_on: EncoderMass = "MASS",
        /// Direction of the loop's command, where the log's was inverted because the motion goes against it: inverted or
        /// as-logged.
        command_sign: CommandDirection = "SIGN",
        /// Step of the predicted response, rad; 0.1 by default, at least 10 counts.
        step: f64 = "RAD",
        /// Torque of an A of the command (of a unit, where it is in none), N·m, for a form that takes a torque; the result's by
        /// default.
        torque_constant: f64 = "K" { requires = "form" },
        /// Unit of the log's command, where the log does not state it: Nm, A or V, for a form that takes one of them.
        command_unit: CommandUnit = "UNIT" { requires = "form" },
        /// Supply voltage, V, for a form whose command is a share of it.
        bus_voltage: f64 = "V" { requires = "form" },
        /// The largest current, A, for a form whose command is a share of it.
        max_current: f64 = "A" { requires = "form" },
    }
    more {
        /// Add a reference model with feed-forward if the step then rises faster.
        #[cfg_attr(feature = "clap", arg(long))]
        pub feed_forward: bool,
        /// Print the gains in the form of a drive's firmware: pid, cascade, simplefoc, odrive, moteus, vesc, dynamixel,
        /// feetech, wpilib, sparkmax, linuxcnc or cia402.
        #[cfg_attr(feature = "clap", arg(long = "for", value_name = "FORM", conflicts_with = "feed_forward"))]
        pub form: Option<Form>,
    }
}

as_parsed! { CommandDirection EncoderMass }

/// A condition that is not known and must be stated.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ConditionError {
    /// The resolution of the encoder.
    #[error(
        "the result lacks the encoder's resolution: state --counts N (per revolution, 0 for an ideal sensor), \
         --resolution R (rad per count), or --scenario S"
    )]
    Resolution,
    /// The largest command.
    #[error(
        "the result lacks the largest command: state --limit U (command units, inf for none), or --scenario S"
    )]
    Limit,
    /// The sign of the command was inferred.
    #[error(
        "the motion goes against the command of the log, whose sign was inverted to identify it. A loop that ran usually \
         gives the opposite of such a column: if yours does, state --command-sign inverted"
    )]
    Sign,
    /// The loop's command moves the position down.
    #[error(
        "--command-sign as-logged: with a command that moves the position down every gain makes the axis run away; reverse \
         motor or encoder in the drive, then state --command-sign inverted"
    )]
    Against,
    /// Nothing says where a resonance may lie.
    #[error(
        "the result does not say up to which frequency its motion would have shown a resonance: identify the log again \
         without a scenario or with law = \"fit\", or state --resonance W (rad/s, inf for none)"
    )]
    Resonance,
    /// The load takes all of it.
    #[error(
        "holding the load needs a command of {holding:.4}, beyond the limit of {} to {}: state a larger --limit",
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
    /// The step of the prediction if none is stated, rad.
    pub const STEP: f64 = 0.1;

    /// The goal: the stiffest gains, unless another is stated.
    #[must_use]
    pub fn goal(&self) -> Goal {
        match (self.response_time, self.bandwidth) {
            (Some(time), _) => Goal::ResponseTime(time),
            (None, Some(bandwidth)) => Goal::Bandwidth(bandwidth),
            (None, None) => Goal::Stiffest,
        }
    }

    /// The tuner's settings for a goal.
    ///
    /// # Errors
    /// The condition that is not known.
    pub fn settings(
        &self,
        goal: Goal,
        result: &IdentifiedResult,
        known: &KnownConditions,
    ) -> Result<TuningSettings, ConditionError> {
        let of_counts = |counts: f64| if counts == 0.0 { 0.0 } else { TAU / counts };
        let stated = self.resolution.or_else(|| self.counts.map(of_counts));
        let resolution = stated.or(known.resolution);
        let resolution = resolution.ok_or(ConditionError::Resolution)?;
        let limit = self.limit.map(|limit| [-limit, limit]).or(known.limit);
        let limit = limit.ok_or(ConditionError::Limit)?;
        // The amplifier's own may be lower.
        let own = result.model.limit;
        let limit = limit.map(|limit| limit.clamp(-own, own));
        self.check(result)?;
        let command = beyond_the_load(result, limit)?;
        let step = Self::STEP.max(TuningSettings::MIN_STEP_COUNTS * resolution);
        let command_delay = self.command_delay.unwrap_or(known.command_delay);
        let mut settings = TuningSettings {
            sample_time: self.sample_time.unwrap_or(result.sample_time),
            resolution,
            noise: noise_beside_rounding(result, resolution),
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
            encoder: self
                .encoder_on
                .map_or(EncoderSide::Unknown, EncoderMass::side),
            notch: true,
            feed_forward: self.feed_forward,
        };
        if let Some(form) = self.form {
            form.prepare(&mut settings, self);
        }
        Ok(settings)
    }

    /// Refuses what the result leaves open and nothing states.
    fn check(&self, result: &IdentifiedResult) -> Result<(), ConditionError> {
        let reading = result.reading.as_ref();
        let command = reading.and_then(|reading| reading.command.as_ref());
        let is_inferred = command.is_some_and(|command| command.sign == CommandSign::Inferred);
        match self.command_sign {
            Some(CommandDirection::AsLogged) => return Err(ConditionError::Against),
            None if is_inferred => return Err(ConditionError::Sign),
            _ => {}
        }
        let is_known = result.model.hidden.is_some() || self.resonance.is_some();
        is_known.then_some(()).ok_or(ConditionError::Resonance)
    }

    /// The conditions that are taken from a log because nothing states them, a sentence each.
    #[must_use]
    pub fn assumptions(&self, known: &KnownConditions) -> Vec<String> {
        let is_stated = self.resolution.is_some() || self.counts.is_some();
        let step = known
            .resolution
            .filter(|_| known.is_step_of_log && !is_stated);
        let command = known
            .limit
            .filter(|_| known.is_command_of_log && self.limit.is_none());
        let step = step.map(|step| {
            format!(
                "the encoder's resolution is assumed to be the smallest step of the log, {step:.4e} rad: state it \
                 with --counts or --resolution"
            )
        });
        let command = command.map(|[_, largest]| {
            format!("the limit is assumed to be the largest command of the log, {largest:.4}: state it with --limit")
        });
        step.into_iter().chain(command).collect()
    }
}

impl EncoderMass {
    const fn side(self) -> EncoderSide {
        match self {
            Self::Motor => EncoderSide::Motor,
            Self::Load => EncoderSide::Load,
        }
    }
}

/// The conditions that a scenario or a result holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct KnownConditions {
    /// Position of a count, rad; zero for an ideal sensor.
    pub resolution: Option<f64>,
    /// Lowest and highest command, command units.
    pub limit: Option<[f64; 2]>,
    /// Delay besides an identified one, s.
    pub command_delay: f64,
    /// The angle of gravity and ripple, where it is the same one in every run.
    pub angle: Option<Angle>,
    /// True if the resolution is the smallest step of a log.
    pub is_step_of_log: bool,
    /// True if the limit is the largest command of a log.
    pub is_command_of_log: bool,
    /// The unit of the command, where a scenario states it.
    pub command_unit: Option<CommandUnit>,
    /// Torque of a unit of command, N·m.
    pub torque_constant: Option<f64>,
}

impl KnownConditions {
    /// Those of a scenario, for a result in which a delay was identified or not.
    #[must_use]
    pub fn of_scenario(scenario: &Options, has_delay: bool) -> Self {
        let controller = scenario.stated.controller;
        let unlimited = [f64::NEG_INFINITY, f64::INFINITY];
        let resolution = match scenario.counts_per_rev {
            Some(_) => scenario.stated.resolution,
            None => 0.0,
        };
        Self {
            resolution: Some(resolution),
            limit: Some(controller.map_or(unlimited, |pid| pid.limit)),
            command_delay: declared_delay(scenario, has_delay),
            angle: Angle::of_scenario(scenario),
            is_step_of_log: false,
            is_command_of_log: false,
            command_unit: Some(scenario.physical.command_unit),
            torque_constant: scenario.physical.torque_constant,
        }
    }

    /// Those of a result of a scenario. They are those of its logs, if it has any, where the scenario states no encoder or no
    /// controller.
    pub(super) fn of_logs(scenario: &Options, result: &KeptResult, has_delay: bool) -> Self {
        let mut known = Self::of_scenario(scenario, has_delay);
        let logs = result.logs.iter();
        if scenario.counts_per_rev.is_none() && !result.logs.is_empty() {
            known.resolution = logs.clone().map(|log| log.resolution).reduce(f64::min);
            known.is_step_of_log = true;
        }
        if scenario.stated.controller.is_none() && !result.logs.is_empty() {
            let largest = logs.filter_map(|log| log.largest_command).reduce(f64::max);
            known.limit = largest.map(|largest| [-largest, largest]);
            known.is_command_of_log = true;
        }
        known
    }

    /// The conditions of a result with its origin. They are its scenario's, and those of the replayed log if encoder or
    /// controller are unknown. Without an origin nothing is known.
    #[must_use]
    pub fn of_result(result: &KeptResult, has_delay: bool) -> Self {
        let origin = result.origin.as_ref();
        let known =
            origin.and_then(|origin| Some((&origin.task, Options::of_origin(origin).ok()?)));
        match known {
            Some((Task::Run | Task::Replay { .. }, scenario)) => {
                Self::of_logs(&scenario, result, has_delay)
            }
            Some((Task::Commission, _)) | None => Self::default(),
        }
    }
}

/// Standard deviation of the noise of the position, rad. Zero unless it exceeds rounding and the error of that
/// estimate.
fn noise_beside_rounding(result: &IdentifiedResult, resolution: f64) -> f64 {
    let noise = result.noise.filter(|noise| *noise > 0.5 * resolution);
    noise.filter(|_| resolution > 0.0).map_or(0.0, |noise| {
        (noise * noise - resolution * resolution / 12.0).sqrt()
    })
}

/// Room that a limit leaves to either side of the command that holds the load.
fn beyond_the_load(
    result: &IdentifiedResult,
    [low, high]: [f64; 2],
) -> Result<f64, ConditionError> {
    let parameters = result.model.servo.parameters;
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

/// The delay that a scenario declares besides the identified one, s. An identified delay contains the declared one, but
/// not the current loop's.
fn declared_delay(scenario: &Options, identified: bool) -> f64 {
    let terms = &scenario.stated.identifier.terms;
    terms.current_loop + if identified { 0.0 } else { terms.delay }
}
