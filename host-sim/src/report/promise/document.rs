use identifier_core::commission::IdentifiedServo;
use identifier_core::tuning::Cap;
use serde::Serialize;

use crate::tune::Tuned;

/// The result of a tuning as the command line promises it.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct Document {
    pub sample_time: f64,
    pub kp: f64,
    pub kd: f64,
    pub ki: f64,
    pub cutoff: f64,
    pub bandwidth: f64,
    pub cap: Option<&'static str>,
    pub promise: PromiseDocument,
    pub feed_forward: FeedForwardDocument,
    pub servo: ServoDocument,
    pub conditions: ConditionsDocument,
}

/// What is promised.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct PromiseDocument {
    pub step: f64,
    pub rise_time: f64,
    pub quickest_rise_time: f64,
    pub slowest_rise_time: f64,
    pub overshoot: f64,
    pub settling_time: f64,
    pub sensitivity: f64,
    pub gain_margins: [f64; 2],
    pub command_share: f64,
    pub noise: f64,
    pub compliance: f64,
    pub stiffness: f64,
}

/// Coefficients of the reference's motion in the command, command units per SI unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct FeedForwardDocument {
    pub acceleration: f64,
    pub velocity: f64,
    pub sign: f64,
    pub constant: f64,
    pub gravity_sine: f64,
    pub gravity_cosine: f64,
    pub lead: f64,
}

/// The servo that was tuned for.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct ServoDocument {
    pub a: f64,
    pub b: f64,
    pub coulomb: f64,
    pub load: f64,
    pub delay: f64,
}

/// What was tuned under; null for no limit and for no known resonance.
#[derive(Debug, Clone, Serialize)]
#[expect(
    missing_docs,
    reason = "the fields are the keys of the result, documented in docs/command-line.md"
)]
pub struct ConditionsDocument {
    pub resolution: f64,
    pub command: Option<f64>,
    pub command_delay: f64,
    pub most_sensitivity: f64,
    pub most_noise: f64,
    pub resonance: Option<f64>,
}

impl Document {
    /// The document of a tuning.
    #[must_use]
    pub fn new(tuned: &Tuned) -> Self {
        let Tuned {
            servo,
            settings,
            tuning,
            ..
        } = tuned;
        let promise = &tuning.promise;
        let finite = |value: f64| value.is_finite().then_some(value);
        Self {
            sample_time: settings.sample_time,
            kp: tuning.kp,
            kd: tuning.kd,
            ki: tuning.ki,
            cutoff: tuning.cutoff,
            bandwidth: tuning.bandwidth,
            cap: tuning.cap.map(Cap::name),
            promise: PromiseDocument {
                step: promise.step,
                rise_time: promise.rise_time,
                quickest_rise_time: promise.quickest_rise_time,
                slowest_rise_time: promise.slowest_rise_time,
                overshoot: promise.overshoot,
                settling_time: promise.settling_time,
                sensitivity: promise.sensitivity,
                gain_margins: promise.gain_margins,
                command_share: promise.command_share,
                noise: promise.noise,
                compliance: promise.compliance,
                stiffness: 1.0 / promise.compliance,
            },
            feed_forward: FeedForwardDocument::new(tuned),
            servo: ServoDocument {
                a: servo.parameters.a,
                b: servo.parameters.b,
                coulomb: servo.parameters.coulomb,
                load: servo.parameters.load,
                delay: servo.delay,
            },
            conditions: ConditionsDocument {
                resolution: settings.resolution,
                command: finite(settings.command),
                command_delay: settings.command_delay,
                most_sensitivity: settings.max_sensitivity,
                most_noise: settings.max_noise,
                resonance: settings.resonance,
            },
        }
    }
}

impl FeedForwardDocument {
    /// Of a tuning.
    #[must_use]
    pub fn new(tuned: &Tuned) -> Self {
        let settings = &tuned.settings;
        Self::of(
            &tuned.servo,
            tuned.gravity,
            tuned.tuning.kd,
            settings.command_delay + settings.sample_time / 2.0,
        )
    }

    /// Of a servo with `gravity`, rad/s², under a derivative gain, command units per rad/s; `late` is the delay
    /// that was not identified, with that of the hold, s.
    #[must_use]
    pub fn of(
        servo: &IdentifiedServo,
        [sine, cosine]: [f64; 2],
        derivative: f64,
        late: f64,
    ) -> Self {
        let parameters = servo.parameters;
        let b = parameters.b;
        Self {
            acceleration: 1.0 / b,
            velocity: parameters.a / b + derivative,
            sign: parameters.coulomb / b,
            // Without a zero's sign.
            constant: 0.0 - parameters.load / b,
            gravity_sine: 0.0 - sine / b,
            gravity_cosine: 0.0 - cosine / b,
            lead: servo.delay + late,
        }
    }
}
