//! A drive on a machine with time, and the host at the other end of its line.

use std::ops::Deref;

use drive_chip::F4;
use drive_chip::family::ClockTree;
use drive_chip::flash::{Areas, RecordFlash};
use drive_chip::serial::{self, Bytes, Ring};
use drive_link::{Command, Line, Receiver, Refusal, Report, Request, State, frame};
use drive_logic::{Channel, Conversation, LineListener, Memory, Records, Sampler, Supervisor};

use super::machine::{BYTE, Handlers, Machine, Mode};
use super::settings;
use super::support::STAGE;

/// Duration of a turn of the background, ns, above the time of its instructions (`cargo xtask budget`: `turn-…`): without anything to do; for each byte that is read; with anything sent; a slice of the work on a record,
/// which is counted at another level of the optimiser.
const TURN: u64 = 5_000;
const READ: u64 = 2_000;
const ANSWER: u64 = 700_000;
const SLICE: u64 = 600_000;

/// Duration of building a loop or a commissioning, before its order is given, ns.
const BUILD: u64 = 400_000;

/// Time in which a request is done, ns.
pub(super) const DONE: u64 = 5_000_000;

/// The background's end of the line, and the figures of a turn.
struct Timed {
    line: serial::Line<'static, &'static Machine>,
    machine: &'static Machine,
    /// Times that the line was listened to in this turn, bytes that were read, frames that were sent.
    listened: u32,
    bytes: u64,
    frames: u64,
    /// Where the host decodes what the drive sends: refusals since the last time.
    refused: Option<(Receiver, Vec<Refusal>)>,
}

impl Line for Timed {
    fn listen(&mut self) {
        // The first time is the beginning of the turn.
        if self.listened > 0 {
            self.machine.compute(BUILD);
        }
        self.listened += 1;
        self.line.listen();
    }

    fn receive(&mut self) -> Option<u8> {
        let byte = self.line.receive();
        self.bytes += u64::from(byte.is_some());
        byte
    }

    fn room(&self) -> usize {
        self.line.room()
    }

    fn send(&mut self, bytes: &[u8]) {
        self.frames += 1;
        self.line.send(bytes);
        if let Some((receiver, refused)) = &mut self.refused {
            let received = bytes.iter().filter_map(|&byte| receiver.take(byte));
            refused.extend(received.filter_map(|report| match report {
                Ok(Report::Refused { refusal, .. }) => Some(refusal),
                _ => None,
            }));
        }
    }
}

/// A drive with its host.
pub(super) struct Host {
    machine: &'static Machine,
    conversation: Conversation,
    supervisor: Supervisor<'static, RecordFlash<&'static Machine>>,
    line: Timed,
    id: u8,
    order: u32,
}

impl Deref for Host {
    type Target = Machine;

    fn deref(&self) -> &Machine {
        self.machine
    }
}

fn forever<T>(thing: T) -> &'static mut T {
    Box::leak(Box::new(thing))
}

impl Host {
    pub(super) fn new(rate: u32) -> Self {
        let machine: &'static Machine = forever(Machine::new(rate));
        let (back, interrupt, line_end) = forever(Channel::new()).split();
        let ring: &'static Ring = forever(Ring::new());
        let (line, port) = serial::line(machine, &F4::CLOCKS, ring, forever(Bytes::new()));
        let flash = RecordFlash::new(machine, Areas::starting_at(1));
        let memory = forever(Memory::new());
        let built_in = settings(rate);
        let records = Records::open(flash, 0, &STAGE);
        let supervisor = Supervisor::new(back, memory, records, &built_in, STAGE, Ok(()));
        let handlers = forever(Handlers {
            sampler: Sampler::new(interrupt, Ok(())).into(),
            port: port.into(),
            listener: LineListener::new(line_end).into(),
        });
        machine.begin(handlers, ring);
        Self {
            machine,
            conversation: Conversation::new(),
            supervisor,
            line: Timed {
                line,
                machine,
                listened: 0,
                bytes: 0,
                frames: 0,
                refused: None,
            },
            id: 0,
            order: 0,
        }
    }

    /// One that is configured, with a link timeout, s.
    pub(super) fn configured(rate: u32, link_timeout: f64) -> Self {
        let mut settings = settings(rate);
        settings.protection.link_timeout = link_timeout;
        let mut host = Self::new(rate);
        host.request(Command::Configure(settings));
        host.pass(50_000_000);
        assert_eq!(host.refusals(), []);
        host
    }

    /// Starts a run.
    pub(super) fn start(&mut self) {
        self.request(Command::Start);
        self.pass(DONE);
        assert_eq!((self.refusals(), self.is_driven()), (Vec::new(), true));
    }

    /// Refusals since the last time; the first time none.
    pub(super) fn refusals(&mut self) -> Vec<Refusal> {
        let fresh = || (Receiver::new(), Vec::new());
        core::mem::take(&mut self.line.refused.get_or_insert_with(fresh).1)
    }

    pub(super) fn state(&self) -> State {
        self.supervisor.state()
    }

    /// Puts the first bytes of a request on the wire, and the others behind a break.
    pub(super) fn cut(&mut self, command: Command, place: usize) {
        self.order += 1;
        let (id, order) = (0, self.order);
        let framed = frame(&Request { id, order, command }).expect("it fits");
        let (before, behind) = framed.split_at(place.min(framed.len()));
        self.send(before);
        self.break_wire(BYTE);
        self.send(behind);
    }

    /// Samples take as long as those of a commissioning from now on.
    pub(super) fn expect_commissioning(&self) {
        self.machine.set_mode(Mode::Commissioning);
    }

    /// Runs the drive's background until a time, and until the turn ends that is under way then.
    pub(super) fn run_to(&mut self, time: u64) {
        while self.machine.now() < time {
            let samples = self.machine.samples();
            (self.line.listened, self.line.bytes, self.line.frames) = (0, 0, 0);
            let more = self.conversation.turn(&mut self.line, &mut self.supervisor);
            let slice = match self.supervisor.state() {
                State::Commissioning => SLICE,
                _ => 0,
            };
            let read = self.line.bytes * READ;
            self.machine
                .compute(TURN + read + self.line.frames.min(1) * ANSWER + slice);
            while !more
                && self.machine.now() < time
                && self.line.line.is_silent()
                && self.machine.samples() == samples
            {
                self.machine.sleep(time);
            }
        }
    }

    /// Runs for a time, ns.
    pub(super) fn pass(&mut self, time: u64) {
        self.run_to(self.machine.now() + time);
    }

    fn send(&mut self, bytes: &[u8]) -> u64 {
        let times = bytes.iter().map(|&byte| self.machine.put_on_the_wire(byte));
        times.fold(u64::MAX, u64::min)
    }

    /// Puts a request on the wire as a host does: after a zero, which ends any earlier bytes. Returns the time at which its
    /// first byte begins.
    pub(super) fn request(&mut self, command: Command) -> u64 {
        self.id = self.id.wrapping_add(1);
        self.order += u32::from(command.may_move());
        let (id, order) = (self.id, self.order);
        let framed = frame(&Request { id, order, command }).expect("it fits");
        let began = self.send(&[0]);
        self.send(&framed);
        began
    }

    /// Garbage, requests with long answers, and a frame that is cut.
    pub(super) fn garble(&mut self) {
        for _ in 0..self.below(60) {
            let byte = self.below(256) as u8;
            self.send(&[byte]);
        }
        for _ in 0..self.below(4) {
            let command = match self.below(4) {
                0 => Command::Show,
                1 => Command::Hello,
                2 => Command::Watch(1),
                _ => Command::Target(0.1),
            };
            self.request(command);
        }
        let command = Command::Configure(settings(1000));
        let cut = frame(&Request::without_order(0, command)).expect("it fits");
        let length = self.below(20) as usize;
        self.send(&cut[..length]);
    }

    /// A stop, and the time at which its first byte begins.
    pub(super) fn stop(&mut self) -> u64 {
        let began = self.request(Command::Stop);
        self.machine.note_at(began);
        began
    }

    /// Garbage without a pause, seldom for long.
    pub(super) fn flood(&mut self) {
        let most = if self.below(8) == 0 { 1500 } else { 60 };
        for _ in 0..self.below(most) {
            let byte = self.below(256) as u8;
            self.send(&[byte]);
        }
    }

    /// Stops until the drive is at rest.
    pub(super) fn come_to_rest(&mut self) {
        for _ in 0..1000 {
            self.machine.set_mode(Mode::Run);
            if self.supervisor.state() == State::Disabled && !self.machine.is_driven() {
                let idle = self.machine.leave_idle(2_000_000);
                return self.run_to(idle);
            }
            self.request(Command::Stop);
            self.pass(20_000_000);
        }
        panic!("{:?}", self.supervisor.state());
    }
}
