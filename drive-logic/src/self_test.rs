//! Whether this chip computes what it should.

use drive_link::Fault;
use identifier_core::adaptation::PositiveDefinite;
use identifier_core::control::{CommandLimit, ControlState, Gains};
use identifier_core::identifier::{
    Bounds, GradientIdentifier, GradientLaw, IdentifierConfig, IdentifierError,
};
use identifier_core::interval::Interval;
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::parameters::AbCoulomb;
use identifier_core::units::Units;

/// Samples of the known computation.
const SAMPLES: i32 = 200;

/// The bits of its result, the same on every machine.
const ANSWER: [u64; 3] = [
    0x3ff0_cb75_dd80_0000,
    0x4069_ccef_9300_0000,
    0x4014_1860_be00_0000,
];

/// Runs controller and identifier with friction over a motion that is a table of whole numbers and
/// holds every bit of the estimates against what they are elsewhere.
///
/// # Errors
/// [`Fault::WrongAnswer`].
pub fn self_test() -> Result<(), Fault> {
    match answer() {
        Ok(ANSWER) => Ok(()),
        _ => Err(Fault::WrongAnswer),
    }
}

fn answer() -> Result<[u64; 3], IdentifierError> {
    let config = IdentifierConfig {
        units: Units::new(1e-3, 6e-4)?,
        gains: Gains::new(9.0, 0.19, 4.0)?,
        limit: CommandLimit::symmetric(10.0)?,
        plant_box: None,
        initial: ServoParameters {
            a: 1.0,
            b: 200.0,
            coulomb: 5.0,
            load: 0.0,
        },
        bounds: Bounds {
            a: Interval::new("bounds.a", 0.0, 50.0)?,
            b: Interval::new("bounds.b", 110.0, 1000.0)?,
            coulomb: Interval::new("bounds.coulomb", 0.0, 100.0)?,
            load: Interval::new("bounds.load", -100.0, 100.0)?,
        },
    };
    let law = GradientLaw {
        gamma: PositiveDefinite::diagonal([0.2, 100.0, 1.0])?,
        mu: None,
        frozen: [false; 3],
    };
    let velocity = LowPass::<f32>::new(&config.units, 500.0)?;
    let controller = config.controller(velocity);
    let identifier = GradientIdentifier::<f32, _, AbCoulomb, 3>::new(&config, &law, velocity)?;
    let mut control = ControlState::at_rest(0.0);
    let mut learnt = identifier.start();
    for k in 0..SAMPLES {
        // A parabola up and down again, and a reference that stays behind it.
        let position = (k * (SAMPLES - k) / 32) as f32;
        if let Ok(sample) = controller.process(&mut control, 1.25 * position, position) {
            identifier.process(&mut learnt, &sample);
        }
    }
    let found = identifier.estimates(&learnt);
    Ok([found.a, found.b, found.coulomb].map(f64::to_bits))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_answer_is_the_known_one() {
        let answer = super::answer().expect("valid");
        assert_eq!(answer, super::ANSWER, "{answer:#018x?}");
        assert_eq!(super::self_test(), Ok(()));
    }
}
