use identifier_core::model::ServoParameters;
use identifier_core::parameters::Parameter;
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

/// An estimate that is at a bound for more than this part of the run's end stands there.
const AT_BOUND: f64 = 0.5;

/// An estimate nearer to zero than this fraction of its tolerance is none.
const AT_ZERO: f64 = 0.5;

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
    /// The parameters that the law estimates.
    pub estimated: Vec<Parameter>,
    /// â, 1/s; constant if it is not estimated.
    pub a: Estimate,
    /// b̂, rad/s² per command unit; constant if it is not estimated.
    pub b: Estimate,
    /// ĉ, rad/s²; constant if it is not estimated.
    pub coulomb: Estimate,
    /// d̂, rad/s²; constant if it is not estimated.
    pub load: Estimate,
    /// The true servo, where it is known.
    pub truth: Option<ServoParameters>,
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
    /// At the end; NaN, like all that follows from it, if the method then had none.
    pub last: f64,
    /// Mean over the last quarter.
    pub tail_mean: f64,
    /// Standard deviation over the last quarter.
    pub tail_std: f64,
    /// How far it still had to go when the run ended, judged from the means over the thirds of the
    /// last quarter; infinite if its steps did not get shorter.
    pub to_go: f64,
    /// The standard error at the end, for laws that have one.
    pub std_error: Option<f64>,
    /// Whether it stood at a bound for most of the last quarter: such a value is no result.
    pub at_bound: bool,
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
    truth: Option<ServoParameters>,
    sample_time: f64,
    tracked: [Tracked; 4],
    standard_errors: Option<ServoParameters>,
    command_squares: Statistics,
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
    samples: f64,
    at_bound: f64,
}

impl Tracked {
    fn add(&mut self, value: f64, at_bound: bool, third: Option<usize>) {
        self.last = value;
        if third.is_some() {
            self.samples += 1.0;
            self.at_bound += f64::from(u8::from(at_bound));
        }
        if !value.is_finite() {
            return;
        }
        if let Some(third) = third {
            self.tail.add(value);
            self.thirds[third].add(value);
        }
    }

    /// The estimate, with the tolerance within which it counts as being at rest.
    fn estimate(&self, tolerance: impl Fn(f64) -> f64, std_error: Option<f64>) -> Estimate {
        if !self.last.is_finite() {
            return Estimate {
                last: f64::NAN,
                tail_mean: f64::NAN,
                tail_std: f64::NAN,
                to_go: f64::NAN,
                std_error: None,
                at_bound: false,
            };
        }
        let tail_mean = self.tail.mean().unwrap_or(self.last);
        let tail_std = self.tail.deviation().unwrap_or(0.0);
        let means = self.thirds.map(|third| third.mean().unwrap_or(self.last));
        Estimate {
            last: self.last,
            tail_mean,
            tail_std,
            to_go: distance_to_go(means, tolerance(tail_mean), tail_std),
            std_error,
            at_bound: self.at_bound > AT_BOUND * self.samples,
        }
    }
}

/// Where a sequence that has passed three equally spaced values will still go.
///
/// An exponential approach shortens its steps by a constant ratio; the steps to come then sum to
/// d₂²/(d₁ − d₂). A last step counts as none if it is below a quarter of the tolerance, or so small
/// beside the standard deviation over the whole stretch that noise explains it (a steady drift has
/// steps of 1.15 standard deviations). One that is no shorter than the step before is endless.
fn distance_to_go([first, second, third]: [f64; 3], tolerance: f64, deviation: f64) -> f64 {
    const STILL: f64 = 0.25;
    const NOISE: f64 = 0.7;
    let (before, last) = ((second - first).abs(), (third - second).abs());
    if last <= (STILL * tolerance).max(NOISE * deviation) {
        0.0
    } else if last < before {
        last * last / (before - last)
    } else {
        f64::INFINITY
    }
}

/// The parameters in the order of [`Summariser::tracked`].
const PARAMETERS: [Parameter; 4] = [
    Parameter::A,
    Parameter::B,
    Parameter::Coulomb,
    Parameter::Load,
];

impl Summariser {
    /// For a run of this scenario.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        Self::lasting(scenario, scenario.duration)
    }

    /// For a run that lasts so long, s.
    #[must_use]
    pub fn lasting(scenario: &Scenario, duration: f64) -> Self {
        Self {
            tail_from: (1.0 - TAIL) * duration,
            duration,
            truth: scenario.plant,
            sample_time: scenario.sample_time(),
            tracked: [Tracked::default(); 4],
            standard_errors: None,
            command_squares: Statistics::default(),
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
        for (tracked, parameter) in self.tracked.iter_mut().zip(PARAMETERS) {
            let at_bound = sample.at_bounds.of(parameter);
            tracked.add(parameter.of(&sample.estimates), at_bound, third);
        }
        self.standard_errors = sample.standard_errors;
        self.command_squares.add(sample.command * sample.command);
        if let Some(error) = sample.output_error {
            self.has_model = true;
            self.error_squares.add(error * error);
            self.error_peak = self.error_peak.max(error.abs());
        }
        if let Some(truth) = &self.truth {
            let within = |off: f64, tolerance: f64| off.abs() <= tolerance;
            // No estimate is outside too.
            if !within(sample.estimates.a - truth.a, SETTLED_A) {
                self.outside_a = Some(time);
            }
            if !within(sample.estimates.b - truth.b, SETTLED_B * truth.b) {
                self.outside_b = Some(time);
            }
        }
        self.end = time;
    }

    /// An acceleration that friction and load are small beside, rad/s²: what the proportional gain
    /// gives the servo of the initial estimate for an error of one, or else ten times what the command
    /// gave the servo that was found.
    fn usual_acceleration(&self, scenario: &Scenario) -> f64 {
        let given = &scenario.stated;
        let kp = match given.controller {
            Some(controller) => Some(controller.kp),
            None => given.correction_gains().ok().map(|gains| gains.kp()),
        };
        let stated = given.identifier.initial.b.zip(kp).map(|(b, kp)| b * kp);
        stated.unwrap_or_else(|| {
            let [_, b, ..] = &self.tracked;
            10.0 * b.last.abs() * self.command_squares.mean().unwrap_or(0.0).sqrt()
        })
    }

    /// The summary of a run that has ended.
    #[must_use]
    pub fn finish(self, scenario: &Scenario, outcome: Outcome) -> Summary {
        let usual = self.usual_acceleration(scenario);
        let estimates: [Estimate; 4] = std::array::from_fn(|i| {
            let parameter = PARAMETERS[i];
            let std_error = self.standard_errors.map(|errors| parameter.of(&errors));
            self.tracked[i].estimate(|value| tolerance(parameter, value, usual), std_error)
        });
        let estimated = scenario.estimated();
        let (status, reason) = verdict(&estimates, scenario, usual, &outcome);
        let still_outside = |outside: Option<f64>| outside.is_some_and(|time| time >= self.end);
        let known = self.truth.is_some() && status != Status::Aborted;
        let settling = |outside: Option<f64>| {
            (known && !still_outside(outside))
                .then(|| outside.map_or(0.0, |time| time + self.sample_time))
        };
        let [a, b, coulomb, load] = estimates;
        Summary {
            law: scenario.identifier.law.name(),
            arithmetic: scenario.identifier.arithmetic.name(),
            sample_time: self.sample_time,
            outcome,
            status,
            reason,
            estimated,
            a,
            b,
            coulomb,
            load,
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

impl Summary {
    /// One estimate; none if the law does not estimate the parameter.
    #[must_use]
    pub fn estimate(&self, parameter: Parameter) -> Option<&Estimate> {
        let estimate = match parameter {
            Parameter::A => &self.a,
            Parameter::B => &self.b,
            Parameter::Coulomb => &self.coulomb,
            Parameter::Load => &self.load,
        };
        self.estimated.contains(&parameter).then_some(estimate)
    }
}

/// The unit of a parameter.
#[must_use]
pub fn unit(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::A => "1/s",
        Parameter::B => "rad/s² per command unit",
        Parameter::Coulomb | Parameter::Load => "rad/s²",
    }
}

/// Within what an estimate is at rest, in the parameter's unit. Friction and load are compared to
/// what the loop's command does: a fiftieth of a hundredth of an acceleration of the servo.
fn tolerance(parameter: Parameter, value: f64, acceleration: f64) -> f64 {
    let relative = SETTLED_B * value.abs();
    match parameter {
        Parameter::A => SETTLED_A.max(relative),
        Parameter::B => relative,
        Parameter::Coulomb | Parameter::Load => (2e-4 * acceleration).max(relative),
    }
}

fn verdict(
    estimates: &[Estimate; 4],
    scenario: &Scenario,
    acceleration: f64,
    outcome: &Outcome,
) -> (Status, String) {
    if let Some(abort) = &outcome.abort {
        let cause = match scenario.unstable_loop() {
            Some(unstable) => unstable.to_string(),
            None => abort.error.to_string(),
        };
        return (
            Status::Aborted,
            format!("aborted after {:.3} s: {cause}", abort.time),
        );
    }
    if estimates.iter().any(|estimate| !estimate.last.is_finite()) {
        let why = outcome
            .failure
            .unwrap_or("what it found at the end cannot be a servo");
        return (Status::NotConverged, format!("no estimate: {why}"));
    }
    let of_law = PARAMETERS
        .into_iter()
        .zip(estimates)
        .filter(|(parameter, _)| scenario.identifier.estimates(*parameter))
        .map(|(parameter, estimate)| {
            let limit = tolerance(parameter, estimate.tail_mean, acceleration);
            (parameter, estimate, limit)
        });
    let restless = of_law
        .clone()
        .find(|(_, estimate, limit)| estimate.tail_std.max(estimate.to_go) > *limit);
    // A lower bound of zero on friction is no obstacle but a fact: it is never negative.
    let held = of_law.clone().find(|(_, estimate, limit)| {
        estimate.at_bound && estimate.tail_mean.abs() > AT_ZERO * limit
    });
    let (status, mut reason) = match (restless, held) {
        (None, None) => (
            Status::Converged,
            "every estimate kept still over the last quarter of the run".to_owned(),
        ),
        (Some((parameter, estimate, limit)), _) => (
            Status::NotConverged,
            format!(
                "{} still moved over the last quarter of the run: standard deviation {:.4}, \
                 distance to go {:.4}, at rest below {limit:.4} {}",
                parameter.name(),
                estimate.tail_std,
                estimate.to_go,
                unit(parameter)
            ),
        ),
        (None, Some((parameter, estimate, _))) => (
            Status::NotConverged,
            format!(
                "{} = {:.4} {} stands at a bound: widen it, or look for what the model lacks",
                parameter.name(),
                estimate.tail_mean,
                unit(parameter),
            ),
        ),
    };
    let slowed = outcome.events.slowed as f64 / outcome.samples.max(1) as f64;
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
    let events = &outcome.events;
    if events.restarted > 0 {
        reason.push_str(&format!(
            "; the model loop ran away and was started again {} times: check gains and sample time",
            events.restarted
        ));
    }
    if events.not_following > 0 {
        reason.push_str(&format!(
            "; in {} samples the servo did not follow its command: check the amplifier, and that the \
             command is the one that acted",
            events.not_following
        ));
    }
    (status, reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The distance that a course over the last quarter still has to go.
    fn to_go(course: impl Fn(f64) -> f64, tolerance: f64) -> f64 {
        let mut tracked = Tracked::default();
        for k in 0..3000 {
            tracked.add(
                course(f64::from(k) / 3000.0),
                false,
                Some(k as usize / 1000),
            );
        }
        tracked.estimate(|_| tolerance, None).to_go
    }

    #[test]
    fn an_exponential_approach_is_seen_through() {
        // From 0 to 1 with a time constant of one stretch: e⁻¹ is left at its end.
        let left = to_go(|t| 1.0 - (-t).exp(), 0.1);
        assert!((0.3..0.6).contains(&left), "{left}");
    }

    #[test]
    fn a_steady_drift_is_endless_and_noise_is_no_drift() {
        assert!(to_go(|t| t, 0.1).is_infinite());
        let noise = to_go(|t| 0.3 * (1234.5 * t).sin(), 0.1);
        assert!(noise < 1e-12, "{noise}");
        assert!(to_go(|t| 0.01 * t, 0.1) < 1e-12, "far below the tolerance");
    }
}
