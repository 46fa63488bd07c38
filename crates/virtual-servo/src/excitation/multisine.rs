use super::oscillator::{Phase, SineSeries};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::Excitation;
use identifier_core::number::Number;
use identifier_core::units::Units;

/// One tone of a [`Multisine`], SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineTone {
    /// Amplitude, rad.
    pub amplitude: f64,
    /// Angular frequency, rad/s.
    pub frequency: f64,
}

/// A sum of up to M sines with Schroeder's phases, which keep its peak low. For equal amplitudes φₖ = −π k (k − 1)/n.
/// Literature: "Synthesis of low-peak-factor signals", IEEE Transactions on Information Theory 16(1), 1970.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multisine<N, const M: usize> {
    amplitudes: [N; M],
    increments: [Phase; M],
    initial: [Phase; M],
    used: usize,
    series: SineSeries<N>,
}

/// Progress of a [`Multisine`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MultisineState<const M: usize> {
    phases: [Phase; M],
}

impl<N: Number, const M: usize> Multisine<N, M> {
    /// The sum of the given tones, 1 to M of them.
    ///
    /// # Errors
    /// `tones`: their number; `amplitude` must be above 0; `frequency` above 0 and below π/T.
    pub fn new(units: &Units, tones: &[SineTone]) -> Result<Self, OutOfRange> {
        Allowed::Within(1.0, M as f64).check("tones", tones.len() as f64)?;
        let nyquist = core::f64::consts::PI / units.sample_time();
        let mut multisine = Self {
            amplitudes: [N::ZERO; M],
            increments: [Phase(0); M],
            initial: [Phase(0); M],
            used: tones.len(),
            series: SineSeries::new(),
        };
        for (k, tone) in tones.iter().enumerate() {
            let amplitude = Allowed::Above(0.0).check("amplitude", tone.amplitude)?;
            let frequency = Allowed::Between(0.0, nyquist).check("frequency", tone.frequency)?;
            multisine.amplitudes[k] = N::from_f64(amplitude * units.position());
            multisine.increments[k] =
                Phase::from_turns(frequency * units.sample_time() / core::f64::consts::TAU);
            let parts = 2 * tones.len();
            let schroeder = (k * (k + 1)) % parts;
            multisine.initial[k] = Phase::from_turns((parts - schroeder) as f64 / parts as f64);
        }
        Ok(multisine)
    }
}

impl<N: Number, const M: usize> Excitation<N> for Multisine<N, M> {
    type State = MultisineState<M>;

    fn start(&self) -> MultisineState<M> {
        MultisineState {
            phases: self.initial,
        }
    }

    #[inline]
    fn process(&self, state: &mut MultisineState<M>) -> N {
        let mut sum = N::ZERO;
        for k in 0..self.used.min(M) {
            sum += self.amplitudes[k] * state.phases[k].sine(&self.series);
            state.phases[k].advance(self.increments[k]);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schroeders_phases_keep_the_peak_low() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        let tones: [SineTone; 16] = core::array::from_fn(|k| SineTone {
            amplitude: 1.0,
            frequency: 2.0 * (k + 1) as f64,
        });
        let sine = Multisine::<f64, 16>::new(&units, &tones).expect("valid");
        let mut state = sine.start();
        let peak = (0..4000).fold(0.0_f64, |peak, _| peak.max(sine.process(&mut state).abs()));
        let crest = peak / libm::sqrt(8.0);
        assert!(crest < 2.0, "{crest}; in phase it would be 5.6");
    }

    #[test]
    fn bad_tones_are_refused_by_name() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        for (name, tones, amplitude, frequency) in [
            ("tones", 0, 1.0, 1.0),
            ("tones", 3, 1.0, 1.0),
            ("amplitude", 1, 0.0, 1.0),
            ("frequency", 1, 1.0, 4000.0),
            ("frequency", 1, 1.0, f64::NAN),
        ] {
            let tone = SineTone {
                amplitude,
                frequency,
            };
            let refused = Multisine::<f64, 2>::new(&units, &[tone; 3][..tones]);
            assert_eq!(refused.expect_err("bad tone").parameter, name);
        }
    }
}
