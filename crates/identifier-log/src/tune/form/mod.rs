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

impl Form {
    /// Takes rate, filter and delay of the firmware into the settings of a tuning.
    pub(super) fn prepare(self, settings: &mut TuningSettings, stated: &Conditions) {
        let time = stated.sample_time.or(self.0.sample_time);
        settings.sample_time = time.unwrap_or(settings.sample_time);
        settings.command_delay += self.0.delay * settings.sample_time;
        let frequency = stated.cutoff.or(self.0.cutoff);
        settings.cutoff = frequency.map(|of| self.0.filter.of(of, settings.sample_time).1);
        settings.feed_forward = false;
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
        /// Tolerances of the largest sensitivity and of the response time, to which searches meet them.
        const TOLERANCE: f64 = 1.005;
        const TIME_TOLERANCE: f64 = 0.02;
        let scale = self.scale(known, stated, result);
        let (scale, assumption) = scale.map_err(NoGains::Form)?;
        let (frequency, time) = (stated.cutoff.or(self.0.cutoff), settings.sample_time);
        let (name, most) = (&self.0.name, 0.5 / time);
        // A phase-locked loop corrects by more than its error there.
        if self.0.filter.of(frequency.unwrap_or(0.0), time).0[0] > 1.0 {
            return Err(NoGains::Form(format!(
                "the filter of {name} is stable up to --cutoff {most:.1} (rad/s) at --sample-time {time} (s): reduce \
                 either"
            )));
        }
        let (mut settings, goal, mut is_slower) = (*settings, settings.goal, false);
        for _ in 0..ATTEMPTS {
            let found = Tuned::new(result, known.angle.as_ref(), &settings);
            if is_slower && found.is_err() {
                break;
            }
            let mut tuned = found?;
            let most = tuned.tuning.bandwidth;
            let mut form = self.stored(&tuned, stated, scale)?;
            let rise_time = form.steps.last().and_then(|step| step.rise_time);
            let longer = match (goal, rise_time) {
                (Goal::ResponseTime(asked), Some(took)) => took / asked,
                _ => 1.0,
            };
            let keeps = form.margins.sensitivity <= TOLERANCE * settings.max_sensitivity;
            let next = if !keeps || rise_time.is_none() {
                is_slower = true;
                SLOWER
            } else if is_slower && goal != Goal::Stiffest {
                return Err(NoGains::TooFast {
                    cap: Cap::Delay,
                    most,
                    rise_time,
                });
            } else if (longer - 1.0).abs() > TIME_TOLERANCE {
                longer
            } else {
                form.remarks.splice(0..0, assumption);
                tuned.tuning.cap = is_slower.then_some(Cap::Delay).or(tuned.tuning.cap);
                tuned.form = Some(form);
                return Ok(tuned);
            };
            settings.goal = Goal::Bandwidth(next * most);
        }
        Err(NoGains::Form(format!(
            "{name} has no gains within the margins: this servo has too little friction for it; choose another form"
        )))
    }

    /// The output of the firmware for a command of the result, and the assumptions behind it. Otherwise the reason why
    /// there is none.
    fn scale(
        self,
        known: &KnownConditions,
        stated: &Conditions,
        result: &IdentifiedResult,
    ) -> Result<(f64, Option<String>), String> {
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
        let torque = stated.torque_constant.or(known.torque_constant);
        let unit = known
            .command_unit
            .filter(|unit| *unit != CommandUnit::Other);
        let of_unit = match (self.0.command.as_deref(), unit.map(CommandUnit::name)) {
            (Some("Nm"), None) if torque.is_none() => 1.0,
            (Some("Nm"), Some("A") | None) => needed("--torque-constant", torque, "0.1")?,
            (Some(own), Some(unit)) if own != unit => {
                return Err(format!(
                    "{name} takes a command in {own}, but the log has one in {unit}: identify with the drive's own \
                     command"
                ));
            }
            _ => 1.0,
        };
        let whole = match self.0.share_of {
            Some(Share::MaxCurrent) => needed("--max-current", stated.max_current, "60")?,
            Some(Share::BusVoltage) => needed("--bus-voltage", stated.bus_voltage, "12")?,
            Some(Share::Acceleration) => TAU / result.servo.parameters.b,
            None => 1.0,
        };
        let is_assumed = unit.is_none() && torque.is_none();
        let assumption = self.0.command.as_ref().filter(|_| is_assumed).map(|own| {
            format!("The command of the log is assumed to be in {own}: state it with `identify --command-unit`.")
        });
        Ok((of_unit / whole, assumption))
    }

    /// The gains of a tuning as the firmware stores them, with what their loop does.
    fn stored(self, tuned: &Tuned, stated: &Conditions, scale: f64) -> Result<FormResult, NoGains> {
        /// The overshoot from which a filter of the target is suggested, and its time constant over that of the
        /// integral's zero.
        const OVERSHOOT: f64 = 0.05;
        const SMOOTHING: f64 = 1.5;
        let (firmware, settings, tuning) = (self.0, &tuned.settings, &tuned.tuning);
        let frequency = stated.cutoff.or(firmware.cutoff).unwrap_or(tuning.cutoff);
        let (exactness, parameters, gains) = self.parameters(tuned, frequency, scale);
        let sample_time = settings.sample_time;
        let (filter, _) = firmware.filter.of(frequency, sample_time);
        let firmware_loop = FirmwareLoop {
            firmware,
            sample_time,
            filter,
            gains,
        };
        let tuner = tuned.tuner().map_err(NoGains::Error)?;
        let servos = tuner.possible_servos();
        let until = PredictedResponse::MAX_TIME / tuning.bandwidth;
        let step = |smoothing| firmware_loop.step(&servos[0], [settings.step, smoothing, until]);
        let (at_once, mut response) = step(0.0);
        let mut steps = vec![at_once];
        let [first, second, third] = gains;
        let zero = second / third;
        let commands = response.iter().map(|sample| sample.command.abs());
        let share = commands.fold(0.0, f64::max) / settings.command;
        if at_once.overshoot > OVERSHOOT && zero.is_finite() {
            let (smoothed, samples) = step(SMOOTHING * zero);
            steps.push(smoothed);
            response = samples;
        }
        let servo = tuned.servo.parameters;
        let mut remarks = Vec::new();
        if let Some(limit) = firmware.velocity_limit {
            let within = limit / first;
            remarks.push(format!("The loop is linear only while |e| is below velocity limit/Kx: {within:.3} rad with the default limit of {limit:.4} rad/s."));
        }
        if share > 1.0 {
            remarks.push(format!(
                "A step of {} rad needs {share:.1} times the largest command, so it is slower than \
                                  predicted: send smoothed targets.",
                settings.step
            ));
        }
        if firmware.law == Estimator::Proportional {
            let left = (servo.coulomb + servo.load.abs()) / (servo.b * second);
            remarks.push(format!(
                "There is no integral: friction and load leave up to {left:.4} rad."
            ));
        }
        remarks.extend(firmware.remarks.iter().cloned());
        Ok(FormResult {
            name: &firmware.name,
            firmware: &firmware.title,
            parameters,
            exactness,
            sample_time,
            margins: firmware_loop.margins(servos, tuning.bandwidth),
            steps,
            remarks,
            response,
        })
    }

    /// The exactness of the form, the stored parameters, and the gains that they represent, SI.
    fn parameters(
        self,
        tuned: &Tuned,
        frequency: f64,
        scale: f64,
    ) -> (&'static str, Vec<FormParameter>, [f64; 3]) {
        let (firmware, settings) = (self.0, &tuned.settings);
        let servo = tuned.servo.parameters;
        let (exactness, mut gains) = firmware.law.gains(&tuned.tuning);
        let per_angle = scale * firmware.angle.unwrap_or(1.0);
        let mut scales = [per_angle; 3];
        if firmware.law == Estimator::Cascade {
            scales[0] = 1.0;
        }
        let own = firmware.command.as_deref().unwrap_or("command");
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
                unit: parameter.unit.replace('$', own),
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
