/// Mean and standard deviation of a stream. Literature: Welford, "Note on a method for calculating corrected sums of
/// squares and products", Technometrics 4(3), 1962.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Statistics {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Statistics {
    /// Takes in a value.
    #[inline]
    pub fn add(&mut self, value: f64) {
        self.count += 1.0;
        let before = value - self.mean;
        self.mean += before / self.count;
        self.squares += before * (value - self.mean);
    }

    /// The mean; none before the first value.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0.0).then_some(self.mean)
    }

    /// The standard deviation; none before the first value.
    #[must_use]
    pub fn deviation(&self) -> Option<f64> {
        (self.count > 0.0).then(|| (self.squares / self.count).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::Statistics;

    #[test]
    fn small_spread_on_a_large_mean_is_kept() {
        let mut statistics = Statistics::default();
        for k in 0..1000 {
            statistics.add(1e9 + f64::from(k % 2));
        }
        assert!((statistics.mean().expect("values") - (1e9 + 0.5)).abs() < 1e-6);
        assert!((statistics.deviation().expect("values") - 0.5).abs() < 1e-9);
        assert_eq!(Statistics::default().mean(), None);
    }
}
