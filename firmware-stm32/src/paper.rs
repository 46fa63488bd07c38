//! The paper's experiment, from the same file as the simulator's.

use identifier_core::parameters::{PerParameter, ServoParameters};
use identifier_core::settings::{BoxSettings, IdentifierSettings, SettingsError, diagonal};
use identifier_core::{ControllerSettings, Settings};
use virtual_servo::excitation::BandLimitedWhiteNoise;
use virtual_servo::{Encoder, Plant};

include!(concat!(env!("OUT_DIR"), "/paper.rs"));

/// Control samples of the experiment.
#[must_use]
pub fn samples() -> u32 {
    (DURATION / SAMPLE_TIME + 0.5) as u32
}

/// Settings of controller and identifier.
#[must_use]
pub fn settings() -> Settings {
    let [a, b] = INITIAL;
    let [of_a, of_b] = GAMMA;
    Settings {
        cutoff: CUTOFF,
        controller: Some(ControllerSettings::pid(KP, KD, KI).limited(LIMIT)),
        identifier: IdentifierSettings {
            initial: PerParameter {
                a: Some(a),
                b: Some(b),
                ..PerParameter::default()
            },
            bounds: PerParameter {
                a: Some(BOUNDS_A),
                b: Some(BOUNDS_B),
                ..PerParameter::default()
            },
            plant_box: Some(BoxSettings { a: BOX_A, b: BOX_B }),
            gamma: Some(diagonal([of_a, of_b, 100.0, 0.0])),
            mu: Some(MU),
            ..IdentifierSettings::UNSTATED
        },
        ..Settings::new(SAMPLE_TIME, COUNTS_PER_REV)
    }
}

/// The reference, counts.
///
/// # Errors
/// None for the file that this was made from.
pub fn reference() -> Result<BandLimitedWhiteNoise, SettingsError> {
    let units = settings().units()?;
    Ok(BandLimitedWhiteNoise::new(
        &units,
        POWER,
        HOLD,
        SEED as u32,
    )?)
}

/// The true servo and its encoder.
#[must_use]
pub fn servo() -> (Plant, Encoder) {
    servo_with(0.0)
}

/// The same with Coulomb friction, rad/s².
#[must_use]
pub fn servo_with(coulomb: f64) -> (Plant, Encoder) {
    (
        Plant::at_rest(&parameters(coulomb), SAMPLE_TIME),
        Encoder::new(COUNTS_PER_REV),
    )
}

/// The true servo's parameters, with Coulomb friction, rad/s².
#[must_use]
pub fn parameters(coulomb: f64) -> ServoParameters {
    ServoParameters {
        a: A,
        b: B,
        coulomb,
        load: LOAD,
    }
}
