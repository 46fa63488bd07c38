//! A commissioning beside a running loop: the loop's gains hold the servo before, and afterwards unless it
//! has found new ones.

use crate::support::commission::{
    HARMS, ORDER, PHASES, SERVO, commission, commission_until, cut_anywhere, cut_short, ended,
    outcome, over, until,
};
use crate::support::drive::{Drive, snapshots};
use crate::support::harms::Harm;
use crate::support::{Bench, Flash, first_contact, harms, still};
use commissioning::Phase;
use drive_link::{Command, Commissioning, Ended, Fault, Origin, Report, Settings, State};
use identifier_core::parameters::ServoParameters;
use identifier_core::reason::Reason;

/// A servo whose load friction does not hold.
const LOADED: ServoParameters = ServoParameters {
    load: 100.0,
    ..SERVO
};

/// Command that a count of the encoder is, at most: k_p and the derivative's share of it.
const A_COUNT: f32 = 0.06;

fn gauss_newton() -> Settings {
    let mut quiet = first_contact();
    quiet.dither.amplitude = 0.0;
    quiet
}

/// Starts a loop that holds the load, away from its start.
fn run(drive: &mut Drive, settings: Settings) {
    drive.run_for(settings, 10);
    drive.order(Command::Target(-1.0), 6000);
    assert_eq!(drive.state(), State::Running);
}

fn held(drive: &Drive) -> f32 {
    drive.bench.held.get().expect("the servo is held")
}

/// The drive as a run of these settings, which obeys.
fn assert_continues(drive: &mut Drive, settings: &Settings) {
    assert_eq!(drive.state(), State::Running);
    assert_eq!(drive.shown(), *settings);
    drive.pass(4000);
    drive.order(Command::Target(0.5), 4000);
    assert_eq!(drive.state(), State::Running);
    // Targets are counted from where the loop was started.
    let at = drive.position();
    assert!((at - 0.5).abs() < 0.1, "{at}");
}

#[test]
fn the_command_has_no_bump_when_the_commissioning_takes_over() {
    for target in [None, Some(3.0)] {
        let (mut drive, bench) = Drive::on_bench(&LOADED);
        run(&mut drive, still());
        if let Some(target) = target {
            drive.order(Command::Target(target), 200);
            assert!(bench.plant.borrow().velocity > 4.0, "it is on its way");
        }
        let before = held(&drive);
        drive.done(Command::Commission(ORDER));
        drive.sample();
        let after = held(&drive);
        // The reference begins to go back to where the servo is.
        let most = if target.is_some() { 0.2 } else { A_COUNT };
        assert!((after - before).abs() < most, "{before} {after}");
        drive.pass(1);
        assert_eq!(drive.state(), State::Commissioning);
        until(&mut drive, Phase::Probe);
    }
}

#[test]
fn proved_gains_are_in_force_at_once_and_kept_when_the_servo_is_released() {
    for settings in [still(), gauss_newton()] {
        let (mut drive, bench) = Drive::on_bench(&LOADED);
        run(&mut drive, settings);
        drive.done(Command::Watch(1));
        drive.done(Command::Commission(ORDER));
        let begun_at = drive.position();
        until(&mut drive, Phase::Trial);
        let reports = over(&mut drive);
        assert_eq!(drive.state(), State::Running);
        let found = outcome(&mut drive);
        assert_eq!(found.commissioning.phase, Phase::Applied, "{found:?}");
        assert!(!found.kept, "writing would stop the processor");
        assert_eq!(drive.flash.steps.get(), 0);
        let tuning = found.tuning.expect("it is tuned");
        let status = drive.status();
        let gains = status.gains.expect("they hold");
        assert_eq!(gains.origin, Origin::Commissioned);
        assert_eq!(gains.controller.kp.to_bits(), tuning.kp.to_bits());
        assert_eq!(status.ended, None, "the run continues");

        // From the commissioning to the loop, and on.
        let mut commands = reports.iter().filter_map(|report| match report {
            Report::Progress(progress) => progress.command,
            _ => None,
        });
        let last = commands.next_back().expect("it is shown");
        assert!((held(&drive) - last).abs() < 3.0 * A_COUNT, "{last}");
        let shown = snapshots(&drive.pass(2000));
        let end = shown.last().expect("it is shown");
        assert!((drive.position() - begun_at).abs() < 0.2);
        assert!((f64::from(end.position) - drive.position()).abs() < 0.01);
        drive.order(Command::Target(-2.0), 3000);
        assert!((drive.position() + 2.0).abs() < 0.02);

        drive.order(Command::Stop, 1);
        assert_eq!(bench.held.get(), None);
        assert!(outcome(&mut drive).kept);
        assert_eq!(drive.status().ended, Some(Ended::Stopped));
        let mut drive = drive.rebooted();
        assert_eq!(drive.status().gains, Some(gains));
        assert_eq!(outcome(&mut drive).commissioning.phase, Phase::Applied);
    }
}

#[test]
fn gauss_newton_continues_from_the_commissioned_servo() {
    let (mut drive, _) = Drive::on_bench(&LOADED);
    let mut wanted = gauss_newton();
    wanted.dither.amplitude = 0.05;
    run(&mut drive, wanted);
    let found = commission(&mut drive, ORDER).servo.expect("it is known");
    for restarted in [false, true] {
        if restarted {
            // A run from rest begins with it too, as long as nothing was learnt since.
            drive.order(Command::Stop, 1);
            let phase = commission(&mut drive, ORDER).commissioning.phase;
            assert_eq!(phase, Phase::Applied);
            drive.done(Command::Start);
        }
        let shown = snapshots(&drive.order(Command::Watch(1), 700));
        let first = shown.first().expect("shown").estimates;
        assert!(
            (first.servo.b / found.parameters.b - 1.0).abs() < 0.01,
            "{first:?}"
        );
        // A first fit would take a second before anything moves.
        let last = shown.last().expect("shown").estimates;
        assert_ne!(
            first.servo.b.to_bits(),
            last.servo.b.to_bits(),
            "it is learnt on"
        );
        assert!(
            shown
                .iter()
                .all(|at| (at.estimates.servo.b / LOADED.b - 1.0).abs() < 0.03)
        );
        assert!((last.servo.load - LOADED.load).abs() < 4.0, "{last:?}");
    }
    drive.order(Command::Stop, 1);
    let status = drive.status();
    assert_eq!(status.noticed.started, 0, "there was no first fit");
    let errors = status.estimates.and_then(|known| known.standard_errors);
    assert!(errors.is_some_and(|errors| errors.b > 0.0), "{status:?}");
}

#[test]
fn after_any_harm_in_any_phase_the_loop_continues_or_the_servo_is_released() {
    let pushed: (Harm, u8, Option<Fault>) = (
        |drive| drive.bench.plant.borrow_mut().position += 4.0,
        152,
        None,
    );
    for phase in PHASES {
        for (harm, number, fault) in HARMS.into_iter().chain([pushed]) {
            let case = format!("{number} in {phase:?}");
            let state = match fault {
                Some(fault) => State::Faulted(fault),
                None if number == Reason::ModeChanged.number() => State::Running,
                None => State::Disabled,
            };
            let (mut drive, bench) = Drive::on_bench(&LOADED);
            run(&mut drive, still());
            commission_until(&mut drive, ORDER, phase);
            harm(&mut drive);
            drive.sample();
            if state == State::Running {
                held(&drive);
            }
            over(&mut drive);
            cut_short(&mut drive, phase, number);
            assert_eq!(drive.state(), state, "{case}");
            assert_eq!(drive.shown(), still(), "{case}");
            let origin = drive.status().gains.map(|gains| gains.origin);
            assert_eq!(origin, Some(Origin::Given), "{case}");
            if state == State::Running {
                assert_continues(&mut drive, &still());
            } else {
                assert_eq!(bench.held.get(), None, "{case}: it is released");
            }
            assert_eq!(drive.flash.steps.get(), 0, "{case}: the store was touched");
        }
    }
}

/// The change of the command in the first sample after a push by 0.01 rad.
fn push(drive: &mut Drive) -> f32 {
    let before = held(drive);
    drive.bench.hold_at(drive.position() + 0.01);
    drive.sample();
    held(drive) - before
}

#[test]
fn gains_that_were_not_validated_do_not_hold_the_servo_afterwards() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    run(&mut drive, still());
    let given = push(&mut drive);
    drive.pass(2000);
    commission_until(&mut drive, ORDER, Phase::Trial);
    drive.refusal(Command::Start);
    assert_eq!(ended(&mut drive).commissioning.phase, Phase::RolledBack);
    drive.pass(4000);
    // From its first motion on all of the command acts.
    push(&mut drive);
    drive.pass(2000);
    let after = push(&mut drive);
    assert!((after / given - 1.0).abs() < 0.1, "{given} {after}");
    // With those that are validated it differs.
    drive.pass(2000);
    assert_eq!(
        commission(&mut drive, ORDER).commissioning.phase,
        Phase::Applied
    );
    drive.pass(4000);
    let applied = push(&mut drive);
    assert!((applied / given - 1.0).abs() > 0.3, "{given} {applied}");
}

#[test]
fn that_it_waits_for_the_loop_is_reported_once() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    run(&mut drive, still());
    commission_until(&mut drive, ORDER, Phase::Probe);
    drive.refusal(Command::Start);
    let mut reports = 0;
    for _ in 0..1000 {
        // The background takes the reports in, but has not built the loop yet.
        drive.pass_without_work(1);
        reports += std::iter::from_fn(|| drive.supervisor.next_report()).count();
    }
    // Its end, and that it holds the servo for the loop.
    assert_eq!(reports, 2);
    over(&mut drive);
    assert_eq!(drive.state(), State::Running);
}

#[test]
fn the_travel_is_counted_from_the_start_of_the_loop_after_a_commissioning_too() {
    for (place, state) in [
        (-1.99, State::Running),
        (-2.01, State::Faulted(Fault::TravelLeft)),
    ] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        let mut wanted = still();
        wanted.protection.following_error = 4.0;
        wanted.protection.speed = 1e4;
        wanted.protection.travel = [-2.0, 2.0];
        run(&mut drive, wanted);
        let mut order = ORDER;
        order.limits.travel = [-0.8, 0.8];
        commission_until(&mut drive, order, Phase::Rest);
        drive.refusal(Command::Start);
        over(&mut drive);
        assert_eq!(drive.state(), State::Running);
        bench.hold_at(place);
        drive.pass(1);
        assert_eq!(drive.state(), state, "{place} rad");
    }
}

#[test]
fn the_command_that_holds_the_load_after_a_commissioning_is_no_stall() {
    // More than the breakaway, 3, and friction keeps the axis where it is.
    let heavy = ServoParameters {
        load: 1000.0,
        coulomb: 100.0,
        ..SERVO
    };
    let (mut drive, _) = Drive::on_bench(&heavy);
    run(&mut drive, still());
    assert!(held(&drive).abs() > 3.2, "{}", held(&drive));
    commission_until(&mut drive, ORDER, Phase::Rest);
    drive.refusal(Command::Start);
    over(&mut drive);
    drive.pass(1000);
    assert_eq!(drive.state(), State::Running);
}

#[test]
fn everything_is_watched_after_its_end_until_the_loop_resumes() {
    let harms: [(Harm, Option<Fault>); 7] = [
        (harms::amplifier_fails, Some(Fault::AmplifierFault)),
        (harms::low_switch_opens, Some(Fault::LimitSwitch)),
        (harms::stage_fails, Some(Fault::ActuatorFailed)),
        (harms::encoder_fails, Some(Fault::EncoderLost)),
        (|_| {}, Some(Fault::LinkLost)),
        (harms::samples_are_late, None),
        (|drive| drive.bench.plant.borrow_mut().position += 2.0, None),
    ];
    for (harm, fault) in harms {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        let mut wanted = still();
        wanted.protection.link_timeout = if fault == Some(Fault::LinkLost) {
            0.2
        } else {
            0.0
        };
        drive.run_for(wanted, 10);
        commission_until(&mut drive, ORDER, Phase::Probe);
        drive.refusal(Command::Start);
        // The background has not built the loop yet.
        drive.pass_without_work(100);
        assert!(bench.held.get().is_some(), "it holds the servo");
        harm(&mut drive);
        drive.pass_without_work(300);
        assert_eq!(bench.held.get(), None, "{fault:?}");
        drive.pass(2);
        let state = fault.map_or(State::Disabled, State::Faulted);
        assert_eq!(drive.state(), state, "{fault:?}");
    }
}

#[test]
fn an_answer_of_the_solver_after_its_end_changes_nothing() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    run(&mut drive, still());
    commission_until(&mut drive, ORDER, Phase::Fit);
    drive.refusal(Command::Start);
    let ended = ended(&mut drive);
    assert_eq!(ended.commissioning.reason, Some(Reason::ModeChanged));
    assert_eq!((ended.servo, ended.tuning), (None, None));
}

#[test]
fn no_command_of_it_is_beyond_the_order_s_limits() {
    let (mut drive, bench) = Drive::on_bench(&LOADED);
    run(&mut drive, still());
    let mut order = ORDER;
    order.limits.command = [-1.5, 2.0];
    // A push has the loop command more than that when the order comes.
    bench.hold_at(drive.position() - 0.3);
    drive.sample();
    assert!(held(&drive) > 2.0, "{}", held(&drive));
    drive.done(Command::Commission(order));
    for sample in 0..3000 {
        drive.pass(1);
        if drive.state() != State::Commissioning {
            break;
        }
        let command = f64::from(held(&drive));
        let [low, high] = order.limits.command;
        assert!((low..=high).contains(&command), "{command} in {sample}");
    }
}

#[test]
fn every_end_hands_the_servo_back_without_a_bump_and_the_load_does_not_fall() {
    // Its motions go to and fro over a count that wraps: 1592 counts from the start.
    let bench = Bench::counting_from(i32::MIN + 1592, &LOADED);
    let mut drive = Drive::boot(bench, &Flash::blank());
    run(&mut drive, still());
    drive.done(Command::Commission(ORDER));
    let begun_at = drive.position();
    until(&mut drive, Phase::Fit);
    drive.refusal(Command::Start);
    let mut last = held(&drive);
    let mut handed_back = false;
    for _ in 0..3000 {
        let was = drive.state();
        drive.pass(1);
        let now = held(&drive);
        if was == State::Commissioning && drive.state() == State::Running {
            assert!((now - last).abs() < 2.0 * A_COUNT, "{last} {now}");
            handed_back = true;
        }
        last = now;
    }
    assert!(handed_back);
    let sagged = drive.position() - begun_at;
    assert!(sagged.abs() < 0.1, "{sagged}");
}

#[test]
fn a_run_that_has_ended_meanwhile_is_not_restarted() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    let mut short = still();
    short.protection.duration = 1.0;
    drive.run(short);
    while bench.held.get().is_none() {
        drive.sample();
    }
    while bench.held.get().is_some() {
        drive.sample();
    }
    // The background has not read the interrupt's events.
    commission(&mut drive, ORDER);
    assert_eq!(bench.held.get(), None);
    let ended = Commissioning {
        phase: Phase::Aborted,
        reason: Some(Reason::ModeChanged),
    };
    assert_eq!(outcome(&mut drive).commissioning, ended);
    assert_eq!(drive.state(), State::Disabled);
    drive.done(Command::Start);
}

#[test]
fn a_stop_that_overtakes_the_order_stops_the_loop_and_prevents_a_start() {
    for beside in [false, true] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        if beside {
            run(&mut drive, still());
        }
        drive.done(Command::Commission(ORDER));
        drive.done(Command::Stop);
        over(&mut drive);
        assert_eq!(bench.held.get(), None);
        let reason = outcome(&mut drive).commissioning.reason;
        assert_eq!(reason, Some(Reason::Stopped));
        drive.done(Command::Start);
    }
}

#[test]
fn after_a_power_loss_all_old_or_all_new_gains_are_in_force() {
    // The flash of a drive that was configured and saved.
    let (mut drive, _) = Drive::on_bench(&LOADED);
    drive.done(Command::Configure(still()));
    drive.done(Command::Save);
    let cold = drive.flash.bytes.borrow().clone();
    let commissioned = |flash: &Flash| {
        let mut drive = Drive::boot(Bench::new(&LOADED), flash);
        let begun = flash.steps.get();
        drive.order(Command::Start, 1000);
        commission(&mut drive, ORDER);
        assert_eq!(drive.state(), State::Running);
        // Up to here a loss of power finds the store untouched.
        assert_eq!(flash.steps.get(), begun);
        drive.order(Command::Stop, 1);
        drive.shown()
    };
    cut_anywhere(&LOADED, &cold, &still(), commissioned, |_, _, _| {});
}

#[test]
fn a_stop_between_the_end_of_a_commissioning_and_its_run_is_not_lost() {
    for nth in 1..=2 {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        run(&mut drive, still());
        drive.done(Command::Commission(ORDER));
        let mut ends = 0;
        while ends < nth {
            let is_end = |report: &Report| match report {
                Report::Status { status, .. } => {
                    let last = status.commissioning.expect("it is under way");
                    last.phase.is_end()
                }
                _ => false,
            };
            ends += drive
                .pass(1)
                .iter()
                .filter(|&report| is_end(report))
                .count();
            assert_eq!(drive.state(), State::Commissioning);
        }
        // The background orders the run, if it may, before the interrupt obeys the stop.
        drive.done(Command::Stop);
        while drive.supervisor.work() {}
        for _ in 0..100 {
            drive.pass(1);
            assert_eq!(bench.held.get(), None, "end {nth}");
        }
        assert_eq!(drive.state(), State::Disabled);
    }
}
