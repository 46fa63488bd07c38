//! The interrupt's half: one call a sample, and nothing in it waits.

use core::fmt;

use drive_link::{Fault, Law, NotAllowed, Noticed, Settings};
use heapless::spsc::{Consumer, Producer, Queue};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor};
use identifier_core::error::OutOfRange;
use identifier_core::identifier::{self, Seen};

use crate::closed_loop::{ClosedLoop, Learnt};
use crate::parts;
use crate::protection::Protection;
use crate::reference::Reference;

/// The sample times that a drive runs at, s: 20 kHz to 1 kHz; with Gauss–Newton 8 kHz to 1 kHz.
///
/// A sample in which the first fit goes on takes 12 200 instructions at most
/// (`gauss-newton-recording-most` of the firmware's budget), which at one and a half cycles each is
/// 109 µs at 168 MHz.
fn sample_times(law: Law) -> (f64, f64) {
    let least = match law {
        Law::Gradient { .. } => 5e-5,
        Law::GaussNewton => 1.25e-4,
    };
    (least, 1e-3)
}

/// Blocks of the first fit that a sample goes through.
const SLICE: u32 = 1;

/// Orders and events that may be on their way at once, and one more; powers of two, so that a queue
/// masks where it would divide.
pub(crate) const ORDERS: usize = 4;
pub(crate) const EVENTS: usize = 8;

/// Orders on their way.
pub type Orders = Queue<Order, ORDERS>;

/// Events on their way.
pub type Events = Queue<Event, EVENTS>;

/// What the supervisor orders.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a run is handed over once, and there is no heap to put it on"
)]
pub enum Order {
    /// Close this loop where the servo stands.
    Run(Run),
    /// Send the servo to a target, counts from where it started.
    Target(i32),
    /// Let the servo go.
    Release,
    /// Forget a fault, if its cause is gone.
    Clear,
    /// Show a sample every so often; 0 for never.
    Watch(u16),
}

/// What the interrupt tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// The servo was let go as ordered; what the loop had learnt.
    Released(Option<Learnt>, Counts),
    /// The servo was let go because of a fault.
    Faulted(Fault, Counts),
    /// A fault was forgotten.
    Cleared,
    /// A sample.
    Shown(Shown),
}

/// What happened without being a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// What the identifier noticed since the start.
    pub noticed: Noticed,
    /// Samples that ended too late since the start.
    pub overruns: u32,
    /// Events that found no room since the drive was switched on.
    pub dropped: u32,
}

/// A sample as the interrupt knows it, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Samples since the start.
    pub sample: u32,
    /// What the loop has learnt.
    pub learnt: Learnt,
    /// Position error, counts.
    pub error: f32,
    /// Counts from where the servo started.
    pub count: i32,
    /// Command, command units.
    pub command: f32,
    /// Output error, counts.
    pub output_error: f32,
    /// What happened without being a fault.
    pub counts: Counts,
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
    fn in_motion(self) -> Result<(), Fault> {
        if !self.amplifier {
            Err(Fault::AmplifierFault)
        } else if self.low_switch && self.high_switch {
            Ok(())
        } else {
            Err(Fault::LimitSwitch)
        }
    }

    fn before_motion(self) -> Result<(), Fault> {
        self.in_motion().map_err(|fault| match fault {
            Fault::LimitSwitch => Fault::LimitSwitchesStuck,
            other => other,
        })
    }
}

/// A loop that is ready to be closed, with its reference and its watch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    closed_loop: ClosedLoop,
    reference: Reference,
    protection: Protection,
    sample: u32,
    started_at: i32,
}

impl Run {
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &Settings, full_scale: f64) -> Result<Self, NotAllowed> {
        let core = &settings.closed_loop.core;
        let within @ (least, most) = sample_times(settings.closed_loop.law);
        if !(least..=most).contains(&core.sample_time) {
            return Err(parts::out_of_range("sample_time", core.sample_time, within));
        }
        let controller = core.own_controller().map_err(parts::not_allowed)?;
        let [low, high] = controller.limit;
        for (name, limit) in [("limit_high", high), ("limit_low", -low)] {
            if limit > full_scale {
                return Err(parts::out_of_range(name, limit, (0.0, full_scale)));
            }
        }
        let closed_loop = ClosedLoop::new(&settings.closed_loop)?;
        let range = |error: OutOfRange| parts::not_allowed(error.into());
        let units = core.units().map_err(range)?;
        Ok(Self {
            closed_loop,
            reference: Reference::new(settings, &units).map_err(range)?,
            protection: Protection::new(settings, controller.limit, &units)?,
            sample: 0,
            started_at: 0,
        })
    }

    /// From where the servo stands. Not inlined for the same reason as [`Sampler::show`].
    #[inline(never)]
    fn start(&mut self, count: i32) {
        self.closed_loop.start(count);
        self.reference.start(count);
        self.started_at = count;
    }

    /// The loop that it closes.
    pub(crate) fn closed_loop(&self) -> &ClosedLoop {
        &self.closed_loop
    }
}

/// The interrupt's half of a drive.
pub struct Sampler<'a> {
    orders: Consumer<'a, Order, ORDERS>,
    events: Producer<'a, Event, EVENTS>,
    run: Option<Run>,
    fault: Option<Fault>,
    /// A fault, a release or its forgetting that found no room yet: it must not be lost.
    untold: Option<Event>,
    watch: Watch,
    counts: Counts,
}

impl fmt::Debug for Sampler<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sampler")
            .field("run", &self.run)
            .field("fault", &self.fault)
            .finish_non_exhaustive()
    }
}

impl<'a> Sampler<'a> {
    /// Released, with its ends of the queues and with what the boot found wrong.
    #[must_use]
    pub fn new(
        orders: Consumer<'a, Order, ORDERS>,
        events: Producer<'a, Event, EVENTS>,
        found_at_boot: Result<(), Fault>,
    ) -> Self {
        let fault = found_at_boot.err();
        Self {
            orders,
            events,
            run: None,
            fault,
            untold: fault.map(|fault| Event::Faulted(fault, Counts::default())),
            watch: Watch::default(),
            counts: Counts::default(),
        }
    }

    /// One sample.
    #[inline]
    pub fn sample<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) {
        if let Some(event) = self.untold.take() {
            self.must_tell(event);
        }
        if self.untold.is_none()
            && let Some(order) = self.orders.dequeue()
        {
            self.obey(order, lines, sensor, actuator);
        }
        let Some(run) = &mut self.run else {
            // Read even so: a counter of few bits that wraps unread loses its turns.
            let _ = sensor.count();
            let _ = actuator.release();
            return;
        };
        let (control, seen) = match run.step(lines, sensor, actuator) {
            Ok(step) => step,
            Err(fault) => return self.fail(fault, actuator),
        };
        self.counts.notice(seen.event);
        if self.watch.is_due() {
            self.show(&control, &seen);
        }
    }

    /// Tells of the sample that has just run. A function of its own, so that it can be seen in the
    /// machine code which samples are shown (`cargo xtask interrupt`).
    #[inline(never)]
    fn show(&mut self, control: &ControlSample<f32>, seen: &Seen<f32>) {
        let Some(run) = &self.run else {
            return;
        };
        let shown = Event::Shown(Shown {
            sample: run.sample,
            learnt: run.closed_loop.learnt(),
            error: control.error,
            count: run.closed_loop.count().wrapping_sub(run.started_at),
            command: control.command,
            output_error: seen.output_error,
            counts: self.counts,
        });
        if self.events.enqueue(shown).is_err() {
            self.counts.dropped = self.counts.dropped.saturating_add(1);
        }
    }

    /// What the firmware finds at the end of a sample: whether the next one was due already.
    #[inline]
    pub fn ended<A: Actuator<f32>>(&mut self, late: bool, actuator: &mut A) {
        let Some(run) = &mut self.run else {
            return;
        };
        self.counts.overruns = self.counts.overruns.saturating_add(late.into());
        if let Err(fault) = run.protection.ended(late) {
            self.fail(fault, actuator);
        }
    }

    fn obey<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        order: Order,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) {
        match order {
            // A fault that struck while the order was on its way stands.
            Order::Run(_) if self.fault.is_some() => {}
            Order::Run(run) => match lines.before_motion() {
                Ok(()) => match sensor.count() {
                    Ok(count) => {
                        self.counts.start();
                        self.run.insert(run).start(count);
                    }
                    Err(_) => self.fail(Fault::EncoderFailed, actuator),
                },
                Err(fault) => self.fail(fault, actuator),
            },
            Order::Target(counts) => {
                if let Some(run) = &mut self.run {
                    run.reference.send(run.started_at.wrapping_add(counts));
                }
            }
            Order::Release => {
                let _ = actuator.release();
                let learnt = self.run.as_ref().map(|run| run.closed_loop.learnt());
                self.run = None;
                self.must_tell(Event::Released(learnt, self.counts));
            }
            Order::Clear if self.fault.is_none() => {}
            // These need a reset, which tests again.
            Order::Clear
                if matches!(self.fault, Some(Fault::ClockNotStable | Fault::WrongAnswer)) =>
            {
                if let Some(fault) = self.fault {
                    self.must_tell(Event::Faulted(fault, self.counts));
                }
            }
            Order::Clear => match lines.before_motion() {
                Ok(()) => {
                    self.fault = None;
                    self.must_tell(Event::Cleared);
                }
                Err(fault) => self.fail(fault, actuator),
            },
            Order::Watch(every) => self.watch = Watch { every, left: 0 },
        }
    }

    #[cold]
    fn fail<A: Actuator<f32>>(&mut self, fault: Fault, actuator: &mut A) {
        let _ = actuator.release();
        self.run = None;
        self.fault = Some(fault);
        self.must_tell(Event::Faulted(fault, self.counts));
    }

    fn must_tell(&mut self, event: Event) {
        if let Err(event) = self.events.enqueue(event) {
            self.untold = Some(event);
        }
    }
}

/// Which samples are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Watch {
    /// Samples from one to the next; 0 for none.
    every: u16,
    left: u16,
}

impl Watch {
    /// Whether this sample is to be shown.
    #[inline]
    fn is_due(&mut self) -> bool {
        if self.every == 0 {
            return false;
        }
        let due = self.left == 0;
        self.left = if due { self.every } else { self.left } - 1;
        due
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
    ) -> Result<(ControlSample<f32>, Seen<f32>), Fault> {
        lines.in_motion()?;
        let setpoint = self.reference.next();
        let control = self
            .closed_loop
            .control(setpoint, sensor, actuator)
            .map_err(|error| match error {
                ControlStepError::Sensor(_) => Fault::EncoderFailed,
                ControlStepError::Actuator(_) => Fault::ActuatorFailed,
                _ => Fault::OutOfReach,
            })?;
        self.protection.check(&control)?;
        let seen = self.closed_loop.learn(&control);
        self.closed_loop.work(SLICE);
        self.sample = self.sample.wrapping_add(1);
        Ok((control, seen))
    }
}
