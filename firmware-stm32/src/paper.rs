//! The paper's experiment, from the same file as the simulator's.

use drive_link::{Format, LoopSettings};
use identifier_core::excitation::BandLimitedWhiteNoise;
use identifier_core::identifier::{GradientLaw, IdentifierConfig, IdentifierError};
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::units::Units;
use virtual_servo::{Encoder, Plant};

include!(concat!(env!("OUT_DIR"), "/paper.rs"));

/// Control samples of the experiment.
#[must_use]
pub fn samples() -> u32 {
    (DURATION / SAMPLE_TIME + 0.5) as u32
}

/// What controller and identifier are built from.
#[must_use]
pub fn loop_settings(format: Format) -> LoopSettings {
    let most = BOUNDS_B[1] * LIMIT.min(KP);
    let [a, b] = INITIAL;
    let [of_a, of_b] = GAMMA;
    LoopSettings {
        sample_time: SAMPLE_TIME,
        counts_per_rev: COUNTS_PER_REV,
        gains: [KP, KD, KI],
        limit: [-LIMIT, LIMIT],
        cutoff: CUTOFF,
        plant_box: Some([BOX_A, BOX_B]),
        initial: [a, b, 0.0, 0.0],
        bounds: [BOUNDS_A, BOUNDS_B, [0.0, most], [-most, most]],
        gamma: [of_a, of_b, 100.0],
        mu: Some(MU),
        friction: false,
        format,
    }
}

/// The same as the core takes it.
///
/// # Errors
/// None for the file that this was made from.
pub fn config() -> Result<IdentifierConfig, IdentifierError> {
    drive_logic::config(&loop_settings(Format::Single))
}

/// The law.
///
/// # Errors
/// None for the file that this was made from.
pub fn law<const P: usize>() -> Result<GradientLaw<P>, IdentifierError> {
    drive_logic::law(&loop_settings(Format::Single))
}

/// The velocity estimate.
///
/// # Errors
/// None for the file that this was made from.
pub fn velocity<N: Number>(units: &Units) -> Result<LowPass<N>, IdentifierError> {
    Ok(LowPass::new(units, CUTOFF)?)
}

/// The reference.
///
/// # Errors
/// None for the file that this was made from.
pub fn reference(units: &Units) -> Result<BandLimitedWhiteNoise, IdentifierError> {
    Ok(BandLimitedWhiteNoise::new(units, POWER, HOLD, SEED as u32)?)
}

/// The true servo and its encoder.
#[must_use]
pub fn servo() -> (Plant, Encoder) {
    let servo = ServoParameters {
        a: A,
        b: B,
        coulomb: 0.0,
        load: LOAD,
    };
    (
        Plant::at_rest(&servo, SAMPLE_TIME),
        Encoder::new(COUNTS_PER_REV),
    )
}
