//! A recognised log is identified with the options that its saved scenario states.

use std::path::Path;

use identifier_log::log::Table;
use identifier_log::recognise::{LogOptions, recognise};
use identifier_log::scenario::Options;

fn table() -> Table {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    Table::read(&folder.join("../../host-sim/logs/simulated-servo.csv.gz")).expect("a table")
}

#[test]
fn a_log_is_taken_with_the_scenario_that_identify_saves() {
    let recognised = recognise(&table(), &LogOptions::default()).expect("a log");
    let text = recognised.scenario("log");
    let mut read = Options::parse("log.toml", &text).expect("allowed");
    let own = recognised.options().expect("allowed");
    // A text has the defaults of what it does not state and no fit needs.
    read.stated.identifier.initial = own.stated.identifier.initial;
    // Nor has it the evidence.
    read.reading.clone_from(&own.reading);

    assert_eq!(own, read, "{text}");
}

/// Every kind of value, in tables that a log may do without and in tables within tables.
#[test]
fn what_a_text_states_is_written_again() {
    for text in [
        "[encoder]\ncounts_per_rev = 4096\n[amplifier]\nlimit = [-2.0, 3.0]\ndelay = 0.001\n[controller]\nkd = 0.25\n\
         feed_forward = { bandwidth = 60.0, acceleration = 0.005 }\nvelocity_filter = { kind = \"averaged-difference\" }\n\
         [identifier]\nparameters = [\"b\", \"a\", \"coulomb\"]\ngamma = [3000.0, 20.0, 7.0]\nservo_range = { a = [0.0, 50.0], b = [110.0, 1000.0] }\n[log]\ntime = 1\ntime_unit = \"ms\"\n\
         reference = \"q \\\"r\\\"\"\nreference_unit = \"deg\"\nposition = 3\ncommand = \"u\"\nbridge_gaps = 4\n",
        "[identifier]\nlaw = \"gauss-newton\"\nrequired_terms = [\"gravity\", \"delay\"]\ninitial = { b = 70.0 }\n[physical]\n\
         torque_constant = 0.5\n[log]\ntime = \"t\"\nposition = \"q\"\nangle = \"absolute\"\ncommand = \"u\"\n\
         known_torque = \"g\"\nposition_unit = \"turns\"\ncut = [[1.0, 2.0], [3.0, 4.5]]\nwrap = 1.0\n",
        "[identifier]\nlaw = \"fit\"\n[inner]\nkp = 40.0\nlimit = 5.0\nintegrator = \"euler\"\n[log]\nsample_time = 0.004\n\
         reference = \"goal\"\nposition = \"v\"\nmeasured = \"velocity\"\n",
        // A controller with the default of each of its keys is not the same as none.
        "[identifier]\nlaw = \"gauss-newton\"\n[controller]\n[log]\ntime = \"t\"\nposition = \"q\"\ncommand = \"u\"\n",
    ] {
        let read = Options::parse("log.toml", text).unwrap_or_else(|error| panic!("{error}"));
        let written = read.text();
        let again = Options::parse("again.toml", &written);
        let again = again.unwrap_or_else(|error| panic!("{error}\n{written}"));
        assert_eq!(read, again, "{written}");
    }
}

/// A number that is stated beside a log has the range that its key has in a text.
#[test]
fn a_number_beyond_the_range_of_its_key_is_refused() {
    for key in [
        "physical.torque_constant",
        "physical.inertia",
        "encoder.counts_per_rev",
    ] {
        let with = |value| {
            let mut options = Options::blank();
            let stated = match key {
                "physical.inertia" => &mut options.physical.inertia,
                "physical.torque_constant" => &mut options.physical.torque_constant,
                _ => &mut options.counts_per_rev,
            };
            *stated = Some(value);
            options.in_range()
        };
        for value in [-1.0, f64::NAN, f64::INFINITY] {
            let refused = with(value).expect_err(key);
            assert!(refused.to_string().contains(key), "{refused}");
        }
        assert!(with(2.0).is_ok(), "{key}");
    }
}

/// The page reads no table of keys: what would end in nonsense or a panic is refused by the options themselves.
#[test]
fn counts_and_limits_that_are_none_are_refused_by_every_door() {
    let table = table();
    for value in [-3.0, f64::NAN] {
        let counts = LogOptions {
            counts_per_rev: Some(value),
            ..LogOptions::default()
        };
        let limit = LogOptions {
            goal: Some("reference_rad".to_owned()),
            kp: Some(1.0),
            limit: Some(value),
            ..LogOptions::default()
        };
        for (key, stated) in [("encoder.counts_per_rev", counts), ("inner.limit", limit)] {
            let recognised = recognise(&table, &stated).expect("a log");
            let refused = recognised.options().expect_err(key);
            assert!(refused.to_string().contains(key), "{refused}");
        }
    }
}
