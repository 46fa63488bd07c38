//! A commissioning, judged by the true motion of the servo.

use commissioning::Phase;
use host_sim::commission::{Commissioning, Outcome, Sample, StepResponse};
use host_sim::scenario::Scenario;
use integration_tests::Random;

/// Rise time against the prediction, and overshoot beyond it.
pub(super) const RISE: f64 = 0.15;
pub(super) const OVERSHOOT: f64 = 0.03;

/// Overshoot of a step that counts as none.
pub(super) const SMALL_OVERSHOOT: f64 = 0.03;

/// A commissioning that has run, with its violations.
#[derive(Debug, Clone)]
pub(super) struct Judged {
    pub(super) outcome: Outcome,
    /// True performance of the applied gains.
    pub(super) kept: Option<Kept>,
    /// Violations of the guarantees.
    pub(super) broken: Vec<String>,
}

/// True performance of the applied gains against the prediction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kept {
    /// Excess of the rise time beyond the predicted range, relative to the nearer end; infinite if it never rose.
    pub(super) rise: f64,
    /// Overshoot, and overshoot beyond the predicted and half a count, as a part of the step.
    pub(super) whole_overshoot: f64,
    pub(super) overshoot: f64,
    /// Final error of the step, relative to it.
    pub(super) left_over: f64,
}

impl Kept {
    /// True if the predicted response is met.
    pub(super) fn is_kept(&self) -> bool {
        self.rise.abs() <= RISE && self.overshoot <= OVERSHOOT
    }
}

/// Commissions a scenario's servo. In each sample the background does a random number of slices of work, whose mean over
/// those that it should do is random too, a half to two.
pub(super) fn commission(scenario: &Scenario) -> Judged {
    observed(scenario, &mut |_| {})
}

/// The same, with every sample shown to `observe`.
pub(super) fn observed(scenario: &Scenario, observe: &mut dyn FnMut(&Sample)) -> Judged {
    let commissioning = Commissioning::new(scenario).expect("it was built when it was read");
    let limits = commissioning.settings().limits;
    let before = commissioning.gains_before().copied();
    let count = scenario.stated.resolution;
    let mut broken = Vec::new();
    let mut coasts = None;
    let mut last = Phase::Idle;
    let mut random = Random::new(scenario.noise_seed());
    let speed = random.log_uniform(0.5, 2.0);
    let mut background =
        |slices: u32| (random.uniform(0.0, 2.0) * speed * f64::from(slices)).round() as u32;
    let outcome = commissioning
        .run_beside(&mut background, &mut |sample| {
            observe(sample);
            if sample.phase.is_end() {
                coasts = Some(sample.command.is_none());
            }
            last = sample.phase;
            let [low, high] = limits.command;
            if sample.command.is_some_and(|u| !(low..=high).contains(&u)) {
                broken.push(format!("command {:?} at {} s", sample.command, sample.time));
            }
        })
        .expect("it was built when it was read");
    let gone = outcome.course.excursion();
    let ([low, high], [lowest, highest]) = (limits.travel, gone.position);
    // A count is the least that the drive can see.
    if lowest < low - count || highest > high + count {
        broken.push(format!(
            "travel left: {lowest:.4} to {highest:.4} of {low:.4} to {high:.4} rad"
        ));
    }
    if gone.speed > limits.speed {
        broken.push(format!(
            "speed {:.3} of {:.3} rad/s",
            gone.speed, limits.speed
        ));
    }
    match outcome.end {
        None => broken.push(format!("it never ended in {}", last.name())),
        Some(end) if end.phase != Phase::Applied => {
            if end.reason.is_none() {
                broken.push("no reason is given".to_owned());
            }
            if before.is_none() && coasts == Some(false) {
                broken.push("gains that failed are kept".to_owned());
            }
            if last != end.phase {
                broken.push(format!(
                    "it went on from {} to {}",
                    end.phase.name(),
                    last.name()
                ));
            }
        }
        Some(_) => {}
    }
    let kept = outcome
        .is_applied()
        .then(|| kept(scenario, &outcome).expect("applied gains can be judged"));
    if let Some(kept) = kept
        && kept.left_over > 0.5
    {
        broken.push(format!(
            "unstable: {:.2} of the step is left",
            kept.left_over
        ));
    }
    Judged {
        outcome,
        kept,
        broken,
    }
}

/// The applied gains on the true servo, by its exact position.
fn kept(scenario: &Scenario, outcome: &Outcome) -> Option<Kept> {
    let predicted_response = outcome.tuning?.predicted_response;
    let response = StepResponse::in_truth(scenario, outcome)?;
    // A servo with friction is predicted a range of rise times.
    let [quickest, slowest] = [
        predicted_response.quickest_rise_time,
        predicted_response.rise_time,
    ];
    let off = |rise: f64| (rise / slowest - 1.0).max(0.0) + (rise / quickest - 1.0).min(0.0);
    Some(Kept {
        rise: response.rise_time().map_or(f64::INFINITY, off),
        whole_overshoot: response.overshoot(),
        overshoot: response.overshoot()
            - predicted_response.overshoot
            - 0.5 * scenario.stated.resolution / response.step(),
        left_over: response.left_over(),
    })
}
