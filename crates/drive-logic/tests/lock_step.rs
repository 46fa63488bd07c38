//! The loop on the chip, the plant elsewhere.

mod support;

use std::sync::mpsc;
use std::thread;

use drive_link::{Answer, Format, Law, LoopSettings, Question, Reading, Receiver, Refused, frame};
use drive_logic::LockStep;
use identifier_core::ControllerSettings;
use identifier_core::identifier::{GaussNewtonIdentifier, Identify, ServoLoop};
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::parameters::AbCoulombLoad;
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
fn gauss_newton_on_the_chip_is_the_cores_bit_for_bit() {
    type Core = ServoLoop<f32, LowPass<f32>, GaussNewtonIdentifier<f32, AbCoulombLoad, 4>>;
    let mut closed_loop = LoopSettings {
        law: Law::GaussNewton,
        ..settings().closed_loop
    };
    closed_loop.core.identifier = IdentifierSettings::UNSTATED;
    let core: Core = closed_loop.core.build().expect("valid");
    let mut state = core.start(0);
    let mut chip = chip();
    assert_eq!(chip(&Question::Begin(closed_loop)), Answer::Ready);
    let servo = ServoParameters {
        coulomb: 10.0,
        load: 20.0,
        ..SERVO
    };
    let mut plant = Plant::at_rest(&servo, SAMPLE_TIME);
    let encoder = Encoder::new(COUNTS);
    let mut last = None;
    for number in 0..10_000 {
        let setpoint = if number / 100 % 3 == 0 { 300 } else { -200 };
        let count = encoder.read(plant.position) as i32;
        let step = core
            .process(&mut state, setpoint, 0.25, count)
            .expect("within reach");
        core.identifier().work(state.identification_mut(), u32::MAX);
        let answer = chip(&Question::Sample {
            number,
            setpoint,
            offset: 0.25,
            count,
        });
        let Answer::Command { reading, .. } = answer else {
            panic!("{answer:?}");
        };
        let found = core.identifier().estimates(state.identification());
        let expected = [
            step.control.command.into(),
            step.seen.output_error.into(),
            found.a,
            found.b,
            found.coulomb,
            found.load,
        ];
        let estimates = reading.estimates;
        let told = [
            reading.command,
            reading.output_error,
            estimates.a,
            estimates.b,
            estimates.coulomb,
            estimates.load,
        ];
        assert_eq!(
            told.map(f64::to_bits),
            expected.map(f64::to_bits),
            "sample {number}"
        );
        plant.advance(reading.command);
        last = Some(estimates);
    }
    let found = last.expect("samples");
    assert!((found.b / servo.b - 1.0).abs() < 0.01, "{found:?}");
}

/// A chip on a thread of its own, at the other end of a line of frames.
fn chip() -> impl FnMut(&Question) -> Answer {
    let (ask, asked) = mpsc::channel::<Vec<u8>>();
    let (tell, told) = mpsc::channel::<Vec<u8>>();
    thread::spawn(move || {
        let mut lock_step = LockStep::new();
        let mut receiver = Receiver::new();
        for byte in asked.iter().flatten() {
            if let Some(Ok(question)) = receiver.take::<Question>(byte) {
                let framed = frame(&lock_step.answer(&question)).expect("it fits");
                if tell.send(framed.to_vec()).is_err() {
                    return;
                }
            }
        }
    });
    let mut receiver = Receiver::new();
    move |question| {
        let framed = frame(question).expect("it fits");
        ask.send(framed.to_vec()).expect("the chip listens");
        let bytes = told.recv().expect("the chip answers");
        let answer = bytes
            .into_iter()
            .find_map(|byte| receiver.take::<Answer>(byte));
        answer.expect("a frame").expect("undamaged")
    }
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
