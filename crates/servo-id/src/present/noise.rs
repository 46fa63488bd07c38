//! The noise of the position sensor in words.

use identifier_log::MotionUnit;
use identifier_log::result::SensorNoise;

use super::number::{figure, fixed};

/// The noise in motion and at standstill, standard deviations; none where neither is known.
pub(super) fn sensor_noise(noise: &SensorNoise, unit: MotionUnit) -> Option<String> {
    let parts = [
        (noise.moving_counts.zip(noise.moving), "in motion"),
        (
            noise.standstill_counts.zip(noise.standstill),
            "at standstill",
        ),
    ];
    let known = parts.into_iter().filter_map(|(noise, when)| {
        let (counts, size) = noise?;
        Some(format!(
            "{} counts ({} {}) {when}",
            fixed(counts, 2),
            figure(size),
            unit.name()
        ))
    });
    let known: Vec<String> = known.collect();
    (!known.is_empty()).then(|| known.join(", "))
}
