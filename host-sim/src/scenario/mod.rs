//! Scenarios: the servo, its loop, the reference and the identifier of an experiment, in SI.
//!
//! The tables that a log has are [`Options`]; [`keys`] has those of the experiment.

mod check;
mod commission;
pub(crate) mod dispatch;
#[cfg(feature = "experiments")]
mod gamma;
pub mod keys;
mod parts;
mod reference;

pub(crate) use check::{complete, in_effect};
pub use commission::CommissionOrder;
#[cfg(feature = "experiments")]
pub(crate) use gamma::{gamma_over, range_around};
pub use identifier_log::scenario::*;
pub use reference::{ExcitationKind, ExcitationSettings, Reference, ReferenceState};

use std::ops::{Deref, DerefMut};

use identifier_core::parameters::ServoParameters;
use virtual_servo::faults::InjectedFault;
use virtual_servo::{Effects, SensorEffects};

/// The paper's experiment: the proposed method.
pub const PAPER: &str = include_str!("../../scenarios/paper.toml");

/// The paper's experiment: the least squares that it is compared with.
pub const PAPER_LEAST_SQUARES: &str = include_str!("../../scenarios/paper-least-squares.toml");

/// A validated scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Loop, identifier and log.
    pub options: Options,
    /// The purpose that it is read for.
    purpose: Purpose,
    /// The true servo, where it is known; a run needs it.
    pub plant: Option<ServoParameters>,
    /// The effects of the true servo beside these parameters.
    pub effects: Effects,
    /// The errors of the position sensor.
    pub sensor: SensorEffects,
    /// The longest that the holding brake of the axis takes to open and to close, s.
    pub brake: Option<[f64; 2]>,
    /// The faults injected while the servo runs.
    pub faults: Vec<InjectedFault>,
    /// The reference.
    pub excitation: ExcitationSettings,
    /// Length of the run, s.
    pub duration: f64,
    /// The seed of what is random in servo and sensor, where it is stated: see
    /// [`Scenario::noise_seed`].
    pub seed: Option<u32>,
    /// The cases of a comparison.
    pub compare: CompareSettings,
    /// The limits and the goal of a commissioning; a commissioning needs them.
    pub commission: Option<CommissionOrder>,
}

/// The cases of a comparison, SI; none for a value derived from the servo.
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

impl CompareSettings {
    /// The usual coarse encoder, counts per revolution.
    const COARSE: f64 = 2000.0;
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

impl Scenario {
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

    /// The control samples of the run.
    #[must_use]
    pub fn samples(&self) -> u64 {
        (self.duration / self.sample_time()).round() as u64
    }

    /// A scenario of which nothing is stated yet.
    #[must_use]
    pub fn blank(purpose: Purpose) -> Self {
        Self {
            options: Options::blank(),
            purpose,
            plant: None,
            effects: Effects::NONE,
            sensor: SensorEffects::default(),
            faults: Vec::new(),
            brake: None,
            excitation: ExcitationSettings::default(),
            duration: 0.0,
            seed: None,
            compare: CompareSettings {
                load: None,
                coulomb: None,
                counts_per_rev: CompareSettings::COARSE,
                limit: None,
            },
            commission: None,
        }
    }
}

impl From<Options> for Scenario {
    /// The scenario of a log without a simulated servo.
    fn from(options: Options) -> Self {
        Self {
            options,
            excitation: ExcitationSettings::paper(),
            ..Self::blank(Purpose::Replay)
        }
    }
}

impl Deref for Scenario {
    type Target = Options;

    fn deref(&self) -> &Options {
        &self.options
    }
}

impl DerefMut for Scenario {
    fn deref_mut(&mut self) -> &mut Options {
        &mut self.options
    }
}

impl AsRef<Options> for Scenario {
    fn as_ref(&self) -> &Options {
        self
    }
}

impl AsMut<Options> for Scenario {
    fn as_mut(&mut self) -> &mut Options {
        self
    }
}

impl Document for Scenario {
    fn keys() -> &'static [Key<Self>] {
        &keys::KEYS
    }

    fn holds(&self, when: When, states: &dyn Fn(&str) -> bool) -> bool {
        match (when, self.purpose) {
            (When::Always, _) | (When::Simulated, Purpose::Commission) => true,
            (When::Stated, _) | (When::InRun, Purpose::Commission) => false,
            (When::InRun | When::Simulated, Purpose::Run) => true,
            // A run's own log has the defaults of the run.
            (When::InRun | When::Simulated, Purpose::Replay) => {
                self.plant.is_some() && !states("log")
            }
        }
    }
}
