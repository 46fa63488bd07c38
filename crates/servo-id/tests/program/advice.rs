//! The catalogues of causes, reasons and remedies, followed: for a case that needs it, and after it the case ends better.
//! Remedies that need hands are not here.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::predict;
use crate::support::{Folder, folder, standard_error};
use identifier_core::reason::Reason;
use serde_json::Value;

/// Lines of a scenario: a table, and lines that are added to it, or that are all of it where its name begins with `=`.
type Lines = (String, String);

/// A case by name, and what each of its remedies changes.
struct Row {
    name: String,
    case: Vec<Lines>,
    remedies: Vec<Vec<Lines>>,
}

const SERVO: &str = r#"plant: a = 0.2174; b = 257.7; coulomb = 5.0 & encoder: counts_per_rev = 10000 & amplifier: limit = 10.0
    & controller: kp = 9.0; kd = 0.19; ki = 4.0; sample_time = 0.001
    & excitation: kind = "band-limited-white-noise"; power = 0.05; sample_time = 0.1; seed = 7
    & identifier: law = "gauss-newton"; parameters = ["a", "b", "coulomb", "load"] & run: duration = 10.0"#;

const AXIS: &str =
    "plant: a = 0.2174; b = 257.7 & encoder: counts_per_rev = 10000 & amplifier: limit = 10.0
    & commission: travel = 0.5; speed = 30.0; sample_time = 0.001 & [fault]:";

// Each row is a name, the case and its remedies. `back` is the table of the servo or axis. `logged` is a log recorded
// from it and identified.

/// Causes of a verdict of code 40.
const CAUSES: &str = r#"
delay | plant: delay = 0.0015 | amplifier: delay = 0.0015 | identifier: required_terms = ["delay"]
coulomb | =plant: a = 0.2174; b = 257.7; coulomb = 40.0 & =identifier: law = "gauss-newton"; parameters = ["a", "b",
    "load"] | =identifier: back
load | =plant: a = 0.2174; b = 257.7; load = 40.0 & =controller: kp = 9.0; kd = 0.19; ki = 0.0; sample_time = 0.001
    & =excitation: kind = "band-limited-white-noise"; power = 0.001; seed = 7 & =identifier: law = "paper";
    initial = { a = 0.0, b = 110.0 }; gamma = [1.0, 100.0] | =identifier: back
asymmetry | =plant: a = 3.0; b = 257.7; coulomb = 5.0; asymmetry = 1.5 | identifier: required_terms = ["asymmetry"]
low-speed-friction | plant: low_speed_friction = 10.0; low_speed_velocity = 1.0 | identifier: required_terms =
    ["low-speed"]; low_speed_velocity = 1.0
quadratic-friction | plant: quadratic_friction = 0.05 | =identifier: law = "fit" | =excitation: kind =
    "band-limited-white-noise"; power = 0.001; seed = 7
gravity | plant: gravity = [60.0, 20.0] | identifier: required_terms = ["gravity"]
ripple | plant: ripple = [15.0, 0.0]; ripple_order = 12 | identifier: required_terms = ["ripple"]; ripple_order = 12
dead-band | plant: dead_band = 0.06 | amplifier: dead_band = 0.06 | identifier: required_terms = ["dead-band"]
resonance | plant: resonance = 300.0; inertia_ratio = 0.6 | =identifier: law = "fit" | =excitation: kind =
    "multisine"; amplitudes = [1.0, 0.5]; frequencies = [3.0, 8.0] & =run: duration = 20.0
gain-drift | plant: gain_drift = 0.02 | =identifier: law = "fit" | =plant: back
friction-drift | plant: coulomb = 40.0; friction_drift = -0.04 | =identifier: law = "fit" | =plant: back
hidden-limit | plant: hidden_limit = 6.0 & =excitation: kind = "band-limited-white-noise"; power = 0.02; seed = 8 |
    =identifier: law = "fit" | =excitation: kind = "band-limited-white-noise"; power = 0.003; seed = 8
current-loop | plant: current_loop = 0.002 | =identifier: law = "fit" | amplifier: current_loop = 0.002
load-friction | plant: load = 40.0; load_dependent_friction = 0.3 | =identifier: law = "fit"
gain-asymmetry | plant: gain_asymmetry = 0.05 | =identifier: law = "fit"
torque-ripple | plant: torque_ripple = [0.05, 0.0]; torque_ripple_order = 6 | =identifier: law = "fit"
varying-inertia | plant: inertia_variation = [0.1, 0.0]; inertia_order = 1 | =identifier: law = "fit" | =excitation:
    kind = "band-limited-white-noise"; power = 0.00005; seed = 7
"#;

/// The verdict's reasons by their code.
const VERDICTS: &str = r#"
21 | =run: duration = 0.05 | =run: duration = 20.0
22 | =excitation: kind = "band-limited-white-noise"; power = 1e-9 | =excitation: back
23 | =excitation: kind = "band-limited-white-noise"; power = 5e-6; seed = 7 & =run: duration = 1.0 | =excitation:
    back | =run: duration = 20.0
24 | identifier: bounds = { a = [0.0, 50.0], b = [300.0, 1000.0] } | =identifier: back | =identifier: law = "fit"
25 | =plant: a = 0.2174; b = 257.7; coulomb = 200.0 & =encoder: counts_per_rev = 2000; noise = 0.01 & =amplifier:
    limit = 0.85 & =controller: kp = 200.0; kd = 0.5; ki = 0.0; sample_time = 0.001 & =excitation: kind = "square";
    amplitude = 1.0; period = 2.0 & =identifier: law = "fit" & =run: duration = 2.0 | =amplifier: back &
    =controller: back & =excitation: back | =encoder: back
26 | =plant: a = 5.0; b = 257.7; load = 100.0; coulomb = 5.0 & =excitation: kind = "none" & =controller: kp = 0.01;
    kd = 0.19; ki = 0.0; sample_time = 0.001 & =identifier: law = "fit" | =excitation: back & =controller: back
27 | =encoder: counts_per_rev = 200 & =excitation: kind = "band-limited-white-noise"; power = 1e-4; seed = 7 &
    =identifier: law = "fit" & =run: duration = 2.0 | =excitation: back
28 | plant: delay = 0.02 & =identifier: law = "fit" | =plant: back
29 | identifier: required_terms = ["gravity"] & =run: duration = 1.0 | =run: duration = 20.0 | =identifier: back
30 | encoder: noise = 0.02 & =identifier: law = "paper"; initial = { a = 0.0, b = 110.0 }; gamma = [0.1, 10.0] &
    =run: duration = 2.0 | =run: duration = 60.0 | =identifier: law = "fit"
41 | plant: delay = 0.0005; dead_band = 0.03 & =excitation: kind = "multisine"; amplitudes = [1.0, 0.5]; frequencies
    = [5.0, 20.0] | amplifier: delay = 0.0005; dead_band = 0.03 | =identifier: law = "fit"
42 | =plant: a = 0.2174; b = 257.7; load = 40.0 & =controller: kp = 9.0; kd = 0.19; ki = 0.0; sample_time = 0.001 &
    =identifier: law = "paper"; parameters = ["a", "b", "load"]; initial = { a = 0.0, b = 110.0 }; gamma = [1.0,
    100.0, 1.0] | =identifier: law = "fit"
"#;

/// The core's reasons that a commissioning ends by.
const COMMISSIONED: &str = r#"
travel-left | plant: load = 2000.0 & =commission: travel = 0.02; speed = 30.0; sample_time = 0.001 | =commission:
    back
speed-exceeded | =commission: travel = 0.5; speed = 2.0; sample_time = 0.001 | =commission: back
does-not-move | plant: coulomb = 300.0 & =amplifier: limit = 1.0 | =amplifier: limit = 10.0
does-not-move | plant: load = 1500.0; coulomb = 1300.0 & =commission: travel = 5.0; speed = 30.0; sample_time =
    0.001 | plant: load = 50.0; coulomb = 13.0
too-little-evidence | plant: coulomb = 5.0 & =encoder: counts_per_rev = 500 & =commission: travel = 0.25; speed =
    30.0; sample_time = 0.001 | =encoder: counts_per_rev = 10000
resonance-or-backlash | plant: resonance = 90.0; inertia_ratio = 0.78 | plant: resonance = 2000.0 | logged
resonance-or-backlash | plant: coulomb = 50.0; resonance = 300.0; inertia_ratio = 0.5; backlash = 0.012 | plant:
    backlash = 0.0
partly-explained | plant: ripple = [500.0, 0.0]; ripple_order = 20 | logged
no-gains | commission: response_time = 0.012 | commission: response_time = 0.03
prediction-missed | =plant: a = 0.663; b = 58.4; coulomb = 29.9; low_speed_friction = 85.3; low_speed_velocity =
    0.17 & =encoder: counts_per_rev = 2000 & =commission: travel = 0.606; speed = 23.2; sample_time = 0.001 |
    =plant: a = 0.663; b = 58.4; coulomb = 29.9
actuator-weak | [fault]: kind = "actuator-weak"; time = 2.5; size = 0.4 | =[fault]:
never-at-rest | =plant: a = 0.316; b = 112.1; resonance = 44.8; inertia_ratio = 0.73 & =encoder: counts_per_rev =
    65536 & =amplifier: limit = 5.0 & =commission: travel = 1.045; speed = 61.55; sample_time = 0.001 | =plant: a =
    0.316; b = 112.1
reversed | plant: delay = 0.01 | amplifier: delay = 0.01
oscillating | plant: current_loop = 0.0165 | plant: current_loop = 0.002
too-little-evidence | =plant: a = 0.2174; b = 20.0 & commission: duration = 0.03 | commission: duration = 0.5
"#;

/// Reasons why a first fit does not succeed.
const REJECTION_REASONS: &str = r#"
too-little-motion | =excitation: kind = "multisine"; amplitudes = [0.003]; frequencies = [3.0] | =excitation: back
one-way-motion | =plant: a = 5.0; b = 257.7; load = 100.0; coulomb = 5.0 & =controller: kp = 0.01; kd = 0.19; ki =
    0.0; sample_time = 0.001 & =excitation: kind = "none" & identifier: noise = 0.05 | =controller: back &
    =excitation: back
constant-command | =plant: a = 5.0; b = 257.7; load = 100.0; coulomb = 5.0 & =amplifier: limit = 0.05 & =controller:
    kp = 200.0; kd = 0.5; ki = 0.0; sample_time = 0.001 & =excitation: kind = "none" | =amplifier: back &
    =controller: back & =excitation: back
early-command | amplifier: delay = 0.003 | amplifier: delay = 0.0
partly-explained | plant: gravity = [1000.0, 500.0] | =identifier: law = "fit"
"#;

/// The tables of a cell.
fn lines(cell: &str) -> Vec<Lines> {
    let table = |table: &str| {
        let (name, text) = table.split_once(':').unwrap_or((table, ""));
        (name.trim().to_owned(), text.trim().replace("; ", "\n"))
    };
    cell.replace("\n    ", " ")
        .split(" & ")
        .map(table)
        .collect()
}

fn rows(table: &str) -> Vec<Row> {
    let row = |row: &str| {
        let mut cells = row.split(" | ");
        let mut next = || cells.next().expect("a cell");
        let (name, case) = (next().to_owned(), lines(next()));
        let remedies = cells.map(lines).collect();
        Row {
            name,
            case,
            remedies,
        }
    };
    table
        .replace("\n    ", " ")
        .trim()
        .lines()
        .map(row)
        .collect()
}

/// A scenario: `base` with the lines of each list, one after the other.
fn scenario(base: &str, changes: [&[Lines]; 2]) -> String {
    let own = lines(base);
    let mut tables = own.clone();
    for (name, text) in changes.into_iter().flatten() {
        let (name, replaces) = name
            .strip_prefix('=')
            .map_or((&**name, false), |name| (name, true));
        let place = tables.iter().position(|(known, _)| known == name);
        let place = place.expect("a table of the base");
        let text = if text == "back" { &own[place].1 } else { text };
        let table = &mut tables[place].1;
        if replaces {
            table.clear();
        }
        // A key that is stated again is stated anew.
        let key = |line: &str| line.split(" =").next().unwrap_or_default().to_owned();
        let keys: BTreeSet<String> = text.lines().map(key).collect();
        let kept = table.lines().filter(|line| !keys.contains(&key(line)));
        *table = kept
            .chain(text.lines())
            .fold(String::new(), |table, line| table + line + "\n");
    }
    let stated = tables.iter().filter(|(_, text)| !text.is_empty());
    stated.fold(String::new(), |mut all, (name, text)| {
        let _ = writeln!(all, "[{name}]\n{text}");
        all
    })
}

/// A run of a scenario: its result.
fn identified(folder: &Folder, text: &str) -> Value {
    folder.write("scenario.toml", text);
    folder.json("run scenario.toml")
}

/// Asserts that each row ends as is checked by its name, and that the servo is identified after each remedy.
fn assert_followed(test: &str, table: &str, check: impl Fn(&str, &Value)) {
    let folder = folder(test);
    for row in rows(table) {
        let before = identified(&folder, &scenario(SERVO, [&row.case, &[]]));
        check(&row.name, &before);
        assert_ne!(before["status"], "converged", "{before}");
        for remedy in &row.remedies {
            let after = identified(&folder, &scenario(SERVO, [&row.case, remedy]));
            assert_eq!(
                after["status"], "converged",
                "{}, {remedy:?}: {after}",
                row.name
            );
        }
    }
}

#[test]
fn a_servo_whose_effect_is_named_is_identified_once_the_remedy_is_followed() {
    assert_followed("advice-causes", CAUSES, |name, before| {
        // In a model without a delay, a current loop appears as one.
        if name != "current-loop" {
            assert_eq!(before["cause"]["name"], name, "{before}");
            assert_eq!(before["code"], 40, "{before}");
        }
    });
}

#[test]
fn a_verdict_becomes_converged_once_its_remedy_is_followed() {
    assert_followed("advice-verdicts", VERDICTS, |name, before| {
        // Where the answer is rough, the remedy is that of the refused fit.
        let code = match before["code"] == 50 {
            true => &before["refused_code"],
            false => &before["code"],
        };
        assert_eq!(code.to_string(), name, "{before}");
    });
}

#[test]
fn a_first_fit_succeeds_once_the_remedy_of_its_rejection_reason_is_followed() {
    assert_followed("advice-obstacles", REJECTION_REASONS, |name, before| {
        assert_eq!(before["code"], 20, "{before}");
        assert_eq!(before["first_fit_rejection"]["name"], name, "{before}");
    });
}

/// Scenarios in a row, each with a gain and an instant of its fault that are larger by so much than those of the last.
const NEIGHBOURS: u32 = 26;
const NEXT: f64 = 0.002;

/// The neighbour of a scenario so many steps away.
fn neighbour(text: &str, step: u32) -> String {
    let factor = 1.0 + NEXT * f64::from(step);
    let line = |line: &str| match line.split_once(" = ") {
        Some((name @ ("b" | "time"), value)) => {
            let value: f64 = value.parse().expect("a number");
            format!("{name} = {}\n", factor * value)
        }
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

/// How a commissioning ends: done, or the message.
fn commissioned(folder: &Folder, text: &str) -> Result<(), String> {
    folder.write("scenario.toml", text);
    let output = folder.call("commission scenario.toml");
    let is_done = output.status.success();
    is_done.then_some(()).ok_or_else(|| standard_error(&output))
}

#[test]
fn a_commissioning_succeeds_once_the_remedy_of_its_reason_is_followed() {
    let folder = folder("advice-reasons");
    let mut wrong = Vec::new();
    for Row {
        name,
        case,
        remedies,
    } in rows(COMMISSIONED)
    {
        let reason = Reason::ALL.iter().find(|reason| reason.name() == name);
        let message = reason.expect("a reason").to_string();
        let (number, _) = message.split_once(' ').expect("fault or reason");
        let number = format!("{number} {}:", reason.expect("a reason").number());
        // Some reasons are rare, and any change of a motion moves them to a neighbour.
        let ends_by_it = |&step: &u32| {
            let case = neighbour(&scenario(AXIS, [&case, &[]]), step);
            commissioned(&folder, &case).is_err_and(|said| said.contains(&number))
        };
        let Some(step) = (0..NEIGHBOURS).find(ends_by_it) else {
            wrong.push(format!("{name}: none ends by it"));
            continue;
        };
        for remedy in &remedies {
            if remedy[0].0 == "logged" {
                assert_logged(&folder, &case);
            } else {
                let after = neighbour(&scenario(AXIS, [&case, remedy]), step);
                let said = commissioned(&folder, &after).err();
                wrong.extend(said.map(|said| format!("{name}: {said}")));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Asserts that the servo of a commissioning's case is identified from a log of it.
fn assert_logged(folder: &Folder, case: &[Lines]) {
    let is_servo = |(name, _): &&Lines| name.trim_start_matches('=') == "plant";
    let mut changes: Vec<Lines> = case.iter().filter(is_servo).cloned().collect();
    changes.insert(0, lines(AXIS)[0].clone());
    changes[0].0 = "=plant".to_owned();
    let text = scenario(SERVO, [&changes, &lines("=run: duration = 5.0")]);
    folder.write("logged.toml", text);
    folder.done("run logged.toml --csv log.csv --force");
    folder.done("identify log.csv --require converged");
}

#[test]
fn a_log_is_predicted_once_the_estimates_come_from_motions_like_it() {
    let folder = folder("advice-predicted");
    let brake = "low_speed_friction = 25.0\nlow_speed_velocity = 100.0\n";
    for (seed, effects) in [(1, ""), (2, brake), (3, brake)] {
        predict::log(&folder, seed, effects);
    }
    predict::scenario(&folder, predict::ALL, predict::CONTROLLER);
    for (seed, code) in [(1, 43), (2, 0)] {
        let call = format!("identify {seed}.csv --scenario replay.toml --predict 3.csv");
        let result = folder.json(&call);
        assert_eq!(result["code"], code, "{result}");
    }
}
