//! The mode of a second mass in the sampled response, exact.
//!
//! The pole is s = −ζω + jω√(1 − ζ²). The mode is Re{r/(s′ − s)}, with r = −jβ over the imaginary part of s where nothing else
//! damps it. A command is held for a sample and delayed by a part φ of it. The newer command adds n₁ = (e^(s(1 − φ)T) −
//! 1)/s, the one before it n₀ = e^(s(1 − φ)T) (e^(sφT) − 1)/s. Together this is Re{r (n₁ z + n₀)/(z − p)}, p = e^(sT), as a
//! fraction with real coefficients.

use super::resonance::Mode;
use crate::number::{Complex, Number};

/// The mode per acceleration b u, over T², without its whole samples of delay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SampledMode<N = f64> {
    /// Coefficients of z², z and 1.
    numerator: [N; 3],
    /// p − 1; the denominator is (z − p)(z − p*), and z − p is δ − (p − 1), which keeps its digits near one.
    offset: Complex<N>,
}

impl SampledMode {
    /// For a delay by a part of a sample.
    pub(super) fn new(mode: &Mode, part: f64, sample_time: f64) -> Self {
        let pole = mode.pole();
        let residue = Complex::new(0.0, -mode.ratio / pole.im);
        Self::of(pole, residue, part, sample_time)
    }

    /// Of a pole, rad/s, and r, s.
    pub(super) fn of(pole: Complex, residue: Complex, part: f64, sample_time: f64) -> Self {
        // In units of a sample.
        let s = pole.scaled(sample_time);
        let residue = residue.scaled(1.0 / sample_time);
        let grown = |time: f64| s.scaled(time).exponential();
        let (later, pole) = (grown(1.0 - part), grown(1.0));
        let newer = (later - Complex::ONE) / s;
        let older = (pole - later) / s;
        let conjugate = pole.conjugate();
        Self {
            numerator: [
                (residue * newer).re,
                (residue * (older - newer * conjugate)).re,
                -(residue * older * conjugate).re,
            ],
            offset: pole - Complex::ONE,
        }
    }

    /// In single precision.
    pub(super) fn single(&self) -> SampledMode<f32> {
        SampledMode {
            numerator: self.numerator.map(Number::from_f64),
            offset: self.offset.to(),
        }
    }

    /// Where its resonance appears in the samples and how wide it is there: ν = tan(ωT/2).
    pub(super) fn resonance(&self) -> (f64, f64) {
        /// That of an angle of 3.1.
        const HIGHEST: f64 = 48.0;
        // The tangent of half of an angle is its sine over one more than its cosine.
        let pole = self.offset + 1.0;
        let size = libm::sqrt(pole.power());
        let nu = (libm::fabs(pole.im) / (size + pole.re)).min(HIGHEST);
        let decay = -0.5 * libm::log(pole.power());
        (nu, 0.5 * decay * (1.0 + nu * nu))
    }
}

impl<N: Number> SampledMode<N> {
    /// At a z = 1 + δ of the unit circle.
    pub(super) fn at(&self, delta: Complex<N>) -> Complex<N> {
        let [two, one, zero] = self.numerator;
        let z = delta + N::ONE;
        let numerator = (z.scaled(two) + one) * z + zero;
        numerator / ((delta - self.offset) * (delta - self.offset.conjugate()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// The sum over the images of the held command (Poisson), which the sampled response is.
    fn images(mode: &Mode, delay: f64, frequency: f64, time: f64) -> Complex {
        let j = Complex { re: 0.0, im: 1.0 };
        let exponential = |angle: f64| j.scaled(angle).exponential();
        let mut sum = j.scaled(0.0);
        for image in -300..=300 {
            let at = frequency + f64::from(image) * TAU / time;
            let s = j.scaled(at);
            let denominator = s * s
                + s.scaled(2.0 * mode.damping * mode.frequency)
                + mode.frequency * mode.frequency;
            let held = exponential(-at * delay).scaled(mode.ratio) / (denominator * s);
            sum = sum + held;
        }
        (Complex::ONE - exponential(-frequency * time)) * sum.scaled(1.0 / time)
    }

    #[test]
    fn it_is_the_sum_over_the_images_below_and_beyond_half_of_the_sampling_frequency() {
        let time = 1e-3;
        for (hertz, part) in [(40.0, 0.0), (180.0, 0.3), (430.0, 0.8), (720.0, 0.5)] {
            let mode = Mode {
                frequency: TAU * hertz,
                damping: 0.02,
                ratio: 1.7,
            };
            let sampled = SampledMode::new(&mode, part, time);
            for at in [10.0, 35.0, 170.0, 310.0, 480.0] {
                let im = TAU * at * time;
                let z = Complex { re: 0.0, im }.exponential();
                let own = sampled.at(z - Complex::ONE).scaled(time * time) / z;
                let exact = images(&mode, part * time, TAU * at, time);
                let off = libm::sqrt((own - exact).power() / exact.power());
                assert!(off < 1e-4, "{hertz} Hz at {at} Hz: {off}");
            }
        }
    }

    #[test]
    fn its_peak_lies_where_it_says() {
        let mode = Mode {
            frequency: TAU * 600.0,
            damping: 0.01,
            ratio: 1.0,
        };
        // 600 Hz sampled at 1 kHz appear at 400 Hz.
        let (nu, width) = SampledMode::new(&mode, 0.0, 1e-3).resonance();
        let expected = libm::tan(0.5 * TAU * 0.4);
        assert!((nu / expected - 1.0).abs() < 1e-3, "{nu} {expected}");
        assert!((width / (0.5 * 0.01 * TAU * 0.6 * (1.0 + nu * nu)) - 1.0).abs() < 1e-6);
    }
}
