//! Logs of any bytes: read or refused with a sentence that names the file; a log that is read has finite rows.

#![no_main]

use std::io::Cursor;
use std::path::Path;

use identifier_log::log::{Log, Table};
use identifier_log::recognise::{LogOptions, recognise};
use identifier_log::scenario::{Column, LogSettings};
use libfuzzer_sys::fuzz_target;

const NAME: &str = "fuzzed.csv";

fn settings() -> LogSettings {
    let mut settings = LogSettings::with_position(Column::Number(1));
    settings.command = Some(Column::Number(2));
    settings
}

fuzz_target!(|bytes: &[u8]| {
    let table = match Table::of_text(Path::new(NAME), Cursor::new(bytes.to_vec())) {
        Ok(table) => table,
        Err(error) => return assert!(error.to_string().contains(NAME), "{error}"),
    };
    match Log::new(&table, &settings(), Some(1e-3)) {
        Ok(log) => {
            for row in log.rows() {
                assert!(row.position.is_finite() && row.time.is_finite(), "{row:?}");
            }
        }
        Err(error) => assert!(error.to_string().contains(NAME), "{error}"),
    }
    let _ = recognise(&table, &LogOptions::default());
});
