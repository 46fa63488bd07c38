//! A commissioning in the sample interrupt: what moves the servo, and what the drive ends it for.

use drive_link::{self, Fault, NoGains, NotAllowed, Outcome, Protection};
use identifier_core::commission::{
    CommissionInputs, CommissionIsr, CommissionSettings, CommissionState, HoldingGains, Phase,
    StopReason,
};
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::units::Units;

use crate::background_alive::Patience;
use crate::channel::InterruptEnd;
use crate::chip::Lines;
use crate::held::Held;
use crate::line_watch::LineWatch;
use crate::messages::Moved;
use crate::parts;
use crate::rest::Rest;
use crate::run::DRIVEN_PATIENCE;
use crate::silence::Silence;
use crate::time::samples;

/// A commissioning that is ready to begin, under way, or over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Commissioning {
    commission: CommissionIsr<f32>,
    state: CommissionState<f32>,
    lines: LineWatch,
    silence: Silence,
    rest: Rest,
    background: Patience,
    /// What the drive ends it for, and the fault that this is, if it is one.
    stop: Option<StopReason>,
    fault: Option<Fault>,
    /// The servo is let go, whatever else might hold it.
    let_go: bool,
    late: bool,
    moved: Moved,
    started_at: i32,
    /// Where the loop was started beside which it runs; none if it runs from rest.
    beside: Option<i32>,
    /// Whether it holds the servo for a loop to go on.
    waits: bool,
}

/// What a sample means for a commissioning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Course {
    /// It goes on.
    On,
    /// It goes on in another phase.
    NextPhase,
    /// It is over, and holds the servo from now on for a loop to go on.
    Waits,
    /// It is over, and the servo is let go.
    Over,
}

impl Commissioning {
    /// Within these protections, going back to the gains before, if there are any.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(
        settings: &CommissionSettings,
        before: Option<&HoldingGains>,
        protection: &Protection,
    ) -> Result<Self, NotAllowed> {
        let refused = |error| parts::not_commissioned(&error);
        let commission = CommissionIsr::new(settings, before).map_err(refused)?;
        let units = Units::new(settings.sample_time, settings.resolution)
            .map_err(|error| parts::not_allowed(error.into()))?;
        Ok(Self {
            state: commission.start(0, None),
            commission,
            lines: LineWatch::new(&units),
            silence: Silence::of(protection.link_timeout, &units),
            rest: Rest::within(protection.stop_time, &units),
            background: Patience::of(samples(DRIVEN_PATIENCE, &units)),
            stop: None,
            fault: None,
            let_go: false,
            late: false,
            moved: Moved::NOT_YET,
            started_at: 0,
            beside: None,
            waits: false,
        })
    }

    /// From where the servo stands. Not inlined, to be seen in the machine code.
    #[inline(never)]
    pub(crate) fn start(&mut self, count: i32, channel: &InterruptEnd<'_>) {
        self.state.begin_at(count);
        self.begin(count, channel);
    }

    /// In place of a loop that has run until now, under its gains at first. Not inlined, to be seen in the
    /// machine code.
    #[inline(never)]
    pub(crate) fn take_over(&mut self, held: &Held, channel: &InterruptEnd<'_>) {
        let Held {
            last,
            count,
            started_at,
            ..
        } = held;
        self.commission.take_over(&mut self.state, *count, last);
        self.beside = Some(*started_at);
        self.begin(*count, channel);
    }

    fn begin(&mut self, count: i32, channel: &InterruptEnd<'_>) {
        self.moved.phase = self.state.phase();
        self.started_at = count;
        self.background.begin(channel);
    }

    /// The servo, if it holds it for a loop to go on.
    pub(crate) fn held(&self) -> Option<Held> {
        let started_at = self.beside.filter(|_| self.waits)?;
        let last = self.state.last_sample()?;
        Some(Held {
            last,
            count: self.started_at.wrapping_add(self.moved.count),
            started_at,
            stood_at: self.started_at,
        })
    }

    /// The slices of work that its study does in each sample.
    pub(crate) fn slices(&self) -> u32 {
        self.commission.slices()
    }

    /// The host was heard.
    pub(crate) fn heard(&mut self) {
        self.silence.end();
    }

    /// Ends it, under the gains before if there are any.
    pub(crate) fn end(&mut self, reason: StopReason) {
        self.stop = self.stop.or(Some(reason));
    }

    /// Ends it and lets the servo go at once.
    pub(crate) fn let_go(&mut self, reason: StopReason) {
        self.end(reason);
        self.let_go = true;
    }

    fn strike(&mut self, fault: Fault) {
        self.fault = self.fault.or(Some(fault));
        self.let_go(match fault {
            Fault::LimitSwitch | Fault::LimitSwitchesStuck => StopReason::LimitSwitch,
            Fault::EncoderFailed => StopReason::EncoderLost,
            Fault::ActuatorFailed => StopReason::ActuatorDead,
            _ => StopReason::AmplifierFault,
        });
    }

    /// It cannot begin.
    pub(crate) fn refuse(&mut self, fault: Fault) {
        self.strike(fault);
    }

    /// The fault that it ended by, if it was one of the drive's.
    pub(crate) fn fault(&self) -> Option<Fault> {
        let lost = self.state.reason() == Some(StopReason::EncoderLost);
        self.fault.or(lost.then_some(Fault::EncoderFailed))
    }

    /// How far it got.
    pub(crate) fn moved(&self) -> Moved {
        self.moved
    }

    /// What it came to.
    pub(crate) fn outcome(&self) -> Outcome {
        let state = &self.state;
        let (phase, reason) = if state.phase().is_end() {
            (state.phase(), state.reason())
        } else {
            (Phase::Aborted, self.stop)
        };
        Outcome {
            commissioning: drive_link::Commissioning { phase, reason },
            servo: state.servo().copied(),
            tuning: state.tuning().copied(),
            no_gains: state.tuning_error().map(NoGains::from),
            trial: state.trial().copied(),
            kept: false,
        }
    }

    /// Takes note of whether a sample ended before the next was due.
    #[inline]
    pub(crate) fn ended(&mut self, in_time: bool) {
        self.late = !in_time;
    }

    /// Whether the background was seen to go round lately.
    #[inline]
    pub(crate) fn has_background(&mut self, channel: &InterruptEnd<'_>) -> bool {
        self.background.lasts(channel)
    }

    /// One sample: the command goes out first, then findings and answers are exchanged.
    #[inline]
    pub(crate) fn step<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
        channel: &mut InterruptEnd<'_>,
    ) -> Course {
        if let Err(fault) = self.lines.check(lines) {
            self.strike(fault);
        }
        if self.silence.is_too_long() {
            self.fault = self.fault.or(Some(Fault::LinkSilent));
            self.end(StopReason::LinkLost);
        }
        let count = sensor.count().ok();
        let seen = CommissionInputs {
            count,
            late: self.late,
            stop: self.stop,
        };
        let step = self.commission.process(&mut self.state, &seen);
        let command = step.command.filter(|_| !self.let_go);
        let acted = match command {
            Some(command) => actuator.hold(command),
            None => actuator.release(),
        };
        if acted.is_err() {
            self.strike(Fault::ActuatorFailed);
        }
        let has_changed = step.phase != self.moved.phase;
        self.moved.note(
            &step,
            count.map(|count| count.wrapping_sub(self.started_at)),
        );
        if let Some(finding) = step.finding
            && !channel.finding(finding)
        {
            // A record with a hole is none: the background is too slow.
            self.end(StopReason::Overrun);
        }
        if let Some(answer) = channel.answer() {
            self.commission.accept(&mut self.state, &answer);
        }
        let is_end = step.phase.is_end();
        if self.let_go || (is_end && command.is_none()) {
            return Course::Over;
        }
        if is_end && has_changed {
            self.rest.begin(self.moved.count);
        }
        if is_end && self.rest.is_over(self.moved.count) {
            // What no loop may go on from is let go.
            if self.beside.is_none() || self.fault.is_some() {
                return Course::Over;
            }
            let is_new = !core::mem::replace(&mut self.waits, true);
            if is_new { Course::Waits } else { Course::On }
        } else if has_changed {
            Course::NextPhase
        } else {
            Course::On
        }
    }
}
