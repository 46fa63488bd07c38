//! From settings to the parts of the core.

use drive_link::{Estimates, LoopSettings, Name, NotAllowed};
use identifier_core::adaptation::PositiveDefinite;
use identifier_core::control::{CommandLimit, Gains};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::identifier::{Bounds, GradientLaw, IdentifierConfig, IdentifierError};
use identifier_core::interval::Interval;
use identifier_core::model::ServoParameters;
use identifier_core::stability::{CertificateError, PlantBox};
use identifier_core::units::Units;

/// What an identifier is built from.
///
/// # Errors
/// The setting that is not allowed.
pub fn config(settings: &LoopSettings) -> Result<IdentifierConfig, IdentifierError> {
    Allowed::Above(0.0).check("counts_per_rev", settings.counts_per_rev)?;
    let position_unit = core::f64::consts::TAU / settings.counts_per_rev;
    let [kp, kd, ki] = settings.gains;
    let [low, high] = settings.limit;
    let limit = if low.is_infinite() && high.is_infinite() {
        CommandLimit::NONE
    } else {
        CommandLimit::asymmetric(low, high)?
    };
    let interval = |name, [min, max]: [f64; 2]| Interval::new(name, min, max);
    let [a, b, coulomb, load] = settings.initial;
    let [of_a, of_b, of_coulomb, of_load] = settings.bounds;
    let plant_box = match settings.plant_box {
        Some([a, b]) => Some(PlantBox::new(
            interval("plant_box.a", a)?,
            interval("plant_box.b", b)?,
        )?),
        None => None,
    };
    Ok(IdentifierConfig {
        units: Units::new(settings.sample_time, position_unit)?,
        gains: Gains::new(kp, kd, ki)?,
        limit,
        plant_box,
        initial: ServoParameters {
            a,
            b,
            coulomb,
            load,
        },
        bounds: Bounds {
            a: interval("bounds.a", of_a)?,
            b: interval("bounds.b", of_b)?,
            coulomb: interval("bounds.coulomb", of_coulomb)?,
            load: interval("bounds.load", of_load)?,
        },
    })
}

/// The law over the first P of a, b and c.
///
/// # Errors
/// A Γ that is not allowed.
pub fn law<const P: usize>(settings: &LoopSettings) -> Result<GradientLaw<P>, IdentifierError> {
    let of = |i: usize| settings.gamma.get(i).copied().unwrap_or(0.0);
    Ok(GradientLaw {
        gamma: PositiveDefinite::diagonal(core::array::from_fn(of))?,
        mu: settings.mu,
        frozen: [false; P],
    })
}

/// Estimates as a message.
pub(crate) fn estimates(found: &ServoParameters) -> Estimates {
    let ServoParameters {
        a,
        b,
        coulomb,
        load,
    } = *found;
    Estimates {
        a,
        b,
        coulomb,
        load,
    }
}

/// A refusal of the core as a message.
pub(crate) fn not_allowed(error: IdentifierError) -> NotAllowed {
    let (name, given, least, most) = match error {
        IdentifierError::Range(OutOfRange {
            parameter,
            value,
            allowed,
        }) => {
            let (least, most) = ends(allowed);
            (parameter, value, least, most)
        }
        IdentifierError::Certificate(CertificateError::MuNotPositive { mu }) => {
            ("mu", mu, 0.0, f64::INFINITY)
        }
        IdentifierError::Certificate(CertificateError::DampingTooSmall {
            mu, mu_below, ..
        }) => ("mu", mu, 0.0, mu_below),
        IdentifierError::Certificate(CertificateError::ProportionalGainTooSmall {
            kp,
            kp_above,
            ..
        }) => ("kp", kp, kp_above, f64::INFINITY),
        IdentifierError::SampledLoop(error) => {
            ("sample_time", error.sample_time, f64::NAN, f64::NAN)
        }
        _ => ("gamma", f64::NAN, 0.0, f64::INFINITY),
    };
    refusal(name, given, least, most)
}

/// A value outside what is allowed as a message.
pub(crate) fn refusal(name: &str, given: f64, least: f64, most: f64) -> NotAllowed {
    NotAllowed {
        name: Name::try_from(name).unwrap_or_default(),
        given,
        least,
        most,
    }
}

fn ends(allowed: Allowed) -> (f64, f64) {
    match allowed {
        Allowed::Above(low) | Allowed::AtLeast(low) => (low, f64::INFINITY),
        Allowed::Below(high) | Allowed::AtMost(high) => (f64::NEG_INFINITY, high),
        Allowed::Between(low, high) | Allowed::Within(low, high) => (low, high),
        Allowed::PositiveUpTo(high) => (0.0, high),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    }
}
