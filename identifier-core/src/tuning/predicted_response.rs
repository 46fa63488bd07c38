use super::Cap;
use crate::control::FeedForwardSettings;

/// Gains and their predicted performance, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tuning {
    /// Proportional gain, command units per rad.
    pub kp: f64,
    /// Derivative gain, command units per rad/s.
    pub kd: f64,
    /// Integral gain, command units per rad s.
    pub ki: f64,
    /// Cut-off of the velocity estimate, rad/s.
    pub cutoff: f64,
    /// Time constant of the filter of the reference, s; zero for none.
    pub reference_filter: f64,
    /// Frequency of the notch filter of the command, rad/s; zero for none.
    pub notch: f64,
    /// The feed-forward; none if only the filter shapes a step.
    pub feed_forward: Option<FeedForwardSettings>,
    /// ω of the poles, those of the servo without its friction, rad/s.
    pub bandwidth: f64,
    /// The cap that limits the bandwidth; none if it is as high as requested.
    pub cap: Option<Cap>,
    /// Its predicted response.
    pub predicted_response: PredictedResponse,
}

/// Predicted behaviour of a loop, for the identified servo and the worst within its uncertainty. Laid out as C does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct PredictedResponse {
    /// The step of the reference that it is for, rad.
    pub step: f64,
    /// From 10 to 90 % of the step, s. The integral holds only the load.
    pub rise_time: f64,
    /// The least of three rise times: that one, and those after a motion in the direction of the step or against it.
    /// Such a motion leaves the integral with all that friction can hold on that side.
    pub quickest_rise_time: f64,
    /// The longest of the three. If it takes longer, [`PredictedResponse::MAX_TIME`].
    pub slowest_rise_time: f64,
    /// Overshoot as a part of the step, at the worst corner, with friction balanced by the integral before the step.
    /// A count is added, since the position within a count is unknown.
    pub overshoot: f64,
    /// Time until the position stays within 2 % of the step, at least two counts, s. If friction keeps it outside, it
    /// is the longest time simulated, [`PredictedResponse::MAX_TIME`].
    pub settling_time: f64,
    /// Mₛ, the largest sensitivity, at the worst corner.
    pub sensitivity: f64,
    /// The factors by which the loop's gain may fall (zero for any to a thousandth) and rise (searched up to 50), at the
    /// worst corner.
    pub gain_margins: [f64; 2],
    /// The largest command of the step, as a part of the available command.
    pub command_share: f64,
    /// Standard deviation of the command from the encoder's rounding, command units.
    pub noise: f64,
    /// The farthest that a step of the load of one rad/s² moves the servo, rad per rad/s².
    pub compliance: f64,
}

impl PredictedResponse {
    /// Time for which a step is simulated, 1/ω. A quarter of it is enough if friction does not hold the servo.
    pub const MAX_TIME: f64 = 25.0;

    /// Takes in the rise time (s) of a step that began otherwise.
    pub(super) fn take_rise(&mut self, rise_time: f64) {
        self.quickest_rise_time = self.quickest_rise_time.min(rise_time);
        self.slowest_rise_time = self.slowest_rise_time.max(rise_time);
    }
}
