//! The interrupt's half: one call per sample, and nothing in it waits.

use drive_link::{Ended, Fault};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::identifier::Update;
use identifier_core::reason::{Reason, StopCategory};

use crate::background_watch::BackgroundWatch;
use crate::brake::{BrakeMotion, BrakeTimes};
use crate::channel::{InterruptEnd, Recorded, Solution};
use crate::chip::{Chip, Lines};
use crate::commissioning::Course;
use crate::ending::{Coasting, Standstill};
use crate::guide::Origin;
use crate::messages::{Event, Examination, InterruptState, Mode, Order};
use crate::run::Run;
use crate::telemetry::{Counts, ReportTimer};

/// The interrupt's half of a drive.
#[derive(Debug)]
pub struct Sampler<'a> {
    channel: InterruptEnd<'a>,
    /// The mode that drives the servo; none while the servo is disabled.
    mode: Option<Mode>,
    brake: BrakeMotion,
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
    new_stops: u32,
    mode_changes: u32,
    /// The position of the disabled axis may have been lost.
    is_count_lost: bool,
    /// The state has changed and its report has found no room yet.
    report_pending: bool,
    report_timer: ReportTimer,
    examination_timer: ReportTimer,
    counts: Counts,
    background: BackgroundWatch,
    /// Standstill and motion of the disabled axis.
    standstill: Standstill,
    coasting: Coasting,
}

impl<'a> Sampler<'a> {
    /// Disabled, with the faults that the boot found.
    #[must_use]
    pub fn new(channel: InterruptEnd<'a>, found_at_boot: Result<(), Fault>) -> Self {
        Self {
            requests: channel.requests().wrapping_sub(1),
            host_frames: channel.host_frames(),
            stops: channel.stops(),
            new_stops: channel.new_stops(),
            mode_changes: channel.mode_changes(),
            channel,
            mode: None,
            brake: BrakeMotion::Settled,
            fault: found_at_boot.err(),
            ended: None,
            returned: None,
            is_count_lost: false,
            report_pending: found_at_boot.is_err(),
            report_timer: ReportTimer::NEVER,
            examination_timer: ReportTimer::NEVER,
            counts: Counts::default(),
            background: BackgroundWatch::new(),
            standstill: Standstill::default(),
            coasting: Coasting::default(),
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
            self.obey(lines, chip);
        }
        let Some(Mode::Run(run)) = &mut self.mode else {
            return self.without_a_run(lines, chip);
        };
        let (sensor, output) = chip.servo();
        match run.step(lines, sensor, output) {
            Ok((control, update)) => {
                let channel = &mut self.channel;
                let has_exchanged = run.exchange(|part| {
                    // The background notices one that is lost.
                    channel.record(Recorded::Motion(part));
                    match channel.solution() {
                        Some(Solution::Run(learning)) => Some(learning),
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
            Err(ended) => return self.end_run(ended, chip),
        }
        let guided = run.guide(chip);
        let late = self.channel.end_sample(chip.next_is_due(), run.count());
        match guided.and_then(|is_home| run.end_sample(late).map(|()| is_home)) {
            Ok(false) => {}
            Ok(true) => self.report_state(),
            Err(ended) => return self.end_run(ended, chip),
        }
        self.hear();
        self.feed_watchdog(chip);
    }

    /// A sample of a servo that is commissioned, or disabled.
    #[cold]
    #[inline(never)]
    fn without_a_run<C: Chip>(&mut self, lines: Lines, chip: &mut C) {
        let Some(Mode::Commissioning(commissioning)) = &mut self.mode else {
            return self.rest(lines, chip);
        };
        commissioning.miss_steps(chip.steps());
        let (sensor, output) = chip.servo();
        let channel = &mut self.channel;
        let course = commissioning.step(lines, sensor, output, |event| {
            let has_room = event.is_none_or(|event| channel.record(Recorded::Event(event)));
            let decision = match channel.solution() {
                Some(Solution::Decision(decision)) => Some(&**decision),
                Some(Solution::Run(_)) | None => None,
            };
            (has_room, decision)
        });
        self.channel.drop_solution();
        let holds = commissioning.holds();
        match course {
            Course::Continues => {}
            Course::NextPhase | Course::AwaitsResume => self.report_state(),
            // It holds the servo until its brake has closed.
            Course::Over if holds && self.closes_brake() => {}
            Course::Over => {
                if !self.begin_closing(Ended::Over, chip) {
                    return self.end_mode(chip);
                }
            }
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
        let count = commissioning.count();
        commissioning.end_sample(self.channel.end_sample(chip.next_is_due(), count));
        self.hear();
        self.feed_watchdog(chip);
    }

    /// A sample of a servo that is disabled.
    #[cold]
    fn rest<C: Chip>(&mut self, lines: Lines, chip: &mut C) {
        let (sensor, output) = chip.servo();
        // Read even so: a counter of few bits that wraps unread loses its turns.
        let count = sensor.count();
        // It follows the sample time that was configured since.
        let patience = self.channel.disabled_patience();
        if let Ok(count) = count {
            self.channel.set_start(count);
            let stands_for = self.standstill.take(count);
            let coasted = self.coasting.take(count, self.channel.coasting_window());
            self.channel.set_standstill(stands_for, coasted);
        } else {
            self.channel.set_standstill(0, 0);
        }
        if count.is_err() || !lines.supply {
            self.lose_count();
        }
        let is_disabled = output.release().is_ok();
        if !is_disabled && self.fault.is_none() {
            self.fault = Some(Fault::ActuatorFailed);
            self.report_state();
        }
        self.background.set_patience(patience);
        self.feed_watchdog(chip);
    }

    /// The position of the disabled axis may be another from now on.
    fn lose_count(&mut self) {
        let is_new = !core::mem::replace(&mut self.is_count_lost, true);
        if is_new && !self.fault.is_some_and(Fault::loses_position) {
            self.report_state();
        }
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

    /// Goes on with the brake, obeys a stop, reports a pending state, and does the next order, one per sample, until nothing is left.
    #[cold]
    #[inline(never)]
    fn obey<C: Chip>(&mut self, lines: Lines, chip: &mut C) {
        let requests = self.channel.requests();
        self.advance_brake(chip);
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
            let new_stops = self.channel.new_stops();
            let is_new = core::mem::replace(&mut self.new_stops, new_stops) != new_stops;
            let is_held = match &mut self.brake {
                BrakeMotion::Closing { is_stopped, .. } => {
                    !core::mem::replace(is_stopped, true) || !is_new
                }
                _ => self.begin_closing(Ended::Stopped, chip),
            };
            match &mut self.mode {
                _ if is_held => {}
                Some(Mode::Commissioning(commissioning)) => {
                    // It ends with this sample, which disables the output again and notices if that fails.
                    commissioning.abort(Reason::Stopped);
                    let (_, output) = chip.servo();
                    let _ = output.release();
                }
                _ => self.end_run(Ended::Stopped, chip),
            }
        }
        if self.report_pending {
            self.try_report_state();
        }
        if self.report_pending {
            return;
        }
        match self.channel.order() {
            Some(Ok(order)) => self.carry_out(order, lines, chip),
            Some(Err(overtaken)) => self.refuse_overtaken(overtaken),
            None if self.brake == BrakeMotion::Settled => self.requests = requests,
            None => {}
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

    fn carry_out<C: Chip>(&mut self, order: Order, lines: Lines, chip: &mut C) {
        match order {
            Order::Begin(mode) => self.begin(mode, lines, chip),
            Order::Replace(mode) => self.replace(mode),
            Order::Target(target) => {
                if let Some(Mode::Run(run)) = &mut self.mode {
                    run.set_target(target);
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
    fn begin<C: Chip>(&mut self, mut mode: Mode, lines: Lines, chip: &mut C) {
        let (sensor, _) = chip.servo();
        let is_count_lost = core::mem::take(&mut self.is_count_lost);
        let found = self.fault.map_or_else(|| rest_count(lines, sensor), Err);
        match (&mut mode, found) {
            (Mode::Run(run), Ok(count)) => {
                self.channel.set_start(count);
                if is_count_lost {
                    run.set_origin(Origin::Start);
                }
                run.start(count);
            }
            (Mode::Commissioning(commissioning), Ok(count)) => {
                self.channel.set_start(count);
                commissioning.start(count);
            }
            // It stands since before the order.
            (Mode::Run(_), Err(_)) if self.fault.is_some() => return self.give_back(mode),
            (Mode::Run(_), Err(fault)) => {
                (self.fault, self.mode) = (Some(fault), Some(mode));
                return self.end_mode(chip);
            }
            (Mode::Commissioning(commissioning), Err(fault)) => {
                commissioning.abort_with_fault(fault);
                self.mode = Some(mode);
                return self.end_mode(chip);
            }
        }
        if let Some(BrakeTimes { opens, .. }) = mode.brake() {
            mode.wait(opens);
            self.brake = BrakeMotion::Opening { left: opens };
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
            _ if self.closes_brake() => None,
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
        if let BrakeMotion::Opening { left } = self.brake {
            mode.wait(left);
        }
        let replaced = self.mode.take();
        self.drive_by(mode);
        if let Some(replaced) = replaced {
            self.give_back(replaced);
        }
    }

    /// Has a mode drive the servo from now on.
    fn drive_by(&mut self, mode: Mode) {
        self.standstill = Standstill::default();
        self.channel.set_standstill(0, 0);
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

    /// Ends a run, and disables the servo whether there is one or not, or holds it until its brake has closed. Not inlined,
    /// to be seen in the machine code.
    #[cold]
    #[inline(never)]
    fn end_run<C: Chip>(&mut self, ended: Ended, chip: &mut C) {
        if self.begin_closing(ended, chip) {
            return;
        }
        let ended = match self.brake {
            BrakeMotion::Closing { ended: first, .. } => first.joined(ended),
            BrakeMotion::Settled | BrakeMotion::Opening { .. } => ended,
        };
        self.add_fault(ended.fault());
        if let Some(Mode::Run(_)) = self.mode {
            self.ended = Some(ended);
        }
        self.end_mode(chip);
    }

    /// Has the brake close while the servo is held. False if it is to be disabled at once: at an end of stop category 0,
    /// without a brake, if nothing holds it, or at a second end.
    fn begin_closing<C: Chip>(&mut self, ended: Ended, chip: &mut C) -> bool {
        let closing = self.closes_brake();
        let Some(mode) = self.mode.as_mut().filter(|mode| mode.holds() && !closing) else {
            return false;
        };
        match (ended.stop_category(), mode.brake()) {
            (StopCategory::Immediate, _) | (_, None) => false,
            (StopCategory::Controlled, Some(BrakeTimes { closes, .. })) => {
                chip.set_brake(false);
                mode.hold(ended);
                self.brake = BrakeMotion::Closing {
                    left: closes,
                    ended,
                    is_stopped: ended == Ended::Stopped,
                };
                self.look_again();
                self.report_state();
                true
            }
        }
    }

    /// A sample of a brake that opens or closes.
    fn advance_brake<C: Chip>(&mut self, chip: &mut C) {
        match &mut self.brake {
            BrakeMotion::Settled => {}
            BrakeMotion::Opening { left } => {
                // Only a servo that is held is let go by its brake.
                if self.mode.as_ref().is_none_or(|mode| !mode.holds()) {
                    return;
                }
                chip.set_brake(true);
                *left = left.saturating_sub(1);
                if *left == 0 {
                    self.brake = BrakeMotion::Settled;
                    if let Some(Mode::Run(run)) = &mut self.mode {
                        run.go();
                    }
                }
            }
            BrakeMotion::Closing { left, ended, .. } => {
                *left = left.saturating_sub(1);
                if *left == 0 {
                    let ended = *ended;
                    self.end_run(ended, chip);
                }
            }
        }
    }

    /// True while the servo is held until its brake has closed.
    fn closes_brake(&self) -> bool {
        matches!(self.brake, BrakeMotion::Closing { .. })
    }

    /// Has the next sample obey and report, whether there are requests or not.
    fn look_again(&mut self) {
        self.requests = self.channel.requests().wrapping_sub(1);
    }

    /// Takes in a fault; the gravest one holds.
    fn add_fault(&mut self, fault: Option<Fault>) {
        self.fault = Fault::graver(self.fault, fault);
    }

    /// Disables the servo and returns the mode that has driven it.
    fn end_mode<C: Chip>(&mut self, chip: &mut C) {
        chip.set_brake(false);
        self.brake = BrakeMotion::Settled;
        let (_, output) = chip.servo();
        if output.release().is_err() {
            self.add_fault(Some(Fault::ActuatorFailed));
        }
        if let Some(mode) = self.mode.take() {
            if let Mode::Commissioning(commissioning) = &mode {
                self.add_fault(commissioning.fault());
            }
            let count = match &mode {
                Mode::Run(run) => run.count(),
                Mode::Commissioning(commissioning) => commissioning.count(),
            };
            self.returned = Some(mode);
            let turns = self.channel.background_turns();
            let patience = self.channel.disabled_patience();
            self.background.begin(patience, turns);
            self.coasting = Coasting::begin(count, self.channel.coasting_window());
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
            origin: run
                .map(|run| run.origin())
                .or(self.is_count_lost.then_some(Origin::Start)),
            index_from_edge: run.and_then(|run| run.index_from_edge()),
            closes_brake: self.closes_brake(),
            awaits_resume: commissioning.is_some_and(|over| over.handover().is_some()),
            stops: self.stops,
            counts: self.counts,
        };
        match self.channel.report(Event::State(state)) {
            Ok(()) => self.report_pending = false,
            Err(Event::State(state)) => {
                self.returned = state.returned;
                // The next sample tries again.
                self.look_again();
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
