//! An identified servo, corrected by what a further measurement shows of it.

use identifier_core::parameters::{IdentifiedServo, ServoParameters};

/// Gives a servo another inertia: all accelerations times a factor.
pub(super) fn scale(servo: &mut IdentifiedServo, factor: f64) {
    let ServoParameters {
        a,
        b,
        coulomb,
        load,
    } = &mut servo.parameters;
    for value in [a, b, coulomb, load] {
        *value *= factor;
    }
    let places = 0..servo.covariance.len();
    for place in places.filter(|&place| place != IdentifiedServo::DELAY) {
        scale_errors(servo, place, factor);
    }
}

/// An unknown of a servo is known by itself, with this standard error.
pub(super) fn set_one_known(servo: &mut IdentifiedServo, place: usize, error: f64) {
    for (i, row) in servo.covariance.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            if i == place || j == place {
                *entry = if i == j { error * error } else { 0.0 };
            }
        }
    }
}

/// Multiplies the standard error of an unknown.
pub(super) fn scale_errors(servo: &mut IdentifiedServo, place: usize, factor: f64) {
    for (i, row) in servo.covariance.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let scaled = [i, j].into_iter().filter(|&of| of == place);
            *entry *= scaled.fold(1.0, |product, _| factor * product);
        }
    }
}
