/// An incremental encoder read at the sample: the count of the last edge passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoder {
    counts_per_rad: f64,
}

impl Encoder {
    /// An encoder, by its counts per revolution (of 2π rad).
    #[must_use]
    pub fn new(counts_per_rev: f64) -> Self {
        Self {
            counts_per_rad: counts_per_rev / core::f64::consts::TAU,
        }
    }

    /// The count at a position (rad): ⌊q/resolution⌋.
    #[inline]
    #[must_use]
    pub fn read(&self, position: f64) -> i64 {
        let exact = position * self.counts_per_rad;
        // A cast and a correction: `f64::floor` is a library call on the x86-64 baseline.
        let toward_zero = exact as i64;
        toward_zero - i64::from(exact < toward_zero as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::Encoder;

    #[test]
    fn counts_edges_on_both_sides_of_zero() {
        let encoder = Encoder::new(10_000.0);
        let resolution = core::f64::consts::TAU / 10_000.0;
        for k in -5_i32..=5 {
            let edge = f64::from(k) * resolution;
            assert_eq!(encoder.read(edge + 0.01 * resolution), i64::from(k));
            assert_eq!(encoder.read(edge + 0.99 * resolution), i64::from(k));
        }
        let far = 1e6 * core::f64::consts::TAU + 0.5 * resolution;
        assert_eq!(encoder.read(far), 10_000_000_000);
    }
}
