//! Gains from the result of an identification.
//!
//! result.json → [`IdentifiedResult`]. With [`Conditions`] from options and scenario → the core's tuner → [`Tuned`],
//! and for a drive's firmware → [`Form`].

mod conditions;
mod form;
mod known_forces;
mod result;

pub use conditions::{ConditionError, Conditions, KnownConditions};
pub use form::Form;
pub use known_forces::Angle;
pub use result::{IdentifiedResult, KnownEffects, ResultError, WithError};

use identifier_core::parameters::IdentifiedServo;
use identifier_core::tuning::{Cap, Goal, Tuner, Tuning, TuningError, TuningSettings};

use crate::result::{
    DelayedServo, FeedForward, FormResult, Gains, KeptResult, KnownForces, StiffPrediction,
    Summary, TuningConditions, TuningResult,
};
use crate::scenario::Options;

/// Gains, and what they were found for.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// The servo.
    pub servo: IdentifiedServo,
    /// The known forces beside inertia and friction.
    pub forces: KnownForces,
    /// The goal and its conditions.
    pub settings: TuningSettings,
    /// The gains.
    pub tuning: Tuning,
    /// The same in the form of a drive's firmware, where that was asked for.
    pub form: Option<FormResult>,
}

/// The reason why there are no gains.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoGains {
    /// The core's rejection.
    #[error(transparent)]
    Error(TuningError),
    /// They do not get the form of the drive, in a sentence.
    #[error("{0}")]
    Form(String),
    /// A smaller one is possible.
    #[error("{cap} allows {most:.2} rad/s")]
    TooFast {
        /// The reason why it is not faster.
        cap: Cap,
        /// The largest bandwidth, rad/s.
        most: f64,
        /// The predicted rise time, s.
        rise_time: Option<f64>,
    },
}

impl Tuned {
    /// Tunes for a result with its angle, if it has one.
    ///
    /// # Errors
    /// The reason why there are no gains.
    pub fn new(
        result: &IdentifiedResult,
        angle: Option<&Angle>,
        settings: &TuningSettings,
    ) -> Result<Self, NoGains> {
        let delay = result.servo.delay + settings.command_delay;
        let forces = known_forces::known_forces(result, angle, delay);
        let tuning = settings.tune(&result.servo).map_err(|error| match error {
            TuningError::TooFast { most, cap, .. } => {
                let goal = Goal::Bandwidth(most);
                let slower = TuningSettings { goal, ..*settings }.tune(&result.servo);
                NoGains::TooFast {
                    cap,
                    most,
                    rise_time: slower
                        .ok()
                        .map(|tuning| tuning.predicted_response.rise_time),
                }
            }
            error => NoGains::Error(error),
        })?;
        Ok(Self {
            servo: result.servo,
            forces,
            settings: *settings,
            tuning,
            form: None,
        })
    }

    /// The stiffest gains for the result of a scenario, under the conditions that these hold.
    ///
    /// # Errors
    /// Why there are none, without an end.
    pub fn stiffest(
        scenario: &Options,
        summary: &Summary,
    ) -> Result<(Self, KnownConditions), String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let kept = KeptResult::from(summary);
        let result = IdentifiedResult::new(&kept).map_err(|error| text(&error))?;
        if result.reservation.is_some() {
            return Err("gains for an unidentified servo would be a guess".to_owned());
        }
        let known = KnownConditions::of_logs(scenario, &kept, result.has_delay);
        let settings = Conditions::default().settings(Goal::Stiffest, &result, &known);
        let settings = settings.map_err(|error| text(&error))?;
        let tuned = Self::new(&result, known.angle.as_ref(), &settings);
        Ok((tuned.map_err(|error| text(&error))?, known))
    }

    /// The bandwidth of the same goal if the estimates had no errors, rad/s; none where that is nearly the same.
    #[must_use]
    pub fn bandwidth_without_errors(&self) -> Option<f64> {
        let sure = IdentifiedServo {
            covariance: [[0.0; 5]; 5],
            ..self.servo
        };
        let bandwidth = self.settings.tune(&sure).ok()?.bandwidth;
        (bandwidth > 1.05 * self.tuning.bandwidth).then_some(bandwidth)
    }

    /// The same goal for a command without a limit; none where that changes nothing, or there are none.
    #[must_use]
    pub fn without_limit(&self) -> Option<Tuning> {
        let settings = TuningSettings {
            command: f64::INFINITY,
            ..self.settings
        };
        let tuning = settings.tune(&self.servo).ok()?;
        (tuning.kp > 1.01 * self.tuning.kp).then_some(tuning)
    }

    /// Tunes for a result in the form that the conditions state, if they do.
    ///
    /// # Errors
    /// The reason why there are no gains, or none in that form.
    pub fn of_conditions(
        result: &IdentifiedResult,
        known: &KnownConditions,
        conditions: &Conditions,
        settings: &TuningSettings,
    ) -> Result<Self, NoGains> {
        match conditions.form {
            Some(form) => form.tune(result, known, conditions, settings),
            None => Self::new(result, known.angle.as_ref(), settings),
        }
    }

    /// The tuner that found them.
    ///
    /// # Errors
    /// None for what was tuned.
    pub fn tuner(&self) -> Result<Tuner, TuningError> {
        Tuner::new(&self.settings, &self.servo)
    }

    /// The feed-forward of the reference's motion.
    #[must_use]
    pub fn feed_forward(&self) -> FeedForward {
        let hold = self.settings.sample_time / 2.0;
        FeedForward::of_servo(&self.servo.parameters, &self.forces, self.tuning.kd, hold)
    }

    /// The result.
    #[must_use]
    pub fn result(&self) -> TuningResult {
        let (servo, settings, tuning) = (&self.servo, &self.settings, &self.tuning);
        TuningResult {
            sample_time: settings.sample_time,
            gains: Gains::tuned(tuning),
            bandwidth: tuning.bandwidth,
            cap: tuning.cap.map(Cap::name),
            predicted_response: StiffPrediction {
                predicted_response: tuning.predicted_response,
                stiffness: 1.0 / tuning.predicted_response.compliance,
            },
            feed_forward: self.feed_forward(),
            form: self.form.clone(),
            servo: DelayedServo {
                parameters: servo.parameters,
                delay: servo.delay,
            },
            conditions: TuningConditions {
                resolution: settings.resolution,
                command: settings.command,
                command_delay: settings.command_delay,
                most_sensitivity: settings.max_sensitivity,
                most_noise: settings.max_noise,
                resonance: settings.resonance,
            },
        }
    }
}
