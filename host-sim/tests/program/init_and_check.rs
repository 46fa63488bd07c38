//! From a data sheet to a scenario that is checked, run and commissioned.

#[cfg(unix)]
use std::path::{Path, PathBuf};

use crate::support::{argument, folder, printed, printed_json, servo_id, standard_error};
use serde_json::Value;

fn done(arguments: &[&str]) -> String {
    printed(&servo_id(arguments))
}

fn json(arguments: &[&str]) -> Value {
    printed_json(&servo_id(arguments))
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// A small DC motor at 24 V, a servo motor behind its current loop, and a large geared axis.
const SHEETS: [(&str, &[&str]); 3] = [
    (
        "voltage",
        &[
            "--voltage",
            "24",
            "--resistance",
            "0.6",
            "--torque-constant",
            "0.05",
            "--rotor-inertia",
            "3e-5",
            "--counts",
            "4096",
            "--viscous",
            "1e-5",
            "--coulomb",
            "5e-3",
        ],
    ),
    (
        "current",
        &[
            "--peak-current",
            "10",
            "--torque-constant",
            "0.07",
            "--rotor-inertia",
            "6e-5",
            "--load-inertia",
            "1e-4",
            "--counts",
            "10000",
            "--coulomb",
            "0.01",
        ],
    ),
    (
        "geared",
        &[
            "--drive",
            "current",
            "--peak-current",
            "30",
            "--torque-constant",
            "0.3",
            "--rotor-inertia",
            "5e-4",
            "--load-inertia",
            "2",
            "--gear",
            "50",
            "--counts",
            "65536",
            "--viscous",
            "1e-3",
            "--coulomb",
            "0.1",
        ],
    ),
];

fn written(name: &str, sheet: &[&str]) -> PathBuf {
    let file = folder(&format!("init-{name}")).join("servo.toml");
    done(&[&["init", &argument(&file)][..], sheet].concat());
    file
}

#[test]
fn a_written_scenario_is_checked_run_and_commissioned() {
    for (name, sheet) in SHEETS {
        let file = argument(&written(name, sheet));
        let check = json(&["check", &file, "--json", "-"]);
        assert_eq!(check["warnings"], Value::Array(vec![]), "{name}");
        assert_eq!(check["loop"]["stable"], true, "{name}");
        assert!(
            number(&check["loop"]["modulus_margin"]) > 0.5,
            "{name}: {check}"
        );
        let run = json(&["run", &file, "--json", "-"]);
        assert_eq!(run["status"], "converged", "{name}: {}", run["reason"]);
        let error = number(&run["estimates"]["b"]["value"]) / number(&run["truth"]["b"]) - 1.0;
        assert!(error.abs() < 0.01, "{name}: {error}");
        let commissioned = json(&["commission", &file, "--json", "-"]);
        assert_eq!(
            commissioned["status"], "applied",
            "{name}: {}",
            commissioned["reason"]
        );
    }
}

#[cfg(unix)]
#[test]
fn without_flags_init_asks_and_accepts_corrections_or_a_cancel() {
    use crate::support::terminal::Terminal;
    let folder = folder("init-asks");
    const PROGRAM: &str = env!("CARGO_BIN_EXE_servo-id");
    let begin = || {
        let mut terminal = Terminal::start(&[PROGRAM, "init", "asked.toml"], &folder, 100, 40);
        terminal.shows("current or voltage [current]:");
        terminal
    };
    let mut cancelled = begin();
    cancelled.types("\u{4}");
    let (status, seen) = cancelled.ends();
    assert_eq!(status, 2, "{seen}");
    assert!(seen.contains("nothing is written"), "{seen}");
    assert!(!folder.join("asked.toml").exists());

    let mut terminal = begin();
    terminal.types("voltage\n");
    for (question, answer) in [
        ("supply's voltage, V:", "24"),
        ("resistance of the winding, ohm:", "two"),
        ("a number, as 0.05 or 5e-2", "-2"),
        // It is refused at once, and asked for again.
        ("--resistance -2 is not allowed", "2"),
        ("torque constant, N m/A:", "0.05"),
        ("1 g cm² = 1e-7):", "2e-5"),
        ("after quadrature:", "4096"),
        ("kg m² [0]:", ""),
        ("one of the load [1]:", ""),
        ("N m s/rad [0]:", ""),
        ("Coulomb friction, N m [0]:", "0.01"),
        ("s [0.001]:", ""),
    ] {
        terminal.shows(question);
        terminal.types(&format!("{answer}\n"));
    }
    let seen = terminal.shows("is written");
    assert_eq!(terminal.ends().0, 0, "{seen}");
    let asked = folder.join("asked.toml");
    let stated = folder.join("stated.toml");
    let stated_name = stated.display().to_string();
    let flags = "--drive voltage --voltage 24 --resistance 2 --torque-constant 0.05 --rotor-inertia 2e-5 \
         --counts 4096 --coulomb 0.01";
    let mut words = vec!["init", stated_name.as_str()];
    words.extend(flags.split_whitespace());
    done(&words);
    let written = |file: &Path| std::fs::read_to_string(file).expect("it is written");
    assert_eq!(written(&asked), written(&stated));

    // An output that cannot be written is refused before the first question.
    let again = Terminal::start(&[PROGRAM, "init", "asked.toml"], &folder, 100, 40);
    let (status, seen) = again.ends();
    assert_eq!(status, 2, "{seen}");
    assert!(
        seen.contains("--force") && !seen.contains("current or voltage"),
        "{seen}"
    );
}

#[test]
fn the_numbers_are_those_of_the_data_sheet() {
    let file = written("numbers", SHEETS[0].1);
    let servo = &json(&["check", &argument(&file), "--json", "-"])["servo"];
    let near = |value: &Value, expected: f64| {
        assert!(
            (number(value) / expected - 1.0).abs() < 1e-5,
            "{value} {expected}"
        );
    };
    near(&servo["b"], 0.05 / (0.6 * 3e-5));
    near(&servo["a"], (1e-5 + 0.05 * 0.05 / 0.6) / 3e-5);
    let text = std::fs::read_to_string(&file).expect("a scenario");
    for derivation in [
        "(B + k_t k_e/R)/J",
        "k_t/(R J)",
        "Coulomb friction/J",
        "3 omega^2/b",
    ] {
        assert!(text.contains(derivation), "{text}");
    }
}

#[test]
fn the_examples_are_what_their_first_lines_say() {
    for name in ["dc_motor", "servo_motor"] {
        let file = format!("{}/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let example = std::fs::read_to_string(file).expect("an example");
        let call = example
            .lines()
            .find_map(|line| line.strip_prefix("#   servo-id init "));
        let options: Vec<&str> = call.expect("a call").split(' ').skip(1).collect();
        let written = done(&[&["init", "-"], &options[..]].concat());
        assert!(example.ends_with(&written), "{name}:\n{written}");
    }
}

#[test]
fn missing_or_wrong_figures_are_named_and_nothing_is_written() {
    let file = folder("init-wrong").join("servo.toml");
    for (sheet, expected) in [
        (&[][..], "--drive is missing"),
        (&["--drive", "voltage"], "--voltage is missing"),
        (&["--peak-current", "3"], "--torque-constant is missing"),
        (
            &[
                "--peak-current",
                "3",
                "--torque-constant",
                "0",
                "--rotor-inertia",
                "1e-5",
                "--counts",
                "4096",
            ],
            "--torque-constant 0 is not allowed",
        ),
    ] {
        let answer = servo_id(&[&["init", &argument(&file)][..], sheet].concat());
        assert_eq!(answer.status.code(), Some(2), "{sheet:?}");
        assert!(standard_error(&answer).contains(expected), "{answer:?}");
        assert!(!file.exists());
    }
}

fn scenario(test: &str, more: &str) -> PathBuf {
    let file = folder(&format!("check-{test}")).join("s.toml");
    let servo = "[plant]\na = 0.2174\nb = 257.7\nload = 20.0\n";
    std::fs::write(&file, format!("{servo}{more}")).expect("written");
    file
}

const LAW: &str = "[identifier]\nlaw = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"load\"]\n";

#[test]
fn parameters_that_check_promises_are_identified_in_a_run() {
    let file = scenario("known", &format!("{LAW}[run]\nduration = 20.0\n"));
    let check = json(&["check", &argument(&file), "--json", "-"]);
    let run = json(&["run", &argument(&file), "--json", "-"]);
    assert_eq!(run["status"], "converged");
    for known in check["known"].as_array().expect("a list") {
        let name = known["unknown"].as_str().expect("a name");
        assert_eq!(known["within_run"], true, "{known}");
        // No method is more accurate than the data permit.
        let least = number(&known["std_error"]);
        let reached = number(&run["estimates"][name]["std_error"]);
        assert!(
            least < 2.0 * reached,
            "{name}: {least} at best, {reached} reached"
        );
    }
    let settled = number(&run["settling_time"]["b"]);
    let known = check["known"].as_array().expect("a list");
    let b = known.iter().find(|known| known["unknown"] == "b");
    let from = number(&b.expect("b is estimated")["from"]);
    assert!(
        from <= 1.5 * settled && settled < 100.0 * from,
        "{from} s, settled {settled} s"
    );
}

#[test]
fn check_promises_no_parameter_that_the_motion_cannot_identify() {
    let stuck = scenario("stuck", &format!("coulomb = 1e9\n{LAW}"));
    let check = json(&["check", &argument(&stuck), "--json", "-"]);
    for known in check["known"].as_array().expect("a list") {
        assert_eq!(known["within_run"], false, "{known}");
        assert!(
            known["from"].is_null() && known["std_error"].is_null(),
            "{known}"
        );
    }
    // A run that breaks off cannot be longer.
    let broken = scenario(
        "broken",
        &format!(
            "{LAW}max_speed = 20.0\n[run]\nduration = 3.0\n\
             [[fault]]\nkind = \"encoder-jump\"\ntime = 0.02\nsize = 100000\n"
        ),
    );
    let check = json(&["check", &argument(&broken), "--json", "-"]);
    let known = check["known"].as_array().expect("a list");
    assert!(known.iter().any(|known| known["within_run"] == false));
    for known in known {
        assert_eq!(
            known["within_run"] == true,
            known["from"].is_number(),
            "{known}"
        );
    }
    let message = done(&["check", &argument(&broken)]);
    assert!(message.contains("the run breaks off"), "{message}");
    assert!(!message.contains("run longer"), "{message}");
}

#[test]
fn problems_of_a_scenario_are_reported() {
    let pid = "[controller]\nkp = 9.0\nki = 4.0\n";
    for (test, more, expected) in [
        (
            "still",
            format!("{LAW}[excitation]\nkind = \"steps\"\nlevels = [0.0]\nhold = 1.0\n"),
            "counts of the encoder only",
        ),
        (
            "unstable",
            format!(
                "{LAW}{pid}kd = 0.0\nsample_time = 0.05\nvelocity_filter = {{ kind = \"low-pass\", cutoff = 40.0 }}\n"
            ),
            "the loop is unstable",
        ),
        (
            "slow",
            format!(
                "{LAW}{pid}kd = 0.19\nsample_time = 0.01\nvelocity_filter = {{ kind = \"low-pass\", cutoff = 200.0 }}\n"
            ),
            "the samples are slow for this loop",
        ),
        (
            "limit",
            format!("{LAW}[amplifier]\nlimit = 0.2\n"),
            "the command is at its limit",
        ),
        (
            "coarse",
            format!("{LAW}[encoder]\ncounts_per_rev = 16\n"),
            "counts of the encoder only",
        ),
        (
            "short",
            format!("{LAW}[run]\nduration = 0.05\n"),
            "will not be known within the run",
        ),
    ] {
        let file = scenario(test, &more);
        let message = done(&["check", &argument(&file)]);
        assert!(
            message.contains("warning: ") && message.contains(expected),
            "{test}: {message}"
        );
    }
    let message = done(&["check", &argument(&scenario("sound", LAW))]);
    assert!(message.contains("No problems found."), "{message}");
}
