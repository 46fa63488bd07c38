use super::CommissionError;
use crate::tuning::Goal;

/// What a commissioning may do with the axis, SI. For a linear axis read m for rad.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Limits {
    /// Lowest and highest position, rad from where the servo stands when it begins: the first at most
    /// zero, the second at least zero.
    pub travel: [f64; 2],
    /// The largest speed, rad/s.
    pub speed: f64,
    /// Lowest and highest command, command units: the first below zero, the second above.
    pub command: [f64; 2],
    /// The longest time that a motion may take, s.
    pub duration: f64,
    /// Whether the servo may only move one way, the one in which there is travel.
    pub one_way: bool,
}

/// What a commissioning is told, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CommissionSettings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of a count, rad.
    pub resolution: f64,
    /// What it may do with the axis.
    pub limits: Limits,
    /// From the reading of the encoder to the change of the output, s, as far as it is known; what is
    /// not known is identified.
    pub command_delay: f64,
    /// The largest b that the servo may have, rad/s² per command unit, if that is known: the motion
    /// before anything is known is then planned for it.
    pub most_gain: Option<f64>,
    /// What is asked of the gains.
    pub goal: Goal,
    /// The largest sensitivity Mₛ, above 1.
    pub most_sensitivity: f64,
    /// The step of the trial, rad; none: half of the travel that there is.
    pub trial_step: Option<f64>,
}

impl Limits {
    /// # Errors
    /// The limit that is not allowed, or that contradicts another.
    pub fn check(&self) -> Result<(), CommissionError> {
        let [low, high] = self.travel;
        let [least, most] = self.command;
        let refuse = |setting, value, needed| {
            Err(CommissionError::OutOfRange {
                setting,
                value,
                needed,
            })
        };
        if !(low <= 0.0 && low.is_finite()) {
            return refuse("travel", low, 0.0);
        }
        if !(high >= 0.0 && high.is_finite() && high > low) {
            return refuse("travel", high, 0.0);
        }
        if !(self.speed > 0.0 && self.speed.is_finite()) {
            return refuse("speed", self.speed, f64::MIN_POSITIVE);
        }
        if !(least < 0.0 && least.is_finite()) {
            return refuse("command", least, -f64::MIN_POSITIVE);
        }
        if !(most > 0.0 && most.is_finite()) {
            return refuse("command", most, f64::MIN_POSITIVE);
        }
        if !(self.duration > 0.0 && self.duration.is_finite()) {
            return refuse("duration", self.duration, f64::MIN_POSITIVE);
        }
        Ok(())
    }
}
