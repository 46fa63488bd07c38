//! The step response of a loop, by the simulator's exact position.

use identifier_core::Settings;
use std::f64::consts::TAU;
use virtual_servo::{Effects, SensorEffects};

use commissioning::HoldingGains;
use identifier_core::control::{ControlState, Controller, Setpoint, Shaped};
use identifier_core::measurement::LowPass;
use identifier_core::settings::{ControllerSettings, SettingsError};

use super::{CommissionedAxis, Outcome};
use crate::scenario::{Fault, Scenario};

/// A servo under gains that follows a step of its reference, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct StepResponse {
    sample_time: f64,
    step: f64,
    /// Position from where it stood, a part of the step, sample by sample from the step on.
    done: Vec<f64>,
}

impl StepResponse {
    /// The response of the identified servo under the gains that were found, with an encoder without edges. None if no
    /// gains were found.
    #[must_use]
    pub fn predicted(scenario: &Scenario, outcome: &Outcome) -> Option<Self> {
        /// Counts in a count of the scenario's encoder.
        const FINER: f64 = 64.0;
        let servo = outcome.servo()?;
        let mut predicted = scenario.clone();
        predicted.plant = Some(servo.parameters);
        predicted.effects = Effects {
            delay: servo.delay.clamp(0.0, Effects::MAX_DELAY),
            ..Effects::NONE
        };
        predicted.sensor = SensorEffects::default();
        predicted.faults = Vec::new();
        predicted.set_encoder(FINER * TAU / scenario.stated.resolution);
        Self::of_outcome(&predicted, outcome)
    }

    /// The response of the true servo under the gains that were found; none if none were found.
    #[must_use]
    pub fn in_truth(scenario: &Scenario, outcome: &Outcome) -> Option<Self> {
        Self::of_outcome(scenario, outcome)
    }

    fn of_outcome(scenario: &Scenario, outcome: &Outcome) -> Option<Self> {
        /// Settling times for which a servo is watched, and s besides.
        const WATCHED: (f64, f64) = (4.0, 0.1);
        /// The longest settling time that is simulated, in 1/ω. The slow pole's part has then decayed to a 400th.
        const SLOWEST: f64 = 30.0;
        let tuning = outcome.tuning.as_ref()?;
        let limits = scenario.commission_settings().ok()?.limits;
        let gains = HoldingGains {
            controller: ControllerSettings::tuned(tuning, limits.command),
            cutoff: tuning.cutoff,
        };
        let step = outcome
            .trial
            .map_or(tuning.predicted_response.step, |trial| trial.step);
        // A servo that friction holds may never come as near as settling asks for.
        let settling = (tuning.predicted_response.settling_time).min(SLOWEST / tuning.bandwidth);
        let (times, besides) = WATCHED;
        Self::new(scenario, &gains, step, times * settling + besides).ok()
    }

    /// Simulates a scenario's servo, encoder included, for a time (s). It starts at standstill, and the integral
    /// balances the load, as in a trial.
    ///
    /// # Errors
    /// The key that it cannot be built from.
    fn new(
        scenario: &Scenario,
        gains: &HoldingGains,
        step: f64,
        lasting: f64,
    ) -> Result<Self, Fault> {
        let settings = Settings {
            cutoff: gains.cutoff,
            controller: Some(gains.controller),
            ..scenario.stated
        };
        let controller: Result<Controller<f64, LowPass<f64>, Shaped<f64>>, SettingsError> =
            settings.build();
        let controller = controller.map_err(|error| scenario.fault(&error))?;
        let units = scenario.checked_units()?;
        let sample_time = units.sample_time();
        let mut axis = CommissionedAxis::new(scenario)?.held();
        let ki = gains.controller.ki;
        let integral = match ki > 0.0 {
            true => axis.balance() / (ki * sample_time) * units.position(),
            false => 0.0,
        };
        let mut state = ControlState::default().with_integral(integral);
        let mut before = axis.sense().count.unwrap_or(0);
        let first = before;
        let mut advance = |axis: &mut CommissionedAxis| {
            let count = axis.sense().count.unwrap_or(before);
            let moved = f64::from(count.wrapping_sub(before));
            before = count;
            let setpoint = Setpoint {
                count: first,
                offset: step * units.position(),
            };
            let error = setpoint.error(count);
            let sample = controller.process(&mut state, error, moved);
            // A loop that has run away beyond what it can count goes nowhere any more.
            axis.advance(sample.map_or(0.0, |sample| sample.command));
        };
        let from = axis.position();
        let mut done = Vec::new();
        for _ in 0..(lasting / sample_time).ceil() as u64 {
            done.push((axis.position() - from) / step);
            advance(&mut axis);
        }
        Ok(Self {
            sample_time,
            step,
            done,
        })
    }

    /// The step, rad.
    #[must_use]
    pub fn step(&self) -> f64 {
        self.step
    }

    /// From 10 to 90 % of the step, s; none if it did not get there.
    #[must_use]
    pub fn rise_time(&self) -> Option<f64> {
        Some(self.passes(0.9)? - self.passes(0.1)?)
    }

    /// Beyond the step, a part of it.
    #[must_use]
    pub fn overshoot(&self) -> f64 {
        let highest = self.done.iter().copied().fold(0.0, f64::max);
        (highest - 1.0).max(0.0)
    }

    /// The largest distance from the step in the last quarter of the time, a part of it.
    #[must_use]
    pub fn left_over(&self) -> f64 {
        let last = &self.done[self.done.len() / 4 * 3..];
        last.iter()
            .map(|done| (done - 1.0).abs())
            .fold(0.0, f64::max)
    }

    /// Time since the step, s, and position from where it stood, rad.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let point = |(k, done): (usize, &f64)| (k as f64 * self.sample_time, done * self.step);
        self.done.iter().enumerate().map(point)
    }

    /// Time at which a part of the step is passed, s, on a straight line between two samples.
    fn passes(&self, level: f64) -> Option<f64> {
        let after = self.done.iter().position(|&done| done >= level)?;
        let (before, next) = (self.done[after.checked_sub(1)?], self.done[after]);
        let part = (level - before) / (next - before);
        Some((after as f64 - 1.0 + part) * self.sample_time)
    }
}
