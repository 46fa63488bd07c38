//! The interrupt's half: one call a sample, and nothing in it waits.

use drive_link::{Ended, Fault};
use identifier_core::commission::StopReason;
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::identifier::Update;

use crate::background_alive::Patience;
use crate::channel::InterruptEnd;
use crate::chip::{Chip, Lines};
use crate::commissioning::{Commissioning, Course};
use crate::messages::{Counts, Event, Order, Returned, Standing};
use crate::run::Run;
use crate::watch::Watch;

/// The interrupt's half of a drive.
#[derive(Debug)]
pub struct Sampler<'a> {
    channel: InterruptEnd<'a>,
    run: Option<&'static mut Run>,
    commissioning: Option<&'static mut Commissioning>,
    fault: Option<Fault>,
    ended: Option<Ended>,
    /// What is on its way back.
    returned: Option<Returned>,
    /// How often was asked when there was nothing left to obey.
    asked: u32,
    /// How often the host had been heard then.
    heard: u32,
    /// The stops that were obeyed.
    stops: u32,
    /// How often another mode had been asked for then.
    mode_changes: u32,
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
            mode_changes: channel.mode_changes(),
            channel,
            run: None,
            commissioning: None,
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
            return self.without_a_run(lines, chip);
        };
        let (sensor, output) = chip.servo();
        match run.step(lines, sensor, output) {
            Ok((control, seen)) => {
                run.exchange(&mut self.channel);
                self.counts.notice(seen.event);
                if self.watch.is_due() {
                    show(run, &mut self.channel, &mut self.counts, &control, &seen);
                }
            }
            Err(ended) => return self.end(ended, output),
        }
        let in_time = !chip.next_is_due();
        if !in_time {
            self.counts.overruns = self.counts.overruns.saturating_add(1);
        }
        if let Err(ended) = run.ended(in_time) {
            let (_, output) = chip.servo();
            return self.end(ended, output);
        }
        if run.has_background(&self.channel) {
            chip.feed_watchdog();
        }
    }

    /// A sample of a servo that is commissioned, or let go.
    #[cold]
    #[inline(never)]
    fn without_a_run<C: Chip>(&mut self, lines: Lines, chip: &mut C) {
        let Some(commissioning) = &mut self.commissioning else {
            return self.rest(chip);
        };
        let (sensor, output) = chip.servo();
        match commissioning.step(lines, sensor, output, &mut self.channel) {
            Course::On => {}
            Course::NextPhase | Course::Waits => self.tell_anew(),
            Course::Over => return self.end_commissioning(output),
        }
        let Some(commissioning) = &mut self.commissioning else {
            return;
        };
        if self.watch.is_due() {
            let moved = Event::Moved(commissioning.moved());
            if self.channel.tell(moved).is_err() {
                self.counts.dropped = self.counts.dropped.saturating_add(1);
            }
        }
        let in_time = !chip.next_is_due();
        commissioning.ended(in_time);
        if !in_time {
            self.counts.overruns = self.counts.overruns.saturating_add(1);
        }
        if commissioning.has_background(&self.channel) {
            chip.feed_watchdog();
        }
    }

    fn end_commissioning<A: Actuator<f32>>(&mut self, actuator: &mut A) {
        let _ = actuator.release();
        if let Some(commissioning) = self.commissioning.take() {
            self.fault = commissioning.fault().or(self.fault);
            self.returned = Some(Returned::Commissioning(commissioning));
        }
        self.tell_anew();
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
                run.heard();
            }
            if let Some(commissioning) = &mut self.commissioning {
                commissioning.heard();
            }
        }
        let mode_changes = self.channel.mode_changes();
        if mode_changes != self.mode_changes {
            self.mode_changes = mode_changes;
            if let Some(commissioning) = &mut self.commissioning {
                commissioning.end(StopReason::ModeChanged);
            }
        }
        let stops = self.channel.stops();
        if stops != self.stops {
            self.stops = stops;
            if let Some(commissioning) = &mut self.commissioning {
                // It ends with this sample.
                commissioning.let_go(StopReason::Stopped);
                let _ = actuator.release();
            } else {
                self.end(Ended::Stopped, actuator);
            }
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
            Err(Order::Run(run) | Order::GoOn(run)) => self.give_back(Returned::Run(run)),
            Ok(Order::Run(run)) if self.fault.is_some() => self.give_back(Returned::Run(run)),
            Ok(Order::Run(run)) => match stands(lines, sensor) {
                Ok(count) => {
                    self.counts.start();
                    self.forget_fits();
                    run.start(count, &self.channel);
                    self.run = Some(run);
                }
                Err(fault) => {
                    self.returned = Some(Returned::Run(run));
                    self.end(Ended::Faulted(fault), actuator);
                }
            },
            Ok(Order::GoOn(run)) => self.go_on(run),
            Err(Order::Commission(commissioning) | Order::CommissionBeside(commissioning)) => {
                commissioning.end(StopReason::Stopped);
                self.give_back(Returned::Commissioning(commissioning));
            }
            Ok(Order::CommissionBeside(commissioning)) => self.commission_beside(commissioning),
            Ok(Order::Commission(commissioning)) => {
                let stands = self.fault.map_or_else(|| stands(lines, sensor), Err);
                match stands {
                    Ok(count) => {
                        self.counts.start();
                        self.forget_answers();
                        commissioning.start(count, &self.channel);
                        self.commissioning = Some(commissioning);
                        self.tell_anew();
                    }
                    Err(fault) => {
                        commissioning.refuse(fault);
                        self.commissioning = Some(commissioning);
                        self.end_commissioning(actuator);
                    }
                }
            }
            Ok(Order::Target(counts)) => {
                if let Some(run) = &mut self.run {
                    run.send(counts);
                }
            }
            Ok(Order::Clear) => self.clear(lines),
            Ok(Order::Watch(every)) | Err(Order::Watch(every)) => {
                self.watch = Watch::every(every);
            }
            Err(Order::Target(_) | Order::Clear) => {}
        }
    }

    /// Puts a commissioning in the place of the loop that runs, from this sample on.
    fn commission_beside(&mut self, commissioning: &'static mut Commissioning) {
        let Some(run) = self.run.take() else {
            // It has ended since.
            match self.fault {
                Some(fault) => commissioning.refuse(fault),
                None => commissioning.end(StopReason::ModeChanged),
            }
            return self.give_back(Returned::Commissioning(commissioning));
        };
        self.forget_answers();
        commissioning.take_over(&run.held(), &self.channel);
        self.commissioning = Some(commissioning);
        self.give_back(Returned::Run(run));
    }

    /// Goes on with a loop from this sample on, if a commissioning waits for it.
    fn go_on(&mut self, run: &'static mut Run) {
        let held = self.commissioning.as_ref().and_then(|over| over.held());
        let Some(held) = held.filter(|_| self.fault.is_none()) else {
            return self.give_back(Returned::Run(run));
        };
        self.forget_fits();
        run.go_on(&held, &self.channel);
        self.run = Some(run);
        if let Some(over) = self.commissioning.take() {
            self.give_back(Returned::Commissioning(over));
        }
    }

    /// Those of a run before.
    fn forget_fits(&mut self) {
        while self.channel.fitted().is_some() {}
    }

    /// Those of a commissioning before.
    fn forget_answers(&mut self) {
        while self.channel.answer().is_some() {}
    }

    fn clear(&mut self, lines: Lines) {
        // These need a reset, which tests again.
        let stays = matches!(self.fault, Some(Fault::ClockNotStable | Fault::WrongAnswer));
        if !stays && self.fault.is_some() {
            self.fault = lines.before_motion().err();
        }
        self.tell_anew();
    }

    fn give_back(&mut self, returned: Returned) {
        self.returned = Some(returned);
        self.tell_anew();
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
            self.returned = Some(Returned::Run(run));
            self.ended = Some(ended);
        }
        self.tell_anew();
    }

    #[cold]
    fn tell_anew(&mut self) {
        self.untold = true;
        self.tell();
    }

    #[cold]
    fn tell(&mut self) {
        let standing = Standing {
            fault: self.fault,
            ended: self.ended,
            returned: self.returned.take(),
            phase: self
                .commissioning
                .as_ref()
                .map(|under_way| under_way.moved().phase),
            waits: self
                .commissioning
                .as_ref()
                .is_some_and(|under_way| under_way.held().is_some()),
            stops: self.stops,
            counts: self.counts,
        };
        match self.channel.tell(Event::Standing(standing)) {
            Ok(()) => self.untold = false,
            Err(Event::Standing(standing)) => {
                self.returned = standing.returned;
                self.come_back();
            }
            Err(Event::Shown(_) | Event::Moved(_)) => {}
        }
    }

    /// There is something left to do in the next sample.
    fn come_back(&mut self) {
        self.asked = self.channel.times_asked().wrapping_sub(1);
    }
}

/// Where the servo stands, unless something keeps it from being moved.
fn stands<S: PositionSensor>(lines: Lines, sensor: &mut S) -> Result<i32, Fault> {
    lines.before_motion()?;
    sensor.count().map_err(|_| Fault::EncoderFailed)
}

/// Tells a sample, if there is room for it. Not inlined, to be seen in the machine code.
#[inline(never)]
fn show(
    run: &Run,
    channel: &mut InterruptEnd<'_>,
    counts: &mut Counts,
    control: &ControlSample<f32>,
    seen: &Update<f32>,
) {
    let shown = Event::Shown(run.shown(control, seen, counts));
    if channel.tell(shown).is_err() {
        counts.dropped = counts.dropped.saturating_add(1);
    }
}
