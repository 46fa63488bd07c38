//! One effect at a time on three servos: with its term all parameters are found, and without it a wrong
//! result is not called converged.

use host_sim::analysis::Status;
use host_sim::result::Summary;
use identifier_core::parameters::Unknown;
use integration_tests::{in_parallel, run};

use super::campaign::{ALL_FOUR, KINDS, Kind, factor};

/// An effect of a usual size, its lines in [plant], and those of its term in [identifier].
struct Effect {
    name: &'static str,
    plant: String,
    term: String,
    /// The delay, s, if it is one.
    delay: Option<f64>,
}

fn effects(kind: &Kind) -> Vec<Effect> {
    let push = kind.b * kind.command;
    let speed = 0.1 * kind.velocity;
    let effect = |name, plant: String, term: &str| Effect {
        name,
        plant,
        term: format!("required_terms = [\"{term}\"]"),
        delay: None,
    };
    let delayed = |name, samples: f64| {
        let delay = samples * kind.sample_time;
        Effect {
            delay: Some(delay),
            ..effect(name, format!("delay = {delay:?}"), "delay")
        }
    };
    let low_speed = effect(
        "low speed",
        format!(
            "low_speed_friction = {:?}\nlow_speed_velocity = {speed:?}",
            0.5 * kind.coulomb
        ),
        "low-speed",
    );
    let ripple = effect(
        "ripple 2 %",
        format!("ripple = [{:?}, 0.0]\nripple_order = 12", 0.02 * push),
        "ripple",
    );
    vec![
        delayed("delay 1", 1.0),
        delayed("delay 2.4", 2.4),
        effect(
            "asymmetry",
            format!("asymmetry = {:?}", 0.4 * kind.a),
            "asymmetry",
        ),
        Effect {
            term: format!("{}\nlow_speed_velocity = {speed:?}", low_speed.term),
            ..low_speed
        },
        effect(
            "gravity 10 %",
            format!("gravity = [{:?}, {:?}]", 0.1 * push, 0.03 * push),
            "gravity",
        ),
        Effect {
            term: format!("{}\nripple_order = 12", ripple.term),
            ..ripple
        },
        effect(
            "dead band 1 %",
            format!("dead_band = {:?}", 0.01 * kind.command),
            "dead-band",
        ),
    ]
}

/// Errors of a result: a in 1/s; b, c and the delay relative.
struct Off {
    a: f64,
    b: f64,
    coulomb: f64,
    delay: f64,
    status: Status,
}

fn off(summary: &Summary, effect: &Effect) -> Off {
    let truth = summary.truth.expect("known");
    let delay = summary
        .outcome
        .terms
        .iter()
        .find(|term| term.unknown == Unknown::Delay)
        .zip(effect.delay)
        .map_or(0.0, |(term, delay)| (term.value / delay - 1.0).abs());
    Off {
        a: (summary.estimates.a.last - truth.a).abs(),
        b: (summary.estimates.b.last / truth.b - 1.0).abs(),
        coulomb: (summary.estimates.coulomb.last / truth.coulomb - 1.0).abs(),
        delay,
        status: summary.status(),
    }
}

fn worst(offs: &[Off], of: impl Fn(&Off) -> f64) -> f64 {
    offs.iter().map(of).fold(0.0, f64::max)
}

fn converged(offs: &[Off]) -> usize {
    let is = |off: &&Off| off.status == Status::Converged;
    offs.iter().filter(is).count()
}

/// Every effect on a kind of servo: found with its term, and never trusted wrongly without it.
fn check(mut kind: Kind) {
    // A term enters after some motion both ways, and travel separates gravity from load.
    kind.duration = kind.duration.max(6.0);
    let seeds: Vec<u32> = (1..=factor()).collect();
    let mut table = String::from(
        "effect         with: a 1/s     b %     c %  delay %  converged | without:   b %     c %  converged\n",
    );
    let mut faults = Vec::new();
    for effect in effects(&kind) {
        let found = |identifier: &str| {
            in_parallel(&seeds, |&seed| {
                off(
                    &run(&kind.run(seed, &effect.plant, "", identifier)),
                    &effect,
                )
            })
        };
        let with = found(&format!("{ALL_FOUR}\n{}", effect.term));
        let without = found(ALL_FOUR);
        table += &format!(
            "{:13} {:11.3} {:7.3} {:7.2} {:8.2} {:10} |        {:7.2} {:7.1} {:10}\n",
            effect.name,
            worst(&with, |off| off.a),
            100.0 * worst(&with, |off| off.b),
            100.0 * worst(&with, |off| off.coulomb),
            100.0 * worst(&with, |off| off.delay),
            converged(&with),
            100.0 * worst(&without, |off| off.b),
            100.0 * worst(&without, |off| off.coulomb),
            converged(&without),
        );
        let most_a = (0.03 * kind.a).max(0.1);
        let found =
            |off: &Off| off.b < 0.005 && off.coulomb < 0.05 && off.a < most_a && off.delay < 0.02;
        let wrong = |off: &Off| off.b > 0.03 || off.coulomb > 0.15;
        let trusted = |off: &Off| off.status == Status::Converged && wrong(off);
        let lost = with.iter().filter(|off| !found(off));
        faults.extend(lost.map(|_| format!("{}: not found", effect.name)));
        let trusted = without.iter().filter(|off| trusted(off));
        faults.extend(trusted.map(|_| format!("{}: trusted", effect.name)));
    }
    println!(
        "{}, largest errors over {} seeds\n{table}",
        kind.name,
        seeds.len()
    );
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn effects_of_the_papers_servo_are_found_with_their_terms_and_never_trusted_without() {
    let [paper, ..] = KINDS;
    check(paper);
}

#[test]
fn effects_of_a_fast_axis_are_found_with_their_terms_and_never_trusted_without() {
    let [_, axis, _] = KINDS;
    check(axis);
}

#[test]
fn effects_of_a_geared_motor_are_found_with_their_terms_and_never_trusted_without() {
    let [.., geared] = KINDS;
    check(geared);
}

#[test]
fn a_declared_amplifier_is_no_lack_of_the_model() {
    let [paper, ..] = KINDS;
    for (effect, declare) in [
        ("current_loop = 0.002", [0.0, 0.0, 0.002]),
        ("delay = 0.0023", [0.0023, 0.0, 0.0]),
        ("dead_band = 0.2", [0.0, 0.2, 0.0]),
        ("current_loop = 0.002\ndead_band = 0.2", [0.0, 0.2, 0.002]),
    ] {
        let mut scenario = paper.run(7, effect, "", ALL_FOUR);
        let hidden = run(&scenario);
        assert_ne!(hidden.status(), Status::Converged, "{effect}");
        let terms = &mut scenario.stated.identifier.terms;
        [terms.delay, terms.dead_band, terms.current_loop] = declare;
        let declared = run(&scenario);
        assert_eq!(
            declared.status(),
            Status::Converged,
            "{effect}: {}",
            declared.reason
        );
        let off = declared.estimates.b.last / 257.7 - 1.0;
        assert!(off.abs() < 0.005, "{effect}: {off}");
        let off = declared.estimates.coulomb.last / 5.0 - 1.0;
        assert!(off.abs() < 0.05, "{effect}: {off}");
    }
}
