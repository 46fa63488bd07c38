//! Orders to commission: the conditions for one, and all or nothing after any interruption.

use crate::support::commission::{ORDER, SERVO, aborted, commission, outcome, over, ready};
use crate::support::drive::Drive;
use crate::support::line::request_bytes;
use crate::support::{Bench, Flash, settings};
use commissioning::{CommissionSettings, Phase};
use drive_link::{Command, Fault, Refusal, Report, Request, State};
use drive_logic::LineListener;
use identifier_core::reason::Reason;

#[test]
fn in_the_wrong_state_it_is_refused_with_a_reason_before_anything_moves() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    let mut drive = Drive::as_it_comes(bench, &flash);
    let order = Command::Commission(ORDER);
    assert_eq!(drive.refusal(Command::Outcome), Refusal::NeverCommissioned);
    assert_eq!(drive.refusal(order), Refusal::NotConfigured);
    drive.run_for(settings(), 10);
    drive.lines(|lines| lines.amplifier = false);
    drive.pass(3);
    let injected = Refusal::Faulted(Fault::AmplifierFault);
    assert_eq!(drive.refusal(order), injected);
    drive.pass(10);
    assert_eq!(bench.held.get(), None);
    assert_eq!(drive.status().commissioning, None);
    assert_eq!(flash.steps.get(), 0, "nothing was kept");
}

#[test]
fn a_flash_that_fails_to_keep_the_gains_in_force_prevents_a_start() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.flash.steps_left.set(3);
    let refused = drive.refusal(Command::Commission(ORDER));
    assert_eq!(refused, Refusal::NotKept);
    drive.pass(10);
    assert_eq!(bench.held.get(), None);
    assert_eq!(drive.state(), State::Disabled);
    // And the drive is of use still.
    drive.flash.steps_left.set(usize::MAX);
    drive.done(Command::Commission(ORDER));
    assert_eq!(drive.state(), State::Commissioning);
}

#[test]
fn gains_with_a_feed_forward_hold_and_are_kept_where_they_are_ordered() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    let order = CommissionSettings {
        feed_forward: true,
        ..ORDER
    };
    let outcome = commission(&mut drive, order);
    assert_eq!(outcome.commissioning.reason, None);
    let led = outcome.tuning.expect("gains").feed_forward;
    let holds = |drive: &mut Drive| {
        let core = drive.shown().closed_loop.core;
        core.controller.expect("a controller").feed_forward
    };
    assert!(led.is_some() && outcome.kept);
    assert_eq!(holds(&mut drive), led);
    assert_eq!(holds(&mut drive.rebooted()), led);
}

#[test]
fn an_axis_at_its_switch_is_not_moved() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    drive.lines(|lines| lines.low_switch = false);
    let ended = commission(&mut drive, ORDER).commissioning;
    assert_eq!(bench.held.get(), None);
    assert_eq!(ended, aborted(Reason::LimitSwitchesStuck));
    assert_eq!(drive.state(), State::Faulted(Fault::LimitSwitchesStuck));
    assert_eq!(drive.shown(), settings());
}

/// The line hears a stop that is not decoded yet.
fn hear_stop(listener: &mut LineListener<'_>) {
    for byte in request_bytes(9, Command::Stop) {
        listener.take(byte);
    }
}

#[test]
fn an_order_that_is_not_given_leaves_no_mark() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::with(ready()));
    let request = Request {
        id: 1,
        order: 1,
        command: Command::Commission(ORDER),
    };
    // A stop, or what may have been one, while the record is written.
    let events: [(fn(&mut LineListener<'_>), _); 2] = [
        (hear_stop, Refusal::Overtaken),
        (|listener| listener.disturbed(), Refusal::LineDisturbed),
    ];
    for (event, refusal) in events {
        let mut drive = Drive::boot(bench, &flash);
        drive.pass(30);
        let mut listener = drive.listener.take().expect("one line");
        let answer = drive
            .supervisor
            .answer_after(&request, || event(&mut listener));
        assert_eq!(answer, Report::Refused { id: 1, refusal });
        drive.pass(20);
        assert_eq!(bench.held.get(), None);
    }
    let mut drive = Drive::boot(bench, &flash);
    assert_eq!(drive.status().commissioning, None);
    drive.pass(30);
    // The queue of orders is full.
    for _ in 0..3 {
        drive.done(Command::Watch(1));
    }
    let refused = drive.refusal(Command::Commission(ORDER));
    assert_eq!(refused, Refusal::Busy);
    let mut drive = drive.rebooted();
    assert_eq!(drive.status().commissioning, None);
    drive.pass(30);
    drive.done(Command::Commission(ORDER));
}

#[test]
fn commissioned_gains_keep_the_limit_that_was_configured() {
    let limit = [-7.0, 9.0];
    let mut limited = settings();
    let controller = &mut limited.closed_loop.core.controller;
    controller.as_mut().expect("there is one").limit = limit;
    let (mut drive, _) = Drive::on_bench(&SERVO);
    drive.done(Command::Configure(limited));
    let mut order = ORDER;
    order.limits.command = [-6.0, 6.0];
    let found = commission(&mut drive, order);
    assert_eq!(found.commissioning.phase, Phase::Applied);
    let gains = drive.status().gains.expect("they hold");
    let tuning = found.tuning.expect("it is tuned");
    assert_eq!(gains.controller.kp.to_bits(), tuning.kp.to_bits());
    let bits = |limit: [f64; 2]| limit.map(f64::to_bits);
    assert_eq!(bits(gains.controller.limit), bits(limit));
}

#[test]
fn without_gains_a_drive_waits_for_a_commissioning() {
    let (bench, flash) = (Bench::new(&SERVO), Flash::blank());
    let mut drive = Drive::as_it_comes(bench, &flash);
    assert_eq!(drive.status().gains, None, "an example is not of its servo");
    let mut without = settings();
    without.closed_loop.core.controller = None;
    drive.done(Command::Configure(without));
    assert_eq!(drive.status().gains, None);
    assert_eq!(drive.not_allowed(Command::Start).name, "controller");
    let mut wrong = without;
    wrong.protection.stop_time = f64::NAN;
    assert_eq!(
        drive.not_allowed(Command::Configure(wrong)).name,
        "stop_time"
    );
    drive.done(Command::Commission(ORDER));
    assert_eq!(drive.state(), State::Commissioning);
}

#[test]
fn a_second_order_is_refused_while_the_first_is_under_way() {
    let (mut drive, _) = Drive::on_bench(&SERVO);
    drive.done(Command::Commission(ORDER));
    let mut other = ORDER;
    other.limits.duration *= 2.0;
    let refused = drive.refusal(Command::Commission(other));
    assert_eq!(refused, Refusal::Running);
    assert_eq!(drive.refusal(Command::Save), Refusal::Running);
    assert_eq!(drive.refusal(Command::Target(0.1)), Refusal::NotRunning);
    assert_eq!(drive.state(), State::Commissioning);
}

#[test]
fn a_power_loss_before_the_end_restores_the_gains_before_and_is_reported_once() {
    let cold = ready();
    // Steps of saving the gains in force, and of removing the mark.
    let steps = {
        let (bench, flash) = (Bench::new(&SERVO), Flash::with(cold.clone()));
        let mut drive = Drive::boot(bench, &flash);
        drive.done(Command::Commission(ORDER));
        let marked = flash.steps.get();
        drive.done(Command::Stop);
        over(&mut drive);
        (marked, flash.steps.get())
    };
    let lost = aborted(Reason::PowerLost);
    let mut reports = 0;
    for cut in 0..steps.1 {
        let (bench, flash) = (Bench::new(&SERVO), Flash::with(cold.clone()));
        {
            let mut drive = Drive::boot(bench, &flash);
            flash.steps_left.set(cut);
            if let Report::Done { .. } = drive.ask(Command::Commission(ORDER)) {
                assert!(cut >= steps.0, "it began without a mark");
                drive.done(Command::Stop);
                over(&mut drive);
            }
        }
        let after = flash.powered_again();
        for boot in 0..2 {
            let mut drive = Drive::boot(bench, &after);
            assert_eq!(drive.shown(), settings(), "cut after {cut} of {steps:?}");
            let says = drive.status().commissioning;
            if boot == 0 && says.is_some() {
                assert_eq!(says, Some(lost), "cut after {cut} of {steps:?}");
                let of_it = outcome(&mut drive);
                assert_eq!(of_it.commissioning, lost);
                assert_eq!((of_it.servo, of_it.tuning, of_it.kept), (None, None, false));
                reports += 1;
            } else {
                assert_eq!(says, None, "cut after {cut} of {steps:?}: reported twice");
            }
            // That it was reported is saved where the axis stands.
            drive.pass(30);
            drive.done(Command::Start);
        }
    }
    assert!(reports > 0, "it was never reported");
}
