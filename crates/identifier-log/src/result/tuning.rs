//! The result of a tuning.

use identifier_core::control::FeedForwardSettings;
use identifier_core::parameters::ServoParameters;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::{PredictedResponse, Tuning};
use serde::Serialize;

use super::{FormResult, Reading};

/// Gains, with their predicted response and their conditions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TuningResult {
    /// Sample time, s.
    pub sample_time: f64,
    /// Gains.
    #[serde(flatten)]
    pub gains: Gains,
    /// ω of the poles, rad/s.
    pub bandwidth: f64,
    /// The reason why it is not faster; none where it is as fast as was asked for.
    pub cap: Option<&'static str>,
    /// Predicted response of the loop, and its stiffness.
    pub predicted_response: StiffPrediction,
    /// The shortest and the longest settling time, s, by what earlier motions leave of friction in the integral; infinite
    /// (null) where it does not settle.
    pub settling_times: [f64; 2],
    /// Gains to begin with, for a quarter of the bandwidth, and the step that they make.
    pub first_trial: Option<FirstTrial>,
    /// The resonance that the gains are for.
    pub resonance: Option<FoundMode>,
    /// The frequency from which on a resonance may lie that nothing has shown, rad/s; none where there is none.
    pub hidden_from: Option<f64>,
    /// How the columns of the log were read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reading: Option<Reading>,
    /// Feed-forward.
    pub feed_forward: FeedForward,
    /// The same in the form of a drive's firmware, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<FormResult>,
    /// The servo that it is for.
    pub servo: DelayedServo,
    /// Conditions.
    pub conditions: TuningConditions,
}

/// Gains to begin with.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FirstTrial {
    /// Gains.
    #[serde(flatten)]
    pub gains: Gains,
    /// The step to make with them, rad.
    pub step: f64,
    /// Its predicted rise time, s.
    pub rise_time: f64,
    /// Its largest predicted overshoot, a part of it.
    pub overshoot: f64,
}

/// The mode of a second mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FoundMode {
    /// ω, rad/s.
    pub rad_per_s: f64,
    /// ζ.
    pub damping: f64,
    /// β, the load's inertia over the motor's; −1 for an encoder on the load.
    pub ratio: f64,
}

/// A PID with its filters, SI.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gains {
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
    /// The feed-forward of the drive's own loop with its reference model; none where the filter alone shapes a step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_model: Option<FeedForwardSettings>,
}

impl Gains {
    /// Gains of a controller with its cut-off, rad/s.
    #[must_use]
    pub fn of(controller: &ControllerSettings, cutoff: f64) -> Self {
        Self {
            kp: controller.kp,
            kd: controller.kd,
            ki: controller.ki,
            cutoff,
            reference_filter: controller.reference_filter,
            notch: controller.notch,
            reference_model: controller.feed_forward,
        }
    }

    /// Gains that were tuned.
    #[must_use]
    pub fn tuned(tuning: &Tuning) -> Self {
        let unlimited = [f64::NEG_INFINITY, f64::INFINITY];
        Self::of(&ControllerSettings::tuned(tuning, unlimited), tuning.cutoff)
    }
}

/// A predicted response with the stiffness that follows from its compliance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StiffPrediction {
    /// The predicted response.
    #[serde(flatten)]
    pub predicted_response: PredictedResponse,
    /// Load per distance that it moves the servo at most, rad/s² per rad.
    pub stiffness: f64,
}

/// Coefficients of the reference's motion in the command, command units per SI unit. They are for a controller with
/// such an input.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FeedForward {
    /// For the acceleration.
    pub acceleration: f64,
    /// For the velocity.
    pub velocity: f64,
    /// Coefficient of the velocity's sign.
    pub sign: f64,
    /// Constant.
    pub constant: f64,
    /// Of sin q.
    pub gravity_sine: f64,
    /// Of cos q.
    pub gravity_cosine: f64,
    /// Of sin Nq.
    pub ripple_sine: f64,
    /// Of cos Nq.
    pub ripple_cosine: f64,
    /// N; zero without a ripple.
    pub ripple_order: f64,
    /// In the direction of all of this.
    pub dead_band: f64,
    /// Time by which the reference is taken ahead, s.
    pub lead: f64,
}

/// A servo with its delay.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DelayedServo {
    /// Its parameters.
    #[serde(flatten)]
    pub parameters: ServoParameters,
    /// From a command to its acceleration besides the hold's, s.
    pub delay: f64,
}

/// Conditions of a tuning.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TuningConditions {
    /// Position of a count, rad.
    pub resolution: f64,
    /// The largest command, command units; infinite (null) for none.
    pub command: f64,
    /// Delay beyond what was identified, s.
    pub command_delay: f64,
    /// The largest sensitivity.
    pub most_sensitivity: f64,
    /// The largest part of the command that noise may make up.
    pub most_noise: f64,
    /// The lowest resonance that is known, rad/s.
    pub resonance: Option<f64>,
}

/// The commands that hold the known forces, and other known figures of the command, SI. Zero for an unknown one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KnownForces {
    /// −d/b, command units.
    pub constant: f64,
    /// −g_s/b and −g_c/b, command units.
    pub gravity: [f64; 2],
    /// −r_s/b and −r_c/b, command units.
    pub ripple: [f64; 2],
    /// N, periods per revolution.
    pub ripple_order: f64,
    /// δ, command units.
    pub dead_band: f64,
    /// Time from a command to its acceleration besides the hold's, s.
    pub delay: f64,
}

impl FeedForward {
    /// For a servo with known forces under a derivative gain, command units per rad/s. `hold` is the mean delay of a
    /// hold, s.
    #[must_use]
    pub fn of_servo(
        servo: &ServoParameters,
        known: &KnownForces,
        derivative: f64,
        hold: f64,
    ) -> Self {
        let ([gravity_sine, gravity_cosine], [ripple_sine, ripple_cosine]) =
            (known.gravity, known.ripple);
        Self {
            acceleration: 1.0 / servo.b,
            velocity: servo.a / servo.b + derivative,
            sign: servo.coulomb / servo.b,
            constant: known.constant,
            gravity_sine,
            gravity_cosine,
            ripple_sine,
            ripple_cosine,
            ripple_order: known.ripple_order,
            dead_band: known.dead_band,
            lead: known.delay + hold,
        }
    }
}
