//! Any input: settings of any numbers, bytes of any value, requests in any order, a flash of any
//! content. The drive refuses or faults, and never moves without an order.

use crate::support::commission::ORDER;
use crate::support::drive::{Drive, SERVO};
use crate::support::line::{Wires, request_bytes};
use crate::support::{Flash, HOMING, SECTOR, numbers, settings};
use drive_link::{Command, Estimator, Homing, Report, Settings, State, TargetSource};
use drive_logic::Conversation;
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(f64::MIN_POSITIVE),
        Just(f64::MAX),
        -1e3..1e3,
        any::<f64>(),
    ]
}

fn number_of_any_size() -> impl Strategy<Value = f64> {
    prop_oneof![
        number(),
        (-50.0..50.0).prop_map(|power| f64::powf(10.0, power))
    ]
}

fn law() -> impl Strategy<Value = Estimator> {
    prop_oneof![
        Just(Estimator::Gradient { friction: false }),
        Just(Estimator::Gradient { friction: true }),
        Just(Estimator::GaussNewton),
    ]
}

fn source() -> impl Strategy<Value = TargetSource> {
    prop_oneof![
        2 => Just(TargetSource::Line),
        1 => number().prop_map(|step| TargetSource::Steps { step }),
    ]
}

/// Settings with a few arbitrary numbers, as factors of the former ones or in their place.
fn any_settings() -> impl Strategy<Value = Settings> {
    let changes = prop::collection::vec(
        (any::<prop::sample::Index>(), number(), any::<bool>()),
        0..4,
    );
    let of_run = (0_u8..4, source(), any::<bool>());
    (changes, law(), of_run).prop_map(|(changes, law, (overruns, source, index))| {
        let mut wanted = settings();
        wanted.source = source;
        wanted.homing = Some(Homing { index, ..HOMING });
        wanted.closed_loop.law = law;
        wanted.protection.overruns = overruns;
        for (place, number, as_factor) in changes {
            let mut numbers = numbers::of_settings(&mut wanted);
            let place = place.index(numbers.len());
            let changed = &mut *numbers[place].1;
            *changed = if as_factor { *changed * number } else { number };
        }
        wanted
    })
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        Just(Command::Hello),
        Just(Command::Show),
        Just(Command::Start),
        Just(Command::Home),
        Just(Command::Stop),
        Just(Command::Clear),
        Just(Command::Save),
        any::<u16>().prop_map(Command::Watch),
        any::<u16>().prop_map(Command::MotionRecord),
        number().prop_map(Command::Target),
        any_settings().prop_map(Command::Configure),
    ]
}

/// The command that is held is within the output stage's range, and held only in a run.
fn holds_what_it_may(drive: &Drive) -> Result<(), TestCaseError> {
    if let Some(command) = drive.bench.held.get() {
        prop_assert!(command.abs() <= 10.0, "{}", command);
        prop_assert_eq!(drive.state(), State::Running);
    }
    Ok(())
}

proptest! {
    #[test]
    fn settings_of_any_numbers_are_refused_or_run_within_their_limits(
        wanted in any_settings(),
        outside in prop::collection::vec(prop::option::of(any::<i16>()), 1..10),
        homes in any::<bool>(),
        switch in (-1.0..1.0, 0.0..2.0),
    ) {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        if let Report::Done { .. } = drive.ask(Command::Configure(wanted)) {
            drive.done(Command::Watch(1));
            let limit = wanted.closed_loop.core.controller.expect("taken").limit;
            if let Report::Done { .. } = drive.ask(Command::Start) {
                if homes {
                    *bench.home_switch.borrow_mut() = switch.0..switch.0 + switch.1;
                    drive.ask(Command::Home);
                }
                for k in 0..300 {
                    bench.steps.set(outside[k / 20 % outside.len()]);
                    for report in drive.pass(1) {
                        if let Report::Snapshot(shown) = report {
                            let command = f64::from(shown.command);
                            prop_assert!((limit[0] - 1e-5..=limit[1] + 1e-5).contains(&command));
                            prop_assert!(shown.estimates.servo.b.is_finite());
                            prop_assert!(shown.output_error.is_finite());
                        }
                    }
                    holds_what_it_may(&drive)?;
                }
            }
        }
    }

    #[test]
    fn any_order_to_commission_is_refused_or_keeps_its_limits(
        changes in prop::collection::vec((0_usize..9, number_of_any_size(), any::<bool>()), 0..3),
    ) {
        let mut order = ORDER;
        for (place, number, as_factor) in changes {
            let (_, changed) = &mut numbers::of_order(&mut order)[place];
            **changed = if as_factor { **changed * number } else { number };
        }
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        if let Report::Done { .. } = drive.ask(Command::Commission(order)) {
            let [low, high] = order.limits.travel;
            let counts = |radians: f64| (radians / order.resolution) as f32;
            prop_assert!(counts(low).is_finite() && counts(high - low) <= 16_777_216.0);
            let a_sample = counts(order.limits.speed * order.sample_time);
            prop_assert!(a_sample > 0.0 && a_sample <= 32_767.01, "{}", a_sample);
            let [least, most] = order.limits.command;
            prop_assert!((-10.0..0.0).contains(&least) && most > 0.0 && most <= 10.0);
            for _ in 0..1000 {
                drive.pass(1);
                if let Some(command) = bench.held.get() {
                    // Until it ends, and the gains before hold the servo.
                    let is_within = (least..=most).contains(&f64::from(command));
                    prop_assert!(command.is_finite() && command.abs() <= 10.0);
                    prop_assert!(is_within || drive.state() == State::Commissioning);
                }
            }
        }
    }

    #[test]
    fn bytes_and_requests_in_any_order_move_nothing_without_a_start(
        steps in prop::collection::vec(
            prop_oneof![
                prop::collection::vec(any::<u8>(), 0..200).prop_map(Err),
                any_command().prop_map(Ok),
            ],
            1..30,
        ),
        breaks in any::<prop::sample::Index>(),
    ) {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        let mut conversation = Conversation::new();
        let mut wire = drive.polled(Wires::default());
        let mut started = false;
        let breaks_at = breaks.index(steps.len());
        for (k, step) in steps.into_iter().enumerate() {
            match step {
                Ok(command) => {
                    started |= matches!(command, Command::Start);
                    wire.line().heard.push_back(0);
                    wire.line().heard.extend(request_bytes(k as u8 + 1, command));
                }
                Err(bytes) => wire.line().heard.extend(bytes),
            }
            if k == breaks_at {
                bench.sensor_works.set(false);
            }
            wire.line().to_say.clear();
            for _ in 0..5 {
                drive.sampler.interrupt(&mut bench.pins());
                bench.pass();
                for _ in 0..10 {
                    conversation.turn(&mut wire, &mut drive.supervisor);
                }
                holds_what_it_may(&drive)?;
                prop_assert!(started || bench.held.get().is_none());
            }
        }
    }

    #[test]
    fn a_drive_with_a_flash_of_any_content_moves_only_once_configured(
        seed in prop::collection::vec(any::<u8>(), 64),
        damaged in any::<bool>(),
        place in any::<prop::sample::Index>(),
    ) {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        drive.done(Command::Save);
        let mut bytes = drive.flash.bytes.borrow().clone();
        if damaged {
            // The record with one bit changed.
            bytes[place.index(600)] ^= 1 << (seed[0] % 8);
        } else {
            for (k, byte) in bytes.iter_mut().enumerate() {
                *byte = seed[k % seed.len()].wrapping_mul(k as u8 | 1);
            }
        }
        prop_assert_eq!(bytes.len(), 2 * SECTOR);
        let spoilt = Flash::with(bytes);
        let mut drive = Drive::as_it_comes(bench, &spoilt);
        let status = drive.status();
        if !status.configured {
            drive.refusal(Command::Start);
        }
        drive.pass(20);
        prop_assert_eq!(bench.held.get(), None);
    }
}
