//! The background's half: everything that may take its time.

mod changes;
mod commission;
mod memory;
mod orders;
mod records;
mod reports;
mod runs;
mod solver;

use core::fmt;

use commissioning::servo_change::ServoChangeState;
use commissioning::{CommissionSettings, Phase};
use drive_link::{
    BoardTest, BootChecks, Command, Commissioned, Ended, Estimates, Fault, Kept, Noticed, Outcome,
    Refusal, Report, Request, Settings, State, TargetSource,
};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::reason::Reason;

pub use self::memory::Memory;
use self::memory::Slot;
use self::orders::Orders;
pub use self::records::Records;
use self::solver::Solver;
use crate::built::Part;
use crate::channel::{BackgroundEnd, Heard};
use crate::chip::OutputStage;
use crate::closed_loop::Identifier;
use crate::commissioning::Commissioning;
use crate::ending::Coasting;
use crate::guide::{Origin, TargetsFrom};
use crate::limits::AllowedRange;
use crate::messages::{Mode, Order};
use crate::run::Run;
use crate::store::Store;
use crate::telemetry::Counts;

/// The longest that the background may be busy while the servo is disabled, s. Building a loop takes a hundredth of it.
/// While the flash erases there are no samples that could miss the background.
const DISABLED_PATIENCE: f64 = 5.0;

/// The background's half of a drive.
pub struct Supervisor<'a, F> {
    channel: BackgroundEnd<'a>,
    store: Store<F>,
    kept: Kept,
    stage: OutputStage,
    settings: Settings,
    configured: bool,
    /// Memory in which a run is built, unless the interrupt has it.
    run_slot: Option<Slot<Run>>,
    /// That of the loop that was started last, to convert samples of the interrupt to SI.
    identifier: Option<Identifier>,
    estimates: Option<Estimates>,
    /// Those that the last run has begun with.
    known_before: Option<Estimates>,
    /// Memory in which a commissioning is built, unless the interrupt has it.
    commissioning_slot: Option<Slot<Part<Commissioning>>>,
    solver: Solver,
    /// The last reported reason why there is no first fit.
    rejection_reason: Option<Reason>,
    /// Changes of the servo in the last run.
    changes: ServoChangeState,
    /// Events of the identifier at the last examination.
    examined_at: Noticed,
    /// The last commissioning that was requested, its phase if it is under way, and the outcome of the last one.
    requested: Option<CommissionSettings>,
    phase: Phase,
    outcome: Option<Outcome>,
    /// The origin of targets and travel, by the last report.
    origin: Origin,
    /// The distance of the index pulse from the edge of the home switch, counts, by the last homing that found both.
    index_from_edge: Option<i32>,
    orders: Orders,
    /// A commissioning is over and holds the servo for a run to resume.
    awaits_resume: bool,
    /// The settings in force are saved as soon as the servo is disabled, and at standstill if that takes erasing.
    save_pending: bool,
    /// The commissioning that the gains come from, unless they were given.
    commissioned: Option<Commissioned>,
    fault: Option<Fault>,
    ended: Option<Ended>,
    /// The stops that the interrupt has obeyed, and whether it holds the servo until its brake has closed.
    stops: u32,
    closes_brake: bool,
    counts: Counts,
    /// Samples of the interrupt that were not reported for want of room on the line.
    reports_dropped: u32,
    garbled: u32,
    boot: BootChecks,
    board_test: BoardTest,
}

impl<F> fmt::Debug for Supervisor<'_, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Supervisor")
            .field("fault", &self.fault)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl<'a, F: NorFlash> Supervisor<'a, F> {
    /// With the record that was found, or else unconfigured, with settings to begin from. Faults that the boot
    /// found hold from the beginning.
    #[inline(never)]
    pub fn new(
        channel: BackgroundEnd<'a>,
        memory: &'static mut Memory,
        records: Records<F>,
        built_in: &Settings,
        stage: OutputStage,
        found_at_boot: Result<(), Fault>,
    ) -> Self {
        let Records {
            store,
            record,
            kept,
        } = records;
        let record = record.as_ref();
        let supervisor = Self {
            stops: channel.stops(),
            channel,
            store,
            kept,
            stage,
            configured: record.is_some(),
            settings: record.map_or(*built_in, |record| record.settings),
            run_slot: Some(Slot::Blank(&mut memory.run)),
            identifier: None,
            estimates: record.and_then(|record| record.estimates),
            known_before: None,
            commissioning_slot: Some(Slot::Blank(&mut memory.commissioning)),
            solver: Solver::in_memory(&mut memory.solver),
            rejection_reason: None,
            changes: ServoChangeState::default(),
            examined_at: Noticed::default(),
            requested: None,
            phase: Phase::Idle,
            outcome: record.and_then(Self::outcome_in),
            origin: Origin::Start,
            index_from_edge: None,
            orders: Orders::default(),
            awaits_resume: false,
            // A commissioning that was interrupted is reported once; again, if that cannot be saved.
            save_pending: record.is_some_and(|record| record.under_way),
            commissioned: record.and_then(|record| record.commissioned),
            fault: found_at_boot.err(),
            ended: None,
            closes_brake: false,
            counts: Counts::default(),
            reports_dropped: 0,
            garbled: 0,
            boot: BootChecks::PASSED,
            board_test: BoardTest::default(),
        };
        supervisor.set_disabled_times();
        supervisor
    }

    /// Sets what the boot has found, which the status reports.
    pub fn set_boot_checks(&mut self, boot: BootChecks) {
        self.boot = boot;
    }

    /// Sets the test of the board, which a request reports.
    pub fn set_board_test(&mut self, test: BoardTest) {
        let servo_on_chip = self.stage.is_simulated;
        self.board_test = BoardTest {
            servo_on_chip,
            ..test
        };
    }

    /// Has the interrupt watch a disabled servo by the settings in force.
    fn set_disabled_times(&self) {
        // A cast saturates.
        let patience = (DISABLED_PATIENCE / self.sample_time()) as u32;
        self.channel
            .set_disabled_times(patience, self.coasting_window());
    }

    /// Samples over which the motion of the disabled axis is seen.
    fn coasting_window(&self) -> u32 {
        let speed = self.settings.protection.speed / self.resolution() * self.sample_time();
        Coasting::window(speed, self.sample_time())
    }

    /// The sample time that holds, s: the firmware's timer follows it while the stage is disabled.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.settings.closed_loop.core.sample_time
    }

    /// The state of the drive.
    #[must_use]
    pub fn state(&self) -> State {
        match self.fault {
            Some(fault) => State::Faulted(fault),
            None if self.is_commissioning() => State::Commissioning,
            None if self.run_slot.is_none() => State::Running,
            None => State::Disabled,
        }
    }

    /// True if the interrupt has a mode, by its last report.
    fn is_driven(&self) -> bool {
        self.run_slot.is_none() || self.is_commissioning()
    }

    /// True if it has a commissioning.
    fn is_commissioning(&self) -> bool {
        self.commissioning_slot.is_none()
    }

    /// True until the interrupt has reported that it has obeyed a stop, and until the brake has closed at an end.
    fn is_stopping(&self) -> bool {
        self.closes_brake || self.stops != self.channel.stops()
    }

    /// Estimates of the last run, or of the one that was saved.
    #[must_use]
    pub fn estimates(&self) -> Option<Estimates> {
        self.estimates
    }

    /// Counts a turn of the background, without which the watchdog is not fed.
    pub fn count_turn(&self) {
        self.channel.count_turn();
    }

    /// Does the work that the interrupt leaves to the background. True if there is more of it before the next sample.
    pub fn work(&mut self) -> bool {
        if self.awaits_resume {
            self.resume();
        }
        self.save_if_pending();
        self.solver.work(&mut self.channel)
    }

    /// All that was heard on the line so far.
    pub(crate) fn heard(&self) -> Heard {
        self.channel.heard()
    }

    /// Takes in that every byte was decoded in which this was heard.
    pub(crate) fn set_decoded(&mut self, heard: Heard) {
        self.channel.set_decoded(heard);
    }

    /// Carries a request out, and answers it.
    pub fn answer(&mut self, request: &Request) -> Report {
        self.answer_after(request, || {})
    }

    /// The same, but listens to the line before motion is ordered. Building a loop and saving a record take many times
    /// as long as a stop, which may have come meanwhile.
    pub fn answer_after(&mut self, request: &Request, listen: impl FnOnce()) -> Report {
        let done = self.obey(request, listen);
        self.answer_to(request, done)
    }

    /// Carries a request out.
    pub(crate) fn obey(&mut self, request: &Request, listen: impl FnOnce()) -> Result<(), Refusal> {
        let command = &request.command;
        if command.may_move() && !self.orders.take(request)? {
            return Ok(());
        }
        self.carry_out(command, listen)?;
        if command.may_move() {
            self.orders.end();
        }
        if command.keeps_alive() {
            self.channel.count_host_frame();
        }
        Ok(())
    }

    /// The answer to a request that was carried out, or not.
    #[inline(never)]
    pub(crate) fn answer_to(&self, request: &Request, done: Result<(), Refusal>) -> Report {
        let id = request.id;
        let refused = |refusal| Report::Refused { id, refusal };
        match done {
            Ok(()) => match request.command {
                // A save may lose home.
                Command::Hello | Command::KeepAlive | Command::Save => self.status(Some(id)),
                Command::Show => Report::Settings {
                    id,
                    settings: self.settings,
                },
                Command::Outcome => self.outcome.clone().map_or_else(
                    || refused(Refusal::NeverCommissioned),
                    |outcome| Report::Outcome { id, outcome },
                ),
                Command::MotionRecord(first) => Report::MotionRecord {
                    id,
                    part: self.solver.motion_record(first),
                },
                Command::BoardTest => Report::BoardTest {
                    id,
                    test: self.board_test.clone(),
                },
                _ => Report::Done { id },
            },
            Err(refusal) => refused(refusal),
        }
    }

    fn carry_out(&mut self, command: &Command, listen: impl FnOnce()) -> Result<(), Refusal> {
        if command.may_move() {
            self.must_be_last()?;
        }
        match command {
            Command::Hello
            | Command::KeepAlive
            | Command::Show
            | Command::Outcome
            | Command::MotionRecord(_)
            | Command::BoardTest => {}
            Command::Configure(_) | Command::Start if self.is_commissioning() => {
                self.channel.change_mode();
                return Err(Refusal::EndedCommissioning);
            }
            Command::Configure(settings) => {
                self.must_be_disabled()?;
                Run::check(settings, &self.stage).map_err(Refusal::Setting)?;
                // These settings may be of another servo than the one that was identified.
                if settings.closed_loop != self.settings.closed_loop {
                    self.estimates = None;
                    self.commissioned = None;
                }
                let resolution = |of: &Settings| of.closed_loop.core.resolution.to_bits();
                if settings.homing != self.settings.homing
                    || resolution(settings) != resolution(&self.settings)
                {
                    self.origin = Origin::Start;
                }
                self.settings = *settings;
                self.configured = true;
                self.set_disabled_times();
            }
            Command::Start => {
                // Of a host that does not know of another's.
                if self.state() == State::Running && !self.is_stopping() {
                    return Ok(());
                }
                self.start(listen)?;
            }
            Command::Target(radians) => {
                let from = match self.settings.homing {
                    Some(_) => TargetsFrom::Home,
                    None => TargetsFrom::Start,
                };
                self.target(from, *radians)?;
            }
            Command::RelativeTarget(radians) => self.target(TargetsFrom::Start, *radians)?,
            Command::Home => {
                self.must_be_running()?;
                if self.settings.homing.is_none() {
                    return Err(Refusal::NoHoming);
                }
                // The same.
                if self.origin != Origin::Sought {
                    self.order(Order::Home)?;
                    self.origin = Origin::Sought;
                }
            }
            Command::Stop => {
                if !self.channel.decode_stop() {
                    self.channel.stop();
                }
            }
            Command::Clear => {
                if let State::Faulted(_) = self.state() {
                    self.order(Order::Clear)?;
                }
            }
            Command::Watch(every) => self.order(Order::Watch(*every))?,
            Command::Save => {
                // Writing stops the processor, and with it the loop.
                self.must_be_disabled()?;
                self.keep(false)?;
            }
            Command::Commission(settings) => self.commission(settings, listen)?,
        }
        Ok(())
    }

    /// The request in hand is the last that was heard on the line, and whole.
    fn must_be_last(&self) -> Result<(), Refusal> {
        if self.channel.is_overtaken() {
            Err(Refusal::Overtaken)
        } else if self.channel.is_uncertain() {
            Err(Refusal::LineDisturbed)
        } else {
            Ok(())
        }
    }

    /// The loop is closed, and stays so.
    fn must_be_running(&self) -> Result<(), Refusal> {
        if self.state() != State::Running || self.is_stopping() {
            return Err(Refusal::NotRunning);
        }
        Ok(())
    }

    /// Not on the way home.
    fn must_not_be_homing(&self) -> Result<(), Refusal> {
        if self.origin == Origin::Sought {
            return Err(Refusal::Homing);
        }
        Ok(())
    }

    /// Disabled and configured, and the axis hardly moves, within the travel: it may be driven.
    fn must_be_startable(&self) -> Result<(), Refusal> {
        /// Part of the largest speed that an axis may have at a start: the loop needs room to brake it.
        const SPEED_AT_START: f64 = 0.8;
        if let State::Faulted(fault) = self.state() {
            return Err(Refusal::Faulted(fault));
        }
        if !self.configured {
            return Err(Refusal::NotConfigured);
        }
        self.must_be_disabled()?;
        let most = SPEED_AT_START * self.settings.protection.speed;
        let speed = self.coasting_speed();
        if speed > most {
            return Err(Refusal::Moves { speed, most });
        }
        let (position, travel) = (self.position(), self.settings.protection.travel);
        if AllowedRange::new(travel).contains(position) {
            Ok(())
        } else {
            Err(Refusal::OutsideTravel { position, travel })
        }
    }

    /// The speed of the disabled axis, rad/s.
    fn coasting_speed(&self) -> f64 {
        let window = f64::from(self.coasting_window());
        let distance = f64::from(self.channel.coasted()) * self.resolution();
        distance / (window * self.sample_time())
    }

    /// The position of the axis, rad from the origin.
    fn position(&self) -> f64 {
        let origin = match self.origin {
            Origin::Found(home) => home,
            Origin::Start | Origin::Sought => self.channel.started_at(),
        };
        f64::from(self.channel.count().wrapping_sub(origin)) * self.resolution()
    }

    /// Position of a count, rad.
    fn resolution(&self) -> f64 {
        self.settings.closed_loop.core.resolution
    }

    /// Disabled or faulted, as the interrupt has reported.
    fn must_be_disabled(&self) -> Result<(), Refusal> {
        if self.is_driven() || self.is_stopping() {
            Err(Refusal::Running)
        } else {
            Ok(())
        }
    }

    /// Gives an order to the interrupt; the memory of one that finds no room is free again.
    fn order(&mut self, order: Order) -> Result<(), Refusal> {
        self.channel.order(order).map_err(|order| {
            self.take_back(order);
            Refusal::Busy
        })
    }

    /// Takes an order back that was not given.
    fn take_back(&mut self, order: Order) {
        match order {
            Order::Begin(mode) | Order::Replace(mode) => self.free(mode),
            Order::Target(_) | Order::Home | Order::Clear | Order::Watch(_) => {}
        }
    }

    /// Takes the memory of a mode back.
    fn free(&mut self, mode: Mode) {
        match mode {
            Mode::Run(run) => self.run_slot = Some(Slot::Used(run)),
            Mode::Commissioning(over) => self.commissioning_slot = Some(Slot::Used(over)),
        }
    }

    /// Sends the servo to a target.
    fn target(&mut self, from: TargetsFrom, radians: f64) -> Result<(), Refusal> {
        self.must_be_running()?;
        if self.settings.source != TargetSource::Line {
            return Err(Refusal::TargetsFromOutside);
        }
        let base = self.origin.base(from, self.channel.started_at())?;
        let reach = AllowedRange::of_targets(&self.settings);
        let target = base.target(radians, self.resolution(), reach)?;
        self.order(Order::Target(target))
    }
}
