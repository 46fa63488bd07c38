//! A result of `run` or `identify`, read back from its JSON.

use std::collections::BTreeMap;

use serde::Deserialize;

use identifier_core::parameters::Parameter;

use super::{EnteredEffect, Reading, SecondMode, SensorNoise, Summary};
use crate::provenance::Origin;

/// A result of `run` or `identify` as far as gains, exports and firmware need it, SI.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct KeptResult {
    /// The estimator's name.
    #[serde(default)]
    pub law: String,
    /// The name of the verdict's status.
    pub status: String,
    /// The verdict's reason, and its number.
    #[serde(default)]
    pub reason: String,
    /// See `reason`.
    #[serde(default)]
    pub code: u8,
    /// Sample time, s.
    pub sample_time: f64,
    /// The unit of the position; none of an earlier version.
    #[serde(default)]
    pub position_unit: Option<String>,
    /// The estimates by the names of their unknowns; none for one that was not estimated.
    pub estimates: BTreeMap<String, Option<KeptEstimate>>,
    /// Their covariance.
    #[serde(default)]
    pub covariance: Option<KeptCovariance>,
    /// The output error over the end.
    #[serde(default)]
    pub residual: Option<KeptResidual>,
    /// The noise of the sensor.
    #[serde(default)]
    pub noise: SensorNoise,
    /// The logs that it is from; none of a simulated servo.
    #[serde(default)]
    pub logs: Vec<KeptLog>,
    /// Its provenance.
    #[serde(default)]
    pub origin: Option<Origin>,
    /// Findings of a fit to the whole record.
    #[serde(default)]
    pub fit: Option<KeptFit>,
    /// How the columns of its log were read.
    #[serde(default)]
    pub reading: Option<Reading>,
}

/// Findings of a fit to a whole record.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct KeptFit {
    /// The effects that the record shows.
    pub effects: Vec<KeptEffect>,
    /// What the record says of a second mode; none of an earlier version.
    #[serde(default)]
    pub second_modes: Option<Vec<SecondMode>>,
}

/// An effect that a record shows.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct KeptEffect {
    /// Its name.
    pub name: String,
    /// Sizes that are no estimates, by name.
    #[serde(default)]
    pub sizes: BTreeMap<String, f64>,
    /// Their standard errors.
    #[serde(default)]
    pub std_errors: BTreeMap<String, f64>,
}

/// An estimate, SI.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct KeptEstimate {
    /// None where the motion contains no information on it.
    pub value: Option<f64>,
    /// None where it is not known, or infinite.
    pub std_error: Option<f64>,
}

/// The output error over the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct KeptResidual {
    /// Root mean square, rad.
    pub rms: Option<f64>,
}

/// A log that was replayed.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct KeptLog {
    /// The smallest step of its position, rad.
    pub resolution: f64,
    /// The largest magnitude of its command, command units; none without a command.
    pub largest_command: Option<f64>,
}

/// A text that is no result.
#[derive(Debug, thiserror::Error)]
#[error("this is not a result that `run` or `identify` wrote with --json: {0}")]
pub struct NoResult(#[from] serde_json::Error);

impl KeptResult {
    /// Reads the JSON of a result.
    ///
    /// # Errors
    /// The line, and the key that is missing or holds what is not allowed.
    pub fn read(json: &str) -> Result<Self, NoResult> {
        Ok(serde_json::from_str(json)?)
    }

    /// The standard error of an estimate; none where it is not known.
    #[must_use]
    pub fn std_error(&self, name: &str) -> Option<f64> {
        self.estimates.get(name)?.as_ref()?.std_error
    }
}

impl From<&Summary> for KeptResult {
    fn from(result: &Summary) -> Self {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let kept = |name: &str, value, std_error: Option<f64>| {
            let value = finite(value);
            let std_error = std_error.and_then(finite);
            (name.to_owned(), Some(KeptEstimate { value, std_error }))
        };
        let parameters = Parameter::ALL.into_iter().filter_map(|parameter| {
            let estimate = result.estimate(parameter)?;
            Some(kept(parameter.name(), estimate.value, estimate.std_error))
        });
        let terms = result.estimates.terms.iter();
        let terms = terms.map(|of| kept(of.unknown.name(), of.value, Some(of.std_error)));
        let covariance = result.covariance.as_ref().map(|of| KeptCovariance {
            names: of.names.iter().map(|name| (*name).to_owned()).collect(),
            matrix: (of.matrix.iter())
                .map(|row| row.iter().copied().map(finite).collect())
                .collect(),
        });
        let logs = result.replay.logs.iter().map(|log| KeptLog {
            resolution: log.resolution,
            largest_command: log.largest_command,
        });
        Self {
            law: result.law.to_owned(),
            status: result.status().name().to_owned(),
            reason: result.reason.clone(),
            code: result.verdict.reason.code(),
            sample_time: result.sample_time,
            position_unit: Some(result.position_unit.name().to_owned()),
            estimates: parameters.chain(terms).collect(),
            covariance,
            residual: result.residual.map(|of| KeptResidual {
                rms: finite(of.rms),
            }),
            noise: result.noise,
            logs: logs.collect(),
            origin: None,
            fit: result.fit.as_ref().map(|fit| KeptFit {
                effects: fit.effects.iter().map(KeptEffect::from).collect(),
                second_modes: Some(fit.second_modes.clone()),
            }),
            reading: result.reading.clone(),
        }
    }
}

impl From<&EnteredEffect> for KeptEffect {
    fn from(effect: &EnteredEffect) -> Self {
        let by_name = |sizes: &[(&'static str, f64)]| {
            let sizes = sizes.iter();
            sizes
                .map(|(name, size)| ((*name).to_owned(), *size))
                .collect()
        };
        Self {
            name: effect.name.to_owned(),
            sizes: by_name(&effect.sizes),
            std_errors: by_name(&effect.std_errors),
        }
    }
}

/// The covariance of estimates, SI; none in it where nothing is known.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct KeptCovariance {
    /// Their names, in the order of rows and columns.
    pub names: Vec<String>,
    /// By rows.
    pub matrix: Vec<Vec<Option<f64>>>,
}

impl KeptCovariance {
    /// That of two estimates by their names.
    #[must_use]
    pub fn of(&self, one: &str, other: &str) -> Option<f64> {
        let place = |name: &str| self.names.iter().position(|own| own == name);
        *self.matrix.get(place(one)?)?.get(place(other)?)?
    }
}
