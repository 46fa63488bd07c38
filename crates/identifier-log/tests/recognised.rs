//! A recognised log is identified with the options that its saved scenario states.

use std::path::Path;

use identifier_log::log::Table;
use identifier_log::recognise::{LogOptions, recognise};
use identifier_log::scenario::Options;

#[test]
fn a_log_is_taken_with_the_scenario_that_identify_saves() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../host-sim/logs/simulated-servo.csv.gz");
    let table = Table::read(&path).expect("a table");
    let recognised = recognise(&table, &LogOptions::default()).expect("a log");
    let text = recognised.scenario("log");
    let mut read = Options::parse("log.toml", &text).expect("allowed");
    let own = recognised.options().expect("allowed");
    // A text has the defaults of what it does not state and no fit needs.
    read.stated.identifier.initial = own.stated.identifier.initial;

    assert_eq!(own, read, "{text}");
}
