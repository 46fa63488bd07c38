//! What an experiment is: the servo, its loop, the reference and the identifier, in SI.
//!
//! A scenario file is read in three steps that each do one thing: [`tables`] is its shape, `build`
//! turns the tables into validated parts of the core, and [`ScenarioError`] says where in the file
//! a step failed and what is allowed there. [`keys`] is the list of all keys, for the errors and
//! for the help.

mod baselines;
mod build;
mod error;
pub(crate) mod fixed;
pub mod keys;
mod law;
mod parts;
mod reference;
mod set;
mod source;
pub mod tables;
mod velocity;

pub use error::ScenarioError;
pub use law::{Baseline, BaselineSettings, Closing, GradientSettings, Law, WindowSettings};
pub use reference::{Reference, ReferenceState};
pub use set::{ModelSet, WithSet};
pub use velocity::WithVelocity;

use std::path::Path;

use identifier_core::control::{CommandLimit, Gains};
use identifier_core::excitation::Tone;
use identifier_core::fixed_point::Ranges;
use identifier_core::identifier::Bounds;
use identifier_core::model::ServoParameters;
use identifier_core::parameters::Parameter;
use identifier_core::stability::PlantBox;
use identifier_core::units::Units;

/// A validated scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// The true servo, where it is known; a run needs it.
    pub plant: Option<ServoParameters>,
    /// Encoder counts per revolution; none for an ideal sensor.
    pub counts_per_rev: Option<f64>,
    /// The amplifier's limit.
    pub limit: CommandLimit,
    /// The controller that closes the loop.
    pub controller: ControllerSettings,
    /// The reference.
    pub excitation: ExcitationSettings,
    /// The identifier.
    pub identifier: IdentifierSettings,
    /// Length of the run, s.
    pub duration: f64,
    /// The columns of a log to replay.
    pub log: Option<LogSettings>,
    /// What the cases of a comparison are made of.
    pub compare: CompareSettings,
}

/// What the cases of a comparison are made of, SI; none for what follows from the servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareSettings {
    /// The load, rad/s².
    pub load: Option<f64>,
    /// The friction, rad/s².
    pub coulomb: Option<f64>,
    /// The coarse encoder, counts per revolution.
    pub counts_per_rev: f64,
    /// The amplifier that saturates, command units.
    pub limit: Option<f64>,
}

/// What a scenario is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A simulated run: it needs a plant.
    Run,
    /// The replay of a log: it needs the log's columns.
    Replay,
}

/// Which column of a log is what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogSettings {
    /// Time, s.
    pub time: String,
    /// Reference position.
    pub reference: String,
    /// Measured position.
    pub position: String,
    /// The recorded command, to be checked against the declared controller.
    pub command: Option<String>,
    /// A known signal added to the command behind the controller and its limit.
    pub injection: Option<String>,
    /// The longest gap, in missing samples, that may be bridged by straight lines.
    pub bridge: u32,
}

/// The PID and its sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControllerSettings {
    /// Gains, SI.
    pub gains: Gains,
    /// Sample time and position unit.
    pub units: Units,
    /// The velocity estimate.
    pub velocity: VelocitySettings,
}

/// The velocity estimate of the controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VelocitySettings {
    /// Low-pass derivative with a cut-off, rad/s.
    LowPass(f64),
    /// Backward difference.
    Difference,
    /// Averaged difference.
    AveragedDifference,
}

/// The reference signal, SI.
#[derive(Debug, Clone, PartialEq)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, documented there"
)]
pub enum ExcitationSettings {
    BandLimitedWhiteNoise {
        power: f64,
        sample_time: f64,
        seed: u32,
    },
    Prbs {
        amplitude: f64,
        hold: f64,
        order: u32,
    },
    Multisine(Vec<Tone>),
    Chirp {
        amplitude: f64,
        from: f64,
        to: f64,
        duration: f64,
    },
    Square {
        amplitude: f64,
        period: f64,
    },
    Steps {
        levels: Vec<f64>,
        hold: f64,
    },
    None,
}

/// What identifies the servo.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifierSettings {
    /// The law and what only it needs.
    pub law: Law,
    /// The parameters to be estimated, in the user's order.
    pub parameters: Vec<Parameter>,
    /// Initial estimates, SI; of a parameter that is not estimated, its known value.
    pub initial: ServoParameters,
    /// Box of the estimates.
    pub bounds: Bounds,
    /// Box of the servo, to be certified.
    pub plant_box: Option<PlantBox>,
    /// The number format of the loop.
    pub arithmetic: Arithmetic,
    /// What the signals stay within in fixed point; none for what follows from the loop.
    pub ranges: Option<Ranges>,
}

/// The number format that the loop is computed in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// Single precision, as on the drive.
    F32,
    /// Double precision.
    F64,
    /// Fixed point, words of 32 bits.
    Fixed,
}

impl Arithmetic {
    /// The format's name in scenarios and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
            Self::Fixed => "fixed",
        }
    }
}

impl Scenario {
    /// Puts an encoder on the servo, and its counts into the loop's units.
    pub fn set_encoder(&mut self, counts_per_rev: f64) {
        let unit = std::f64::consts::TAU / counts_per_rev;
        if let Ok(units) = Units::new(self.controller.units.sample_time(), unit) {
            self.controller.units = units;
            self.counts_per_rev = Some(counts_per_rev);
        }
    }

    /// The control samples of the run.
    #[must_use]
    pub fn samples(&self) -> u64 {
        (self.duration / self.controller.units.sample_time()).round() as u64
    }

    /// Reads a scenario file.
    ///
    /// # Errors
    /// File, line, key and what is allowed there.
    pub fn load(path: &Path, purpose: Purpose) -> Result<Self, ScenarioError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| ScenarioError::unreadable(path, &error))?;
        Self::parse(&path.display().to_string(), &text, purpose)
    }

    /// Reads a scenario from a text; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(name: &str, text: &str, purpose: Purpose) -> Result<Self, ScenarioError> {
        let source = source::Source::new(name, text);
        let tables = source.tables()?;
        build::scenario(&tables, purpose).map_err(|fault| source.locate(fault))
    }
}
