use identifier_core::parameters::ServoParameters;
use virtual_servo::distinct_seed;
use virtual_servo::excitation::NormalSource;

use crate::scenario::{ExcitationKind, Scenario, range_around};

/// The scenario of one servo of a sweep. Its b is log-uniform and its a uniform in the plant's range, or within a
/// factor of three of the scenario's servo. The load is uniform between minus and plus the scenario's, and friction is
/// uniform from none to the scenario's. It has seeds of its own for a noise reference and for everything random in
/// servo and sensor. Its other effects are the scenario's, those of friction in proportion to it.
///
/// Each follows from the seed and the number alone.
#[must_use]
pub fn draw(base: &Scenario, seed: u32, index: u32) -> Scenario {
    let mut scenario = base.clone();
    let Some(servo) = base.plant else {
        return scenario;
    };
    let mut source = NormalSource::new(distinct_seed(seed, index));
    let mut uniform = |low: f64, high: f64| low + (high - low) * source.next_uniform();
    let within = base.stated.identifier.parameter_range;
    let within = within.unwrap_or_else(|| range_around(&servo));
    let ([a_min, a_max], [b_min, b_max]) = (within.a, within.b);
    let drawn = ServoParameters {
        a: uniform(a_min, a_max),
        b: b_min * libm::exp(uniform(0.0, libm::log(b_max / b_min))),
        load: uniform(-servo.load, servo.load),
        coulomb: uniform(0.0, servo.coulomb),
    };
    scenario.effects = base.effects.carried_over(&servo, &drawn);
    scenario.plant = Some(drawn);
    if scenario.excitation.kind == ExcitationKind::BandLimitedWhiteNoise {
        scenario.excitation.seed = uniform(1.0, f64::from(u32::MAX)) as u32;
    }
    scenario.seed = Some(distinct_seed(!seed, index));
    scenario
}
