use identifier_core::units::Units;

/// The samples that a time (s) takes, rounded up; one at least.
pub(crate) fn samples(time: f64, units: &Units) -> u32 {
    /// Rounding of a division of two times.
    const WHOLE_TOLERANCE: f64 = 1e-6;
    let samples = time / units.sample_time() - WHOLE_TOLERANCE;
    // A cast saturates.
    (samples as u32).saturating_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_never_cut_short() {
        for (sample_time, time, wanted) in [
            (1e-3, 5e-3, 5),
            (1e-3, 5.1e-3, 6),
            (5e-5, 2e-3, 40),
            (1e-3, 1e-9, 1),
            (1e-3, 0.1, 100),
            (5e-5, 1e9, u32::MAX),
        ] {
            let units = Units::new(sample_time, 1e-3).expect("allowed");
            assert_eq!(samples(time, &units), wanted, "{time} s of {sample_time} s");
        }
    }
}
