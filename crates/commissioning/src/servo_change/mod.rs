//! Changes of a servo after its gains were found. The test is whether the prediction of the gains still holds for it.

use core::fmt;

mod state;

pub use state::ServoChangeState;

use identifier_core::parameters::{IdentifiedServo, ServoParameters};
use identifier_core::reason::Reason;
use identifier_core::tuning::Tuning;

/// A servo with the gains whose prediction holds for it.
///
/// Its inertia and its loads are compared in terms of the command, inertia as 1/b. Viscous and Coulomb friction and
/// load are a/b, c/b and d/b. An added mass changes the first alone.
///
/// A servo counts as another if one of the four differs so far from the predicted one
///
/// - in standard errors of both together ([`CommissionedServo::CERTAIN`]) that noise does not explain it, and
/// - in size that the prediction no longer holds. The limit of inertia is [`CommissionedServo::MAX_INERTIA_RATIO`]. That of
///   viscous friction is a quarter of the loop's damping k_d + a/b. That of Coulomb friction is half of it, and a
///   twenty-fifth of the predicted step's largest command. The load must then change by less than half of that. That of
///   the load is a tenth of the largest command. The load must also leave less of it than the predicted step takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommissionedServo {
    servo: [Known; 4],
    /// The least change of each that counts.
    least: [f64; 4],
}

/// A servo for which the gains' prediction no longer holds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ServoChange {
    /// The quantity that changed.
    pub reason: Reason,
    /// The predicted value of 1/b, a/b, c/b or d/b, in command units per rad/s², command units per rad/s, command
    /// units.
    pub predicted: f64,
    /// The value that was found.
    pub found: f64,
    /// Their distance, standard errors of both together.
    pub standard_errors: f64,
}

impl fmt::Display for ServoChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            reason,
            predicted,
            found,
            standard_errors,
        } = self;
        let unit = match reason {
            Reason::InertiaChanged => "u/(rad/s²)",
            Reason::ViscousFrictionChanged => "u/(rad/s)",
            _ => "u",
        };
        write!(
            f,
            "{reason} ({found:.3e} {unit}, commissioned with {predicted:.3e}, {standard_errors:.0} standard errors \
             apart)"
        )
    }
}

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Known {
    value: f64,
    error: f64,
}

/// Places of the quantities.
const COULOMB: usize = 2;
const LOAD: usize = 3;

/// The reasons, in the order of the quantities.
const REASONS: [Reason; 4] = [
    Reason::InertiaChanged,
    Reason::ViscousFrictionChanged,
    Reason::CoulombFrictionChanged,
    Reason::LoadChanged,
];

impl CommissionedServo {
    /// The standard errors, of the predicted and the found value together, from which a change is certain.
    pub const CERTAIN: f64 = 6.0;

    /// The ratio to either side from which another inertia counts. With the largest sensitivity of the gains, 1.6, the
    /// gain margins of a loop are 0.62 and 2.7. Most of that is left to the loop.
    pub const MAX_INERTIA_RATIO: f64 = 1.25;

    /// For the identified servo, its gains, and the largest command in either direction, command units; infinite for
    /// none. None if b is undetermined.
    #[must_use]
    pub fn new(servo: &IdentifiedServo, tuning: &Tuning, limit: f64) -> Option<Self> {
        /// The change of viscous friction, as a part of the loop's damping.
        const DAMPING: f64 = 0.25;
        /// The change of Coulomb friction, as a part of itself and of the step's largest command.
        const FRICTION: (f64, f64) = (0.5, 0.04);
        /// The change of the load, as a part of the largest command.
        const LOAD_SHARE: f64 = 0.1;
        let errors = ServoParameters {
            a: servo.standard_error(IdentifiedServo::A),
            b: servo.standard_error(IdentifiedServo::B),
            coulomb: servo.standard_error(IdentifiedServo::COULOMB),
            load: servo.standard_error(IdentifiedServo::LOAD),
        };
        let servo = per_gain(&servo.parameters, &errors)?;
        let [inertia, viscous, coulomb, load] = servo.map(|known| known.value);
        let largest_command = tuning.command_of_step() * tuning.predicted_response.step;
        let step = tuning.predicted_response.command_share * (limit - load.abs());
        Some(Self {
            servo,
            least: [
                inertia * (1.0 - 1.0 / Self::MAX_INERTIA_RATIO),
                DAMPING * (tuning.kd + viscous),
                (FRICTION.0 * coulomb).max(FRICTION.1 * largest_command),
                // Of the load's size: it may change its sign.
                (limit - step - load.abs()).max(LOAD_SHARE * limit),
            ],
        })
    }

    /// The first quantity in which a servo, identified with these standard errors, differs from the predicted one. None
    /// if the gains' prediction holds for it, or its estimate is too uncertain for another judgement.
    #[must_use]
    pub fn change(&self, found: &ServoParameters, errors: &ServoParameters) -> Option<ServoChange> {
        /// The largest change of the load beside one of friction, as a part of it.
        const MAX_LOAD_SHARE: f64 = 0.5;
        let found = per_gain(found, errors)?;
        // A motion that goes mostly one way shows c ± d alone.
        let moved = |i: usize| (found[i].value - self.servo[i].value).abs();
        let is_ambiguous = moved(LOAD) > MAX_LOAD_SHARE * moved(COULOMB);
        let compared = self.servo.iter().zip(&found).zip(&self.least).zip(REASONS);
        compared
            .filter(|(_, reason)| *reason != Reason::CoulombFrictionChanged || !is_ambiguous)
            .filter_map(|(((predicted, found), &least), reason)| {
                change(predicted, found, least, reason)
            })
            .next()
    }
}

fn change(predicted: &Known, found: &Known, least: f64, reason: Reason) -> Option<ServoChange> {
    let size = match reason {
        Reason::LoadChanged => found.value.abs() - predicted.value.abs(),
        // The other way it is larger by the same ratio.
        Reason::InertiaChanged if found.value > predicted.value => {
            (found.value - predicted.value) * predicted.value / found.value
        }
        _ => (found.value - predicted.value).abs(),
    };
    let error = libm::hypot(predicted.error, found.error);
    let distance = (found.value - predicted.value).abs() / error;
    // NaN fails both.
    (size > least && distance > CommissionedServo::CERTAIN).then_some(ServoChange {
        reason,
        predicted: predicted.value,
        found: found.value,
        standard_errors: distance.min(f64::MAX),
    })
}

/// 1/b, a/b, c/b and d/b with their standard errors. The errors of both are taken as independent. The error of a
/// ratio is then too large, not too small, if both increase together. None if b is undetermined.
fn per_gain(servo: &ServoParameters, errors: &ServoParameters) -> Option<[Known; 4]> {
    /// The largest relative error of b with which a ratio still has a standard error.
    const MAX_RELATIVE_ERROR: f64 = 0.2;
    let part = errors.b / servo.b;
    let is_known = servo.b > 0.0 && part < MAX_RELATIVE_ERROR;
    let ratio = |value: f64, error: f64| Known {
        value: value / servo.b,
        error: libm::hypot(error, value * part) / servo.b,
    };
    is_known.then(|| {
        [
            ratio(1.0, 0.0),
            ratio(servo.a, errors.a),
            ratio(servo.coulomb, errors.coulomb),
            ratio(servo.load, errors.load),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use identifier_core::tuning::{Goal, TuningSettings};

    const SERVO: ServoParameters = ServoParameters::new(0.5, 250.0, 50.0, 25.0);

    const ERRORS: ServoParameters = ServoParameters::new(0.1, 0.5, 1.0, 1.0);

    const LIMIT: f64 = 10.0;

    fn predicted() -> CommissionedServo {
        let errors = IdentifiedServo::known(ERRORS, 0.0).values();
        let servo = IdentifiedServo {
            unexplained: 1e-4,
            ..IdentifiedServo::known(SERVO, 0.0).with_errors(errors)
        };
        let mut settings = TuningSettings::new(1e-3, 1e-4, LIMIT, 0.1);
        settings.goal = Goal::Bandwidth(40.0);
        let tuning = settings.tune(&servo).expect("gains");
        CommissionedServo::new(&servo, &tuning, LIMIT).expect("known")
    }

    /// A change of the servo whose standard errors are those of the predicted one times a factor.
    fn change_to(servo: ServoParameters, errors: f64) -> Option<Reason> {
        let errors = ServoParameters::from_fn(|of| errors * ERRORS.get(of));
        predicted()
            .change(&servo, &errors)
            .map(|change| change.reason)
    }

    /// All accelerations of a servo with another inertia.
    fn with_inertia(factor: f64) -> ServoParameters {
        ServoParameters::from_fn(|of| SERVO.get(of) / factor)
    }

    #[test]
    fn a_mass_changes_the_inertia_alone_and_a_small_one_nothing() {
        for factor in [0.2, 0.5, 0.75, 1.3, 2.0, 5.0] {
            let change = change_to(with_inertia(factor), 1.0);
            assert_eq!(change, Some(Reason::InertiaChanged), "{factor}");
        }
        for factor in [0.85, 1.0, 1.2] {
            assert_eq!(change_to(with_inertia(factor), 1.0), None, "{factor}");
        }
    }

    #[test]
    fn a_change_within_the_errors_is_none() {
        assert_eq!(change_to(with_inertia(2.0), 60.0), None);
        // b that is not known has no ratios.
        assert_eq!(change_to(with_inertia(2.0), 1e9), None);
        assert_eq!(change_to(with_inertia(2.0), f64::NAN), None);
        assert_eq!(change_to(with_inertia(f64::NAN), 1.0), None);
        // Six standard errors decide where the estimate is poor.
        assert!(change_to(with_inertia(1.4), 10.0).is_some());
        assert_eq!(change_to(with_inertia(1.4), 20.0), None);
    }

    #[test]
    fn frictions_and_load_are_told_apart() {
        let doubled = ServoParameters {
            coulomb: 2.0 * SERVO.coulomb,
            ..SERVO
        };
        let changed = change_to(doubled, 1.0);
        assert_eq!(changed, Some(Reason::CoulombFrictionChanged));
        // Motion one way shows c + d alone.
        let ambiguous = ServoParameters {
            load: SERVO.load - SERVO.coulomb,
            ..doubled
        };
        assert_eq!(change_to(ambiguous, 1.0), None);
        let viscous = ServoParameters { a: 40.0, ..SERVO };
        let changed = change_to(viscous, 1.0);
        assert_eq!(changed, Some(Reason::ViscousFrictionChanged));
        // Less of the command is left than a step takes.
        for load in [0.99, -0.99] {
            let loaded = ServoParameters {
                load: load * LIMIT * SERVO.b,
                ..SERVO
            };
            assert_eq!(change_to(loaded, 1.0), Some(Reason::LoadChanged));
        }
        let subtracted = ServoParameters { load: 0.0, ..SERVO };
        assert_eq!(change_to(subtracted, 1.0), None);
    }
}
