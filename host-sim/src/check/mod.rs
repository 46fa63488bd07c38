//! The properties of a scenario before it is run: the loop's bandwidth and margins, the accuracy that the motion
//! allows for each unknown and when it is reached, and problems with their remedies.
//!
//! The loop's figures are those of the sampled loop with all its delay. The rest comes from a rehearsal: the
//! simulated servo moves as it would in the run, and nothing is identified.

mod closed_loop;
mod information;
mod rehearsal;
mod warnings;

use self::closed_loop::Response;
use self::rehearsal::Rehearsal;
use self::warnings::warnings;
use crate::result::{Certificate, CheckResult, EncoderFigures, ServoFigures};
use crate::scenario::{Fault, Scenario};

/// Checks a scenario that can be run.
///
/// # Errors
/// The key at which it cannot be.
pub fn check(scenario: &Scenario) -> Result<CheckResult, Fault> {
    /// The correction's bandwidth where there is no loop to take it from, in 1/T.
    const PER_SAMPLE: f64 = 0.05;
    /// The time for which the fit of a verdict trusts its model, over the reciprocal of the motion's bandwidth: four of the
    /// shortest, of 0.7.
    const HORIZON: f64 = 2.8;
    let plant = scenario
        .plant
        .ok_or_else(|| Fault::new("plant", "a check needs a servo to look at"))?;
    let response = Response::new(scenario, &plant);
    let closed_loop = response.map(|response| response.figures(scenario));
    let omega = closed_loop
        .and_then(|found| found.crossover)
        .map(|crossover| crossover / HORIZON)
        .unwrap_or(PER_SAMPLE / scenario.sample_time());
    let rehearsal = Rehearsal::run(scenario, omega)?;
    let resolution = scenario.stated.resolution;
    let [low, high] = scenario.controller().limit;
    let largest = high.min(-low);
    let friction = plant.coulomb + plant.load.abs();
    let mut check = CheckResult {
        sample_time: scenario.sample_time(),
        servo: ServoFigures {
            a: plant.a,
            b: plant.b,
            time_constant: (plant.a > 0.0).then(|| 1.0 / plant.a),
            top_speed: (plant.a > 0.0 && largest.is_finite())
                .then(|| ((plant.b * largest - friction) / plant.a).max(0.0)),
            breakaway: friction / plant.b,
        },
        closed_loop,
        certificate: Certificate {
            certified: rehearsal.outcome.certified,
            gain_margin: rehearsal.outcome.gain_margin,
            mu: rehearsal.outcome.mu,
        },
        encoder: EncoderFigures {
            resolution,
            motion: rehearsal.position / resolution,
            noise: rehearsal.noise,
            command_per_count: response.map(|response| response.command_of(resolution)),
        },
        limited: rehearsal.limited,
        known: rehearsal.known.clone(),
        warnings: Vec::new(),
    };
    check.warnings = warnings(&check, scenario, &rehearsal);
    Ok(check)
}
