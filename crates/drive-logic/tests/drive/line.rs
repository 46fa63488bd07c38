//! The drive at the end of a realistic line, with the times of bytes in both directions and of the
//! background. The figures are the time until a stop is obeyed, and the effect of a broken line.

use std::collections::VecDeque;

use crate::support::commission::ORDER;
use crate::support::drive::{Drive, SERVO};
use crate::support::line::{ROOM, Random, Wires, request_bytes};
use crate::support::{HOMING, settings};
use drive_link::{
    Command, Estimator, Fault, Home, Line, PROTOCOL, Receiver, Refusal, Report, Settings, State,
};
use drive_logic::{Conversation, PolledLine};

/// Time of a byte at 1 Mbaud, ns.
const BYTE: u64 = 10_000;

/// Time between samples, ns: 4 kHz.
const SAMPLE: u64 = 250_000;

/// Duration of one pass of the background, ns, above the emulator's count
/// (`cargo xtask budget`: `turn-…`) at two cycles for an instruction: without anything to do; for each
/// byte that is read; with anything sent, for a request with its answer; for an unsolicited report, in
/// every pass.
const TURN: [u64; 4] = [5_000, 2_000, 700_000, 300_000];

/// A drive, its line and its time.
struct OnLine {
    drive: Drive,
    conversation: Conversation,
    wires: PolledLine<'static, Wires>,
    /// Bytes on their way to the drive.
    to_drive: VecDeque<u8>,
    receiver: Receiver,
    reports: Vec<Report>,
    /// ns.
    now: u64,
    next_sample: u64,
    free_at: u64,
    /// Durations of a pass, as [`TURN`].
    turn: [u64; 4],
    id: u8,
}

impl OnLine {
    fn with(settings: Settings) -> Self {
        let (mut drive, _) = Drive::on_bench(&SERVO);
        drive.done(Command::Configure(settings));
        Self {
            wires: drive.polled(Wires::default()),
            to_drive: VecDeque::new(),
            drive,
            conversation: Conversation::new(),
            receiver: Receiver::new(),
            reports: Vec::new(),
            now: 0,
            next_sample: 0,
            free_at: 0,
            turn: TURN,
            id: 0,
        }
    }

    /// Advances by the time of a byte.
    fn step(&mut self) {
        self.now += BYTE;
        let wires = self.wires.line();
        if let Some(byte) = self.to_drive.pop_front()
            && wires.heard.len() < ROOM
        {
            wires.heard.push_back(byte);
        }
        if let Some(byte) = wires.to_say.pop_front()
            && let Some(Ok(report)) = self.receiver.take::<Report>(byte)
        {
            self.reports.push(report);
        }
        if self.now >= self.next_sample {
            self.next_sample += SAMPLE;
            self.drive.sampler.interrupt(&mut self.drive.bench.pins());
            self.drive.bench.pass();
        }
        if self.now >= self.free_at {
            let wires = self.wires.line();
            (wires.bytes, wires.frames) = (0, 0);
            self.conversation
                .turn(&mut self.wires, &mut self.drive.supervisor);
            let [turn, byte, answer, news] = self.turn;
            let wires = self.wires.line();
            let answered = if wires.frames > 0 { answer } else { 0 };
            self.free_at = self.now + turn + byte * wires.bytes.min(160) + answered + news;
        }
    }

    fn pass(&mut self, time: f64) {
        let until = self.now + (1e9 * time) as u64;
        while self.now < until {
            self.step();
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        self.to_drive.extend(bytes);
    }

    /// Sends a request as a host does: after a zero, which ends any earlier bytes on the line.
    fn request(&mut self, command: Command) -> u8 {
        self.id = self.id.wrapping_add(1);
        self.send(&[0]);
        self.send(&request_bytes(self.id, command));
        self.id
    }

    /// Repeats a request until the drive has done it.
    fn ask(&mut self, command: Command) {
        for _ in 0..50 {
            let id = self.request(command);
            self.reports.clear();
            for _ in 0..200 {
                self.pass(2e-4);
                for report in &self.reports {
                    match report {
                        Report::Done { id: same } if *same == id => return,
                        Report::Refused { id: same, refusal } if *same == id => {
                            assert!(
                                matches!(refusal, Refusal::Busy | Refusal::Running),
                                "{refusal}"
                            );
                        }
                        _ => {}
                    }
                }
            }
        }
        panic!("{command:?} is not done");
    }

    fn is_driven(&self) -> bool {
        self.drive.bench.held.get().is_some()
    }
}

/// 4 kHz, everything shown.
fn fast() -> Settings {
    let mut fast = settings();
    fast.closed_loop.core.sample_time = 2.5e-4;
    fast.closed_loop.law = Estimator::Gradient { friction: true };
    // The bench's servo moves by a millisecond in each sample: four times as fast.
    fast.protection.speed = 1e3;
    fast.protection.following_error = 50.0;
    fast
}

#[test]
fn every_request_is_answered_under_any_rate_of_reports() {
    let mut line = OnLine::with(fast());
    // A background so quick that the line is the bottleneck.
    line.turn = TURN.map(|time| time / 10);
    line.ask(Command::Watch(1));
    line.ask(Command::Start);
    for _ in 0..50 {
        line.pass(0.05);
        line.reports.clear();
        let id = line.request(Command::Show);
        // All that may wait on the line before the answer, and the answer.
        line.pass(0.03);
        let is_answer =
            |report: &Report| matches!(report, Report::Settings { id: same, .. } if *same == id);
        assert!(line.reports.iter().any(is_answer), "asked once");
    }
    assert!(line.drive.status().dropped > 0, "the line was full");
}

#[test]
fn requests_without_a_pause_do_not_hide_a_stop() {
    let mut line = OnLine::with(fast());
    for flood in [100, 300, 1000, 3000] {
        line.ask(Command::Start);
        line.pass(0.001);
        assert!(line.is_driven());
        // More than all the queues hold, each with a long answer.
        for _ in 0..flood {
            line.request(Command::Show);
        }
        while !line.to_drive.is_empty() {
            line.step();
        }
        assert!(line.is_driven());
        let sent = line.now;
        line.request(Command::Stop);
        for _ in 0..100 {
            line.request(Command::Show);
        }
        while line.is_driven() {
            line.step();
            assert!(line.now < sent + 2_000_000, "{flood} requests before it");
        }
        line.pass(4.0);
        assert!(!line.is_driven());
    }
}

/// A line on which each piece comes when the one before has been looked at.
struct Pieces(VecDeque<VecDeque<u8>>);

impl Line for Pieces {
    fn listen(&mut self) {}

    fn receive(&mut self) -> Option<u8> {
        let byte = self.0.front_mut()?.pop_front();
        if byte.is_none() {
            self.0.pop_front();
        }
        byte
    }

    fn room(&self) -> usize {
        ROOM
    }

    fn send(&mut self, _: &[u8]) {}
}

#[test]
fn a_stop_while_a_run_is_built_prevents_its_start() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let piece = |command| VecDeque::from(request_bytes(1, command));
    let mut pieces = drive.polled(Pieces([piece(Command::Start), piece(Command::Stop)].into()));
    let mut conversation = Conversation::new();
    for _ in 0..10 {
        conversation.turn(&mut pieces, &mut drive.supervisor);
        drive.sample();
        assert!(drive.bench.held.get().is_none());
    }
    // And without one it begins.
    *pieces.line() = Pieces([piece(Command::Start), piece(Command::Hello)].into());
    conversation.turn(&mut pieces, &mut drive.supervisor);
    drive.sample();
    assert!(drive.bench.held.get().is_some());
}

#[test]
fn an_order_around_lost_bytes_is_refused_until_all_before_them_is_decoded() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let mut listener = drive.listener.take().expect("one line");
    let mut conversation = Conversation::new();
    let start = request_bytes(1, Command::Start);
    let mut line = Wires {
        heard: start.iter().copied().collect(),
        ..Wires::default()
    };
    listener.disturbed();
    conversation.turn(&mut line, &mut drive.supervisor);
    drive.sample();
    assert!(drive.bench.held.get().is_none(), "a stop may be lost");
    assert_eq!(drive.refusal(Command::Target(0.1)), Refusal::LineDisturbed);
    assert_eq!(drive.status().disturbed, 1);
    // Nothing is left of that time.
    conversation.turn(&mut line, &mut drive.supervisor);
    line.heard.extend(start.iter());
    conversation.turn(&mut line, &mut drive.supervisor);
    drive.sample();
    assert!(drive.bench.held.get().is_some());
    // A run that is under way is not ended: silence ends it, if it lasts.
    listener.disturbed();
    drive.sample();
    assert!(drive.bench.held.get().is_some());
}

#[test]
fn no_order_that_may_move_the_axis_is_obeyed_in_doubt_and_any_other_request_is() {
    let moving = [
        Command::Start,
        Command::Target(0.1),
        Command::Home,
        Command::Commission(ORDER),
    ];
    let others = [
        Command::Hello,
        Command::Show,
        Command::Watch(0),
        Command::Clear,
        Command::Stop,
    ];
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let mut wanted = settings();
    wanted.homing = Some(HOMING);
    drive.run_for(wanted, 10);
    assert_eq!(drive.state(), State::Running);
    drive.listener.as_mut().expect("one line").disturbed();
    for command in moving {
        assert!(command.may_move());
        assert_eq!(drive.refusal(command), Refusal::LineDisturbed);
    }
    drive.pass(10);
    assert_eq!(drive.status().home, Home::Unknown, "it is not on its way");
    for command in others {
        assert!(!command.may_move());
        let answer = drive.ask(command);
        assert!(!matches!(answer, Report::Refused { .. }), "{answer:?}");
    }
}

/// Bytes of the host in a frame, whatever they are.
fn framed(message: &[u8]) -> Vec<u8> {
    let check = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(message);
    let whole = [message, &check.to_le_bytes()].concat();
    let runs = whole.split(|&byte| byte == 0);
    let framed = runs.flat_map(|run| [&[run.len() as u8 + 1], run].concat());
    framed.chain([0]).collect()
}

#[test]
fn a_request_of_another_version_is_answered_with_a_refusal_and_moves_nothing() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    drive.order(Command::Start, 10);
    let mut conversation = Conversation::new();
    let mut line = drive.polled(Wires::default());
    // The homing order of a host of version 17, whose stop had this code, and one with an extra byte.
    for (framed, given, bytes) in [
        (framed(&[8, 5]), 5, 2),
        (framed(&[8, PROTOCOL, 5, 0]), PROTOCOL, 4),
    ] {
        line.line().heard.push_back(0);
        line.line().heard.extend(framed);
        while conversation.turn(&mut line, &mut drive.supervisor) {}
        let mut receiver = Receiver::new();
        let sent = std::mem::take(&mut line.line().to_say);
        let heard = sent.iter().find_map(|&byte| receiver.take::<Report>(byte));
        let refusal = Refusal::NotUnderstood {
            spoken: PROTOCOL,
            given,
            bytes,
        };
        assert_eq!(heard, Some(Ok(Report::Refused { id: 8, refusal })));
    }
    drive.pass(10);
    assert_eq!(drive.status().home, Home::Unknown);
    assert_eq!(drive.status().garbled, 0);
}

#[test]
fn a_stop_that_is_heard_voids_an_order_that_is_on_its_way() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    let mut listener = drive.listener.take().expect("one line");
    drive.done(Command::Start);
    let stop = request_bytes(1, Command::Stop);
    stop.iter().for_each(|&byte| listener.take(byte));
    for _ in 0..5 {
        drive.sample();
        assert!(drive.bench.held.get().is_none());
    }
    // It is decoded only now.
    assert_eq!(drive.refusal(Command::Start), Refusal::Overtaken);
    drive.order(Command::Stop, 5);
    drive.order(Command::Start, 5);
    assert!(drive.bench.held.get().is_some());
    // And the next one that is heard stops the run without being decoded at all.
    stop.iter().for_each(|&byte| listener.take(byte));
    drive.sampler.interrupt(&mut bench.pins());
    assert!(drive.bench.held.get().is_none());
}

#[test]
fn a_line_that_is_cut_anywhere_ends_the_run_in_time() {
    let mut random = Random(7);
    for _ in 0..200 {
        let mut wanted = fast();
        wanted.protection.link_timeout = 0.05;
        wanted.protection.stop_time = 0.05;
        let mut line = OnLine::with(wanted);
        line.ask(Command::Watch(1));
        line.ask(Command::Start);
        line.pass(0.001);
        for _ in 0..random.below(5) {
            line.request(Command::KeepAlive);
            line.pass(0.02);
        }
        assert!(line.is_driven());
        // In the middle of a request, and from then on noise.
        let framed = request_bytes(1, Command::Target(1.0));
        line.send(&framed[..random.below(framed.len() as u32) as usize]);
        let cut = line.now;
        while line.is_driven() {
            if random.below(100) == 0 {
                line.send(&[random.next() as u8]);
            }
            line.step();
            assert!(line.now < cut + 1_000_000_000, "still driven");
        }
        let late = (line.now - cut) as f64 * 1e-9;
        assert!(late < 0.05 + 0.05 + 0.002, "{late} s");
        line.pass(0.01);
        assert_eq!(line.drive.state(), State::Faulted(Fault::LinkLost));
    }
}
