//! Logs of any bytes: read or refused with a sentence that names the file; a log that is read has finite rows.

#![no_main]

use std::path::Path;

use host_sim::log::{Log, hold};
use host_sim::recognise::{Stated, recognise};
use host_sim::scenario::{Column, LogSettings};
use libfuzzer_sys::fuzz_target;

const NAME: &str = "fuzzed.csv";

fn settings() -> LogSettings {
    let mut settings = LogSettings::with_position(Column::Number(1));
    settings.command = Some(Column::Number(2));
    settings
}

fuzz_target!(|bytes: &[u8]| {
    hold(bytes.to_vec());
    let path = Path::new(NAME);
    match Log::read(path, &settings(), Some(1e-3)) {
        Ok(log) => {
            for row in log.rows().expect("it has been read before") {
                let row = row.expect("it has been judged sound");
                assert!(row.position.is_finite() && row.time.is_finite(), "{row:?}");
            }
        }
        Err(error) => assert!(error.to_string().contains(NAME), "{error}"),
    }
    let _ = recognise(path, &Stated::default());
});
