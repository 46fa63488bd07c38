//! The paper's experiment, from the same file as the simulator's.

use identifier_core::Settings;
use identifier_core::parameters::{PerParameter, ServoParameters};
use identifier_core::settings::{
    ControllerSettings, IdentifierSettings, ParameterRangeSettings, SettingsError,
};
use virtual_servo::excitation::BandLimitedWhiteNoise;
use virtual_servo::{Encoder, Plant};

// A module for each table of the scenario.
include!(concat!(env!("OUT_DIR"), "/paper.rs"));

/// Control samples of the experiment.
#[must_use]
pub fn samples() -> u32 {
    (run::DURATION / controller::SAMPLE_TIME + 0.5) as u32
}

/// Settings of controller and identifier.
#[must_use]
pub fn settings() -> Settings {
    let [of_a, of_b] = identifier::GAMMA;
    Settings {
        cutoff: controller::velocity_filter::CUTOFF,
        controller: Some(
            ControllerSettings::pid(controller::KP, controller::KD, controller::KI)
                .limited(amplifier::LIMIT),
        ),
        identifier: IdentifierSettings {
            initial: PerParameter {
                a: Some(identifier::initial::A),
                b: Some(identifier::initial::B),
                ..PerParameter::default()
            },
            bounds: PerParameter {
                a: Some(identifier::bounds::A),
                b: Some(identifier::bounds::B),
                ..PerParameter::default()
            },
            parameter_range: Some(ParameterRangeSettings {
                a: identifier::servo_range::A,
                b: identifier::servo_range::B,
            }),
            gamma: Some(PerParameter::new(of_a, of_b, 100.0, 0.0)),
            mu: Some(identifier::MU),
            ..IdentifierSettings::UNSTATED
        },
        ..Settings::new(controller::SAMPLE_TIME, encoder::COUNTS_PER_REV)
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
        excitation::POWER,
        excitation::SAMPLE_TIME,
        excitation::SEED as u32,
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
        Plant::at_rest(&parameters(coulomb), controller::SAMPLE_TIME),
        Encoder::new(encoder::COUNTS_PER_REV),
    )
}

/// The true servo's parameters, with Coulomb friction, rad/s².
#[must_use]
pub fn parameters(coulomb: f64) -> ServoParameters {
    ServoParameters {
        a: plant::A,
        b: plant::B,
        coulomb,
        load: plant::LOAD,
    }
}
