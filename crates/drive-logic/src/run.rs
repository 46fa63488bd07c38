//! One run of a loop: its samples from start to end.

use drive_link::{Ended, Fault, NotAllowed, Settings};
use identifier_core::ControllerSettings;
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor};
use identifier_core::error::OutOfRange;
use identifier_core::identifier::{ExpectedMotion, Update};
use identifier_core::parameters::IdentifiedServo;

use crate::background_alive::Patience;
use crate::channel::InterruptEnd;
use crate::chip::{Lines, Stage};
use crate::closed_loop::{ClosedLoop, Look, Looked};
use crate::ending::{Course, Ending};
use crate::held::Held;
use crate::messages::{Counts, Shown};
use crate::parts;
use crate::protection::Protection;
use crate::reference::Reference;
use crate::time::samples;

/// The sample times that a drive runs at, s: 20 kHz to 1 kHz.
const SAMPLE_TIMES: (f64, f64) = (5e-5, 1e-3);

/// How long the background may not be seen to go round, while the servo is driven, before the watchdog
/// is left to reset the chip, s.
pub(crate) const DRIVEN_PATIENCE: f64 = 0.1;

/// A loop that is ready to be closed, with its reference and its watch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Run {
    closed_loop: ClosedLoop,
    reference: Reference,
    protection: Protection,
    ending: Ending,
    background: Patience,
    sample: u32,
    /// The last sample, its count, and that of the first.
    last: ControlSample<f32>,
    count: i32,
    started_at: i32,
}

/// Before the first sample.
const NOT_YET: ControlSample<f32> = ControlSample {
    error: 0.0,
    increment: 0.0,
    velocity: 0.0,
    command: 0.0,
};

impl Run {
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &Settings, stage: &Stage) -> Result<Self, NotAllowed> {
        let core = &settings.closed_loop.core;
        check_sample_time(core.sample_time, stage)?;
        let controller = core.own_controller().map_err(parts::not_allowed)?;
        let range = |error: OutOfRange| parts::not_allowed(error.into());
        controller.command_limit().map_err(range)?;
        parts::within_stage(controller.limit, stage)?;
        let units = core.units().map_err(range)?;
        Ok(Self {
            // What contradicts costs nothing to find; the certificate of a box does.
            reference: Reference::new(settings, &units).map_err(range)?,
            protection: Protection::new(settings, controller, &units)?,
            ending: Ending::new(&settings.protection, &units),
            background: Patience::of(samples(DRIVEN_PATIENCE, &units)),
            closed_loop: ClosedLoop::new(&settings.closed_loop)?,
            sample: 0,
            last: NOT_YET,
            count: 0,
            started_at: 0,
        })
    }

    /// Whether a run could be had of these settings, and of those without a controller, which wait for
    /// a commissioning, with one that gives nothing.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn check(settings: &Settings, stage: &Stage) -> Result<(), NotAllowed> {
        let core = &settings.closed_loop.core;
        if core.controller.is_some() {
            return Self::new(settings, stage).map(|_| ());
        }
        check_sample_time(core.sample_time, stage)?;
        let range = |error: OutOfRange| parts::not_allowed(error.into());
        let units = core.units().map_err(range)?;
        Reference::new(settings, &units).map_err(range)?;
        let none = ControllerSettings::pid(0.0, 0.0, 0.0).limited(stage.full_scale);
        Protection::new(settings, &none, &units).map(|_| ())
    }

    /// Knows the servo from the beginning, as a commissioning has identified it.
    pub(crate) fn know(&mut self, servo: &IdentifiedServo, motion: &ExpectedMotion) {
        self.closed_loop.know(servo, motion);
    }

    /// From where the servo stands. Not inlined, to be seen in the machine code.
    #[inline(never)]
    pub(crate) fn start(&mut self, count: i32, channel: &InterruptEnd<'_>) {
        self.closed_loop.start(count);
        self.reference.start(count);
        self.protection.start(count);
        self.ending.start();
        self.started_at = count;
        self.background.begin(channel);
    }

    /// Goes on where something else has held the servo, in the run that was under way before.
    pub(crate) fn go_on(&mut self, held: &Held, channel: &InterruptEnd<'_>) {
        let Held {
            last,
            count,
            started_at,
            stood_at,
        } = *held;
        self.closed_loop.take_over(held);
        self.reference.go_on_to(stood_at, count, last.error);
        self.protection.go_on(held);
        self.ending.start();
        self.started_at = started_at;
        self.background.begin(channel);
    }

    /// The servo as it leaves it to something else.
    pub(crate) fn held(&self) -> Held {
        Held {
            last: self.last,
            count: self.count,
            started_at: self.started_at,
            stood_at: self.count,
        }
    }

    /// The host was heard.
    pub(crate) fn heard(&mut self) {
        self.ending.heard();
    }

    /// Sends the servo to a target, counts from where it started.
    pub(crate) fn send(&mut self, counts: i32) {
        self.reference.send(self.started_at.wrapping_add(counts));
    }

    /// The loop that it closes.
    pub(crate) fn closed_loop(&self) -> &ClosedLoop {
        &self.closed_loop
    }

    /// Gives the background what was recorded, and takes from it what was fitted.
    #[inline]
    pub(crate) fn exchange(&mut self, channel: &mut InterruptEnd<'_>) {
        self.closed_loop.exchange(|block| {
            channel.block(block);
            channel.fitted()
        });
    }

    /// Takes note of whether a sample ended before the next was due.
    ///
    /// # Errors
    /// If too many in a row did not.
    #[inline]
    pub(crate) fn ended(&mut self, in_time: bool) -> Result<(), Ended> {
        if in_time {
            self.protection.ended_in_time();
            Ok(())
        } else {
            self.protection.ended_late().map_err(Ended::Faulted)
        }
    }

    /// Whether the background was seen to go round lately.
    #[inline]
    pub(crate) fn has_background(&mut self, channel: &InterruptEnd<'_>) -> bool {
        self.background.lasts(channel)
    }

    /// The last sample as the host is shown it.
    pub(crate) fn shown(
        &self,
        control: &ControlSample<f32>,
        seen: &Update<f32>,
        counts: &Counts,
    ) -> Shown {
        Shown {
            sample: self.sample,
            learnt: self.closed_loop.learnt(),
            error: control.error,
            count: self.count.wrapping_sub(self.started_at),
            command: control.command,
            output_error: seen.output_error,
            counts: *counts,
        }
    }

    /// Whether the loop was ever closed.
    pub(crate) fn has_run(&self) -> bool {
        self.sample > 0
    }

    /// One sample. The command goes out before anything is learnt, and what can wait comes last.
    #[inline]
    pub(crate) fn step<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<(ControlSample<f32>, Update<f32>), Ended> {
        let Self {
            closed_loop,
            reference,
            protection,
            ending,
            sample,
            last,
            count: last_count,
            ..
        } = self;
        protection.check_lines(lines).map_err(Ended::Faulted)?;
        let setpoint = reference.next();
        let watch = RunWatch {
            protection,
            ending,
            reference,
            last,
            last_count,
        };
        let done = closed_loop.sample(setpoint, sensor, actuator, watch)?;
        *sample = sample.wrapping_add(1);
        Ok(done)
    }
}

fn check_sample_time(given: f64, stage: &Stage) -> Result<(), NotAllowed> {
    let within @ (least, most) = SAMPLE_TIMES;
    if !(least..=most).contains(&given) {
        return Err(parts::out_of_range("sample_time", given, within));
    }
    parts::whole_periods(given, stage.period)
}

/// What watches over every step of a run.
struct RunWatch<'a> {
    protection: &'a mut Protection,
    ending: &'a mut Ending,
    reference: &'a mut Reference,
    last: &'a mut ControlSample<f32>,
    last_count: &'a mut i32,
}

impl Look for RunWatch<'_> {
    type End = Ended;

    #[inline(always)]
    fn look<S: PositionSensor, A: Actuator<f32>>(
        self,
        taken: Looked<S, A>,
    ) -> Result<ControlSample<f32>, Ended> {
        let (control, count) = taken.map_err(|error| Ended::Faulted(fault_of(&error)))?;
        *self.last = control;
        *self.last_count = count;
        let checked = self.protection.check(&control, count);
        checked.map_err(Ended::Faulted)?;
        match self.ending.check(count) {
            Course::On => {}
            Course::Rest => self.reference.stay(),
            Course::Ended(ended) => return Err(ended),
        }
        Ok(control)
    }
}

fn fault_of<S, A>(error: &ControlStepError<S, A>) -> Fault {
    match error {
        ControlStepError::Sensor(_) => Fault::EncoderFailed,
        ControlStepError::Actuator(_) => Fault::ActuatorFailed,
        _ => Fault::OutOfReach,
    }
}
