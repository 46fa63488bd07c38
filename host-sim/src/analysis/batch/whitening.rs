//! Whitening by an autoregression of second order, fitted to what is left of the output error.

use super::least_squares::dot;

/// e_k − f₁ e_{k−1} − f₂ e_{k−2}.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Whitening {
    coefficients: [f64; 2],
}

impl Whitening {
    /// Fitted to values by Yule's and Walker's equations; always stable.
    pub(super) fn new(values: &[f64]) -> Self {
        /// A part of the variance that is taken for white, so that what is hardly noise at all does
        /// not make the equations singular.
        const WHITE_SHARE: f64 = 1e-6;
        let lagged = |lag: usize| dot(values, &values[lag.min(values.len())..]);
        let (whole, first, second) = (lagged(0) * (1.0 + WHITE_SHARE), lagged(1), lagged(2));
        let determinant = whole * whole - first * first;
        if determinant.is_nan() || determinant <= 0.0 {
            return Self {
                coefficients: [0.0; 2],
            };
        }
        Self {
            coefficients: [
                first * (whole - second) / determinant,
                (whole * second - first * first) / determinant,
            ],
        }
    }

    /// Values whitened; the first two, of which too little is known, are left out.
    pub(super) fn apply(&self, values: &[f64]) -> Vec<f64> {
        let [first, second] = self.coefficients;
        values
            .windows(3)
            .map(|window| window[2] - first * window[1] - second * window[0])
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use virtual_servo::excitation::NormalSource;

    use super::*;

    #[test]
    fn the_series_it_was_fitted_to_becomes_white() {
        let mut source = NormalSource::new(1);
        let (mut last, mut before) = (0.0, 0.0);
        let coloured: Vec<f64> = (0..20_000)
            .map(|_| {
                let next = 1.2 * last - 0.5 * before + source.next_uniform() - 0.5;
                (before, last) = (last, next);
                next
            })
            .collect();
        let whitening = Whitening::new(&coloured);
        let white = whitening.apply(&coloured);
        let correlation = |values: &[f64]| dot(values, &values[1..]) / dot(values, values);
        assert!(correlation(&coloured) > 0.7);
        assert!(correlation(&white).abs() < 0.02, "{whitening:?}");
    }
}
