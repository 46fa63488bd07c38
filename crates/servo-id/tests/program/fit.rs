//! One fit to a whole log, from the command line.

use serde_json::{Value, json};

use crate::support::{Folder, estimate, number, own_folder, scenario_text};

/// The trace of a simulated servo, and the scenario of the page on the fit.
fn trace() -> Folder {
    let folder = own_folder();
    folder.write("servo.toml", scenario_text("friction.toml"));
    folder.done("run servo.toml --csv trace.csv");
    let page = include_str!("../../../../docs/fit.md");
    let example = page.split("```").nth(1).expect("an example");
    folder.write("fit.toml", example.trim_start_matches("toml"));
    folder
}

const REPLAY: &str = "identify trace.csv --scenario fit.toml";

/// Changes the commands of a trace.
fn with_commands(folder: &Folder, change: impl FnOnce(&mut Vec<f64>)) {
    let text = folder.read("trace.csv");
    let rows = text.lines().map(|line| line.split(',').collect());
    let rows: Vec<Vec<&str>> = rows.collect();
    let place = rows[0].iter().position(|name| *name == "command");
    let place = place.expect("a column of commands");
    let commands = rows[1..]
        .iter()
        .map(|row| row[place].parse().expect("a number"));
    let mut commands: Vec<f64> = commands.collect();
    change(&mut commands);
    let mut changed = rows[0].join(",") + "\n";
    for (row, command) in rows[1..].iter().zip(commands) {
        let mut row = row.clone();
        let command = command.to_string();
        row[place] = &command;
        changed += &(row.join(",") + "\n");
    }
    folder.write("trace.csv", changed);
}

fn std_error(result: &Value, name: &str) -> f64 {
    number(result, &format!("/estimates/{name}/std_error"))
}

#[test]
fn a_log_is_identified_without_a_first_guess() {
    let result = trace().json(REPLAY);
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    for (name, truth, tolerance) in [("b", 257.7, 2e-3), ("coulomb", 10.0, 0.01)] {
        let off = (estimate(&result, name) - truth).abs();
        let error = std_error(&result, name);
        let is_right = off < 4.0 * error && off < tolerance * truth;
        assert!(is_right, "{name}: {off} ± {error}");
    }
    let noise = number(&result, "/noise/moving_counts");
    assert!((0.25..0.35).contains(&noise), "{noise}");
    assert_eq!(result["fit"]["effects"], json!([]));
    assert!(result["fit"]["command_recorded_late"].is_null());
}

/// With the servo as the model, only the quantisation of the encoder is left, sample by sample; of one with another
/// gain more.
#[test]
fn what_a_model_leaves_of_every_sample_is_beside_it() {
    let trace = trace();
    let left = || -> f64 {
        let text = trace.done(&format!("{REPLAY} --csv -"));
        let mut cells = text
            .lines()
            .map(|line| line.split(',').nth(3).expect("a cell"));
        assert_eq!(cells.next(), Some("residual_rad"));
        let errors: Vec<f64> = cells.flat_map(str::parse).collect();
        assert!(errors.len() > 7500, "{} of 8000", errors.len());
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        (squares / errors.len() as f64).sqrt() * 10_000.0 / std::f64::consts::TAU
    };
    let counts = left();
    assert!((0.27..0.35).contains(&counts), "{counts}");
    // A delay that changes in the middle is none that a model has.
    with_commands(&trace, |commands| {
        let half = commands.len() / 2;
        commands[half..].rotate_right(6);
    });
    let counts = left();
    assert!(counts > 0.5, "{counts}");
}

#[test]
fn the_table_of_an_identified_log_has_no_empty_column() {
    let trace = trace();
    let text = trace.done(&format!("{REPLAY} --csv -"));
    let rows: Vec<Vec<&str>> = text.lines().map(|row| row.split(',').collect()).collect();
    let heading = "time_s,position_rad,model_rad,residual_rad,command,a_per_s,b_rad_per_s2_per_command,\
                   coulomb_rad_per_s2,load_rad_per_s2";
    assert_eq!(rows[0].join(","), heading);
    let cell = |row: &Vec<&str>, place: usize| row[place].parse::<f64>().expect("a number");
    for row in rows.iter().skip(500).step_by(100) {
        let [position, model, residual] = [1, 2, 3].map(|place| cell(row, place));
        assert!((position - model - residual).abs() < 1e-12, "{row:?}");
        assert!((cell(row, 6) / 257.7 - 1.0).abs() < 2e-3, "{row:?}");
    }
    // An online estimator has the course of its estimates and of their errors.
    let text = trace.done("identify trace.csv --scenario servo.toml --csv -");
    assert_eq!(
        text.lines().next().map(|row| row.split(',').count()),
        Some(13)
    );
}

/// The scenario of the page with further keys of the identifier.
fn with_keys(folder: &Folder, keys: &str) {
    let law = "law = \"fit\"";
    let text = folder.read("fit.toml");
    folder.write("fit.toml", text.replace(law, &format!("{law}\n{keys}")));
}

#[test]
fn a_required_term_is_in_the_model_without_evidence() {
    let trace = trace();
    assert!(trace.json(REPLAY)["estimates"]["asymmetry"].is_null());
    with_keys(&trace, "required_terms = [\"asymmetry\"]");
    let result = trace.json(REPLAY);
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    let size = estimate(&result, "asymmetry");
    let error = std_error(&result, "asymmetry");
    assert!(size.abs() < 4.0 * error && error < 0.1, "{size} ± {error}");
}
