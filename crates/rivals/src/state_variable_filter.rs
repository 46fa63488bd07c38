use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::number::Number;
use identifier_core::units::Units;

/// λ²/(s + λ)², stepped exactly for a held input, with its rate.
///
/// Dividing a differential equation by Λ(s) = (s + λ)²/λ² leaves signals that follow from the measured ones (Sastry and
/// Bodson, Adaptive Control: Stability, Convergence and Robustness, 1989, section 2.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateVariableFilter<N> {
    transition: [[N; 2]; 2],
    input: [N; 2],
}

/// The state of a [`StateVariableFilter`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filtered<N> {
    /// The filtered signal.
    pub value: N,
    /// Its rate, per sample.
    pub rate: N,
}

impl<N: Number> Filtered<N> {
    /// Nothing has happened yet.
    pub const AT_REST: Self = Self {
        value: N::ZERO,
        rate: N::ZERO,
    };
}

impl<N: Number> StateVariableFilter<N> {
    /// The filter with a cut-off λ, rad/s.
    ///
    /// # Errors
    /// `cutoff` must be above zero and below the Nyquist frequency π/T.
    pub fn new(units: &Units, cutoff: f64) -> Result<Self, OutOfRange> {
        let nyquist = core::f64::consts::PI / units.sample_time();
        let l = Allowed::Between(0.0, nyquist).check("cutoff", cutoff)? * units.rate();
        let decay = libm::exp(-l);
        let number = N::from_f64;
        Ok(Self {
            transition: [
                [number(decay * (1.0 + l)), number(decay)],
                [number(-decay * l * l), number(decay * (1.0 - l))],
            ],
            input: [number(1.0 - decay * (1.0 + l)), number(decay * l * l)],
        })
    }

    /// One sample with an input that was held over it.
    #[inline]
    pub fn process(&self, state: &mut Filtered<N>, input: N) {
        let [[vv, vr], [rv, rr]] = self.transition;
        let [iv, ir] = self.input;
        let Filtered { value, rate } = *state;
        state.value = vv * value + vr * rate + iv * input;
        state.rate = rv * value + rr * rate + ir * input;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filter_steps_like_the_continuous_one() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        let filter = StateVariableFilter::<f64>::new(&units, 80.0).expect("valid");
        let mut state = Filtered::AT_REST;
        for k in 1..=200 {
            filter.process(&mut state, 1.0);
            let lt = 80.0 * 1e-3 * f64::from(k);
            let value = 1.0 - libm::exp(-lt) * (1.0 + lt);
            let rate = 80.0 * 1e-3 * lt * libm::exp(-lt);
            assert!((state.value - value).abs() < 1e-12, "sample {k}");
            assert!((state.rate - rate).abs() < 1e-12, "sample {k}");
        }
    }
}
