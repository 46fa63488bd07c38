//! The step that gains are looked for with, and that is to try them.

use super::super::message::Candidate;
use super::CommissionSolver;
use identifier_core::number::Number;
use identifier_core::parameters::IdentifiedServo;
use identifier_core::tuning::Tuning;

impl<N: Number, const W: usize> CommissionSolver<N, W> {
    /// The part of the travel in its direction that the trial's step takes where none is given.
    const STEP: f64 = 0.25;

    /// The part that it takes where the encoder has few counts in that.
    const MAX_STEP: f64 = Candidate::<N>::MAX_END;

    /// The part of the largest speed that the trial's step may reach.
    const OF_SPEED: f64 = 0.7;

    /// The part of the command that it may ask for.
    const OF_COMMAND: f64 = 0.5;

    /// Minimum counts of a step that resolve an overshoot and a rise.
    const MIN_STEP_COUNTS: f64 = 40.0;

    /// The step of the trial for gains: within speed, command and travel, and seen well by the encoder.
    pub(super) fn step_for(&self, tuning: &Tuning, servo: &IdentifiedServo) -> f64 {
        let limits = &self.settings.limits;
        let speed = Self::OF_SPEED * limits.speed / tuning.speed_of_step();
        let command = Self::OF_COMMAND * self.command(servo) / tuning.command_of_step();
        let wanted = match self.settings.trial_step {
            Some(step) => step.min(speed),
            None => self.room().min(speed).min(command),
        };
        wanted.max(self.step)
    }

    /// The step that gains are looked for with: so small that it binds neither speed nor command.
    pub(super) fn first_step(&self) -> f64 {
        let least = self.least_step().min(self.room());
        self.settings.trial_step.unwrap_or(least)
    }

    fn least_step(&self) -> f64 {
        Self::MIN_STEP_COUNTS * self.settings.resolution
    }

    /// The largest step within the travel, rad.
    fn room(&self) -> f64 {
        let [low, high] = self.settings.limits.travel;
        let farthest = high.max(-low);
        (Self::STEP * farthest).max(self.least_step().min(Self::MAX_STEP * farthest))
    }

    /// The largest possible step, rad, from one side of the start to the other. It is for a servo that friction holds
    /// through a smaller one.
    pub(super) fn most_room(&self) -> f64 {
        let [low, high] = self.settings.limits.travel;
        Self::MAX_STEP * (high - low)
    }

    /// The command that is left when the load is held.
    pub(super) fn command(&self, servo: &IdentifiedServo) -> f64 {
        let [low, high] = self.settings.limits.command;
        high.min(-low) - libm::fabs(servo.parameters.load / servo.parameters.b)
    }
}
