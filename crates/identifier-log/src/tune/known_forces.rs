//! The known forces on a servo beside inertia and friction, for the formula of a feed-forward.

use super::result::{IdentifiedResult, WithError};

use crate::result::KnownForces;
use crate::scenario::Options;

/// An angle that is the same one in every run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    /// Periods of the ripple to a revolution; none where none is declared.
    pub ripple_order: Option<f64>,
}

impl Angle {
    /// That of a scenario; none where its angle begins anew in every recording.
    #[must_use]
    pub fn of_scenario(scenario: &Options) -> Option<Self> {
        let terms = &scenario.stated.identifier.terms;
        // The tool's own traces are of a servo that begins at zero.
        let is_same = match &scenario.log {
            Some(log) => log.absolute,
            None => true,
        };
        is_same.then_some(Self {
            ripple_order: terms.ripple_order,
        })
    }
}

/// The standard errors from zero at which an estimate is certain. Chance alone does that to one in a million.
const KNOWN: f64 = 5.0;

/// The value of an estimate that is known, else zero.
fn known([value, std_error]: WithError) -> f64 {
    if value.abs() > KNOWN * std_error {
        value
    } else {
        0.0
    }
}

/// The forces that are known, for an angle, if there is one. The `delay` is that from a command to its
/// acceleration besides the hold's, s.
pub(super) fn known_forces(
    result: &IdentifiedResult,
    angle: Option<&Angle>,
    delay: f64,
) -> KnownForces {
    let (own, b) = (&result.effects, result.model.servo.parameters.b);
    // Without a zero's sign.
    let held = |force| 0.0 - known(force) / b;
    let without_angle = KnownForces {
        constant: held(result.load),
        dead_band: known(own.dead_band).max(0.0),
        delay,
        ..KnownForces::default()
    };
    let Some(angle) = angle else {
        return without_angle;
    };
    KnownForces {
        gravity: own.gravity.map(held),
        ripple: angle
            .ripple_order
            .map_or([0.0; 2], |_| own.ripple.map(held)),
        ripple_order: angle.ripple_order.unwrap_or(0.0),
        ..without_angle
    }
}
