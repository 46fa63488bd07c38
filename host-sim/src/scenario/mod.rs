//! Scenarios: the servo, its loop, the reference and the identifier of an experiment, in SI.
//!
//! A scenario file is read in steps that each do one thing. The module `source` parses the text. Then `read` writes its
//! values, key by key, into the settings. Last, `check` rejects settings that contradict each other. The table [`keys`]
//! has all keys, from which reading, errors, help and [`schema`] follow. A key's `kind` reads and describes its value.

mod check;
mod commission;
pub(crate) mod dispatch;
mod error;
mod estimator;
#[cfg(feature = "experiments")]
mod gamma;
mod inner;
mod key;
pub mod keys;
mod kind;
mod log;
mod log_quantity;
mod log_units;
mod names;
mod parts;
mod physical;
mod range;
mod read;
mod reference;
mod rivals;
pub mod schema;
mod set;
mod source;
mod stability;

pub use commission::CommissionOrder;
pub use error::{Fault, ScenarioError};
pub use estimator::{Estimator, LoopKind, RivalSettings};
#[cfg(feature = "experiments")]
pub(crate) use gamma::{gamma_over, range_around};
pub use inner::{InnerLoop, Integrator};
pub use kind::Key;
pub(crate) use kind::MAX_COLUMNS;
pub(crate) use log::in_order;
pub use log::{Column, LogSettings};
pub use log_quantity::LogQuantity;
pub use log_units::{LogUnits, PositionUnit, TimeUnit};
pub use physical::{CommandUnit, PhysicalSettings};
pub(crate) use reference::MAX_SIMULATED;
pub use reference::{ExcitationKind, ExcitationSettings, Reference, ReferenceState};
pub use set::ModelSet;
pub(crate) use source::fetch;

use identifier_core::Settings;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::settings::ControllerSettings;
use identifier_core::units::Units;
use names::named;
use virtual_servo::faults::InjectedFault;
use virtual_servo::{Effects, SensorEffects};

/// The paper's experiment: the proposed method.
pub const PAPER: &str = include_str!("../../scenarios/paper.toml");

/// The paper's experiment: the least squares that it is compared with.
pub const PAPER_LEAST_SQUARES: &str = include_str!("../../scenarios/paper-least-squares.toml");

/// Why the parts can be relied on: a [`Scenario`] builds each of them once when it is read.
pub(crate) const CHECKED: &str = "the scenario was checked when it was read";

/// A validated scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// The true servo, where it is known; a run needs it.
    pub plant: Option<ServoParameters>,
    /// The effects of the true servo beside these parameters.
    pub effects: Effects,
    /// Encoder counts per revolution; none for an ideal sensor.
    pub counts_per_rev: Option<f64>,
    /// The errors of the position sensor.
    pub sensor: SensorEffects,
    /// The longest that the holding brake of the axis takes to open and to close, s.
    pub brake: Option<[f64; 2]>,
    /// The faults injected while the servo runs.
    pub faults: Vec<InjectedFault>,
    /// The settings of loop and identifier that the file states; [`Scenario::settings`] is the whole. A replay may have no controller.
    pub stated: Settings,
    /// The velocity estimate; the cut-off of a low-pass is in `stated`.
    pub velocity: Velocity,
    /// The reference.
    pub excitation: ExcitationSettings,
    /// Law, parameters and number format of the identification.
    pub identifier: Identification,
    /// Length of the run, s.
    pub duration: f64,
    /// The seed of what is random in servo and sensor, where it is stated: see
    /// [`Scenario::noise_seed`].
    pub seed: Option<u32>,
    /// The stated columns of a log to replay: see [`Scenario::log_columns`].
    pub log: Option<LogSettings>,
    /// The position loop of the servo itself, where the log has its goals.
    pub inner: Option<InnerLoop>,
    /// The physical quantities that turn a result's ratios into physical units.
    pub physical: PhysicalSettings,
    /// The cases of a comparison.
    pub compare: CompareSettings,
    /// The limits and the goal of a commissioning; a commissioning needs them.
    pub commission: Option<CommissionOrder>,
}

/// The cases of a comparison, SI; none for a value derived from the servo.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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

/// The purpose that a scenario is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// A simulated run: it needs a plant.
    Run,
    /// The replay of a log: it needs the log's columns.
    Replay,
    /// A simulated commissioning: it needs a plant and what it may do; a controller is one that runs
    /// already.
    Commission,
}

named! {
    /// The velocity estimates.
    pub enum Velocity {
        /// Low-pass derivative.
        LowPass = "low-pass" takes &["cutoff"],
        /// Backward difference.
        Difference = "difference",
        /// Averaged difference.
        AveragedDifference = "averaged-difference",
    }
}

/// Law, parameters and number format of the identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// The estimator.
    pub law: Estimator,
    /// The settings of an estimator for comparison.
    pub rival: RivalSettings,
    /// The parameters to be estimated, in the user's order.
    pub parameters: Vec<Parameter>,
    /// The number format of the loop.
    pub arithmetic: Arithmetic,
}

named! {
    /// The number format that the loop is computed in.
    pub enum Arithmetic {
        /// Single precision, as on the drive.
        F32 = "f32",
        /// Double precision.
        F64 = "f64",
        /// Fixed point, words of 32 bits.
        Fixed = "fixed" takes &["ranges"],
    }
}

impl Scenario {
    /// Puts an encoder on the servo, and its counts into the loop's units.
    pub fn set_encoder(&mut self, counts_per_rev: f64) {
        self.counts_per_rev = Some(counts_per_rev);
        self.stated.resolution = std::f64::consts::TAU / counts_per_rev;
    }

    /// True if the replayed log is that of the scenario's own run. It then states the true servo and no columns. The
    /// defaults of a run then hold for the log too.
    #[must_use]
    pub fn is_log_of_simulated_run(&self) -> bool {
        self.plant.is_some() && self.log.is_none()
    }

    /// The seed of everything random in servo and sensor: the run's, or else that of the reference, or 1.
    #[must_use]
    pub fn noise_seed(&self) -> u32 {
        self.seed.or(self.excitation.seed()).unwrap_or(1)
    }

    /// Sample time, s.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.stated.sample_time
    }

    /// Sample time and position unit.
    ///
    /// # Panics
    /// If one of them was changed to what is not allowed.
    #[must_use]
    pub fn units(&self) -> Units {
        self.stated.units().expect(CHECKED)
    }

    /// The declared controller: a run has one.
    ///
    /// # Panics
    /// For a replay that declares none.
    #[must_use]
    pub fn controller(&self) -> &ControllerSettings {
        self.stated.controller.as_ref().expect(CHECKED)
    }

    /// The control samples of the run.
    #[must_use]
    pub fn samples(&self) -> u64 {
        (self.duration / self.sample_time()).round() as u64
    }

    /// A scenario of which nothing is stated yet.
    #[must_use]
    pub fn blank() -> Self {
        Self {
            plant: None,
            effects: Effects::NONE,
            counts_per_rev: None,
            sensor: SensorEffects::default(),
            faults: Vec::new(),
            brake: None,
            // Where no controller is declared, its sample time is the log's.
            stated: Settings::new(1e-3, 1.0),
            velocity: Velocity::LowPass,
            excitation: ExcitationSettings::NONE,
            identifier: Identification {
                law: Estimator::Gradient,
                rival: RivalSettings::TYPICAL,
                parameters: Vec::new(),
                arithmetic: Arithmetic::F32,
            },
            duration: 0.0,
            seed: None,
            log: None,
            inner: None,
            physical: PhysicalSettings::NONE,
            compare: CompareSettings::default(),
            commission: None,
        }
    }

    /// This scenario with the settings that follow from its values, checked for a purpose. `build` finds settings from
    /// which no loop can be built.
    pub(crate) fn complete(
        self,
        purpose: Purpose,
        build: fn(&Self) -> Result<(), Fault>,
    ) -> Result<Self, Fault> {
        check::complete(self, purpose, build)
    }

    /// Reads a scenario from a text. Errors show `name` as the file. A fault that `build` finds is located by its place
    /// in the text, too.
    ///
    /// # Errors
    /// File, line, key and what is allowed there.
    pub(crate) fn read(
        name: &str,
        text: &str,
        purpose: Purpose,
        build: fn(&Self) -> Result<(), Fault>,
    ) -> Result<Self, ScenarioError> {
        let source = source::Source::new(name, text)?;
        read::scenario(&source, purpose)
            .and_then(|read| check::complete(read, purpose, build))
            .map_err(|fault| source.locate(fault))
    }
}
