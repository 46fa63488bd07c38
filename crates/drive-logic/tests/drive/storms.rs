//! Conversations whose frames are lost, doubled and late, those of older runs among them. The drive does what the orders of
//! this run ask for, in the order of their numbers, and nothing else.

use crate::support::drive::{Drive, SERVO};
use crate::support::line::Random;
use crate::support::{SAMPLE_TIME, still};
use drive_link::{Command, Refusal, Report, Request, State};

/// Steps of a conversation, and the samples of each.
const STEPS: u32 = 80;
const SAMPLES: u32 = 3;

/// The longest way of a frame, steps: longer than many runs.
const LATEST: u32 = 60;

/// What the orders ask for that have arrived.
#[derive(Debug, Default)]
struct Asked {
    last: u32,
    runs: bool,
    /// Rad from where the run started.
    target: f64,
}

impl Asked {
    /// Takes in a request and its answer.
    fn take(&mut self, request: &Request, answer: &Report) {
        let refusal = match answer {
            Report::Refused { refusal, .. } => Some(refusal),
            _ => None,
        };
        let Request { order, command, .. } = *request;
        if command == Command::Stop {
            self.runs = false;
        }
        if !command.may_move() {
            return;
        }
        if order <= self.last {
            let is_last = order == self.last;
            assert!(
                refusal == Some(&Refusal::GivenBefore) || is_last,
                "{request:?}: {answer:?}"
            );
            return;
        }
        self.last = order;
        match command {
            _ if refusal.is_some() => {}
            Command::Start => {
                (self.target, self.runs) = (if self.runs { self.target } else { 0.0 }, true)
            }
            Command::Target(target) => self.target = target,
            _ => unreachable!("none of these"),
        }
    }
}

/// One conversation.
fn converse(random: &mut Random) {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    let mut wanted = still();
    wanted.protection.following_error = 10.0;
    drive.done(Command::Configure(wanted));
    drive.done(Command::Watch(1));
    let mut asked = Asked::default();
    let mut ways: Vec<(u32, Request)> = Vec::new();
    let (mut given, mut from) = (0, bench.position());
    for step in 0..STEPS + LATEST {
        if step < STEPS && random.below(3) == 0 {
            given += 1;
            let command = match random.below(5) {
                0 | 1 => Command::Start,
                2 => Command::Stop,
                _ => Command::Target(f64::from(random.below(100)) / 100.0),
            };
            let request = match command {
                Command::Stop => Request::without_order(given as u8, command),
                _ => Request {
                    id: given as u8,
                    order: given,
                    command,
                },
            };
            let copies = [1, 1, 1, 2, 2, 3, 0][random.below(7) as usize];
            for _ in 0..copies {
                let late = [0, 0, 1, random.below(LATEST)][random.below(4) as usize];
                ways.push((step + late, request));
            }
        }
        let (due, under_way) = ways.into_iter().partition(|(at, _)| *at <= step);
        ways = under_way;
        for (_, request) in due {
            let ran = asked.runs;
            let answer = drive.supervisor.answer(&request);
            asked.take(&request, &answer);
            if asked.runs && !ran {
                from = bench.position();
            }
            let reports = drive.pass(SAMPLES);
            assert!(
                !reports
                    .iter()
                    .any(|report| matches!(report, Report::Fault(_))),
                "{reports:?}"
            );
            assert_eq!(bench.held.get().is_some(), asked.runs, "{request:?}");
            let state = if asked.runs {
                State::Running
            } else {
                State::Disabled
            };
            assert_eq!(drive.state(), state);
        }
        drive.pass(SAMPLES);
    }
    // All of it is over.
    drive.pass((1.0 / SAMPLE_TIME) as u32);
    assert_eq!(bench.held.get().is_some(), asked.runs);
    if asked.runs {
        let off = bench.position() - from - asked.target;
        assert!(off.abs() < 0.05, "{off} {asked:?}");
    }
}

fn converse_times(times: u32, seed: u32) {
    let mut random = Random(seed.max(1));
    (0..times).for_each(|_| converse(&mut random));
}

#[test]
fn no_frame_that_is_late_or_doubled_moves_the_axis() {
    converse_times(300, 1);
}

#[test]
#[ignore = "minutes: `CONVERSATIONS=50000 SEED=1 cargo test --release -p drive-logic --test drive -- --ignored storms`"]
fn no_frame_of_many_conversations_moves_the_axis_late() {
    let number = |name: &str, usual| {
        let given = std::env::var(name).ok();
        given.map_or(usual, |text| text.parse().expect("a number"))
    };
    converse_times(number("CONVERSATIONS", 50_000), number("SEED", 1));
}
