//! What an experiment is: the servo, its loop, the reference and the identifier, in SI.
//!
//! A scenario file is read in three steps that each do one thing: [`tables`] is its shape, `build`
//! turns the tables into validated parts of the core, and [`ScenarioError`] says where in the file
//! a step failed and what is allowed there. [`keys`] is the list of all keys, for the errors and
//! for the help.

mod build;
mod error;
pub mod keys;
mod parts;
mod reference;
mod source;
pub mod tables;
mod velocity;

pub use error::ScenarioError;
pub use reference::{Reference, ReferenceState};
pub use velocity::WithVelocity;

use std::path::Path;

use identifier_core::adaptation::PositiveDefinite;
use identifier_core::control::{CommandLimit, Gains};
use identifier_core::excitation::Tone;
use identifier_core::interval::Interval;
use identifier_core::model::ServoParameters;
use identifier_core::stability::PlantBox;
use identifier_core::units::Units;

/// A validated scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// The true servo.
    pub plant: ServoParameters,
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
    /// Initial [â, b̂], SI.
    pub initial: [f64; 2],
    /// The number format of the loop.
    pub arithmetic: Arithmetic,
}

/// The adaptation law.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// The Γ-gradient law (11) in the PID's loop.
    Gradient(GradientSettings),
    /// Recursive least squares in a loop closed by a relay.
    RelayLeastSquares(RelaySettings),
}

/// What only the Γ-gradient law needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GradientSettings {
    /// Γ; none for the automatic one.
    pub gamma: Option<PositiveDefinite<2>>,
    /// μ, 1/s; none for the automatic one.
    pub mu: Option<f64>,
    /// Box of the estimates.
    pub bounds: [Interval; 2],
    /// Box of the servo, to be certified.
    pub plant_box: Option<PlantBox>,
}

/// What only the relay's least squares needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelaySettings {
    /// The relay's command, ± this, command units.
    pub relay: f64,
    /// Forgetting factor.
    pub forgetting: f64,
    /// Cut-off of the filters of input and output, rad/s.
    pub filter_cutoff: f64,
}

impl Law {
    /// The law's name in scenarios and results.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gradient(_) => "gradient",
            Self::RelayLeastSquares(_) => "relay-least-squares",
        }
    }
}

/// The number format that the loop is computed in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arithmetic {
    /// Single precision, as on the drive.
    F32,
    /// Double precision.
    F64,
}

impl Arithmetic {
    /// The format's name in scenarios and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

impl Scenario {
    /// The control samples of the run.
    #[must_use]
    pub fn samples(&self) -> u64 {
        (self.duration / self.controller.units.sample_time()).round() as u64
    }

    /// Reads a scenario file.
    ///
    /// # Errors
    /// File, line, key and what is allowed there.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| ScenarioError::unreadable(path, &error))?;
        Self::parse(&path.display().to_string(), &text)
    }

    /// Reads a scenario from a text; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`Scenario::load`].
    pub fn parse(name: &str, text: &str) -> Result<Self, ScenarioError> {
        let source = source::Source::new(name, text);
        let tables = source.tables()?;
        build::scenario(&tables).map_err(|fault| source.locate(fault))
    }
}
