//! One effect at a time on three servos: without its term a wrong result is not called converged.

use identifier_log::verdict::Status;
use integration_tests::{factor, in_parallel, run};

use super::campaign::{ALL_FOUR, KINDS, Kind};

/// Effects of a usual size: their names, and their lines in `[plant]`.
fn effects(kind: &Kind) -> Vec<(&'static str, String)> {
    let push = kind.b * kind.command;
    let low_speed = [0.5 * kind.coulomb, 0.1 * kind.velocity];
    vec![
        ("delay 1", format!("delay = {:?}", kind.sample_time)),
        ("delay 2.4", format!("delay = {:?}", 2.4 * kind.sample_time)),
        ("asymmetry", format!("asymmetry = {:?}", 0.4 * kind.a)),
        (
            "low speed",
            format!(
                "low_speed_friction = {:?}\nlow_speed_velocity = {:?}",
                low_speed[0], low_speed[1]
            ),
        ),
        (
            "gravity 10 %",
            format!("gravity = [{:?}, {:?}]", 0.1 * push, 0.03 * push),
        ),
        (
            "ripple 2 %",
            format!("ripple = [{:?}, 0.0]\nripple_order = 12", 0.02 * push),
        ),
        (
            "dead band 1 %",
            format!("dead_band = {:?}", 0.01 * kind.command),
        ),
    ]
}

/// Every effect on a kind of servo is never trusted wrongly.
fn check(mut kind: Kind) {
    // Travel separates gravity from load.
    kind.duration = kind.duration.max(6.0);
    let seeds: Vec<u32> = (1..=factor::<u32>()).collect();
    for (name, plant) in effects(&kind) {
        for summary in in_parallel(&seeds, |&seed| run(&kind.run(seed, &plant, "", ALL_FOUR))) {
            let truth = summary.truth.expect("known");
            let b = (summary.estimates.b.last / truth.b - 1.0).abs();
            let coulomb = (summary.estimates.coulomb.last / truth.coulomb - 1.0).abs();
            println!(
                "{} {name}: b {b:.4}, c {coulomb:.3}, {}",
                kind.name, summary.reason
            );
            let is_wrong = b > 0.03 || coulomb > 0.15;
            assert!(
                !is_wrong || summary.status() != Status::Converged,
                "{name}: {}",
                summary.reason
            );
        }
    }
}

#[test]
fn effects_of_the_papers_servo_are_never_trusted_without_their_terms() {
    let [paper, ..] = KINDS;
    check(paper);
}

#[test]
fn effects_of_a_fast_axis_are_never_trusted_without_their_terms() {
    let [_, axis, _] = KINDS;
    check(axis);
}

#[test]
fn effects_of_a_geared_motor_are_never_trusted_without_their_terms() {
    let [.., geared] = KINDS;
    check(geared);
}
