//! The contract of `servo-id commission`: its messages, its files, and its refusals before
//! anything moves.

use std::fs;

#[cfg(unix)]
use crate::monitor::Bench;
use crate::support::{assert_done, folder, servo_id, standard_error};
use identifier_core::reason::Reason;
#[cfg(unix)]
use identifier_log::verdict::Cause;
use serde_json::Value;

const PAPER: &str = include_str!("../../../../host-sim/scenarios/commission.toml");

/// Commissions the servo of a scenario text: exit status, output, and the result.
fn commission(test: &str, text: &str) -> (Option<i32>, String, Option<Value>) {
    let folder = folder(&format!("commission-{test}"));
    let [scenario, json] = ["scenario.toml", "result.json"].map(|name| folder.join(name));
    fs::write(&scenario, text).expect("the scenario is written");
    let [path, result] = [&scenario, &json].map(|path| path.display().to_string());
    let output = servo_id(&["commission", &path, "--json", &result]);
    let answer = String::from_utf8_lossy(&output.stdout).into_owned() + &standard_error(&output);
    let result = fs::read_to_string(&json).ok();
    let result = result.map(|text| serde_json::from_str(&text).expect("it is JSON"));
    (output.status.code(), answer, result)
}

/// The paper's servo with one line changed is refused before anything moves: at the key's line, and with a possible
/// figure.
fn assert_refused((from, to): (&str, &str), key: &str, figure: &str) {
    let test = "refused";
    let key = if key.contains('.') {
        key.to_owned()
    } else {
        format!("commission.{key}")
    };
    let text = PAPER.replace(from, to);
    assert_ne!(text, PAPER, "{test}");
    let (status, answer, result) = commission(test, &text);
    assert_eq!(status, Some(2), "{test}: {answer}");
    assert!(result.is_none(), "{test}: no partial output");
    assert!(!answer.contains("frequency-response"), "{test}: {answer}");
    let name = key.rsplit('.').next().expect("a key has a name");
    let line = text.lines().position(|line| line.starts_with(name));
    let table = text.lines().position(|line| line == "[commission]");
    let line = 1 + line.or(table).expect("the key or its table is there");
    assert!(
        answer.contains(&format!("scenario.toml:{line}: {key}: ")),
        "{test}: {answer}"
    );
    assert!(answer.contains(figure), "{test}: {answer}");
}

#[test]
fn an_unknown_servo_ends_with_gains_and_their_derivation() {
    let (status, answer, result) = commission("paper", PAPER);
    assert_eq!(status, Some(0), "{answer}");
    let result = result.expect("it is written");
    assert_eq!(result["status"], "applied");
    assert_eq!(result["code"], 0);
    assert_eq!(result["reason"], Value::Null);
    let b = result["servo"]["b"]["value"].as_f64().expect("a number");
    assert!((b / 257.7 - 1.0).abs() < 0.01, "{b}");
    let phases = result["phases"].as_array().expect("a list").iter();
    let names: Vec<_> = phases
        .map(|phase| phase["phase"].as_str().unwrap_or("?"))
        .collect();
    assert_eq!(
        names,
        [
            "rest",
            "probe",
            "fit",
            "frequency-response",
            "gains",
            "trial",
            "applied"
        ]
    );
    let first = answer
        .find("it moves at most")
        .expect("the largest motion is printed");
    assert!(
        names
            .iter()
            .all(|name| answer.find(name).is_some_and(|place| first < place)),
        "{answer}"
    );
    for gain in ["kp", "kd", "ki", "cutoff"] {
        assert!(
            result["gains"][gain].as_f64().expect("a number") > 0.0,
            "{gain}"
        );
    }
    let [highest, time] = [
        &result["response"]["highest_frequency"],
        &result["sample_time"],
    ]
    .map(|figure| figure.as_f64().expect("a number"));
    let looked_at = highest * time / std::f64::consts::TAU;
    assert!((0.49..0.4951).contains(&looked_at), "{looked_at}");
    let predicted = result["predicted_response"]["rise_time"]
        .as_f64()
        .expect("a number");
    let measured = result["trial"]["rise_time"].as_f64().expect("a number");
    assert!(
        (measured / predicted - 1.0).abs() < 0.15,
        "{measured} of {predicted}"
    );
}

#[test]
fn results_are_the_same_in_every_run_and_alone_on_standard_output() {
    let folder = folder("commission-streams");
    let scenario = folder.join("scenario.toml");
    fs::write(&scenario, PAPER).expect("the scenario is written");
    let scenario = scenario.display().to_string();
    for kind in ["--json", "--csv", "--plot"] {
        let [one, other] = [(); 2].map(|()| servo_id(&["commission", &scenario, kind, "-"]));
        assert_done(&one);
        assert_eq!(one.stdout, other.stdout, "{kind}");
        let text = String::from_utf8(one.stdout).expect("text");
        match kind {
            "--json" => drop(serde_json::from_str::<Value>(&text).expect("JSON and nothing else")),
            "--csv" => {
                assert!(text.starts_with("time_s,reference_rad,position_rad,command,phase,"))
            }
            _ => assert!(text.starts_with("<svg")),
        }
    }
}

#[test]
fn gains_that_are_not_applied_give_exit_status_one_and_the_reason_by_text_and_number() {
    // A locked axis: friction exceeds the largest command.
    let text = PAPER.replace("coulomb = 0.0 ", "coulomb = 9000.0 ");
    assert_ne!(text, PAPER);
    let (status, answer, result) = commission("locked", &text);
    assert_eq!(status, Some(1), "{answer}");
    let result = result.expect("it is written");
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
    let end = |kind: &str, size: &str| {
        let fault = format!("[[fault]]\nkind = \"{kind}\"\ntime = 0.4\n{size}");
        let text = format!("{PAPER}\n{CONTROLLER}{fault}\n");
        let (status, answer, result) = commission(kind, &text);
        assert_eq!(status, Some(1), "{kind}: {answer}");
        let phases = &result.expect("it is written")["phases"];
        let end = phases.as_array().and_then(|phases| phases.last());
        end.is_some_and(|end| end["excursion"].is_object())
    };
    for (kind, size, is_held) in [
        ("actuator-weak", "size = 0.3", true),
        ("encoder-lost", "", false),
        ("actuator-dead", "", false),
    ] {
        assert_eq!(end(kind, size), is_held, "{kind}");
    }
}

#[test]
fn a_commissioning_impossible_within_its_limits_is_refused_with_the_figure_that_would_do() {
    const FIXED: &str = "[identifier]\narithmetic = \"fixed\"\n[commission]";
    for (from, to, key, figure) in [
        ("travel = 0.5 ", "travel = 0.002 ", "travel", "rad"),
        ("speed = 30.0 ", "speed = 0.05 ", "speed", "0.1"),
        (
            "speed =",
            "max_gain = 600.0\nspeed =",
            "sample_time",
            "0.000750",
        ),
        (
            "speed =",
            "command_delay = 0.02\nspeed =",
            "command_delay",
            "0.0150",
        ),
        (
            "travel = 0.5 ",
            "travel = [0.1, 0.5] ",
            "travel",
            "[low, high]",
        ),
        (
            "travel = 0.5 ",
            "travel = [0.0, 0.5] ",
            "travel",
            "identify",
        ),
        ("travel = 0.5 ", "# ", "travel", "travel = 0.5 "),
        ("speed =", "command = 12.0\nspeed =", "command", "[-10, 10]"),
        ("limit = 10.0", "# ", "command", "amplifier.limit"),
        (
            "speed =",
            "bandwidth = 20.0\nstiffest = true\nspeed =",
            "bandwidth",
            "",
        ),
        ("speed =", "trial_step = 3.0\nspeed =", "trial_step", ""),
        (
            "speed =",
            "max_sensitivity = 0.9\nspeed =",
            "max_sensitivity",
            "1",
        ),
        ("[commission]", FIXED, "identifier.arithmetic", "\"f64\""),
    ] {
        assert_refused((from, to), key, figure);
    }
}

#[test]
fn a_scenario_without_limits_is_refused_with_the_lines_to_write() {
    let run = include_str!("../../../../host-sim/scenarios/paper.toml");
    let (status, answer, result) = commission("run", run);
    assert_eq!(status, Some(2), "{answer}");
    assert!(
        result.is_none() && answer.contains("travel = 0.5"),
        "{answer}"
    );
}

#[test]
fn what_chose_the_rounds_is_refused_with_what_replaces_it() {
    let folder = folder("commission-rounds");
    let path = folder.join("scenario.toml");
    let file = path.display().to_string();
    fs::write(&path, PAPER).expect("the scenario is written");
    for gone in ["--quick", "--thorough"] {
        let refused = servo_id(&["commission", &file, gone]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(standard_error(&refused).contains(gone));
    }
    let stated = PAPER.replace("[commission]", "[commission]\nslide_rounds = 1");
    fs::write(&path, stated).expect("the scenario is written");
    let refused = servo_id(&["commission", &file]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(standard_error(&refused).contains("slide_rounds"));
}

#[test]
fn gains_are_led_on_request_and_not_for_a_response_time() {
    let folder = folder("commission-led");
    let (path, result) = (folder.join("scenario.toml"), folder.join("result.json"));
    let [file, result] = [&path, &result].map(|file| file.display().to_string());
    let timed = PAPER.replace("[commission]", "[commission]\nresponse_time = 0.05");
    fs::write(&path, timed).expect("the scenario is written");
    let refused = servo_id(&["commission", &file, "--feed-forward"]);
    assert_eq!(refused.status.code(), Some(2));
    let answer = standard_error(&refused);
    assert!(answer.contains("commission.feed_forward"), "{answer}");

    fs::write(&path, PAPER).expect("the scenario is written");
    let asked = ["commission", &file, "--json", &result, "--force"];
    let gains = |flags: &[&str]| {
        assert_done(&servo_id(&[&asked, flags].concat()));
        let text = fs::read_to_string(&result).expect("it is written");
        let json: Value = serde_json::from_str(&text).expect("it is JSON");
        let rise = json["trial"]["rise_time"].as_f64().expect("s");
        (json["gains"].clone(), rise)
    };
    let ((filtered, slow), (led, quick)) = (gains(&[]), gains(&["--feed-forward"]));
    assert!(filtered.get("reference_model").is_none());
    assert!(
        led["reference_model"]["bandwidth"].as_f64() > Some(0.0),
        "{led}"
    );
    assert!(quick < 0.7 * slow, "{quick} {slow}");
}

/// Servos that five numbers do not explain, beside gains that hold them, and the effect of each.
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
        "gravity",
        "a = 0.5\nb = 257.7\ncoulomb = 30.0\nload = 3.0\ngravity = [-300.0, 0.0]\n\
         [encoder]\ncounts_per_rev = 20000\n[amplifier]\nlimit = 10.0\n\
         [controller]\nkp = 1.6\nkd = 0.06\nki = 4.0\nsample_time = 0.001\n",
        "travel = 1.5",
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
        let (_, answer, result) = commission(&format!("effect-{effect}"), &text);
        let result = result.unwrap_or_else(|| panic!("{answer}"));
        let bench = Bench::with_scenario(&format!("commission-drive-{effect}"), &text);
        let [scenario, json] = ["servo.toml", "result.json"].map(|name| bench.folder.join(name));
        let [scenario, json] = [&scenario, &json].map(|path| path.display().to_string());
        let verb = ["drive", "--port", &bench.port, "commission", &scenario];
        let output = servo_id(&[&verb[..], &["--json", &json]].concat());
        assert_eq!(output.status.code(), Some(1), "{effect}");
        let answer = standard_error(&output);
        let of_drive = fs::read_to_string(&json).unwrap_or_else(|_| panic!("{answer}"));
        let of_drive: Value = serde_json::from_str(&of_drive).expect("JSON");
        for result in [result, of_drive] {
            assert_eq!(result["code"], Reason::PartlyExplained.number(), "{effect}");
            assert_eq!(result["effects"], serde_json::json!([effect]), "{effect}");
        }
        let cause = Cause::ALL.iter().find(|cause| cause.name() == effect);
        assert!(
            answer.contains(cause.expect("its name").meaning()),
            "{answer}"
        );
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
        log += &format!("{time:.3},{seen:.9},{command:.7}\n");
        for _ in 0..STEPS {
            let step = sample / f64::from(STEPS);
            velocity = (velocity + step * (b * command + load - coulomb - a * velocity)).max(0.0);
            position += step * velocity;
        }
    }
    let folder = folder("commission-forwards");
    let [file, scenario, json] =
        ["log.csv", "scenario.toml", "result.json"].map(|name| folder.join(name));
    fs::write(&file, log).expect("written");
    let text = "[encoder]\ncounts_per_rev = 16384\n[identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"load\"]\n\
                [log]\ntime = \"time\"\nposition = \"position\"\ncommand = \"command\"\n";
    fs::write(&scenario, text).expect("written");
    let [file, scenario, result] = [&file, &scenario, &json].map(|path| path.display().to_string());
    let _ = servo_id(&[
        "identify",
        &file,
        "--scenario",
        &scenario,
        "--json",
        &result,
    ]);
    let result = fs::read_to_string(&json).expect("a result");
    let result: Value = serde_json::from_str(&result).expect("JSON");
    for (name, truth) in [("a", a), ("b", b)] {
        let found = result["estimates"][name]["value"].as_f64();
        let found = found.unwrap_or_else(|| panic!("{result}"));
        assert!((found / truth - 1.0).abs() < 0.03, "{name}: {found}");
    }
}
