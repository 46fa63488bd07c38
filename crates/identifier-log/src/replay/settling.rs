//! Samples in which the velocity estimate settles.

use crate::log::Segment;
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
