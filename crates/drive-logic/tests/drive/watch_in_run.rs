//! A run is watched as a commissioning is, for as long as the servo is driven.

use crate::support::commission::{ORDER, SERVO, commission};
use crate::support::drive::Drive;
use crate::support::{SAMPLE_TIME, still};
use commissioning::{CommissionSettings, Phase};
use drive_link::{Command, Fault, State};
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::Goal;

/// Gains of an ordinary response. Slower ones push less, and what does not move shows later.
const QUICK: CommissionSettings = CommissionSettings {
    goal: Goal::ResponseTime(0.048),
    ..ORDER
};

/// A drive that was commissioned and runs with the new gains, without a dither.
fn running(drive: &mut Drive) {
    drive.done(Command::Configure(still()));
    let phase = commission(drive, QUICK).commissioning.phase;
    assert_eq!(phase, Phase::Applied);
    drive.order(Command::Start, 500);
    assert_eq!(drive.state(), State::Running);
}

/// Samples until a drive has ended its run with a fault, and the fault.
fn fault_within(drive: &mut Drive, most: u32) -> (u32, Fault) {
    for sample in 1..=most {
        drive.pass(1);
        if let State::Faulted(fault) = drive.state() {
            assert_eq!(drive.bench.held.get(), None);
            return (sample, fault);
        }
    }
    panic!("no fault in {most} samples");
}

fn samples(time: f64) -> u32 {
    (time / SAMPLE_TIME).round() as u32
}

#[test]
fn a_stuck_encoder_after_a_commissioning_disables_within_fifty_milliseconds_of_motion() {
    for target in [2.0, -0.5] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        running(&mut drive);
        bench.stick();
        // At rest it does not show.
        drive.pass(200);
        assert_eq!(drive.state(), State::Running);
        drive.done(Command::Target(target));
        let (taken, fault) = fault_within(&mut drive, samples(0.05));
        assert_eq!(fault, Fault::ActuatorDead, "after {taken} samples");
    }
}

#[test]
fn an_encoder_that_sticks_in_motion_disables_within_fifty_milliseconds() {
    for target in [20.0, -20.0] {
        for wait in (5..400).step_by(13) {
            let (mut drive, bench) = Drive::on_bench(&SERVO);
            running(&mut drive);
            drive.order(Command::Target(target), wait);
            bench.stick();
            let (taken, fault) = fault_within(&mut drive, samples(0.05));
            assert!(
                matches!(fault, Fault::EncoderStuck | Fault::ActuatorDead),
                "{fault} {taken} ms after {wait}"
            );
        }
    }
}

#[test]
fn an_actuator_that_dies_or_turns_round_disables() {
    for b in [1e-3, -SERVO.b] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        running(&mut drive);
        drive.order(Command::Target(20.0), 300);
        bench.change(&ServoParameters { b, ..SERVO });
        let (_, fault) = fault_within(&mut drive, samples(0.5));
        let named = [
            Fault::ActuatorDead,
            Fault::Reversed,
            Fault::FollowingError,
            Fault::SpeedExceeded,
        ];
        assert!(named.contains(&fault), "{b}: {fault}");
    }
}

#[test]
fn a_sound_servo_runs_on_whatever_it_carries() {
    let (mut drive, bench) = Drive::on_bench(&SERVO);
    running(&mut drive);
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
        drive.pass(150);
        bench.change(carried);
        drive.pass(150);
        drive.done(Command::Target(target));
        for _ in 0..5000 {
            drive.pass(1);
            assert_eq!(drive.state(), State::Running, "{carried:?} {target}");
        }
    }
}
