//! A whole drive on a bench.

use drive_link::{
    Command, Fault, NotAllowed, Receiver, Refusal, Report, Request, Settings, Snapshot, State,
    Status, frame,
};
use drive_logic::{
    Channel, LineListener, Lines, Memory, OutputStage, PolledLine, Records, Sampler, Supervisor,
};
use identifier_core::parameters::ServoParameters;

use super::{Bench, Flash, STAGE, settings};

pub(crate) const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 0.0,
    load: 20.0,
};

/// A drive on a bench.
pub(crate) struct Drive {
    pub(crate) sampler: Sampler<'static>,
    pub(crate) supervisor: Supervisor<'static, Flash>,
    pub(crate) bench: &'static Bench,
    pub(crate) flash: Flash,
    pub(crate) listener: Option<LineListener<'static>>,
    id: u8,
    pub(crate) order: u32,
}

/// A request as it arrives, for what is not sent to be missed.
fn over_the_line(request: &Request) -> Request {
    let mut receiver = Receiver::new();
    let bytes = frame(request).expect("it fits");
    let mut received = bytes.iter().filter_map(|&byte| receiver.take_request(byte));
    received.next().expect("a whole frame").expect("understood")
}

impl Drive {
    /// A drive with a blank flash on the bench with a servo, configured.
    pub(crate) fn on_bench(servo: &ServoParameters) -> (Self, &'static Bench) {
        let bench = Bench::new(servo);
        (Self::boot(bench, &Flash::blank()), bench)
    }

    /// A drive that is configured, by its flash or now.
    pub(crate) fn boot(bench: &'static Bench, flash: &Flash) -> Self {
        Self::booted_with(bench, flash, Ok(()))
    }

    /// The same, and what was found at boot.
    pub(crate) fn booted_with(
        bench: &'static Bench,
        flash: &Flash,
        found: Result<(), Fault>,
    ) -> Self {
        let mut drive = Self::new(bench, flash, found, STAGE);
        if !drive.status().configured {
            drive.done(Command::Configure(settings()));
        }
        drive
    }

    /// A drive as delivered: without settings of its servo, unless the flash has some.
    pub(crate) fn as_it_comes(bench: &'static Bench, flash: &Flash) -> Self {
        Self::new(bench, flash, Ok(()), STAGE)
    }

    /// A drive as delivered with an output stage, and what was found at boot.
    pub(crate) fn new(
        bench: &'static Bench,
        flash: &Flash,
        found: Result<(), Fault>,
        stage: OutputStage,
    ) -> Self {
        let (background, interrupt, line) = Box::leak(Box::new(Channel::new())).split();
        let memory = Box::leak(Box::new(Memory::new()));
        let records = Records::open(flash.clone(), 0, &stage);
        Self {
            sampler: Sampler::new(interrupt, found),
            supervisor: Supervisor::new(background, memory, records, &settings(), stage, found),
            bench,
            flash: flash.clone(),
            listener: Some(LineListener::new(line)),
            id: 0,
            order: 0,
        }
    }

    /// The drive on the same bench after its power was off.
    pub(crate) fn rebooted(&self) -> Self {
        Self::boot(self.bench, &self.flash)
    }

    /// A line that this drive listens to whenever its background looks at it.
    pub(crate) fn polled<L>(&mut self, line: L) -> PolledLine<'static, L> {
        PolledLine::new(line, self.listener.take().expect("one line"))
    }

    pub(crate) fn state(&self) -> State {
        self.supervisor.state()
    }

    /// The angle of the axis, rad.
    pub(crate) fn position(&self) -> f64 {
        self.bench.position()
    }

    pub(crate) fn status(&mut self) -> Status {
        match self.ask(Command::Hello) {
            Report::Status { status, .. } => status,
            other => panic!("{other:?} is no status"),
        }
    }

    pub(crate) fn ask(&mut self, command: Command) -> Report {
        self.id = self.id.wrapping_add(1);
        self.order += u32::from(command.may_move());
        let (id, order) = (self.id, self.order);
        let order = if command.may_move() { order } else { 0 };
        let answer = self
            .supervisor
            .answer(&over_the_line(&Request { id, order, command }));
        if let Report::Done { id: same } | Report::Refused { id: same, .. } = &answer {
            assert_eq!(*same, id);
        }
        answer
    }

    pub(crate) fn shown(&mut self) -> Settings {
        match self.ask(Command::Show) {
            Report::Settings { settings, .. } => settings,
            other => panic!("{other:?} are no settings"),
        }
    }

    pub(crate) fn done(&mut self, command: Command) {
        let answer = self.ask(command);
        assert!(
            matches!(answer, Report::Done { .. } | Report::Status { .. }),
            "{answer:?}"
        );
    }

    pub(crate) fn refusal(&mut self, command: Command) -> Refusal {
        match self.ask(command) {
            Report::Refused { refusal, .. } => refusal,
            other => panic!("{command:?} was not refused but answered with {other:?}"),
        }
    }

    /// The setting for which a request is refused, and why.
    pub(crate) fn not_allowed(&mut self, command: Command) -> NotAllowed {
        match self.refusal(command) {
            Refusal::Setting(refused) => refused,
            other => panic!("{command:?}: {other:?}"),
        }
    }

    /// A request that is refused, but has ended a commissioning.
    pub(crate) fn ends_commissioning(&mut self, command: Command) {
        assert_eq!(self.refusal(command), Refusal::EndedCommissioning);
    }

    /// Has a command done, and runs samples: the reports.
    pub(crate) fn order(&mut self, command: Command, samples: u32) -> Vec<Report> {
        self.done(command);
        self.pass(samples)
    }

    /// Starts a run with these settings.
    pub(crate) fn run(&mut self, settings: Settings) {
        self.run_for(settings, 0);
    }

    /// The same, with its first samples: their reports.
    pub(crate) fn run_for(&mut self, settings: Settings, samples: u32) -> Vec<Report> {
        self.done(Command::Configure(settings));
        self.order(Command::Start, samples)
    }

    /// Runs one sample and leaves its reports in the queue.
    pub(crate) fn sample(&mut self) {
        self.sampler.interrupt(&mut self.bench.pins());
        self.supervisor.count_turn();
        while self.supervisor.work() {}
        self.bench.pass();
    }

    /// Runs samples while the background takes turns but does no work.
    pub(crate) fn pass_without_work(&mut self, samples: u32) {
        for _ in 0..samples {
            self.sampler.interrupt(&mut self.bench.pins());
            self.supervisor.count_turn();
            self.bench.pass();
        }
    }

    /// Runs samples while the background hangs: the number of those that fed the watchdog.
    pub(crate) fn fed_while_hanging(&mut self, samples: u32) -> u32 {
        let before = self.bench.fed.get();
        for _ in 0..samples {
            self.sampler.interrupt(&mut self.bench.pins());
            self.bench.pass();
        }
        self.bench.fed.get() - before
    }

    /// Changes the levels of the input lines.
    pub(crate) fn lines(&self, change: impl FnOnce(&mut Lines)) {
        let mut lines = self.bench.lines.get();
        change(&mut lines);
        self.bench.lines.set(lines);
    }

    /// Runs samples and gathers the reports.
    pub(crate) fn pass(&mut self, samples: u32) -> Vec<Report> {
        let mut reports = Vec::new();
        for _ in 0..samples {
            self.sample();
            reports.extend(std::iter::from_fn(|| self.supervisor.next_report()));
        }
        reports
    }

    /// Starts, runs the loop for a while, then applies a harm: the fault that follows.
    pub(crate) fn fault_after(&mut self, harm: impl FnOnce(&mut Self)) -> Option<Fault> {
        self.done(Command::Start);
        self.pass(300);
        assert_eq!(self.supervisor.state(), State::Running);
        assert!(self.bench.held.get().is_some());
        harm(self);
        let reports = self.pass(3000);
        let fault = reports.iter().find_map(|report| match report {
            Report::Fault(fault) => Some(*fault),
            _ => None,
        });
        if let Some(fault) = fault {
            assert_eq!(self.supervisor.state(), State::Faulted(fault));
            assert_eq!(self.bench.held.get(), None, "the servo is released");
            assert_eq!(self.refusal(Command::Start), Refusal::Faulted(fault));
        }
        fault
    }
}

pub(crate) fn snapshots(reports: &[Report]) -> Vec<Snapshot> {
    reports
        .iter()
        .filter_map(|report| match report {
            Report::Snapshot(snapshot) => Some(*snapshot),
            _ => None,
        })
        .collect()
}
