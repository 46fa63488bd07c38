//! Random numbers, with a stream for each use.

use crate::excitation::NormalSource;

/// The use of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stream {
    LoadWander = 1,
    SensorNoise = 2,
    Jitter = 3,
}

/// The source of normal numbers for a use, one of many that follow from a seed.
pub(crate) fn source(seed: u32, stream: Stream) -> NormalSource {
    NormalSource::new(distinct_seed(seed, stream as u32))
}

/// A seed that is far from its neighbours'.
#[must_use]
pub fn distinct_seed(seed: u32, index: u32) -> u32 {
    let mut source = SplitMix64::new(u64::from(seed) << 32 | u64::from(index));
    (source.next_word() >> 33) as u32
}

/// A generator of uniform random words that is good from any seed on. Literature: Steele, Lea and Flood, "Fast
/// splittable pseudorandom number generators", OOPSLA 2014.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// The sequence of a seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next word.
    pub fn next_word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// The next number, uniform from zero to below one.
    pub fn next_uniform(&mut self) -> f64 {
        (self.next_word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next number, uniform between two bounds.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next_uniform()
    }

    /// One of some values.
    ///
    /// # Panics
    /// Without a value.
    pub fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        let place = (self.next_uniform() * values.len() as f64) as usize;
        values[place.min(values.len() - 1)]
    }
}
