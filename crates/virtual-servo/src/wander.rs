//! A wandering load.

use crate::excitation::NormalSource;

use crate::noise::{Stream, source};

/// A first-order Gauss–Markov process, exact from sample to sample and held in between. From its first value on it has
/// the same standard deviation, and its correlation falls as e^(−t/τ).
#[derive(Debug, Clone)]
pub(crate) struct Wander {
    kept: f64,
    fresh: f64,
    source: NormalSource,
    load: f64,
}

impl Wander {
    /// With a standard deviation (rad/s²) and a time constant (s).
    pub(crate) fn new([deviation, time]: [f64; 2], sample_time: f64, seed: u32) -> Self {
        let step = sample_time / time;
        let mut source = source(seed, Stream::LoadWander);
        Self {
            kept: libm::exp(-step),
            fresh: deviation * libm::sqrt(-libm::expm1(-2.0 * step)),
            load: deviation * source.next_normal(),
            source,
        }
    }

    /// The load of the next sample, rad/s².
    pub(crate) fn next(&mut self) -> f64 {
        let load = self.load;
        self.load = self.kept * load + self.fresh * self.source.next_normal();
        load
    }
}

#[cfg(test)]
mod tests {
    use super::Wander;

    #[test]
    fn has_its_standard_deviation_and_its_time_constant() {
        let (mut square, mut product) = (0.0, 0.0);
        let (samples, apart) = (400_000_u32, 100);
        let mut wander = Wander::new([3.0, 0.1], 1e-3, 7);
        let mut delayed = Wander::new([3.0, 0.1], 1e-3, 7);
        for _ in 0..apart {
            wander.next();
        }
        for _ in 0..samples {
            let (now, before) = (wander.next(), delayed.next());
            square += now * now / f64::from(samples);
            product += now * before / f64::from(samples);
        }
        // 400 s are 2000 independent values: the variance is known to 3 %.
        assert!((square / 9.0 - 1.0).abs() < 0.1, "variance {square}");
        let correlation = product / square;
        let off = correlation - libm::exp(-1.0);
        assert!(off.abs() < 0.06, "{correlation}");
    }
}
