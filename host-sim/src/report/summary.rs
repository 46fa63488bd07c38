use identifier_core::model::ServoParameters;
use identifier_core::stability::sampled_loop::AMPLE_GAIN_MARGIN;

use super::Statistics;
use crate::experiment::{Outcome, Sample};
use crate::scenario::Scenario;

/// The part of a run, at its end, over which tail means are taken.
const TAIL: f64 = 0.25;

/// How far from the truth an estimate may be and count as settled: b̂ within this fraction, â
/// within this many 1/s. The same tolerances say whether estimates have come to rest.
const SETTLED_B: f64 = 0.02;
const SETTLED_A: f64 = 0.1;

/// An estimate nearer to a bound than this fraction of its tolerance stands at it.
const AT_BOUND: f64 = 0.5;

/// The fraction of slowed samples from which a result says that the guard sets the pace.
const MOSTLY_SLOWED: f64 = 0.5;

/// What came out of an experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// The law's name.
    pub law: &'static str,
    /// The number format's name.
    pub arithmetic: &'static str,
    /// Sample time, s.
    pub sample_time: f64,
    /// What the run itself knows.
    pub outcome: Outcome,
    /// Whether the estimates have come to rest.
    pub status: Status,
    /// Why that status, and what else a user should know.
    pub reason: String,
    /// â, 1/s.
    pub a: Estimate,
    /// b̂, rad/s² per command unit.
    pub b: Estimate,
    /// d̂, rad/s², for laws that estimate it.
    pub load: Option<Estimate>,
    /// The true servo.
    pub truth: ServoParameters,
    /// Root mean square and largest magnitude of the output error, rad, for laws with a model.
    pub output_error: Option<(f64, f64)>,
    /// The last time at which â was outside ±0.1 1/s of the truth, s; none if it still was at the
    /// end.
    pub settling_a: Option<f64>,
    /// The last time at which b̂ was outside 2 % of the truth, s; none if it still was at the end.
    pub settling_b: Option<f64>,
}

/// One estimate over the run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// At the end.
    pub last: f64,
    /// Mean over the last quarter.
    pub tail_mean: f64,
    /// Standard deviation over the last quarter.
    pub tail_std: f64,
    /// How far it still had to go when the run ended, judged from the means over the thirds of the
    /// last quarter; infinite if its steps did not get shorter.
    pub to_go: f64,
}

/// Whether the estimates have come to rest. The truth plays no part in it: a drive does not know
/// it either.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Over the last quarter every estimate kept still.
    Converged,
    /// Some estimate still moved.
    NotConverged,
    /// The run ended early.
    Aborted,
}

impl Status {
    /// The status's name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::NotConverged => "not-converged",
            Self::Aborted => "aborted",
        }
    }
}

/// Gathers a [`Summary`] from the samples of a run.
#[derive(Debug, Clone)]
pub struct Summariser {
    tail_from: f64,
    duration: f64,
    truth: ServoParameters,
    sample_time: f64,
    a: Tracked,
    b: Tracked,
    load: Option<Tracked>,
    error_squares: Statistics,
    error_peak: f64,
    has_model: bool,
    outside_a: Option<f64>,
    outside_b: Option<f64>,
    end: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Tracked {
    last: f64,
    tail: Statistics,
    thirds: [Statistics; 3],
}

impl Tracked {
    fn add(&mut self, value: f64, third: Option<usize>) {
        self.last = value;
        if let Some(third) = third {
            self.tail.add(value);
            self.thirds[third].add(value);
        }
    }

    /// The estimate, with the tolerance within which it counts as being at rest.
    fn estimate(&self, tolerance: impl Fn(f64) -> f64) -> Estimate {
        let tail_mean = self.tail.mean().unwrap_or(self.last);
        let means = self.thirds.map(|third| third.mean().unwrap_or(self.last));
        Estimate {
            last: self.last,
            tail_mean,
            tail_std: self.tail.deviation().unwrap_or(0.0),
            to_go: distance_to_go(means, tolerance(tail_mean)),
        }
    }
}

/// Where a sequence that has passed three equally spaced values will still go.
///
/// An exponential approach shortens its steps by a constant ratio; the steps to come then sum to
/// d₂²/(d₁ − d₂). A last step below a tenth of the tolerance counts as none, one that is no shorter
/// than the step before as endless.
fn distance_to_go([first, second, third]: [f64; 3], tolerance: f64) -> f64 {
    const STILL: f64 = 0.1;
    let (before, last) = ((second - first).abs(), (third - second).abs());
    if last <= STILL * tolerance {
        0.0
    } else if last < before {
        last * last / (before - last)
    } else {
        f64::INFINITY
    }
}

impl Summariser {
    /// For a run of this scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            tail_from: (1.0 - TAIL) * scenario.duration,
            duration: scenario.duration,
            truth: scenario.plant,
            sample_time: scenario.controller.units.sample_time(),
            a: Tracked::default(),
            b: Tracked::default(),
            load: None,
            error_squares: Statistics::default(),
            error_peak: 0.0,
            has_model: false,
            outside_a: None,
            outside_b: None,
            end: 0.0,
        }
    }

    /// Takes in a sample.
    #[inline]
    pub fn add(&mut self, sample: &Sample) {
        let time = sample.time;
        let third = (time >= self.tail_from).then(|| {
            let passed = (time - self.tail_from) / (self.duration - self.tail_from);
            ((3.0 * passed) as usize).min(2)
        });
        self.a.add(sample.a, third);
        self.b.add(sample.b, third);
        if let Some(load) = sample.load {
            self.load.get_or_insert_default().add(load, third);
        }
        if let Some(error) = sample.output_error {
            self.has_model = true;
            self.error_squares.add(error * error);
            self.error_peak = self.error_peak.max(error.abs());
        }
        if (sample.a - self.truth.a).abs() > SETTLED_A {
            self.outside_a = Some(time);
        }
        if (sample.b - self.truth.b).abs() > SETTLED_B * self.truth.b {
            self.outside_b = Some(time);
        }
        self.end = time;
    }

    /// The summary of a run that has ended.
    #[must_use]
    pub fn finish(self, scenario: &Scenario, outcome: Outcome) -> Summary {
        let (a, b) = (self.a.estimate(tolerance_a), self.b.estimate(tolerance_b));
        let (status, reason) = verdict(&a, &b, &outcome);
        let still_outside = |outside: Option<f64>| outside.is_some_and(|time| time >= self.end);
        let settling = |outside: Option<f64>| {
            (status != Status::Aborted && !still_outside(outside))
                .then(|| outside.map_or(0.0, |time| time + self.sample_time))
        };
        Summary {
            law: scenario.identifier.law.name(),
            arithmetic: scenario.identifier.arithmetic.name(),
            sample_time: self.sample_time,
            outcome,
            status,
            reason,
            a,
            b,
            load: self.load.map(|load| load.estimate(tolerance_b)),
            truth: self.truth,
            output_error: self.has_model.then(|| {
                let mean_square = self.error_squares.mean().unwrap_or(0.0);
                (mean_square.sqrt(), self.error_peak)
            }),
            settling_a: settling(self.outside_a),
            settling_b: settling(self.outside_b),
        }
    }
}

/// Within what â is at rest, 1/s.
fn tolerance_a(a: f64) -> f64 {
    SETTLED_A.max(SETTLED_B * a.abs())
}

/// Within what b̂ is at rest, rad/s² per command unit.
fn tolerance_b(b: f64) -> f64 {
    SETTLED_B * b.abs()
}

fn verdict(a: &Estimate, b: &Estimate, outcome: &Outcome) -> (Status, String) {
    if let Some(abort) = outcome.abort {
        return (
            Status::Aborted,
            format!("aborted after {:.3} s: {}", abort.time, abort.error),
        );
    }
    let estimates = [
        ("a", a, tolerance_a(a.tail_mean), "1/s"),
        ("b", b, tolerance_b(b.tail_mean), "rad/s² per command unit"),
    ];
    let restless = estimates
        .into_iter()
        .find(|(_, estimate, limit, _)| estimate.tail_std.max(estimate.to_go) > *limit);
    let held = estimates
        .into_iter()
        .zip(outcome.bounds.into_iter().flatten())
        .find(|((_, estimate, limit, _), bounds)| {
            let near = |bound: f64| (estimate.tail_mean - bound).abs() < AT_BOUND * limit;
            // A lower bound of zero on a is no obstacle but a fact: friction is never negative.
            near(bounds.max()) || (bounds.min() > 0.0 && near(bounds.min()))
        });
    let (status, mut reason) = match (restless, held) {
        (None, None) => (
            Status::Converged,
            "every estimate kept still over the last quarter of the run".to_owned(),
        ),
        (Some((name, estimate, limit, unit)), _) => (
            Status::NotConverged,
            format!(
                "{name} still moved over the last quarter of the run: standard deviation {:.4}, \
                 distance to go {:.4}, at rest below {limit:.4} {unit}",
                estimate.tail_std, estimate.to_go
            ),
        ),
        (None, Some(((name, estimate, _, unit), bounds))) => (
            Status::NotConverged,
            format!(
                "{name} = {:.4} {unit} stands at the end of its bounds, {} to {}: widen them, or \
                 look for what the model lacks",
                estimate.tail_mean,
                bounds.min(),
                bounds.max()
            ),
        ),
    };
    let slowed = outcome.slowed as f64 / outcome.samples.max(1) as f64;
    if slowed > MOSTLY_SLOWED {
        reason.push_str(&format!(
            "; the guard slowed {:.0} % of the updates: gamma is larger than the sample time bears",
            100.0 * slowed
        ));
    }
    if let Some(margin) = outcome.gain_margin
        && margin < AMPLE_GAIN_MARGIN
    {
        reason.push_str(&format!(
            "; the sampled loop keeps a gain margin of only {margin:.1} over the box: below \
             {AMPLE_GAIN_MARGIN} the estimates may wander, sample faster or lower the gains"
        ));
    }
    if outcome.restarts > 0 {
        reason.push_str(&format!(
            "; the model loop ran away and was started again {} times: check gains and limit",
            outcome.restarts
        ));
    }
    (status, reason)
}
