//! A commissioning in the sample interrupt, with the drive's reasons to end it.

use commissioning::{
    CommissionInputs, CommissionIsr, CommissionState, Decision, Phase, RecordEvent,
};
use drive_link::{self, Ended, Fault, Name, Outcome, Protection};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::reason::{Reason, StopCategory};
use identifier_core::units::Units;

use crate::background_watch::DRIVEN_PATIENCE;
use crate::brake::BrakeTimes;
use crate::chip::Lines;
use crate::closed_loop::{AT_REST, Handover};
use crate::ending::{Deadline, Rest};
use crate::protection::LineWatch;
use crate::telemetry::CommissionSample;
use crate::time::samples;

/// A commissioning that is ready to begin, under way, or over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Commissioning {
    commission: CommissionIsr<f32>,
    state: CommissionState<f32>,
    lines: LineWatch,
    deadline: Deadline,
    rest: Rest,
    background_patience: u32,
    /// The drive's reason to end it, and its fault, if it is one.
    stop: Option<Reason>,
    fault: Option<Fault>,
    /// The servo is disabled, whatever else might hold it.
    disabled: bool,
    late: bool,
    sample: CommissionSample,
    started_at: i32,
    /// The origin of the run in whose place it runs; none from rest.
    run_origin: Option<i32>,
    /// It holds the servo for a run to resume.
    awaits_resume: bool,
    /// The command that balances the load, by earlier estimates.
    balance: f32,
    brake: Option<BrakeTimes>,
    /// Its last command holds the servo.
    holds: bool,
    /// Steps came, which nothing follows.
    missed_steps: bool,
    /// Position of a count, rad.
    resolution: f64,
}

/// The meaning of a sample for the commissioning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Course {
    /// It continues.
    Continues,
    /// It continues in another phase.
    NextPhase,
    /// It is over, and holds the servo from now on for a run to resume.
    AwaitsResume,
    /// It is over, and the servo is disabled.
    Over,
}

impl Commissioning {
    /// Within these protections. The command balances the load, by earlier estimates; the brake is that of the axis.
    pub(crate) fn new(
        commission: CommissionIsr<f32>,
        protection: &Protection,
        units: &Units,
        (balance, brake): (f32, Option<BrakeTimes>),
    ) -> Self {
        Self {
            state: commission.start(0, None),
            commission,
            lines: LineWatch::new(units),
            deadline: Deadline::new(0.0, protection.link_timeout, units),
            rest: Rest::within(protection.stop_time, units),
            background_patience: samples(DRIVEN_PATIENCE, units),
            stop: None,
            fault: None,
            disabled: false,
            late: false,
            sample: CommissionSample::IDLE,
            started_at: 0,
            run_origin: None,
            awaits_resume: false,
            balance,
            brake,
            holds: false,
            missed_steps: false,
            resolution: units.position_unit(),
        }
    }

    /// From the count of the servo at rest. Not inlined, to be seen in the machine code.
    #[inline(never)]
    pub(crate) fn start(&mut self, count: i32) {
        if self.balance == 0.0 {
            self.state.begin_at(count);
        } else {
            let last = ControlSample {
                command: self.balance,
                ..AT_REST
            };
            self.commission.take_over(&mut self.state, count, &last);
        }
        self.begin(count);
    }

    /// The times of the axis's brake, if it has one.
    pub(crate) fn brake(&self) -> Option<BrakeTimes> {
        self.brake
    }

    /// Has the old gains, if there are any, hold the servo for this many samples before the first motion.
    pub(crate) fn wait(&mut self, samples: u32) {
        self.state.rest_for(samples);
    }

    /// Ends it, and has the old gains hold the servo until its brake has closed.
    pub(crate) fn hold(&mut self, ended: Ended) {
        self.deadline = Deadline::NEVER;
        if ended == Ended::Stopped {
            self.end(Reason::Stopped);
        }
    }

    /// The reason that it is told to end for: where a brake is to close first, one for which the old gains hold the servo.
    fn told(&self) -> Option<Reason> {
        let held = |reason: &Reason| reason.stop_category() == StopCategory::Controlled;
        match self.stop {
            Some(reason) if self.brake.is_some() && held(&reason) => Some(Reason::ModeChanged),
            stop => stop,
        }
    }

    /// True if its last command holds the servo.
    pub(crate) fn holds(&self) -> bool {
        self.holds
    }

    /// In place of a run, under its gains at first. Not inlined, to be seen in the machine code.
    #[inline(never)]
    pub(crate) fn take_over(&mut self, handover: &Handover) {
        let Handover {
            last,
            count,
            origin,
            ..
        } = handover;
        self.commission.take_over(&mut self.state, *count, last);
        self.run_origin = Some(*origin);
        self.begin(*count);
    }

    fn begin(&mut self, count: i32) {
        self.sample.phase = self.state.phase();
        self.started_at = count;
    }

    /// The servo, if it holds it for a run to resume.
    pub(crate) fn handover(&self) -> Option<Handover> {
        let origin = self.run_origin.filter(|_| self.awaits_resume)?;
        Some(Handover {
            last: self.state.last_sample()?,
            count: self.count(),
            origin,
            rest_count: self.started_at,
            missed_steps: self.missed_steps,
        })
    }

    /// The count of the last sample.
    pub(crate) fn count(&self) -> i32 {
        self.started_at.wrapping_add(self.sample.count)
    }

    /// Samples for which the background may not run.
    pub(crate) fn background_patience(&self) -> u32 {
        self.background_patience
    }

    /// A frame of the host was received.
    pub(crate) fn link_alive(&mut self) {
        self.deadline.link_alive();
    }

    /// Ends it, under the gains before if there are any.
    pub(crate) fn end(&mut self, reason: Reason) {
        self.stop = self.stop.or(Some(reason));
    }

    /// Ends it and disables the servo at once.
    pub(crate) fn abort(&mut self, reason: Reason) {
        self.end(reason);
        self.disabled = true;
    }

    /// Ends it for a fault, before it begins or in the middle.
    pub(crate) fn abort_with_fault(&mut self, fault: Fault) {
        self.end_by_fault(fault);
        self.disabled = true;
    }

    /// Ends it for a fault, under the gains before; the gravest of several holds.
    #[cold]
    #[inline(never)]
    fn end_by_fault(&mut self, fault: Fault) {
        self.fault = Fault::graver(self.fault, Some(fault));
        self.end(fault);
    }

    /// Ends it for a fault of the lines, under the gains before until its brake has closed, if it may.
    #[cold]
    #[inline(never)]
    fn end_by_line(&mut self, fault: Fault) {
        let is_first = self.stop.is_none();
        self.end_by_fault(fault);
        if is_first && self.brake.is_some() && fault.stop_category() == StopCategory::Controlled {
            self.lines.ignore_switches();
        } else {
            self.disabled = true;
        }
    }

    /// The fault that it ended by, if it was one of the drive's.
    pub(crate) fn fault(&self) -> Option<Fault> {
        let found = self.state.reason();
        let lost = found.filter(|reason| *reason == Reason::EncoderLost);
        // And what came while the axis was held for a fault.
        Fault::graver(self.fault.or(lost), self.fault.and(found))
    }

    /// The last sample in its reported form.
    pub(crate) fn report(&self) -> CommissionSample {
        self.sample
    }

    /// Its outcome.
    pub(crate) fn outcome(&self) -> Outcome {
        let state = &self.state;
        let (phase, reason) = if state.phase().is_end() {
            // What it was told is not the reason itself.
            let told = |reason: &Reason| *reason != Reason::ModeChanged;
            (state.phase(), state.reason().filter(told).or(self.stop))
        } else {
            (Phase::Aborted, self.stop)
        };
        Outcome {
            commissioning: drive_link::Commissioning { phase, reason },
            servo: state.servo().copied(),
            tuning: state.tuning().copied(),
            no_gains: state
                .tuning_error()
                .map(|error| error.renamed(|name| Name::try_from(name).unwrap_or_default())),
            trial: state.trial().copied(),
            noise: state.noise() * self.resolution,
            kept: false,
        }
    }

    /// Takes in the steps of a sample, none if they are unclear.
    #[inline]
    pub(crate) fn miss_steps(&mut self, steps: Option<i16>) {
        self.missed_steps |= steps != Some(0);
    }

    /// Takes in whether a sample ended too late.
    #[inline]
    pub(crate) fn end_sample(&mut self, late: bool) {
        self.late = late;
    }

    /// Has a command act, or disables the servo.
    #[inline]
    fn act<A: Actuator<f32>>(&mut self, command: Option<f32>, actuator: &mut A) {
        let acted = match command.filter(|_| !self.disabled) {
            Some(command) => actuator.hold(command),
            None => actuator.release(),
        };
        if acted.is_err() {
            self.abort_with_fault(Fault::ActuatorFailed);
        }
    }

    /// One sample. The command goes out first. Then an event of the record, if any, is exchanged for a decision of the
    /// solver. `exchange` returns false if there is no space for an event.
    #[inline]
    pub(crate) fn step<'a, S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
        exchange: impl FnOnce(Option<RecordEvent<f32>>) -> (bool, Option<&'a Decision<f32>>),
    ) -> Course {
        if let Err(fault) = self.lines.check(lines) {
            self.end_by_line(fault);
        }
        if self.deadline.check().is_some() {
            self.end_by_fault(Fault::LinkLost);
        }
        let count = sensor.count().ok();
        let inputs = CommissionInputs {
            count,
            late: self.late,
            stop: self.told(),
        };
        let given = self.commission.control(&mut self.state, &inputs);
        self.act(given, actuator);
        let step = self.commission.learn(&mut self.state);
        if step.command != given || self.disabled {
            self.act(step.command, actuator);
        }
        let command = step.command.filter(|_| !self.disabled);
        self.holds = command.is_some();
        let has_changed = step.phase != self.sample.phase;
        self.sample.update(
            &step,
            count.map(|count| count.wrapping_sub(self.started_at)),
        );
        let (has_room, decision) = exchange(step.finding);
        if !has_room {
            // A record with a hole is none: the background is too slow.
            self.end(Reason::Overrun);
        }
        if let Some(decision) = decision {
            self.commission.accept(&mut self.state, decision);
        }
        let is_end = step.phase.is_end();
        if is_end && count.is_none() {
            // No reading is bridged any longer.
            self.abort_with_fault(Fault::EncoderLost);
        }
        if self.disabled || (is_end && command.is_none()) {
            return Course::Over;
        }
        if is_end && has_changed {
            self.rest.begin(self.sample.count);
        }
        if is_end && self.rest.is_over(self.sample.count) {
            // Without a run that may resume, the servo is disabled.
            if self.run_origin.is_none() || self.fault.is_some() {
                return Course::Over;
            }
            let is_new = !core::mem::replace(&mut self.awaits_resume, true);
            if is_new {
                Course::AwaitsResume
            } else {
                Course::Continues
            }
        } else if has_changed {
            Course::NextPhase
        } else {
            Course::Continues
        }
    }
}
