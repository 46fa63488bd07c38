//! The scenarios of the page are those that their texts are on the command line.

use std::path::Path;

use host_sim::scenario::{Purpose, Scenario};
use identifier_log::log::Table;
use identifier_log::recognise::{LogOptions, recognise};
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
        let mut own = settings.scenario().expect("allowed");
        // A text has the defaults of what it does not state and a run does not need.
        own.compare = read.compare;
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

#[test]
fn a_log_is_taken_with_the_scenario_that_identify_saves() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/logs/simulated-servo.csv.gz");
    let recognised = recognise(
        &Table::read(&path).expect("a table"),
        &LogOptions::default(),
    )
    .expect("a log");
    let text = recognised.scenario("log");
    let read = Scenario::parse("log.toml", &text, Purpose::Replay).expect("allowed");
    let mut own = log::scenario(&recognised).expect("allowed");
    own.compare = read.compare;
    // A text has the defaults of what it does not state and no fit needs.
    own.excitation = read.excitation.clone();
    own.stated.identifier.initial = read.stated.identifier.initial;

    assert_eq!(own, read, "{text}");
}
