//! Servos that are not the model: applied only if the predicted response is met, else refused. The table counts the
//! refusals of which the fit of the whole record names the effect.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use host_sim::commission::Recorded;
use host_sim::scenario::Scenario;
use identifier_core::reason::Reason;
use identifier_log::verdict::Cause;
use integration_tests::{factor, in_parallel};

use super::judged::{Judged, observed};
use super::servos::{KINDS, Kind};

/// Seeds of each servo, for a factor of one.
const SEEDS: f64 = 1.0;

/// The part of the servos that are not applied of which the reason names an effect that they have, at least.
const NAMED: f64 = 0.7;

/// The part of the servos without an effect that is applied, at least.
const APPLIED: f64 = 0.75;

/// Known failures, not corrected yet: an overshoot of 4 to 5 points above the prediction with a dead band and backlash,
/// a motion beyond the largest speed with much backlash, and an overshoot of 3.2 to 3.7 points above the promise where
/// friction at rest is four times that in motion: the integral hunts, more slowly than the trial lasts.
const KNOWN_FAULTS: [&str; 3] = [
    "paper, backlash, dead band",
    "geared, backlash 50 counts",
    "geared, low-speed friction 3 of c",
];

/// An effect of some size, its lines in [plant], and its names.
struct Effect {
    name: &'static str,
    size: &'static str,
    plant: String,
    named: &'static [Cause],
}

fn effects(kind: &Kind) -> Vec<Effect> {
    let push = kind.b * kind.limit;
    let count = std::f64::consts::TAU / kind.counts;
    let resonance = |omega: f64| {
        format!(
            "resonance = {:?}\ninertia_ratio = 0.5",
            omega * 1e-3 / kind.sample_time.max(2e-4)
        )
    };
    let backlash = |counts: f64| format!("backlash = {:?}", counts * count);
    let low_speed = |part: f64| {
        format!(
            "low_speed_friction = {:?}\nlow_speed_velocity = {:?}",
            part * kind.coulomb,
            0.02 * kind.speed
        )
    };
    let gravity = |part: f64| format!("gravity = [{:?}, {:?}]", part * push, 0.3 * part * push);
    let dead_band = |part: f64| format!("dead_band = {:?}", part * kind.limit);
    let ripple = |part: f64| format!("ripple = [{:?}, 0.0]\nripple_order = 12", part * push);
    let both = |one: String, other: String| format!("{one}\n{other}");
    type Causes = &'static [Cause];
    const RESONANCE: Causes = &[Cause::Resonance];
    const BACKLASH: Causes = &[Cause::Backlash];
    const LOW_SPEED: Causes = &[Cause::LowSpeedFriction];
    const GRAVITY: Causes = &[Cause::Gravity];
    const DEAD_BAND: Causes = &[Cause::DeadBand];
    const RIPPLE: Causes = &[Cause::Ripple];
    let effect = |name, size, plant, named| Effect {
        name,
        size,
        plant,
        named,
    };
    vec![
        effect("none", "", String::new(), &[]),
        effect(
            "resonance",
            "800 rad/s at 1 kHz",
            resonance(800.0),
            RESONANCE,
        ),
        effect(
            "resonance",
            "250 rad/s at 1 kHz",
            resonance(250.0),
            RESONANCE,
        ),
        effect("resonance", "80 rad/s at 1 kHz", resonance(80.0), RESONANCE),
        effect("backlash", "2 counts", backlash(2.0), BACKLASH),
        effect("backlash", "10 counts", backlash(10.0), BACKLASH),
        effect("backlash", "50 counts", backlash(50.0), BACKLASH),
        effect("low-speed friction", "0.3 of c", low_speed(0.3), LOW_SPEED),
        effect("low-speed friction", "1 of c", low_speed(1.0), LOW_SPEED),
        effect("low-speed friction", "3 of c", low_speed(3.0), LOW_SPEED),
        effect("gravity", "1 % of the limit", gravity(0.01), GRAVITY),
        effect("gravity", "5 %", gravity(0.05), GRAVITY),
        effect("gravity", "20 %", gravity(0.2), GRAVITY),
        effect(
            "dead band",
            "0.5 % of the limit",
            dead_band(0.005),
            DEAD_BAND,
        ),
        effect("dead band", "2 %", dead_band(0.02), DEAD_BAND),
        effect("dead band", "5 %", dead_band(0.05), DEAD_BAND),
        effect("cogging", "0.5 % of the limit", ripple(0.005), RIPPLE),
        effect("cogging", "2 %", ripple(0.02), RIPPLE),
        effect("cogging", "5 %", ripple(0.05), RIPPLE),
        effect(
            "backlash, dead band",
            "10 counts, 2 %",
            both(backlash(10.0), dead_band(0.02)),
            &[Cause::Backlash, Cause::DeadBand],
        ),
        effect(
            "low-speed, gravity",
            "1 of c, 5 %",
            both(low_speed(1.0), gravity(0.05)),
            &[Cause::LowSpeedFriction, Cause::Gravity],
        ),
        effect(
            "cogging, resonance",
            "2 %, 250 rad/s",
            both(ripple(0.02), resonance(250.0)),
            &[Cause::Ripple, Cause::Resonance],
        ),
    ]
}

/// A commissioning, and the effects that the fit of its whole record finds if it ended without gains.
fn explained(scenario: &Scenario) -> (Judged, Vec<Cause>) {
    let mut recorded = Recorded::default();
    let judged = observed(scenario, &mut |sample| recorded.add(sample));
    let effects = recorded.effects(scenario, judged.outcome.reason());
    (judged, effects)
}

/// Outcomes of the servos with an effect.
#[derive(Default)]
struct Row {
    kept: usize,
    broken: usize,
    named: usize,
    others: Vec<String>,
}

impl Row {
    fn add(&mut self, judged: &Judged, effects: &[Cause], named: &[Cause]) {
        match (&judged.kept, judged.outcome.reason()) {
            (Some(kept), _) if kept.is_kept() => self.kept += 1,
            (Some(_), _) => self.broken += 1,
            (None, _) if effects.iter().any(|of| named.contains(of)) => self.named += 1,
            (None, reason) => {
                let reason = reason.map_or("no end", Reason::name);
                self.others.push(format!("{reason} {effects:?}"));
            }
        }
    }
}

#[test]
fn a_servo_that_is_not_the_model_is_applied_only_where_the_prediction_is_kept() {
    let mut table = format!(
        "{:<8}{:<21}{:<20}{:>8}{:>8}{:>8}  other reasons\n",
        "servo", "effect", "size", "kept", "broken", "named"
    );
    let mut faults = Vec::new();
    let seeds: Vec<u32> = (1..=(SEEDS * factor::<f64>()).ceil().max(1.0) as u32).collect();
    let (mut named, mut refused) = (0, 0);
    let all: Vec<(&Kind, Effect)> = KINDS
        .iter()
        .flat_map(|kind| effects(kind).into_iter().map(move |effect| (kind, effect)))
        .collect();
    let judged = in_parallel(&all, |(kind, effect)| {
        let one = |&seed| explained(&kind.scenario(&effect.plant, seed));
        seeds.iter().map(one).collect::<Vec<_>>()
    });
    for ((kind, effect), judged) in all.iter().zip(&judged) {
        let what = format!("{}, {} {}", kind.name, effect.name, effect.size);
        let mut row = Row::default();
        for (judged, effects) in judged {
            row.add(judged, effects, effect.named);
            faults.extend(judged.broken.iter().map(|fault| format!("{what}: {fault}")));
            if let Some(kept) = judged.kept.filter(|kept| !kept.is_kept()) {
                faults.push(format!("{what}: {kept:?}"));
            }
        }
        if effect.named.is_empty() {
            for (_, effects) in judged.iter().filter(|(_, effects)| !effects.is_empty()) {
                faults.push(format!("{what}: {effects:?}"));
            }
            if (row.kept as f64) < APPLIED * seeds.len() as f64 {
                faults.push(format!(
                    "{what}: {} of {} are applied",
                    row.kept,
                    seeds.len()
                ));
            }
        } else {
            named += row.named;
            refused += row.named + row.others.len();
        }
        let others: BTreeSet<&str> = row.others.iter().map(String::as_str).collect();
        writeln!(
            table,
            "{:<8}{:<21}{:<20}{:>8}{:>8}{:>8}  {}",
            kind.name,
            effect.name,
            effect.size,
            row.kept,
            row.broken,
            row.named,
            Vec::from_iter(others).join(", ")
        )
        .expect("a string takes any text");
    }
    println!(
        "{table}\n{named} of {refused} that were not applied have an effect of theirs as the reason"
    );
    faults.retain(|fault| !KNOWN_FAULTS.iter().any(|known| fault.starts_with(known)));
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(
        refused > 0 && named as f64 >= NAMED * refused as f64,
        "{named} of {refused}"
    );
}
