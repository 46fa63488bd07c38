use super::gains::{HoldingGains, Loop};
use super::trial::Trial;
use super::{CommissionSettings, IdentifiedServo};
use crate::error::OutOfRange;
use crate::number::Number;
use crate::tuning::Tuning;
use crate::units::Units;

/// Gains that are to be tried, and their trial in machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate<N: Number> {
    /// The gains and what they promise, SI.
    pub tuning: Tuning,
    pub(super) controller: Loop<N>,
    pub(super) trial: Trial<N>,
    /// Samples for which the servo must be still to have come to rest under them.
    pub(super) rest: u32,
}

impl<N: Number> Candidate<N> {
    /// The part of what is left of the travel that a disturbance may move the servo.
    const OF_ROOM: f64 = 0.2;

    /// The part of the command that disturbs the servo in the trial.
    const DISTURBANCE: f64 = 0.1;

    /// # Errors
    /// A gain that no controller has.
    pub(super) fn of(
        tuning: &Tuning,
        servo: &IdentifiedServo,
        settings: &CommissionSettings,
    ) -> Result<Self, OutOfRange> {
        let units = Units::new(settings.sample_time, settings.resolution)?;
        let limits = &settings.limits;
        let promise = &tuning.promise;
        let [low, high] = limits.travel;
        let step = if high < -low {
            -promise.step
        } else {
            promise.step
        };
        let [least, most] = limits.command;
        // Back towards where the servo came from, and no further than the travel has room for.
        let left = high.max(-low) - promise.step;
        let bearable = Self::OF_ROOM * left / (promise.compliance * servo.parameters.b);
        let disturbance = (Self::DISTURBANCE * most.min(-least)).min(bearable);
        let disturbance = libm::copysign(disturbance, -step);
        // A servo that hunts about its friction is still for a while too.
        let settling = Trial::<N>::settling(tuning);
        Ok(Self {
            tuning: *tuning,
            controller: HoldingGains::tuned(tuning, limits).build(&units)?,
            trial: Trial::of(tuning, &units, step, disturbance, &servo.parameters),
            rest: (0.5 * settling / settings.sample_time) as u32,
        })
    }
}
