//! Gains from the result of an identification.
//!
//! result.json → [`IdentifiedResult`]. With [`Conditions`] from options and scenario → the core's tuner → [`Tuned`],
//! and for a drive's firmware → [`Form`].

mod conditions;
mod effects;
mod form;
mod known_forces;
mod result;

pub use conditions::{CommandDirection, ConditionError, Conditions, EncoderMass, KnownConditions};
pub use effects::{Bound, LoopModel};
pub use form::Form;
pub use known_forces::Angle;
pub use result::{IdentifiedResult, KnownEffects, ResultError, WithError};

use identifier_core::tuning::{Cap, Goal, StepMeasure, Tuner, Tuning, TuningError, TuningSettings};

use crate::result::{
    DelayedServo, FeedForward, FirstTrial, FormResult, FoundMode, Gains, KeptResult, KnownForces,
    Reading, StiffPrediction, Summary, TuningConditions, TuningResult,
};
use crate::scenario::Options;

/// Gains, and what they were found for.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuned {
    /// The servo, with its effects.
    pub model: LoopModel,
    /// How the columns of its log were read.
    pub reading: Option<Reading>,
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
    /// The part of the bandwidth to begin with.
    const FIRST_TRIAL: f64 = 0.25;

    /// Tunes for a result with its angle, if it has one.
    ///
    /// # Errors
    /// The reason why there are no gains.
    pub fn new(
        result: &IdentifiedResult,
        angle: Option<&Angle>,
        settings: &TuningSettings,
    ) -> Result<Self, NoGains> {
        let model = &result.model;
        let delay = model.servo.delay + settings.command_delay;
        let forces = known_forces::known_forces(result, angle, delay);
        let tuning = model.tune(settings).map_err(|error| match error {
            TuningError::TooFast { most, cap, .. } => {
                let goal = Goal::Bandwidth(most);
                let slower = model.tune(&TuningSettings { goal, ..*settings });
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
            model: model.clone(),
            reading: result.reading.clone(),
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
        let mut sure = self.model.clone();
        sure.servo.covariance = [[0.0; 5]; 5];
        let bandwidth = sure.tune(&self.settings).ok()?.bandwidth;
        (bandwidth > 1.05 * self.tuning.bandwidth).then_some(bandwidth)
    }

    /// The same goal for a command without a limit; none where that changes nothing, or there are none.
    #[must_use]
    pub fn without_limit(&self) -> Option<Tuning> {
        let settings = TuningSettings {
            command: f64::INFINITY,
            ..self.settings
        };
        let tuning = self.model.tune(&settings).ok()?;
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
        let Some(form) = conditions.form else {
            return Self::new(result, known.angle.as_ref(), settings);
        };
        let mut tuned = form.tune(result, known, conditions, settings)?;
        let goal = Goal::Bandwidth(Self::FIRST_TRIAL * tuned.tuning.bandwidth);
        let slower = TuningSettings { goal, ..*settings };
        let first = form.tune(result, known, conditions, &slower).ok();
        if let (Some(own), Some(first)) = (&mut tuned.form, first.and_then(|first| first.form)) {
            own.first_trial = first.parameters;
        }
        Ok(tuned)
    }

    /// The bandwidth of the same goal if there were no resonance that nothing has shown, rad/s; none where that is nearly the
    /// same.
    #[must_use]
    pub fn bandwidth_without_hidden(&self) -> Option<f64> {
        let settings = TuningSettings {
            resonance: Some(f64::INFINITY),
            ..self.settings
        };
        let bandwidth = self.model.tune(&settings).ok()?.bandwidth;
        (bandwidth > 1.05 * self.tuning.bandwidth).then_some(bandwidth)
    }

    /// The frequency from which on a resonance may lie that nothing has shown, rad/s; none where there is none.
    #[must_use]
    pub fn hidden_from(&self) -> Option<f64> {
        let stated = self.settings.resonance;
        let finite = |frequency: &f64| frequency.is_finite();
        stated
            .map_or_else(|| self.model.hidden_from(), Some)
            .filter(finite)
    }

    /// Gains to begin with: those for a quarter of the bandwidth.
    #[must_use]
    pub fn first_trial(&self) -> Option<Tuning> {
        let settings = TuningSettings {
            goal: Goal::Bandwidth(Self::FIRST_TRIAL * self.tuning.bandwidth),
            feed_forward: false,
            ..self.settings
        };
        self.model.tune(&settings).ok()
    }

    /// The shortest and the longest time in which a step settles, s: with what earlier motions leave of friction in the
    /// integral. Infinite where it does not.
    #[must_use]
    pub fn settling_times(&self) -> [f64; 2] {
        /// Time for which a step is followed, 1/ω.
        const FOLLOWED: f64 = 100.0;
        let (settings, tuning) = (&self.settings, &self.tuning);
        let until = FOLLOWED / tuning.bandwidth;
        let settled = |share: f64| {
            let steps = self.tuner().ok()?.step_after(tuning, share).ok()?;
            let mut measure = StepMeasure::<f64>::new(settings.step, settings.resolution);
            let mut last = [0.0; 2];
            for sample in steps.take_while(|sample| sample.time < until) {
                measure.take(sample.position);
                last = [last[1], sample.time];
            }
            Some(f64::from(measure.settled()?) * (last[1] - last[0]))
        };
        let times = [-1.0, 0.0, 1.0].map(|share| settled(share).unwrap_or(f64::INFINITY));
        let most = times.into_iter().fold(0.0, f64::max);
        [times.into_iter().fold(f64::INFINITY, f64::min), most]
    }

    /// The tuner that found them.
    ///
    /// # Errors
    /// None for what was tuned.
    pub fn tuner(&self) -> Result<Tuner, TuningError> {
        self.model.tuner(&self.settings)
    }

    /// The feed-forward of the reference's motion.
    #[must_use]
    pub fn feed_forward(&self) -> FeedForward {
        let hold = self.settings.sample_time / 2.0;
        FeedForward::of_servo(
            &self.model.servo.parameters,
            &self.forces,
            self.tuning.kd,
            hold,
        )
    }

    /// The result.
    #[must_use]
    pub fn result(&self) -> TuningResult {
        let (servo, settings, tuning) = (&self.model.servo, &self.settings, &self.tuning);
        TuningResult {
            sample_time: settings.sample_time,
            gains: Gains::tuned(tuning),
            bandwidth: tuning.bandwidth,
            cap: tuning.cap.map(Cap::name),
            predicted_response: StiffPrediction {
                predicted_response: tuning.predicted_response,
                stiffness: 1.0 / tuning.predicted_response.compliance,
            },
            settling_times: self.settling_times(),
            first_trial: self.first_trial().map(|tuning| FirstTrial {
                gains: Gains::tuned(&tuning),
                step: tuning.predicted_response.step,
                rise_time: tuning.predicted_response.rise_time,
                overshoot: tuning.predicted_response.overshoot,
            }),
            resonance: self.model.resonance.map(|of| FoundMode {
                rad_per_s: of.mode.frequency,
                damping: of.mode.damping,
                ratio: of.mode.ratio,
            }),
            hidden_from: self.hidden_from(),
            reading: self.reading.clone(),
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
