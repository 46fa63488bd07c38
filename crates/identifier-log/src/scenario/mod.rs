//! The tables of a scenario that a log has, in SI: encoder, amplifier, controller, identifier, and the log itself.
//!
//! A text is read in steps that each do one thing. `source` parses it. Then [`read`](fn@read) writes its values, key by key, into a
//! [`Document`]. Last, its check rejects settings that contradict each other. The table of a document's keys has all of
//! them, from which reading, [writing](Options::text), errors, help and [`schema`] follow. A key's `kind` reads, writes and
//! describes its value. A crate with further tables has a document of its own, whose keys are [`keys::of_log`] and its own.

mod check;
mod dispatch;
mod error;
mod estimator;
mod inner;
mod key;
pub mod keys;
mod kind;
mod log;
mod log_units;
mod names;
mod physical;
mod range;
mod read;
pub mod schema;
mod set;
mod source;
mod write;

pub use error::{Fault, ScenarioError};
pub use estimator::{Estimator, LoopKind, RivalSettings};
pub use inner::{InnerLoop, Integrator};
pub use key::examples;
pub use kind::{Choice, Default, Entries, Key, Kind, MAX_COLUMNS, MAX_ENTRIES, Place, When};
pub(crate) use log::in_order;
pub use log::{Column, LogSettings};
pub use log_units::{LogQuantity, LogUnits, PositionUnit, TimeUnit};
pub use physical::{CommandUnit, PhysicalSettings};
pub use range::Range;
pub use read::read;
pub use set::ModelSet;
pub use source::fetch;

use identifier_core::Settings;
use identifier_core::parameters::{Parameter, PerParameter};
use identifier_core::settings::{ControllerSettings, GainError, SettingsError};
use identifier_core::stability::CertificateError;
use identifier_core::units::Units;
use log_fit::Between;

use crate::column_reading::Reading;
use names::named;

/// All tables of a scenario, in the order in which they are read: what a later one needs stands before it.
pub const TABLES: [&str; 13] = [
    "plant",
    "encoder",
    "amplifier",
    "controller",
    "excitation",
    "identifier",
    "run",
    "fault",
    "compare",
    "commission",
    "inner",
    "physical",
    "log",
];

/// Settings that are read from a text: [`Options`], or these and more.
pub trait Document: AsRef<Options> + AsMut<Options> + 'static {
    /// False if a text may have keys that are not among these.
    const IS_WHOLE: bool = true;

    /// All keys, in the order in which they are read.
    fn keys() -> &'static [Key<Self>]
    where
        Self: Sized;

    /// True if the defaults of a table hold that the text does not state. `states` tells which tables it does.
    fn holds(&self, when: When, states: &dyn Fn(&str) -> bool) -> bool;
}

/// Why the parts can be relied on: each is built once when the settings are read.
const CHECKED: &str = "the scenario was checked when it was read";

/// What is stated of a log, its servo and the loop that moved it, and how to identify it.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Encoder counts per revolution; none for an ideal sensor.
    pub counts_per_rev: Option<f64>,
    /// The stated settings of loop and identifier. A log may have no controller.
    pub stated: Settings,
    /// The velocity estimate; the cut-off of a low-pass is in `stated`.
    pub velocity: Velocity,
    /// Law, parameters and number format of the identification.
    pub identifier: Identification,
    /// The stated columns of a log: see [`Options::log_columns`].
    pub log: Option<LogSettings>,
    /// The position loop of the servo itself, where the log has its goals.
    pub inner: Option<InnerLoop>,
    /// The physical quantities that turn a result's ratios into physical units.
    pub physical: PhysicalSettings,
    /// How the columns of the log were recognised, which no text states.
    pub reading: Option<Reading>,
    /// What acted between the rows of the log, which its fit says.
    pub between: Between,
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

impl AsRef<Self> for Options {
    fn as_ref(&self) -> &Self {
        self
    }
}

impl AsMut<Self> for Options {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

impl Options {
    /// Of which nothing is stated yet.
    #[must_use]
    pub fn blank() -> Self {
        Self {
            counts_per_rev: None,
            // Where no controller is declared, its sample time is the log's.
            stated: Settings::new(1e-3, 1.0),
            velocity: Velocity::LowPass,
            identifier: Identification {
                law: Estimator::Gradient,
                rival: RivalSettings::TYPICAL,
                parameters: Vec::new(),
                arithmetic: Arithmetic::F32,
            },
            log: None,
            inner: None,
            physical: PhysicalSettings::NONE,
            reading: None,
            between: Between::Held,
        }
    }

    /// Puts an encoder on the servo, and its counts into the loop's units.
    pub fn set_encoder(&mut self, counts_per_rev: f64) {
        self.counts_per_rev = Some(counts_per_rev);
        self.stated.resolution = std::f64::consts::TAU / counts_per_rev;
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
    /// For a log that declares none.
    #[must_use]
    pub fn controller(&self) -> &ControllerSettings {
        self.stated.controller.as_ref().expect(CHECKED)
    }

    /// The settings of loop and identifier: the stated ones, with parameters that are not estimated as known.
    #[must_use]
    pub fn identifier_settings(&self) -> Settings {
        let mut settings = self.stated;
        settings.identifier.known =
            PerParameter::from_fn(|parameter| self.identifier.is_known(parameter));
        if self.identifier.arithmetic == Arithmetic::Fixed {
            bound_by_the_range(&mut settings);
        }
        settings
    }

    /// [`Options::units`] where they are not known to be allowed.
    ///
    /// # Errors
    /// The key that is out of its range.
    pub fn checked_units(&self) -> Result<Units, Fault> {
        self.stated
            .units()
            .map_err(|error| self.fault(&error.into()))
    }

    /// An error of the core at the key that it is best mended at.
    #[must_use]
    pub fn fault(&self, error: &SettingsError) -> Fault {
        Fault::new(self.key_of(error), error)
    }

    fn key_of(&self, error: &SettingsError) -> String {
        let given = &self.stated.identifier;
        let gains = match given.correction {
            Some(_) => "identifier.correction",
            None => "controller",
        };
        match error {
            SettingsError::Range(error) => match error.parameter {
                "alpha_min" => format!("{gains}.kd"),
                parameter @ ("kp" | "kd" | "ki") => format!("{gains}.{parameter}"),
                parameter @ ("delay" | "dead_band" | "current_loop") => {
                    format!("amplifier.{parameter}")
                }
                "a_min" => "identifier.servo_range.a".to_owned(),
                "b_min" => "identifier.servo_range.b".to_owned(),
                parameter => {
                    key_of_loop(parameter).unwrap_or_else(|| format!("identifier.{parameter}"))
                }
            },
            SettingsError::NotGiven {
                setting: "controller",
            } => "controller".to_owned(),
            SettingsError::NotGiven { setting } => format!("identifier.{setting}"),
            SettingsError::NoAmplifier { setting } => format!("amplifier.{setting}"),
            SettingsError::NotShaped { setting } => format!("controller.{setting}"),
            SettingsError::Certificate(CertificateError::ProportionalGainTooSmall { .. }) => {
                format!("{gains}.kp")
            }
            SettingsError::Certificate(_) if given.mu.is_some() => "identifier.mu".to_owned(),
            SettingsError::Certificate(_) => "identifier.servo_range".to_owned(),
            SettingsError::NoGamma(GainError::AtRest) => "excitation.kind".to_owned(),
            SettingsError::NoGamma(_) => "controller.sample_time".to_owned(),
            SettingsError::SampledLoop(_) => "controller.sample_time".to_owned(),
            SettingsError::NoSuchTerm { .. } => "identifier.required_terms".to_owned(),
            SettingsError::Estimate(_) => "identifier.bounds.b".to_owned(),
        }
    }
}

/// The key that states a setting of the loop, by the setting's name in errors.
#[must_use]
pub fn key_of_loop(setting: &str) -> Option<String> {
    Some(match setting {
        "cutoff" => "controller.velocity_filter.cutoff".to_owned(),
        "resolution" => "encoder.counts_per_rev".to_owned(),
        "limit" | "limit_low" | "limit_high" => "amplifier.limit".to_owned(),
        "kp" | "kd" | "ki" | "reference_filter" | "notch" | "sample_time" => {
            format!("controller.{setting}")
        }
        own if own.starts_with("feed_forward.") => format!("controller.{own}"),
        _ => return None,
    })
}

/// Fixed point needs bounds of friction and load. If none are stated, the parameter range gives them. A command of the
/// limit, or of an error of one, makes no larger acceleration of any servo in it.
fn bound_by_the_range(settings: &mut Settings) {
    let (Some(within), Some(controller)) =
        (settings.identifier.parameter_range, settings.controller)
    else {
        return;
    };
    let [low, high] = controller.limit;
    let most = within.b[1] * controller.kp.min(high).min(-low);
    let bounds = &mut settings.identifier.bounds;
    bounds.coulomb.get_or_insert([0.0, most]);
    bounds.load.get_or_insert([-most, most]);
}
