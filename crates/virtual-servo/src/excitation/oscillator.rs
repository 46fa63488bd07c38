use identifier_core::number::Number;

/// A turn cut into 2⁶⁴ parts: phases add without rounding and wrap by themselves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Phase(pub(super) u64);

impl Phase {
    /// A fraction of a turn, 0 to 1.
    pub(super) fn from_turns(turns: f64) -> Self {
        /// 2⁶⁴.
        const PARTS: f64 = 18_446_744_073_709_551_616.0;
        Self((turns * PARTS) as u64)
    }

    #[inline]
    pub(super) fn advance(&mut self, by: Self) {
        self.0 = self.0.wrapping_add(by.0);
    }

    /// sin(2π phase).
    ///
    /// The phase is folded onto a quarter wave, where the Taylor series to the 13th power is within 10⁻⁹ of the sine.
    /// It is a shape, not a measurement, with the same bits everywhere.
    #[inline]
    pub(super) fn sine<N: Number>(self, series: &SineSeries<N>) -> N {
        let turn = (self.0 >> 32) as i32;
        let half_turns = N::from_count(turn) * series.per_count;
        let folded = if half_turns > series.half {
            N::ONE - half_turns
        } else if half_turns < -series.half {
            -N::ONE - half_turns
        } else {
            half_turns
        };
        let square = folded * folded;
        let [head @ .., last] = series.coefficients;
        head.iter().rev().fold(last, |sum, &c| sum * square + c) * folded
    }
}

/// The coefficients of sin(πx)/x in powers of x².
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SineSeries<N> {
    coefficients: [N; 7],
    half: N,
    per_count: N,
}

impl<N: Number> SineSeries<N> {
    pub(super) fn new() -> Self {
        let square = core::f64::consts::PI * core::f64::consts::PI;
        let mut term = core::f64::consts::PI;
        Self {
            coefficients: core::array::from_fn(|k| {
                let coefficient = term;
                let next = (2 * k + 2) as f64;
                term *= -square / (next * (next + 1.0));
                N::from_f64(coefficient)
            }),
            half: N::from_f64(0.5),
            per_count: N::from_f64(1.0 / 2_147_483_648.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sine_is_a_sine(turns in 0.0_f64..1.0) {
            let exact = libm::sin(core::f64::consts::TAU * turns);
            let phase = Phase::from_turns(turns);
            prop_assert!((phase.sine(&SineSeries::<f64>::new()) - exact).abs() < 5e-9);
            let single = f64::from(phase.sine(&SineSeries::<f32>::new()));
            prop_assert!((single - exact).abs() < 1e-6);
        }
    }
}
