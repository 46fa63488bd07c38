//! What only the logs know of the settings.

use identifier_core::Settings;

use super::settling::settling;
use crate::log::Log;
use crate::scenario::Options;

/// The default time of the core's first fits, and the shortest that it takes, s.
const DEFAULT_START_TIME: f64 = 1.0;
const MIN_START_TIME: f64 = 1e-4;

impl Options {
    /// These options completed from the logs. They give the sample time if no controller is declared, and the resolution
    /// of the position if no encoder is. They also give the time window of a first fit if the longest segment is shorter
    /// than usual. A simulated run's `own` log adds nothing but the last. The first log counts where they differ.
    #[must_use]
    pub fn fitted(mut self, logs: &[Log], own: bool) -> Self {
        let Some(log) = logs.first() else {
            return self;
        };
        self.sample_every(log.sample_time);
        if self.counts_per_rev.is_none() && !own {
            self.stated.resolution = log.resolution();
        }
        let segments = logs.iter().flat_map(Log::segments);
        let learnt = segments.map(|segment| segment.samples - settling(&self, segment));
        let most = learnt.max().unwrap_or(0) as f64 * self.sample_time();
        if (MIN_START_TIME..DEFAULT_START_TIME).contains(&most) {
            self.stated.identifier.start_time.get_or_insert(most);
        }
        self
    }

    /// Takes the sample time of a log, s, where no controller declares one.
    pub fn sample_every(&mut self, sample_time: f64) {
        if self.stated.controller.is_none() {
            // The cut-off that follows from a sample time; the resolution is not that of these counts.
            let of_log = Settings::new(sample_time, 1.0);
            self.stated.sample_time = of_log.sample_time;
            self.stated.cutoff = of_log.cutoff;
        }
    }
}
