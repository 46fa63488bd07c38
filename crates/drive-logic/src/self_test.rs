//! A test of the chip's arithmetic by a known computation.

use drive_link::Fault;
use identifier_core::Settings;
use identifier_core::identifier::{GradientIdentifier, Identify, ServoLoop};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{PerParameter, Unknowns};
use identifier_core::settings::{ControllerSettings, IdentifierSettings, SettingsError};

/// Samples of the known computation.
const SAMPLES: i32 = 200;

/// The bits of its result, the same on every machine.
const ANSWER: [u64; 3] = [
    0x3ff0_a2dd_2a40_0000,
    0x4069_f239_6000_0000,
    0x4013_ffbb_1300_0000,
];

/// Where its motion begins: it passes the place where counts wrap.
const START: i32 = i32::MAX - 100;

type Filter = LowPass<f32>;

/// Runs controller and identifier with friction over a motion from a table of whole numbers. It compares every bit of
/// the estimates with their value elsewhere.
///
/// # Errors
/// [`Fault::SelfTestFailed`].
#[inline(never)]
pub fn self_test() -> Result<(), Fault> {
    match answer() {
        Ok(ANSWER) => Ok(()),
        _ => Err(Fault::SelfTestFailed),
    }
}

fn settings() -> Settings {
    let mut gamma = [[0.0; 4]; 4];
    gamma[0][0] = 0.2;
    gamma[1][1] = 100.0;
    gamma[2][2] = 1.0;
    Settings {
        sample_time: 1e-3,
        resolution: 6e-4,
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        identifier: IdentifierSettings {
            initial: PerParameter {
                a: Some(1.0),
                b: Some(200.0),
                coulomb: Some(5.0),
                load: None,
            },
            bounds: PerParameter {
                a: Some([0.0, 50.0]),
                b: Some([110.0, 1000.0]),
                coulomb: Some([0.0, 100.0]),
                load: None,
            },
            gamma: Some(gamma),
            ..IdentifierSettings::UNSTATED
        },
    }
}

fn answer() -> Result<[u64; 3], SettingsError> {
    let servo_loop: ServoLoop<f32, Filter, GradientIdentifier<f32, Filter, Unknowns<3>, 3>> =
        settings().build()?;
    let mut state = servo_loop.start(START);
    for k in 0..SAMPLES {
        // A parabola up and down again, and a setpoint that goes a quarter beyond it.
        let position = k * (SAMPLES - k) / 32;
        let count = START.wrapping_add(position);
        let beyond = 0.25 * position as f32;
        // A sample that is refused leaves the state, and so another answer.
        let _ = servo_loop.process(&mut state, count, beyond, count);
    }
    let identifier = servo_loop.identifier();
    let found = identifier.estimates_in(&identifier.snapshot(state.identification()));
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
