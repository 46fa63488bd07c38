//! The interrupt's half: one call per sample, and nothing in it waits.

use drive_link::{Ended, Fault};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::identifier::Update;
use identifier_core::reason::Reason;

use crate::background_watch::BackgroundWatch;
use crate::channel::{InterruptEnd, Recorded, Solution};
use crate::chip::{Chip, Lines};
use crate::commissioning::Course;
use crate::ending::Standstill;
use crate::messages::{Event, Examination, InterruptState, Mode, Order};
use crate::run::Run;
use crate::telemetry::{Counts, ReportTimer};

/// The interrupt's half of a drive.
#[derive(Debug)]
pub struct Sampler<'a> {
    channel: InterruptEnd<'a>,
    /// The mode that drives the servo; none while the servo is disabled.
    mode: Option<Mode>,
    fault: Option<Fault>,
    /// How the last run ended.
    ended: Option<Ended>,
    /// A mode on its way back.
    returned: Option<Mode>,
    /// The requests when there was nothing left to obey.
    requests: u32,
    /// Frames of the host, stops and changes of mode that were taken in.
    host_frames: u32,
    stops: u32,
    mode_changes: u32,
    /// The state has changed and its report has found no room yet.
    report_pending: bool,
    report_timer: ReportTimer,
    examination_timer: ReportTimer,
    counts: Counts,
    background: BackgroundWatch,
    /// The standstill of the disabled axis.
    standstill: Standstill,
}

impl<'a> Sampler<'a> {
    /// Disabled, with the faults that the boot found.
    #[must_use]
    pub fn new(channel: InterruptEnd<'a>, found_at_boot: Result<(), Fault>) -> Self {
        Self {
            requests: channel.requests().wrapping_sub(1),
            host_frames: channel.host_frames(),
            stops: channel.stops(),
            mode_changes: channel.mode_changes(),
            channel,
            mode: None,
            fault: found_at_boot.err(),
            ended: None,
            returned: None,
            report_pending: found_at_boot.is_err(),
            report_timer: ReportTimer::NEVER,
            examination_timer: ReportTimer::NEVER,
            counts: Counts::default(),
            background: BackgroundWatch::new(),
            standstill: Standstill::default(),
        }
    }

    /// All that the sample interrupt does.
    #[inline]
    pub fn interrupt<C: Chip>(&mut self, chip: &mut C) {
        let begun = chip.cycles();
        self.sample(chip);
        let taken = chip.cycles().wrapping_sub(begun);
        self.channel.set_cycles(taken);
    }

    #[inline]
    fn sample<C: Chip>(&mut self, chip: &mut C) {
        let lines = chip.lines();
        if self.channel.requests() != self.requests {
            let (sensor, output) = chip.servo();
            self.obey(lines, sensor, output);
        }
        let Some(Mode::Run(run)) = &mut self.mode else {
            return self.without_a_run(lines, chip);
        };
        let (sensor, output) = chip.servo();
        match run.step(lines, sensor, output) {
            Ok((control, update)) => {
                let channel = &mut self.channel;
                let has_exchanged = run.exchange(|block| {
                    // A fit notices a block that is lost.
                    channel.record(Recorded::Block(block));
                    match channel.solution() {
                        Some(Solution::Fit(fitted)) => Some(fitted),
                        Some(Solution::Decision(_)) | None => None,
                    }
                });
                if has_exchanged {
                    channel.drop_solution();
                }
                self.counts.count(update.event);
                if self.report_timer.is_due() {
                    let send = |sample| channel.report(sample);
                    report(run, &mut self.counts, &control, &update, send);
                }
                if self.examination_timer.is_due() {
                    let examined = Event::Examined(Examination {
                        settled: run.examine(),
                        noticed: self.counts.noticed,
                    });
                    // One that finds no room is made again.
                    let _ = channel.report(examined);
                }
            }
            Err(ended) => return self.end_run(ended, output),
        }
        let guided = run.guide(chip);
        self.standstill = Standstill::default();
        let late = self.channel.end_sample(chip.next_is_due());
        match guided.and_then(|is_home| run.end_sample(late).map(|()| is_home)) {
            Ok(false) => {}
            Ok(true) => self.report_state(),
            Err(ended) => {
                let (_, output) = chip.servo();
                return self.end_run(ended, output);
            }
        }
        self.hear();
        self.feed_watchdog(chip);
    }

    /// A sample of a servo that is commissioned, or disabled.
    #[cold]
    #[inline(never)]
    fn without_a_run<C: Chip>(&mut self, lines: Lines, chip: &mut C) {
        let Some(Mode::Commissioning(commissioning)) = &mut self.mode else {
            return self.rest(chip);
        };
        let (sensor, output) = chip.servo();
        let channel = &mut self.channel;
        let course = commissioning.step(lines, sensor, output, |event| {
            let has_room = event.is_none_or(|event| channel.record(Recorded::Event(event)));
            let decision = match channel.solution() {
                Some(Solution::Decision(decision)) => Some(decision),
                Some(Solution::Fit(_)) | None => None,
            };
            (has_room, decision)
        });
        self.channel.drop_solution();
        match course {
            Course::Continues => {}
            Course::NextPhase | Course::AwaitsResume => self.report_state(),
            Course::Over => return self.end_mode(output),
        }
        let Some(Mode::Commissioning(commissioning)) = &mut self.mode else {
            return;
        };
        if self.report_timer.is_due() {
            let sample = Event::Commissioning(commissioning.report());
            if self.channel.report(sample).is_err() {
                self.counts.dropped = self.counts.dropped.saturating_add(1);
            }
        }
        self.standstill = Standstill::default();
        commissioning.end_sample(self.channel.end_sample(chip.next_is_due()));
        self.hear();
        self.feed_watchdog(chip);
    }

    /// A sample of a servo that is disabled.
    #[cold]
    fn rest<C: Chip>(&mut self, chip: &mut C) {
        let (sensor, output) = chip.servo();
        // Read even so: a counter of few bits that wraps unread loses its turns.
        let count = sensor.count();
        let stands_for = count.map_or(0, |count| self.standstill.take(count));
        self.channel.set_standstill(stands_for);
        let is_disabled = output.release().is_ok();
        if !is_disabled && self.fault.is_none() {
            self.fault = Some(Fault::ActuatorFailed);
            self.report_state();
        }
        // It follows the sample time that was configured since.
        let patience = self.channel.disabled_patience();
        self.background.set_patience(patience);
        self.feed_watchdog(chip);
    }

    /// Takes in frames of the host, which no command waits for.
    #[inline]
    fn hear(&mut self) {
        let host_frames = self.channel.host_frames();
        if host_frames == self.host_frames {
            return;
        }
        self.host_frames = host_frames;
        match &mut self.mode {
            Some(Mode::Run(run)) => run.link_alive(),
            Some(Mode::Commissioning(commissioning)) => commissioning.link_alive(),
            None => {}
        }
    }

    /// Feeds the watchdog as long as the background runs.
    #[inline]
    fn feed_watchdog<C: Chip>(&mut self, chip: &mut C) {
        if self.background.lasts(|| self.channel.background_turns()) {
            chip.feed_watchdog();
        }
    }

    /// Obeys a stop, reports a pending state, and does the next order, one per sample, until nothing is left.
    #[cold]
    #[inline(never)]
    fn obey<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) {
        let requests = self.channel.requests();
        let mode_changes = self.channel.mode_changes();
        if mode_changes != self.mode_changes {
            self.mode_changes = mode_changes;
            if let Some(Mode::Commissioning(commissioning)) = &mut self.mode {
                commissioning.end(Reason::ModeChanged);
            }
        }
        let stops = self.channel.stops();
        if stops != self.stops {
            self.stops = stops;
            if let Some(Mode::Commissioning(commissioning)) = &mut self.mode {
                // It ends with this sample, which disables the output again and notices if that fails.
                commissioning.abort(Reason::Stopped);
                let _ = actuator.release();
            } else {
                self.end_run(Ended::Stopped, actuator);
            }
        }
        if self.report_pending {
            self.try_report_state();
        }
        if self.report_pending {
            return;
        }
        match self.channel.order() {
            Some(Ok(order)) => self.carry_out(order, lines, sensor, actuator),
            Some(Err(overtaken)) => self.refuse_overtaken(overtaken),
            None => self.requests = requests,
        }
    }

    /// A stop has overtaken an order.
    fn refuse_overtaken(&mut self, order: Order) {
        match order {
            Order::Begin(mode) | Order::Replace(mode) => self.refuse(mode, Reason::Stopped),
            Order::Watch(interval) => self.report_timer = ReportTimer::every(interval),
            Order::Target(_) | Order::Home | Order::Clear => {}
        }
    }

    fn carry_out<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        order: Order,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) {
        match order {
            Order::Begin(mode) => self.begin(mode, lines, sensor, actuator),
            Order::Replace(mode) => self.replace(mode),
            Order::Target(counts) => {
                if let Some(Mode::Run(run)) = &mut self.mode {
                    run.set_target(counts);
                }
            }
            Order::Home => {
                if let Some(Mode::Run(run)) = &mut self.mode {
                    run.home();
                }
            }
            Order::Clear => self.clear(lines),
            Order::Watch(interval) => self.report_timer = ReportTimer::every(interval),
        }
    }

    /// Begins a mode from the servo's rest position, unless a fault holds, old or new.
    fn begin<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        mut mode: Mode,
        lines: Lines,
        sensor: &mut S,
        actuator: &mut A,
    ) {
        let found = self.fault.map_or_else(|| rest_count(lines, sensor), Err);
        match (&mut mode, found) {
            (Mode::Run(run), Ok(count)) => run.start(count),
            (Mode::Commissioning(commissioning), Ok(count)) => commissioning.start(count),
            // It stands since before the order.
            (Mode::Run(_), Err(_)) if self.fault.is_some() => return self.give_back(mode),
            (Mode::Run(_), Err(fault)) => {
                (self.fault, self.mode) = (Some(fault), Some(mode));
                return self.end_mode(actuator);
            }
            (Mode::Commissioning(commissioning), Err(fault)) => {
                commissioning.abort_with_fault(fault);
                self.mode = Some(mode);
                return self.end_mode(actuator);
            }
        }
        self.counts.start();
        self.channel.start_overruns();
        let is_commissioning = matches!(mode, Mode::Commissioning(_));
        self.drive_by(mode);
        if is_commissioning {
            self.report_state();
        }
    }

    /// Puts a mode in the place of the one that drives the servo, from this sample on.
    fn replace(&mut self, mut mode: Mode) {
        let handover = match (&self.mode, &mode) {
            (Some(Mode::Run(run)), Mode::Commissioning(_)) => Some(run.handover()),
            (Some(Mode::Commissioning(over)), Mode::Run(_)) if self.fault.is_none() => {
                over.handover()
            }
            // It has ended since.
            _ => None,
        };
        let Some(handover) = handover else {
            return self.refuse(mode, Reason::ModeChanged);
        };
        match &mut mode {
            Mode::Run(run) => run.take_over(&handover),
            Mode::Commissioning(commissioning) => commissioning.take_over(&handover),
        }
        let replaced = self.mode.take();
        self.drive_by(mode);
        if let Some(replaced) = replaced {
            self.give_back(replaced);
        }
    }

    /// Has a mode drive the servo from now on.
    fn drive_by(&mut self, mode: Mode) {
        // Solutions for a mode before it.
        while self.channel.drop_solution() {}
        let (patience, interval) = match &mode {
            Mode::Run(run) => (run.background_patience(), run.examination_interval()),
            Mode::Commissioning(commissioning) => (commissioning.background_patience(), 0),
        };
        self.examination_timer = ReportTimer::every(interval);
        let turns = self.channel.background_turns();
        self.background.begin(patience, turns);
        self.mode = Some(mode);
    }

    /// Returns a mode that cannot begin: for the fault that holds, or else for this reason.
    fn refuse(&mut self, mut mode: Mode, reason: Reason) {
        if let Mode::Commissioning(commissioning) = &mut mode {
            match self.fault {
                Some(fault) if reason != Reason::Stopped => {
                    commissioning.abort_with_fault(fault);
                }
                _ => commissioning.end(reason),
            }
        }
        self.give_back(mode);
    }

    fn clear(&mut self, lines: Lines) {
        // These need a reset, which tests again.
        let stays = self.fault.is_some_and(Fault::needs_reset);
        if !stays && self.fault.is_some() {
            self.fault = lines.before_motion().err();
        }
        self.report_state();
    }

    fn give_back(&mut self, mode: Mode) {
        self.returned = Some(mode);
        self.report_state();
    }

    /// Ends a run, and disables the servo whether there is one or not. Not inlined, to be seen in the machine code.
    #[cold]
    #[inline(never)]
    fn end_run<A: Actuator<f32>>(&mut self, ended: Ended, actuator: &mut A) {
        if let Ended::Faulted(fault) = ended {
            self.fault = Some(fault);
        }
        if self.mode.is_some() {
            self.ended = Some(ended);
        }
        self.end_mode(actuator);
    }

    /// Disables the servo and returns the mode that has driven it.
    fn end_mode<A: Actuator<f32>>(&mut self, actuator: &mut A) {
        if actuator.release().is_err() {
            self.fault = self.fault.or(Some(Fault::ActuatorFailed));
        }
        if let Some(mode) = self.mode.take() {
            if let Mode::Commissioning(commissioning) = &mode {
                self.fault = commissioning.fault().or(self.fault);
            }
            self.returned = Some(mode);
            let turns = self.channel.background_turns();
            let patience = self.channel.disabled_patience();
            self.background.begin(patience, turns);
        }
        self.report_state();
    }

    #[cold]
    fn report_state(&mut self) {
        self.report_pending = true;
        self.try_report_state();
    }

    #[cold]
    fn try_report_state(&mut self) {
        let (commissioning, run) = match &self.mode {
            Some(Mode::Commissioning(commissioning)) => (Some(commissioning), None),
            Some(Mode::Run(run)) => (None, Some(run)),
            None => (None, None),
        };
        let state = InterruptState {
            fault: self.fault,
            ended: self.ended,
            returned: self.returned.take(),
            phase: commissioning.map(|under_way| under_way.report().phase),
            origin: run.map(|run| run.origin()),
            awaits_resume: commissioning.is_some_and(|over| over.handover().is_some()),
            stops: self.stops,
            counts: self.counts,
        };
        match self.channel.report(Event::State(state)) {
            Ok(()) => self.report_pending = false,
            Err(Event::State(state)) => {
                self.returned = state.returned;
                // The next sample tries again.
                self.requests = self.channel.requests().wrapping_sub(1);
            }
            Err(Event::Run(_) | Event::Commissioning(_) | Event::Examined(_)) => {}
        }
    }
}

/// The count of the servo at rest, unless a fault prevents its motion.
fn rest_count<S: PositionSensor>(lines: Lines, sensor: &mut S) -> Result<i32, Fault> {
    lines.before_motion()?;
    sensor.count().map_err(|_| Fault::EncoderLost)
}

/// Reports a sample, if there is room for it. Not inlined, to be seen in the machine code; generic, to be compiled with the
/// interrupt, for speed.
#[inline(never)]
fn report(
    run: &Run,
    counts: &mut Counts,
    control: &ControlSample<f32>,
    update: &Update<f32>,
    send: impl FnOnce(Event) -> Result<(), Event>,
) {
    let sample = Event::Run(run.report(control, update, counts));
    if send(sample).is_err() {
        counts.dropped = counts.dropped.saturating_add(1);
    }
}
