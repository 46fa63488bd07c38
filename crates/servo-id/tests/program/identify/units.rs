//! Physical units, goals of a servo with a loop of its own, and the joints of one log.

use serde_json::Value;

use super::{GAIN, MOTION, Motion, log, text};
use crate::support::{estimate, number};

#[test]
fn a_torque_constant_puts_the_result_in_physical_units() {
    let log = log("units-torque", &MOTION.text());
    log.done("identify log.csv --torque-constant 0.5 --json result.json");
    let result = log.read_json("result.json");
    let physical = |name: &str| number(&result, &format!("/physical/{name}/value"));
    let inertia = 0.5 / estimate(&result, "b");
    assert!((physical("inertia") - inertia).abs() < 1e-15);
    for (own, ratio) in [("viscous", "a"), ("coulomb", "coulomb"), ("load", "load")] {
        let expected = inertia * estimate(&result, ratio);
        assert!((physical(own) / expected - 1.0).abs() < 1e-12, "{own}");
        assert!(number(&result, &format!("/physical/{own}/std_error")) > 0.0);
    }
    // The name of the column, u_V, says volts: 3/200 V against friction, 8/200 V·s/rad, and −5/200 V hold the load.
    for (gain, expected) in [("kS", 3.0), ("kV", 8.0), ("kA", 1.0), ("kG", -5.0)] {
        let found = number(&result, &format!("/voltage_gains/{gain}/value"));
        let ratio = found * GAIN / expected;
        assert!((ratio - 1.0).abs() < 0.05, "{gain}: {found}");
    }
    let found = log.done("export result.json --format json");
    let exported: Value = serde_json::from_str(&found).expect("JSON");
    let inertia = &exported["joints"][0]["inertia"];
    assert_eq!(*inertia, result["physical"]["inertia"]);
}

#[test]
fn a_scale_that_is_stated_twice_is_refused() {
    let log = log("units-refused", &MOTION.text());
    log.assert_refused(
        "identify log.csv --torque-constant 0.5 --inertia 1 | inertia
        identify log.csv --torque-constant -1 | torque_constant = -1
        identify log.csv --command-unit Nm --inertia 1 | inertia
        identify log.csv --command-unit N | --command-unit
        identify log.csv --command-unit lb | lb",
    );
}

/// A servo with a loop of its own at 1 kHz, of which every row is recorded: goal, position and the command that acted.
fn with_goals() -> Motion {
    let text = format!(
        "[plant]\na = 8.0\nb = {GAIN:?}\ncoulomb = 3.0\nload = 5.0\n[encoder]\ncounts_per_rev = 10000\n\
         [amplifier]\nlimit = 2.0\n[controller]\nkp = 6.0\nkd = 0.1\nki = 0.0\nsample_time = 0.001\n\
         velocity_filter = {{ kind = \"difference\" }}\n[excitation]\nkind = \"prbs\"\namplitude = 0.3\nhold = 0.1\n\
         order = 10\n[identifier]\nlaw = \"fit\"\n[run]\nduration = 4.0\n"
    );
    Motion::of("units-goals-run", &text)
}

#[test]
fn a_log_of_goals_gives_what_the_command_would_have() {
    let of = with_goals();
    let columns = |name: &str, values: &[f64]| {
        text(&[
            ("t_s", &of.time, 4),
            ("q_rad", &of.position, 9),
            (name, values, 9),
        ])
    };
    let log = log("units-goals", &columns("goal_rad", &of.reference));
    log.write("command.csv", columns("u", &of.command));
    let of_command = log.json("identify command.csv");
    const LOOP: &str = "--goal goal_rad --kp 6 --kd 0.1 --limit 2";
    let result = log.json(&format!("identify log.csv {LOOP}"));
    assert_eq!(result["status"], "converged", "{}", result["reason"]);
    let off = |result: &Value, name: &str| {
        let [own, expected] = [result, &of_command].map(|of| estimate(of, name));
        (own / expected - 1.0).abs()
    };
    for name in ["a", "b", "coulomb", "load"] {
        assert!(off(&result, name) < 1e-3, "{name}: {result}, {of_command}");
    }
    // Likewise with a velocity, of which the loop's own is the difference.
    let before = |k: usize| of.position[k.saturating_sub(1)];
    let velocity = (0..of.position.len()).map(|k| (of.position[k] - before(k)) / 0.001);
    let velocity: Vec<_> = velocity.collect();
    let columns = text(&[
        ("t_s", &of.time, 4),
        ("q_rad", &of.position, 9),
        ("goal_rad", &of.reference, 9),
        ("w", &velocity, 9),
    ]);
    log.write("velocity.csv", columns);
    let of_velocity = log.json(&format!("identify velocity.csv {LOOP} --velocity w"));
    assert!(off(&of_velocity, "b") < 1e-3, "{of_velocity}");
    // Every tenth row: the loop is ten times faster than the log.
    let tenth = |of: &[f64]| of.iter().step_by(10).copied().collect::<Vec<_>>();
    let [time, position, goals] = [&of.time, &of.position, &of.reference].map(|of| tenth(of));
    let rare = text(&[
        ("t_s", &time, 4),
        ("q_rad", &position, 9),
        ("goal_rad", &goals, 9),
    ]);
    log.write("rare.csv", rare);
    let rare = log.json(&format!("identify rare.csv {LOOP} --loop-time 0.001"));
    let b = estimate(&rare, "b");
    assert!((b / GAIN - 1.0).abs() < 0.02, "{b}");
}

/// A torque that moves the servo beside the recorded command: gravity, and a coupling that goes with the drive.
#[test]
fn a_known_torque_is_added_to_the_command() {
    const CONSTANT: f64 = 0.5;
    let motion = &*MOTION;
    let both = motion.position.iter().zip(&motion.command);
    let torques = both.map(|(q, u)| CONSTANT * (0.2 * u + 0.05 * q.sin()));
    let torques: Vec<_> = torques.collect();
    let commands = motion.command.iter().zip(&torques);
    let commands: Vec<_> = commands
        .map(|(whole, torque)| whole - torque / CONSTANT)
        .collect();
    let log = log(
        "units-known-torque",
        &text(&[
            ("t_s", &motion.time, 4),
            ("q_rad", &motion.position, 9),
            ("u", &commands, 9),
            ("tau_model", &torques, 9),
        ]),
    );
    const CALL: &str = "identify log.csv --command u";
    let without = estimate(&log.json(&format!("{CALL} --torque-constant 0.5")), "b");
    assert!(without > 1.1 * GAIN, "{without}");
    // The scenario that is saved declares it.
    let with = "--torque-constant 0.5 --known-torque tau_model --save-scenario log.toml";
    let found = estimate(&log.json(&format!("{CALL} {with}")), "b");
    assert!((found / GAIN - 1.0).abs() < 0.01, "{found}");
    let again = estimate(&log.json("identify log.csv --scenario log.toml"), "b");
    assert!((again / found - 1.0).abs() < 1e-12);
    log.assert_refused(
        "identify log.csv --command u --known-torque tau_model | --torque-constant
        identify log.csv --command u --known-torque tau_model --inertia 1 | --torque-constant
        identify log.csv --command u --known-torque gravity --torque-constant 1 | gravity
        identify log.csv --command u --known-torque u --torque-constant 1 | u is already --command",
    );
}

#[test]
fn a_log_of_goals_is_refused_with_what_is_missing() {
    let of = with_goals();
    let goals = ("goal_rad", &*of.reference, 9);
    let log = log(
        "units-goals-refused",
        &text(&[("t_s", &of.time, 4), ("q_rad", &of.position, 9), goals]),
    );
    log.assert_refused(
        "identify log.csv --goal target --kp 6 | target
        identify log.csv --kp 6 | --goal
        identify log.csv --goal goal_rad --kp 6 --velocity w | w
        identify log.csv --goal goal_rad --kp 6 --loop-time 0.0007 --quiet | 0.0007
        identify log.csv --goal goal_rad --kp 6 --integrator rk4 | rk4",
    );
    let text = "[log]\nsample_time = 0.001\nposition = \"q_rad\"\nreference = \"goal_rad\"\n[identifier]\nlaw = \"fit\"\n\
                [inner]\nkp = 6.0\n";
    for more in [
        "[controller]\nkp = 1.0\n",
        "integrator = \"euler\"\ncutoff = 9.0\n",
    ] {
        log.write("log.toml", format!("{text}{more}"));
        log.refused("identify log.csv --scenario log.toml");
    }
}
