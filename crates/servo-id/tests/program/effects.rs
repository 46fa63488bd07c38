//! Real-world effects in a scenario: accepted values, refusals, and the verbs that take them.

use std::sync::atomic::AtomicBool;

use crate::support::readable::assert_readable;
use crate::support::table;
use host_sim::compare::Case;
use host_sim::scenario::{Purpose, Scenario};
use host_sim::{simulate, sweep};

const SERVO: &str = "[plant]\na = 0.5\nb = 200.0\ncoulomb = 4.0\nload = 1.0\n";
const SHORT: &str = "[run]\nduration = 1.0\n";

/// A run of a second with these keys of the servo and tables behind it.
fn scenario(keys: &str, tables: &str) -> Scenario {
    let text = format!("{SERVO}{keys}\n{tables}\n{SHORT}");
    Scenario::parse("s.toml", &text, Purpose::Run).unwrap_or_else(|error| panic!("{error}"))
}

fn positions(scenario: &Scenario) -> Vec<f64> {
    let mut positions = Vec::new();
    simulate::run(scenario, &mut |sample| positions.push(sample.position))
        .expect("it can be built");
    positions
}

/// Every effect by itself, as large as one sees it in a second.
const EFFECTS: [(&str, &str); 22] = [
    ("delay = 0.0024", ""),
    ("current_loop = 0.002", ""),
    ("asymmetry = 0.4", ""),
    ("low_speed_friction = 3.0\nlow_speed_velocity = 0.2", ""),
    ("gravity = [-20.0, 4.0]", ""),
    ("ripple = [0.0, 5.0]\nripple_order = 24", ""),
    ("quadratic_friction = 0.05", ""),
    ("load_dependent_friction = 0.1", ""),
    ("torque_ripple = [0.05, 0.0]\ntorque_ripple_order = 6", ""),
    ("inertia_variation = [0.0, 0.1]\ninertia_order = 1", ""),
    ("gain_asymmetry = -0.05", ""),
    ("dead_band = 0.02", ""),
    ("resonance = 300.0\ninertia_ratio = 0.5", ""),
    (
        "resonance = 300.0\ninertia_ratio = 0.5\nresonance_damping = 0.3",
        "",
    ),
    ("backlash = 0.01", ""),
    ("gain_drift = 0.05", ""),
    ("friction_drift = -0.1", ""),
    ("hidden_limit = 0.1", ""),
    ("load_wander = [5.0, 0.2]", ""),
    ("", "[encoder]\nnoise = 0.002"),
    ("", "[encoder]\neccentricity = 0.01"),
    ("", "[encoder]\njitter = 0.2"),
];

#[test]
fn a_run_takes_each_and_is_the_same_every_time() {
    let without = positions(&scenario("", ""));
    for (keys, tables) in EFFECTS {
        let scenario = scenario(keys, tables);
        let with = positions(&scenario);
        assert_eq!(with, positions(&scenario), "{keys}{tables}");
        assert_ne!(with, without, "{keys}{tables}");
    }
}

#[test]
fn the_seed_of_the_run_is_that_of_load_and_sensor() {
    let keys = "load_wander = [5.0, 0.2]";
    let of_seed = |seed: &str| {
        let text = format!(
            "{SERVO}{keys}\n{SHORT}{seed}\n[excitation]\nkind = \"square\"\namplitude = 0.1\nperiod = 0.2\n"
        );
        let scenario = Scenario::parse("s.toml", &text, Purpose::Run).expect("valid");
        positions(&scenario)
    };
    assert_eq!(of_seed(""), of_seed("seed = 1"));
    assert_ne!(of_seed(""), of_seed("seed = 2"));
}

#[test]
fn a_sweep_takes_them_on_every_servo_that_it_draws() {
    let all: Vec<&str> = EFFECTS
        .iter()
        .map(|(keys, _)| *keys)
        .filter(|keys| !keys.contains("resonance"))
        .collect();
    let base = scenario(&all.join("\n"), "[encoder]\njitter = 0.1");
    let mut lowest = base.clone();
    lowest.effects.asymmetry = 0.5;
    lowest.effects.low_speed_friction = -4.0;
    let going = AtomicBool::new(false);
    for base in [base, lowest] {
        let runs = sweep::sweep(&base, 0..20, 3, &going, &|| ()).expect("every servo can be built");
        assert_eq!(runs.len(), 20);
    }
    let drawn = [0, 1].map(|index| sweep::draw(&scenario("delay = 0.002", ""), 3, index));
    assert!(drawn.iter().all(|drawn| drawn.effects.delay > 0.0019));
    assert_ne!(drawn[0].noise_seed(), drawn[1].noise_seed());
}

#[test]
fn a_comparison_takes_them_and_omits_low_speed_friction_without_friction() {
    let base = scenario(
        "delay = 0.001\nlow_speed_friction = -3.0\nlow_speed_velocity = 0.2",
        "",
    );
    for case in Case::all(&base).expect("a servo") {
        let effects = case.scenario.effects;
        assert!(effects.delay > 0.0, "{}", case.name);
        let servo = case.scenario.plant.expect("a servo");
        let left = effects.low_speed_friction;
        assert!((left + 0.75 * servo.coulomb).abs() < 1e-12, "{}", case.name);
        case.scenario.buildable().expect(case.name);
    }
}

/// Tables, and lines of them of which the last is refused.
const IMPOSSIBLE: &str = "
plant | delay = -0.001
plant | delay = 0.07
plant | asymmetry = 0.6
plant | low_speed_friction = 3.0
plant | low_speed_velocity = 1.0; low_speed_friction = -4.5
plant | gravity = [1.0]
plant | gravity = [1e7, 0.0]
plant | ripple = [1.0, 0.0]; ripple_order = 2.5
plant | torque_ripple_order = 6; torque_ripple = [0.7, 0.7]
plant | resonance_damping = 0.1
plant | load_wander = [3.0, 0.0]
encoder | noise = -1.0
encoder | eccentricity = 4.0
encoder | jitter = 0.6
";

#[test]
fn impossible_effects_are_refused_at_their_key() {
    let refused = |keys: &str, tables: &str, key: &str| {
        let text = format!("{SERVO}{keys}\n{tables}\n{SHORT}");
        let error = Scenario::parse("s.toml", &text, Purpose::Run).expect_err(keys);
        let answer = error.to_string();
        assert_readable(&answer, &text);
        assert!(
            answer.contains(&format!(": {key}: ")),
            "{keys}{tables}: {answer}"
        );
    };
    // The key of the last line.
    for row in table(IMPOSSIBLE) {
        let last = row[1]
            .lines()
            .last()
            .and_then(|line| line.split(' ').next());
        let key = format!("{}.{}", row[0], last.expect("a key"));
        match &*row[0] {
            "plant" => refused(&row[1], "", &key),
            table => refused("", &format!("[{table}]\n{}", row[1]), &key),
        }
    }
    let control = "[controller]\nkp = 9.0\nkd = 0.19\nki = 4.0\nsample_time = 0.02\n\
                   velocity_filter = { kind = \"difference\" }";
    refused("delay = 0.11", control, "plant.delay");
}

#[test]
fn a_drift_that_leaves_nothing_is_refused_with_the_time_that_is_left() {
    let text = format!("{SERVO}gain_drift = -0.05\n[run]\nduration = 30.0\n");
    let error = Scenario::parse("s.toml", &text, Purpose::Run).expect_err("no gain is left");
    let answer = error.to_string();
    assert!(
        answer.contains("plant.gain_drift: ") && answer.contains("20 s"),
        "{answer}"
    );
}
