//! The whole drive but for its pins, on a simulated servo.

use core::f64::consts::TAU;

use crate::support::drive::{Drive, SERVO, snapshots};
use crate::support::harms::Harm;
use crate::support::{Bench, COUNTS, Flash, STAGE, first_contact, harms, settings, still};
use drive_link::{
    Command, Estimates, Fault, Kept, Noticed, Record, Refusal, Report, Settings, State,
};
use drive_logic::{Lines, OutputStage, Store};
use identifier_core::parameters::{PerParameter, ServoParameters, Term, Terms, Unknown};
use identifier_core::settings::ParameterRangeSettings;

#[test]
fn a_drive_identifies_its_servo_and_keeps_the_estimates_over_a_loss_of_power() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    assert_eq!(bench.held.get(), None);
    drive.done(Command::Watch(10));
    let shown = snapshots(&drive.order(Command::Start, 20_000));
    assert_eq!(shown.len(), 2000);
    let last = shown.last().expect("shown");
    let found = last.estimates.servo;
    assert!((found.b / SERVO.b - 1.0).abs() < 0.01, "{last:?}");
    assert!((found.a - SERVO.a).abs() < 0.1, "{last:?}");
    assert!((found.load - SERVO.load).abs() < 0.5, "{last:?}");
    assert_eq!(last.sample, 19_991);
    let configure = Command::Configure(settings());
    assert_eq!(drive.refusal(Command::Save), Refusal::Running);
    assert_eq!(drive.refusal(configure), Refusal::Running);
    drive.done(Command::Stop);
    // The servo counts as released only after the interrupt has confirmed it.
    assert_eq!(drive.refusal(Command::Save), Refusal::Running);
    drive.pass(1);
    assert_eq!((drive.state(), bench.held.get()), (State::Disabled, None));
    drive.done(Command::Save);
    let mut drive = drive.rebooted();
    let status = drive.status();
    assert_eq!((status.kept, status.state), (Kept::Record, State::Disabled));
    let kept = drive.supervisor.estimates().expect("kept");
    assert!((kept.servo.b / SERVO.b - 1.0).abs() < 0.01, "{kept:?}");
}

/// Where a servo is on its way to a target, rad.
fn driven(reference_filter: f64, amplitude: f64) -> f64 {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    let mut wanted = settings();
    wanted.dither.amplitude = amplitude;
    let controller = wanted.closed_loop.core.controller.as_mut();
    controller.expect("given").reference_filter = reference_filter;
    drive.run(wanted);
    drive.order(Command::Target(1.0), 133);
    bench.position()
}

#[test]
fn a_dither_acts_behind_the_filter_of_the_reference() {
    let [filtered, direct] = [0.05, 0.0].map(|time| driven(time, 0.3));
    assert_eq!(filtered.to_bits(), direct.to_bits());
    // Without a dither the filter acts.
    let [filtered, direct] = [0.05, 0.0].map(|time| driven(time, 0.0));
    assert!(direct > 1.01 * filtered, "{direct} {filtered}");
}

#[test]
fn an_unknown_servo_is_identified_in_seconds_and_its_load_tracked() {
    let servo = ServoParameters {
        coulomb: 10.0,
        ..SERVO
    };
    let (mut drive, bench) = Drive::on_bench(&servo);
    drive.done(Command::Watch(10));
    let shown = snapshots(&drive.run_for(first_contact(), 10_000));
    let found = shown.last().expect("shown").estimates;
    let own = found.servo;
    assert!((own.b / servo.b - 1.0).abs() < 0.01, "{found:?}");
    assert!((own.coulomb - servo.coulomb).abs() < 0.5, "{found:?}");
    assert!((own.load - servo.load).abs() < 0.5, "{found:?}");
    assert_eq!(found.at_bounds, PerParameter::default());

    bench.change(&ServoParameters {
        load: -30.0,
        ..servo
    });
    let shown = snapshots(&drive.pass(2000));
    let found = shown.last().expect("shown").estimates;
    assert!((found.servo.load + 30.0).abs() < 1.5, "{found:?}");
    drive.order(Command::Stop, 1);
    let status = drive.status();
    let noticed = Noticed {
        started: 1,
        load_steps: 1,
        ..Noticed::default()
    };
    assert_eq!(status.noticed, noticed);
}

/// The estimates of a run of so many samples on a bench.
fn identified(wanted: Settings, bench: &'static Bench, samples: u32) -> Estimates {
    let mut drive = Drive::boot(bench, &Flash::blank());
    drive.run_for(wanted, samples);
    drive.order(Command::Stop, 1);
    drive.supervisor.estimates().expect("learnt")
}

/// First contact with a servo that has friction, with a term.
fn demanding(term: Term) -> (Settings, ServoParameters) {
    let mut wanted = first_contact();
    wanted.closed_loop.core.identifier.terms.demanded = Terms::NONE.with(term);
    let servo = ServoParameters {
        coulomb: 10.0,
        ..SERVO
    };
    (wanted, servo)
}

#[test]
fn a_declared_delay_whose_term_has_not_entered_is_no_estimate() {
    let (mut wanted, servo) = demanding(Term::Delay);
    wanted.closed_loop.core.identifier.terms.delay = 0.002;
    let bench = Bench::new(&servo);
    bench.delay_commands(2);
    let found = identified(wanted, bench, 1000);
    let terms = found.terms.expect("a model with terms");
    let entered: Vec<_> = terms.entered().collect();
    assert!(entered.is_empty(), "{entered:?}");
}

/// Wherever the counter stands at the start: the angle is the counter's.
#[test]
fn gravity_is_estimated_by_the_angle_of_the_counter() {
    /// rad/s².
    const GRAVITY: f64 = 15.0;
    /// Samples to a target, and targets, rad.
    const STAY: usize = 1500;
    const TARGETS: [f64; 4] = [2.5, -2.5, 0.5, -1.5];
    let (wanted, servo) = demanding(Term::Gravity);
    for first in [0, 1234] {
        let bench = Bench::counting_from(first, &servo);
        let mut drive = Drive::boot(bench, &Flash::blank());
        drive.run(wanted);
        for sample in 0..60_000 {
            if sample % STAY == 0 {
                drive.done(Command::Target(TARGETS[sample / STAY % TARGETS.len()]));
            }
            bench.change(&ServoParameters {
                load: servo.load + GRAVITY * bench.position().sin(),
                ..servo
            });
            drive.pass(1);
        }
        drive.order(Command::Stop, 1);
        let found = drive.supervisor.estimates().expect("learnt");
        let terms = found.terms.expect("a model with terms");
        let (sin, cos) = (f64::from(first) * TAU / COUNTS).sin_cos();
        for (unknown, true_size) in [
            (Unknown::GravitySine, GRAVITY * cos),
            (Unknown::GravityCosine, -GRAVITY * sin),
        ] {
            let size = terms.entered().find(|(own, ..)| *own == unknown);
            let size = size.map_or(f64::NAN, |(_, size, _)| f64::from(size));
            assert!(
                (size - true_size).abs() < 0.5,
                "{unknown:?} {size}: {found:?}"
            );
        }
        assert!((found.servo.load - servo.load).abs() < 0.5, "{found:?}");
    }
}

#[test]
fn an_estimate_at_its_bound_is_reported_as_none() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let mut narrow = settings();
    let identifier = &mut narrow.closed_loop.core.identifier;
    identifier.parameter_range = Some(ParameterRangeSettings {
        a: [0.0, 50.0],
        b: [110.0, 200.0],
    });
    identifier.bounds.b = Some([110.0, 200.0]);
    drive.run_for(narrow, 20_000);
    drive.order(Command::Stop, 1);
    let found = drive.supervisor.estimates().expect("learnt");
    assert!(found.at_bounds.b && found.servo.b >= 199.9, "{found:?}");
}

#[test]
fn the_servo_reaches_its_target_and_goes_no_further() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    assert_eq!(drive.refusal(Command::Target(1.0)), Refusal::NotRunning);
    let still = still();
    drive.run_for(still, 10);
    for radians in [51.1, -1e9, f64::NAN, f64::INFINITY] {
        assert_eq!(
            drive.refusal(Command::Target(radians)),
            Refusal::TooFar {
                within: [-51.0, 51.0]
            }
        );
    }
    // 80 000 counts.
    drive.order(Command::Target(-50.0), 20_000);
    assert!((bench.position() + 50.0).abs() < 0.01);
    drive.order(Command::Target(0.0), 20_000);
    assert!(bench.position().abs() < 0.01);
}

#[test]
fn every_harm_has_its_fault_and_releases_the_servo() {
    let harms: [(Fault, Harm); 9] = [
        (Fault::SupplyLow, |drive| {
            // The amplifier is disabled with it.
            drive.lines(|lines| (lines.supply, lines.amplifier) = (false, false));
        }),
        (Fault::AmplifierFault, harms::amplifier_fails),
        (Fault::LimitSwitch, harms::low_switch_opens),
        (Fault::LimitSwitch, harms::high_switch_opens),
        (Fault::EncoderLost, harms::encoder_fails),
        (Fault::ActuatorFailed, harms::stage_fails),
        (Fault::Overrun, harms::samples_are_late),
        (Fault::FollowingError, |drive| {
            // The axis is turned by a revolution by hand.
            drive.bench.plant.borrow_mut().position += 6.3;
        }),
        (Fault::EncoderSilent, |drive| {
            // The encoder is unplugged, and the reference moves away until the command is at its limit.
            drive.bench.connected.set(false);
            drive.done(Command::Target(2.0));
        }),
    ];
    for (fault, harm) in harms {
        let (mut drive, _) = Drive::on_bench(&SERVO);
        assert_eq!(drive.fault_after(harm), Some(fault));
    }
}

#[test]
fn a_missing_and_a_broken_encoder_are_found_at_once() {
    // A dither of 0.3 rad: command and error are far from their limits.
    for broken_line in [false, true] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        bench.connected.set(false);
        drive.done(Command::Start);
        let mut reports = Vec::new();
        for k in 0..400 {
            bench.flicker.set(i32::from(broken_line && k % 2 == 0));
            reports.extend(drive.pass(1));
        }
        assert!(
            reports.contains(&Report::Fault(Fault::EncoderSilent)),
            "{reports:?}"
        );
    }
}

#[test]
fn a_servo_at_rest_against_a_load_is_no_fault() {
    let servo = ServoParameters {
        load: 2000.0,
        ..SERVO
    };
    let (mut drive, bench) = Drive::on_bench(&servo);
    let still = still();
    drive.run_for(still, 30_000);
    assert_eq!(drive.state(), State::Running);
    assert!(bench.held.get().is_some_and(|command| command < -7.0));
}

#[test]
fn a_doubled_stop_does_not_end_the_run_after_it() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.order(Command::Start, 10);
    drive.done(Command::Stop);
    drive.order(Command::Stop, 1);
    drive.order(Command::Start, 10);
    assert_eq!(drive.state(), State::Running);
    assert!(bench.held.get().is_some());
    assert_eq!(drive.refusal(Command::Save), Refusal::Running);
}

#[test]
fn a_faulted_drive_accepts_settings_that_remove_the_fault() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let fault = drive.fault_after(|drive| drive.bench.plant.borrow_mut().position += 6.3);
    assert_eq!(fault, Some(Fault::FollowingError));
    let mut wider = settings();
    wider.protection.following_error = 10.0;
    drive.done(Command::Configure(wider));
    drive.order(Command::Clear, 1);
    drive.done(Command::Start);
}

#[test]
fn a_stuck_switch_is_found_before_motion_and_after_it_until_it_is_repaired() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.lines(|lines| lines.high_switch = false);
    let stuck = [Report::Fault(Fault::LimitSwitchesStuck)];
    assert_eq!(drive.order(Command::Start, 5), stuck);
    assert_eq!(bench.held.get(), None);
    assert_eq!(drive.order(Command::Clear, 5), stuck);
    bench.lines.set(Lines::HEALTHY);
    drive.order(Command::Clear, 5);
    assert_eq!(drive.state(), State::Disabled);
    drive.order(Command::Start, 5);
    assert!(bench.held.get().is_some());
}

#[test]
fn a_fault_found_at_boot_is_known_at_once_and_only_one_of_the_past_can_be_cleared() {
    for (fault, is_past) in [
        (Fault::ResetByWatchdog, true),
        (Fault::SelfTestFailed, false),
        (Fault::ClockNotStable, false),
    ] {
        let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
        let mut drive = Drive::booted_with(bench, &flash, Err(fault));
        assert_eq!(drive.status().state, State::Faulted(fault));
        assert_eq!(drive.refusal(Command::Start), Refusal::Faulted(fault));
        assert_eq!(drive.pass(3), [Report::Fault(fault)]);
        assert_eq!(drive.refusal(Command::Start), Refusal::Faulted(fault));
        let again = drive.order(Command::Clear, 2);
        assert_eq!(again.contains(&Report::Fault(fault)), !is_past, "{again:?}");
        let answer = drive.ask(Command::Start);
        assert_eq!(matches!(answer, Report::Done { .. }), is_past, "{answer:?}");
    }
}

#[test]
fn a_fault_in_the_queue_wins_over_a_start() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.done(Command::Start);
    drive.lines(|lines| lines.amplifier = false);
    drive.sample();
    bench.lines.set(Lines::HEALTHY);
    // The supervisor has not read the event yet, and its next order must not move the servo.
    drive.order(Command::Stop, 5);
    assert_eq!(drive.state(), State::Faulted(Fault::AmplifierFault));
    assert_eq!(bench.held.get(), None);
}

#[test]
fn reporting_never_blocks_and_no_fault_is_lost() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.done(Command::Watch(1));
    drive.done(Command::Start);
    // The queue fills unread, and then a fault occurs.
    for _ in 0..100 {
        drive.sample();
    }
    drive.lines(|lines| lines.amplifier = false);
    drive.sample();
    assert_eq!(bench.held.get(), None);
    bench.lines.set(Lines::HEALTHY);
    let reports = drive.pass(3);
    assert!(reports.contains(&Report::Fault(Fault::AmplifierFault)));
    drive.done(Command::Clear);
    drive.order(Command::Watch(1), 3);
    drive.order(Command::Start, 3);
    let status = drive.status();
    assert!(status.dropped > 80, "{status:?}");
}

#[test]
fn a_store_that_fails_leaves_the_drive_as_it_was() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    drive.flash.steps_left.set(3);
    assert_eq!(drive.refusal(Command::Save), Refusal::NotKept);
    drive.flash.steps_left.set(usize::MAX);
    drive.done(Command::Save);
}

#[test]
fn a_record_that_this_stage_refuses_is_not_used() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.order(Command::Start, 5000);
    drive.order(Command::Stop, 1);
    drive.done(Command::Save);
    // Its limit of the command is beyond what this stage gives.
    let weak = OutputStage {
        full_scale: 5.0,
        ..STAGE
    };
    let mut drive = Drive::new(bench, &drive.flash, Ok(()), weak);
    let status = drive.status();
    assert_eq!(
        (status.kept, status.configured),
        (Kept::OtherVersion, false)
    );
    assert_eq!((status.estimates, status.gains), (None, None));
    assert_eq!(drive.refusal(Command::Start), Refusal::NotConfigured);
    drive.pass(10);
    assert_eq!(bench.held.get(), None);
}

#[test]
fn a_count_that_wraps_in_the_middle_of_a_run_is_not_noticed() {
    let run = |first: i32| {
        let bench = Bench::counting_from(first, &SERVO);
        let mut drive = Drive::boot(bench, &Flash::blank());
        drive.done(Command::Watch(1));
        let mut reports = drive.order(Command::Start, 2000);
        // Over the wrap, and back.
        for radians in [6.0, -6.0] {
            drive.done(Command::Target(radians));
            reports.extend(drive.pass(4000));
        }
        drive.done(Command::Stop);
        reports.extend(drive.pass(1));
        reports
    };
    let before = run(0);
    let shown = snapshots(&before);
    assert!(shown.iter().any(|shown| shown.position > 5.9));
    assert!(shown.iter().any(|shown| shown.position < -5.9));
    for first in [i32::MAX - 5000, i32::MAX, i32::MIN, i32::MIN + 5000] {
        assert!(run(first) == before, "counting from {first}");
    }
}

proptest::proptest! {
    #[test]
    fn no_order_of_commands_and_harms_moves_a_faulted_drive(
        steps in proptest::collection::vec(0_u8..12, 1..60),
    ) {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        for step in steps {
            match step {
                0 | 1 => { drive.ask(Command::Start); }
                2 => { drive.ask(Command::Stop); }
                3 => { drive.ask(Command::Clear); }
                4 => { drive.ask(Command::Save); }
                5 => { drive.ask(Command::Configure(settings())); }
                6 => { drive.ask(Command::Target(1.0)); }
                7 => drive.lines(|lines| lines.amplifier = !lines.amplifier),
                8 => drive.lines(|lines| lines.low_switch = !lines.low_switch),
                9 => bench.late.set(!bench.late.get()),
                10 => { drive.ask(Command::Watch(2)); }
                _ => { drive.pass(20); }
            }
            drive.pass(2);
            if drive.state() != State::Running {
                proptest::prop_assert_eq!(bench.held.get(), None);
            }
            if !bench.lines.get().amplifier {
                proptest::prop_assert_eq!(bench.held.get(), None);
            }
        }
    }
}

#[test]
fn a_record_of_another_board_or_of_a_simulated_servo_is_left_alone_and_both_builds_are_said() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.done(Command::Save);
    let simulated = OutputStage {
        is_simulated: true,
        ..STAGE
    };
    let other_board = OutputStage {
        board: "bench2",
        ..STAGE
    };
    for other in [simulated, other_board] {
        let flash = drive.flash.powered_again();
        let mut unused = Drive::new(bench, &flash, Ok(()), other);
        let status = unused.status();
        let Kept::OtherBuild { stored, own } = status.kept else {
            panic!("{:?}", status.kept);
        };
        let shown = status.kept.to_string();
        let names = |build: u32| shown.contains(&format!("{build:08x}"));
        assert!(names(stored) && names(own));
        assert!(stored != own && !status.configured);
        assert_eq!(status.simulated, other.is_simulated);
        assert_eq!(unused.refusal(Command::Start), Refusal::NotConfigured);
        // That of the first build is still there, until it is replaced.
        let mut drive = Drive::boot(bench, &flash);
        assert_eq!(drive.status().kept, Kept::Record);
        let mut drive = Drive::new(bench, &flash, Ok(()), other);
        drive.done(Command::Configure(settings()));
        drive.done(Command::Save);
        let mut drive = Drive::new(bench, &flash, Ok(()), other);
        assert_eq!(drive.status().kept, Kept::Record);
    }
}

#[test]
fn of_a_record_of_the_version_before_all_is_taken_but_the_load_that_a_run_has_learnt() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.order(Command::Start, 20_000);
    drive.order(Command::Stop, 1);
    drive.done(Command::Save);
    let learnt = drive.status().estimates.expect("learnt");
    assert!(learnt.servo.load > 1.0, "{}", learnt.servo.load);
    let (mut contents, flash) = (Vec::new(), Flash::blank());
    Store::open(drive.flash.powered_again(), 0, 0, |_, bytes| {
        contents = bytes.to_vec();
        true
    });
    // It begins with the fingerprint of its build.
    let mut build = Record::WITH_UNPROVEN_LOADS.to_le_bytes().to_vec();
    build.push(STAGE.is_simulated.into());
    build.extend(STAGE.board.as_bytes());
    let fingerprint = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&build);
    contents[..4].copy_from_slice(&fingerprint.to_le_bytes());
    let version = Record::WITH_UNPROVEN_LOADS;
    let (mut store, _) = Store::open(flash.clone(), 0, version, |_, _| false);
    let write = |room: &mut [u8]| {
        room[..contents.len()].copy_from_slice(&contents);
        Some(contents.len())
    };
    store.keep(true, write).expect("power is there");
    let mut again = Drive::as_it_comes(bench, &flash);
    let status = again.status();
    assert_eq!((status.kept, status.configured), (Kept::WithoutLoads, true));
    assert_eq!(again.shown(), drive.shown());
    let mut without = learnt;
    without.servo.load = 0.0;
    assert_eq!(status.estimates, Some(without));
    again.pass(30);
    again.done(Command::Save);
    assert_eq!(again.rebooted().status().kept, Kept::Record);
}
