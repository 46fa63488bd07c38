use identifier_core::excitation::NormalSource;
use identifier_core::model::ServoParameters;

use crate::scenario::{ExcitationSettings, Scenario};

/// The factor around the scenario's servo within which servos are drawn where no box is given.
const FACTOR: f64 = 3.0;

/// The scenario of one servo of a sweep: b log-uniform and a uniform in the plant box (or within a
/// factor of three of the scenario's servo), the load uniform between minus and plus the scenario's,
/// friction uniform from none to the scenario's, and a noise reference with a seed of its own.
///
/// Each follows from the seed and the number alone.
#[must_use]
pub fn draw(base: &Scenario, seed: u32, index: u32) -> Scenario {
    let mut scenario = base.clone();
    let Some(servo) = base.plant else {
        return scenario;
    };
    let mut source = NormalSource::new(mixed(seed, index));
    let mut uniform = |low: f64, high: f64| low + (high - low) * source.next_uniform();
    let ([a_min, a_max], [b_min, b_max]) = match base.stated.identifier.plant_box {
        Some(within) => (within.a, within.b),
        None => (
            [0.0, FACTOR * servo.a],
            [servo.b / FACTOR, FACTOR * servo.b],
        ),
    };
    scenario.plant = Some(ServoParameters {
        a: uniform(a_min, a_max),
        b: b_min * libm::exp(uniform(0.0, libm::log(b_max / b_min))),
        load: uniform(-servo.load, servo.load),
        coulomb: uniform(0.0, servo.coulomb),
    });
    if let ExcitationSettings::BandLimitedWhiteNoise { seed, .. } = &mut scenario.excitation {
        *seed = uniform(1.0, f64::from(u32::MAX)) as u32;
    }
    scenario
}

/// A seed that is far from its neighbours' (the finaliser of SplitMix64; Steele, Lea and Flood,
/// "Fast splittable pseudorandom number generators", OOPSLA 2014).
fn mixed(seed: u32, index: u32) -> u32 {
    let mut z = (u64::from(seed) << 32 | u64::from(index)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 33) as u32
}
