//! Between the core and the messages.

use drive_link::{Estimates, Name, NotAllowed, Why};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::identifier::{IdentifierError, Identify};
use identifier_core::model::ServoParameters;
use identifier_core::settings::IdentifierSettings;
use identifier_core::stability::CertificateError;

/// What an identifier has found as a message.
pub(crate) fn estimates<N: Copy, I: Identify<N>>(identifier: &I, shown: &I::Shown) -> Estimates {
    let ServoParameters {
        a,
        b,
        coulomb,
        load,
    } = identifier.estimates_of(shown);
    Estimates {
        a,
        b,
        coulomb,
        load,
        at_bounds: identifier.at_bounds_of(shown),
    }
}

/// Lets an identifier begin with what is known of its servo, but for what is known to be none: an
/// estimate at a bound.
pub(crate) fn begin_with(known: &Estimates, identifier: &mut IdentifierSettings) {
    let Estimates {
        a,
        b,
        coulomb,
        load,
        at_bounds,
    } = known;
    let initial = &mut identifier.initial;
    for (place, value, at_bound) in [
        (&mut initial.a, a, at_bounds.a),
        (&mut initial.b, b, at_bounds.b),
        (&mut initial.coulomb, coulomb, at_bounds.coulomb),
        (&mut initial.load, load, at_bounds.load),
    ] {
        if !at_bound {
            *place = Some(*value);
        }
    }
}

/// A refusal of the core as a message.
pub(crate) fn not_allowed(error: IdentifierError) -> NotAllowed {
    match error {
        IdentifierError::Range(OutOfRange {
            parameter,
            value,
            allowed,
        }) => out_of_range(parameter, value, ends(allowed)),
        IdentifierError::Certificate(CertificateError::MuNotPositive { mu }) => {
            out_of_range("mu", mu, (0.0, f64::INFINITY))
        }
        IdentifierError::Certificate(CertificateError::DampingTooSmall {
            mu, mu_below, ..
        }) => out_of_range("mu", mu, (0.0, mu_below)),
        IdentifierError::Certificate(CertificateError::ProportionalGainTooSmall {
            kp,
            kp_above,
            ..
        }) => out_of_range("kp", kp, (kp_above, f64::INFINITY)),
        IdentifierError::SampledLoop(error) => refusal(
            "sample_time",
            Why::Unstable {
                given: error.sample_time,
            },
        ),
        IdentifierError::Estimate(error) => out_of_range("bounds.b", error.b, (0.0, error.stable)),
        IdentifierError::NotGiven { setting } => refusal(setting, Why::NotGiven),
        _ => out_of_range("gamma", f64::NAN, (0.0, f64::INFINITY)),
    }
}

/// A setting out of its range as a message.
pub(crate) fn out_of_range(name: &str, given: f64, (least, most): (f64, f64)) -> NotAllowed {
    refusal(name, Why::OutOfRange { given, least, most })
}

/// A setting that contradicts another as a message.
pub(crate) fn too_small(name: &str, given: f64, least: f64, other: &str) -> NotAllowed {
    let other = Name::try_from(other).unwrap_or_default();
    refusal(
        name,
        Why::TooSmallFor {
            given,
            least,
            other,
        },
    )
}

/// Whether a sample time is a whole number of the output stage's periods.
pub(crate) fn whole_periods(sample_time: f64, period: f64) -> Result<(), NotAllowed> {
    /// Part of a period that decimal fractions leave.
    const ROUNDING: f64 = 1e-6;
    let periods = sample_time / period;
    // A cast saturates.
    let whole = f64::from((periods + 0.5) as u32);
    if whole >= 1.0 && (periods - whole).abs() <= ROUNDING {
        Ok(())
    } else {
        let why = Why::NotWhole {
            given: sample_time,
            period,
        };
        Err(refusal("sample_time", why))
    }
}

/// A setting that is refused as a message.
pub(crate) fn refusal(name: &str, why: Why) -> NotAllowed {
    NotAllowed {
        name: Name::try_from(name).unwrap_or_default(),
        why,
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
