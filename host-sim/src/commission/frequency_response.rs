//! The frequency response that a commissioning has measured.

use std::f64::consts::TAU;

use identifier_core::number::Complex;
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::{MeasuredLine, Mode, Resonance};

/// Lines of a response from command to position, and the resonance that they show.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// By frequency.
    pub lines: Vec<MeasuredLine>,
    /// None of a servo of one mass.
    pub resonance: Option<Resonance>,
}

impl FrequencyResponse {
    /// From lines; none without any.
    #[must_use]
    pub fn new(lines: &[MeasuredLine], resonance: Option<&Resonance>) -> Option<Self> {
        (!lines.is_empty()).then(|| Self {
            lines: lines.to_vec(),
            resonance: resonance.copied(),
        })
    }

    /// The highest frequency that was looked at, rad/s.
    #[must_use]
    pub fn highest_frequency(&self) -> f64 {
        self.lines.last().map_or(0.0, |line| line.frequency)
    }

    /// By frequency (Hz): the measured acceleration per command, b = 1, and its standard deviation, dB.
    pub fn measured(&self, b: f64) -> impl Iterator<Item = (f64, f64, f64)> {
        self.lines.iter().map(move |line| {
            let size = line.gain.power().sqrt();
            let acceleration = size * line.frequency * line.frequency / b;
            let deviation = decibels(1.0 + line.deviation / size);
            (line.frequency / TAU, decibels(acceleration), deviation)
        })
    }

    /// The frequency response of the identified servo, with the hold of a sample (s) and without the current loop. Its
    /// frequencies are finer than the lines.
    pub fn identified(
        &self,
        servo: &ServoParameters,
        sample_time: f64,
    ) -> impl Iterator<Item = (f64, f64)> {
        /// Points from one line to the next.
        const FINER: usize = 12;
        let frequencies = self.lines.windows(2).flat_map(|pair| {
            let [low, high] = [pair[0].frequency, pair[1].frequency];
            (0..FINER).map(move |k| low * (high / low).powf(k as f64 / FINER as f64))
        });
        frequencies.map(move |omega| {
            let half = 0.5 * omega * sample_time;
            let hold = half.sin() / half;
            let mode = self.resonance.as_ref().map(|found| &found.mode);
            let acceleration = acceleration(servo.a, mode, omega);
            (omega / TAU, decibels(hold * acceleration.power().sqrt()))
        })
    }
}

/// −ω² (1/(s (s + a)) + β/(s² + 2 ζ ω₂ s + ω₂²)) at s = jω.
fn acceleration(a: f64, mode: Option<&Mode>, omega: f64) -> Complex {
    let number = |re, im| Complex { re, im };
    let both = number(1.0, 0.0) / number(1.0, -a / omega);
    let Some(mode) = mode else {
        return both;
    };
    let square = omega * omega;
    let denominator = number(
        mode.frequency * mode.frequency - square,
        2.0 * mode.damping * mode.frequency * omega,
    );
    both + number(-mode.ratio * square, 0.0) / denominator
}

fn decibels(ratio: f64) -> f64 {
    20.0 * ratio.log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_mass_is_flat_and_two_have_an_antiresonance_and_the_motors_gain_beyond() {
        let size = |mode: Option<&Mode>, omega| acceleration(2.0, mode, omega).power().sqrt();
        assert!((size(None, 200.0) - 1.0).abs() < 1e-4);
        assert!((size(None, 2.0) - 0.5_f64.sqrt()).abs() < 1e-12);
        let mode = Mode {
            frequency: 400.0,
            damping: 1e-3,
            ratio: 3.0,
        };
        assert!((mode.antiresonance() - 200.0).abs() < 1e-9);
        assert!(size(Some(&mode), 200.0) < 0.02);
        assert!(size(Some(&mode), 400.0) > 100.0);
        // Beyond the resonance the motor moves alone, with 1 + β times the gain of both.
        assert!((size(Some(&mode), 4e4) - 4.0).abs() < 1e-3);
    }
}
