use crate::scenario::{Scenario, Velocity};

/// Samples of a velocity estimate without a pole, and the first row, whose motion is unknown.
pub(super) const MIN_SETTLING: u64 = 3;

/// The samples in which the velocity estimate settles on a motion that it joins.
pub(super) fn settling_in_motion(scenario: &Scenario) -> u64 {
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
