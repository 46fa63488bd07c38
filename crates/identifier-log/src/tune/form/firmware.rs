//! The rows of the table of firmwares, firmwares.toml.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::str::FromStr;
use std::sync::LazyLock;

use serde::Deserialize;

/// A firmware and its controller; the table explains its keys.
#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Firmware {
    pub(super) name: String,
    pub(super) title: String,
    pub(super) sample_time: Option<f64>,
    pub(super) delay: f64,
    pub(super) filter: Filter,
    pub(super) cutoff: Option<f64>,
    pub(super) law: Estimator,
    pub(super) older: f64,
    /// Samples by which the error's target is late.
    pub(super) target_delay: usize,
    pub(super) anti_windup: AntiWindup,
    /// The repository, file and commit that it was read from; none where it was not read.
    pub(super) source: Option<String>,
    pub(super) command: Option<String>,
    pub(super) share_of: Option<Share>,
    pub(super) angle: Option<f64>,
    pub(super) parameters: Vec<Parameter>,
    /// Its usual limit of the velocity, rad/s.
    pub(super) velocity_limit: Option<f64>,
    pub(super) remarks: Vec<String>,
}

/// A parameter: a quantity times a factor, with six digits or these decimal places, up to the largest.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Parameter {
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) of: Of,
    pub(super) factor: Option<f64>,
    pub(super) places: Option<usize>,
    pub(super) most: Option<f64>,
}

/// The structure of a controller.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
pub(super) enum Estimator {
    /// kp e + ki ∫e − kd v, with the gains kd, kp and ki.
    #[default]
    Pid,
    /// The same with the derivative of the error.
    PidOnError,
    /// (Kv + Kvi ∫)(Kx e − v), with the gains Kx, Kv and Kvi.
    Cascade,
    /// kp e alone.
    Proportional,
}

/// The whole that an output is a share of.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub(super) enum Share {
    MaxCurrent,
    BusVoltage,
    /// The command for 2π rad/s², so that the gain of the velocity is its bandwidth in Hz.
    Acceleration,
}

/// The quantity that a parameter is.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub(super) enum Of {
    /// The gains of the control law: kd, kp and ki, or Kx, Kv and Kvi.
    First,
    Second,
    Third,
    /// Kv/Kvi, s.
    ResetTime,
    /// The filter: its frequency, rad/s, the reciprocal of that, or the share of the newest sample in it.
    Cutoff,
    TimeConstant,
    NewestShare,
    /// The feed-forward: 1/b, a/b, c/b.
    Acceleration,
    Velocity,
    Friction,
    /// The largest command.
    Limit,
}

/// A filter of a frequency ω for position and velocity, as an α-β filter: prediction p + w, innovation e, p = prediction + α e,
/// w += β e. Here w is the motion of a sample. The velocity is w over a sample, and the position is p + γ w: with γ = 1 the
/// next prediction. With α = 1 it is a low-pass filter of the difference; a phase-locked loop is one too.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
pub(super) enum Filter {
    /// Low-pass filter of the difference, with the pole e^(−ωT).
    #[default]
    LowPass,
    /// The same with the pole 1/(1 + ωT).
    BackwardLowPass,
    /// Phase-locked loop whose velocity is its integral, ω²/(s + ω)², and whose position (2ωs + ω²)/(s + ω)² is that of the
    /// sample.
    Observer,
    /// The same with the position of the sample that follows.
    AheadObserver,
}

/// What an integral does where the output is at its limit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
pub(super) enum AntiWindup {
    /// It goes on.
    #[default]
    None,
    /// Its part of the output stays within the limit.
    Clamped,
    /// Its part stays within what the proportional part leaves of the limit.
    Headroom,
    /// It falls by a hundredth each sample.
    Decay,
    /// It grows no more towards the limit.
    Conditional,
}

impl Filter {
    /// [α, β, γ] for a frequency, rad/s, at a sample time, s. The last value is the cut-off, rad/s, of the equivalent
    /// low-pass filter for which gains are designed. It has the same pole or the same lag or, if neither exists, the
    /// same noise.
    pub(super) fn of(self, frequency: f64, time: f64) -> ([f64; 3], f64) {
        let x = frequency * time;
        let (filter, cutoff) = match self {
            Self::LowPass => ([1.0, -(-x).exp_m1(), 0.0], frequency),
            Self::BackwardLowPass => ([1.0, x / (1.0 + x), 0.0], x.ln_1p() / time),
            Self::Observer => ([2.0 * x, x * x, 0.0], 0.5 * frequency),
            Self::AheadObserver => ([2.0 * x, x * x, 1.0], 0.5 * frequency),
        };
        (filter, cutoff.min(0.99 * PI / time))
    }
}

/// The table; a test reads it, so that it is not empty.
pub(super) static FIRMWARES: LazyLock<Vec<Firmware>> = LazyLock::new(|| {
    let table = toml::from_str::<BTreeMap<String, Vec<Firmware>>>(include_str!("firmwares.toml"));
    let mut table = table.unwrap_or_default();
    table.remove("firmware").unwrap_or_default()
});

/// The form of a drive's firmware.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form(pub(super) &'static Firmware);

impl FromStr for Form {
    /// All names.
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = FIRMWARES.iter().find(|firmware| firmware.name == name);
        found.map(Self).ok_or_else(|| {
            let names: Vec<_> = FIRMWARES.iter().map(|firmware| &*firmware.name).collect();
            format!("one of {}", names.join(", "))
        })
    }
}
