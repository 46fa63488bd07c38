//! The shape of a scenario file: its tables and keys, before any value is judged.

use std::fmt;

use serde::Deserialize;

use super::Baseline;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};

/// A whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Tables {
    pub plant: Option<Plant>,
    pub encoder: Option<Encoder>,
    #[serde(default)]
    pub amplifier: Amplifier,
    pub controller: Option<Controller>,
    #[serde(default)]
    pub excitation: Excitation,
    #[serde(default)]
    pub identifier: Identifier,
    #[serde(default)]
    pub run: Run,
    pub log: Option<Log>,
    #[serde(default)]
    pub compare: Compare,
}

/// `[plant]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Plant {
    pub a: f64,
    pub b: f64,
    #[serde(default)]
    pub load: f64,
    #[serde(default)]
    pub coulomb: f64,
}

/// `[encoder]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Encoder {
    pub counts_per_rev: f64,
}

impl Default for Encoder {
    fn default() -> Self {
        Self {
            counts_per_rev: 10_000.0,
        }
    }
}

/// `[amplifier]`
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Amplifier {
    pub limit: Option<NumberOrRow>,
}

/// `[controller]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Controller {
    pub kp: f64,
    pub kd: f64,
    pub ki: f64,
    pub sample_time: f64,
    pub velocity_filter: VelocityFilter,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            kp: 9.0,
            kd: 0.19,
            ki: 4.0,
            sample_time: 1e-3,
            velocity_filter: VelocityFilter::default(),
        }
    }
}

/// `velocity_filter`
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct VelocityFilter {
    pub kind: VelocityKind,
    pub cutoff: Option<f64>,
}

/// The kinds of velocity estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(
    missing_docs,
    reason = "the variants are the names in the scenario file"
)]
pub enum VelocityKind {
    #[default]
    LowPass,
    Difference,
    AveragedDifference,
}

/// `[excitation]`: the keys of every kind; which of them a kind takes is judged later, so that
/// an error can point at the key.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Excitation {
    pub kind: ExcitationKind,
    pub power: Option<f64>,
    pub sample_time: Option<f64>,
    pub seed: Option<u32>,
    pub amplitude: Option<f64>,
    pub hold: Option<f64>,
    pub order: Option<u32>,
    pub amplitudes: Option<Vec<f64>>,
    pub frequencies: Option<Vec<f64>>,
    pub from: Option<f64>,
    pub to: Option<f64>,
    pub duration: Option<f64>,
    pub period: Option<f64>,
    pub levels: Option<Vec<f64>>,
}

/// The kinds of reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(
    missing_docs,
    reason = "the variants are the names in the scenario file"
)]
pub enum ExcitationKind {
    #[default]
    BandLimitedWhiteNoise,
    Prbs,
    Multisine,
    Chirp,
    Square,
    Steps,
    None,
}

/// `[compare]`
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Compare {
    pub load: Option<f64>,
    pub coulomb: Option<f64>,
    pub counts_per_rev: Option<f64>,
    pub limit: Option<f64>,
}

/// `[identifier]`: the keys of every law, judged like those of the excitation.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Identifier {
    pub law: LawName,
    pub gamma: Option<Vec<NumberOrRow>>,
    pub mu: Option<f64>,
    pub parameters: Option<Vec<Parameter>>,
    pub initial: Initial,
    pub bounds: Option<Bounds>,
    pub plant_box: Option<PlantBox>,
    pub correction: Option<Correction>,
    pub bandwidth: Option<f64>,
    pub max_speed: Option<f64>,
    pub arithmetic: Arithmetic,
    pub ranges: Option<FixedRanges>,
    pub uncertainty: Option<Uncertainty>,
    pub noise: Option<f64>,
    pub start_time: Option<f64>,
    pub memory: Option<f64>,
    pub relay: Option<f64>,
    pub forgetting: Option<f64>,
    pub filter_cutoff: Option<f64>,
    pub relay_delay: Option<f64>,
    pub proportional_gain: Option<f64>,
    pub block: Option<f64>,
}

/// The laws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(
    missing_docs,
    reason = "the variants are the names in the scenario file"
)]
pub enum LawName {
    #[default]
    Gradient,
    GaussNewton,
    Window,
    PdGradient,
    RelayLeastSquares,
    ProportionalLeastSquares,
    TwoDegreesOfFreedom,
    MultiStepLeastSquares,
    RelayCycle,
    TwoRelays,
    ClosedLoopArx,
    MechanicalLeastSquares,
}

impl LawName {
    /// The method for comparison of that name.
    #[must_use]
    pub fn baseline(self) -> Option<Baseline> {
        Some(match self {
            Self::Gradient | Self::GaussNewton | Self::Window | Self::PdGradient => return None,
            Self::RelayLeastSquares => Baseline::RelayLeastSquares,
            Self::ProportionalLeastSquares => Baseline::ProportionalLeastSquares,
            Self::TwoDegreesOfFreedom => Baseline::TwoDegreesOfFreedom,
            Self::MultiStepLeastSquares => Baseline::MultiStepLeastSquares,
            Self::RelayCycle => Baseline::RelayCycle,
            Self::TwoRelays => Baseline::TwoRelays,
            Self::ClosedLoopArx => Baseline::ClosedLoopArx,
            Self::MechanicalLeastSquares => Baseline::MechanicalLeastSquares,
        })
    }
}

/// The parameters that can be estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(
    missing_docs,
    reason = "the variants are the names in the scenario file"
)]
pub enum Parameter {
    A,
    B,
    Coulomb,
    Load,
}

/// The number formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(
    missing_docs,
    reason = "the variants are the names in the scenario file"
)]
pub enum Arithmetic {
    #[default]
    F32,
    F64,
    Fixed,
}

/// `initial`
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Initial {
    pub a: Option<f64>,
    pub b: Option<f64>,
    pub coulomb: Option<f64>,
    pub load: Option<f64>,
}

/// `bounds`
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Bounds {
    pub a: Option<[f64; 2]>,
    pub b: Option<[f64; 2]>,
    pub coulomb: Option<[f64; 2]>,
    pub load: Option<[f64; 2]>,
}

/// `correction`
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Correction {
    pub kp: f64,
    pub kd: f64,
    pub ki: f64,
}

/// `ranges`
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct FixedRanges {
    pub error: f64,
    pub velocity: f64,
    pub command: f64,
}

/// `uncertainty`
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Uncertainty {
    pub a: Option<f64>,
    pub b: Option<f64>,
    pub coulomb: Option<f64>,
    pub load: Option<f64>,
}

/// `[log]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Log {
    pub time: String,
    pub reference: Option<String>,
    pub position: String,
    pub command: Option<String>,
    pub injection: Option<String>,
    #[serde(default)]
    pub bridge_gaps: u32,
}

/// `plant_box`
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct PlantBox {
    pub a: [f64; 2],
    pub b: [f64; 2],
}

/// `[run]`
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the scenario file, see `keys`"
)]
pub struct Run {
    pub duration: f64,
}

impl Default for Run {
    fn default() -> Self {
        Self { duration: 60.0 }
    }
}

/// A number, or a row of numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum NumberOrRow {
    /// A number.
    Number(f64),
    /// A row.
    Row(Vec<f64>),
}

impl<'de> Deserialize<'de> for NumberOrRow {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;

        impl<'de> Visitor<'de> for Either {
            type Value = NumberOrRow;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a row of numbers")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<NumberOrRow, E> {
                Ok(NumberOrRow::Number(value))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<NumberOrRow, E> {
                Ok(NumberOrRow::Number(value as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut row: A) -> Result<NumberOrRow, A::Error> {
                let mut numbers = Vec::new();
                while let Some(number) = row.next_element()? {
                    numbers.push(number);
                }
                Ok(NumberOrRow::Row(numbers))
            }
        }

        deserializer.deserialize_any(Either)
    }
}
