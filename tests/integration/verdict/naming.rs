//! One unmodelled effect at a time: the name that the verdict gives it.

use std::collections::BTreeMap;

use host_sim::scenario::Scenario;
use identifier_log::result::Summary;
use identifier_log::verdict::{Cause, Status};
use integration_tests::{factor, in_parallel, run};

use super::campaign::{ALL_FOUR, KINDS, Kind};

/// An effect of a servo as it is usual in size.
fn effects(kind: &Kind) -> Vec<(Cause, String)> {
    let Kind {
        sample_time: t,
        b,
        coulomb,
        command,
        velocity,
        duration,
        gains,
        counts,
        ..
    } = kind;
    let push = b * command;
    let bandwidth = (b * gains[0]).sqrt();
    let count = std::f64::consts::TAU / counts;
    vec![
        (Cause::Delay, format!("delay = {:?}", 1.5 * t)),
        (Cause::Delay, format!("current_loop = {:?}", 0.8 * t)),
        (Cause::Asymmetry, format!("asymmetry = {:?}", 0.5 * kind.a)),
        (
            Cause::LowSpeedFriction,
            format!(
                "low_speed_friction = {:?}\nlow_speed_velocity = {:?}",
                0.6 * coulomb,
                0.1 * velocity
            ),
        ),
        (
            Cause::Gravity,
            format!("gravity = [{:?}, {:?}]", 0.08 * push, 0.03 * push),
        ),
        (
            Cause::Ripple,
            format!("ripple = [{:?}, 0.0]\nripple_order = 12", 0.02 * push),
        ),
        (Cause::DeadBand, format!("dead_band = {:?}", 0.02 * command)),
        (
            Cause::Resonance,
            format!("resonance = {:?}\ninertia_ratio = 0.4", 4.0 * bandwidth),
        ),
        (Cause::Backlash, format!("backlash = {:?}", 12.0 * count)),
        (
            Cause::GainDrift,
            format!("gain_drift = {:?}", 0.1 / duration),
        ),
        (
            Cause::FrictionDrift,
            format!("friction_drift = {:?}", -0.4 / duration),
        ),
        (
            Cause::HiddenLimit,
            format!("hidden_limit = {:?}", 1.5 * command),
        ),
    ]
}

fn named(summary: &Summary) -> Option<Cause> {
    summary.cause.as_ref().map(|finding| finding.cause)
}

/// Effects on a kind of servo, each alone.
fn check(kind: &Kind, effects: &[(Cause, String)]) {
    let runs: Vec<(Cause, Scenario)> = effects
        .iter()
        .flat_map(|(cause, plant)| {
            (1..=factor::<u32>())
                .map(move |seed| (*cause, kind.run(1000 + seed, plant, "", ALL_FOUR)))
        })
        .collect();
    let found = in_parallel(&runs, |(cause, scenario)| (*cause, run(scenario)));
    let mut table: BTreeMap<&str, BTreeMap<String, u32>> = BTreeMap::new();
    let (mut right, mut wrong) = (0, 0);
    for (cause, summary) in &found {
        let name = named(summary);
        right += u32::from(name == Some(*cause));
        wrong += u32::from(name.is_some_and(|name| name != *cause));
        let label = name.map_or("nothing", Cause::name);
        let status = summary.status();
        *table
            .entry(cause.name())
            .or_default()
            .entry(format!("{label}/{}", status.name()))
            .or_default() += 1;
        assert_ne!(status, Status::Aborted);
    }
    for (cause, names) in &table {
        println!("{:8} {cause:20} {names:?}", kind.name);
    }
    let all = found.len() as f64;
    let (right, wrong) = (f64::from(right) / all, f64::from(wrong) / all);
    println!(
        "{}: named right {:.1} %, wrong {:.1} % of {all}",
        kind.name,
        100.0 * right,
        100.0 * wrong
    );
    assert!(right >= 0.85 && wrong <= 0.05);
}

#[test]
fn a_single_effect_of_the_papers_servo_is_named_and_no_other() {
    let [paper, ..] = KINDS;
    check(&paper, &effects(&paper));
}

#[test]
fn an_effect_of_the_motion_of_a_fast_axis_is_named_and_no_other() {
    let [_, axis, _] = KINDS;
    check(&axis, &effects(&axis)[..6]);
}

#[test]
fn an_effect_of_the_drive_train_of_a_fast_axis_is_named_and_no_other() {
    let [_, axis, _] = KINDS;
    check(&axis, &effects(&axis)[6..]);
}

#[test]
fn a_single_effect_of_a_geared_motor_is_named_and_no_other() {
    let [.., geared] = KINDS;
    check(&geared, &effects(&geared));
}
