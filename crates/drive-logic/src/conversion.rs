//! Conversions between the core's values and the messages of the link.

use drive_link::{Estimates, NotAllowed, TermSizes};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::identifier::Identify;
use identifier_core::parameters::{IdentifiedServo, PerParameter, ServoParameters};
use identifier_core::settings::IdentifierSettings;

use crate::chip::OutputStage;

/// Estimates of an identifier as a message.
pub(crate) fn estimates<N: Copy, I: Identify<N>>(identifier: &I, shown: &I::Snapshot) -> Estimates {
    Estimates {
        servo: identifier.estimates_in(shown),
        at_bounds: identifier.at_bounds_in(shown),
        standard_errors: None,
        terms: TermSizes::where_known(|unknown| identifier.value_in(shown, unknown)),
    }
}

/// Estimates of a commissioning as a message. None is at a bound, or it would have failed.
pub(crate) fn identified(servo: &IdentifiedServo) -> Estimates {
    Estimates {
        servo: servo.parameters,
        at_bounds: PerParameter::default(),
        standard_errors: Some(ServoParameters {
            a: servo.standard_error(IdentifiedServo::A),
            b: servo.standard_error(IdentifiedServo::B),
            coulomb: servo.standard_error(IdentifiedServo::COULOMB),
            load: servo.standard_error(IdentifiedServo::LOAD),
        }),
        terms: None,
    }
}

/// The command that balances the load of a servo, within its limits; zero where load or gain is not known.
pub(crate) fn balance(known: &Estimates, [low, high]: [f64; 2]) -> f64 {
    let (servo, at_bounds) = (&known.servo, &known.at_bounds);
    let command = -servo.load / servo.b;
    // Not a number is none.
    if at_bounds.b || at_bounds.load || !(servo.b > 0.0 && command.is_finite()) {
        return 0.0;
    }
    command.max(low).min(high)
}

/// Initial estimates from what is known of the servo. An estimate at a bound is none.
pub(crate) fn set_initial(known: &Estimates, identifier: &mut IdentifierSettings) {
    let (servo, at_bounds) = (&known.servo, &known.at_bounds);
    let initial = &mut identifier.initial;
    for (place, value, at_bound) in [
        (&mut initial.a, servo.a, at_bounds.a),
        (&mut initial.b, servo.b, at_bounds.b),
        (&mut initial.coulomb, servo.coulomb, at_bounds.coulomb),
        (&mut initial.load, servo.load, at_bounds.load),
    ] {
        if !at_bound {
            *place = Some(value);
        }
    }
}

/// # Errors
/// The output stage cannot give these limits of a command.
pub(crate) fn check_stage_limits(
    [low, high]: [f64; 2],
    stage: &OutputStage,
) -> Result<(), NotAllowed> {
    for (name, limit) in [("limit_high", high), ("limit_low", -low)] {
        Allowed::AtMost(stage.full_scale).check(name, limit)?;
    }
    Ok(())
}

/// # Errors
/// The sample time is no whole number of the output stage's periods.
pub(crate) fn check_whole_periods(sample_time: f64, period: f64) -> Result<(), NotAllowed> {
    /// Part of a period that decimal fractions leave.
    const WHOLE_TOLERANCE: f64 = 1e-6;
    let periods = sample_time / period;
    // A cast saturates.
    let whole = f64::from((periods + 0.5) as u32);
    if whole >= 1.0 && (periods - whole).abs() <= WHOLE_TOLERANCE {
        Ok(())
    } else {
        let allowed = Allowed::MultipleOf(period);
        Err(OutOfRange::new("sample_time", sample_time, allowed).into())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::string::ToString;

    use identifier_core::settings::{GainError, SettingsError};

    use super::*;

    #[test]
    fn a_refusal_of_the_core_says_on_the_line_what_it_says_in_the_core() {
        for error in [
            SettingsError::NoGamma(GainError::AtRest),
            SettingsError::NotGiven { setting: "bounds" },
            OutOfRange::new("feed_forward.coulomb_speed", -0.5, Allowed::Above(0.0)).into(),
            OutOfRange::new("sample_time", 1.1e-4, Allowed::MultipleOf(5e-5)).into(),
            OutOfRange::new("delay", f64::NAN, Allowed::Within(0.0, 0.006)).into(),
        ] {
            assert_eq!(NotAllowed::from(error).to_string(), error.to_string());
        }
    }

    #[test]
    fn the_command_that_holds_a_load_keeps_the_limits_of_the_order() {
        for (load, command) in [(30.0, -1.0), (-30.0, 2.0), (5.0, -0.5)] {
            let known = Estimates {
                servo: ServoParameters {
                    a: 1.0,
                    b: 10.0,
                    coulomb: 0.0,
                    load,
                },
                ..Estimates::default()
            };
            let held = balance(&known, [-1.0, 2.0]);
            assert_eq!(held.to_bits(), f64::to_bits(command));
        }
    }
}
