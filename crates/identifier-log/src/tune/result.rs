use identifier_core::parameters::{IdentifiedServo, ServoParameters, Unknown};

use super::effects::LoopModel;
use crate::motion_unit::{AxisKind, MotionUnit};
use crate::result::{KeptEstimate, KeptResult, Reading};
use crate::verdict::VerdictReason;

/// The servo in the result of a run or a replay, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedResult {
    /// The servo, with the covariance of what was identified and all of its effects.
    pub model: LoopModel,
    /// Its axis: gains are for a unit of position that is stated.
    pub axis: AxisKind,
    /// The load, rad/s².
    pub load: WithError,
    /// The effects that were identified.
    pub effects: KnownEffects,
    /// True if a delay was identified.
    pub has_delay: bool,
    /// Sample time, s.
    pub sample_time: f64,
    /// Standard deviation of the measured position's noise in motion, rounding included, rad; none where it is not known.
    pub noise: Option<f64>,
    /// How the columns of its log were read.
    pub reading: Option<Reading>,
    /// The reason why nothing should be built on it, if there is one.
    pub reservation: Option<String>,
}

/// A fault of a result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {fault}")]
pub struct ResultError {
    /// Where.
    key: String,
    fault: String,
}

impl IdentifiedResult {
    /// From a result, read back or not.
    ///
    /// # Errors
    /// The key that is missing or holds what is not allowed.
    pub fn new(result: &KeptResult) -> Result<Self, ResultError> {
        // Results of earlier versions know rad only.
        let unit = (result.position_unit.as_deref()).map_or(
            Some(MotionUnit::Stated(AxisKind::Rotary)),
            MotionUnit::named,
        );
        let unit = unit.ok_or_else(|| missing("position_unit"))?;
        let (status, sample_time) = (&result.status, result.sample_time);
        let estimate = |name: &str| match result.estimates.get(name).copied().flatten() {
            None => Ok(None),
            Some(KeptEstimate {
                value: Some(value),
                std_error,
            }) => Ok(Some([value, std_error.unwrap_or(f64::INFINITY)])),
            Some(_) => Err(missing(&format!("estimates.{name}.value"))),
        };
        let common = |one: &str, other: &str| result.covariance.as_ref()?.of(one, other);
        let axis = unit.axis().map_err(|unstated| ResultError {
            key: "position_unit".to_owned(),
            fault: unstated.to_string(),
        })?;
        let mut assumed = result.reading.iter().flat_map(|of| &of.assumed);
        if let Some(assumed) = assumed.next() {
            return Err(ResultError {
                key: "reading.assumed".to_owned(),
                fault: format!("{assumed}; identify again with it stated"),
            });
        }
        if sample_time <= 0.0 {
            return Err(refused("sample_time", sample_time, "a number above 0"));
        }

        let known = |name: &str| -> Result<[f64; 2], ResultError> {
            Ok(estimate(name)?.unwrap_or([0.0; 2]))
        };
        let needed = |name: &str| {
            estimate(name)?.ok_or_else(|| ResultError {
                key: format!("estimates.{name}"),
                fault: "it was not identified: without it there are no gains".to_owned(),
            })
        };
        let (a, b) = (needed("a")?, needed("b")?);
        let (coulomb, load, delay) = (known("coulomb")?, known("load")?, known("delay")?);
        if b[0] <= 0.0 {
            return Err(refused("estimates.b.value", b[0], "a number above 0"));
        }
        let not_negative = [("a", a), ("coulomb", coulomb), ("delay", delay)];
        let mut covariance = [[0.0; 5]; 5];
        let places = [
            (IdentifiedServo::A, "a", a),
            (IdentifiedServo::B, "b", b),
            (IdentifiedServo::COULOMB, "coulomb", coulomb),
            (IdentifiedServo::DELAY, "delay", delay),
            (IdentifiedServo::LOAD, "load", load),
        ];
        // An unknown one is reported below.
        let finite = places.iter().filter(|(.., [_, error])| error.is_finite());
        for &(row, one, [_, error]) in finite.clone() {
            for &(column, other, _) in finite.clone() {
                covariance[row][column] = match row == column {
                    true => error * error,
                    false => common(one, other).unwrap_or(0.0),
                };
            }
        }
        /// The standard error of b, as a part of it, up to which a partially identified servo gets gains.
        const SURE: f64 = 0.04;
        // A rough answer is one of b, whatever its error: the gains bear all of its interval.
        let is_rough = result.code == VerdictReason::ROUGH;
        let is_partial = status == "partial" && (is_rough || b[1] <= SURE * b[0]);
        let reservation = if status == "converged" || is_partial {
            let unsure = [("a", a), ("b", b), ("delay", delay)];
            let unsure = unsure
                .into_iter()
                .find(|(_, [_, error])| !error.is_finite());
            unsure.map(|(name, _)| {
                format!("estimates.{name}.std_error: the standard error is missing")
            })
        } else {
            Some(format!("status = \"{status}\": {}", result.reason))
        };
        // An estimate may pass its bound by its own error.
        for (name, [value, error]) in not_negative {
            if value < -3.0 * error {
                let key = format!("estimates.{name}.value");
                return Err(refused(&key, value, "a number of at least 0"));
            }
        }
        let mut model = LoopModel::new(IdentifiedServo {
            parameters: ServoParameters {
                a: a[0].max(0.0),
                b: b[0],
                coulomb: coulomb[0].max(0.0),
                load: load[0],
            },
            delay: delay[0].max(0.0),
            covariance,
            unexplained: result.residual.and_then(|of| of.rms).unwrap_or(0.0),
        });
        let mut estimates = Vec::new();
        for unknown in Unknown::ALL {
            if let Some([value, _]) = estimate(unknown.name())? {
                estimates.push((unknown, value));
            }
        }
        let fit = result.fit.as_ref();
        let effects = fit.map_or(&[][..], |fit| &fit.effects);
        model
            .take(effects, &estimates)
            .map_err(|name| ResultError {
                key: "fit.effects".to_owned(),
                fault: format!(
                    "{name} is no effect that this version knows: identify the log again"
                ),
            })?;
        let second_modes = fit.and_then(|fit| fit.second_modes.as_deref());
        model.hide(second_modes.unwrap_or_default());
        let reservation = reservation.or_else(|| model.refusal.clone());
        Ok(Self {
            model,
            axis,
            load,
            effects: KnownEffects {
                gravity: [known("gravity-sine")?, known("gravity-cosine")?],
                ripple: [known("ripple-sine")?, known("ripple-cosine")?],
                dead_band: known("dead-band")?,
            },
            has_delay: estimate("delay")?.is_some(),
            sample_time,
            noise: result.noise.moving,
            reading: result.reading.clone(),
            reservation,
        })
    }
}

fn missing(key: &str) -> ResultError {
    ResultError {
        key: key.to_owned(),
        fault: "the motion does not determine it: nothing can be built on it".to_owned(),
    }
}

fn refused(key: &str, value: f64, allowed: &str) -> ResultError {
    ResultError {
        key: key.to_owned(),
        fault: format!("{value} is not allowed: it must be {allowed}"),
    }
}

/// An estimate and its standard error, infinite where that is not known.
pub type WithError = [f64; 2];

/// Sizes of the effects that a feed-forward can compensate, zero where they were not identified.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct KnownEffects {
    /// g_s and g_c, rad/s².
    pub gravity: [WithError; 2],
    /// r_s and r_c, rad/s².
    pub ripple: [WithError; 2],
    /// δ, command units.
    pub dead_band: WithError,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tune::{Conditions, KnownConditions, Tuned};
    use identifier_core::tuning::Goal;

    const RESULT: &str = r#"{
        "status": "converged", "reason": "it keeps still", "sample_time": 0.001,
        "estimates": {
            "a": { "value": 0.2, "std_error": 0.01 },
            "b": { "value": 250.0, "std_error": 0.5 },
            "coulomb": { "value": -0.01, "std_error": 0.02 },
            "load": null,
            "delay": { "value": 0.0012, "std_error": 0.00001 },
            "gravity-sine": { "value": 3.0, "std_error": 0.1 }
        },
        "covariance": {
            "names": ["b", "a", "delay"],
            "matrix": [[0.25, 0.004, null], [0.004, 0.0001, -2e-8], [null, -2e-8, 1e-10]]
        }
    }"#;

    fn read(text: &str) -> Result<IdentifiedResult, String> {
        let kept = KeptResult::read(text).map_err(|error| error.to_string())?;
        IdentifiedResult::new(&kept).map_err(|error| error.to_string())
    }

    #[test]
    fn the_values_of_a_result_are_taken() {
        let result = read(RESULT).expect("a result");
        let servo = result.model.servo;
        assert_eq!(servo.parameters, ServoParameters::new(0.2, 250.0, 0.0, 0.0));
        assert!((servo.standard_error(IdentifiedServo::B) - 0.5).abs() < 1e-12);
        assert!((servo.delay - 0.0012).abs() < 1e-12 && result.has_delay);
        let (a, b, delay) = (
            IdentifiedServo::A,
            IdentifiedServo::B,
            IdentifiedServo::DELAY,
        );
        let pairs = [(a, b), (b, a), (a, delay), (b, delay)];
        let found = pairs.map(|(one, other)| servo.covariance[one][other].to_bits());
        assert_eq!(found, [0.004, 0.004, -2e-8, 0.0].map(f64::to_bits));
        assert!((result.effects.gravity[0][0] - 3.0).abs() < 1e-12);
        assert_eq!(result.reservation, None);
    }

    #[test]
    fn objections_to_a_result_are_reported() {
        for (from, to, part) in [
            (
                "\"converged",
                "\"moving",
                "status = \"moving\": it keeps still",
            ),
            ("0.5", "null", "estimates.b.std_error"),
        ] {
            let text = RESULT.replace(from, to);
            let reservation = read(&text).expect("a result").reservation;
            assert!(reservation.expect("a doubt").contains(part), "{to}");
        }
    }

    #[test]
    fn a_rough_answer_gets_gains_for_all_of_its_interval() {
        let rough = |code: u8| {
            RESULT
                .replace(r#""converged""#, &format!(r#""partial", "code": {code}"#))
                .replace(r#""std_error": 0.5"#, r#""std_error": 25.0"#)
        };
        let of_fit = read(&rough(23)).expect("a result");
        assert!(of_fit.reservation.is_some());
        let result = read(&rough(50)).expect("a result");
        assert_eq!(result.reservation, None);
        let known = KnownConditions {
            resolution: Some(1e-3),
            limit: Some([-10.0, 10.0]),
            ..KnownConditions::default()
        };
        let stated = Conditions {
            resonance: Some(f64::INFINITY),
            ..Conditions::default()
        };
        let settings = stated.settings(Goal::Stiffest, &result, &known);
        let tuned = Tuned::new(&result, None, &settings.expect("settings")).expect("gains");
        let sure = tuned.bandwidth_without_errors().expect("a cost");
        assert!(sure > 1.05 * tuned.tuning.bandwidth, "{sure}");
    }

    #[test]
    fn a_document_that_is_no_result_is_refused_by_key() {
        for (from, to, key) in [
            ("{", "{,", "line 1"),
            (r#""status": "converged","#, "", "`status`"),
            ("0.001,", r#""x","#, "line 2"),
            ("0.001,", "0.0,", "sample_time: 0 is not allowed"),
            (r#""estimates""#, r#""others""#, "`estimates`"),
            (r#""value": 0.2"#, r#""value": null"#, "estimates.a.value: "),
            ("\"b\": {", "\"c\": {", "estimates.b: it was not identified"),
            ("250.0", "-250.0", "estimates.b.value: -250 is not allowed"),
            ("-0.01", "-0.1", "estimates.coulomb.value: -0.1 is"),
        ] {
            let text = RESULT.replacen(from, to, 1);
            let refused = read(&text).expect_err(to);
            assert!(refused.contains(key), "{refused}");
        }
    }
}
