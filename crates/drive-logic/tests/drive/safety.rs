//! Protection of a machine with a spindle, beside the faults: conditions for a start, ends of a
//! run, and limits of the reference.

use crate::support::commission::ORDER;
use crate::support::drive::{Drive, SERVO, snapshots};
use crate::support::{Bench, Flash, SAMPLE_TIME, first_contact, settings, still};
use drive_link::{
    Command, Ended, Fault, InterruptCycles, Refusal, Report, Request, Settings, State,
};
use drive_logic::Lines;
use identifier_core::parameters::ServoParameters;

/// A drive that has run with these settings for some samples.
fn running(servo: &ServoParameters, settings: Settings, samples: u32) -> (Drive, &'static Bench) {
    let (mut drive, bench) = Drive::on_bench(servo);
    drive.run_for(settings, samples);
    (drive, bench)
}

/// Samples until the stage is disabled; `None` if more than `most`.
fn samples_until_disabled(drive: &mut Drive, most: u32) -> Option<u32> {
    (1..=most).find(|_| {
        drive.pass(1);
        drive.bench.held.get().is_none()
    })
}

#[test]
fn nothing_moves_before_the_servo_is_configured() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    let mut drive = Drive::as_it_comes(bench, &flash);
    assert!(!drive.status().configured);
    assert_eq!(drive.refusal(Command::Start), Refusal::NotConfigured);
    drive.pass(100);
    assert_eq!(bench.held.get(), None);
    drive.done(Command::Configure(settings()));
    assert!(drive.status().configured);
    drive.done(Command::Save);
    // The saved settings are in force after a reboot.
    let mut drive = Drive::as_it_comes(bench, &flash);
    assert!(drive.status().configured);
    drive.order(Command::Start, 10);
    assert!(bench.held.get().is_some());
}

#[test]
fn a_stop_needs_no_room_and_overtakes_what_was_ordered_before_it() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.done(Command::Start);
    // The queue of orders is full now.
    drive.done(Command::Watch(1));
    drive.done(Command::Target(1.0));
    assert_eq!(drive.refusal(Command::Watch(1)), Refusal::Busy);
    drive.done(Command::Stop);
    for _ in 0..20 {
        drive.pass(1);
        assert_eq!(
            bench.held.get(),
            None,
            "a start that a stop overtook moves nothing"
        );
    }
    assert_eq!(drive.state(), State::Disabled);

    // A running one, with a full queue of reports that are not read.
    drive.order(Command::Start, 50);
    assert!(bench.held.get().is_some());
    for _ in 0..100 {
        drive.sample();
    }
    while let Report::Done { .. } = drive.ask(Command::Target(0.5)) {}
    drive.done(Command::Stop);
    drive.sample();
    assert_eq!(bench.held.get(), None);
    drive.pass(3);
    assert_eq!(drive.state(), State::Disabled);
    assert_eq!(drive.status().ended, Some(Ended::Stopped));
}

#[test]
fn a_silent_host_ends_the_run_at_rest_within_the_stated_time() {
    for moving in [false, true] {
        let mut wanted = still();
        wanted.protection.link_timeout = 0.3;
        wanted.protection.stop_time = 0.2;
        let (mut drive, bench) = running(&SERVO, wanted, 0);
        if moving {
            drive.done(Command::Target(40.0));
        }
        for _ in 0..20 {
            drive.pass(290);
            let answer = drive.ask(Command::KeepAlive);
            assert!(matches!(answer, Report::Status { .. }), "{answer:?}");
        }
        assert_eq!(drive.state(), State::Running);
        let speed_before = bench.plant.borrow().velocity.abs();
        assert_eq!(speed_before > 4.0, moving);
        // 0.3 s and 0.2 s, and the sample in which each of them is over.
        let samples = samples_until_disabled(&mut drive, 503).expect("in time");
        assert!(samples >= 300, "{samples}");
        assert!(bench.plant.borrow().velocity.abs() < 0.1, "at rest");
        drive.pass(3);
        assert_eq!(drive.state(), State::Faulted(Fault::LinkLost));
        assert_eq!(drive.status().ended, Some(Ended::Faulted(Fault::LinkLost)));
    }
}

#[test]
fn only_a_host_that_drives_and_is_obeyed_keeps_a_run_alive() {
    for (command, keeps_alive) in [
        (Command::Hello, false),
        (Command::Show, false),
        (Command::Watch(0), false),
        (Command::Outcome, false),
        (Command::MotionRecord(0), false),
        (Command::BoardTest, false),
        (Command::Clear, false),
        (Command::Save, false),
        (Command::Configure(still()), false),
        (Command::KeepAlive, true),
        (Command::Target(0.1), true),
        (Command::Start, true),
        // Refused.
        (Command::Target(f64::NAN), false),
        (Command::Home, false),
    ] {
        let mut wanted = still();
        wanted.protection.link_timeout = 0.3;
        let (mut drive, _) = running(&SERVO, wanted, 0);
        for _ in 0..20 {
            drive.pass(100);
            drive.ask(command);
        }
        let is_alive = drive.state() == State::Running;
        assert_eq!(is_alive, keeps_alive, "{command:?}");
    }
}

#[test]
fn a_start_that_finds_no_room_can_be_ordered_again() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    for _ in 0..3 {
        drive.done(Command::Watch(0));
    }
    assert_eq!(drive.refusal(Command::Start), Refusal::Busy);
    drive.pass(10);
    drive.order(Command::Start, 10);
    assert_eq!(drive.state(), State::Running);
}

#[test]
fn what_asks_for_a_servo_at_rest_is_refused_until_a_stop_is_obeyed() {
    let (mut drive, _) = running(&SERVO, still(), 10);
    drive.done(Command::Stop);
    for command in [Command::Save, Command::Configure(still()), Command::Start] {
        assert_eq!(drive.refusal(command), Refusal::Running);
    }
    drive.pass(2);
    drive.done(Command::Configure(still()));
    // A stop of a servo that is disabled already counts as well.
    drive.done(Command::Stop);
    assert_eq!(drive.refusal(Command::Save), Refusal::Running);
    drive.pass(2);
    drive.done(Command::Save);
}

#[test]
fn a_servo_on_its_way_to_rest_takes_no_target() {
    let mut wanted = still();
    wanted.protection.duration = 1.0;
    wanted.protection.stop_time = 0.4;
    let (mut drive, bench) = running(&SERVO, wanted, 1001);
    for _ in 0..10 {
        // With any answer.
        drive.ask(Command::Target(40.0));
        drive.pass(1);
    }
    let samples = samples_until_disabled(&mut drive, 400).expect("it comes to rest");
    assert!(samples < 100, "{samples}");
    assert!(bench.position().abs() < 0.1);
}

#[test]
fn the_speed_is_watched_in_every_sample() {
    for (speed, fault) in [(9.0, None), (11.0, Some(Fault::SpeedExceeded))] {
        let mut wanted = still();
        wanted.protection.speed = 10.0;
        let (mut drive, bench) = running(&SERVO, wanted, 10);
        let mut at = 0.0;
        for _ in 0..60 {
            at += speed * SAMPLE_TIME;
            bench.hold_at(at);
            drive.pass(1);
        }
        let expected = fault.map_or(State::Running, State::Faulted);
        assert_eq!(drive.state(), expected, "{speed} rad/s");
    }
}

#[test]
fn an_axis_held_by_hand_is_no_silent_encoder_until_its_error_is_too_large() {
    // The first power-on of the manual: the amplifier has no supply, a hand turns the axis.
    let mut wanted = still();
    wanted.protection.following_error = 0.2;
    wanted.protection.travel = [-0.5, 0.5];
    let (mut drive, bench) = running(&SERVO, wanted, 0);
    let hand = |drive: &mut Drive, to: f64, samples: u32| {
        for _ in 0..samples {
            bench.hold_at(to);
            drive.pass(1);
        }
    };
    for k in 1..=19 {
        hand(&mut drive, 0.01 * f64::from(k), 100);
        assert_eq!(drive.state(), State::Running, "{k}");
    }
    hand(&mut drive, 0.21, 2);
    assert_eq!(drive.state(), State::Faulted(Fault::FollowingError));
}

#[test]
fn an_axis_that_friction_holds_is_no_silent_encoder() {
    for dither in [0.0, 0.05] {
        let servo = ServoParameters {
            coulomb: 60.0,
            load: 0.0,
            ..SERVO
        };
        let mut wanted = settings();
        wanted.dither.amplitude = dither;
        wanted.protection.following_error = 0.2;
        wanted.protection.travel = [-1.0, 1.0];
        let (drive, bench) = running(&servo, wanted, 20_000);
        assert_eq!(drive.state(), State::Running, "{dither} rad");
        assert!(bench.held.get().is_some());
    }
}

#[test]
fn the_largest_dither_that_is_allowed_does_not_fault() {
    let mut wanted = settings();
    wanted.dither.amplitude = 0.1;
    wanted.protection.following_error = 0.3;
    wanted.protection.travel = [-0.2, 0.2];
    let (drive, bench) = running(&SERVO, wanted, 60_000);
    assert_eq!(drive.state(), State::Running);
    assert!(bench.held.get().is_some());
}

#[test]
fn what_a_run_has_learnt_is_kept_and_the_next_run_starts_from_it_unless_it_ended_by_a_fault() {
    for loses_power in [false, true] {
        let (mut drive, bench) = running(&SERVO, settings(), 20_000);
        drive.order(Command::Stop, 2);
        let learnt = drive.supervisor.estimates().expect("learnt");
        let b = learnt.servo.b;
        assert!((b / SERVO.b - 1.0).abs() < 0.01, "{b}");
        // What it learns before the fault may be of a jam.
        drive.order(Command::Start, 20);
        bench.plant.borrow_mut().position += 6.3;
        drive.pass(2);
        assert_eq!(drive.state(), State::Faulted(Fault::FollowingError));
        assert_eq!(drive.supervisor.estimates(), Some(learnt));
        drive.done(Command::Save);
        if loses_power {
            drive = drive.rebooted();
        } else {
            drive.order(Command::Clear, 1);
        }
        drive.done(Command::Watch(1));
        let shown = snapshots(&drive.order(Command::Start, 2));
        let first = shown.first().expect("shown").estimates.servo.b;
        assert!((first / b - 1.0).abs() < 1e-3, "{first} {b}");
        drive.order(Command::Stop, 2);

        // The same settings keep the learnt estimates, those of another servo discard them.
        drive.done(Command::Configure(settings()));
        assert!(drive.supervisor.estimates().is_some());
        let mut other = settings();
        other.closed_loop.core.identifier.initial.b = Some(200.0);
        drive.done(Command::Configure(other));
        assert_eq!(drive.supervisor.estimates(), None);
    }
}

#[test]
fn a_limit_switch_that_bounces_for_a_sample_is_no_fault_and_one_that_opens_is() {
    for (open, fault) in [(1, None), (2, Some(Fault::LimitSwitch))] {
        let (mut drive, bench) = running(&SERVO, settings(), 100);
        for _ in 0..5 {
            drive.lines(|lines| lines.low_switch = false);
            drive.pass(open);
            bench.lines.set(Lines::HEALTHY);
            drive.pass(1);
        }
        let expected = fault.map_or(State::Running, State::Faulted);
        assert_eq!(drive.state(), expected);
    }
}

#[test]
fn a_background_that_hangs_is_left_to_the_watchdog() {
    let (mut drive, _) = running(&SERVO, settings(), 100);
    // Driven, for a tenth of a second at most; released, for five.
    let driven = drive.fed_while_hanging(1000);
    assert!((49..=100).contains(&driven), "{driven}");
    drive.order(Command::Stop, 3000);
    let disabled = drive.fed_while_hanging(20_000);
    assert!((2499..=5000).contains(&disabled), "{disabled}");
    // A time, not a number of samples: at twenty times the rate it is twenty times as many.
    let mut fast = settings();
    fast.dither.amplitude = 0.0;
    fast.closed_loop.core.sample_time = 5e-5;
    drive.order(Command::Configure(fast), 60_000);
    let disabled = drive.fed_while_hanging(400_000);
    assert!((49_999..=100_000).contains(&disabled), "{disabled}");
    // As soon as the background runs again, the watchdog is fed again.
    drive.pass(1);
    assert_eq!(drive.fed_while_hanging(100), 100);
}

#[test]
fn late_samples_in_a_row_or_every_other_one_are_a_fault_and_each_is_reported() {
    let (mut drive, bench) = running(&SERVO, settings(), 100);
    let late = |drive: &mut Drive, samples: u32| {
        bench.late.set(true);
        drive.pass(samples);
        bench.late.set(false);
    };
    for _ in 0..5 {
        late(&mut drive, 2);
        drive.pass(8);
    }
    assert_eq!(drive.state(), State::Running);
    assert_eq!(drive.status().overruns, 10, "although nobody watches");
    late(&mut drive, 3);
    assert_eq!(drive.state(), State::Faulted(Fault::Overrun));
    assert_eq!(drive.status().overruns, 13);
    // The next run counts from zero.
    drive.order(Command::Clear, 1);
    drive.order(Command::Start, 10);
    late(&mut drive, 1);
    drive.order(Command::Stop, 1);
    assert_eq!(drive.status().overruns, 1);
    // Seven, of which every other one is late.
    drive.order(Command::Start, 10);
    for _ in 0..3 {
        late(&mut drive, 1);
        drive.pass(1);
    }
    assert_eq!(drive.state(), State::Running);
    late(&mut drive, 1);
    assert_eq!(drive.state(), State::Faulted(Fault::Overrun));
    assert_eq!(drive.status().overruns, 4);
}

#[test]
fn the_status_has_the_cycles_of_the_last_interrupt_and_of_the_longest_since_the_start() {
    let (mut drive, bench) = running(&SERVO, settings(), 0);
    assert_eq!(drive.status().interrupt_cycles, None, "no counter runs");
    // It wraps.
    for taken in [300, 500, 400] {
        bench.cycles.set([u32::MAX - 100, taken]);
        drive.pass(1);
    }
    let cycles = |last, longest| Some(InterruptCycles { last, longest });
    assert_eq!(drive.status().interrupt_cycles, cycles(400, 500));
    drive.order(Command::Stop, 1);
    drive.order(Command::Start, 10);
    assert_eq!(drive.status().interrupt_cycles, cycles(400, 400));
}

#[test]
fn as_many_late_samples_as_are_configured_are_a_fault() {
    for overruns in [1, 2, 5] {
        let mut wanted = still();
        wanted.protection.overruns = overruns;
        let (mut drive, bench) = running(&SERVO, wanted, 10);
        bench.late.set(true);
        drive.pass(u32::from(overruns) - 1);
        assert_eq!(drive.state(), State::Running);
        drive.pass(1);
        assert_eq!(drive.state(), State::Faulted(Fault::Overrun));
    }
}

#[test]
fn the_smaller_limit_of_the_command_is_the_one_that_a_stall_is_judged_by() {
    // A command of 2.9 is more than 0.3 of the smaller limit, whichever way that is.
    for (limit, fault) in [
        ([-10.0, 9.0], None),
        ([-4.0, 10.0], Some(Fault::EncoderSilent)),
        ([-10.0, 4.0], Some(Fault::EncoderSilent)),
    ] {
        let servo = ServoParameters {
            coulomb: 900.0,
            load: 0.0,
            ..SERVO
        };
        let mut wanted = first_contact();
        wanted.dither.amplitude = 0.0;
        wanted.protection.breakaway = 0.3;
        wanted.protection.following_error = 2.0;
        let controller = wanted.closed_loop.core.controller.as_mut();
        let controller = controller.expect("there is one");
        (controller.limit, controller.ki) = (limit, 0.0);
        let (mut drive, _) = running(&servo, wanted, 10);
        for sign in [1.0, -1.0] {
            if drive.state() == State::Running {
                drive.order(Command::Target(sign * 0.25), 1000);
            }
        }
        let wanted = fault.map_or(State::Running, State::Faulted);
        assert_eq!(drive.state(), wanted, "{limit:?}");
    }
}

#[test]
fn a_command_that_the_stage_does_not_take_is_released_in_the_same_sample() {
    let (mut drive, bench) = running(&SERVO, still(), 10);
    bench.stage_works.set(false);
    drive.sample();
    assert_eq!(bench.held.get(), None);
}

#[test]
fn the_estimator_that_needs_no_guess_starts_from_kept_estimates() {
    let (mut drive, bench) = running(&SERVO, first_contact(), 5000);
    for _ in 0..2 {
        drive.order(Command::Stop, 2);
        let learnt = drive.supervisor.estimates().expect("learnt");
        assert!((learnt.servo.b / SERVO.b - 1.0).abs() < 0.01, "{learnt:?}");
        drive.order(Command::Start, 5000);
    }
    assert!(bench.held.get().is_some());
}

#[test]
fn an_output_that_cannot_be_disabled_is_a_fault_in_every_state() {
    let failed = State::Faulted(Fault::ActuatorFailed);
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    // At rest, before and after a clear.
    bench.releases.set(false);
    drive.pass(2);
    assert_eq!(drive.state(), failed);
    drive.order(Command::Clear, 5);
    assert_eq!(drive.state(), failed);
    bench.releases.set(true);
    drive.order(Command::Clear, 5);
    assert_eq!(drive.state(), State::Disabled);
    // At the end of a run whose time is over, if only in that sample.
    let mut short = settings();
    short.protection.duration = 0.05;
    drive.run_for(short, 20);
    bench.releases.set(false);
    while bench.held.get().is_some() {
        drive.sample();
    }
    bench.releases.set(true);
    drive.pass(5);
    assert_eq!(drive.state(), failed);
}

#[test]
fn a_travel_has_two_ends_and_ends_a_run_at_each_of_them() {
    for (place, is_within) in [
        (-0.049, true),
        (-0.052, false),
        (1.499, true),
        (1.502, false),
    ] {
        let mut wanted = still();
        wanted.protection.travel = [-0.05, 1.5];
        wanted.protection.following_error = 1.55;
        wanted.protection.speed = 1e4;
        let (mut drive, bench) = running(&SERVO, wanted, 10);
        for far in [-0.06, 1.6, f64::NAN] {
            let within = [-0.05, 1.5];
            assert_eq!(
                drive.refusal(Command::Target(far)),
                Refusal::TooFar { within }
            );
        }
        bench.hold_at(place);
        drive.pass(2);
        let left = State::Faulted(Fault::TravelLeft);
        let state = if is_within { State::Running } else { left };
        assert_eq!(drive.state(), state, "{place}");
    }
}

#[test]
fn an_axis_that_moves_is_not_driven_and_its_speed_is_said() {
    const FREE: ServoParameters = ServoParameters {
        a: 0.0,
        b: 257.7,
        coulomb: 0.0,
        load: 0.0,
    };
    for speed in [90.0, -90.0, 75.0, 5.0, 0.0] {
        for after in [2, 10, 17, 40, 500] {
            let (mut drive, bench) = Drive::on_bench(&FREE);
            drive.pass(100);
            bench.plant.borrow_mut().velocity = speed;
            drive.pass(after);
            let begin = [Command::Start, Command::Commission(ORDER)][after as usize % 2];
            let refusal = match drive.ask(begin) {
                Report::Refused { refusal, .. } => refusal,
                // What is slow shows in a long window only.
                _ => {
                    assert!(speed.abs() < 80.0 || after < 40, "{speed} {after}");
                    continue;
                }
            };
            let Refusal::Moves { speed: shown, most } = refusal else {
                panic!("{refusal:?}");
            };
            assert!((most - 80.0).abs() < 1e-9, "four fifths of the largest");
            assert!(
                shown > most && (shown / speed.abs() - 1.0).abs() < 0.1,
                "{speed}: {shown}"
            );
            drive.pass(10);
            assert_eq!(bench.held.get(), None);
        }
    }
    // Stopped in motion, it is known to move at once.
    let (mut drive, bench) = Drive::on_bench(&FREE);
    drive.run_for(still(), 10);
    bench.plant.borrow_mut().velocity = 90.0;
    drive.pass(2);
    drive.order(Command::Stop, 1);
    bench.plant.borrow_mut().velocity = 90.0;
    drive.pass(1);
    assert!(matches!(
        drive.refusal(Command::Start),
        Refusal::Moves { .. }
    ));
}

#[test]
fn an_axis_that_moves_faster_than_it_may_is_not_driven_with_a_coarse_encoder_either() {
    const FREE: ServoParameters = ServoParameters {
        a: 0.0,
        b: 257.7,
        coulomb: 0.0,
        load: 0.0,
    };
    const LIMIT: f64 = 20.0;
    for counts in [12.0, 48.0, 400.0, 10_000.0] {
        for (part, may_start) in [(0.0, true), (0.5, true), (1.3, false), (-1.3, false)] {
            let bench = Bench::counting(0, counts, &FREE);
            let mut drive = Drive::boot(bench, &Flash::blank());
            let mut wanted = still();
            wanted.closed_loop.core.resolution = core::f64::consts::TAU / counts;
            (wanted.protection.speed, wanted.protection.pace) = (LIMIT, 1.0);
            drive.done(Command::Configure(wanted));
            bench.plant.borrow_mut().velocity = part * LIMIT;
            drive.pass(1000);
            for _ in 0..10 {
                let answer = drive.ask(Command::Start);
                let has_begun = matches!(answer, Report::Done { .. });
                assert_eq!(has_begun, may_start, "{counts} {part}: {answer:?}");
                if has_begun {
                    break;
                }
                drive.pass(37);
            }
        }
    }
}

#[test]
fn an_order_acts_once_and_never_late() {
    let (mut drive, bench) = Drive::on_bench(&crate::support::commission::SERVO);
    let answer = |drive: &mut Drive, order: u32, command: Command| {
        let id = order as u8;
        let answer = drive.supervisor.answer(&Request { id, order, command });
        drive.pass(5);
        match answer {
            Report::Refused { refusal, .. } => Err(refusal),
            _ => Ok(()),
        }
    };
    let late = Err(Refusal::GivenBefore);
    let commission = Command::Commission(ORDER);
    // Beyond the largest number, too.
    let mut order = u32::MAX - 20;
    assert_eq!(answer(&mut drive, 0, Command::Start), late);
    for before in [1 << 30, 1 << 31, 3 << 30, order] {
        let refused = answer(&mut drive, before, Command::Target(0.1));
        assert_eq!(refused, Err(Refusal::NotRunning));
    }
    drive.done(Command::Configure(still()));
    let mut next = |drive: &mut Drive, command| {
        order = order.wrapping_add(3);
        assert_eq!(answer(drive, order, command), Ok(()));
        assert_eq!(drive.status().order, order);
        order
    };
    for begin in [Command::Start, commission, Command::Start, commission] {
        let begun = next(&mut drive, begin);
        // It comes again while it is under way.
        assert_eq!(answer(&mut drive, begun, begin), Ok(()));
        let mut given = vec![(begun, begin)];
        if begin == Command::Start {
            for target in [0.2, 0.0] {
                given.push((
                    next(&mut drive, Command::Target(target)),
                    Command::Target(target),
                ));
                drive.pass(300);
            }
            // The first target again, and a frame of before the run.
            assert_eq!(answer(&mut drive, given[1].0, given[1].1), late);
            assert_eq!(answer(&mut drive, begun.wrapping_sub(2), given[1].1), late);
            drive.pass(300);
            assert!(bench.position().abs() < 0.05, "{}", bench.position());
        }
        drive.done(Command::Stop);
        drive.pass(1000);
        assert_eq!(drive.state(), State::Disabled);
        // In the run after it each comes again, and long after.
        let now = next(&mut drive, Command::Start);
        for round in 0..2 {
            for &(old, command) in &given {
                assert_eq!(
                    answer(&mut drive, old, command),
                    late,
                    "{round} {command:?}"
                );
            }
            (0..300).for_each(|_| _ = drive.status());
        }
        assert_eq!(answer(&mut drive, now, Command::Start), Ok(()));
        // Another host gives one of the same number.
        let others = Request {
            id: (now as u8).wrapping_add(1),
            order: now,
            command: Command::Target(0.2),
        };
        let refused = drive.supervisor.answer(&others);
        assert!(
            matches!(refused, Report::Refused { id, refusal: Refusal::GivenBefore } if id == others.id),
            "{refused:?}"
        );
        drive.done(Command::Stop);
        drive.pass(1000);
        assert_eq!(
            answer(&mut drive, now, Command::Start),
            Ok(()),
            "it was done"
        );
        drive.pass(5);
        assert_eq!(drive.state(), State::Disabled);
    }
}
