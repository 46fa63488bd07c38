//! One run of a loop: its samples from start to end.

use commissioning::servo_change::ServoChangeState;
use commissioning::watch::{Use, WatchSettings};
use drive_link::{
    Ended, Estimates, Estimator, Fault, LoopSettings, NotAllowed, ServoChanges, Settings, Why,
};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor};
use identifier_core::error::Allowed;
use identifier_core::identifier::{ExpectedMotion, Update};
use identifier_core::parameters::IdentifiedServo;
use identifier_core::settings::ControllerSettings;
use identifier_core::units::Units;

use crate::background_watch::DRIVEN_PATIENCE;
use crate::brake::BrakeTimes;
use crate::chip::{Chip, Lines, OutputStage};
use crate::closed_loop::{
    self, AT_REST, ClosedLoop, Handover, Learning, MotionPart, Settled, StepMonitor, StepResult,
};
use crate::conversion;
use crate::ending::{Course, Ending};
use crate::first_motion::{Balance, FirstMotion};
use crate::guide::{Guide, Origin, Target};
use crate::paced_watch::PacedWatch;
use crate::protection::Protection;
use crate::reference::Reference;
use crate::telemetry::{Counts, RunSample};
use crate::time::samples;

/// The shortest sample times of a run, s, without terms and with them. At least half of each stays free of its longest
/// interrupt, on the slowest chip (`cargo xtask budget`).
pub const MIN_SAMPLE_TIME: f64 = 5e-5;
/// See [`MIN_SAMPLE_TIME`].
pub const MIN_SAMPLE_TIME_WITH_TERMS: f64 = 1.5e-4;

/// The longest sample time of a run, s.
const MAX_SAMPLE_TIME: f64 = 1e-3;

/// A loop that is ready to be closed, with its reference and its watches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Run {
    closed_loop: ClosedLoop,
    parts: RunParts,
}

/// All of a run but its loop.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RunParts {
    first_motion: FirstMotion,
    reference: Reference,
    protection: Protection,
    watch: PacedWatch,
    ending: Ending,
    background_patience: u32,
    /// Samples from one examination of the estimates to the next; 0 for none.
    examination_interval: u16,
    brake: Option<BrakeTimes>,
    sample: u32,
    guide: Guide,
    /// The command that was to balance the load has moved the servo.
    is_refuted: bool,
    /// The last sample, its count, and that from which targets and travel count.
    last: ControlSample<f32>,
    count: i32,
    origin: i32,
}

impl RunParts {
    /// # Errors
    /// The setting that is not allowed.
    #[inline(never)]
    fn new(settings: &Settings, stage: &OutputStage) -> Result<Self, NotAllowed> {
        let core = &settings.closed_loop.core;
        check_sample_time(core, stage)?;
        let controller = core.own_controller()?;
        controller.command_limit()?;
        conversion::check_stage_limits(controller.limit, stage)?;
        let units = core.units()?;
        controller.reference_filter::<f32>(&units)?;
        controller.notch::<f32>(&units)?;
        let axis = axis(core, controller);
        let first_motion = FirstMotion::new(axis.command, core.sample_time);
        Ok(Self {
            watch: PacedWatch::new(&axis)?,
            reference: Reference::new(settings, &units)?,
            protection: Protection::new(settings, controller, &units)?
                .of_unknown(first_motion.patience()),
            guide: Guide::new(settings, &units)?,
            ending: Ending::new(&settings.protection, &units),
            background_patience: samples(DRIVEN_PATIENCE, &units),
            examination_interval: examination_interval(settings, &units)?,
            brake: BrakeTimes::new(settings.brake.as_ref(), &units)?,
            first_motion,
            is_refuted: false,
            sample: 0,
            last: AT_REST,
            count: 0,
            origin: 0,
        })
    }
}

impl Run {
    /// # Errors
    /// The setting that is not allowed.
    #[inline]
    pub(crate) fn new(settings: &Settings, stage: &OutputStage) -> Result<Self, NotAllowed> {
        // A contradiction costs nothing to find; the certificate of a parameter range does.
        let parts = RunParts::new(settings, stage)?;
        Ok(Self {
            closed_loop: closed_loop(settings)?,
            parts,
        })
    }

    /// Checks settings without keeping the run. Settings without a controller, which wait for a commissioning, are
    /// checked with a controller of zero gains.
    ///
    /// # Errors
    /// The setting that is not allowed.
    #[inline(never)]
    pub(crate) fn check(settings: &Settings, stage: &OutputStage) -> Result<(), NotAllowed> {
        let core = &settings.closed_loop.core;
        if core.controller.is_some() {
            RunParts::new(settings, stage)?;
            return closed_loop(settings).map(|_| ());
        }
        check_sample_time(core, stage)?;
        closed_loop::check(&settings.closed_loop)?;
        let units = core.units()?;
        examination_interval(settings, &units)?;
        BrakeTimes::new(settings.brake.as_ref(), &units)?;
        Reference::new(settings, &units)?;
        let none = ControllerSettings::pid(0.0, 0.0, 0.0).limited(stage.full_scale);
        Protection::new(settings, &none, &units)?;
        Guide::new(settings, &units).map(|_| ())
    }

    /// Is watched as a servo that a commissioning has identified, whatever was learnt since: the gains are of that.
    #[inline(never)]
    pub(crate) fn know(&mut self, servo: &IdentifiedServo) {
        if self.parts.watch.know(servo) {
            self.parts.first_motion.know();
            self.parts.protection.end_first_motion();
        }
    }

    /// Identifies from such a servo on.
    pub(crate) fn begin_from(&mut self, servo: &IdentifiedServo, motion: &ExpectedMotion) {
        self.closed_loop.know(servo, motion);
    }

    /// Starts under the command that balances the load of this servo. The integral gives it or, without one, an offset
    /// of the reference.
    pub(crate) fn balance(&mut self, known: &Estimates, settings: &Settings) {
        let core = &settings.closed_loop.core;
        let (Some(controller), Ok(units)) = (&core.controller, core.units()) else {
            return;
        };
        let command = conversion::balance(known, controller.limit);
        let offset = if controller.ki == 0.0 && controller.kp > 0.0 {
            command / controller.kp * units.position()
        } else {
            0.0
        };
        self.parts.last.command = command as f32;
        self.parts.last.error = offset as f32;
    }

    /// From the count of the servo at rest. Not inlined, to be seen in the machine code.
    #[inline(never)]
    pub(crate) fn start(&mut self, count: i32) {
        self.parts.origin = match self.parts.guide.origin() {
            Origin::Found(origin) => origin,
            Origin::Start | Origin::Sought => count,
        };
        self.parts.count = count;
        let handover = self.handover();
        self.closed_loop.start(&handover);
        self.parts.reference.start(count, self.parts.last.error);
        self.parts.watch.start(count);
        self.parts.protection.start(&handover);
        self.parts.guide.begin(count);
        let balance = handover.last.command;
        if balance == 0.0 || self.parts.brake.is_some() {
            // Behind its brake the axis does not move.
            self.parts.first_motion.take_over(balance);
        } else {
            self.parts.first_motion.grow(balance);
            self.parts.reference.wait();
        }
    }

    /// Begins anew without a command that balances the load, as that has moved the servo.
    #[cold]
    #[inline(never)]
    fn begin_unbalanced(&mut self) {
        self.parts.last = AT_REST;
        self.closed_loop.start(&self.handover());
        self.parts.reference.rest_at(self.parts.count);
        self.parts.reference.go();
    }

    /// From where a commissioning holds the servo, in the run that was under way before.
    pub(crate) fn take_over(&mut self, handover: &Handover) {
        let Handover {
            last,
            count,
            origin,
            rest_count,
            missed_steps,
        } = *handover;
        self.closed_loop.take_over(handover);
        self.parts.first_motion.take_over(last.command);
        self.parts
            .reference
            .resume_to(rest_count, count, last.error);
        self.parts.protection.start(handover);
        self.parts.guide.resume(rest_count, missed_steps);
        self.parts.origin = origin;
        self.parts.watch.start(count);
        (self.parts.last, self.parts.count) = (last, count);
    }

    /// The servo as it hands it over to a commissioning.
    pub(crate) fn handover(&self) -> Handover {
        Handover {
            last: self.parts.last,
            count: self.parts.count,
            origin: self.parts.origin,
            rest_count: self.parts.count,
            missed_steps: false,
        }
    }

    /// The times of the axis's brake, if it has one.
    pub(crate) fn brake(&self) -> Option<BrakeTimes> {
        self.parts.brake
    }

    /// Holds the servo where it is until [`go`](Self::go).
    pub(crate) fn wait(&mut self) {
        self.parts.reference.wait();
    }

    /// Follows its targets after it has waited.
    pub(crate) fn go(&mut self) {
        self.parts.reference.go();
    }

    /// Has ended, and holds the servo where it is until its brake has closed.
    pub(crate) fn hold(&mut self, ended: Ended) {
        self.parts.reference.stay();
        self.parts.ending.hold();
        self.parts.protection.hold(ended);
    }

    /// Samples for which the background may not run.
    pub(crate) fn background_patience(&self) -> u32 {
        self.parts.background_patience
    }

    /// A frame of the host was received.
    pub(crate) fn link_alive(&mut self) {
        self.parts.ending.link_alive();
    }

    /// Sends the servo to a target of the host.
    pub(crate) fn set_target(&mut self, target: Target) {
        if self.parts.guide.takes_targets() {
            let target = self.parts.origin.wrapping_add(target.counts());
            self.parts.reference.send(target);
        }
    }

    /// Drives the axis home.
    pub(crate) fn home(&mut self) {
        self.parts.guide.home();
    }

    /// The distance of the index pulse from the edge of the home switch, counts, if this run has found both.
    pub(crate) fn index_from_edge(&self) -> Option<i32> {
        self.parts.guide.index_from_edge()
    }

    /// The origin of targets and travel.
    pub(crate) fn origin(&self) -> Origin {
        self.parts.guide.origin()
    }

    /// Continues with the origin of a run before.
    pub(crate) fn set_origin(&mut self, origin: Origin) {
        self.parts.guide.set_origin(origin);
    }

    /// Guides the reference after a sample: homing, and commands from outside. True if the origin was found.
    ///
    /// # Errors
    /// The fault by which the run ends.
    #[inline]
    pub(crate) fn guide<C: Chip>(&mut self, chip: &mut C) -> Result<bool, Ended> {
        if self.parts.guide.is_idle() {
            return Ok(false);
        }
        if core::mem::take(&mut self.parts.is_refuted) {
            self.begin_unbalanced();
        }
        let reference = &mut self.parts.reference;
        let found = self
            .parts
            .guide
            .step(chip, self.parts.count, self.parts.origin, reference);
        let Some(origin) = found.map_err(Ended::Faulted)? else {
            return Ok(false);
        };
        self.parts.origin = origin;
        self.parts.protection.set_origin(origin);
        Ok(true)
    }

    /// The count of the last sample.
    #[inline]
    pub(crate) fn count(&self) -> i32 {
        self.parts.count
    }

    /// Its loop.
    pub(crate) fn closed_loop(&self) -> &ClosedLoop {
        &self.closed_loop
    }

    /// Hands on the part of the motion that is complete, if one is, and takes over what has come back. True if there was
    /// one.
    #[inline]
    pub(crate) fn exchange<'a>(
        &mut self,
        hand_on: impl FnOnce(MotionPart) -> Option<&'a Learning>,
    ) -> bool {
        self.closed_loop.exchange(hand_on)
    }

    /// Samples from one examination of the estimates to the next; 0 for none.
    pub(crate) fn examination_interval(&self) -> u16 {
        self.parts.examination_interval
    }

    /// Examines the estimates.
    pub(crate) fn examine(&mut self) -> Option<Settled> {
        self.closed_loop.examine()
    }

    /// Takes in whether a sample ended too late.
    ///
    /// # Errors
    /// Too many did.
    #[inline]
    pub(crate) fn end_sample(&mut self, late: bool) -> Result<(), Ended> {
        self.parts
            .protection
            .end_sample(late)
            .map_err(Ended::Faulted)
    }

    /// The last sample in its reported form.
    #[inline]
    pub(crate) fn report(
        &self,
        control: &ControlSample<f32>,
        update: &Update<f32>,
        counts: &Counts,
    ) -> RunSample {
        RunSample {
            sample: self.parts.sample,
            learnt: self.closed_loop.learnt(),
            error: control.error,
            count: self.parts.count.wrapping_sub(self.parts.origin),
            command: control.command,
            output_error: update.output_error,
            counts: *counts,
        }
    }

    /// True if the loop was ever closed.
    pub(crate) fn has_run(&self) -> bool {
        self.parts.sample > 0
    }

    /// One sample. The command goes out before anything is learnt.
    #[inline]
    pub(crate) fn step<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<(ControlSample<f32>, Update<f32>), Ended> {
        let Self { closed_loop, parts } = self;
        parts
            .protection
            .check_lines(lines)
            .map_err(Ended::Faulted)?;
        let setpoint = parts.reference.next();
        let done = closed_loop.sample(setpoint, sensor, actuator, &mut *parts)?;
        parts.sample = parts.sample.wrapping_add(1);
        Ok(done)
    }
}

/// The settings of the watches over an axis.
fn axis(core: &identifier_core::Settings, controller: &ControllerSettings) -> WatchSettings {
    WatchSettings {
        sample_time: core.sample_time,
        resolution: core.resolution,
        // These two are the protection's, by the settings of the run.
        travel: [f64::NEG_INFINITY, f64::INFINITY],
        speed: f64::INFINITY,
        command: controller.limit,
        used_for: Use::Operation,
    }
}

/// Its loop, of the given settings, but under a dither without filter of the reference and without reference model. Those
/// two would remove most of the acceleration from the dither, and with it the evidence of b. Targets are approached at a
/// bounded speed anyway.
#[inline(never)]
fn closed_loop(settings: &Settings) -> Result<ClosedLoop, NotAllowed> {
    closed_loop::check(&settings.closed_loop)?;
    let LoopSettings { core, law, .. } = &settings.closed_loop;
    let (amplifier, mut behind) = core.amplifier()?;
    if settings.dither.amplitude != 0.0
        && let Some(controller) = &mut behind.controller
    {
        controller.reference_filter = 0.0;
        controller.feed_forward = None;
    }
    ClosedLoop::new(&behind, *law, amplifier)
}

/// Samples from one examination of the estimates to the next; 0 for none.
///
/// # Errors
/// The settings ask for one of an estimator that has no standard errors, or of a model with terms.
fn examination_interval(settings: &Settings, units: &Units) -> Result<u16, NotAllowed> {
    let LoopSettings { core, law, .. } = &settings.closed_loop;
    let is_examined = *law == Estimator::GaussNewton && core.identifier.terms.demanded.is_empty();
    match settings.servo_changes {
        ServoChanges::Ignored => Ok(0),
        ServoChanges::Reported if is_examined => {
            let interval = samples(ServoChangeState::INTERVAL, units);
            Ok(u16::try_from(interval).unwrap_or(u16::MAX))
        }
        ServoChanges::Reported => Err(NotAllowed::new("servo_changes", Why::NotHere)),
    }
}

fn check_sample_time(
    settings: &identifier_core::Settings,
    stage: &OutputStage,
) -> Result<(), NotAllowed> {
    let given = settings.sample_time;
    Allowed::Within(MIN_SAMPLE_TIME, MAX_SAMPLE_TIME).check("sample_time", given)?;
    let has_terms = !settings.identifier.terms.demanded.is_empty();
    if has_terms && given < MIN_SAMPLE_TIME_WITH_TERMS {
        return Err(NotAllowed::too_small(
            "sample_time",
            given,
            MIN_SAMPLE_TIME_WITH_TERMS,
            "required_terms",
        ));
    }
    conversion::check_whole_periods(given, stage.period)
}

impl RunParts {
    /// The command that acts in place of the controller's.
    #[cold]
    #[inline(never)]
    fn ramped(&mut self, command: f32) -> f32 {
        let moved = self.protection.moved();
        let (command, balance) = self.first_motion.ramped(command, moved);
        match balance {
            Some(Balance::Acts) => self.reference.go(),
            Some(Balance::Refuted) => {
                self.is_refuted = true;
                self.guide.activate();
            }
            None => {}
        }
        command
    }
}

/// The watches over every step of a run.
impl StepMonitor for &mut RunParts {
    type End = Ended;

    #[inline(always)]
    fn acting(&mut self, sample: &ControlSample<f32>) -> f32 {
        if self.first_motion.acts() {
            // Its address would put the sample into memory.
            self.ramped(sample.command)
        } else {
            sample.command
        }
    }

    #[inline(always)]
    fn check<S: PositionSensor, A: Actuator<f32>>(
        self,
        step: StepResult<S, A>,
    ) -> Result<ControlSample<f32>, Ended> {
        let (control, count) = step.map_err(|error| Ended::Faulted(fault_of(&error)))?;
        let before = core::mem::replace(&mut self.last, control);
        self.count = count;
        let checked = self.protection.check(&control, count);
        checked.map_err(Ended::Faulted)?;
        let watched = self.watch.process(&control, count, before.command);
        watched.map_err(Ended::Faulted)?;
        match self.ending.check(count) {
            Course::Continues => {}
            Course::Rests => self.reference.stay(),
            Course::Ended(ended) => return Err(ended),
        }
        Ok(control)
    }
}

fn fault_of<S, A>(error: &ControlStepError<S, A>) -> Fault {
    match error {
        ControlStepError::Sensor(_) => Fault::EncoderLost,
        ControlStepError::Actuator(_) => Fault::ActuatorFailed,
        _ => Fault::OutOfReach,
    }
}
