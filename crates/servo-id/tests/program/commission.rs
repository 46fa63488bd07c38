//! The contract of `servo-id commission`: its messages, its files, and its refusals before
//! anything moves.

use std::fmt::Write;

#[cfg(unix)]
use crate::monitor::Bench;
use crate::support::readable::assert_readable;
use crate::support::{Folder, estimate, number, own_folder, scenario_text, standard_error, table};
use host_sim::scenario::{Purpose, Scenario};
use identifier_core::reason::Reason;
#[cfg(unix)]
use identifier_log::verdict::Cause;
use serde_json::Value;

const PAPER: &str = include_str!("../../../../host-sim/scenarios/commission.toml");

/// A folder with a scenario.
fn with(scenario: &str) -> Folder {
    let folder = own_folder();
    folder.write("scenario.toml", scenario);
    folder
}

const CALL: &str = "commission scenario.toml --json result.json";

/// The result of a commissioning that ends without gains.
fn failed(scenario: &str) -> Value {
    let folder = with(scenario);
    let output = folder.call(CALL);
    assert_eq!(output.status.code(), Some(1), "{}", standard_error(&output));
    folder.read_json("result.json")
}

/// The message about a scenario that is refused.
fn refusal(text: &str) -> String {
    let error = Scenario::parse("s.toml", text, Purpose::Commission).expect_err(text);
    let answer = error.to_string();
    assert_readable(&answer, text);
    answer
}

/// A joint under gravity of 475 rad/s², one that sticks and one that cogs.
#[test]
fn a_force_that_was_found_is_said() {
    let joint = scenario_text("commission_gravity.toml");
    let sticks = joint.replace(
        "gravity = [240.0, -410.0]",
        "low_speed_friction = 60.0\nlow_speed_velocity = 0.5",
    );
    let cogs = joint.replace(
        "gravity = [240.0, -410.0]",
        "ripple = [240.0, 320.0]\nripple_order = 24",
    );
    for (text, said, size) in [
        (&joint, "by gravity or a spring: ", 475.0),
        (&sticks, "Friction is higher by ", 60.0),
        (&cogs, "Cogging: ", 400.0),
    ] {
        let folder = with(text);
        let shown = folder.done(CALL);
        let found = shown.split(said).nth(1).expect(&shown);
        let found: f64 = found
            .split(' ')
            .next()
            .and_then(|word| word.parse().ok())
            .expect(&shown);
        assert!((found / size - 1.0).abs() < 0.2, "{said}{found}");
    }
}

#[test]
fn an_unknown_servo_ends_with_gains_and_their_derivation() {
    let folder = with(PAPER);
    let output = folder.call(CALL);
    let answer = String::from_utf8_lossy(&output.stdout).into_owned() + &standard_error(&output);
    assert_eq!(output.status.code(), Some(0), "{answer}");
    let result = folder.read_json("result.json");
    assert_eq!(result["status"], "applied");
    assert_eq!(result["code"], 0);
    assert_eq!(result["reason"], Value::Null);
    let b = number(&result, "/servo/b/value");
    assert!((b / 257.7 - 1.0).abs() < 0.01, "{b}");
    let phases = result["phases"].as_array().expect("a list").iter();
    let names: Vec<_> = phases
        .map(|phase| phase["phase"].as_str().unwrap_or("?"))
        .collect();
    let expected = "rest probe fit frequency-response gains trial applied";
    assert_eq!(names.join(" "), expected);
    let first = answer.find("it moves at most");
    let first = first.expect("the largest motion is printed");
    let is_after = |name: &&str| answer.find(*name).is_some_and(|place| first < place);
    assert!(names.iter().all(is_after), "{answer}");
    for gain in ["kp", "kd", "ki", "cutoff"] {
        assert!(number(&result, &format!("/gains/{gain}")) > 0.0, "{gain}");
    }
    let highest = number(&result, "/response/highest_frequency");
    let looked_at = highest * number(&result, "/sample_time") / std::f64::consts::TAU;
    assert!((0.49..0.4951).contains(&looked_at), "{looked_at}");
    let predicted = number(&result, "/predicted_response/rise_time");
    let ratio = number(&result, "/trial/rise_time") / predicted;
    assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
}

#[test]
fn gains_that_are_not_applied_give_exit_status_one_and_the_reason_by_text_and_number() {
    // A locked axis: friction exceeds the largest command.
    let result = failed(&PAPER.replace("coulomb = 0.0 ", "coulomb = 9000.0 "));
    let reason = Reason::DoesNotMove;
    assert_eq!(result["status"], "aborted");
    assert_eq!(result["code"], reason.number());
    assert_eq!(result["phase"], "probe");
    assert_eq!(result["reason"]["name"], reason.name());
    assert_eq!(result["reason"]["remedy"], reason.remedy());
    assert_eq!(result["gains"], Value::Null);
}

#[test]
fn the_end_of_a_held_axis_tells_whether_the_stage_is_on() {
    const CONTROLLER: &str = "[controller]\nkp = 5.0\nkd = 0.15\nki = 4.0\n\
                              velocity_filter = { kind = \"low-pass\", cutoff = 500.0 }\n";
    for (kind, is_held) in [
        ("\"actuator-weak\"\nsize = 0.3", true),
        ("\"encoder-lost\"", false),
        ("\"actuator-dead\"", false),
    ] {
        let result = failed(&format!(
            "{PAPER}\n{CONTROLLER}[[fault]]\ntime = 0.4\nkind = {kind}\n"
        ));
        let end = result["phases"].as_array().and_then(|phases| phases.last());
        let excursion = end.is_some_and(|end| end["excursion"].is_object());
        assert_eq!(excursion, is_held, "{kind}");
    }
}

/// What is changed in the scenario, to what, and the key and a figure that the answer names.
const IMPOSSIBLE: &str = r#"
travel = 0.5 | travel = 0.002 | commission.travel | rad
speed = 30.0 | speed = 0.05 | commission.speed | 0.1
speed = | max_gain = 600.0; speed = | commission.sample_time | 0.000750
speed = | command_delay = 0.02; speed = | commission.command_delay | 0.015
travel = 0.5 | travel = [0.1, 0.5] | commission.travel | [low, high]
travel = 0.5 | travel = [0.0, 0.5] | commission.travel | identify
travel = 0.5 | # | commission.travel | travel = 0.5
speed = | command = 12.0; speed = | commission.command | [-10, 10]
limit = 10.0 | # | commission.command | amplifier.limit
speed = | bandwidth = 20.0; response_time = 0.1; speed = | commission.bandwidth |
speed = | trial_step = 3.0; speed = | commission.trial_step |
speed = | max_sensitivity = 0.9; speed = | commission.max_sensitivity | 1
speed = | slide_rounds = 1; speed = | commission.slide_rounds |
[commission] | [identifier]; arithmetic = "fixed"; [commission] | identifier.arithmetic | "f64"
"#;

#[test]
fn a_commissioning_impossible_within_its_limits_is_refused_with_the_figure_that_would_do() {
    for row in table(IMPOSSIBLE) {
        let text = PAPER.replacen(&row[0], &row[1], 1);
        assert_ne!(text, PAPER, "{row:?}");
        let (_, name) = row[2].split_once('.').expect("a table and a name");
        let line = text.lines().position(|line| line.starts_with(name));
        let head = text.lines().position(|line| line == "[commission]");
        let line = 1 + line.or(head).expect("the key or its table is there");
        let answer = refusal(&text);
        let place = format!("s.toml:{line}: {}: ", row[2]);
        let is_named = answer.contains(&place) && answer.contains(&row[3]);
        assert!(is_named, "{row:?}: {answer}");
    }
    // A scenario without limits is answered with the lines to write.
    let answer = refusal(&scenario_text("paper.toml"));
    assert!(answer.contains("travel = 0.5"), "{answer}");
}

#[test]
fn what_is_refused_moves_nothing_and_writes_nothing() {
    let folder = with(&PAPER.replace("travel = 0.5 ", "travel = 0.002 "));
    folder.assert_refused(
        "commission scenario.toml --json result.json | scenario.toml:
        commission scenario.toml --quick | --quick
        commission scenario.toml --thorough | --thorough",
    );
    let timed = PAPER.replace("[commission]", "[commission]\nresponse_time = 0.05");
    folder.write("scenario.toml", timed);
    let answer = folder.refused("commission scenario.toml --feed-forward");
    assert!(answer.contains("commission.feed_forward"), "{answer}");
    assert_eq!(folder.names(), ["scenario.toml"]);
}

/// Servos that five numbers do not explain, beside gains that hold them, and the effect of each. The reason of the end is
/// that of the noise, or of the detent in which the axis comes to rest, and no fault of the actuator.
#[cfg(unix)]
const EFFECTS: [(&str, &str, &str); 2] = [
    (
        "dead-band",
        "a = 1.5\nb = 3000.0\ncoulomb = 150.0\nload = 30.0\ndead_band = 0.25\n\
         [encoder]\ncounts_per_rev = 20000\n[amplifier]\nlimit = 5.0\n\
         [controller]\nkp = 0.9\nkd = 0.02\nki = 4.0\nsample_time = 0.0005\n",
        "travel = 0.5",
    ),
    (
        "ripple",
        "a = 0.5\nb = 257.7\ncoulomb = 30.0\nload = 3.0\nripple = [1200.0, 0.0]\nripple_order = 24\n\
         [encoder]\ncounts_per_rev = 20000\n[amplifier]\nlimit = 10.0\n\
         [controller]\nkp = 1.6\nkd = 0.06\nki = 4.0\nsample_time = 0.001\n",
        "travel = 0.5",
    ),
];

#[cfg(unix)]
#[test]
fn the_effect_of_an_axis_is_named_from_what_a_drive_keeps_as_from_every_sample() {
    let named = |(effect, servo, travel): (&str, &str, &str)| {
        let text = format!(
            "[plant]\n{servo}velocity_filter = {{ kind = \"low-pass\", cutoff = 300.0 }}\n\
             [excitation]\nkind = \"none\"\n\
             [identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"coulomb\", \"load\"]\n\
             [commission]\n{travel}\nspeed = 40.0\n"
        );
        let bench = Bench::with_scenario(&format!("commission-drive-{effect}"), &text);
        let call = format!("drive --port {} commission servo.toml --json -", bench.port);
        for call in ["commission servo.toml --json -", &call] {
            let output = bench.folder.call(call);
            let answer = standard_error(&output);
            assert_eq!(output.status.code(), Some(1), "{effect}: {answer}");
            let result: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            let code = result["code"].as_u64().expect("the number of its reason");
            let dead = u64::from(Reason::ActuatorDead.number());
            assert_ne!(code, dead, "{effect}");
            assert_eq!(result["effects"], serde_json::json!([effect]), "{effect}");
            let cause = Cause::ALL.iter().find(|cause| cause.name() == effect);
            let meaning = cause.expect("its name").meaning();
            assert!(answer.contains(meaning), "{answer}");
        }
    };
    std::thread::scope(|scope| {
        for one in EFFECTS {
            scope.spawn(move || named(one));
        }
    });
}

/// The way out of an axis that may not reverse: a motion forwards alone.
#[test]
fn an_axis_that_may_not_reverse_is_identified_from_a_log() {
    const STEPS: u32 = 20;
    let [a, b, coulomb, load] = [3.1, 120.0, 9.0, -2.0];
    let (sample, count) = (1e-3, std::f64::consts::TAU / 16384.0);
    let (mut position, mut velocity, mut last) = (0.0_f64, 0.0_f64, 0.0);
    let mut log = "time,position,command\n".to_owned();
    for k in 0..10_000 {
        let time = sample * f64::from(k);
        let seen = (position / count).floor() * count;
        let wanted = 6.0 + 3.0 * (5.6 * time).sin() + 2.0 * (19.0 * time).sin();
        let command = (0.1 + 0.08 * (wanted - (seen - last) / sample)).clamp(-3.0, 3.0);
        last = seen;
        let _ = writeln!(log, "{time:.3},{seen:.9},{command:.7}");
        for _ in 0..STEPS {
            let step = sample / f64::from(STEPS);
            velocity = (velocity + step * (b * command + load - coulomb - a * velocity)).max(0.0);
            position += step * velocity;
        }
    }
    let folder = with(
        "[encoder]\ncounts_per_rev = 16384\n[identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"load\"]\n\
         [log]\ntime = \"time\"\nposition = \"position\"\ncommand = \"command\"\n",
    );
    folder.write("log.csv", log);
    let result = folder.json("identify log.csv --scenario scenario.toml");
    for (name, truth) in [("a", a), ("b", b)] {
        let found = estimate(&result, name);
        assert!((found / truth - 1.0).abs() < 0.03, "{name}: {found}");
    }
}
