//! The interrupt's half: one call a sample, and nothing in it waits.

use drive_link::{Ended, Fault, NotAllowed, Noticed, Settings};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor};
use identifier_core::error::OutOfRange;
use identifier_core::identifier::{self, Seen};

use crate::channel::InterruptEnd;
use crate::closed_loop::{ClosedLoop, Learnt, Look, Looked};
use crate::ending::{Course, Ending};
use crate::parts;
use crate::protection::Protection;
use crate::reference::Reference;
use crate::time::samples;

/// The sample times that a drive runs at, s: 20 kHz to 1 kHz.
const SAMPLE_TIMES: (f64, f64) = (5e-5, 1e-3);

/// How long the background may not be seen to go round, while the servo is driven, before the watchdog
/// is left to reset the chip, s.
const DRIVEN_PATIENCE: f64 = 0.1;

/// What the supervisor orders.
#[derive(Debug)]
pub(crate) enum Order {
    /// Close this loop where the servo stands.
    Run(&'static mut Run),
    /// Send the servo to a target, counts from where it started.
    Target(i32),
    /// Forget a fault, if its cause is gone.
    Clear,
    /// Show a sample every so often; 0 for never.
    Watch(u16),
}

/// What the interrupt tells.
#[derive(Debug)]
pub(crate) enum Event {
    /// How things stand: after every change, and after every order that asks for one.
    Standing(Standing),
    /// A sample.
    Shown(Shown),
}

/// How things stand in the interrupt.
#[derive(Debug)]
pub(crate) struct Standing {
    /// The fault that holds.
    pub(crate) fault: Option<Fault>,
    /// How the last run ended.
    pub(crate) ended: Option<Ended>,
    /// The run that has ended, or was not begun.
    pub(crate) returned: Option<&'static mut Run>,
    /// The stops that were obeyed.
    pub(crate) stops: u32,
    /// What happened without being a fault.
    pub(crate) counts: Counts,
}

/// What happened without being a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Counts {
    /// What the identifier noticed since the start.
    pub(crate) noticed: Noticed,
    /// Samples that ended too late since the start.
    pub(crate) overruns: u32,
    /// Events that found no room since the drive was switched on.
    pub(crate) dropped: u32,
}

/// A sample as the interrupt knows it, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shown {
    /// Samples since the start.
    pub(crate) sample: u32,
    /// What the loop has learnt.
    pub(crate) learnt: Learnt,
    /// Position error, counts.
    pub(crate) error: f32,
    /// Counts from where the servo started.
    pub(crate) count: i32,
    /// Command, command units.
    pub(crate) command: f32,
    /// Output error, counts.
    pub(crate) output_error: f32,
    /// What happened without being a fault.
    pub(crate) counts: Counts,
}

impl Counts {
    /// Those of a run begin with it.
    fn start(&mut self) {
        *self = Self {
            dropped: self.dropped,
            ..Self::default()
        };
    }

    #[inline]
    fn notice(&mut self, event: identifier::Event) {
        let Noticed {
            started,
            load_steps,
            not_following,
            friction_lowered,
            restarted,
        } = &mut self.noticed;
        let count = match event {
            identifier::Event::Started => started,
            identifier::Event::LoadStep => load_steps,
            identifier::Event::NotFollowing => not_following,
            identifier::Event::FrictionLowered => friction_lowered,
            identifier::Event::Restarted => restarted,
            _ => return,
        };
        *count = count.saturating_add(1);
    }
}

/// What the pins say besides the encoder. Every line is healthy when it is closed, so a broken wire
/// is a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lines {
    /// The amplifier reports no fault.
    pub amplifier: bool,
    /// The limit switch at the lower end is closed.
    pub low_switch: bool,
    /// The limit switch at the upper end is closed.
    pub high_switch: bool,
}

impl Lines {
    fn before_motion(self) -> Result<(), Fault> {
        if !self.amplifier {
            Err(Fault::AmplifierFault)
        } else if self.low_switch && self.high_switch {
            Ok(())
        } else {
            Err(Fault::LimitSwitchesStuck)
        }
    }
}

/// What the sample interrupt finds on a chip.
pub trait Chip {
    /// The encoder.
    type Sensor: PositionSensor;
    /// The output stage.
    type Output: Actuator<f32>;

    /// What the lines say now.
    fn lines(&self) -> Lines;

    /// Encoder and output stage.
    fn servo(&mut self) -> (&mut Self::Sensor, &mut Self::Output);

    /// Whether the time of the next sample has come.
    fn next_is_due(&self) -> bool;

    /// Keeps the watchdog from resetting the chip.
    fn feed_watchdog(&mut self);
}

/// A loop that is ready to be closed, with its reference and its watch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    closed_loop: ClosedLoop,
    reference: Reference,
    protection: Protection,
    ending: Ending,
    background: Patience,
    sample: u32,
    /// The count of the last sample, and of the first.
    count: i32,
    started_at: i32,
}

/// What the output stage of a drive can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// The command that asks for all it has, command units: no limit may be beyond it.
    pub full_scale: f64,
    /// The samples are a whole number of these apart, s: the period of its PWM.
    pub period: f64,
    /// From the reading of the encoder to the change of the output, s.
    pub command_delay: f64,
}

impl Run {
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &Settings, stage: &Stage) -> Result<Self, NotAllowed> {
        let core = &settings.closed_loop.core;
        let within @ (least, most) = SAMPLE_TIMES;
        let given = core.sample_time;
        if !(least..=most).contains(&given) {
            return Err(parts::out_of_range("sample_time", given, within));
        }
        parts::whole_periods(given, stage.period)?;
        let controller = core.own_controller().map_err(parts::not_allowed)?;
        let range = |error: OutOfRange| parts::not_allowed(error.into());
        controller.command_limit().map_err(range)?;
        let [low, high] = controller.limit;
        for (name, limit) in [("limit_high", high), ("limit_low", -low)] {
            if limit > stage.full_scale {
                return Err(parts::out_of_range(name, limit, (0.0, stage.full_scale)));
            }
        }
        let units = core.units().map_err(range)?;
        Ok(Self {
            // What contradicts costs nothing to find; the certificate of a box does.
            reference: Reference::new(settings, &units).map_err(range)?,
            protection: Protection::new(settings, controller, &units)?,
            ending: Ending::new(&settings.protection, &units),
            background: Patience::of(samples(DRIVEN_PATIENCE, &units)),
            closed_loop: ClosedLoop::new(&settings.closed_loop)?,
            sample: 0,
            count: 0,
            started_at: 0,
        })
    }

    /// From where the servo stands. Not inlined, to be seen in the machine code.
    #[inline(never)]
    fn start(&mut self, count: i32) {
        self.closed_loop.start(count);
        self.reference.start(count);
        self.protection.start(count);
        self.ending.start();
        self.started_at = count;
    }

    /// The loop that it closes.
    pub(crate) fn closed_loop(&self) -> &ClosedLoop {
        &self.closed_loop
    }

    /// Whether the loop was ever closed.
    pub(crate) fn has_run(&self) -> bool {
        self.sample > 0
    }
}

/// The interrupt's half of a drive.
#[derive(Debug)]
pub struct Sampler<'a> {
    channel: InterruptEnd<'a>,
    run: Option<&'static mut Run>,
    fault: Option<Fault>,
    ended: Option<Ended>,
    /// A run on its way back.
    returned: Option<&'static mut Run>,
    /// How often was asked when there was nothing left to obey.
    asked: u32,
    /// How often the host had been heard then.
    heard: u32,
    /// The stops that were obeyed.
    stops: u32,
    /// How things stand has changed and has found no room yet.
    untold: bool,
    watch: Watch,
    counts: Counts,
    background: Patience,
}

impl<'a> Sampler<'a> {
    /// Released, with what the boot found wrong.
    #[must_use]
    pub fn new(channel: InterruptEnd<'a>, found_at_boot: Result<(), Fault>) -> Self {
        Self {
            asked: channel.times_asked().wrapping_sub(1),
            heard: channel.times_heard(),
            stops: channel.stops(),
            channel,
            run: None,
            fault: found_at_boot.err(),
            ended: None,
            returned: None,
            untold: found_at_boot.is_err(),
            watch: Watch::NONE,
            counts: Counts::default(),
            background: Patience::of(1),
        }
    }

    /// All that the sample interrupt does.
    #[inline]
    pub fn interrupt<C: Chip>(&mut self, chip: &mut C) {
        let lines = chip.lines();
        if self.channel.times_asked() != self.asked {
            let (sensor, output) = chip.servo();
            self.obey(lines, sensor, output);
        }
        let Some(run) = &mut self.run else {
            return self.rest(chip);
        };
        let (sensor, output) = chip.servo();
        match run.step(lines, sensor, output) {
            Ok((control, seen)) => {
                run.closed_loop.exchange(|block| {
                    self.channel.block(block);
                    self.channel.fitted()
                });
                self.counts.notice(seen.event);
                if self.watch.is_due() {
                    show(run, &mut self.channel, &mut self.counts, &control, &seen);
                }
            }
            Err(ended) => return self.end(ended, output),
        }
        if chip.next_is_due() {
            self.counts.overruns = self.counts.overruns.saturating_add(1);
            if let Err(fault) = run.protection.ended_late() {
                let (_, output) = chip.servo();
                return self.end(Ended::Faulted(fault), output);
            }
        } else {
            run.protection.ended_in_time();
        }
        if run.background.lasts(&self.channel) {
            chip.feed_watchdog();
        }
    }

    /// A sample of a servo that is let go.
    #[cold]
    fn rest<C: Chip>(&mut self, chip: &mut C) {
        let (sensor, output) = chip.servo();
        // Read even so: a counter of few bits that wraps unread loses its turns.
        let _ = sensor.count();
        let _ = output.release();
        // It follows the sample time that was configured since.
        self.background.set(self.channel.released_patience());
        if self.background.lasts(&self.channel) {
            chip.feed_watchdog();
        }
    }

    /// Takes note that the host was heard, obeys a stop, tells what was not told yet, and does the next
    /// order, a sample each, until there is nothing left of all that.
    #[cold]
    #[inline(never)]
    fn obey<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) {
        let asked = self.channel.times_asked();
        let heard = self.channel.times_heard();
        if heard != self.heard {
            self.heard = heard;
            if let Some(run) = &mut self.run {
                run.ending.heard();
            }
        }
        let stops = self.channel.stops();
        if stops != self.stops {
            self.stops = stops;
            self.end(Ended::Stopped, actuator);
        }
        if self.untold {
            self.tell();
        }
        if self.untold {
            return;
        }
        match self.channel.order() {
            Some(order) => self.carry_out(order, lines, sensor, actuator),
            None => self.asked = asked,
        }
    }

    fn carry_out<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        order: Result<Order, Order>,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) {
        match order {
            // A stop has overtaken it; a fault that struck while it was on its way stands.
            Err(Order::Run(run)) => self.give_back(run),
            Ok(Order::Run(run)) if self.fault.is_some() => self.give_back(run),
            Ok(Order::Run(run)) => {
                let stands = lines
                    .before_motion()
                    .and_then(|()| sensor.count().map_err(|_| Fault::EncoderFailed));
                match stands {
                    Ok(count) => {
                        self.counts.start();
                        // Of a run before.
                        while self.channel.fitted().is_some() {}
                        run.start(count);
                        run.background.begin(&self.channel);
                        self.run = Some(run);
                    }
                    Err(fault) => {
                        self.returned = Some(run);
                        self.end(Ended::Faulted(fault), actuator);
                    }
                }
            }
            Ok(Order::Target(counts)) => {
                if let Some(run) = &mut self.run {
                    run.reference.send(run.started_at.wrapping_add(counts));
                }
            }
            Ok(Order::Clear) => self.clear(lines),
            Ok(Order::Watch(every)) | Err(Order::Watch(every)) => {
                self.watch = Watch::every(every);
            }
            Err(Order::Target(_) | Order::Clear) => {}
        }
    }

    fn clear(&mut self, lines: Lines) {
        // These need a reset, which tests again.
        let stays = matches!(self.fault, Some(Fault::ClockNotStable | Fault::WrongAnswer));
        if !stays && self.fault.is_some() {
            self.fault = lines.before_motion().err();
        }
        self.untold = true;
        self.tell();
    }

    fn give_back(&mut self, run: &'static mut Run) {
        self.returned = Some(run);
        self.untold = true;
        self.tell();
    }

    /// Lets the servo go. Not inlined, to be seen in the machine code.
    #[cold]
    #[inline(never)]
    fn end<A: Actuator<f32>>(&mut self, ended: Ended, actuator: &mut A) {
        let _ = actuator.release();
        if let Ended::Faulted(fault) = ended {
            self.fault = Some(fault);
        }
        if let Some(run) = self.run.take() {
            self.returned = Some(run);
            self.ended = Some(ended);
        }
        self.untold = true;
        self.tell();
    }

    #[cold]
    fn tell(&mut self) {
        let standing = Standing {
            fault: self.fault,
            ended: self.ended,
            returned: self.returned.take(),
            stops: self.stops,
            counts: self.counts,
        };
        match self.channel.tell(Event::Standing(standing)) {
            Ok(()) => self.untold = false,
            Err(Event::Standing(standing)) => {
                self.returned = standing.returned;
                self.come_back();
            }
            Err(Event::Shown(_)) => {}
        }
    }

    /// There is something left to do in the next sample.
    fn come_back(&mut self) {
        self.asked = self.channel.times_asked().wrapping_sub(1);
    }
}

/// Which samples are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Watch {
    /// Samples from one to the next; 0 for none.
    every: u16,
    left: u32,
}

impl Watch {
    const NONE: Self = Self::every(0);

    /// The next sample, and then every so many.
    const fn every(every: u16) -> Self {
        Self {
            every,
            left: if every == 0 { u32::MAX } else { 1 },
        }
    }

    /// Whether this sample is to be shown.
    #[inline]
    fn is_due(&mut self) -> bool {
        self.left -= 1;
        self.left == 0 && self.begin_anew()
    }

    #[cold]
    fn begin_anew(&mut self) -> bool {
        let is_due = self.every > 0;
        self.left = if is_due { self.every.into() } else { u32::MAX };
        is_due
    }
}

/// How long the background may not be seen to go round.
///
/// A count runs down in every sample; only when it has run out is the background looked at, and then it
/// has gone round since, or not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Patience {
    most: u32,
    left: u32,
    times: u32,
}

impl Patience {
    /// It lasts from half of so many samples to all of them.
    fn of(samples: u32) -> Self {
        let mut patience = Self {
            most: 1,
            left: 1,
            times: 0,
        };
        patience.set(samples);
        patience.left = patience.most;
        patience
    }

    /// From the next time on that it is renewed.
    fn set(&mut self, samples: u32) {
        self.most = (samples / 2).max(1);
    }

    fn begin(&mut self, channel: &InterruptEnd<'_>) {
        self.times = channel.times_alive();
        self.left = self.most;
    }

    #[inline]
    fn lasts(&mut self, channel: &InterruptEnd<'_>) -> bool {
        self.left -= 1;
        self.left > 0 || self.is_renewed(channel)
    }

    #[cold]
    fn is_renewed(&mut self, channel: &InterruptEnd<'_>) -> bool {
        let is_alive = channel.times_alive() != self.times;
        if is_alive {
            self.begin(channel);
        } else {
            // Until it is seen again.
            self.left = 1;
        }
        is_alive
    }
}

impl Run {
    /// One sample. The command goes out before anything is learnt, and what can wait comes last.
    #[inline]
    fn step<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<(ControlSample<f32>, Seen<f32>), Ended> {
        let Self {
            closed_loop,
            reference,
            protection,
            ending,
            sample,
            count: last_count,
            ..
        } = self;
        protection.check_lines(lines).map_err(Ended::Faulted)?;
        let setpoint = reference.next();
        let watch = RunWatch {
            protection,
            ending,
            reference,
            last_count,
        };
        let done = closed_loop.sample(setpoint, sensor, actuator, watch)?;
        *sample = sample.wrapping_add(1);
        Ok(done)
    }
}

/// What watches over every step of a run.
struct RunWatch<'a> {
    protection: &'a mut Protection,
    ending: &'a mut Ending,
    reference: &'a mut Reference,
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

/// Tells a sample, if there is room for it. Not inlined, to be seen in the machine code.
#[inline(never)]
fn show(
    run: &Run,
    channel: &mut InterruptEnd<'_>,
    counts: &mut Counts,
    control: &ControlSample<f32>,
    seen: &Seen<f32>,
) {
    let shown = Event::Shown(Shown {
        sample: run.sample,
        learnt: run.closed_loop.learnt(),
        error: control.error,
        count: run.count.wrapping_sub(run.started_at),
        command: control.command,
        output_error: seen.output_error,
        counts: *counts,
    });
    if channel.tell(shown).is_err() {
        counts.dropped = counts.dropped.saturating_add(1);
    }
}
