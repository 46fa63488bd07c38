//! A commissioning on the simulated drive: the machine of the firmware, the simulator's servo.
//!
//! A sample is the same in the simulator and on the chip. The encoder is read, the interrupt's half gives a command and
//! the background's half does its slices of work. The command acts until the next sample. So a commissioning is the
//! same to the bit wherever it runs.

mod axis;
mod course;
mod explain;
mod frequency_response;
mod record;
mod response;

pub use axis::CommissionedAxis;
pub use course::{Course, Excursion, PhaseSpan, Sample};
pub use explain::Recorded;
pub use frequency_response::FrequencyResponse;
pub use record::{End, Known, Outcome};
pub use response::StepResponse;

use commissioning::{
    CommissionIsr, CommissionSettings, CommissionSolver, CommissionState, HoldingGains,
    LargestMotion, SynchronousCommission,
};
use identifier_core::number::Number;

use crate::scenario::{Arithmetic, Fault, Scenario};

/// Blocks that the study's record has, as in the firmware.
pub const RECORD: usize = 256;

/// For how long what follows on the end is watched, s.
const AFTERWARDS: f64 = 0.2;

/// The longest that a commissioning may take, s: it is to end by itself long before.
const MAX_TIME: f64 = 60.0;

/// A commissioning of a scenario's servo, about to begin.
#[derive(Debug, Clone)]
pub struct Commissioning {
    axis: CommissionedAxis,
    settings: CommissionSettings,
    before: Option<HoldingGains>,
    arithmetic: Arithmetic,
    largest: LargestMotion,
}

impl Commissioning {
    /// The commissioning of a scenario.
    ///
    /// # Errors
    /// The key that is missing, or that it cannot be done with; nothing has moved then.
    pub fn new(scenario: &Scenario) -> Result<Self, Fault> {
        let settings = scenario.commission_settings()?;
        let before = scenario.gains_before()?;
        let refused = |error| scenario.fault_of_commission(&error);
        let machine = CommissionIsr::<f64>::new(&settings, before.as_ref()).map_err(refused)?;
        CommissionSolver::<f64, RECORD>::new(&settings).map_err(refused)?;
        let arithmetic = scenario.identifier.arithmetic;
        if arithmetic == Arithmetic::Fixed {
            return Err(Fault::new(
                "identifier.arithmetic",
                "a commissioning is computed in \"f32\", as on the chip, or in \"f64\"",
            ));
        }
        let axis = CommissionedAxis::new(scenario)?;
        Ok(Self {
            axis: match before {
                Some(_) => axis.held(),
                None => axis,
            },
            settings,
            before,
            arithmetic,
            largest: machine.largest_motion(),
        })
    }

    /// The settings of the core.
    #[must_use]
    pub fn settings(&self) -> &CommissionSettings {
        &self.settings
    }

    /// The gains that hold the servo before, if there are any.
    #[must_use]
    pub fn gains_before(&self) -> Option<&HoldingGains> {
        self.before.as_ref()
    }

    /// The largest motion that there can be before anything is known of the servo.
    #[must_use]
    pub fn largest_motion(&self) -> LargestMotion {
        self.largest
    }

    /// Runs it and shows every sample to `observe`.
    ///
    /// # Errors
    /// As [`Commissioning::new`].
    pub fn run(self, observe: &mut dyn FnMut(&Sample)) -> Result<Outcome, Fault> {
        self.run_beside(&mut |slices| slices, observe)
    }

    /// The same for a background that is faster or has other work. It maps the slices of work that are due in a sample
    /// to those that are done.
    ///
    /// # Errors
    /// As [`Commissioning::new`].
    pub fn run_beside(
        self,
        background: &mut dyn FnMut(u32) -> u32,
        observe: &mut dyn FnMut(&Sample),
    ) -> Result<Outcome, Fault> {
        match self.arithmetic {
            Arithmetic::F64 => self.run_here::<f64>(background, observe),
            Arithmetic::F32 | Arithmetic::Fixed => self.run_here::<f32>(background, observe),
        }
    }

    fn run_here<N: Number>(
        mut self,
        background: &mut dyn FnMut(u32) -> u32,
        observe: &mut dyn FnMut(&Sample),
    ) -> Result<Outcome, Fault> {
        let before = self.before.as_ref();
        // What the gains before hold the servo with.
        let held = before.map(|_| self.axis.balance());
        let built = SynchronousCommission::<N, RECORD>::new(&self.settings, before, held);
        let mut commissioner = built.map_err(|error| Fault::new("commission", error))?;
        let sample_time = self.settings.sample_time;
        let mut course = Course::default();
        let mut known = Vec::new();
        let mut end: Option<End> = None;
        loop {
            let time = course.samples() as f64 * sample_time;
            let (position, velocity) = (self.axis.position(), self.axis.velocity());
            let seen = self.axis.sense();
            let done = commissioner.sample_with_slices(&seen, background(commissioner.slices()));
            known.extend(done.servo.map(|servo| Known { time, servo }));
            let sample = Sample {
                time,
                phase: done.phase,
                measured: seen
                    .count
                    .map(|count| f64::from(count) * self.settings.resolution),
                reference: done
                    .setpoint
                    .map(|setpoint| setpoint * self.settings.resolution),
                position,
                velocity,
                command: done.command,
            };
            if done.phase.is_end() && end.is_none_or(|end| end.phase != done.phase) {
                end = Some(End {
                    phase: done.phase,
                    within: course.phase(),
                    reason: done.reason,
                    time,
                    disabled: None,
                });
            }
            if let Some(end) = &mut end {
                end.disabled = match done.command {
                    Some(_) => None,
                    None => end.disabled.or(Some(time)),
                };
            }
            course.add(&sample);
            observe(&sample);
            let over = end.as_ref().map_or(MAX_TIME, |end| end.time + AFTERWARDS);
            if time >= over {
                let state = commissioner.state();
                let tuning_error = state.and_then(CommissionState::tuning_error);
                let noise = state.map_or(0.0, CommissionState::noise);
                let solver = commissioner.solver();
                return Ok(Outcome {
                    end,
                    known,
                    tuning: state.and_then(CommissionState::tuning).copied(),
                    no_gains: tuning_error.copied(),
                    trial: done.trial,
                    noise: noise * self.settings.resolution,
                    forces: *solver.forces(),
                    response: FrequencyResponse::new(solver.response(), solver.resonance()),
                    course: course.finish(time),
                });
            }
            self.axis.advance(done.command.unwrap_or(0.0));
        }
    }
}
