//! The line of a drive: what a stop overtakes, and the effect of lost bytes. Its times are checked by the stops in `tests`.

use std::collections::VecDeque;

use crate::support::commission::ORDER;
use crate::support::drive::{Drive, SERVO};
use crate::support::line::{ROOM, Wires, request_bytes};
use crate::support::{HOMING, settings};
use drive_link::{Command, Home, Line, PROTOCOL, Receiver, Refusal, Report, State};
use drive_logic::Conversation;

#[test]
fn reports_leave_the_room_that_an_answer_needs() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.done(Command::Watch(1));
    drive.done(Command::Start);
    let mut line = drive.polled(Wires::default());
    let mut conversation = Conversation::new();
    // Nothing of it is taken away.
    for _ in 0..1000 {
        drive.sampler.interrupt(&mut bench.pins());
        bench.pass();
        while conversation.turn(&mut line, &mut drive.supervisor) {}
    }
    assert!(drive.status().dropped > 0, "the line is full");
    line.line().heard.push_back(0);
    line.line().heard.extend(request_bytes(7, Command::Show));
    while conversation.turn(&mut line, &mut drive.supervisor) {}
    let mut receiver = Receiver::new();
    let sent = std::mem::take(&mut line.line().to_say);
    let mut heard = sent.iter().filter_map(|&byte| receiver.take(byte));
    let is_answer = |report| matches!(report, Ok(Report::Settings { id: 7, .. }));
    assert!(heard.any(is_answer), "asked once");
}

#[test]
fn requests_without_a_pause_do_not_hide_a_stop() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.order(Command::Start, 10);
    let mut line = drive.polled(Wires::default());
    // More than all the queues hold, each with a long answer.
    let show = request_bytes(1, Command::Show);
    line.line().heard.extend(show.repeat(3000));
    line.line().heard.extend(request_bytes(2, Command::Stop));
    Conversation::new().turn(&mut line, &mut drive.supervisor);
    drive.sample();
    assert_eq!(bench.held.get(), None);
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
    let piece = |id, command| VecDeque::from(request_bytes(id, command));
    let mut pieces = drive.polled(Pieces(
        [piece(1, Command::Start), piece(2, Command::Stop)].into(),
    ));
    let mut conversation = Conversation::new();
    for _ in 0..10 {
        conversation.turn(&mut pieces, &mut drive.supervisor);
        drive.sample();
        assert!(drive.bench.held.get().is_none());
    }
    // And without one it begins.
    *pieces.line() = Pieces([piece(3, Command::Start), piece(4, Command::Hello)].into());
    conversation.turn(&mut pieces, &mut drive.supervisor);
    drive.sample();
    assert!(drive.bench.held.get().is_some());
}

#[test]
fn an_order_around_lost_bytes_is_refused_until_all_before_them_is_decoded() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let mut listener = drive.listener.take().expect("one line");
    let mut conversation = Conversation::new();
    let start = |id| request_bytes(id, Command::Start);
    let mut line = Wires {
        heard: start(1).into(),
        ..Wires::default()
    };
    listener.disturbed();
    conversation.turn(&mut line, &mut drive.supervisor);
    drive.sample();
    assert!(drive.bench.held.get().is_none(), "a stop may be lost");
    drive.order = 1;
    assert_eq!(drive.refusal(Command::Target(0.1)), Refusal::LineDisturbed);
    assert_eq!(drive.status().disturbed, 1);
    // Nothing is left of that time.
    conversation.turn(&mut line, &mut drive.supervisor);
    line.heard.extend(start(3));
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
        Command::RelativeTarget(0.1),
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
        (framed(&[8, PROTOCOL, 1, 5, 0]), PROTOCOL, 5),
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
