//! Gains in the form of a drive's firmware.
//!
//! A [`Form`] is a row of the table of firmwares. Its rate, filter and delay enter the conditions of the design. The
//! gains become its parameters, rounded to the stored form. Margins and step are computed from the stored values.

mod firmware;
mod firmware_loop;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use identifier_core::tuning::{Cap, Goal, PredictedResponse, Tuning, TuningSettings};

pub use self::firmware::Form;
use self::firmware::{Estimator, Of, Share};
use self::firmware_loop::FirmwareLoop;
use super::{Conditions, IdentifiedResult, KnownConditions, NoGains, Tuned};
use crate::motion_unit::AxisKind;
use crate::result::{FormParameter, FormResult};
use crate::scenario::CommandUnit;

/// The output of a firmware.
#[derive(Debug, Clone, Copy)]
struct Output {
    /// Of it for a unit of the log's command.
    scale: f64,
    /// Its unit.
    unit: &'static str,
}

impl Form {
    /// Takes rate, filter and delay of the firmware into the settings of a tuning.
    pub(super) fn prepare(self, settings: &mut TuningSettings, stated: &Conditions) {
        let time = stated.sample_time.or(self.0.sample_time);
        settings.sample_time = time.unwrap_or(settings.sample_time);
        settings.command_delay += self.0.delay * settings.sample_time;
        let frequency = stated.cutoff.or(self.0.cutoff);
        settings.cutoff = frequency.map(|of| self.0.filter.of(of, settings.sample_time).1);
        // None has a reference model or a notch.
        (settings.feed_forward, settings.notch) = (false, false);
    }

    /// Gains for a result with their form. If the firmware's own loop has less than the margins, or another response
    /// time than the goal, another bandwidth is designed.
    ///
    /// # Errors
    /// As [`Tuned::new`], or why the gains do not get the form.
    pub(super) fn tune(
        self,
        result: &IdentifiedResult,
        known: &KnownConditions,
        stated: &Conditions,
        settings: &TuningSettings,
    ) -> Result<Tuned, NoGains> {
        /// Part of the bandwidth that the next attempt has, and attempts.
        const SLOWER: f64 = 0.97;
        const ATTEMPTS: usize = 150;
        /// Tolerance of the response time, to which searches meet it.
        const TIME_TOLERANCE: f64 = 0.02;
        let output = self.output(known, stated, result);
        let output = output.map_err(NoGains::Form)?;
        let (frequency, time) = (stated.cutoff.or(self.0.cutoff), settings.sample_time);
        let (name, most) = (&self.0.name, 0.5 / time);
        // A phase-locked loop corrects by more than its error there.
        if self.0.filter.of(frequency.unwrap_or(0.0), time).0[0] > 1.0 {
            return Err(NoGains::Form(format!(
                "the filter of {name} is stable up to --cutoff {most:.1} (rad/s) at --sample-time {time} (s): reduce \
                 either"
            )));
        }
        let (mut settings, goal, mut slower) = (*settings, settings.goal, None);
        for _ in 0..ATTEMPTS {
            let found = Tuned::new(result, known.angle.as_ref(), &settings);
            if slower.is_some() && found.is_err() {
                break;
            }
            let mut tuned = found?;
            let most = tuned.tuning.bandwidth;
            let (form, cap) = self.stored(&tuned, stated, output)?;
            let rise_time = form.steps.last().and_then(|step| step.rise_time);
            let longer = match (goal, rise_time) {
                (Goal::ResponseTime(asked), Some(took)) => took / asked,
                _ => 1.0,
            };
            let cap = cap.or(rise_time.is_none().then_some(Cap::Delay));
            let next = if cap.is_some() {
                slower = cap;
                SLOWER
            } else if let Some(cap) = slower.filter(|_| goal != Goal::Stiffest) {
                return Err(NoGains::TooFast {
                    cap,
                    most,
                    rise_time,
                });
            } else if (longer - 1.0).abs() > TIME_TOLERANCE {
                longer
            } else {
                tuned.tuning.cap = slower.or(tuned.tuning.cap);
                tuned.form = Some(form);
                return Ok(tuned);
            };
            settings.goal = Goal::Bandwidth(next * most);
        }
        Err(NoGains::Form(format!(
            "{name} has no gains within the margins: this servo has too little friction for it, or a resonance that it does not \
             hold; choose another form"
        )))
    }

    /// The output of the firmware for a command of the result, or the reason why there is none.
    fn output(
        self,
        known: &KnownConditions,
        stated: &Conditions,
        result: &IdentifiedResult,
    ) -> Result<Output, String> {
        let name = &self.0.name;
        if result.axis == AxisKind::Linear && self.0.angle.is_some() {
            return Err(format!(
                "{name} is for a rotary axis, but the result is in m: choose pid, cascade or linuxcnc"
            ));
        }
        let needed = |option: &str, value: Option<f64>, example: &str| {
            let allowed = value.filter(|value| *value > 0.0 && value.is_finite());
            allowed.ok_or_else(|| {
                format!("{name} needs {option} for its command, a number above 0: for example {option} {example}")
            })
        };
        let of_reading = result.reading.as_ref().and_then(CommandUnit::of_reading);
        let unit = [stated.command_unit, of_reading, known.command_unit];
        let mut unit = unit.into_iter().flatten();
        let unit = unit.find(|unit| *unit != CommandUnit::Other);
        let unit = unit.map(CommandUnit::name);
        let torque = stated.torque_constant.or(known.torque_constant);
        let own = self.0.command.as_deref().or(unit);
        let of_unit = match (&self.0.command, unit) {
            (Some(own), Some(unit)) if own == unit => 1.0,
            (Some(own), Some("A")) if own == "Nm" => needed("--torque-constant", torque, "0.1")?,
            (Some(own), None) if own == "Nm" && torque.is_some() => {
                needed("--torque-constant", torque, "0.1")?
            }
            (Some(own), Some(unit)) => {
                return Err(format!(
                    "{name} takes a command in {own}, but the log has one in {unit}: identify with the drive's own \
                     command"
                ));
            }
            (Some(own), None) => {
                return Err(format!(
                    "{name} takes a command in {own}, and nothing states the unit of the log's: state it with \
                     --command-unit {own} if it is that"
                ));
            }
            (None, _) => 1.0,
        };
        let whole = match self.0.share_of {
            Some(Share::MaxCurrent) => needed("--max-current", stated.max_current, "60")?,
            Some(Share::BusVoltage) => needed("--bus-voltage", stated.bus_voltage, "12")?,
            Some(Share::Acceleration) => TAU / result.model.servo.parameters.b,
            None => 1.0,
        };
        Ok(Output {
            scale: of_unit / whole,
            unit: own.unwrap_or("command"),
        })
    }

    /// The gains of a tuning as the firmware stores them, with what their loop does, and what forbids them.
    fn stored(
        self,
        tuned: &Tuned,
        stated: &Conditions,
        output: Output,
    ) -> Result<(FormResult, Option<Cap>), NoGains> {
        /// The overshoot from which a filter of the target is suggested, and its time constant over that of the
        /// integral's zero.
        const OVERSHOOT: f64 = 0.05;
        const SMOOTHING: f64 = 1.5;
        let (firmware, settings, tuning) = (self.0, &tuned.settings, &tuned.tuning);
        let (exactness, parameters, firmware_loop) = self.run(tuned, stated, output);
        let gains = firmware_loop.gains;
        let tuner = tuned.tuner().map_err(NoGains::Error)?;
        let servos = tuner.possible_servos();
        let until = PredictedResponse::MAX_TIME / tuning.bandwidth;
        let step = |smoothing| firmware_loop.step(&servos[0], [settings.step, smoothing, until]);
        let (at_once, mut response) = step(0.0);
        let mut steps = vec![at_once];
        let [first, second, third] = gains;
        let zero = second / third;
        let limited = response.iter().map(|sample| sample.command.abs());
        let is_limited = limited.fold(0.0, f64::max) >= settings.command;
        if at_once.overshoot > OVERSHOOT && zero.is_finite() {
            let (smoothed, samples) = step(SMOOTHING * zero);
            steps.push(smoothed);
            response = samples;
        }
        let servo = tuned.model.servo.parameters;
        let margins = firmware_loop.margins(
            tuner.sampled_servos(),
            [tuning.bandwidth, settings.max_sensitivity],
            tuned.model.resonance.is_some(),
        );
        let bears = tuner.bears_hidden(tuned.model.shown(), |nu| firmware_loop.controller(nu));
        let cap = match (margins.1, bears) {
            (true, true) => None,
            (true, false) => Some(Cap::UnseenResonance),
            (false, _) if tuned.model.resonance.is_some() => Some(Cap::Resonance),
            (false, _) => Some(Cap::Delay),
        };
        let mut remarks = Vec::new();
        if let Some(limit) = firmware.velocity_limit {
            let within = limit / first;
            remarks.push(format!("The loop is linear only while |e| is below velocity limit/Kx: {within:.3} rad with the default limit of {limit:.4} rad/s."));
        }
        if is_limited {
            remarks.push(format!(
                "A step of {} rad reaches the largest command: send smoothed targets.",
                settings.step
            ));
        }
        if let Some(source) = &firmware.source {
            remarks.push(format!("Its loop was read from {source}."));
        } else if firmware.command.is_some() {
            remarks.push(
                "Its loop is that of its manual: the firmware itself was not read.".to_owned(),
            );
        }
        if firmware.law == Estimator::Proportional {
            let left = (servo.coulomb + servo.load.abs()) / (servo.b * second);
            remarks.push(format!(
                "There is no integral: friction and load leave up to {left:.4} rad."
            ));
        }
        remarks.extend(firmware.remarks.iter().cloned());
        let form = FormResult {
            name: &firmware.name,
            firmware: &firmware.title,
            parameters,
            exactness,
            sample_time: settings.sample_time,
            margins: margins.0,
            steps,
            first_trial: Vec::new(),
            remarks,
            response,
        };
        Ok((form, cap))
    }

    /// The exactness of the form, the stored parameters, and the loop that runs with them.
    fn run(
        self,
        tuned: &Tuned,
        stated: &Conditions,
        output: Output,
    ) -> (&'static str, Vec<FormParameter>, FirmwareLoop) {
        let firmware = self.0;
        let frequency = stated
            .cutoff
            .or(firmware.cutoff)
            .unwrap_or(tuned.tuning.cutoff);
        let (exactness, parameters, gains) = self.parameters(tuned, frequency, output);
        let sample_time = tuned.settings.sample_time;
        let firmware_loop = FirmwareLoop {
            firmware,
            sample_time,
            filter: firmware.filter.of(frequency, sample_time).0,
            gains,
            limit: tuned.settings.command,
        };
        (exactness, parameters, firmware_loop)
    }

    /// The exactness of the form, the stored parameters, and the gains that they represent, SI.
    fn parameters(
        self,
        tuned: &Tuned,
        frequency: f64,
        Output { scale, unit }: Output,
    ) -> (&'static str, Vec<FormParameter>, [f64; 3]) {
        let (firmware, settings) = (self.0, &tuned.settings);
        let servo = tuned.model.servo.parameters;
        let (exactness, mut gains) = firmware.law.gains(&tuned.tuning);
        let per_angle = scale * firmware.angle.unwrap_or(1.0);
        let mut scales = [per_angle; 3];
        if firmware.law == Estimator::Cascade {
            scales[0] = 1.0;
        }
        let mut parameters = Vec::new();
        for parameter in &firmware.parameters {
            let place = parameter.of as usize;
            let value = match parameter.of {
                Of::First | Of::Second | Of::Third => gains[place] * scales[place],
                Of::ResetTime => gains[1] / gains[2],
                Of::Cutoff => frequency,
                Of::TimeConstant => 1.0 / frequency,
                Of::NewestShare => -(-frequency * settings.sample_time).exp_m1(),
                Of::Acceleration => per_angle / servo.b,
                Of::Velocity => per_angle * servo.a / servo.b,
                Of::Friction => scale * servo.coulomb / servo.b,
                Of::Limit => scale * (settings.command + (servo.load / servo.b).abs()),
            };
            let factor = parameter.factor.unwrap_or(1.0);
            let value = (factor * value).min(parameter.most.unwrap_or(f64::INFINITY));
            let digits = match parameter.places {
                Some(places) => format!("{value:.places$}"),
                None => format!("{value:.5e}"),
            };
            let value = digits.parse().unwrap_or(value);
            match parameter.of {
                Of::ResetTime => gains[2] = gains[1] * factor / value,
                _ if place < gains.len() => gains[place] = value / (factor * scales[place]),
                _ => {}
            }
            parameters.push(FormParameter {
                name: &parameter.name,
                value,
                unit: parameter.unit.replace('$', unit),
            });
        }
        // No limit is no number to state.
        parameters.retain(|parameter| parameter.value.is_finite());
        (exactness, parameters, gains)
    }
}

impl Estimator {
    /// Whether the gains of a tuning are the same loop, and they, SI. A cascade has real gains up to ki = kp²/4kd.
    fn gains(self, tuning: &Tuning) -> (&'static str, [f64; 3]) {
        let Tuning { kp, ki, kd, .. } = *tuning;
        let root = kp * kp - 4.0 * kd * ki;
        // The larger of two that both fit: the integral of the speed is then slow.
        let position = (kp + root.max(0.0).sqrt()) / (2.0 * kd);
        match self {
            Self::Pid | Self::PidOnError => ("exact", [kd, kp, ki]),
            Self::Proportional => ("P only", [0.0, kp, 0.0]),
            Self::Cascade if root < 0.0 => ("needs ki cut", [position, kd, kp - kd * position]),
            Self::Cascade => ("exact", [position, kd, kp - kd * position]),
        }
    }
}
