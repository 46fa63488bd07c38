//! The result of a check.

use serde::Serialize;

use super::SensorNoise;

/// Properties of a scenario, known before it is run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CheckResult {
    /// Sample time, s.
    pub sample_time: f64,
    /// The servo.
    pub servo: ServoFigures,
    /// The loop around it, where a PID closes it.
    #[serde(rename = "loop")]
    pub closed_loop: Option<LoopFigures>,
    /// The certificate.
    pub certificate: Certificate,
    /// The encoder beside the motion.
    pub encoder: EncoderFigures,
    /// The part of the samples in which the command is at its limit.
    pub limited: f64,
    /// Accuracy that the motion allows for each unknown.
    pub known: Vec<Known>,
    /// The problems, with remedies.
    pub warnings: Vec<String>,
}

/// The servo's own figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ServoFigures {
    /// Viscous friction over inertia, 1/s.
    pub a: f64,
    /// Gain over inertia, rad/s² per command unit.
    pub b: f64,
    /// 1/a, s; null for a servo without viscous friction.
    pub time_constant: Option<f64>,
    /// The speed that the largest command holds, rad/s; null without a limit or without friction.
    pub top_speed: Option<f64>,
    /// The command that friction and load take before the servo moves, command units.
    pub breakaway: f64,
}

/// The certificate of the box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Certificate {
    /// True if every servo of a box is certified.
    pub certified: bool,
    /// The gain margin of the sampled loop over it.
    pub gain_margin: Option<f64>,
    /// μ, 1/s, of the gradient law.
    pub mu: Option<f64>,
}

/// The encoder beside the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EncoderFigures {
    /// A count, rad; of an ideal sensor the resolution of its numbers.
    pub resolution: f64,
    /// Deviation of the position, counts.
    pub motion: f64,
    /// Noise of the measured position.
    pub noise: SensorNoise,
    /// Change of the command by a count at once, command units.
    pub command_per_count: Option<f64>,
}

/// Accuracy that the motion allows for an unknown.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Known {
    /// Its name.
    pub unknown: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The least standard error at the end of the run; null where the motion contains no information on it.
    pub std_error: Option<f64>,
    /// The standard error from which on it counts as known.
    pub needed: f64,
    /// Time at which that is reached, s, perhaps after the end of the run; null for never.
    pub from: Option<f64>,
    /// True if that is before the end of the run.
    pub within_run: bool,
}

/// Speed and margins of a loop. All but the first are null where it is unstable.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopFigures {
    /// True if it is stable, delay left aside.
    pub stable: bool,
    /// Frequency at which the closed loop has fallen by 3 dB, rad/s.
    pub bandwidth: Option<f64>,
    /// Frequency at which |L| last falls below 1, rad/s.
    pub crossover: Option<f64>,
    /// Phase margin there, degrees.
    pub phase_margin: Option<f64>,
    /// The factors by which the gain may fall and rise; null for any.
    pub gain_margins: [Option<f64>; 2],
    /// The least |1 + L|.
    pub modulus_margin: Option<f64>,
}
