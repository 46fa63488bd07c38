//! A commissioning from rest: from an unknown servo to gains in force, with any harm in any phase.

use crate::support::commission::{
    HARMS, ORDER, PHASES, SERVO, aborted, changed, commission, commission_until, cut_anywhere,
    cut_short, ended, outcome, over, ready,
};
use crate::support::drive::{Drive, snapshots};
use crate::support::{Bench, Flash, settings, still};
use commissioning::{CommissionIsr, CommissionSettings, Phase};
use drive_link::{Command, Commissioning, Fault, MotionRecord, Origin, Progress, Report, State};
use identifier_core::reason::Reason;
use identifier_core::tuning::Goal;

const APPLIED: Commissioning = Commissioning {
    phase: Phase::Applied,
    reason: None,
};

#[test]
fn an_unknown_servo_ends_with_gains_in_force_now_and_after_a_power_cycle() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    let mut drive = Drive::as_it_comes(bench, &flash);
    let mut unknown = settings();
    unknown.closed_loop.core.controller = None;
    drive.done(Command::Configure(unknown));
    let found = commission(&mut drive, ORDER);
    assert_eq!(found.commissioning, APPLIED);
    assert!(found.kept);
    assert_eq!(bench.held.get(), None, "it is released at the end");
    let servo = found.servo.expect("it is known").parameters;
    assert!((servo.b / SERVO.b - 1.0).abs() < 0.02, "{servo:?}");
    let tuning = found.tuning.expect("it is tuned");
    let status = drive.status();
    let gains = status.gains.expect("they hold");
    assert_eq!(gains.origin, Origin::Commissioned);
    let pid = gains.controller;
    assert_eq!((pid.kp, pid.kd, pid.ki), (tuning.kp, tuning.kd, tuning.ki));
    let limit = ORDER.limits.command;
    assert_eq!((pid.limit, gains.cutoff), (limit, tuning.cutoff));
    let known = status.estimates.expect("the servo is known");
    assert_eq!(known.servo.b.to_bits(), servo.b.to_bits());
    assert!(known.standard_errors.is_some_and(|errors| errors.b > 0.0));
    drive.done(Command::Watch(1));
    drive.done(Command::Start);
    let shown = snapshots(&drive.order(Command::Target(0.5), 3000));
    let last = shown.last().expect("it is shown");
    assert!((last.position - last.reference).abs() < 0.5, "{last:?}");
    assert_eq!(drive.state(), State::Running);
    let mut drive = Drive::as_it_comes(Bench::new(&SERVO), &flash);
    let status = drive.status();
    assert_eq!(status.gains, Some(gains));
    assert_eq!(status.commissioning, Some(APPLIED));
    assert_eq!(outcome(&mut drive).commissioning, APPLIED);
    // Gains that a user sets no longer count as commissioned.
    drive.done(Command::Configure(settings()));
    let origin = drive.status().gains.map(|gains| gains.origin);
    assert_eq!(origin, Some(Origin::Given));
}

#[test]
fn its_progress_is_reported() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    drive.done(Command::Watch(10));
    drive.done(Command::Commission(ORDER));
    let reports = over(&mut drive);
    let shown: Vec<Progress> = reports
        .iter()
        .filter_map(|report| match report {
            Report::Progress(progress) => Some(*progress),
            _ => None,
        })
        .collect();
    for pair in shown.windows(2) {
        assert_eq!(pair[1].sample, pair[0].sample + 10);
    }
    let [low, high] = ORDER.limits.travel.map(|end| end as f32);
    assert!(shown.iter().all(|at| (low..high).contains(&at.position)));
    let probed = shown.iter().filter(|at| at.phase == Phase::Probe);
    assert!(
        probed
            .clone()
            .any(|at| at.recorded > 0 && at.gain.is_none())
    );
    assert!(probed.clone().any(|at| at.position.abs() > 0.01));
    let tried = shown.iter().find(|at| at.phase == Phase::Trial);
    let [b, error] = tried.and_then(|at| at.gain).expect("it is known by then");
    assert!((f64::from(b) / SERVO.b - 1.0).abs() < 0.02 && error > 0.0);
    // Every phase is reported too.
    for phase in PHASES {
        let is_reported = |report: &Report| {
            matches!(report, Report::Status { status, .. }
                if status.commissioning.is_some_and(|stands| stands.phase == phase))
        };
        assert!(reports.iter().any(is_reported), "{phase:?}");
    }
}

/// The part of the record from a block on.
fn part(drive: &mut Drive, first: u16) -> MotionRecord {
    match drive.ask(Command::MotionRecord(first)) {
        Report::MotionRecord { part, .. } => part,
        other => panic!("{other:?} is no record"),
    }
}

#[test]
fn its_record_is_there_once_it_is_over_and_during_the_next_run() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    assert_eq!(part(&mut drive, 0), MotionRecord::NONE);
    commission_until(&mut drive, ORDER, Phase::FrequencyResponse);
    assert_eq!(part(&mut drive, 0), MotionRecord::NONE, "it may still grow");
    over(&mut drive);
    let mut displacements = Vec::new();
    while let blocks = part(&mut drive, displacements.len() as u16).blocks
        && !blocks.is_empty()
    {
        displacements.extend(blocks.iter().map(|[displacement, ..]| *displacement));
    }
    let first = part(&mut drive, 0);
    assert_eq!(displacements.len(), usize::from(first.total));
    assert!((16..=256).contains(&first.total) && first.samples > 0);
    assert_eq!(first.resolution.to_bits(), ORDER.resolution.to_bits());
    let farthest = displacements
        .iter()
        .scan(0.0_f32, |position, displacement| {
            *position += displacement;
            Some(position.abs())
        });
    let farthest = f64::from(farthest.fold(0.0, f32::max)) * first.resolution;
    assert!((0.01..2.0).contains(&farthest), "{farthest}");
    // A run has a record of its own.
    drive.order(Command::Start, 500);
    assert_eq!(part(&mut drive, 0), first);
}

#[test]
fn after_any_harm_in_any_phase_the_gains_before_are_in_force_and_the_reason_is_reported() {
    for phase in PHASES {
        for (harm, number, fault) in HARMS {
            let mut drive = Drive::boot(Bench::new(&SERVO), &Flash::with(ready()));
            commission_until(&mut drive, ORDER, phase);
            harm(&mut drive);
            over(&mut drive);
            let case = format!("{number} in {phase:?}");
            let came_to = cut_short(&mut drive, phase, number);
            assert_eq!(drive.bench.held.get(), None, "{case}: it is released");
            let state = fault.map_or(State::Disabled, State::Faulted);
            assert_eq!(drive.state(), state, "{case}");
            assert_eq!(drive.shown(), settings(), "{case}");
            assert!(!came_to.kept, "{case}");
            let mut drive = drive.rebooted();
            assert_eq!(drive.shown(), settings());
            assert_eq!(drive.status().commissioning, None);
        }
    }
}

#[test]
fn a_background_that_hangs_is_left_to_the_watchdog_as_in_a_run() {
    for phase in [Phase::Fit, Phase::Trial] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        commission_until(&mut drive, ORDER, phase);
        let before = bench.fed.get();
        drive.pass(5);
        assert_eq!(bench.fed.get() - before, 5, "{phase:?}");
        let fed = drive.fed_while_hanging(150);
        assert!((49..=100).contains(&fed), "{fed} in {phase:?}");
        // As soon as the background runs again, the watchdog is fed again.
        drive.pass(1);
        assert_eq!(drive.fed_while_hanging(40), 40, "{phase:?}");
    }
}

#[test]
fn an_output_that_cannot_be_disabled_is_a_fault_while_the_servo_is_not_driven_yet() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    let mut drive = Drive::as_it_comes(bench, &flash);
    // No gains hold the servo during the released check.
    let mut unknown = settings();
    unknown.closed_loop.core.controller = None;
    drive.done(Command::Configure(unknown));
    commission_until(&mut drive, ORDER, Phase::Rest);
    bench.releases.set(false);
    let reason = ended(&mut drive).commissioning.reason;
    assert_eq!(reason, Some(Reason::ActuatorFailed));
    assert_eq!(drive.state(), State::Faulted(Fault::ActuatorFailed));
}

#[test]
fn the_solver_gets_its_slices_with_every_sample() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.done(Command::Commission(ORDER));
    let slices = CommissionIsr::<f32>::new(&ORDER, None)
        .expect("allowed")
        .slices();
    assert!(slices > 1, "{slices}");
    for _ in 0..3 {
        drive.sampler.interrupt(&mut bench.pins());
        let mut done = 1;
        while drive.supervisor.work() {
            done += 1;
        }
        assert_eq!(done, slices);
    }
}

#[test]
fn a_record_with_a_hole_ends_it() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    commission_until(&mut drive, ORDER, Phase::Probe);
    // Turns, so that the watchdog is fed, but no work: the queue fills.
    drive.pass_without_work(400);
    let ended = ended(&mut drive).commissioning;
    assert_eq!(ended.reason, Some(Reason::Overrun));
    assert_eq!(bench.held.get(), None);
}

#[test]
fn its_late_samples_are_counted_and_reported() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    commission_until(&mut drive, ORDER, Phase::Rest);
    let late = |drive: &mut Drive, samples: u32| {
        bench.late.set(true);
        drive.pass(samples);
        bench.late.set(false);
    };
    // A single one is bridged.
    for _ in 0..3 {
        late(&mut drive, 1);
        drive.pass(3);
    }
    assert_eq!(drive.state(), State::Commissioning);
    late(&mut drive, 3);
    let ended = ended(&mut drive).commissioning;
    assert_eq!(ended.reason, Some(Reason::Overrun));
    assert_eq!(drive.status().overruns, 6);
}

#[test]
fn a_command_that_the_stage_does_not_take_is_released_in_the_same_sample() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    commission_until(&mut drive, ORDER, Phase::Probe);
    bench.stage_works.set(false);
    drive.sample();
    assert_eq!(bench.held.get(), None);
    let ended = ended(&mut drive).commissioning;
    assert_eq!(ended, aborted(Reason::ActuatorFailed));
    assert_eq!(drive.state(), State::Faulted(Fault::ActuatorFailed));
}

#[test]
fn its_result_is_saved_once_the_axis_stands_if_the_flash_must_be_erased_for_that() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    // With the mark at its begin, all that an area holds.
    let mut wanted = settings();
    for _ in 0..2 {
        wanted.protection.stop_time *= 1.01;
        drive.done(Command::Configure(wanted));
        drive.done(Command::Save);
    }
    assert_eq!(commission(&mut drive, ORDER).commissioning, APPLIED);
    assert_eq!(bench.held.get(), None);
    // Turned by hand.
    for k in 0..100 {
        bench.hold_at(0.01 * f64::from(k));
        drive.pass(1);
        assert_eq!(
            (drive.flash.erased.get(), outcome(&mut drive).kept),
            (0, false)
        );
    }
    drive.pass(18);
    assert_eq!(
        (drive.flash.erased.get(), outcome(&mut drive).kept),
        (0, false)
    );
    drive.pass(4);
    assert_eq!(
        (drive.flash.erased.get(), outcome(&mut drive).kept),
        (1, true)
    );
    drive.pass(100);
    assert_eq!(drive.flash.erased.get(), 1, "once");
}

#[test]
fn a_result_is_saved_once_and_no_run_afterwards_writes_to_the_flash() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    assert!(commission(&mut drive, ORDER).kept);
    let run = |drive: &mut Drive| {
        let steps = drive.flash.steps.get();
        drive.order(Command::Start, 100);
        drive.order(Command::Stop, 100);
        assert_eq!(drive.flash.steps.get(), steps);
    };
    run(&mut drive);
    // Nor after one that has found nothing.
    commission_until(&mut drive, ORDER, Phase::Probe);
    drive.refusal(Command::Start);
    over(&mut drive);
    drive.pass(100);
    run(&mut drive);
    // A record has the gains before, which are no result of it.
    drive.done(Command::Save);
    assert!(!outcome(&mut drive).kept);
}

#[test]
fn a_flash_that_fails_is_tried_again_with_the_end_of_a_run_and_not_all_the_time() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    commission_until(&mut drive, ORDER, Phase::Trial);
    drive.flash.steps_left.set(0);
    over(&mut drive);
    drive.pass(200);
    assert_eq!(outcome(&mut drive).commissioning, APPLIED);
    assert_eq!(
        (drive.flash.refused.get(), outcome(&mut drive).kept),
        (1, false)
    );
    drive.flash.steps_left.set(usize::MAX);
    drive.order(Command::Start, 100);
    drive.order(Command::Stop, 100);
    assert!(outcome(&mut drive).kept);
}

#[test]
fn a_silent_host_ends_it_in_any_phase_from_rest_and_beside_a_run() {
    for beside in [false, true] {
        let mut listening = still();
        listening.protection.link_timeout = if beside { 0.05 } else { 0.01 };
        for phase in PHASES {
            let (mut drive, bench) = Drive::on_bench(&SERVO);
            drive.done(Command::Configure(listening));
            if beside {
                drive.order(Command::Start, 10);
            }
            commission_until(&mut drive, ORDER, phase);
            let reason = ended(&mut drive).commissioning.reason;
            assert_eq!(bench.held.get(), None, "{phase:?}");
            assert_eq!(drive.state(), State::Faulted(Fault::LinkLost), "{phase:?}");
            assert_eq!(reason, Some(Reason::LinkLost), "{phase:?}");
            assert_eq!(drive.shown(), listening, "{phase:?}");
        }
    }
}

#[test]
fn a_stop_releases_the_servo_in_the_same_sample_and_a_mode_change_brings_it_to_rest_first() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    commission_until(&mut drive, ORDER, Phase::FrequencyResponse);
    drive.pass(10);
    drive.done(Command::Stop);
    drive.sample();
    assert_eq!(bench.held.get(), None);
    drive.pass(100);

    commission_until(&mut drive, ORDER, Phase::FrequencyResponse);
    drive.pass(400);
    let moving = bench.plant.borrow().velocity;
    assert!(moving.abs() > 1.0, "{moving}");
    drive.refusal(Command::Start);
    drive.sample();
    assert!(bench.held.get().is_some(), "the gains before hold it");
    over(&mut drive);
    let left = bench.plant.borrow().velocity;
    assert!(left.abs() < 0.5, "{left}");
    // And now it can be started.
    drive.order(Command::Start, 5);
    assert_eq!(drive.state(), State::Running);
}

#[test]
fn after_a_power_loss_all_old_or_all_new_gains_are_in_force() {
    let commissioned = |flash: &Flash| {
        let mut drive = Drive::boot(Bench::new(&SERVO), flash);
        if let Report::Done { .. } = drive.ask(Command::Commission(ORDER)) {
            over(&mut drive);
        }
        drive.shown()
    };
    cut_anywhere(
        &SERVO,
        &ready(),
        &settings(),
        commissioned,
        |status, is_new, cut| {
            if is_new {
                assert_eq!(status.commissioning, Some(APPLIED), "cut after {cut}");
            } else {
                let reason = status.commissioning.and_then(|stands| stands.reason);
                assert!(
                    matches!(reason, None | Some(Reason::PowerLost)),
                    "cut after {cut}"
                );
            }
        },
    );
}

#[test]
fn nothing_of_a_commissioning_goes_to_the_next() {
    let drive = || Drive::boot(Bench::new(&SERVO), &Flash::with(ready()));
    let fast = CommissionSettings {
        goal: Goal::Bandwidth(300.0),
        ..ORDER
    };
    let mut whole = drive();
    let end = commission(&mut whole, fast).commissioning;
    assert_eq!(end, aborted(Reason::NoGains));
    // Cut at any time, after which the background goes on for a while, or takes nothing in.
    for (samples, goes_on) in (20..8000).step_by(20).flat_map(|k| [(k, false), (k, true)]) {
        let mut drive = drive();
        drive.done(Command::Commission(fast));
        drive.pass(samples);
        if drive.state() != State::Commissioning {
            assert!(samples > 500, "{samples}");
            return;
        }
        drive.pass_without_work(30);
        drive.done(Command::Stop);
        for _ in 0..60 {
            if goes_on {
                drive.sample();
            } else {
                drive.pass_without_work(1);
            }
            drive.bench.hold_at(0.0);
        }
        while drive.supervisor.next_report().is_some() {}
        // Of another servo.
        let other = changed(0.25, 1.0);
        drive.bench.change(&other);
        let again = commission(&mut drive, ORDER);
        assert_eq!(again.commissioning, APPLIED, "{samples} {goes_on}");
        let b = again.servo.expect("known").parameters.b;
        assert!((b / other.b - 1.0).abs() < 0.02, "{samples}: {b}");
    }
    unreachable!("it ends");
}
