//! A loop that is certified, and stable when sampled, does not diverge; a run that does not converge reports it.

use host_sim::scenario::{Scenario, Velocity};
use identifier_core::control::Gains;
use identifier_core::interval::Interval;
use identifier_core::settings::{ControllerSettings, ParameterRangeSettings};
use identifier_core::stability::SampledLoop;
use identifier_core::stability::{Certificate, ParameterRange};
use identifier_log::result::Summary;
use identifier_log::verdict::Status;
use integration_tests::{Random, factor, in_parallel, run, servo};
use servo_id::paper::{self, Case, Method};

/// A random parameter range.
fn random_range(random: &mut Random) -> ParameterRange {
    let a_min = random.uniform(0.0, 10.0);
    let a_max = a_min + random.log_uniform(0.1, 50.0);
    let b_min = random.log_uniform(1.0, 500.0);
    let b_max = b_min * random.log_uniform(1.0, 10.0);
    ParameterRange::new(
        Interval::new("a", a_min, a_max).expect("ordered"),
        Interval::new("b", b_min, b_max).expect("ordered"),
    )
    .expect("positive")
}

fn random_gains(random: &mut Random) -> Gains {
    Gains::new(
        random.log_uniform(0.5, 50.0),
        random.log_uniform(0.01, 2.0),
        random.log_uniform(0.1, 50.0),
    )
    .expect("positive")
}

/// A random servo of a parameter range.
fn random_servo(random: &mut Random, parameter_range: &ParameterRange) -> (f64, f64) {
    let (a, b) = (parameter_range.a(), parameter_range.b());
    (
        random.uniform(a.min(), a.max()),
        random.log_uniform(b.min(), b.max()),
    )
}

/// A random scenario whose box is certified and whose sampled loop is stable, under a Γ that is
/// `excess` times the automatic one.
fn random_scenario(random: &mut Random, excess: f64) -> Option<Scenario> {
    let mut scenario = paper::scenario(Method::Proposed, Case::Balanced);
    let parameter_range = random_range(random);
    let gains = random_gains(random);
    Certificate::with_automatic_mu(&gains, &parameter_range).ok()?;
    scenario.velocity = match random.uniform(0.0, 3.0) as u32 {
        0 => {
            scenario.stated.cutoff = random.log_uniform(100.0, 2000.0);
            Velocity::LowPass
        }
        1 => Velocity::Difference,
        _ => Velocity::AveragedDifference,
    };
    let (a, b) = random_servo(random, &parameter_range);
    let plant = servo(&mut scenario);
    plant.a = a;
    plant.b = b;
    plant.load = random.uniform(-0.06, 0.06) * b * gains.kp();
    let limit = random.log_uniform(0.5, 10.0) * gains.kp();
    let own = ControllerSettings::pid(gains.kp(), gains.kd(), gains.ki());
    scenario.stated.controller = Some(own.limited(limit));
    // Below the parameter range or inside it: far above, the sampled model loop has no gain margin left.
    let start = random.log_uniform(0.2 * parameter_range.b().min(), parameter_range.b().max());
    let learning = &mut scenario.stated.identifier;
    learning.initial.b = Some(start);
    learning.parameter_range = Some(ParameterRangeSettings {
        a: [parameter_range.a().min(), parameter_range.a().max()],
        b: [parameter_range.b().min(), parameter_range.b().max()],
    });
    learning.bounds.b = Some([start.min(b) / 2.0, 10.0 * b]);
    learning.mu = None;
    learning.gamma = None;
    let mut scenario = scenario.with_gamma_chosen();
    let gamma = scenario.stated.identifier.gamma.as_mut()?;
    for entry in [&mut gamma.a, &mut gamma.b] {
        *entry *= excess;
    }
    scenario.buildable().is_ok().then_some(scenario)
}

/// Runs `count` random scenarios with Γ excesses of a range.
fn search(seed: u32, count: usize, excess: (f64, f64)) -> Vec<(Scenario, Summary)> {
    let mut random = Random::new(seed);
    let mut scenarios = Vec::new();
    while scenarios.len() < count {
        let excess = random.log_uniform(excess.0, excess.1);
        scenarios.extend(random_scenario(&mut random, excess));
    }
    let summaries = in_parallel(&scenarios, run);
    scenarios.into_iter().zip(summaries).collect()
}

fn error_of_b(summary: &Summary) -> f64 {
    (summary.estimates.b.tail_mean / summary.truth.expect("known").b - 1.0).abs()
}

/// Lyapunov's function V₁ = H₁ + H₂ at the start, with the model at rest where the servo is, and
/// its part H₂ at the end.
fn lyapunov(scenario: &Scenario, summary: &Summary) -> (f64, f64) {
    let gamma = summary.outcome.gamma.as_ref().expect("the law has one");
    let (gamma_a, gamma_b) = (gamma[0][0], gamma[1][1]);
    let truth = &summary.truth.expect("known");
    let h2 =
        |a: f64, b: f64| ((a - truth.a).powi(2) / gamma_a + (b - truth.b).powi(2) / gamma_b) / 2.0;
    let bki = truth.b * scenario.controller().ki;
    let omega = truth.load / bki;
    let h1 = summary.outcome.mu.expect("the law has one") * bki * omega * omega / 2.0;
    let initial = &scenario.stated.identifier.initial;
    let (a, b) = initial.a.zip(initial.b).expect("both are stated");
    (
        h1 + h2(a, b),
        h2(summary.estimates.a.tail_mean, summary.estimates.b.tail_mean),
    )
}

/// No early end, no runaway model, and no "converged" on a wrong value.
fn assert_honest(scenario: &Scenario, summary: &Summary) {
    assert!(
        summary.outcome.abort.is_none(),
        "{}: {scenario:?}",
        summary.reason
    );
    assert_eq!(summary.outcome.events.restarted, 0, "{scenario:?}");
    if summary.status() == Status::Converged {
        assert!(
            error_of_b(summary) < 0.05,
            "{:?}: {scenario:?}",
            summary.estimates.b
        );
    }
}

#[test]
fn no_certified_and_sampled_stable_case_diverges() {
    let mut ample: usize = 0;
    for (scenario, summary) in search(1000, 30 * factor::<usize>(), (0.1, 10.0)) {
        assert_honest(&scenario, &summary);
        if summary.outcome.gain_margin < Some(SampledLoop::AMPLE_GAIN_MARGIN) {
            continue;
        }
        ample += 1;
        let (start, end) = lyapunov(&scenario, &summary);
        assert!(
            end < start,
            "from {start} to {end}: {scenario:?} {summary:?}"
        );
    }
    assert!(
        3 * ample > 30 * factor::<usize>(),
        "{ample} have an ample gain margin"
    );
}

#[test]
fn a_far_too_large_gain_is_never_wrongly_called_converged() {
    let mut converged: usize = 0;
    for (scenario, summary) in search(2000, 24 * factor::<usize>(), (10.0, 1000.0)) {
        assert_honest(&scenario, &summary);
        converged += usize::from(summary.status() == Status::Converged);
    }
    assert!(converged > 6 * factor::<usize>(), "{converged}");
}
