//! The first motion of an unknown servo: a dead encoder does not show it.

use crate::support::commission::SERVO;
use crate::support::drive::Drive;
use crate::support::{settings, still};
use drive_link::{Command, Fault, State};
use identifier_core::parameters::ServoParameters;

/// A run under the PID of the settings, without a dither.
fn start(drive: &mut Drive) {
    let settings = still();
    drive.run_for(settings, 10);
}

/// The largest command and the largest change by which a probe's may rise in a sample of 1 ms.
const LIMIT: f32 = 10.0;
const STEEPEST: f32 = 0.02 * LIMIT;

#[test]
fn an_unknown_servo_with_a_dead_encoder_is_pushed_as_by_a_probe_and_ends() {
    // A line of it may still flicker.
    for (target, pause, flicker) in [
        (9.0, 0, 0),
        (-9.0, 0, 1),
        (1.0, 0, 4),
        (-1.0, 700, 0),
        (9.0, 3000, 1),
    ] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        bench.stick();
        start(&mut drive);
        drive.pass(pause);
        assert_eq!(drive.state(), State::Running);
        drive.done(Command::Target(target));
        let (mut before, mut most, mut rises) = (0.0_f32, 0.0_f32, 0);
        for sample in 0..2000 {
            bench.flicker.set(flicker * (sample % 2));
            drive.pass(1);
            let Some(command) = bench.held.get() else {
                break;
            };
            let rise = command.abs() - before.abs();
            assert!(rise <= STEEPEST * 1.001, "{target} {sample}: {rise}");
            before = command;
            most = most.max(command.abs());
            rises += u32::from(command.abs() > 0.1);
        }
        let ended = State::Faulted(Fault::EncoderSilent);
        assert_eq!(drive.state(), ended, "{target}");
        assert_eq!(drive.state(), ended, "{target}");
        assert_eq!(bench.held.get(), None);
        let plant = *bench.plant.borrow();
        println!(
            "{target}: {most} for {rises} samples, {} rad",
            plant.position
        );
        assert!(plant.position.abs() < 2.0, "{target}: {}", plant.position);
    }
}

#[test]
fn a_servo_that_counts_has_all_of_its_command_at_once() {
    for friction in [0.0, 15.0, 500.0] {
        let servo = ServoParameters {
            coulomb: friction,
            ..SERVO
        };
        let (mut drive, bench) = Drive::on_bench(&servo);
        start(&mut drive);
        // From the second motion on nothing is left of the ramp.
        for (target, is_first) in [(1.0, true), (2.0, false), (-1.0, false)] {
            drive.done(Command::Target(target));
            let mut largest = 0.0_f32;
            let mut before = bench.held.get().unwrap_or(0.0);
            for _ in 0..2500 {
                drive.pass(1);
                let command = bench.held.get().expect("it runs");
                largest = largest.max((command - before).abs());
                before = command;
            }
            assert_eq!(drive.state(), State::Running, "{friction}");
            let off = bench.position() - target;
            assert!(off.abs() < 0.2, "{friction} {target}: {off}");
            println!("{friction} {target} {is_first}: {largest}");
        }
    }
}

#[test]
fn from_its_first_motion_on_it_has_the_usual_time_to_move() {
    // Counts that are a motion, and others.
    for (counts, samples) in [(5.5, 100), (4.0, 20), (0.0, 20)] {
        let (mut drive, bench) = Drive::on_bench(&SERVO);
        start(&mut drive);
        bench.hold_at(counts * settings().closed_loop.core.resolution);
        bench.stick();
        drive.done(Command::Target(9.0));
        let mut beyond = 0;
        for _ in 0..1000 {
            drive.pass(1);
            let Some(command) = bench.held.get() else {
                break;
            };
            beyond += u32::from(command.abs() >= 0.3 * LIMIT);
        }
        assert_eq!(drive.state(), State::Faulted(Fault::EncoderSilent));
        assert!(beyond.abs_diff(samples) <= 2, "{counts}: {beyond}");
    }
}
