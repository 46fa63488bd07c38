//! The paper's experiment, from the same file as the simulator's.

use identifier_core::adaptation::PositiveDefinite;
use identifier_core::control::{CommandLimit, Gains};
use identifier_core::excitation::BandLimitedWhiteNoise;
use identifier_core::identifier::{Bounds, GradientLaw, IdentifierConfig, IdentifierError};
use identifier_core::interval::Interval;
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::stability::PlantBox;
use identifier_core::units::Units;
use virtual_servo::{Encoder, Plant};

include!(concat!(env!("OUT_DIR"), "/paper.rs"));

/// Control samples of the experiment.
#[must_use]
pub fn samples() -> u32 {
    (DURATION / SAMPLE_TIME + 0.5) as u32
}

/// What the identifier is built from.
///
/// # Errors
/// None for the file that this was made from.
pub fn config() -> Result<IdentifierConfig, IdentifierError> {
    let position_unit = core::f64::consts::TAU / COUNTS_PER_REV;
    let units = Units::new(SAMPLE_TIME, position_unit)?;
    let limit = CommandLimit::symmetric(LIMIT)?;
    let interval = |name, [min, max]: [f64; 2]| Interval::new(name, min, max);
    let most = BOUNDS_B[1] * LIMIT.min(KP);
    let [a, b] = INITIAL;
    Ok(IdentifierConfig {
        units,
        gains: Gains::new(KP, KD, KI)?,
        limit,
        plant_box: Some(PlantBox::new(
            interval("plant_box.a", BOX_A)?,
            interval("plant_box.b", BOX_B)?,
        )?),
        initial: ServoParameters {
            a,
            b,
            coulomb: 0.0,
            load: 0.0,
        },
        bounds: Bounds {
            a: interval("bounds.a", BOUNDS_A)?,
            b: interval("bounds.b", BOUNDS_B)?,
            coulomb: interval("bounds.coulomb", [0.0, most])?,
            load: interval("bounds.load", [-most, most])?,
        },
    })
}

/// The law.
///
/// # Errors
/// None for the file that this was made from.
pub fn law() -> Result<GradientLaw<2>, IdentifierError> {
    Ok(GradientLaw {
        gamma: PositiveDefinite::diagonal(GAMMA)?,
        mu: Some(MU),
        frozen: [false; 2],
    })
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
