//! Identification of a drawn log as a user does it: from a file with time, position and command.

use std::fmt::Write as _;
use std::path::PathBuf;

use host_sim::scenario::{Purpose, Scenario};
use identifier_log::log::Log;
use identifier_log::result::Summary;
use integration_tests::logs::RecordedLog;

/// Settings of an identification that are compared.
#[derive(Clone, Copy)]
pub(super) struct Settings {
    pub(super) name: &'static str,
    /// The lines of `[identifier]` for a log.
    identifier: fn(&RecordedLog) -> String,
}

/// The four parameters.
pub(super) const FOUR: Settings = Settings {
    name: "four parameters",
    identifier: |_| super::super::campaign::ALL_FOUR.to_owned(),
};

/// One fit to the whole record.
pub(super) const FIT: Settings = Settings {
    name: "one fit to the whole record",
    identifier: |_| "law = \"fit\"".to_owned(),
};

/// A log as a file, deleted with the value.
pub(in crate::verdict) struct LogFile(PathBuf);

impl LogFile {
    /// Writes the text of a log.
    pub(in crate::verdict) fn of(text: impl AsRef<[u8]>) -> Self {
        // Tests run at the same time, and so do their threads.
        let thread = std::thread::current().id();
        let name = format!("drawn-{}-{thread:?}.csv", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::write(&path, text).expect("the log can be written");
        Self(path)
    }

    /// Writes a drawn log.
    pub(super) fn write(log: &RecordedLog) -> Self {
        let mut text = String::from("time_s,position_rad,command\n");
        for (sample, command) in log.commands.iter().enumerate() {
            let time = sample as f64 * log.setup.sample_time;
            let position = log.position(sample);
            writeln!(text, "{time},{position},{command}").expect("a String takes all");
        }
        Self::of(text)
    }

    /// Replays a drawn log.
    ///
    /// # Errors
    /// The refusal of the log or the scenario.
    pub(super) fn identify(
        &self,
        log: &RecordedLog,
        settings: Settings,
    ) -> Result<Summary, String> {
        let text = format!(
            "[encoder]\ncounts_per_rev = {:?}\n[identifier]\n{}\n\
             [log]\ntime = \"time_s\"\nposition = \"position_rad\"\ncommand = \"command\"\nangle = \"absolute\"\n",
            log.setup.counts_per_rev,
            (settings.identifier)(log)
        );
        let scenario = Scenario::parse("drawn", &text, Purpose::Replay).expect("valid settings");
        self.replayed(scenario)
    }

    /// Replays the log by a scenario.
    ///
    /// # Errors
    /// The refusal of the log.
    pub(in crate::verdict) fn replayed(&self, scenario: Scenario) -> Result<Summary, String> {
        let log = Log::read(&self.0, &scenario.log_columns(), scenario.log_sample_time())
            .map_err(|error| error.to_string())?;
        let found = host_sim::identify_logs(scenario, &[log], &[], 1, &|| true, &mut |_, _| {});
        Ok(found.map_err(|error| error.to_string())?.summary)
    }
}

impl Drop for LogFile {
    fn drop(&mut self) {
        // A file that is left in a directory for temporary files does no harm.
        let _ = std::fs::remove_file(&self.0);
    }
}
