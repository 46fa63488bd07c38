//! Behaviour of a design: its step with the identified servo, and its displacement by a load. Also the overshoot of the
//! other possible servos.

use core::f64::consts::FRAC_PI_2;

use super::axis_forces::AxisForces;
use super::closed_loop::{ClosedLoop, TestSignal};
use super::margins::Margins;
use super::placement::Design;
use super::possible_servos::PossibleServos;
use super::resonance::Mode;
use super::{PredictedResponse, StepMeasure, TuningError, TuningSettings};

/// Inputs of a prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictionInputs {
    pub(super) servos: PossibleServos,
    pub(super) coulomb: f64,
    pub(super) forces: AxisForces,
    /// The mode of two masses, if a measured response shows them.
    pub(super) mode: Option<Mode>,
    pub(super) settings: TuningSettings,
}

/// A prediction in progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponsePrediction {
    design: Design,
    stage: PredictedQuantity,
    closed_loop: ClosedLoop,
    measure: StepMeasure<f64>,
    /// The largest distance from the first position, rad.
    farthest: f64,
    /// True if the predicted quantity has been reached.
    seen: bool,
    predicted_response: PredictedResponse,
}

/// The predicted quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PredictedQuantity {
    /// The step of the identified servo.
    Step,
    /// The same with other forces on the axis that there may be.
    Possible(usize),
    /// Its rise if the integral already balances friction.
    Balanced,
    /// Its rise if the integral opposes the step.
    Opposed,
    /// Its answer to a step of the load.
    Load,
    /// The overshoot of a corner.
    Corner(usize),
}

/// Time limit for a peak of the response, 1/ω: twice the peak time of an ideal step.
const TURN: f64 = 10.0;

/// The time after a step at which a breakaway gives the largest overshoot, 1/ω. The filtered reference has then
/// completed its step, and the servo follows as without the filter.
const LATE: f64 = 5.0;

/// The speed below which unknown friction at rest acts, as a part of the step's ω.
const SLIPS: f64 = 0.02;

/// The steps from the quarters of a wave.
const QUARTERS: usize = 4;

/// Times by which a step has its peak, from its arrival and from breakaway, 1/ω.
const PEAK: f64 = 5.0;
const LATE_PEAK: f64 = 7.0;

/// An overshoot beyond which a loop does not hold what changes with the angle.
const MAX_OVERSHOOT: f64 = 1.0;

/// The time for which a servo that hunts is followed, as a multiple of that of a step.
const HUNTS: f64 = 4.0;

/// Time within the band after which it has settled, 1/ω.
const SETTLED: f64 = 6.0;

impl PredictionInputs {
    /// The loop of a design that is to make the step with the identified servo.
    pub(super) fn step(&self, design: &Design) -> Result<ClosedLoop, TuningError> {
        self.step_after(design, 0.0)
    }

    /// The same with a share of the friction in the integral.
    pub(super) fn step_after(
        &self,
        design: &Design,
        share: f64,
    ) -> Result<ClosedLoop, TuningError> {
        self.closed_loop(design, 0, &self.balanced_step(share))
    }

    fn neutral_step(&self) -> TestSignal {
        TestSignal {
            step: self.settings.step,
            load: 0.0,
            coulomb: self.coulomb,
            balanced: 0.0,
            resolution: self.settings.resolution,
            command: self.settings.command,
            forces: self.forces,
        }
    }

    /// Friction at rest, rad/s².
    fn holding(&self) -> f64 {
        self.coulomb + self.forces.low_speed
    }

    /// A step by a servo whose friction the integral balances after an earlier motion. That motion was in the direction
    /// of the step for a share of one, against it for −1.
    fn balanced_step(&self, share: f64) -> TestSignal {
        TestSignal {
            balanced: share * self.holding(),
            ..self.neutral_step()
        }
    }

    /// True if friction at rest may be higher than the identified.
    fn sticks(&self) -> bool {
        self.forces.most_low_speed > self.forces.low_speed
    }

    /// The same with the highest friction at rest that there may be.
    fn with_highest_friction(&self, design: &Design) -> Self {
        let mut worst = *self;
        if self.sticks() {
            worst.forces.low_speed = self.forces.most_low_speed;
            worst.forces.per_low_speed_velocity =
                1.0 / (SLIPS * design.bandwidth * self.settings.step);
        }
        worst
    }

    /// The first of the steps from a place in their list on that there may be: with the highest friction at rest, and from the
    /// other quarters of a wave.
    fn possible_step(&self, design: &Design, place: usize) -> (PredictedQuantity, TestSignal) {
        let mut other = self.with_highest_friction(design);
        let first = match place {
            0 if self.sticks() => 0,
            _ if self.forces.has_cogging() && place < QUARTERS => place.max(1),
            _ => return (PredictedQuantity::Balanced, self.balanced_step(1.0)),
        };
        other.forces = other.forces.at_phase(FRAC_PI_2 * first as f64);
        (PredictedQuantity::Possible(first), other.neutral_step())
    }

    /// The step that overshoots most. The highest friction at rest holds the servo until [`LATE`]: the integral begins on
    /// the other side, up to what friction can hold. With a feed-forward, feed-forward and integral both compensate
    /// friction.
    fn worst_step(&self, design: &Design) -> TestSignal {
        let worst = self.with_highest_friction(design);
        if design.feed_forward.is_some() {
            return worst.balanced_step(1.0);
        }
        let b = self.servos.identified().b;
        let integrated = LATE / design.bandwidth - design.reference_filter;
        let gathered = b * self.settings.step * (design.kp + design.ki * integrated.max(0.0));
        let share = 1.0 - gathered / worst.holding().max(f64::MIN_POSITIVE);
        worst.balanced_step(share.max(-1.0))
    }

    /// One rad/s² of load, which the loop answers without friction, limit or counts.
    fn unit_load(&self) -> TestSignal {
        TestSignal {
            step: 0.0,
            load: 1.0,
            coulomb: 0.0,
            balanced: 0.0,
            resolution: 0.0,
            command: f64::INFINITY,
            forces: AxisForces::default(),
        }
    }

    pub(super) fn measure(&self) -> StepMeasure<f64> {
        StepMeasure::new(self.settings.step, self.settings.resolution)
    }

    fn closed_loop(
        &self,
        design: &Design,
        place: usize,
        trial: &TestSignal,
    ) -> Result<ClosedLoop, TuningError> {
        let servo = self.servos.get(place).ok_or(TuningError::NotKnown)?;
        Ok(ClosedLoop::new(
            design,
            servo,
            self.mode.as_ref(),
            self.settings.sample_time,
            trial,
        )?)
    }
}

/// Samples of a time in 1/ω.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a few thousand at most"
)]
pub(super) fn samples(time: f64, design: &Design, closed_loop: &ClosedLoop) -> u32 {
    ((time / (design.bandwidth * closed_loop.sample_time())) as u32).saturating_add(1)
}

impl ResponsePrediction {
    pub(super) fn begin(
        scene: &PredictionInputs,
        design: &Design,
        margins: &Margins,
    ) -> Result<Self, TuningError> {
        Ok(Self {
            design: *design,
            stage: PredictedQuantity::Step,
            closed_loop: scene.step(design)?,
            measure: scene.measure(),
            farthest: 0.0,
            seen: false,
            predicted_response: PredictedResponse {
                step: scene.settings.step,
                rise_time: f64::INFINITY,
                quickest_rise_time: f64::INFINITY,
                slowest_rise_time: f64::INFINITY,
                overshoot: 0.0,
                settling_time: f64::INFINITY,
                sensitivity: margins.sensitivity,
                gain_margins: margins.gain,
                command_share: 0.0,
                noise: design.noise,
                compliance: 0.0,
            },
        })
    }

    /// One sample of one servo, or the transition between two of them.
    pub(super) fn work(
        &mut self,
        scene: &PredictionInputs,
    ) -> Option<Result<PredictedResponse, TuningError>> {
        if self.seen {
            self.seen = false;
            return match self.next(scene) {
                Ok(true) => None,
                Ok(false) => Some(Ok(self.predicted_response)),
                Err(error) => Some(Err(error)),
            };
        }
        let Some(seen) = self.closed_loop.advance() else {
            return Some(Err(TuningError::DoesNotArrive));
        };
        self.measure.take(seen.position);
        self.farthest = self.farthest.max(libm::fabs(seen.position));
        if self.stage == PredictedQuantity::Step {
            let share = libm::fabs(seen.command) / scene.settings.command;
            self.predicted_response.command_share =
                self.predicted_response.command_share.max(share);
        }
        self.seen = self.ends(scene, seen.position);
        None
    }

    /// True if the predicted quantity has been reached.
    fn ends(&self, scene: &PredictionInputs, position: f64) -> bool {
        /// The part of the distance back from the farthest position that confirms it as the farthest.
        const BACK: f64 = 0.25;
        let taken = self.measure.samples();
        let longer_than = |time| taken > samples(time, &self.design, &self.closed_loop);
        match self.stage {
            // Friction that is higher at rest may hold it short of its place, until the integral moves it on and beyond.
            PredictedQuantity::Step if scene.forces.low_speed > 0.0 => {
                longer_than(HUNTS * PredictedResponse::MAX_TIME)
            }
            PredictedQuantity::Step | PredictedQuantity::Possible(_) => {
                let settled = self.measure.settled();
                longer_than(PredictedResponse::MAX_TIME)
                    || settled.is_some_and(|since| {
                        taken - since > samples(SETTLED, &self.design, &self.closed_loop)
                    })
            }
            PredictedQuantity::Balanced | PredictedQuantity::Opposed => {
                longer_than(PredictedResponse::MAX_TIME) || self.measure.rise().is_some()
            }
            PredictedQuantity::Load => longer_than(TURN) || position < (1.0 - BACK) * self.farthest,
            PredictedQuantity::Corner(_) => {
                let beyond = self.farthest - self.predicted_response.step;
                let has_turned = beyond > 0.0 && self.farthest - position > BACK * beyond;
                let [_, arrived] = self.measure.since();
                let peak = samples(PEAK, &self.design, &self.closed_loop);
                has_turned
                    || arrived.is_some_and(|since| since > peak)
                    || longer_than(LATE + LATE_PEAK)
            }
        }
    }

    /// Takes in the rise of a step from another initial state. If it has not risen, the time so far counts as a least
    /// value.
    fn take_rise(&mut self) {
        let taken = f64::from(self.measure.samples());
        let rise = self.measure.rise().unwrap_or(taken);
        self.predicted_response
            .take_rise(self.closed_loop.sample_time() * rise);
    }

    fn take_overshoot(&mut self) {
        self.predicted_response.overshoot = self
            .predicted_response
            .overshoot
            .max(self.measure.overshoot());
    }

    /// Evaluates the finished quantity, and begins the next; false if there is none.
    fn next(&mut self, scene: &PredictionInputs) -> Result<bool, TuningError> {
        let sample_time = self.closed_loop.sample_time();
        let taken = self.measure.samples();
        let (stage, trial) = match self.stage {
            PredictedQuantity::Step => {
                let rise = self.measure.rise().ok_or(TuningError::DoesNotArrive)?;
                if self.measure.overshoot() > MAX_OVERSHOOT {
                    return Err(TuningError::DoesNotArrive);
                }
                self.predicted_response.rise_time = rise * sample_time;
                self.predicted_response.quickest_rise_time = self.predicted_response.rise_time;
                self.predicted_response.slowest_rise_time = self.predicted_response.rise_time;
                self.take_overshoot();
                let settled = self.measure.settled().unwrap_or(taken);
                let most = samples(PredictedResponse::MAX_TIME, &self.design, &self.closed_loop);
                self.predicted_response.settling_time = sample_time * f64::from(settled.min(most));
                scene.possible_step(&self.design, 0)
            }
            PredictedQuantity::Possible(place) => {
                self.take_rise();
                self.take_overshoot();
                scene.possible_step(&self.design, place + 1)
            }
            PredictedQuantity::Balanced => {
                self.take_rise();
                (PredictedQuantity::Opposed, scene.balanced_step(-1.0))
            }
            PredictedQuantity::Opposed => {
                self.take_rise();
                (PredictedQuantity::Load, scene.unit_load())
            }
            PredictedQuantity::Load => {
                self.predicted_response.compliance = self.farthest;
                (PredictedQuantity::Corner(0), scene.worst_step(&self.design))
            }
            PredictedQuantity::Corner(place) => {
                if place == 0 && scene.sticks() {
                    self.take_rise();
                }
                self.take_overshoot();
                (
                    PredictedQuantity::Corner(place + 1),
                    scene.worst_step(&self.design),
                )
            }
        };
        let place = match stage {
            PredictedQuantity::Corner(PossibleServos::COUNT) => {
                // The position of the servo within a count is unknown.
                self.predicted_response.overshoot +=
                    scene.settings.resolution / self.predicted_response.step;
                return Ok(false);
            }
            PredictedQuantity::Corner(place) => place,
            _ => 0,
        };
        self.closed_loop = scene.closed_loop(&self.design, place, &trial)?;
        self.measure = scene.measure();
        self.farthest = 0.0;
        self.stage = stage;
        Ok(true)
    }
}
