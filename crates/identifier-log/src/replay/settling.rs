//! Samples in which the velocity estimate settles.

use identifier_core::Settings;

use crate::log::{Log, Segment};
use crate::scenario::{Options, Velocity};

/// Samples of a velocity estimate without a pole, and the first row, whose motion is unknown.
pub(super) const MIN_SETTLING: u64 = 3;

/// The samples in which the velocity estimate settles on a motion that it joins.
pub fn settling_in_motion(scenario: &Options) -> u64 {
    /// Time constants after which a low-pass has settled to 0.03 % of a step.
    const TIME_CONSTANTS: f64 = 8.0;
    let stated = &scenario.stated;
    match scenario.velocity {
        Velocity::LowPass => {
            MIN_SETTLING + (TIME_CONSTANTS / (stated.cutoff * stated.sample_time)) as u64
        }
        Velocity::Difference | Velocity::AveragedDifference => MIN_SETTLING,
    }
}

/// The samples of a segment without learning. There are none if the servo starts at standstill, because its motion is
/// then fully known. Otherwise they are those in which the velocity estimate settles.
pub(super) fn settling(scenario: &Options, segment: &Segment) -> u64 {
    /// At most this fraction of a segment, one over, is spent on settling.
    const SETTLING_DIVISOR: u64 = 10;
    if segment.begins_at_rest(scenario.stated.resolution) {
        return 0;
    }
    settling_in_motion(scenario)
        .min((segment.samples / SETTLING_DIVISOR).max(MIN_SETTLING))
        .min(segment.samples - 1)
}

/// The default time of the core's first fits, and the shortest that it takes, s.
const DEFAULT_START_TIME: f64 = 1.0;
const MIN_START_TIME: f64 = 1e-4;

impl Options {
    /// These options completed from the logs. They give the sample time if no controller is declared, and the resolution
    /// of the position if no encoder is. They also give the time window of a first fit if the longest segment is shorter
    /// than usual. A simulated run's `own` log adds nothing but the last. The first log's sample time counts.
    #[must_use]
    pub fn fitted(mut self, logs: &[Log], own: bool) -> Self {
        let Some(log) = logs.first() else {
            return self;
        };
        self.sample_every(log.sample_time);
        if self.counts_per_rev.is_none() && !own {
            self.stated.resolution = Log::resolution(logs);
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
