//! The background's half: everything that may take its time.

use core::fmt;

use drive_link::{
    Command, Estimates, Kept, PROTOCOL, Refusal, Report, Request, Settings, Snapshot, State, Status,
};
use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::{Consumer, Producer};
use serde::{Deserialize, Serialize};

use crate::closed_loop::{ClosedLoop, Learnt};
use crate::sampler::{Counts, EVENTS, Event, ORDERS, Order, Run, Shown};
use crate::store::Store;

/// The version of the [`Record`]: another one is another meaning of the bytes.
const VERSION: u16 = 2;

/// What survives a loss of power.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Record {
    settings: Settings,
    /// What the last run that was kept had found.
    estimates: Option<Estimates>,
}

/// The background's half of a drive.
pub struct Supervisor<'a, F> {
    orders: Producer<'a, Order, ORDERS>,
    events: Consumer<'a, Event, EVENTS>,
    store: Store<F>,
    kept: Kept,
    full_scale: f64,
    settings: Settings,
    /// The loop that was started last: it says in SI what the interrupt tells in its own units.
    closed_loop: Option<ClosedLoop>,
    estimates: Option<Estimates>,
    state: State,
    /// The interrupt has been told to let the servo go and has not said yet that it did.
    releasing: bool,
    counts: Counts,
    garbled: u32,
}

impl<F> fmt::Debug for Supervisor<'_, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Supervisor")
            .field("state", &self.state)
            .field("settings", &self.settings)
            .finish_non_exhaustive()
    }
}

impl<'a, F: NorFlash> Supervisor<'a, F> {
    /// With the record in the store, or else the built-in settings. `full_scale` is the command that
    /// asks for all that the output stage has, command units.
    pub fn new(
        orders: Producer<'a, Order, ORDERS>,
        events: Consumer<'a, Event, EVENTS>,
        (flash, start): (F, u32),
        built_in: &Settings,
        full_scale: f64,
    ) -> Self {
        let (store, record, kept) = Store::open::<Record>(flash, start, VERSION);
        // A record that this firmware would refuse is of no use, however whole it is.
        let read = record.is_some();
        let record = record.filter(|record| Run::new(&record.settings, full_scale).is_ok());
        let kept = if read && record.is_none() {
            Kept::OtherVersion
        } else {
            kept
        };
        Self {
            orders,
            events,
            store,
            kept,
            full_scale,
            settings: record.map_or(*built_in, |record| record.settings),
            closed_loop: None,
            estimates: record.and_then(|record| record.estimates),
            state: State::Released,
            releasing: false,
            counts: Counts::default(),
            garbled: 0,
        }
    }

    /// The sample time that holds, s: the firmware's timer follows it while the servo is released.
    #[must_use]
    pub fn sample_time(&self) -> f64 {
        self.settings.closed_loop.core.sample_time
    }

    /// What the drive does.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// What the last run found, or the one that was kept.
    #[must_use]
    pub fn estimates(&self) -> Option<Estimates> {
        self.estimates
    }

    /// Takes note of a frame that was not understood.
    pub fn garbled(&mut self) {
        self.garbled = self.garbled.saturating_add(1);
    }

    /// The next thing that the interrupt tells, as a report.
    pub fn news(&mut self) -> Option<Report> {
        Some(match self.events.dequeue()? {
            Event::Shown(shown) => Report::Snapshot(self.snapshot(&shown)),
            Event::Faulted(fault, counts) => {
                self.counts = counts;
                self.releasing = false;
                self.state = State::Faulted(fault);
                Report::Fault(fault)
            }
            Event::Cleared => {
                self.state = State::Released;
                self.status(None)
            }
            Event::Released(learnt, counts) => {
                self.counts = counts;
                self.releasing = false;
                if self.state == State::Running {
                    self.state = State::Released;
                }
                if let Some(learnt) = learnt {
                    self.take_in(&learnt);
                }
                self.status(None)
            }
        })
    }

    /// Does what is asked for, and answers.
    pub fn answer(&mut self, request: &Request) -> Report {
        let id = request.id;
        match self.obey(&request.command) {
            Ok(()) => match request.command {
                Command::Hello => self.status(Some(id)),
                Command::Show => Report::Settings {
                    id,
                    settings: self.settings,
                },
                _ => Report::Done { id },
            },
            Err(refusal) => Report::Refused { id, refusal },
        }
    }

    fn obey(&mut self, command: &Command) -> Result<(), Refusal> {
        match *command {
            Command::Hello | Command::Show => {}
            Command::Configure(settings) => {
                self.must_be_let_go()?;
                Run::new(&settings, self.full_scale).map_err(Refusal::Setting)?;
                self.settings = settings;
            }
            Command::Start => {
                // Said again, it is done already.
                if self.state == State::Running && !self.releasing {
                    return Ok(());
                }
                self.must_be_released()?;
                let run = Run::new(&self.settings, self.full_scale).map_err(Refusal::Setting)?;
                self.order(Order::Run(run))?;
                self.closed_loop = Some(*run.closed_loop());
                self.state = State::Running;
            }
            Command::Target(radians) => {
                if self.state != State::Running {
                    return Err(Refusal::NotRunning);
                }
                self.order(Order::Target(self.counts(radians)?))?;
            }
            // One release at a time: the end of a second one would be taken for that of a later run.
            Command::Stop if self.releasing => {}
            Command::Stop => {
                self.order(Order::Release)?;
                self.releasing = true;
            }
            Command::Clear => {
                if let State::Faulted(_) = self.state {
                    self.order(Order::Clear)?;
                }
            }
            Command::Watch(every) => self.order(Order::Watch(every))?,
            Command::Save => {
                // Writing stops the processor, and with it the loop.
                self.must_be_let_go()?;
                let record = Record {
                    settings: self.settings,
                    estimates: self.estimates,
                };
                self.store.keep(&record).map_err(|_| Refusal::NotKept)?;
                self.kept = Kept::Record;
            }
        }
        Ok(())
    }

    /// Released or faulted, and the interrupt has said so.
    fn must_be_let_go(&self) -> Result<(), Refusal> {
        if self.state == State::Running || self.releasing {
            Err(Refusal::Running)
        } else {
            Ok(())
        }
    }

    fn must_be_released(&self) -> Result<(), Refusal> {
        match self.state {
            State::Released if !self.releasing => Ok(()),
            State::Released | State::Running => Err(Refusal::Running),
            State::Faulted(fault) => Err(Refusal::Faulted(fault)),
        }
    }

    fn order(&mut self, order: Order) -> Result<(), Refusal> {
        self.orders.enqueue(order).map_err(|_| Refusal::Busy)
    }

    fn counts(&self, radians: f64) -> Result<i32, Refusal> {
        let most = self.settings.protection.travel;
        if !radians.is_finite() || radians.abs() > most {
            return Err(Refusal::TooFar { most });
        }
        // Within what 32 bits hold, as the travel is.
        Ok((radians / self.settings.closed_loop.core.resolution) as i32)
    }

    fn status(&self, id: Option<u8>) -> Report {
        let status = Status {
            protocol: PROTOCOL,
            state: self.state,
            kept: self.kept,
            estimates: self.estimates,
            noticed: self.counts.noticed,
            overruns: self.counts.overruns,
            dropped: self.counts.dropped,
            garbled: self.garbled,
        };
        Report::Status { id, status }
    }

    fn snapshot(&mut self, shown: &Shown) -> Snapshot {
        let resolution = self.settings.closed_loop.core.resolution;
        let radians = |counts: f64| (counts * resolution) as f32;
        self.take_in(&shown.learnt);
        self.counts = shown.counts;
        Snapshot {
            sample: shown.sample,
            reference: radians(f64::from(shown.count) + f64::from(shown.error)),
            position: radians(f64::from(shown.count)),
            command: shown.command,
            output_error: radians(f64::from(shown.output_error)),
            estimates: self.estimates.unwrap_or_default(),
        }
    }

    fn take_in(&mut self, learnt: &Learnt) {
        let closed_loop = self.closed_loop.as_ref();
        let found = closed_loop.and_then(|closed_loop| closed_loop.estimates(learnt));
        self.estimates = found.or(self.estimates);
    }
}
