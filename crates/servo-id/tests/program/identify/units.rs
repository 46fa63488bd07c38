//! Physical units, goals of a servo with a loop of its own, and the joints of one log.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::{GAIN, Motion, cells, log, text};
use crate::support::{
    argument, assert_done, folder, printed, printed_json, refusal_message, servo_id, standard_error,
};

fn value(of: &Value) -> f64 {
    of["value"].as_f64().expect("a number")
}

#[test]
fn a_torque_constant_puts_the_result_in_physical_units() {
    let motion = Motion::new();
    let log = log("units-torque", &motion.text());
    let json = argument(&Path::new(&log).with_extension("json"));
    let call = [
        "identify",
        &log,
        "--torque-constant",
        "0.5",
        "--json",
        &json,
    ];
    assert_done(&servo_id(&call));
    let result: Value =
        serde_json::from_str(&std::fs::read_to_string(&json).expect("a file")).expect("JSON");
    let (estimates, physical) = (&result["estimates"], &result["physical"]);
    let inertia = 0.5 / value(&estimates["b"]);
    assert!((value(&physical["inertia"]) - inertia).abs() < 1e-15);
    for (own, ratio) in [("viscous", "a"), ("coulomb", "coulomb"), ("load", "load")] {
        let expected = inertia * value(&estimates[ratio]);
        assert!(
            (value(&physical[own]) / expected - 1.0).abs() < 1e-12,
            "{own}"
        );
        assert!(
            physical[own]["std_error"]
                .as_f64()
                .is_some_and(|error| error > 0.0)
        );
    }
    // The name of the column, u_V, says volts: 3/200 V against friction, 8/200 V·s/rad, and −5/200 V hold the load.
    for (gain, expected) in [("kS", 3.0), ("kV", 8.0), ("kA", 1.0), ("kG", -5.0)] {
        let found = value(&result["voltage_gains"][gain]);
        assert!(
            (found * GAIN / expected - 1.0).abs() < 0.05,
            "{gain}: {found}"
        );
    }
    let found = printed(&servo_id(&["export", &json, "--format", "json"]));
    let exported: Value = serde_json::from_str(&found).expect("JSON");
    assert_eq!(exported["joints"][0]["inertia"], physical["inertia"]);
}

#[test]
fn a_scale_that_is_stated_twice_is_refused() {
    let log = log("units-refused", &Motion::new().text());
    for (options, named) in [
        ("--torque-constant 0.5 --inertia 1", "inertia"),
        ("--torque-constant -1", "torque_constant = -1"),
        ("--command-unit Nm --inertia 1", "inertia"),
        ("--command-unit N", "--command-unit"),
        ("--command-unit lb", "lb"),
    ] {
        let call: Vec<_> = ["identify", &log]
            .into_iter()
            .chain(options.split(' '))
            .collect();
        let message = refusal_message(&servo_id(&call));
        assert!(message.contains(named), "{options:?}: {message}");
    }
}

#[test]
fn a_payload_beside_the_gain_without_it_gives_the_inertia() {
    let folder = folder("units-payload");
    let scenario = folder.join("payload.toml");
    let text = "[plant]\na = 2.0\nb = 160.0\n[identifier]\nlaw = \"fit\"\n[run]\nduration = 4.0\n\
                [physical]\npayload = 0.001\nbare_gain = [200.0, 0.1]\n";
    std::fs::write(&scenario, text).expect("written");
    let result = printed_json(&servo_id(&["run", &argument(&scenario), "--json", "-"]));
    // J = m b₀/(b₀ − b) = 0.001·200/40.
    let inertia = value(&result["physical"]["inertia"]);
    assert!((inertia / 0.005 - 1.0).abs() < 0.01, "{inertia}");
    std::fs::write(&scenario, text.replace("bare_gain = [200.0, 0.1]\n", "")).expect("written");
    refusal_message(&servo_id(&["run", &argument(&scenario)]));
}

/// A servo with a loop of its own at 1 kHz, of which every row is recorded: goal, position and the command that acted.
fn with_goals() -> Motion {
    Motion::of(&servo_of_goals())
}

/// Its scenario.
fn servo_of_goals() -> PathBuf {
    let scenario = folder("units-goals-run").join("servo.toml");
    let text = format!(
        "[plant]\na = 8.0\nb = {GAIN:?}\ncoulomb = 3.0\nload = 5.0\n[encoder]\ncounts_per_rev = 10000\n\
         [amplifier]\nlimit = 2.0\n[controller]\nkp = 6.0\nkd = 0.1\nki = 0.0\nsample_time = 0.001\n\
         velocity_filter = {{ kind = \"difference\" }}\n[excitation]\nkind = \"prbs\"\namplitude = 0.3\nhold = 0.1\n\
         order = 10\n[identifier]\nlaw = \"fit\"\n[run]\nduration = 4.0\n"
    );
    std::fs::write(&scenario, text).expect("written");
    scenario
}

/// The result of a log of goals.
fn by_goals(log: &str, options: &[&str]) -> Value {
    let call = ["identify", log, "--goal", "goal_rad", "--json", "-"];
    printed_json(&servo_id(&[&call[..], options].concat()))
}

const LOOP: [&str; 6] = ["--kp", "6", "--kd", "0.1", "--limit", "2"];

#[test]
fn a_log_of_goals_gives_what_the_command_would_have() {
    let motion = with_goals();
    let goals = cells(&motion.reference, 9);
    let [time, position, command] = [
        cells(&motion.time, 4),
        cells(&motion.position, 9),
        cells(&motion.command, 9),
    ];
    let of_command = log(
        "units-goals-command",
        &text(
            ",",
            &[("t_s", &time), ("q_rad", &position), ("u", &command)],
        ),
    );
    let of_command = printed_json(&servo_id(&["identify", &of_command, "--json", "-"]));
    let of_goals = log(
        "units-goals",
        &text(
            ",",
            &[("t_s", &time), ("q_rad", &position), ("goal_rad", &goals)],
        ),
    );
    let result = by_goals(&of_goals, &LOOP);
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    for name in ["a", "b", "coulomb", "load"] {
        let [own, expected] = [&result, &of_command].map(|of| value(&of["estimates"][name]));
        assert!(
            (own / expected - 1.0).abs() < 1e-3,
            "{name}: {own}, {expected}"
        );
    }
    // Likewise with a velocity, of which the loop's own is the difference.
    let velocity: Vec<_> = (0..motion.position.len())
        .map(|k| (motion.position[k] - motion.position[k.saturating_sub(1)]) / 0.001)
        .collect();
    let of_velocity = log(
        "units-goals-velocity",
        &text(
            ",",
            &[
                ("t_s", &time),
                ("q_rad", &position),
                ("goal_rad", &goals),
                ("w", &cells(&velocity, 9)),
            ],
        ),
    );
    let of_velocity = by_goals(&of_velocity, &[&LOOP[..], &["--velocity", "w"]].concat());
    let [own, expected] = [&of_velocity, &of_command].map(|of| value(&of["estimates"]["b"]));
    assert!((own / expected - 1.0).abs() < 1e-3, "{own}, {expected}");
    // Every tenth row: the loop is ten times faster than the log.
    let tenth = |cells: &[String]| cells.iter().step_by(10).cloned().collect::<Vec<_>>();
    let columns = [tenth(&time), tenth(&position), tenth(&goals)];
    let rare = log(
        "units-goals-rare",
        &text(
            ",",
            &[
                ("t_s", &columns[0]),
                ("q_rad", &columns[1]),
                ("goal_rad", &columns[2]),
            ],
        ),
    );
    let options = [&LOOP[..], &["--loop-time", "0.001"]].concat();
    let rare = by_goals(&rare, &options);
    let b = value(&rare["estimates"]["b"]);
    assert!((b / GAIN - 1.0).abs() < 0.02, "{b}");
}

/// A torque that moves the servo beside the recorded command: gravity, and a coupling that goes with the drive.
#[test]
fn a_known_torque_is_added_to_the_command() {
    const CONSTANT: f64 = 0.5;
    let motion = Motion::new();
    let torques: Vec<_> = (motion.position.iter().zip(&motion.command))
        .map(|(q, u)| CONSTANT * (0.2 * u + 0.05 * q.sin()))
        .collect();
    let commands: Vec<_> = (motion.command.iter().zip(&torques))
        .map(|(whole, torque)| whole - torque / CONSTANT)
        .collect();
    let columns = [
        ("t_s", &cells(&motion.time, 4)),
        ("q_rad", &cells(&motion.position, 9)),
        ("u", &cells(&commands, 9)),
        ("tau_model", &cells(&torques, 9)),
    ];
    let of_torque = log(
        "units-known-torque",
        &text(",", &columns.map(|(name, cells)| (name, &cells[..]))),
    );
    let b = |options: &[&str]| {
        let call = ["identify", &of_torque, "--command", "u", "--json", "-"];
        value(&printed_json(&servo_id(&[&call[..], options].concat()))["estimates"]["b"])
    };
    let without = b(&["--torque-constant", "0.5"]);
    assert!(without > 1.1 * GAIN, "{without}");
    let with = ["--torque-constant", "0.5", "--known-torque", "tau_model"];
    let found = b(&with);
    assert!((found / GAIN - 1.0).abs() < 0.01, "{found}");
    // The scenario that is saved declares it.
    let scenario = argument(&Path::new(&of_torque).with_extension("toml"));
    let save = [
        "identify",
        &of_torque,
        "--command",
        "u",
        "--save-scenario",
        &scenario,
    ];
    assert_done(&servo_id(&[&save[..], &with].concat()));
    let again = printed_json(&servo_id(&[
        "identify",
        &of_torque,
        "--scenario",
        &scenario,
        "--json",
        "-",
    ]));
    assert!((value(&again["estimates"]["b"]) / found - 1.0).abs() < 1e-12);
    for (options, named) in [
        ("--known-torque tau_model", "--torque-constant"),
        ("--known-torque tau_model --inertia 1", "--torque-constant"),
        ("--known-torque gravity --torque-constant 1", "gravity"),
        (
            "--known-torque u --torque-constant 1",
            "u is already --command",
        ),
    ] {
        let call = ["identify", &of_torque, "--command", "u"]
            .into_iter()
            .chain(options.split(' '));
        let message = refusal_message(&servo_id(&call.collect::<Vec<_>>()));
        assert!(message.contains(named), "{options:?}: {message}");
    }
}

#[test]
fn a_log_of_goals_is_refused_with_what_is_missing() {
    let motion = with_goals();
    let [time, position, goals] = [
        cells(&motion.time, 4),
        cells(&motion.position, 9),
        cells(&motion.reference, 9),
    ];
    let own = log(
        "units-goals-refused",
        &text(
            ",",
            &[("t_s", &time), ("q_rad", &position), ("goal_rad", &goals)],
        ),
    );
    for (options, named) in [
        ("--goal target --kp 6", "target"),
        ("--kp 6", "--goal"),
        ("--goal goal_rad --kp 6 --velocity w", "w"),
        ("--goal goal_rad --kp 6 --loop-time 0.0007", "0.0007"),
        ("--goal goal_rad --kp 6 --integrator rk4", "rk4"),
    ] {
        let call = ["identify", &own]
            .into_iter()
            .chain(options.split_whitespace());
        let output = servo_id(&call.collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(2), "{options}");
        let message = standard_error(&output);
        assert!(message.contains(named), "{options:?}: {message}");
    }
    let scenario = Path::new(&own).with_extension("toml");
    let text = "[log]\nsample_time = 0.001\nposition = \"q_rad\"\nreference = \"goal_rad\"\n[identifier]\nlaw = \"fit\"\n\
                [inner]\nkp = 6.0\n";
    for more in [
        "[controller]\nkp = 1.0\n",
        "integrator = \"euler\"\ncutoff = 9.0\n",
    ] {
        std::fs::write(&scenario, format!("{text}{more}")).expect("written");
        refusal_message(&servo_id(&[
            "identify",
            &own,
            "--scenario",
            &argument(&scenario),
        ]));
    }
}

#[test]
fn the_columns_of_one_log_are_the_joints_of_one_model() {
    let motion = Motion::new();
    let [time, position] = [cells(&motion.time, 4), cells(&motion.position, 6)];
    let [hip, knee] = [1.0, 2.0].map(|factor| {
        let command: Vec<_> = motion.command.iter().map(|u| factor * u).collect();
        cells(&command, 5)
    });
    let own = log(
        "units-joints",
        &text(
            ",",
            &[
                ("t_s", &time),
                ("hip_q", &position),
                ("knee_q", &position),
                ("hip_u", &hip),
                ("knee_u", &knee),
            ],
        ),
    );
    let folder = folder("units-joints-results");
    let results = ["hip", "knee"].map(|joint| {
        let json = argument(&folder.join(format!("{joint}.json")));
        let [position, command] = ["q", "u"].map(|of| format!("{joint}_{of}"));
        let columns = ["--position", &position, "--command", &command];
        let rest = [
            "--position-unit",
            "rad",
            "--torque-constant",
            "0.5",
            "--json",
            &json,
        ];
        assert_done(&servo_id(
            &[&["identify", &own], &columns[..], &rest].concat(),
        ));
        json
    });
    let output = servo_id(&["export", &results[0], &results[1], "--format", "json"]);
    let joints: Value = serde_json::from_str(&printed(&output)).expect("JSON");
    let names: Vec<_> = joints["joints"]
        .as_array()
        .expect("joints")
        .iter()
        .map(|one| &one["name"])
        .collect();
    assert_eq!(names, [&json!("hip"), &json!("knee")]);
    let [hip, knee] = [0, 1].map(|place| value(&joints["joints"][place]["inertia"]));
    assert!((knee / hip - 2.0).abs() < 1e-3, "{hip} {knee}");
}
