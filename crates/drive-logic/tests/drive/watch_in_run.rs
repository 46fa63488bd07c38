//! A run is watched as a commissioning is, for as long as the servo is driven.

use crate::support::commission::{ORDER, SERVO, commission};
use crate::support::drive::Drive;
use crate::support::{Bench, Flash, still};
use commissioning::{CommissionSettings, Phase};
use drive_link::{Command, Fault, State};
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::Goal;

/// Gains of an ordinary response. Slower ones push less, and what does not move shows later.
const QUICK: CommissionSettings = CommissionSettings {
    goal: Goal::ResponseTime(0.048),
    ..ORDER
};

/// The sample times at which a run is watched: every sample up to 2 kHz, and every 0.5 ms above.
const SAMPLE_TIMES: [f64; 4] = [1e-3, 2.5e-4, 1e-4, 5e-5];

/// A drive that was commissioned and runs with the new gains, without a dither.
fn running(sample_time: f64) -> (Drive, &'static Bench) {
    let bench = Bench::sampled(&SERVO, sample_time);
    let mut drive = Drive::as_it_comes(bench, &Flash::blank());
    let mut settings = still();
    settings.closed_loop.core.sample_time = sample_time;
    drive.done(Command::Configure(settings));
    let order = CommissionSettings {
        sample_time,
        ..QUICK
    };
    let phase = commission(&mut drive, order).commissioning.phase;
    assert_eq!(phase, Phase::Applied, "{sample_time} s");
    start(&mut drive);
    (drive, bench)
}

fn start(drive: &mut Drive) {
    drive.order(Command::Start, drive.bench.samples(0.5));
    assert_eq!(drive.state(), State::Running);
}

/// A sound axis again, at rest.
fn mend(drive: &mut Drive) {
    drive.bench.change(&SERVO);
    drive.bench.connected.set(true);
    drive.bench.hold_at(0.0);
    drive.pass(drive.bench.samples(0.1));
    drive.order(Command::Clear, 1);
    start(drive);
}

/// Time until a drive has ended its run with a fault, s, and the fault.
fn fault_within(drive: &mut Drive, most: f64) -> (f64, Fault) {
    for sample in 1..=drive.bench.samples(most) {
        drive.pass(1);
        if let State::Faulted(fault) = drive.state() {
            assert_eq!(drive.bench.held.get(), None);
            return (f64::from(sample) * drive.bench.sample_time.get(), fault);
        }
    }
    panic!(
        "no fault in {most} s at {} s, {}",
        drive.bench.sample_time.get(),
        drive.bench.position()
    );
}

#[test]
fn a_stuck_encoder_after_a_commissioning_disables_within_fifty_milliseconds_of_motion() {
    for sample_time in SAMPLE_TIMES {
        let (mut drive, bench) = running(sample_time);
        for target in [2.0, -0.5] {
            bench.stick();
            // At rest it does not show.
            drive.pass(bench.samples(0.2));
            assert_eq!(drive.state(), State::Running);
            drive.done(Command::Target(target));
            let (taken, fault) = fault_within(&mut drive, 0.05);
            assert_eq!(
                fault,
                Fault::ActuatorDead,
                "{sample_time} s: after {taken} s"
            );
            mend(&mut drive);
        }
    }
}

#[test]
fn an_encoder_that_sticks_in_motion_disables_within_fifty_milliseconds() {
    for sample_time in SAMPLE_TIMES {
        let (mut drive, bench) = running(sample_time);
        for target in [20.0, -20.0] {
            for wait in (5..400).step_by(13) {
                let wait = f64::from(wait) * 1e-3;
                drive.order(Command::Target(target), bench.samples(wait));
                bench.stick();
                let (taken, fault) = fault_within(&mut drive, 0.05);
                assert!(
                    matches!(fault, Fault::EncoderStuck | Fault::ActuatorDead),
                    "{sample_time} s: {fault} {taken} s after {wait}"
                );
                mend(&mut drive);
            }
        }
    }
}

#[test]
fn an_actuator_that_dies_or_turns_round_disables() {
    for sample_time in SAMPLE_TIMES {
        let (mut drive, bench) = running(sample_time);
        for b in [1e-3, -SERVO.b] {
            for wait in (5..400).step_by(40) {
                drive.order(Command::Target(20.0), bench.samples(f64::from(wait) * 1e-3));
                bench.change(&ServoParameters { b, ..SERVO });
                let (taken, fault) = fault_within(&mut drive, 0.5);
                let named = [
                    Fault::ActuatorDead,
                    Fault::Reversed,
                    Fault::FollowingError,
                    Fault::SpeedExceeded,
                ];
                assert!(
                    named.contains(&fault),
                    "{sample_time} s, {b}: {fault} {taken} s after {wait} ms"
                );
                mend(&mut drive);
            }
        }
    }
}

#[test]
fn a_sound_servo_runs_on_whatever_it_carries() {
    for sample_time in SAMPLE_TIMES {
        stays_running(sample_time);
    }
}

fn stays_running(sample_time: f64) {
    let (mut drive, bench) = running(sample_time);
    let heavy = ServoParameters {
        a: SERVO.a / 2.0,
        b: SERVO.b / 2.0,
        coulomb: 10.0,
        load: 100.0,
    };
    let light = ServoParameters {
        a: 2.0 * SERVO.a,
        b: 2.0 * SERVO.b,
        coulomb: 30.0,
        load: -300.0,
    };
    for (carried, target) in [heavy, light, heavy, SERVO, light]
        .iter()
        .zip([5.0, -5.0, 9.0, 0.0, 3.0])
    {
        drive.pass(bench.samples(0.15));
        bench.change(carried);
        drive.pass(bench.samples(0.15));
        drive.done(Command::Target(target));
        for _ in 0..bench.samples(5.0) {
            drive.pass(1);
            assert_eq!(drive.state(), State::Running, "{carried:?} {target}");
        }
    }
}
