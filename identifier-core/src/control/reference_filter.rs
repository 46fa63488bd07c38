use crate::constants::{Encode, encode};
use crate::error::{Allowed, OutOfRange};
use crate::number::Arithmetic;
use crate::units::Units;

/// First-order filter of the reference, F(s) = 1/(1 + s T_r), its pole mapped exactly: E = e^(−T/T_r).
///
/// The filtered reference y follows the reference r, held over a sample, by y ← r − E (r − y). The filter uses only
/// distances from the position q. It takes the error r − q to y − q:
///
/// y − q ← (r − q) − E ((r − q) − ((y − q)_before − (q − q_before)))
///
/// so it is as exact at any count and through its wrap as the error is. No rounding adds up. The error of y is at most
/// the last bit of the error r − q over 1 − E. When the loop has moved the servo to y, y is r. Without a filter E is
/// zero, and y is r to the last bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceFilter<N> {
    pole: N,
}

encode! {
    [N: Encode] ReferenceFilter<N> as "ReferenceFilter" { pole }
}

/// State of a [`ReferenceFilter`]: the filtered reference less the position in the last sample, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FilteredError<N>(pub(crate) N);

impl<N: Arithmetic> ReferenceFilter<N> {
    /// No filter.
    pub const NONE: Self = Self { pole: N::ZERO };

    /// The longest time constant, sample times. Single precision keeps it to 0.3 %, because 1 − E = 10⁻⁵ has an error
    /// of half of 2⁻²⁴.
    pub const MAX_SAMPLES: f64 = 1e5;

    /// A filter with a time constant T_r, s, from 0 (none) to [`ReferenceFilter::MAX_SAMPLES`] sample times.
    ///
    /// # Errors
    /// `reference_filter` out of its range.
    pub fn new(units: &Units, time_constant: f64) -> Result<Self, OutOfRange> {
        let sample_time = units.sample_time();
        let longest = Self::MAX_SAMPLES * sample_time;
        Allowed::Within(0.0, longest).check("reference_filter", time_constant)?;
        // e^(−∞) is zero.
        Ok(Self {
            pole: N::signal(libm::exp(-sample_time / time_constant.abs()), 0),
        })
    }

    /// True if there is one.
    pub(crate) fn is_there(&self) -> bool {
        self.pole != N::ZERO
    }

    /// Takes the error r − q of a sample and the increment of q since the last one. Returns y − q. All are of one full
    /// scale, in machine units.
    #[inline]
    pub(crate) fn process(&self, state: &mut FilteredError<N>, error: N, increment: N) -> N {
        let unmoved = (state.0 - increment).saturated();
        // In fixed point towards zero, to end at the reference.
        state.0 = error - (error - unmoved).decayed(self.pole);
        state.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Setpoint;
    use crate::number::Number;
    use proptest::prelude::*;

    /// Sample times of 250 Hz, 1, 4 and 20 kHz.
    const SAMPLE_TIMES: [f64; 4] = [4e-3, 1e-3, 250e-6, 50e-6];

    fn filter<N: Number>(sample_time: f64, time_constant: f64) -> ReferenceFilter<N> {
        let units = Units::new(sample_time, 1e-3).expect("valid");
        ReferenceFilter::new(&units, time_constant).expect("valid")
    }

    #[test]
    fn a_step_is_followed_as_in_continuous_time_at_any_sample_rate() {
        const TIME_CONSTANT: f64 = 0.03;
        const STEP: f64 = 5000.0;
        for sample_time in SAMPLE_TIMES {
            let exact = filter::<f64>(sample_time, TIME_CONSTANT);
            let single = filter::<f32>(sample_time, TIME_CONSTANT);
            let (mut state, mut single_state) = (FilteredError(0.0), FilteredError(0.0));
            for k in 1..=(0.2 / sample_time) as u32 {
                let time = f64::from(k) * sample_time;
                let expected = -STEP * (-time / TIME_CONSTANT).exp_m1();
                let off = exact.process(&mut state, STEP, 0.0) - expected;
                assert!(off.abs() < 1e-8 * STEP, "{sample_time} {time}");
                let found = f64::from(single.process(&mut single_state, STEP as f32, 0.0));
                let off = found - expected;
                assert!(off.abs() < 1e-4 * STEP, "{sample_time} {time}: {off}");
            }
        }
    }

    #[test]
    fn a_time_constant_out_of_range_is_refused_by_name() {
        let units = Units::new(1e-3, 1e-3).expect("valid");
        for refused in [-1e-3, f64::NAN, f64::INFINITY, 100.1] {
            let error = ReferenceFilter::<f32>::new(&units, refused).expect_err("refused");
            assert_eq!(error.parameter, "reference_filter");
        }
        assert!(ReferenceFilter::<f32>::new(&units, 100.0).is_ok());
        assert_eq!(filter::<f32>(1e-3, 0.0), ReferenceFilter::NONE);
    }

    proptest! {
        /// The servo moves and its counter wraps meanwhile. Then the reference is constant, and the filter has
        /// settled.
        #[test]
        fn the_filtered_reference_is_that_of_exact_arithmetic_and_ends_at_the_reference(
            start: i32,
            moves in prop::collection::vec((-300_i32..300, -200_i32..200), 1..400),
            rate in 0_usize..4,
            time_constant in 1e-3_f64..0.1,
        ) {
            let sample_time = SAMPLE_TIMES[rate];
            let filter = filter::<f32>(sample_time, time_constant);
            let pole = (-sample_time / time_constant).exp();
            let mut state = FilteredError(0.0);
            // From the last position of the servo.
            let (mut position, mut reference, mut exact) = (0_i64, 0_i64, 0.0);
            let mut follow = |position: i64, moved: i64, reference: i64, exact: &mut f64| {
                let at = |counts: i64| start.wrapping_add(counts as i32);
                let setpoint = Setpoint { count: at(reference), offset: 0.25_f32 };
                let goal = reference as f64 + 0.25;
                *exact = goal - pole * (goal - *exact);
                let error = setpoint.error(at(position));
                f64::from(filter.process(&mut state, error, moved as f32)) + position as f64
            };
            for (moved, led) in moves {
                position += i64::from(moved);
                reference += i64::from(led);
                let found = follow(position, i64::from(moved), reference, &mut exact);
                // Half of the last bit of the largest error in each of the samples that the filter remembers.
                let remembered = (time_constant / sample_time).min(400.0);
                let tolerance = 2e-7 * 2e5 * (1.0 + remembered.sqrt());
                prop_assert!((found - exact).abs() < tolerance, "{found} {exact}");
            }
            let mut found = 0.0;
            for _ in 0..(30.0 * time_constant / sample_time) as u32 + 2 {
                found = follow(position, 0, reference, &mut exact);
            }
            let error = (reference - position) as f64 + 0.25;
            let left = found - (reference as f64 + 0.25);
            // What a step is that rounding to single precision takes for none.
            let last_bit = f64::from(f32::EPSILON) * error.abs();
            prop_assert!(left.abs() <= 1.01 * last_bit / (1.0 - pole), "{left} of {error}");
        }
    }
}
