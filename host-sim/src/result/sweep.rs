//! The result of a sweep.

use identifier_core::parameters::{Parameter, ServoParameters};
use serde::Serialize;

use identifier_log::verdict::Status;

/// The result of a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepResult {
    /// The estimator's name.
    pub law: &'static str,
    /// The seed of servos and references.
    pub seed: u32,
    /// Servos that were asked for.
    pub wanted: u32,
    /// Distribution over the servos that were run.
    #[serde(flatten)]
    pub distribution: Distribution,
}

/// The result of one servo.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRun {
    /// Its number in the sweep.
    pub index: u32,
    /// The servo.
    pub truth: ServoParameters,
    /// Reliability of the estimates.
    pub status: Status,
    /// Mean of each estimate over the tail; NaN where there is none.
    pub found: ServoParameters,
    /// Time from which on â was within ±0.1 1/s, s.
    pub settling_a: Option<f64>,
    /// Time from which on b̂ was within 2 %, s.
    pub settling_b: Option<f64>,
}

impl SweepRun {
    /// Estimate less truth.
    #[must_use]
    pub fn error(&self, parameter: Parameter) -> f64 {
        self.found.get(parameter) - self.truth.get(parameter)
    }
}

/// The distribution over a sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distribution {
    /// Servos that were run.
    pub runs: usize,
    /// The number of servos whose estimates are reliable.
    pub converged: usize,
    /// The gain may be relied on, and another unknown may not.
    pub partial: usize,
    /// The model lacks something that moves the estimates.
    pub unexplained: usize,
    /// The data say too little of an unknown.
    pub no_information: usize,
    /// Estimates still moved.
    pub moving: usize,
    /// The run ended early.
    pub aborted: usize,
    /// The quantities, with their quantiles.
    pub spreads: Vec<Spread>,
}

/// The distribution of one quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// Its name.
    #[serde(rename = "quantity")]
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Servos that have a value.
    pub count: usize,
    /// The quantiles of these.
    #[serde(flatten)]
    pub quantiles: Quantiles,
}

/// Quantiles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(missing_docs, reason = "each is the quantile of that name, in percent")]
pub struct Quantiles {
    pub q05: f64,
    pub q25: f64,
    pub q50: f64,
    pub q75: f64,
    pub q95: f64,
    pub max: f64,
}

impl Quantiles {
    /// They all, ascending, each with the share of the servos that are no worse.
    #[must_use]
    pub fn named(&self) -> [(&'static str, f64); 6] {
        [
            ("5 %", self.q05),
            ("25 %", self.q25),
            ("50 %", self.q50),
            ("75 %", self.q75),
            ("95 %", self.q95),
            ("largest", self.max),
        ]
    }

    /// Percentiles of values in ascending order, at least one: the smallest value that this percentage
    /// does not exceed.
    fn from_sorted(sorted: &[f64]) -> Self {
        let at = |part: f64| {
            let place = (part * sorted.len() as f64).ceil().max(1.0) as usize - 1;
            sorted[place.min(sorted.len() - 1)]
        };
        Self {
            q05: at(0.05),
            q25: at(0.25),
            q50: at(0.5),
            q75: at(0.75),
            q95: at(0.95),
            max: at(1.0),
        }
    }
}

impl Distribution {
    /// The distribution over these runs.
    #[must_use]
    pub fn new(runs: &[SweepRun]) -> Self {
        let with = |status| runs.iter().filter(|run| run.status == status).count();
        let error = |parameter: Parameter| move |run: &SweepRun| Some(run.error(parameter).abs());
        let spreads = [
            spread("|â − a|", "1/s", runs, error(Parameter::A)),
            spread("|b̂/b − 1|", "%", runs, |run| {
                Some(100.0 * run.error(Parameter::B).abs() / run.truth.b)
            }),
            spread("|ĉ − c|", "rad/s²", runs, error(Parameter::Coulomb)),
            spread("|d̂ − d|", "rad/s²", runs, error(Parameter::Load)),
            spread("a settled", "s", runs, |run| run.settling_a),
            spread("b settled", "s", runs, |run| run.settling_b),
        ];
        Self {
            runs: runs.len(),
            converged: with(Status::Converged),
            partial: with(Status::Partial),
            unexplained: with(Status::Unexplained),
            no_information: with(Status::NoInformation),
            moving: with(Status::Moving),
            aborted: with(Status::Aborted),
            spreads: spreads.into_iter().flatten().collect(),
        }
    }
}

fn spread(
    name: &'static str,
    unit: &'static str,
    runs: &[SweepRun],
    of: impl Fn(&SweepRun) -> Option<f64>,
) -> Option<Spread> {
    let mut sorted: Vec<f64> = runs
        .iter()
        .filter(|run| run.status != Status::Aborted)
        .filter_map(of)
        .filter(|value| value.is_finite())
        .collect();
    sorted.sort_unstable_by(f64::total_cmp);
    (!sorted.is_empty()).then(|| Spread {
        name,
        unit,
        count: sorted.len(),
        quantiles: Quantiles::from_sorted(&sorted),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_that_occur() {
        let sorted: Vec<f64> = (1..=100).map(f64::from).collect();
        let quantiles = Quantiles::from_sorted(&sorted);
        let found = [quantiles.q05, quantiles.q50, quantiles.max];
        let alone = Quantiles::from_sorted(&[7.0]).q95;
        assert_eq!((found, alone), ([5.0, 50.0, 100.0], 7.0));
    }
}
