//! The loop on the chip, the plant elsewhere.

mod support;

use drive_link::{Answer, Format, Law, LoopSettings, Question, Reading, Refused};
use drive_logic::LockStep;
use identifier_core::ControllerSettings;
use identifier_core::model::ServoParameters;
use identifier_core::settings::IdentifierSettings;
use support::{COUNTS, SAMPLE_TIME, settings};
use virtual_servo::{Encoder, Plant};

const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 0.0,
    load: 0.0,
};

fn reading(lock_step: &mut LockStep, number: u32, wanted: i32, count: i32) -> Reading {
    let question = Question::Sample {
        number,
        setpoint: wanted,
        offset: 0.25,
        count,
    };
    match lock_step.answer(&question) {
        Answer::Command {
            number: same,
            reading,
        } => {
            assert_eq!(same, number);
            reading
        }
        other => panic!("{other:?}"),
    }
}

/// Runs an experiment; every question is asked as often as said.
fn run(closed_loop: LoopSettings, times: u32) -> Reading {
    let mut lock_step = LockStep::new();
    assert_eq!(
        lock_step.answer(&Question::Begin(closed_loop)),
        Answer::Ready
    );
    let mut plant = Plant::at_rest(&SERVO, SAMPLE_TIME);
    let encoder = Encoder::new(COUNTS);
    let mut last = None;
    for k in 0..10_000 {
        let wanted = if k / 100 % 3 == 0 { 300 } else { -200 };
        let count = encoder.read(plant.position) as i32;
        let seen = reading(&mut lock_step, k, wanted, count);
        for _ in 1..times {
            assert_eq!(reading(&mut lock_step, k, wanted, count), seen);
        }
        plant.advance(seen.command);
        last = Some(seen);
    }
    last.expect("samples")
}

#[test]
fn both_formats_find_the_servo_however_often_a_question_is_asked() {
    for format in [Format::Single, Format::Fixed] {
        let closed_loop = LoopSettings {
            format,
            ..settings().closed_loop
        };
        let once = run(closed_loop, 1);
        assert!((once.estimates.b / SERVO.b - 1.0).abs() < 0.01, "{once:?}");
        assert_eq!(run(closed_loop, 3), once);
    }
}

#[test]
fn a_first_fit_is_made_once_however_often_a_question_is_asked() {
    let mut closed_loop = LoopSettings {
        law: Law::GaussNewton,
        ..settings().closed_loop
    };
    closed_loop.core.identifier = IdentifierSettings::UNSTATED;
    let once = run(closed_loop, 1);
    assert!((once.estimates.b / SERVO.b - 1.0).abs() < 0.01, "{once:?}");
    assert_eq!(run(closed_loop, 3), once);
}

#[test]
fn what_is_out_of_step_or_out_of_range_is_refused() {
    let mut lock_step = LockStep::new();
    let sample = |number| Question::Sample {
        number,
        setpoint: 0,
        offset: 0.0,
        count: 0,
    };
    assert_eq!(
        lock_step.answer(&sample(0)),
        Answer::Refused(Refused::NotBegun)
    );
    let mut closed_loop = settings().closed_loop;
    closed_loop.core.controller = Some(ControllerSettings::pid(-1.0, 0.19, 4.0));
    assert!(matches!(
        lock_step.answer(&Question::Begin(closed_loop)),
        Answer::Refused(Refused::Setting(refused)) if refused.name == "kp"
    ));
    let begin = Question::Begin(settings().closed_loop);
    assert_eq!(lock_step.answer(&begin), Answer::Ready);
    assert_eq!(
        lock_step.answer(&sample(1)),
        Answer::Refused(Refused::OutOfStep { next: 0 })
    );
    lock_step.answer(&sample(0));
    lock_step.answer(&sample(1));
    assert_eq!(
        lock_step.answer(&sample(0)),
        Answer::Refused(Refused::OutOfStep { next: 2 })
    );
    let mad = Question::Sample {
        number: 2,
        setpoint: 0,
        offset: f64::NAN,
        count: 0,
    };
    assert_eq!(lock_step.answer(&mad), Answer::Refused(Refused::OutOfReach));
    assert!(matches!(
        lock_step.answer(&sample(2)),
        Answer::Command { .. }
    ));
}
