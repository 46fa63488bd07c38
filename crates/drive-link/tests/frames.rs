//! Frames over a line that loses, doubles and changes bytes.

use commissioning::{CommissionSettings, Limits, Phase, TrialResult};
use drive_link::{
    Command, Commissioning, Dither, Estimates, Estimator, Fault, FrameError, HoldingBrake, Homing,
    LoopSettings, MAX_FRAME_BYTES, MotionRecord, NoGains, Outcome, PROTOCOL, Protection, Receiver,
    Refusal, Report, Request, ServoChanges, Settings, Snapshot, StopListener, TargetSource,
    TermSizes, frame,
};
use identifier_core::control::FeedForwardSettings;
use identifier_core::fit::Block;
use identifier_core::parameters::{IdentifiedServo, PerParameter, ServoParameters, Term, Terms};
use identifier_core::reason::Reason;
use identifier_core::settings::{
    ControllerSettings, IdentifierSettings, ParameterRangeSettings, RangeSettings, TermSettings,
};
use identifier_core::tuning::{Cap, Goal, PredictedResponse, Tuning};
use proptest::prelude::*;

/// Settings of any numbers, and of everything that may be left out any part.
fn settings() -> impl Strategy<Value = Settings> {
    let number = any::<f64>().prop_filter("numbers", |number| !number.is_nan());
    let numbers = prop::collection::vec(number, 104);
    (numbers, any::<u32>(), any::<u8>()).prop_map(|(n, given, overruns)| {
        let mut numbers = n.into_iter();
        filled(&mut || numbers.next().expect("enough"), given, overruns)
    })
}

/// Settings of these numbers; each bit of `given` includes one optional field.
fn filled(next: &mut impl FnMut() -> f64, mut given: u32, overruns: u8) -> Settings {
    let mut is_given = || {
        given = given.rotate_left(1);
        given & 1 == 1
    };
    let mut perhaps = |next: &mut dyn FnMut() -> f64| is_given().then(next);
    let identifier = IdentifierSettings {
        initial: PerParameter::from_fn(|_| perhaps(next)),
        known: PerParameter::from_fn(|_| perhaps(&mut || 0.0).is_some()),
        bounds: PerParameter::from_fn(|_| perhaps(next).map(|low| [low, next()])),
        uncertainty: PerParameter::from_fn(|_| perhaps(next)),
        noise: perhaps(next),
        parameter_range: perhaps(next).map(|low| ParameterRangeSettings {
            a: [low, next()],
            b: [next(), next()],
        }),
        gamma: perhaps(next).map(|a| PerParameter::new(a, next(), next(), next())),
        mu: perhaps(next),
        correction: perhaps(next).map(|kp| [kp, next(), next()]),
        bandwidth: perhaps(next),
        start_time: perhaps(next),
        memory: perhaps(next),
        terms: TermSettings {
            demanded: Terms::NONE.with(Term::Delay).with(Term::Gravity),
            delay: next(),
            dead_band: next(),
            current_loop: next(),
            low_speed_velocity: perhaps(next),
            ripple_order: perhaps(next),
            revolution: next(),
        },
        max_speed: perhaps(next),
        ranges: perhaps(next).map(|error| RangeSettings {
            error,
            velocity: next(),
            command: next(),
        }),
    };
    let friction = perhaps(next).is_some();
    let core = identifier_core::Settings {
        sample_time: next(),
        resolution: next(),
        cutoff: next(),
        controller: perhaps(next).map(|kp| ControllerSettings {
            kp,
            kd: next(),
            ki: next(),
            limit: [next(), next()],
            reference_filter: next(),
            notch: next(),
            feed_forward: perhaps(next).map(|bandwidth| FeedForwardSettings {
                bandwidth,
                acceleration: next(),
                velocity: next(),
                coulomb: next(),
                coulomb_speed: next(),
            }),
        }),
        identifier,
    };
    Settings {
        closed_loop: LoopSettings {
            core,
            law: Estimator::Gradient { friction },
        },
        dither: Dither {
            amplitude: next(),
            hold: next(),
        },
        protection: Protection {
            following_error: next(),
            travel: [next(), next()],
            pace: next(),
            speed: next(),
            breakaway: next(),
            stall_time: next(),
            overruns,
            duration: next(),
            link_timeout: next(),
            stop_time: next(),
        },
        homing: Some(Homing {
            seek: next(),
            approach: next(),
            clearance: next(),
            index: true,
            offset: next(),
        }),
        source: TargetSource::Steps { step: next() },
        servo_changes: ServoChanges::Reported,
        brake: Some(HoldingBrake {
            opens: next(),
            closes: next(),
        }),
    }
}

#[test]
fn settings_with_every_field_fit_a_message() {
    let settings = filled(&mut || f64::MIN, u32::MAX, u8::MAX);
    let command = Command::Configure(settings);
    let framed = frame(&Request {
        id: 255,
        order: u32::MAX,
        command,
    })
    .expect("it fits");
    assert!(framed.len() <= MAX_FRAME_BYTES, "{}", framed.len());
    let report = Report::Settings { id: 255, settings };
    // A report carries neither version nor order.
    assert_eq!(frame(&report).expect("it fits").len() + 6, framed.len());
}

/// Any estimates.
const SERVO: ServoParameters = ServoParameters {
    a: f64::MIN,
    b: f64::MIN,
    coulomb: f64::MIN,
    load: f64::MIN,
};

fn order() -> CommissionSettings {
    CommissionSettings {
        sample_time: 1e-4,
        resolution: 1e-3,
        limits: Limits {
            travel: [-1.0, 1.0],
            speed: 50.0,
            command: [-10.0, 10.0],
            duration: 1.0,
        },
        command_delay: 1e-5,
        max_gain: Some(1e3),
        noise: 1e-3,
        goal: Goal::ResponseTime(0.02),
        max_sensitivity: 1.6,
        trial_step: Some(0.5),
        notch: true,
        feed_forward: true,
    }
}

#[test]
fn every_report_of_a_commissioning_fits_a_message() {
    let command = Command::Commission(order());
    assert!(
        frame(&Request {
            id: 255,
            order: u32::MAX,
            command
        })
        .is_ok()
    );
    let outcome = Outcome {
        commissioning: Commissioning {
            phase: Phase::RolledBack,
            reason: Some(Reason::AmplifierFault),
        },
        servo: Some(IdentifiedServo {
            parameters: SERVO,
            delay: f64::MIN,
            covariance: [[f64::MIN; 5]; 5],
            unexplained: f64::MIN,
        }),
        tuning: Some(Tuning {
            kp: f64::MIN,
            kd: f64::MIN,
            ki: f64::MIN,
            cutoff: f64::MIN,
            reference_filter: f64::MIN,
            notch: f64::MIN,
            feed_forward: Some(FeedForwardSettings {
                bandwidth: f64::MIN,
                acceleration: f64::MIN,
                velocity: f64::MIN,
                coulomb: f64::MIN,
                coulomb_speed: f64::MIN,
            }),
            bandwidth: f64::MIN,
            cap: Some(Cap::Delay),
            predicted_response: PredictedResponse {
                step: f64::MIN,
                rise_time: f64::MIN,
                quickest_rise_time: f64::MIN,
                slowest_rise_time: f64::MIN,
                overshoot: f64::MIN,
                settling_time: f64::MIN,
                sensitivity: f64::MIN,
                gain_margins: [f64::MIN; 2],
                command_share: f64::MIN,
                noise: f64::MIN,
                compliance: f64::MIN,
            },
        }),
        no_gains: Some(NoGains::TooFast {
            bandwidth: f64::MIN,
            most: f64::MIN,
            cap: Cap::EncoderNoise,
        }),
        trial: Some(TrialResult {
            step: f64::MIN,
            rise_time: Some(f64::MIN),
            overshoot: f64::MIN,
        }),
        noise: f64::MIN,
        kept: true,
    };
    let report = Report::Outcome { id: 255, outcome };
    let framed = frame(&report).expect("it fits");
    let mut receiver = Receiver::new();
    let heard = framed
        .iter()
        .find_map(|&byte| receiver.take::<Report>(byte));
    assert_eq!(heard, Some(Ok(report)));
}

#[test]
fn a_record_is_whole_after_messages_that_all_fit() {
    let block = |k: u16| Block {
        travel: f32::from(k),
        command: f32::MIN,
        first_moment: f32::MAX,
    };
    let record: Vec<_> = (0..1000).map(block).collect();
    let mut heard: Vec<u16> = Vec::new();
    while heard.len() < record.len() {
        let first = heard.len() as u16;
        let part = MotionRecord::from((&record, u16::MAX, f64::MIN), first);
        let report = Report::MotionRecord { id: 255, part };
        let framed = report.framed().expect("it fits");
        assert!(framed.len() <= MAX_FRAME_BYTES, "{}", framed.len());
        let mut receiver = Receiver::new();
        let received = framed.iter().find_map(|&byte| receiver.take(byte));
        assert_eq!(received.as_ref(), Some(&Ok(report)));
        let Some(Ok(Report::MotionRecord { part, .. })) = received else {
            continue;
        };
        assert_eq!(part.total, 1000);
        heard.extend(part.blocks.iter().map(|block| block[0] as u16));
    }
    assert!((0..1000).eq(heard));
    let beyond = MotionRecord::from((&record, 1, 1.0), 1000);
    assert!(beyond.blocks.is_empty());
}

fn request() -> impl Strategy<Value = Request> {
    let command = prop_oneof![
        Just(Command::Hello),
        settings().prop_map(Command::Configure),
        Just(Command::Start),
        any::<u16>().prop_map(Command::Watch),
        (-1e3_f64..1e3).prop_map(Command::Target),
        Just(Command::Save),
        Just(Command::Home),
        Just(Command::Commission(order())),
        Just(Command::Outcome),
        any::<u16>().prop_map(Command::MotionRecord),
        Just(Command::BoardTest),
        Just(Command::KeepAlive),
    ];
    (any::<u8>(), any::<u32>(), command).prop_map(|(id, order, command)| match command {
        Command::Stop => Request::without_order(id, command),
        _ => Request { id, order, command },
    })
}

fn received(receiver: &mut Receiver, bytes: &[u8]) -> Vec<Result<Request, FrameError>> {
    bytes
        .iter()
        .filter_map(|&byte| receiver.take_request(byte))
        .collect()
}

proptest! {
    #[test]
    fn every_message_is_received_as_sent(requests in prop::collection::vec(request(), 1..8)) {
        let mut line = Vec::new();
        for request in &requests {
            let framed = frame(request).expect("it fits");
            prop_assert!(framed.len() <= MAX_FRAME_BYTES);
            prop_assert_eq!(framed.iter().position(|&byte| byte == 0), Some(framed.len() - 1));
            line.extend_from_slice(&framed);
        }
        let heard = received(&mut Receiver::new(), &line);
        prop_assert_eq!(heard, requests.into_iter().map(Ok).collect::<Vec<_>>());
    }

    #[test]
    fn after_any_garbage_the_next_frame_but_one_is_received(
        garbage in prop::collection::vec(any::<u8>(), 0..3 * MAX_FRAME_BYTES),
        first in request(),
        second in request(),
    ) {
        let mut receiver = Receiver::new();
        let heard = received(&mut receiver, &garbage);
        prop_assert!(heard.iter().all(Result::is_err), "{heard:?}");
        // The remains of the garbage may corrupt the first, but not after a zero.
        received(&mut receiver, &frame(&first).expect("it fits"));
        let heard = received(&mut receiver, &frame(&second).expect("it fits"));
        prop_assert_eq!(heard, vec![Ok(second)]);
    }

    #[test]
    fn a_lost_a_doubled_and_a_changed_byte_cost_one_frame(
        spoilt in request(),
        next in request(),
        place: prop::sample::Index,
        bit in 0_u8..8,
        kind in 0..3,
    ) {
        let mut line = frame(&spoilt).expect("it fits").to_vec();
        let place = place.index(line.len() - 1);
        match kind {
            0 => { line.remove(place); }
            1 => line.insert(place, line[place]),
            _ => line[place] ^= 1 << bit,
        }
        line.extend_from_slice(&frame(&next).expect("it fits"));
        let heard = received(&mut Receiver::new(), &line);
        prop_assert_eq!(heard.last(), Some(&Ok(next)));
        let misheard = heard[..heard.len() - 1].iter().filter(|heard| heard.is_ok()).count();
        prop_assert_eq!(misheard, 0, "{:?} became {:?}", spoilt, heard);
    }

    #[test]
    fn a_stop_is_received_amid_any_bytes_and_no_other_bytes_are_a_stop(
        before in prop::collection::vec(any::<u8>(), 0..3 * MAX_FRAME_BYTES),
        other in request(),
        id: u8,
        place: prop::sample::Index,
        bit in 0_u8..8,
    ) {
        let mut listener = StopListener::new();
        let mut stops = |bytes: &[u8]| bytes.iter().filter(|&&byte| listener.take(byte)).count();
        prop_assert_eq!(stops(&before) + stops(&[0]), 0);
        prop_assert_eq!(stops(&frame(&other).expect("it fits")), 0);
        let stop = frame(&Request::without_order(id, Command::Stop)).expect("it fits");
        prop_assert_eq!(stops(&stop), 1);
        prop_assert_eq!(stops(&stop), 1);
        let mut spoilt = stop.to_vec();
        spoilt[place.index(stop.len() - 1)] ^= 1 << bit;
        prop_assert_eq!(stops(&spoilt) + stops(&[0]), 0);
        prop_assert_eq!(stops(&stop), 1);
    }

    #[test]
    fn a_snapshot_arrives_as_it_was_sent(
        sample: u32,
        command in -1e6_f32..1e6,
        output_error in -1e9_f32..1e9,
        flags: (bool, bool),
    ) {
        let report = Report::Snapshot(Snapshot {
            sample,
            reference: 1.0,
            position: -2.0,
            command,
            output_error,
            estimates: Estimates {
                servo: ServoParameters {
                    a: command.into(),
                    b: 2.0,
                    coulomb: 0.0,
                    load: output_error.into(),
                },
                at_bounds: PerParameter { a: flags.1, ..PerParameter::default() },
                standard_errors: flags.0.then_some(SERVO),
                terms: TermSizes::where_known(|_| flags.1.then_some(f64::from(command))),
            },
        });
        let mut receiver = Receiver::new();
        let heard = frame(&report)
            .expect("it fits")
            .iter()
            .find_map(|&byte| receiver.take::<Report>(byte));
        prop_assert_eq!(heard, Some(Ok(report)));
    }
}

/// A message of the host in a frame, byte by byte: its check and its framing are computed here apart from the code.
fn framed_bytes(message: &[u8]) -> Vec<u8> {
    framed_from(u32::MAX, message)
}

/// The same with a check that begins from this value.
fn framed_from(mut check: u32, message: &[u8]) -> Vec<u8> {
    for &byte in message {
        check ^= u32::from(byte);
        for _ in 0..8 {
            check = check >> 1 ^ if check & 1 == 1 { 0xedb8_8320 } else { 0 };
        }
    }
    let whole = [message, &(!check).to_le_bytes()].concat();
    let runs = whole.split(|&byte| byte == 0);
    let mut framed: Vec<u8> = runs
        .flat_map(|run| [&[run.len() as u8 + 1], run].concat())
        .collect();
    framed.push(0);
    framed
}

#[test]
fn the_bytes_of_a_stop_are_these_in_every_version() {
    const STOP: [u8; 8] = [0x07, 0x09, 0x06, 0x83, 0x0c, 0x78, 0x79, 0x00];
    let stop = Request::without_order(9, Command::Stop);
    assert_eq!(framed_bytes(&[9, 6]), STOP);
    assert_eq!(frame(&stop).expect("it fits"), STOP);
    assert_eq!(received(&mut Receiver::new(), &STOP), [Ok(stop)]);
    let mut listener = StopListener::new();
    assert_eq!(STOP.iter().filter(|&&byte| listener.take(byte)).count(), 1);
}

#[test]
fn a_request_of_another_version_is_none_whatever_it_asks_for() {
    const OURS: u8 = PROTOCOL;
    let heard = |message: &[u8]| {
        let mut heard = received(&mut Receiver::new(), &framed_bytes(message));
        (heard.len() == 1)
            .then(|| heard.remove(0))
            .expect("a frame")
    };
    let refused = |message: &[u8]| {
        Err(FrameError::NoRequest {
            id: message[0],
            given: message[1],
            bytes: message.len() as u16,
        })
    };
    // Start, as it has always been numbered.
    let (id, order, command) = (7, 5, Command::Start);
    assert_eq!(heard(&[7, OURS, 5, 3]), Ok(Request { id, order, command }));
    for version in (0..=u8::MAX).filter(|&version| version != OURS) {
        assert_eq!(
            heard(&[7, version, 5, 3]),
            refused(&[7, version, 5, 3]),
            "{version}"
        );
    }
    // A request of a host that sends no version, of any number and command; its stop is one here too.
    for id in [0, 3, 6, OURS - 1, OURS, 255] {
        for command in (0..=12).filter(|&command| command != 6) {
            for body in [&[][..], &[0], &[3], &[3, 3], &[0; 8]] {
                let message = [&[id, command], body].concat();
                assert_eq!(heard(&message), refused(&message));
            }
        }
    }
    // A command that is longer, shorter, missing or unknown, and a stop that is longer or in the place of a command.
    for message in [
        &[7, OURS, 5, 3, 0][..],
        &[7, OURS, 5, 4, 0, 0],
        &[7, OURS],
        &[7, OURS, 5],
        &[7, OURS, 5, 200],
        &[7, OURS, 5, 99],
        &[7, 6, 0],
    ] {
        assert_eq!(heard(message), refused(message));
    }
    assert_eq!(heard(&[7]), Err(FrameError::Unknown));
}

#[test]
fn a_refusal_for_another_version_has_the_same_bytes_in_every_version() {
    let refusal = Refusal::NotUnderstood {
        spoken: 19,
        given: 3,
        bytes: 300,
    };
    let shown = refusal.to_string();
    for part in ["version 19", "version 3", "300 bytes", "flash"] {
        assert!(shown.contains(part), "{shown}");
    }
    let report = Report::Refused { id: 7, refusal };
    let message = [1, 7, 0, 19, 3, 0xac, 0x02];
    // "rprt" as the check has it, its bits in the other order.
    const SEED_OF_REPORTS: u32 = 0x7472_7072_u32.reverse_bits();
    let framed = frame(&report).expect("it fits");
    assert_eq!(framed, framed_from(SEED_OF_REPORTS, &message)[..]);
    // A drive of a version up to 21 sends it with the check of a request: this, and that a stop was done, is understood.
    let heard = |bytes: &[u8]| {
        let mut receiver = Receiver::new();
        bytes.iter().find_map(|&byte| receiver.take::<Report>(byte))
    };
    assert_eq!(heard(&framed_bytes(&message)), Some(Ok(report)));
    assert_eq!(
        heard(&framed_bytes(&[0, 7])),
        Some(Ok(Report::Done { id: 7 }))
    );
    assert_eq!(
        heard(&framed_bytes(&[1, 7, 1])),
        Some(Err(FrameError::Damaged))
    );
}

#[test]
fn the_echo_of_a_report_is_no_request_and_no_stop() {
    let refused = |id, refusal| Report::Refused { id, refusal };
    let not_understood = Refusal::NotUnderstood {
        spoken: PROTOCOL,
        given: PROTOCOL,
        bytes: 3,
    };
    for id in 0..=u8::MAX {
        for report in [
            Report::Done { id },
            refused(id, Refusal::LineDisturbed),
            refused(id, Refusal::Overtaken),
            refused(id, Refusal::Busy),
            refused(id, not_understood.clone()),
            Report::Fault(Fault::LinkLost),
        ] {
            let framed = frame(&report).expect("it fits");
            // An echo that is answered has an echo: it never ends.
            let heard = received(&mut Receiver::new(), &framed);
            assert_eq!(heard, [Err(FrameError::Damaged)], "{report:?}");
            let mut listener = StopListener::new();
            assert!(
                !framed.iter().any(|&byte| listener.take(byte)),
                "{report:?}"
            );
        }
    }
}

#[test]
fn a_frame_without_end_is_refused_and_forgotten() {
    let mut receiver = Receiver::new();
    for _ in 0..10 * MAX_FRAME_BYTES {
        assert_eq!(receiver.take_request(7), None);
    }
    assert_eq!(receiver.take_request(0), Some(Err(FrameError::TooLong)));
    let hello = Request::without_order(3, Command::Hello);
    let heard = received(&mut receiver, &frame(&hello).expect("it fits"));
    assert_eq!(heard, vec![Ok(hello)]);
}
