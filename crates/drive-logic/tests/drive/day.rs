//! A drive for a day at 10 kHz, with its host at the other end of the line: every request is answered, every target is
//! reached, no sample shown is missing, every fault is reported once and disables the stage, and every stop is obeyed.

use std::time::Instant;

use crate::support::drive::{Drive, SERVO};
use crate::support::harms::{self, Harm};
use crate::support::line::{Random, Wires, order_bytes};
use crate::support::{Bench, Flash, settings};
use drive_link::{Command, Ended, Estimator, Fault, Receiver, Report, State};
use drive_logic::{Conversation, PolledLine};
use identifier_core::parameters::ServoParameters;

const RATE: u32 = 10_000;

/// Between two samples shown, samples.
const SHOWN: u16 = 1000;

/// The longest time from a request to its answer, and from an event to its effect on the output, samples.
const MAX_ANSWER: u32 = 10;
const MAX_EFFECT: u32 = 2;

/// Targets, rad: the axis has a second to reach the next one.
const TARGETS: f64 = 1.5;

/// Largest distance of the reference from its target then, rad: the dither.
const DITHER: f64 = 0.3;

/// A drive, its servo, its line, which is faster than the samples, and its host.
struct Day {
    drive: Drive,
    wires: PolledLine<'static, Wires>,
    conversation: Conversation,
    receiver: Receiver,
    id: u8,
    order: u32,
    /// Reports that are no samples shown, since they were last looked at.
    reports: Vec<Report>,
    /// The last sample shown of a run, its reference and the b estimated.
    shown: Option<(u32, f64, f64)>,
    random: Random,
}

impl Day {
    fn new(mut drive: Drive) -> Self {
        Self {
            wires: drive.polled(Wires::default()),
            drive,
            conversation: Conversation::new(),
            receiver: Receiver::new(),
            id: 0,
            order: 0,
            reports: Vec::new(),
            shown: None,
            random: Random(0x2545_f491),
        }
    }

    fn sample(&mut self) {
        let Drive {
            sampler,
            supervisor,
            bench,
            ..
        } = &mut self.drive;
        sampler.interrupt(&mut bench.pins());
        bench.pass();
        while self.conversation.turn(&mut self.wires, supervisor) {}
        while let Some(byte) = self.wires.line().to_say.pop_front() {
            match self.receiver.take::<Report>(byte) {
                Some(Ok(Report::Snapshot(shown))) => {
                    let apart = u32::from(SHOWN);
                    let is_next = self.shown.map_or(shown.sample <= apart, |(last, ..)| {
                        shown.sample == last + apart
                    });
                    assert!(is_next, "a sample shown is missing before {}", shown.sample);
                    let b = shown.estimates.servo.b;
                    self.shown = Some((shown.sample, shown.reference.into(), b));
                }
                Some(Ok(report)) => self.reports.push(report),
                Some(Err(error)) => panic!("a frame is damaged: {error:?}"),
                None => {}
            }
        }
    }

    fn pass(&mut self, samples: u32) {
        for _ in 0..samples {
            self.sample();
        }
    }

    /// Asks, and returns the answer, which must be the only report meanwhile.
    fn ask(&mut self, command: Command) -> Report {
        assert_eq!(self.reports, [], "nothing was reported unasked");
        (self.id, self.order) = (self.id.wrapping_add(1), self.order + 1);
        let (id, order) = (self.id, self.order);
        self.wires.line().heard.push_back(0);
        let bytes = order_bytes(id, order, command);
        self.wires.line().heard.extend(bytes);
        for _ in 0..MAX_ANSWER {
            self.sample();
            let Some(answer) = self.reports.pop() else {
                continue;
            };
            assert_eq!(self.reports, [], "one answer");
            let (Report::Done { id: same } | Report::Refused { id: same, .. }) = &answer else {
                assert!(
                    matches!(&answer, Report::Status { id: Some(same), .. } if *same == id),
                    "{answer:?}"
                );
                return answer;
            };
            assert_eq!(*same, id);
            return answer;
        }
        panic!("{command:?} is not answered");
    }

    fn done(&mut self, command: Command) {
        let answer = self.ask(command);
        assert!(
            matches!(answer, Report::Done { .. } | Report::Status { .. }),
            "{command:?}: {answer:?}"
        );
    }

    fn is_driven(&self) -> bool {
        self.drive.bench.held.get().is_some()
    }

    /// Runs until the stage is disabled, which must not take long.
    fn is_disabled_soon(&mut self) {
        let disabled = (0..MAX_EFFECT).any(|_| {
            self.sample();
            !self.is_driven()
        });
        assert!(disabled);
    }

    fn start(&mut self) {
        // The counter of the run's samples begins anew.
        self.shown = None;
        self.done(Command::Start);
        self.pass(2);
        assert!(self.is_driven());
    }

    /// A second of a run: a target, which must be reached, and signs of life.
    fn second(&mut self) {
        let target = TARGETS * (f64::from(self.random.below(2001)) / 1000.0 - 1.0);
        self.done(Command::Target(target));
        for _ in 0..4 {
            self.pass(RATE / 4 - MAX_ANSWER);
            let Report::Status { status, .. } = self.ask(Command::KeepAlive) else {
                panic!("no status");
            };
            assert_eq!(status.state, State::Running);
            assert_eq!((status.overruns, status.dropped, status.garbled), (0, 0, 0));
        }
        let (_, reference, _) = self.shown.expect("samples are shown");
        let off = (reference - target).abs();
        assert!(
            off <= DITHER + 0.01,
            "the target {target} was not reached, by {off} rad"
        );
    }

    /// A cause of a fault, which must be reported once and disable the stage; then the next run.
    fn fault(&mut self, fault: Fault, cause: Harm) {
        cause(&mut self.drive);
        self.is_disabled_soon();
        self.pass(MAX_ANSWER);
        assert_eq!(self.reports, [Report::Fault(fault)]);
        self.reports.clear();
        harms::repaired(&mut self.drive);
        self.pass(RATE / 100);
        self.done(Command::Clear);
        self.pass(MAX_ANSWER);
        // Its end is reported by the state.
        self.reports.clear();
        self.rest_and_start();
    }

    fn stop(&mut self) {
        self.done(Command::Stop);
        self.is_disabled_soon();
        self.pass(MAX_ANSWER);
        self.reports.clear();
        let Report::Status { status, .. } = self.ask(Command::Hello) else {
            panic!("no status");
        };
        assert_eq!(status.ended, Some(Ended::Stopped));
        self.rest_and_start();
    }

    /// The servo coasts for a while, and is then driven again.
    fn rest_and_start(&mut self) {
        self.drive.bench.hold_at(0.0);
        self.start();
    }
}

/// Faults by their causes.
const FAULTS: [(Fault, Harm); 4] = [
    (Fault::SupplyLow, harms::supply_sags),
    (Fault::AmplifierFault, harms::amplifier_fails),
    (Fault::EncoderLost, harms::encoder_fails),
    (Fault::ActuatorFailed, harms::stage_fails),
];

/// Hours of a drive, each minute of which ends with a stop or a fault.
fn hours(hours: f64) {
    let servo = ServoParameters { load: 0.0, ..SERVO };
    let bench = Bench::sampled(&servo, 1.0 / f64::from(RATE));
    let mut drive = Drive::boot(bench, &Flash::blank());
    let mut settings = settings();
    settings.closed_loop.core.sample_time = 1.0 / f64::from(RATE);
    settings.closed_loop.law = Estimator::GaussNewton;
    settings.dither.amplitude = DITHER;
    settings.protection.link_timeout = 1.0;
    drive.done(Command::Configure(settings));
    let mut day = Day::new(drive);
    day.done(Command::Watch(SHOWN));
    let begun = Instant::now();
    let minutes = (60.0 * hours).ceil() as usize;
    day.start();
    for minute in 0..minutes {
        for _ in 0..60 {
            day.second();
        }
        let (_, _, b) = day.shown.expect("samples are shown");
        assert!(
            (b / servo.b - 1.0).abs() < 0.01,
            "minute {minute}: b is {b}"
        );
        match FAULTS.get(minute % (FAULTS.len() + 1)) {
            Some(&(fault, cause)) => day.fault(fault, cause),
            None => day.stop(),
        }
    }
    println!(
        "{minutes} minutes at {} kHz in {:.0} s: every request answered, {} targets reached, {} faults reported, {} stops \
         obeyed",
        RATE / 1000,
        begun.elapsed().as_secs_f64(),
        60 * minutes,
        minutes - minutes / 5,
        minutes / 5
    );
}

#[test]
fn five_minutes_at_10_khz_lose_no_order_and_no_fault() {
    hours(5.0 / 60.0);
}

/// `cargo test -p drive-logic day:: -- --ignored --nocapture`.
#[test]
#[ignore = "it takes minutes"]
fn a_day_at_10_khz_loses_no_order_and_no_fault() {
    hours(24.0);
}
