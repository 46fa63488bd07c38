//! Faults in a scenario: accepted and refused values, and their effect on a run.

use crate::support::readable::assert_readable;
use crate::support::table;
use host_sim::scenario::{Purpose, Scenario};
use host_sim::simulate;
use identifier_log::experiment::{AbortCause, Outcome};

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

/// The keys of a second fault, the line below the first that the answer names, and the key.
const WRONG: &str = r#"
kind = "overrun"; tim = 1.0 | 8 | fault.tim
time = 1.0; kind = "actuator-ded" | 8 | fault.kind
kind = "actuator-weak"; time = 1.0; size = 1.5 | 9 | fault.size
kind = "overrun"; time = 1.0; size = 1.5 | 9 | fault.size
kind = "encoder-jump"; time = 1.0; size = 5; duration = 1 | 10 | fault.duration
kind = "load-step" | 6 | fault.time
kind = "load-step"; time = 1.0 | 6 | fault.size
"#;

#[test]
fn wrong_faults_are_refused_at_their_line() {
    let head = SERVO.lines().count() + SHORT.lines().count();
    let sound = fault("overrun", "");
    let refused = |faults: &str, line: usize, key: &str| {
        let answer = parse(faults).expect_err("it is wrong");
        let place = format!("s.toml:{}: {key}", head + line);
        assert!(answer.contains(&place), "{place}: {answer}");
    };
    // The first fault has four lines, the last of them empty, and an empty one follows.
    for row in table(WRONG) {
        let line = row[1].parse().expect("a number");
        refused(&format!("{sound}\n[[fault]]\n{}\n", row[0]), line, &row[2]);
    }
    refused("[fault]\nkind = \"overrun\"\ntime = 1.0\n", 1, "fault");
    refused(&sound.repeat(17), 1, "fault");
    parse(&sound.repeat(16)).expect("as many as there may be");
}

#[test]
fn the_lines_that_a_message_advises_are_accepted() {
    let answer = parse("[[fault]]\n").expect_err("nothing is stated");
    let (_, lines) = answer.split_once(":\n").expect("an example");
    let scenario = parse(&format!("[[fault]]\n{lines}")).expect("the example is a fault");
    assert_eq!(scenario.faults.len(), 1);
}
