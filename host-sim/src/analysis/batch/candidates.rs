//! Candidate unmodelled effects: each with the columns that it is made of.

use identifier_core::parameters::Unknown;

use super::Judged;
use super::effect::{Effect, LAGS};
use super::plan::Prepared;

/// Delays that are tried, samples.
const DELAYS: [usize; 4] = [1, 2, 4, 8];

/// Speeds at which low-speed friction has faded that are tried, over the usual velocity.
const LOW_SPEEDS: [f64; 3] = [0.05, 0.15, 0.4];

/// Orders of ripple that motors and gears often have.
const ORDERS: [f64; 10] = [2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 18.0, 24.0, 36.0, 42.0];

/// Limits that are tried, over the largest command.
const LIMITS: [f64; 3] = [0.35, 0.6, 0.85];

/// Resonances that are tried, over the frequency at which the output error swings most.
const RESONANCES: [f64; 3] = [0.97, 1.0, 1.03];

/// The periods of a ripple that the usual swing must pass, in radians.
const MIN_RIPPLE_SWING: f64 = 1.0;

/// The part of a revolution that must be travelled for a force to go with the angle.
const MIN_TRAVEL: f64 = 0.02;

/// Samples that a period of a ripple must last at the usual velocity.
const MIN_PERIOD_SAMPLES: f64 = 8.0;

/// Plays that are tried, counts.
const PLAYS: [f64; 3] = [3.0, 12.0, 48.0];

/// The candidates; `ringing` is the frequency at which the output error swings most, radians a sample.
/// Unless the output error is `large` beside the encoder's, a resonance is none of them.
pub(super) fn all(
    judged: &Judged<'_>,
    prepared: &Prepared,
    large: bool,
    ringing: Option<f64>,
) -> Vec<Vec<Effect>> {
    let absent = |unknown: &Unknown| !judged.unknowns.contains(unknown);
    let unknowns = Unknown::ALL.into_iter().filter(absent);
    let mut candidates: Vec<Vec<Effect>> = unknowns
        .flat_map(|unknown| lacking(unknown, judged, prepared))
        .collect();
    candidates.push(vec![Effect::Quadratic]);
    if travels(judged, prepared) {
        candidates.push(vec![Effect::EccentricSine, Effect::EccentricCosine]);
    }
    // The rounding of a coarse encoder goes with the acceleration too.
    if large {
        candidates.push(vec![Effect::Compliance(None)]);
        let near = |frequency| {
            RESONANCES.map(|factor: f64| vec![Effect::Compliance(Some(factor * frequency))])
        };
        candidates.extend(ringing.map(near).into_iter().flatten());
    }
    candidates.extend(PLAYS.map(|counts| vec![Effect::Play(counts)]));
    candidates.push(vec![Effect::GainDrift]);
    if judged.servo.coulomb > 0.0 {
        candidates.push(vec![Effect::FrictionDrift]);
    }
    candidates.extend(LIMITS.map(|part| vec![Effect::Limit(part * prepared.high_command)]));
    candidates
}

/// The candidates for an unknown that the model has not got.
fn lacking(unknown: Unknown, judged: &Judged<'_>, prepared: &Prepared) -> Vec<Vec<Effect>> {
    match unknown {
        Unknown::A | Unknown::B | Unknown::GravityCosine | Unknown::RippleCosine => Vec::new(),
        Unknown::Delay => {
            let later = DELAYS.map(|samples| vec![Effect::Later(samples)]);
            let lags = LAGS.map(|samples| vec![Effect::CurrentLoop(samples)]);
            later.into_iter().chain(lags).collect()
        }
        Unknown::LowSpeed => {
            let velocity = usual_velocity(judged, prepared);
            Vec::from(LOW_SPEEDS.map(|part| vec![Effect::LowSpeed(part * velocity)]))
        }
        Unknown::GravitySine | Unknown::RippleSine if !travels(judged, prepared) => Vec::new(),
        Unknown::GravitySine => vec![vec![Effect::Sine(1.0), Effect::Cosine(1.0)]],
        Unknown::RippleSine => ripples(judged, prepared),
        unknown => vec![vec![Effect::Own(unknown)]],
    }
}

fn ripples(judged: &Judged<'_>, prepared: &Prepared) -> Vec<Vec<Effect>> {
    let resolution = prepared.plan.model.angle_resolution();
    let per_order = resolution * usual_velocity(judged, prepared);
    let swing = prepared.scales.position * judged.scenario.units().position() * resolution;
    let shows = |order: &f64| {
        order * per_order * MIN_PERIOD_SAMPLES < std::f64::consts::TAU
            && order * swing > MIN_RIPPLE_SWING
    };
    let declared = judged.scenario.stated.identifier.terms.ripple_order;
    let others = ORDERS
        .into_iter()
        .filter(|order| declared.is_none_or(|own| (own - order).abs() > 0.5));
    let orders = declared.into_iter().chain(others).filter(shows);
    orders
        .map(|order| vec![Effect::Sine(order), Effect::Cosine(order)])
        .collect()
}

/// True if the servo travels enough of a revolution to show a force that goes with the angle.
fn travels(judged: &Judged<'_>, prepared: &Prepared) -> bool {
    prepared.scales.position > MIN_TRAVEL * judged.scenario.stated.identifier.terms.revolution
}

/// Counts per sample.
fn usual_velocity(judged: &Judged<'_>, prepared: &Prepared) -> f64 {
    prepared.scales.velocity * judged.scenario.units().velocity()
}
