//! The background's half: everything that may take its time.

mod commission;
mod record;
mod reports;
mod runs;

use core::fmt;

use drive_link::{
    Command, Ended, Estimates, Fault, Kept, Outcome, Refusal, Report, Request, Settings, State,
};
use embedded_storage::nor_flash::NorFlash;
use identifier_core::commission::{CommissionSettings, Phase};

use self::record::{Commissioned, Record, VERSION};
use crate::channel::BackgroundEnd;
use crate::chip::Stage;
use crate::closed_loop::ClosedLoop;
use crate::commissioning::Commissioning;
use crate::first_fit::FirstFit;
use crate::memory::Memory;
use crate::messages::{Counts, Order};
use crate::protection::reach;
use crate::run::Run;
use crate::spare::Spare;
use crate::store::Store;
use crate::studying::Studying;

/// How long the background may be busy while the servo is let go, s: building a loop takes a hundredth of
/// that, and while the flash erases there are no samples that could miss it.
const RELEASED_PATIENCE: f64 = 5.0;

/// The background's half of a drive.
pub struct Supervisor<'a, F> {
    channel: BackgroundEnd<'a>,
    store: Store<F>,
    kept: Kept,
    stage: Stage,
    settings: Settings,
    configured: bool,
    /// Where a run is built, unless the interrupt has it.
    spare: Option<Spare<Run>>,
    /// The loop that was started last: it says in SI what the interrupt tells in its own units.
    closed_loop: Option<ClosedLoop>,
    first_fit: Option<FirstFit>,
    estimates: Option<Estimates>,
    /// Where a commissioning is built, unless the interrupt has it; and its other half.
    spare_commissioning: Option<Spare<Commissioning>>,
    studying: Studying,
    /// The last that was ordered, where it stands if it is under way, and what the last one came to.
    ordered: Option<CommissionSettings>,
    phase: Phase,
    outcome: Option<Outcome>,
    /// Whether it is over and holds the servo for a loop to go on.
    waits: bool,
    /// Whether what holds is to be kept as soon as the servo is let go.
    unkept: bool,
    /// What the gains that hold come from, unless they were given.
    commissioned: Option<Commissioned>,
    fault: Option<Fault>,
    ended: Option<Ended>,
    /// The stops that the interrupt has obeyed.
    stops: u32,
    counts: Counts,
    /// Samples that were told, but not said for want of room on the line.
    unsaid: u32,
    garbled: u32,
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
    /// With the record in the store, or else unconfigured, with settings to begin from. What the boot
    /// found wrong holds from the beginning.
    pub fn new(
        channel: BackgroundEnd<'a>,
        memory: &'static mut Memory,
        (flash, start): (F, u32),
        built_in: &Settings,
        stage: Stage,
        found_at_boot: Result<(), Fault>,
    ) -> Self {
        let (store, record, kept) = Store::open::<Record>(flash, start, VERSION);
        // A record that this firmware would refuse is of no use, however whole it is.
        let read = record.is_some();
        let record = record.filter(|record| Run::check(&record.settings, &stage).is_ok());
        let kept = if read && record.is_none() {
            Kept::OtherVersion
        } else {
            kept
        };
        let mut supervisor = Self {
            stops: channel.stops(),
            channel,
            store,
            kept,
            stage,
            configured: record.is_some(),
            settings: record.map_or(*built_in, |record| record.settings),
            spare: Some(Spare::Blank(&mut memory.run)),
            closed_loop: None,
            first_fit: None,
            estimates: record.and_then(|record| record.estimates),
            spare_commissioning: Some(Spare::Blank(&mut memory.commissioning)),
            studying: Studying::in_memory(&mut memory.study),
            ordered: None,
            phase: Phase::Idle,
            outcome: record.as_ref().and_then(Self::outcome_of),
            waits: false,
            unkept: false,
            commissioned: record.and_then(|record| record.commissioned),
            fault: found_at_boot.err(),
            ended: None,
            counts: Counts::default(),
            unsaid: 0,
            garbled: 0,
        };
        if record.is_some_and(|record| record.under_way) {
            // Told once. If it cannot be kept, it is told again.
            let _ = supervisor.keep(false);
        }
        supervisor.be_missed_for(RELEASED_PATIENCE);
        supervisor
    }

    /// Says for how long the background may be missed while the servo is let go, s.
    fn be_missed_for(&self, time: f64) {
        // A cast saturates.
        let samples = (time / self.sample_time()) as u32;
        self.channel.set_released_patience(samples);
    }

    /// The sample time that holds, s: the firmware's timer follows it while the servo is released.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.settings.closed_loop.core.sample_time
    }

    /// What the drive does.
    #[must_use]
    pub fn state(&self) -> State {
        match self.fault {
            Some(fault) => State::Faulted(fault),
            None if self.is_commissioning() => State::Commissioning,
            None if self.spare.is_none() => State::Running,
            None => State::Released,
        }
    }

    /// Whether the interrupt has a run or a commissioning, as far as it has told.
    fn is_out(&self) -> bool {
        self.spare.is_none() || self.is_commissioning()
    }

    /// Whether it has a commissioning.
    fn is_commissioning(&self) -> bool {
        self.spare_commissioning.is_none()
    }

    /// Whether the interrupt has been told to stop and has not said yet that it did.
    fn is_stopping(&self) -> bool {
        self.stops != self.channel.stops()
    }

    /// What the last run found, or the one that was kept.
    #[must_use]
    pub fn estimates(&self) -> Option<Estimates> {
        self.estimates
    }

    /// The background goes round: say so in each of its turns.
    pub fn is_alive(&self) {
        self.channel.is_alive();
    }

    /// Goes on with what the interrupt leaves to the background; true if there is more of it to do before
    /// the next sample.
    pub fn work(&mut self) -> bool {
        if let Some(first_fit) = &mut self.first_fit {
            first_fit.work(&mut self.channel);
        }
        if self.waits {
            self.go_on();
        }
        self.studying.work(&mut self.channel)
    }

    /// Lets the servo go, at once, whatever is asked or told besides.
    pub fn stop(&self) {
        self.channel.stop();
    }

    /// Does what is asked for, and answers.
    pub fn answer(&mut self, request: &Request) -> Report {
        self.answer_unless(request, |_| false)
    }

    /// The same, unless it is overtaken by a stop: that is asked before a run is ordered, because to
    /// build its loop takes many times as long as a stop may wait.
    pub fn answer_unless(
        &mut self,
        request: &Request,
        overtaken: impl FnOnce(&Self) -> bool,
    ) -> Report {
        self.channel.heard();
        let id = request.id;
        let refused = |refusal| Report::Refused { id, refusal };
        match self.obey(&request.command, overtaken) {
            Ok(()) => match request.command {
                Command::Hello => self.status(Some(id)),
                Command::Show => Report::Settings {
                    id,
                    settings: self.settings,
                },
                Command::Outcome => self.outcome.clone().map_or_else(
                    || refused(Refusal::NeverCommissioned),
                    |outcome| Report::Outcome { id, outcome },
                ),
                _ => Report::Done { id },
            },
            Err(refusal) => refused(refusal),
        }
    }

    fn obey(
        &mut self,
        command: &Command,
        overtaken: impl FnOnce(&Self) -> bool,
    ) -> Result<(), Refusal> {
        match *command {
            Command::Hello | Command::Show | Command::Outcome => {}
            Command::Configure(_) | Command::Start if self.is_commissioning() => {
                self.channel.change_mode();
                return Err(Refusal::EndedCommissioning);
            }
            Command::Configure(settings) => {
                self.must_be_let_go()?;
                Run::check(&settings, &self.stage).map_err(Refusal::Setting)?;
                // What is said of a servo now holds more than what was learnt of another.
                if settings.closed_loop != self.settings.closed_loop {
                    self.estimates = None;
                    self.commissioned = None;
                }
                self.settings = settings;
                self.configured = true;
                self.be_missed_for(RELEASED_PATIENCE);
            }
            Command::Start => {
                // Said again, it is done already.
                if self.state() == State::Running && !self.is_stopping() {
                    return Ok(());
                }
                self.start(overtaken)?;
            }
            Command::Target(radians) => {
                if self.state() != State::Running || self.is_stopping() {
                    return Err(Refusal::NotRunning);
                }
                let target = Order::Target(self.counts(radians)?);
                self.order(target)?;
            }
            Command::Stop => self.channel.stop(),
            Command::Clear => {
                if let State::Faulted(_) = self.state() {
                    self.order(Order::Clear)?;
                }
            }
            Command::Watch(every) => self.order(Order::Watch(every))?,
            Command::Save => {
                // Writing stops the processor, and with it the loop.
                self.must_be_let_go()?;
                self.keep(false).map_err(|_| Refusal::NotKept)?;
            }
            Command::Commission(settings) => self.commission(&settings, overtaken)?,
        }
        Ok(())
    }

    /// Released and configured.
    fn must_be_ready(&self) -> Result<(), Refusal> {
        if let State::Faulted(fault) = self.state() {
            return Err(Refusal::Faulted(fault));
        }
        if !self.configured {
            return Err(Refusal::NotConfigured);
        }
        self.must_be_let_go()
    }

    /// Released or faulted, and the interrupt has said so.
    fn must_be_let_go(&self) -> Result<(), Refusal> {
        if self.is_out() || self.is_stopping() {
            Err(Refusal::Running)
        } else {
            Ok(())
        }
    }

    fn order(&mut self, order: Order) -> Result<(), Refusal> {
        self.channel.order(order).map_err(|_| Refusal::Busy)
    }

    fn counts(&self, radians: f64) -> Result<i32, Refusal> {
        let most = reach(&self.settings);
        if !radians.is_finite() || radians.abs() > most {
            return Err(Refusal::TooFar { most });
        }
        // Within what 32 bits hold, as the travel is.
        Ok((radians / self.settings.closed_loop.core.resolution) as i32)
    }
}
