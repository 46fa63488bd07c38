use crate::number::Number;

/// The autocorrelation of errors from one to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Autocorrelation<N> {
    /// The last error.
    last: N,
    /// Sum of the products of successive errors.
    pub(crate) products: N,
}

impl<N: Number> Autocorrelation<N> {
    /// Takes in an error.
    #[inline]
    pub(crate) fn add(&mut self, error: N) {
        self.products += error * self.last;
        self.last = error;
    }
}

/// The variance of white errors with the same information as autocorrelated errors of this variance. `products` is the
/// sum of products of successive errors, `squares` that of their squares. An autocorrelation ρᵏ reduces the information
/// by (1 + ρ)/(1 − ρ). It is limited to `largest`: beyond that it cannot be distinguished from one.
pub(crate) fn autocorrelated<N: Number>(variance: N, products: N, squares: N, largest: f64) -> N {
    let correlation = if squares > N::ZERO {
        (products * squares.reciprocal()).limited(N::ZERO, N::from_f64(largest))
    } else {
        N::ZERO
    };
    variance * (N::ONE + correlation) * (N::ONE - correlation).reciprocal()
}

#[cfg(test)]
mod tests {
    use super::{Autocorrelation, autocorrelated};

    #[test]
    fn correlated_errors_say_less_and_no_more_than_white_ones() {
        let of = |errors: &[f64]| {
            let mut autocorrelation = Autocorrelation::default();
            let mut squares = 0.0;
            for &error in errors {
                autocorrelation.add(error);
                squares += error * error;
            }
            autocorrelated(2.0, autocorrelation.products, squares, 0.9)
        };
        let half = [1.0, 0.5, 0.25, 0.125, 0.0625];
        assert!((of(&half) / 6.0 - 1.0).abs() < 0.01, "{}", of(&half));
        assert!((of(&[1.0, -1.0, 1.0]) - 2.0).abs() < 1e-9);
        assert!((of(&[1.0; 100]) / 38.0 - 1.0).abs() < 1e-9);
        assert!((of(&[0.0; 3]) - 2.0).abs() < 1e-9);
    }
}
