//! Faults in a scenario: accepted and refused values, and their effect on a run.

use crate::support::readable::assert_readable;
use host_sim::experiment::{AbortCause, Outcome};
use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;

const SERVO: &str = "[plant]\na = 0.5\nb = 200.0\ncoulomb = 4.0\nload = 1.0\n";
const SHORT: &str = "[run]\nduration = 1.0\n";

fn parse(faults: &str) -> Result<Scenario, String> {
    let text = format!("{SERVO}{SHORT}{faults}");
    Scenario::parse("s.toml", &text, Purpose::Run).map_err(|error| {
        let answer = error.to_string();
        assert_readable(&answer, &text);
        answer
    })
}

/// Positions and commands of a run, and its outcome.
fn run(faults: &str) -> (Vec<[f64; 2]>, Outcome) {
    let scenario = parse(faults).unwrap_or_else(|error| panic!("{error}"));
    let mut seen = Vec::new();
    let outcome = simulate::run(&scenario, &mut |sample| {
        seen.push([sample.position, sample.command]);
    });
    (seen, outcome.expect("it can be built"))
}

/// Each kind, as large as one sees it in a second, and whether the servo's motion shows it.
const KINDS: [(&str, &str, bool); 12] = [
    ("encoder-stuck", "", true),
    ("encoder-lost", "duration = 9.0", false),
    ("encoder-jump", "size = 300", true),
    ("encoder-reversed", "duration = 0.02", true),
    ("actuator-dead", "", true),
    ("actuator-weak", "size = 0.4", true),
    ("actuator-reversed", "duration = 0.02", true),
    ("load-step", "size = -20.0", true),
    ("friction-rise", "size = 10.0\nduration = 0.4", true),
    ("overrun", "", true),
    ("limit-switch", "", false),
    ("amplifier-fault", "duration = 0.1", true),
];

fn fault(kind: &str, keys: &str) -> String {
    format!("[[fault]]\nkind = \"{kind}\"\ntime = 0.5\n{keys}\n")
}

#[test]
fn a_fault_changes_the_motion_from_its_time_on_and_nothing_before() {
    let (sound, _) = run("");
    for (kind, keys, shows) in KINDS {
        let (faulty, outcome) = run(&fault(kind, keys));
        assert_eq!(faulty[..500], sound[..500], "{kind}");
        if kind == "encoder-lost" {
            let abort = outcome.abort.expect("it ends");
            assert_eq!(abort.cause, AbortCause::NoReading);
            assert!((abort.time - 0.5).abs() < 1e-9 && faulty.len() == 500);
            continue;
        }
        assert_eq!(faulty[500..] != sound[500..], shows, "{kind}");
    }
}

#[test]
fn faults_come_one_after_the_other_and_together() {
    let (sound, _) = run("");
    let step =
        |time, size| format!("[[fault]]\nkind = \"load-step\"\ntime = {time}\nsize = {size}\n");
    let (both, _) = run(&(step(0.3, 12.0) + &step(0.3, -12.0)));
    assert_eq!(both, sound, "two loads that cancel each other");
    let (later, _) = run(&(step(0.7, 12.0) + &step(0.3, 12.0)));
    let (first, _) = run(&step(0.3, 12.0));
    assert_eq!(later[..700], first[..700]);
    assert_ne!(later[700..], first[700..]);
}

#[test]
fn wrong_faults_are_refused_at_their_line() {
    let head = SERVO.lines().count() + SHORT.lines().count();
    let refused = |faults: &str, line: usize, parts: &[&str]| {
        let answer = parse(faults).expect_err("it is wrong");
        let place = format!("s.toml:{}: fault", head + line);
        for part in [place.as_str()].iter().chain(parts) {
            assert!(answer.contains(part), "{part:?} is missing:\n{answer}");
        }
    };
    let sound = fault("overrun", "");
    let second = |fault: &str| format!("{sound}\n[[fault]]\n{fault}");
    // The first fault has four lines, the last of them empty, and an empty one follows.
    refused(
        &second("kind = \"overrun\"\ntim = 1.0\n"),
        8,
        &[
            "fault.tim: there is no such key",
            "did you mean time?",
            "kind, time, duration, size",
        ],
    );
    refused(
        &second("time = 1.0\nkind = \"actuator-ded\"\n"),
        8,
        &[
            "there is no \"actuator-ded\"",
            "did you mean \"actuator-dead\"?",
        ],
    );
    refused(
        &second("kind = \"actuator-weak\"\ntime = 1.0\nsize = 1.5\n"),
        9,
        &["fault.size: size = 1.5", "from 0 to 1"],
    );
    refused(
        &second("kind = \"overrun\"\ntime = 1.0\nsize = 1.5\n"),
        9,
        &["\"overrun\" does not take this key, but duration"],
    );
    refused(
        &second("kind = \"encoder-jump\"\ntime = 1.0\nsize = 5\nduration = 1\n"),
        10,
        &["\"encoder-jump\" does not take this key, but size"],
    );
    refused(
        &second("kind = \"load-step\"\n"),
        6,
        &["fault.time: this value is missing", "time = 5.0"],
    );
    refused(
        &second("kind = \"load-step\"\ntime = 1.0\n"),
        6,
        &[
            "fault.size: this value is missing: \"load-step\" needs it",
            "size = 0.5",
        ],
    );
    refused(
        "[fault]\nkind = \"overrun\"\ntime = 1.0\n",
        1,
        &["write [[fault]], in double brackets"],
    );
    refused(&sound.repeat(17), 1, &["17 entries, where 1 to 16 belong"]);
    parse(&sound.repeat(16)).expect("as many as there may be");
}

#[test]
fn the_lines_that_a_message_advises_are_accepted() {
    let answer = parse("[[fault]]\n").expect_err("nothing is stated");
    let (_, lines) = answer
        .split_once("write, for example:\n")
        .expect("an example");
    let scenario = parse(&format!("[[fault]]\n{lines}")).expect("the example is a fault");
    assert_eq!(scenario.faults.len(), 1);
}
