//! The scenarios of the page are those that their texts are on the command line.

use std::path::Path;

use host_sim::scenario::{Purpose, Scenario};
use identifier_log::log::Table;
use identifier_log::recognise::LogOptions;
use playground::log;
use playground::settings::Settings;

/// A servo without effects, in the order of the settings.
const PLAIN: [f64; Settings::COUNT] = [
    0.2174, 257.7, 10.0, 20.0, 0.0, 0.0, 0.0, 0.5, 1e4, 10.0, 9.0, 4.0, 0.19, 1e-3, 500.0, 0.0,
    0.2236, 0.1, 6.0, 7.0,
];

fn with(changes: &[(usize, f64)]) -> [f64; Settings::COUNT] {
    let mut values = PLAIN;
    for &(place, value) in changes {
        values[place] = value;
    }
    values
}

#[test]
fn the_text_of_settings_is_their_scenario() {
    let [load_step, delay, resonance, reference] = [4, 5, 6, 15];
    for changes in [
        &[][..],
        &[(load_step, 30.0)],
        &[(delay, 2.4e-3), (reference, 1.0)],
        &[(resonance, 63.0), (reference, 2.0)],
    ] {
        let settings = Settings::from_values(&with(changes)).expect("complete");
        let text = settings.text();
        let read = Scenario::parse("playground.toml", &text, Purpose::Run);
        let read = read.unwrap_or_else(|error| panic!("{error}\n{text}"));
        let own = settings.scenario().expect("allowed");
        assert_eq!(own, read, "{text}");
    }
}

#[test]
fn settings_that_are_not_allowed_are_refused_by_key() {
    let [counts, period] = [8, 17];
    for (changes, key) in [
        (&[(counts, 0.0)], "encoder.counts_per_rev"),
        (&[(period, 0.0105)], "excitation.sample_time"),
    ] {
        let settings = Settings::from_values(&with(changes)).expect("complete");
        let refusal = settings.scenario().expect_err("not allowed").to_string();
        assert!(refusal.contains(key), "{refusal}");
    }
    assert_eq!(Settings::from_values(&PLAIN[1..]), None);
    assert_eq!(Settings::from_values(&with(&[(15, 3.0)])), None);
}

/// The shipped log with its position in counts, without a word about them.
#[test]
fn a_log_in_counts_has_no_gains_and_no_physical_unit_until_they_are_stated() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/logs/simulated-servo.csv.gz");
    let table = Table::read(&path).expect("a table");
    let column = |name: &str| {
        let of = table.columns.iter().find(|column| column.name == name);
        of.expect("a column").values.clone()
    };
    let (time, position, command) = (column("time_s"), column("position_rad"), column("command"));
    let rows = (time.iter().zip(&position)).zip(&command);
    let rows = rows.map(|((time, position), command)| {
        let counts = position * 10_000.0 / std::f64::consts::TAU;
        format!("{time},{counts:.0},{command}\n")
    });
    let text = format!("t_s,q,u\n{}", rows.collect::<String>());
    let identify = |stated: &[(&str, &str)]| {
        let mut options = LogOptions::default();
        for (flag, answer) in stated {
            options.answer(flag, answer).expect("allowed");
        }
        log::identify(text.clone().into_bytes(), &options)
    };
    let found = identify(&[]).expect("a log");
    assert_eq!(found.summary.position_unit.name(), "counts");
    assert_eq!(found.summary.estimates.b.unit, "counts/s² per command unit");
    assert!(found.summary.physical.is_none());
    let none = found.tuned.expect_err("no gains");
    assert!(none.contains("--counts-per-rev"), "{none}");
    let refused = identify(&[("torque-constant", "0.1")]).expect_err("no unit");
    assert!(
        refused.text.contains("--counts-per-rev"),
        "{}",
        refused.text
    );

    let stated = identify(&[("counts-per-rev", "10000"), ("torque-constant", "0.1")]);
    let found = stated.expect("a log");
    assert!((found.summary.estimates.b.value / 257.7 - 1.0).abs() < 0.01);
    let physical = found.summary.physical.expect("its unit is stated");
    assert!((physical.inertia.value * 257.7 / 0.1 - 1.0).abs() < 0.01);
    assert!(found.tuned.is_ok());
}
