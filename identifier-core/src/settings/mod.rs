//! The settings that every part is built from: plain numbers in SI, and one fallible
//! [`Settings::build`].
//!
//! This module is above all others of the core. It uses every part below, and none of them knows the settings.

mod amplifier;
mod automatic_gamma;
mod controller;
mod error;
mod fitting;
mod full_scales;
mod gauss_newton;
mod gradient;
mod identifier;
mod parameter_range;
mod servo_loop;
mod terms;

pub use error::{GainError, SettingsError};
pub use identifier::{IdentifierSettings, ParameterRangeSettings, RangeSettings, TermSettings};

use crate::control::{
    CommandLimit, FeedForward, FeedForwardSettings, Gains, Notch, ReferenceFilter, Shaped,
};
use crate::error::{Allowed, OutOfRange};
use crate::fit::QUANTISATION_VARIANCE;
use crate::measurement::velocity::{Transfer, VelocityEstimate};
use crate::number::Arithmetic;
use crate::tuning::Tuning;
use crate::units::Units;

/// The settings of a loop and its identifier, SI. For a linear axis read m for rad.
///
/// Optional settings have a default that is stated with them. [`Settings::new`] fills all of them in,
/// so that a configuration names only the differences.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of one count, rad: 2π over the counts of a revolution after fourfold evaluation.
    pub resolution: f64,
    /// Cut-off of a [`LowPass`](crate::measurement::velocity::LowPass) velocity estimate, rad/s; other
    /// estimates have none.
    pub cutoff: f64,
    /// The PID that closes the loop; none if another controller does and the identifier only listens.
    pub controller: Option<ControllerSettings>,
    /// The identifier.
    pub identifier: IdentifierSettings,
}

/// The PID (3) and its limit, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ControllerSettings {
    /// Proportional gain, command units per rad.
    pub kp: f64,
    /// Derivative gain on the measured velocity, command units per rad/s.
    pub kd: f64,
    /// Integral gain, command units per rad s.
    pub ki: f64,
    /// Lowest and highest command, command units; infinite for none.
    pub limit: [f64; 2],
    /// Time constant of the `ReferenceFilter`, s; zero for none.
    pub reference_filter: f64,
    /// Frequency of the `Notch`, rad/s; zero for none.
    pub notch: f64,
    /// The `FeedForward` behind that filter; none if the PID gets the reference unchanged.
    pub feed_forward: Option<FeedForwardSettings>,
}

/// A part that [`Settings::build`] can build.
pub trait FromSettings: Sized {
    /// Builds it.
    ///
    /// # Errors
    /// The setting that is not allowed, by name, and the allowed range.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError>;
}

impl ControllerSettings {
    /// A PID without a limit, without a filter of the reference and without feed-forward.
    #[must_use]
    pub fn pid(kp: f64, kd: f64, ki: f64) -> Self {
        Self {
            kp,
            kd,
            ki,
            limit: [f64::NEG_INFINITY, f64::INFINITY],
            reference_filter: 0.0,
            notch: 0.0,
            feed_forward: None,
        }
    }

    /// The PID that was tuned, with the lowest and highest command, command units; infinite for none.
    #[must_use]
    pub fn tuned(tuning: &Tuning, limit: [f64; 2]) -> Self {
        Self {
            kp: tuning.kp,
            kd: tuning.kd,
            ki: tuning.ki,
            limit,
            reference_filter: tuning.reference_filter,
            notch: tuning.notch,
            feed_forward: tuning.feed_forward,
        }
    }

    /// The same with |u| ≤ `limit`, command units.
    #[must_use]
    pub fn limited(self, limit: f64) -> Self {
        Self {
            limit: [-limit, limit],
            ..self
        }
    }

    /// The gains.
    ///
    /// # Errors
    /// See [`Gains::new`].
    pub fn gains(&self) -> Result<Gains, OutOfRange> {
        Gains::new(self.kp, self.kd, self.ki)
    }

    /// The filter of the reference.
    ///
    /// # Errors
    /// See `ReferenceFilter::new`.
    pub fn reference_filter<N: Arithmetic>(
        &self,
        units: &Units,
    ) -> Result<ReferenceFilter<N>, OutOfRange> {
        ReferenceFilter::new(units, self.reference_filter)
    }

    /// The notch filter of the command.
    ///
    /// # Errors
    /// See `Notch::new`.
    pub fn notch<N: Arithmetic>(&self, units: &Units) -> Result<Notch<N>, OutOfRange> {
        Notch::new(units, self.notch)
    }

    /// The feed-forward, for the controller's estimate of the velocity.
    ///
    /// # Errors
    /// See `FeedForward::new`, and a gain out of its range.
    pub fn feed_forward<N: Arithmetic>(
        &self,
        units: &Units,
        velocity: &Transfer,
    ) -> Result<FeedForward<N>, OutOfRange> {
        match &self.feed_forward {
            Some(given) => FeedForward::new(units, given, &self.gains()?, velocity),
            None => Ok(FeedForward::default()),
        }
    }

    /// The first setting that asks for more than a PID, by name.
    #[must_use]
    pub fn shaping_setting(&self) -> Option<&'static str> {
        let given = [
            ("reference_filter", self.reference_filter != 0.0),
            ("notch", self.notch != 0.0),
            ("feed_forward", self.feed_forward.is_some()),
        ];
        let first = given.into_iter().find(|(_, is_given)| *is_given);
        first.map(|(setting, _)| setting)
    }

    /// All three, for the controller's estimate of the velocity.
    ///
    /// # Errors
    /// That of the first that is out of its range.
    pub fn shaping<N: Arithmetic>(
        &self,
        units: &Units,
        velocity: &Transfer,
    ) -> Result<Shaped<N>, OutOfRange> {
        Ok(Shaped::new(
            self.reference_filter(units)?,
            self.feed_forward(units, velocity)?,
            self.notch(units)?,
        ))
    }

    /// The limit.
    ///
    /// # Errors
    /// See [`CommandLimit::asymmetric`].
    pub fn command_limit(&self) -> Result<CommandLimit, OutOfRange> {
        CommandLimit::from_range(self.limit)
    }
}

impl Settings {
    /// The default cut-off of a low-pass velocity estimate over the sample rate: 500 rad/s at 1 kHz, as in the paper's
    /// experiment.
    const CUTOFF: f64 = 0.5;

    /// Settings for a sample time (s) and an encoder's counts per revolution after fourfold
    /// evaluation, nothing else stated.
    #[must_use]
    pub fn new(sample_time: f64, counts_per_revolution: f64) -> Self {
        Self {
            sample_time,
            resolution: core::f64::consts::TAU / counts_per_revolution,
            cutoff: Self::CUTOFF / sample_time,
            controller: None,
            identifier: IdentifierSettings::UNSTATED,
        }
    }

    /// The same with a PID and its largest command: see [`ControllerSettings`].
    #[must_use]
    pub fn with_pid(self, kp: f64, kd: f64, ki: f64, limit: f64) -> Self {
        Self {
            controller: Some(ControllerSettings::pid(kp, kd, ki).limited(limit)),
            ..self
        }
    }

    /// The same to be certified for every servo with a (1/s) and b (rad/s² per command unit) in these ranges.
    #[must_use]
    pub fn with_servo_range(mut self, a: [f64; 2], b: [f64; 2]) -> Self {
        self.identifier.parameter_range = Some(ParameterRangeSettings { a, b });
        self
    }

    /// Builds a part: a controller, an identifier, or a loop of both.
    ///
    /// # Errors
    /// The first setting that is not allowed, by name, and the allowed range.
    pub fn build<T: FromSettings>(&self) -> Result<T, SettingsError> {
        self.units()?;
        T::from_settings(self)
    }

    /// Sample time and position unit.
    ///
    /// # Errors
    /// `sample_time` or `resolution` out of range.
    pub fn units(&self) -> Result<Units, OutOfRange> {
        Units::new(self.sample_time, self.resolution).map_err(|error| OutOfRange {
            parameter: match error.parameter {
                "position_unit" => "resolution",
                other => other,
            },
            ..error
        })
    }

    /// The velocity estimate of the controller.
    ///
    /// # Errors
    /// `sample_time`, `resolution` or `cutoff` out of range.
    pub fn velocity<N: Arithmetic, V: VelocityEstimate<N>>(&self) -> Result<V, OutOfRange> {
        V::with_cutoff(&self.units()?, self.cutoff)
    }

    /// The controller.
    ///
    /// # Errors
    /// [`SettingsError::NotGiven`] if there is none.
    pub fn own_controller(&self) -> Result<&ControllerSettings, SettingsError> {
        self.controller.as_ref().ok_or(SettingsError::NotGiven {
            setting: "controller",
        })
    }

    /// The gains of the gradient's correction in command form: those stated, or the controller's. If the identifier
    /// listens to another controller, they follow from parameter range and bandwidth.
    ///
    /// # Errors
    /// A gain out of range; [`SettingsError::NotGiven`] if there is nothing that they follow from.
    pub fn correction_gains(&self) -> Result<Gains, SettingsError> {
        match (self.identifier.correction, self.controller) {
            (Some([kp, kd, ki]), _) => Ok(Gains::new(kp, kd, ki)?),
            (None, Some(controller)) => Ok(controller.gains()?),
            (None, None) => self.chosen_correction(),
        }
    }

    /// The gains for the servo in the middle of the parameter range: k_p = ω²/b, k_d = 2ω/b, k_i = k_p ω/20. Both fast
    /// poles of the error loop are at −ω. A slow one near −ω/20 is for the integral, which takes the load.
    fn chosen_correction(&self) -> Result<Gains, SettingsError> {
        /// Part of ω at which the integral acts.
        const INTEGRAL: f64 = 0.05;
        let Some(ParameterRangeSettings { b: [min, max], .. }) = self.identifier.parameter_range
        else {
            return Err(SettingsError::NotGiven {
                setting: "correction",
            });
        };
        let omega = self.bandwidth()?;
        let b = Allowed::Above(0.0).check("servo_range.b", libm::sqrt(min * max))?;
        let kp = omega * omega / b;
        Ok(Gains::new(kp, 2.0 * omega / b, INTEGRAL * omega * kp)?)
    }

    /// Bandwidth of the correction, rad/s: the one stated, or a twentieth of the sample rate. This is the usual ratio
    /// for position loops.
    pub(crate) fn bandwidth(&self) -> Result<f64, OutOfRange> {
        /// Part of the sample rate.
        const COMMON: f64 = 0.05;
        let most = 0.5 / self.sample_time;
        let stated = self.identifier.bandwidth;
        Allowed::PositiveUpTo(most).check("bandwidth", stated.unwrap_or(COMMON / self.sample_time))
    }

    /// The largest increment that is taken, machine units, at most `reach`.
    pub(crate) fn most_increment(&self, units: &Units, reach: f64) -> Result<f64, OutOfRange> {
        let Some(speed) = self.identifier.max_speed else {
            return Ok(reach);
        };
        let speed = Allowed::Above(0.0).check("max_speed", speed)?;
        // At least a count, the increment of the slowest motion.
        Ok((speed * units.velocity()).max(1.0).min(reach))
    }

    /// The variance of the position noise, counts²: at least an encoder's.
    pub(crate) fn noise_variance(&self, units: &Units) -> Result<f64, OutOfRange> {
        Ok(match self.identifier.noise {
            Some(noise) => {
                let counts = Allowed::PositiveUpTo(1e3).check("noise", noise)? * units.position();
                counts * counts
            }
            None => QUANTISATION_VARIANCE,
        })
    }

    /// The largest |u| that the controller's limit allows, command units.
    pub(crate) fn largest_command(&self) -> Option<f64> {
        let [low, high] = self.controller?.limit;
        let limit = high.max(-low);
        Allowed::Above(0.0).holds(limit).then_some(limit)
    }
}
