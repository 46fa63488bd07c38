//! Gains in the form of a drive's firmware.
//!
//! A [`Form`] is a row of the table of firmwares. Its rate, filter and delay enter the conditions of the design; the gains
//! become its parameters, these are rounded to what it stores, and margins and step are computed of what is stored.

mod firmware;
mod firmware_loop;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::tuning::{Cap, Goal, PossibleServo, Promise, Tuning, TuningSettings};

use self::firmware::{FIRMWARES, Firmware, Of, Parameter, Takes};
use self::firmware_loop::{FirmwareLoop, Law};
use super::{Conditions, IdentifiedResult, KnownConditions, NoGains, Tuned};
use crate::result::{FormMargins, FormParameter, FormResult, FormStep};
use crate::scenario::CommandUnit;

/// The form of a drive's firmware.
#[derive(Clone, Copy)]
pub struct Form(&'static Firmware);

/// Why gains do not get a form.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum FormError {
    /// A number that the conversion needs.
    #[error(
        "{form} takes {takes}, and the conversion needs {what}: state {option}, for example {option} {example}"
    )]
    Missing {
        /// The form.
        form: Form,
        /// What the firmware takes as command.
        takes: &'static str,
        /// The number.
        what: &'static str,
        /// The option that states it.
        option: &'static str,
        /// A value of it.
        example: &'static str,
    },
    /// A number that is not allowed.
    #[error("{option} {value} is not allowed: it must be a number above 0")]
    NotAllowed {
        /// The option.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// A command that is something else.
    #[error(
        "{form} takes {takes}, and the command of the result is in {unit}, which does not become that without a model of \
         the motor: identify with a log of the drive's own command"
    )]
    OtherCommand {
        /// The form.
        form: Form,
        /// What the firmware takes as command.
        takes: &'static str,
        /// The unit of the command.
        unit: &'static str,
    },
    /// A linear axis.
    #[error(
        "the result is of an axis in m, and {0} is for one that turns: take pid, cascade, wpilib, linuxcnc or cia402"
    )]
    Linear(Form),
    /// No proportional gain keeps the margins.
    #[error(
        "{0} has a proportional gain only, and none keeps the margins: the servo has too little friction of its own"
    )]
    Undamped(Form),
}

impl Form {
    /// The name that states it.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// All names, for a message.
    #[must_use]
    pub fn names() -> String {
        let names: Vec<_> = FIRMWARES.iter().map(|firmware| firmware.name).collect();
        names.join(", ")
    }

    /// Takes rate, filter and delay of the firmware into the settings of a tuning.
    pub(super) fn prepare(self, settings: &mut TuningSettings, stated: &Conditions) {
        if let (None, Some(time)) = (stated.sample_time, self.0.sample_time) {
            settings.sample_time = time;
        }
        let time = settings.sample_time;
        settings.command_delay += self.0.delay * time;
        let frequency = stated.cutoff.or(self.0.cutoff).or(match self.0.filter {
            firmware::Filter::Difference => Some(0.0),
            _ => None,
        });
        settings.cutoff = frequency.map(|frequency| self.0.filter.cutoff(frequency, time));
        settings.feed_forward = false;
    }

    /// Gains for a result with their form. Where the firmware's own loop has less than the margins, or another response
    /// time than the goal, a loop of another bandwidth is designed.
    ///
    /// # Errors
    /// As [`Tuned::new`], or why the gains do not get the form.
    pub(super) fn tune(
        self,
        result: &IdentifiedResult,
        known: &KnownConditions,
        conditions: &Conditions,
        settings: &TuningSettings,
    ) -> Result<Tuned, NoGains> {
        /// Part of the bandwidth that the next attempt has, and attempts.
        const SLOWER: f64 = 0.97;
        const ATTEMPTS: usize = 150;
        /// Tolerance of the largest sensitivity, which a search meets to that, and of the response time.
        const TOLERANCE: f64 = 1.005;
        const TIME_TOLERANCE: f64 = 0.02;
        let (scale, assumption) = self.scale(known, conditions, result.servo.parameters.b)?;
        let mut settings = *settings;
        let (goal, mut share, mut is_slower) = (settings.goal, 1.0, false);
        for _ in 0..ATTEMPTS {
            let tuned = Tuned::new(result, known.angle.as_ref(), &settings)?;
            let bandwidth = tuned.tuning.bandwidth;
            let stored = self.stored(&tuned, conditions, scale, share, known.is_linear);
            let keeps = stored.margins.sensitivity <= TOLERANCE * settings.max_sensitivity;
            if !keeps || stored.firmware_loop.gains[0] <= 0.0 {
                is_slower = true;
                if self.0.law == Law::Proportional {
                    share *= SLOWER;
                } else {
                    settings.goal = Goal::Bandwidth(SLOWER * bandwidth);
                }
                continue;
            }
            let form = self.result(&tuned, stored, &assumption);
            let rise_time = form.steps.last().and_then(|step| step.rise_time);
            let is_free = self.0.law != Law::Proportional && goal != Goal::Stiffest;
            if is_slower && is_free {
                return Err(NoGains::TooFast {
                    cap: Cap::Delay,
                    most: bandwidth,
                    rise_time,
                });
            }
            if let (Goal::ResponseTime(asked), Some(took), true) = (goal, rise_time, is_free)
                && (took / asked - 1.0).abs() > TIME_TOLERANCE
            {
                settings.goal = Goal::Bandwidth(bandwidth * took / asked);
                continue;
            }
            let cap = is_slower.then_some(Cap::Delay).or(tuned.tuning.cap);
            return Ok(Tuned {
                form: Some(form),
                tuning: Tuning {
                    cap,
                    ..tuned.tuning
                },
                ..tuned
            });
        }
        Err(NoGains::Form(FormError::Undamped(self)))
    }

    /// The command of the firmware for one of the result, and what had to be assumed for it.
    fn scale(
        self,
        known: &KnownConditions,
        stated: &Conditions,
        b: f64,
    ) -> Result<(f64, Option<String>), NoGains> {
        let Firmware { takes, angle, .. } = self.0;
        if known.is_linear && angle.is_some() {
            return Err(NoGains::Form(FormError::Linear(self)));
        }
        let named = takes.named();
        let unit = known.command_unit;
        let missing = |what, option, example| FormError::Missing {
            form: self,
            takes: named,
            what,
            option,
            example,
        };
        let checked = |option, value: Option<f64>, missing: FormError| match value {
            Some(value) if value > 0.0 && value.is_finite() => Ok(value),
            Some(value) => Err(FormError::NotAllowed { option, value }),
            None => Err(missing),
        };
        let torque = || {
            let option = "--torque-constant";
            let what = "the torque of a unit of command";
            let value = stated.torque_constant.or(known.torque_constant);
            checked(option, value, missing(what, option, "0.1"))
        };
        let scale = match (takes, unit) {
            (Takes::Same, _) => Ok(1.0),
            (Takes::Acceleration, _) => Ok(b / TAU),
            (Takes::Torque, CommandUnit::NewtonMetre) => Ok(1.0),
            (Takes::Torque, CommandUnit::Other)
                if stated.torque_constant.or(known.torque_constant).is_none() =>
            {
                Ok(1.0)
            }
            (Takes::Torque, CommandUnit::Ampere | CommandUnit::Other) => torque(),
            (
                Takes::ShareOfCurrent,
                CommandUnit::Ampere | CommandUnit::Other | CommandUnit::NewtonMetre,
            ) => {
                let option = "--max-current";
                let largest = checked(
                    option,
                    stated.max_current,
                    missing("l_current_max in A", option, "60"),
                );
                largest.and_then(|largest| match unit {
                    CommandUnit::NewtonMetre => Ok(1.0 / (largest * torque()?)),
                    _ => Ok(1.0 / largest),
                })
            }
            (Takes::Voltage, CommandUnit::Volt | CommandUnit::Other) => Ok(1.0),
            (Takes::ShareOfVoltage, CommandUnit::Other) if stated.bus_voltage.is_none() => Ok(1.0),
            (Takes::ShareOfVoltage, CommandUnit::Volt | CommandUnit::Other) => {
                let option = "--bus-voltage";
                let supply = missing("the supply voltage", option, "12");
                checked(option, stated.bus_voltage, supply).map(f64::recip)
            }
            _ => Err(FormError::OtherCommand {
                form: self,
                takes: named,
                unit: unit.name(),
            }),
        };
        let scale = scale.map_err(NoGains::Form)?;
        let is_assumed = unit == CommandUnit::Other
            && !matches!(takes, Takes::Same | Takes::Acceleration)
            && stated.torque_constant.or(known.torque_constant).is_none();
        let assumed = match takes {
            Takes::ShareOfCurrent => "a current in A",
            Takes::ShareOfVoltage if stated.bus_voltage.is_some() => "a voltage in V",
            _ => named,
        };
        let assumption = is_assumed.then(|| {
            format!(
                "The result does not tell the unit of the command: it is taken to be {assumed}. `identify --command-unit` \
                 states it."
            )
        });
        Ok((scale, assumption))
    }

    /// The parameters of gains as they are stored, and the loop that these make.
    fn stored(
        self,
        tuned: &Tuned,
        conditions: &Conditions,
        scale: f64,
        share: f64,
        is_linear: bool,
    ) -> Stored {
        let firmware = self.0;
        let (servo, settings) = (&tuned.servo, &tuned.settings);
        let time = settings.sample_time;
        let (mut gains, exactness) = firmware.law.gains(&tuned.tuning, share);
        let frequency = conditions.cutoff.or(firmware.cutoff);
        let number = firmware
            .filter
            .number(frequency.unwrap_or(tuned.tuning.cutoff), time);
        let mut filter = number;
        let per_angle = scale * firmware.angle.unwrap_or(1.0);
        let (a, b) = (servo.parameters.a, servo.parameters.b);
        let holding = (servo.parameters.load / b).abs();
        // What a gain of the firmware is for one of SI.
        let of_gain = |place: usize| match firmware.law {
            Law::Cascade if place == 0 => 1.0,
            _ => per_angle,
        };
        let mut parameters = Vec::new();
        for parameter in firmware.parameters {
            let Parameter { of, factor, .. } = *parameter;
            let value = match of {
                Of::Gain(place) => gains[place] * of_gain(place),
                Of::ResetTime => gains[1] / gains[2],
                Of::Filter => number,
                Of::Acceleration => per_angle / b,
                Of::Velocity => per_angle * a / b,
                Of::Friction => scale * servo.parameters.coulomb / b,
                Of::Limit => scale * (settings.command + holding),
            };
            if !value.is_finite() {
                continue;
            }
            let value = parameter.rounding.of(factor * value);
            match of {
                Of::Gain(place) => gains[place] = value / (factor * of_gain(place)),
                Of::ResetTime if value > 0.0 => gains[2] = gains[1] * factor / value,
                Of::Filter => filter = value,
                _ => {}
            }
            let unit = parameter.unit.replace('$', self.command_unit());
            parameters.push(FormParameter {
                name: parameter.name,
                value,
                unit: if is_linear && of != Of::Filter {
                    unit.replace("rad", "m")
                } else {
                    unit
                },
            });
        }
        let firmware_loop = FirmwareLoop {
            sample_time: time,
            filter: firmware.filter.with(filter, time, firmware.position),
            newest: firmware.newest,
            law: firmware.law,
            gains,
        };
        let corners = corners(servo, settings.command_delay);
        Stored {
            margins: firmware_loop.margins(&corners, tuned.tuning.bandwidth),
            parameters,
            exactness,
            firmware_loop,
        }
    }

    /// The unit of its command.
    fn command_unit(self) -> &'static str {
        match self.0.takes {
            Takes::Torque => "Nm",
            Takes::Voltage => "V",
            _ => "command",
        }
    }

    /// The result of what is stored.
    fn result(self, tuned: &Tuned, stored: Stored, assumption: &Option<String>) -> FormResult {
        let firmware = self.0;
        let Stored {
            margins,
            parameters,
            exactness,
            firmware_loop,
        } = stored;
        let servo = corners(&tuned.servo, tuned.settings.command_delay)[0];
        let bandwidth = tuned.tuning.bandwidth;
        let until = Promise::MAX_TIME / bandwidth;
        let gains = firmware_loop.gains;
        let smoothing = firmware.law.smoothing(&gains);
        let courses = [0.0, smoothing].map(|smoothing| {
            let samples = firmware_loop.step(&servo, smoothing, until);
            (FormStep::of(&samples, smoothing), samples)
        });
        let [(step, response), (smoothed, _)] = courses;
        /// An overshoot that is worth a filter of the target.
        const OVERSHOOT: f64 = 0.05;
        let steps = [
            Some(step),
            (step.overshoot > OVERSHOOT && smoothing > 0.0).then_some(smoothed),
        ];
        let distance = firmware.velocity_limit.map(|(limit, name)| {
            format!(
                "The loop is linear only while |e| is below {name} over Kx: {:.3} rad with the default.",
                limit / gains[0]
            )
        });
        let TuningSettings {
            step: size,
            command,
            ..
        } = tuned.settings;
        let most = response
            .iter()
            .fold(0.0_f64, |most, sample| most.max(sample[2].abs()));
        let share = most * size / command;
        let saturates = (share > 1.0).then(|| {
            format!(
                "A step of {size} rad at once asks for {share:.1} times the largest command: there the promise does not hold. \
                 Send smaller or smoothed steps."
            )
        });
        let ServoParameters {
            b, coulomb, load, ..
        } = tuned.servo.parameters;
        let offset = (firmware.law == Law::Proportional).then(|| {
            let left = (coulomb + load.abs()) / (b * gains[0]);
            format!("Without an integral, friction and load leave up to {left:.4} rad.")
        });
        let fixed = firmware.remarks.iter().map(|remark| (*remark).to_owned());
        FormResult {
            name: firmware.name,
            firmware: firmware.title,
            parameters,
            exactness,
            sample_time: firmware_loop.sample_time,
            margins,
            steps: steps.into_iter().flatten().collect(),
            remarks: [assumption.clone(), distance, saturates, offset]
                .into_iter()
                .flatten()
                .chain(fixed)
                .collect(),
            response,
            sensitivity: firmware_loop.sensitivity(&servo, bandwidth),
        }
    }
}

/// The parameters as they are stored, with their loop and its margins.
struct Stored {
    parameters: Vec<FormParameter>,
    exactness: &'static str,
    firmware_loop: FirmwareLoop,
    margins: FormMargins,
}

impl Law {
    /// The gains of a tuning, SI, and whether they are the same loop. A cascade has real gains up to ki = kp²/4kd.
    fn gains(self, tuning: &Tuning, share: f64) -> ([f64; 3], &'static str) {
        let Tuning { kp, ki, kd, .. } = *tuning;
        match self {
            Self::Pid | Self::PidOnError => ([kp, ki, kd], "exact"),
            Self::Proportional => ([share * kp, 0.0, 0.0], "P only"),
            Self::Cascade => {
                let root = kp * kp - 4.0 * kd * ki;
                // The larger root: the integral of the speed is then slow.
                let position = (kp + root.max(0.0).sqrt()) / (2.0 * kd);
                let exactness = if root < 0.0 { "needs ki cut" } else { "exact" };
                ([position, kd, kp - kd * position], exactness)
            }
        }
    }

    /// Time constant of a filter of the target that takes away the zero of the integral, s, as the design has it.
    fn smoothing(self, gains: &[f64; 3]) -> f64 {
        /// Over that of the zero.
        const FACTOR: f64 = 1.5;
        let [first, second, third] = *gains;
        match self {
            Self::Proportional => 0.0,
            Self::Pid | Self::PidOnError => FACTOR * first / second,
            Self::Cascade => FACTOR * second / third,
        }
    }
}

impl Takes {
    /// Its name in a sentence.
    fn named(self) -> &'static str {
        match self {
            Self::Same => "the command of the result",
            Self::Torque => "a torque in Nm",
            Self::ShareOfCurrent => "a share of the largest current",
            Self::Voltage => "a voltage in V",
            Self::ShareOfVoltage => "a share of the supply voltage",
            Self::Acceleration => "an acceleration",
        }
    }
}

/// The identified servo and the corners of its uncertainty along a, b and the delay, as the tuner takes them of a result,
/// with a delay besides, s.
fn corners(servo: &IdentifiedServo, further: f64) -> Vec<PossibleServo> {
    /// Standard errors to each side.
    const SIDES: f64 = 3.0;
    let of = |place: usize, side: f64| {
        let off = |own: usize| {
            if own == place {
                side * SIDES * servo.standard_error(own)
            } else {
                0.0
            }
        };
        PossibleServo {
            a: (servo.parameters.a + off(IdentifiedServo::A)).max(0.0),
            b: servo.parameters.b + off(IdentifiedServo::B),
            delay: (servo.delay + off(IdentifiedServo::DELAY)).max(0.0) + further,
        }
    };
    let places = [
        IdentifiedServo::A,
        IdentifiedServo::B,
        IdentifiedServo::DELAY,
    ];
    let others = places
        .into_iter()
        .flat_map(|place| [-1.0, 1.0].map(|side| of(place, side)));
    std::iter::once(of(IdentifiedServo::A, 0.0))
        .chain(others)
        .collect()
}

impl FromStr for Form {
    /// All names.
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = FIRMWARES.iter().find(|firmware| firmware.name == name);
        found
            .map(Self)
            .ok_or_else(|| format!("one of {}", Self::names()))
    }
}

impl PartialEq for Form {
    fn eq(&self, other: &Self) -> bool {
        self.0.name == other.0.name
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.name)
    }
}

impl fmt::Debug for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}
