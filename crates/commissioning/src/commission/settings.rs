use super::governor::Governor;
use super::{CommissionError, Limits, noise};
use crate::watch::{Use, WatchSettings};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::tuning::{Goal, Tuner, TuningSettings};

/// Settings of a commissioning, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CommissionSettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of a count, rad.
    pub resolution: f64,
    /// Limits of the axis.
    pub limits: Limits,
    /// The known part of the delay from the reading of the encoder to the change of the output, s. The rest is
    /// identified.
    pub command_delay: f64,
    /// The largest b that the servo may have, rad/s² per command unit, if it is stated. The first motion is then
    /// planned for it.
    pub max_gain: Option<f64>,
    /// Standard deviation of the encoder's noise beside the rounding of a count, rad; 0 for none. Motion is then judged
    /// in units of the noise, as with a coarser encoder. The gains are accordingly slower.
    pub noise: f64,
    /// The goal of the gains.
    pub goal: Goal,
    /// The largest sensitivity Mₛ, above 1.
    pub max_sensitivity: f64,
    /// The step of the trial, rad. None is the largest within a quarter of the travel, the speed and half of the
    /// command.
    pub trial_step: Option<f64>,
    /// True if the gains may have a notch filter, which a controller in fixed point has not.
    pub notch: bool,
    /// True to use a reference model with feed-forward if the step then rises faster
    /// ([`TuningSettings::feed_forward`]). A controller in fixed point has none.
    pub feed_forward: bool,
}

impl CommissionSettings {
    /// For the stiffest gains, without further knowledge of the servo.
    #[must_use]
    pub const fn new(sample_time: f64, resolution: f64, limits: Limits) -> Self {
        Self {
            sample_time,
            resolution,
            limits,
            command_delay: 0.0,
            max_gain: None,
            noise: 0.0,
            goal: Goal::Stiffest,
            max_sensitivity: TuningSettings::MAX_SENSITIVITY,
            trial_step: None,
            notch: true,
            feed_forward: false,
        }
    }

    /// The range of possible sensitivities. Below the first no delay is permitted; beyond the second there are no gains.
    pub const SENSITIVITIES: (f64, f64) = (1.1, TuningSettings::SENSITIVITIES.1);

    /// The longest declared delay, s and samples. With a longer one monitoring and fit cannot distinguish a late servo
    /// from a reversed, a dead or a compliant one.
    const MAX_COMMAND_DELAY: (f64, f64) = (0.015, 16.0);

    /// The same for positions in units of the noise. The travel keeps the distance from its ends that the noise hides.
    pub(super) fn in_units_of_noise(&self) -> Self {
        let resolution = noise::unit(self.noise / self.resolution) * self.resolution;
        let hidden = if resolution > self.resolution {
            2.0 * resolution
        } else {
            0.0
        };
        let [low, high] = self.limits.travel;
        let travel = [(low + hidden).min(0.0), (high - hidden).max(0.0)];
        Self {
            resolution,
            limits: Limits {
                travel,
                ..self.limits
            },
            ..*self
        }
    }

    /// Settings of the tuner for a largest command, command units, and a step, rad. Whatever delay there is was identified.
    #[must_use]
    pub fn tuning(&self, command: f64, step: f64) -> TuningSettings {
        TuningSettings {
            noise: self.noise,
            goal: self.goal,
            max_sensitivity: self.max_sensitivity,
            notch: self.notch,
            feed_forward: self.feed_forward,
            ..TuningSettings::new(self.sample_time, self.resolution, command, step)
        }
    }

    /// Settings of the watch.
    pub(super) fn watch(&self) -> WatchSettings {
        WatchSettings {
            used_for: Use::Commissioning,
            sample_time: self.sample_time,
            resolution: self.resolution,
            travel: self.limits.travel,
            speed: self.limits.speed,
            command: self.limits.command,
        }
    }

    /// # Errors
    /// The setting that is not allowed.
    pub(super) fn check(&self) -> Result<(), CommissionError> {
        self.limits.check()?;
        let (least, most) = Self::SENSITIVITIES;
        Allowed::Within(least, most).check("max_sensitivity", self.max_sensitivity)?;
        let (longest, samples) = Self::MAX_COMMAND_DELAY;
        let longest = longest.min(samples * self.sample_time);
        Allowed::Within(0.0, longest).check("command_delay", self.command_delay)?;
        Allowed::AtLeast(0.0).check("noise", self.noise)?;
        if let Some(gain) = self.max_gain {
            Allowed::Above(0.0).check("max_gain", gain)?;
        }
        if let Some(step) = self.trial_step {
            let [low, high] = self.limits.travel;
            // It overshoots.
            let room = 0.7 * high.max(-low);
            Allowed::PositiveUpTo(room).check("trial_step", step)?;
        }
        let bandwidth = match self.goal {
            Goal::ResponseTime(time) => {
                Tuner::RISE / Allowed::Above(0.0).check("response_time", time)?
            }
            Goal::Bandwidth(omega) => Allowed::Above(0.0).check("bandwidth", omega)?,
            Goal::Stiffest => return Ok(()),
        };
        self.can_be_sampled(bandwidth)
    }

    /// Checks that a command that holds the axis now leaves enough for its motions.
    ///
    /// # Errors
    /// The limit of the command of which it is more than 0.8, with the least that would do.
    pub fn check_held(&self, held: f64) -> Result<(), CommissionError> {
        let [low, high] = self.limits.command;
        let needed = held / Governor::<f64>::HOLDS;
        Allowed::AtMost(needed.min(0.0)).check("command", low)?;
        Allowed::AtLeast(needed.max(0.0)).check("command", high)?;
        Ok(())
    }

    /// # Errors
    /// [`CommissionError::TooFast`] for a bandwidth that no servo tolerates at this sample time and delay. It names one
    /// that a servo without a delay of its own tolerates.
    fn can_be_sampled(&self, bandwidth: f64) -> Result<(), CommissionError> {
        /// The largest ω T that the tuner takes for a loop at all.
        const FASTEST: f64 = 0.5;
        /// ω times hold and delay that a servo without friction tolerates with Mₛ = 1.6.
        const BORNE: f64 = 0.085;
        if bandwidth <= FASTEST / (self.sample_time + self.command_delay) {
            return Ok(());
        }
        let (least, _) = Self::SENSITIVITIES;
        let asked = (self.max_sensitivity - least) / (TuningSettings::MAX_SENSITIVITY - least);
        let late = 0.5 * self.sample_time + self.command_delay;
        Err(CommissionError::TooFast {
            bandwidth,
            most: BORNE * asked.clamp(0.02, 1.0) / late,
        })
    }
}

impl Limits {
    /// The longest that a motion takes where nothing else is asked for, s.
    pub const DURATION: f64 = 1.0;

    /// Lowest and highest position, speed, lowest and highest command.
    #[must_use]
    pub const fn new(travel: [f64; 2], speed: f64, command: [f64; 2]) -> Self {
        Self {
            travel,
            speed,
            command,
            duration: Self::DURATION,
        }
    }

    /// # Errors
    /// The limit that is not allowed, or that contradicts another.
    pub fn check(&self) -> Result<(), OutOfRange> {
        let [low, high] = self.travel;
        let [least, most] = self.command;
        for (setting, value, allowed) in [
            ("travel", low, Allowed::AtMost(0.0)),
            ("travel", high, Allowed::AtLeast(0.0)),
            ("travel", high, Allowed::Above(low)),
            ("speed", self.speed, Allowed::Above(0.0)),
            ("command", least, Allowed::Below(0.0)),
            ("command", most, Allowed::Above(0.0)),
            ("duration", self.duration, Allowed::Above(0.0)),
        ] {
            allowed.check(setting, value)?;
        }
        Ok(())
    }
}
