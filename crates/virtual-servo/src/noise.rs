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

/// A seed that is far from its neighbours' (the finaliser of SplitMix64; Steele, Lea and Flood,
/// "Fast splittable pseudorandom number generators", OOPSLA 2014).
#[must_use]
pub fn distinct_seed(seed: u32, index: u32) -> u32 {
    let mut z = (u64::from(seed) << 32 | u64::from(index)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 33) as u32
}
