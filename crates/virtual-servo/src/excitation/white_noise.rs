use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::{Excitation, Hold};
use identifier_core::number::Number;
use identifier_core::units::Units;

/// Simulink's Band-Limited White Noise, bit for bit. Normal random numbers are held for a sample time of their own,
/// scaled by √(power/sample time).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandLimitedWhiteNoise {
    scale: f64,
    per_unit: f64,
    hold: u32,
    seed: u32,
}

/// Progress of a [`BandLimitedWhiteNoise`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandLimitedWhiteNoiseState<N> {
    source: NormalSource,
    hold: Hold,
    level: N,
}

impl BandLimitedWhiteNoise {
    /// Noise of a power (rad² s), a sample time (s; a whole number of control samples) and a seed.
    ///
    /// # Errors
    /// `power` must be above 0, `sample_time` a whole number of control samples.
    pub fn new(units: &Units, power: f64, sample_time: f64, seed: u32) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("power", power)?;
        Ok(Self {
            scale: libm::sqrt(power) / libm::sqrt(sample_time),
            per_unit: units.position_unit(),
            hold: Hold::steps("sample_time", sample_time, units.sample_time())?,
            seed,
        })
    }
}

impl<N: Number> Excitation<N> for BandLimitedWhiteNoise {
    type State = BandLimitedWhiteNoiseState<N>;

    fn start(&self) -> Self::State {
        BandLimitedWhiteNoiseState {
            source: NormalSource::new(self.seed),
            hold: Hold::EXPIRED,
            level: N::ZERO,
        }
    }

    #[inline]
    fn process(&self, state: &mut Self::State) -> N {
        if state.hold.expires(self.hold) {
            state.level = N::from_f64(self.scale * state.source.next_normal() / self.per_unit);
        }
        state.level
    }
}

/// Simulink's generator of normal random numbers. It is Park and Miller's minimal standard behind Marsaglia's polar
/// method. Literature: "Random number generators: good ones are hard to find", Communications of the ACM 31(10), 1988.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NormalSource {
    state: u32,
}

impl NormalSource {
    const MULTIPLIER: u64 = 16_807;
    const MODULUS: u64 = 0x7fff_ffff;
    const LARGEST_STATE: u32 = 0x7fff_fffe;
    /// The state that Simulink substitutes for zero.
    const STATE_FOR_ZERO: u32 = 1_144_108_930;
    /// 1/modulus, with the digits that Simulink writes.
    #[expect(clippy::excessive_precision, reason = "the digits are Simulink's")]
    const PER_STATE: f64 = 4.656_612_875_245_796_9e-10;

    /// Scrambles a seed into the first state as Simulink's Random Number block does.
    #[must_use]
    pub fn new(seed: u32) -> Self {
        let high = seed >> 16;
        let bit = seed & 0x8000;
        let low = seed.wrapping_sub(high << 16).wrapping_add(bit);
        let state = (low << 16).wrapping_add(bit).wrapping_add(high);
        Self {
            state: match state {
                0 => Self::STATE_FOR_ZERO,
                _ => state.min(Self::LARGEST_STATE),
            },
        }
    }

    /// The next uniform number in (0, 1).
    pub fn next_uniform(&mut self) -> f64 {
        let next = (Self::MULTIPLIER * u64::from(self.state) % Self::MODULUS) as u32;
        self.state = next;
        f64::from(next) * Self::PER_STATE
    }

    /// The next standard normal number. The polar method makes two; Simulink throws the second
    /// away.
    pub fn next_normal(&mut self) -> f64 {
        loop {
            let x = 2.0 * self.next_uniform() - 1.0;
            let y = 2.0 * self.next_uniform() - 1.0;
            let r = x * x + y * y;
            // r = 0 is excluded by the modulus being prime: x = y = 0 would need U = 1/2 twice.
            if r <= 1.0 {
                return libm::sqrt(-2.0 * libm::log(r) / r) * x;
            }
        }
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "bit for bit is the claim")]
mod tests {
    use super::*;

    #[test]
    fn generator_meets_park_and_millers_check_value() {
        let mut source = NormalSource { state: 1 };
        for _ in 0..10_000 {
            source.next_uniform();
        }
        assert_eq!(source.state, 1_043_618_065);
    }

    #[test]
    fn seeds_without_a_valid_state_are_mended_as_in_simulink() {
        assert_eq!(NormalSource::new(0).state, 1_144_108_930);
        assert!((0..100_000_u32).all(|k| {
            let state = NormalSource::new(k.wrapping_mul(42_949)).state;
            (1..=NormalSource::LARGEST_STATE).contains(&state)
        }));
    }

    #[test]
    #[expect(clippy::excessive_precision, reason = "the digits are Simulink's")]
    fn outputs_of_the_paper_are_simulinks() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        let noise = BandLimitedWhiteNoise::new(&units, 0.005, 0.1, 1_212_121).expect("valid");
        let mut state = Excitation::<f64>::start(&noise);
        let outputs: [f64; 500] = core::array::from_fn(|_| noise.process(&mut state));
        let expected = [
            0.290_503_081_935_298_45,
            0.091_314_839_049_081_331,
            0.087_030_307_411_077_423,
            0.236_483_693_057_515_29,
            -0.102_288_718_733_931_42,
        ];
        for (k, output) in outputs.iter().enumerate() {
            assert_eq!(*output, expected[k / 100], "sample {k}");
        }
    }

    #[test]
    fn hold_that_is_no_whole_number_of_samples_is_refused() {
        let units = Units::new(1e-3, 1.0).expect("valid");
        let error = BandLimitedWhiteNoise::new(&units, 0.005, 0.0995, 1).expect_err("99.5 samples");
        assert_eq!(error.parameter, "sample_time");
        assert!(BandLimitedWhiteNoise::new(&units, 0.005, 1e-4, 1).is_err());
        assert!(BandLimitedWhiteNoise::new(&units, -1.0, 0.1, 1).is_err());
    }
}
