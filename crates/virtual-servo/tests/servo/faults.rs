//! Injected faults: each has its effect for its duration.

use identifier_core::parameters::ServoParameters;
use virtual_servo::faults::{FaultKind, Faults, InjectedFault};
use virtual_servo::{Effects, Servo};

use crate::{SAMPLE_TIME, with};

const COUNT: f64 = 1e-3;
const PARAMETERS: ServoParameters = ServoParameters::new(1.5, 200.0, 6.0, -3.0);

fn servo(effects: &Effects) -> Servo {
    Servo::at_rest(&PARAMETERS, effects, SAMPLE_TIME, 7).expect("allowed")
}

/// Encoder readings, sample by sample, of a servo under a command that changes its sign.
fn shown(faults: &[InjectedFault], effects: &Effects) -> Vec<Option<f64>> {
    let mut servo = servo(effects);
    let mut faults = Faults::new(faults, SAMPLE_TIME, COUNT).expect("allowed");
    (0..400)
        .map(|sample| {
            faults.begin_sample(&mut servo);
            let shown = faults.seen(servo.position());
            servo.advance(faults.acting(command(sample)));
            shown
        })
        .collect()
}

fn command(sample: u32) -> f64 {
    if sample % 80 < 40 { 0.5 } else { -0.4 }
}

fn sound(effects: &Effects) -> Vec<f64> {
    let mut servo = servo(effects);
    (0..400)
        .map(|sample| {
            let position = servo.position();
            servo.advance(command(sample));
            position
        })
        .collect()
}

fn fault(kind: FaultKind, size: f64) -> InjectedFault {
    InjectedFault {
        kind,
        time: 0.1,
        duration: 0.05,
        size,
    }
}

#[test]
fn without_a_fault_and_before_one_every_bit_is_that_of_the_sound_servo() {
    for effects in [
        Effects::NONE,
        with(|of| (of.delay, of.gravity) = (1.5e-3, [4.0, 1.0])),
    ] {
        let sound = sound(&effects);
        for faults in [vec![], vec![fault(FaultKind::ActuatorReversed, 0.0)]] {
            for (sample, shown) in shown(&faults, &effects).into_iter().enumerate().take(101) {
                let bits = shown.map(f64::to_bits);
                assert_eq!(bits, Some(sound[sample].to_bits()), "{sample}");
            }
        }
    }
}

#[test]
fn each_encoder_fault_changes_the_readings_as_stated() {
    let sound = sound(&Effects::NONE);
    let moved = |from: usize, to: usize| sound[to] - sound[from];
    let shows = |kind, size| shown(&[fault(kind, size)], &Effects::NONE);
    let close = |shown: Option<f64>, expected: f64| {
        let shown = shown.expect("it is read");
        assert!((shown - expected).abs() < 1e-12, "{shown} {expected}");
    };
    let stuck = shows(FaultKind::EncoderStuck, 0.0);
    let reversed = shows(FaultKind::EncoderReversed, 0.0);
    let jumped = shows(FaultKind::EncoderJump, 25.0);
    let lost = shows(FaultKind::EncoderLost, 0.0);
    for sample in 0..400 {
        let within = (100..150).contains(&sample);
        assert_eq!(lost[sample].is_none(), within, "{sample}");
        // The position before a fault is where it begins to count wrongly.
        let past = sample.clamp(99, 149);
        let wrongly = moved(99, past);
        close(stuck[sample], sound[sample] - wrongly);
        close(reversed[sample], sound[sample] - 2.0 * wrongly);
        let jump = if sample >= 100 { 25.0 * COUNT } else { 0.0 };
        close(jumped[sample], sound[sample] + jump);
    }
}

#[test]
fn an_actuator_acts_by_its_share_and_a_late_sample_holds_the_command_before() {
    let acts = |kind, size, sample: usize| {
        let mut servo = servo(&Effects::NONE);
        let faults = [fault(kind, size)];
        let mut faults = Faults::new(&faults, SAMPLE_TIME, COUNT).expect("allowed");
        (0..=sample)
            .map(|sample| {
                let now = faults.begin_sample(&mut servo);
                (now, faults.acting(sample as f64))
            })
            .last()
            .expect("a sample")
    };
    for (kind, size, expected) in [
        (FaultKind::ActuatorDead, 0.0, 0.0),
        (FaultKind::ActuatorWeak, 0.25, 30.0),
        (FaultKind::ActuatorReversed, 0.0, -120.0),
        (FaultKind::AmplifierFault, 0.0, 0.0),
        (FaultKind::Overrun, 0.0, 119.0),
        (FaultKind::LimitSwitch, 0.0, 120.0),
    ] {
        let (now, command) = acts(kind, size, 120);
        assert!((command - expected).abs() < 1e-12, "{kind:?}: {command}");
        assert_eq!(now.late, kind == FaultKind::Overrun);
        assert_eq!(now.limit_switch, kind == FaultKind::LimitSwitch);
        assert_eq!(now.amplifier_fault, kind == FaultKind::AmplifierFault);
        for sound in [99, 150] {
            let (now, command) = acts(kind, size, sound);
            assert!((command - sound as f64).abs() < 1e-12, "{kind:?}");
            assert!(!now.late && !now.limit_switch && !now.amplifier_fault);
        }
    }
}

#[test]
fn a_load_step_accelerates_and_a_friction_rise_brakes_while_they_last() {
    let integrated = with(|of| of.gravity = [1e-9, 0.0]);
    for effects in [Effects::NONE, integrated] {
        // Pushed by 0.5 · 200 − 3 rad/s² against 6 of friction.
        let speed = |kind, size| {
            let mut servo = servo(&effects);
            let faults = [fault(kind, size)];
            let mut faults = Faults::new(&faults, SAMPLE_TIME, COUNT).expect("allowed");
            for _ in 0..200 {
                faults.begin_sample(&mut servo);
                servo.advance(faults.acting(0.5));
            }
            servo.velocity()
        };
        let undisturbed = speed(FaultKind::LoadStep, 0.0);
        // The velocity gained in 50 ms decays with a for another 50.
        let fades = (1.0 - (-1.5_f64 * 0.05).exp()) / 1.5 * (-1.5_f64 * 0.05).exp();
        for (kind, size, share) in [
            (FaultKind::LoadStep, 20.0, 20.0),
            (FaultKind::FrictionRise, 15.0, -15.0),
        ] {
            let changed = speed(kind, size) - undisturbed;
            let off = changed - share * fades;
            assert!(off.abs() < 1e-6, "{kind:?}: {changed}");
        }
    }
}

#[test]
fn impossible_faults_are_refused_by_name() {
    let sound = fault(FaultKind::ActuatorWeak, 0.5);
    type Change = fn(&mut InjectedFault);
    let changes: [(&str, Change); 3] = [
        ("time", |fault| fault.time = -1.0),
        ("duration", |fault| fault.duration = 0.0),
        ("size", |fault| fault.size = 1.5),
    ];
    for (name, change) in changes {
        let mut fault = sound;
        change(&mut fault);
        let refused = Faults::new(&[fault], SAMPLE_TIME, COUNT).expect_err("refused");
        assert_eq!(refused.parameter, name);
    }
    let many = [sound; Faults::MAX_FAULTS + 1];
    let refused = Faults::new(&many, SAMPLE_TIME, COUNT).expect_err("too many");
    assert_eq!(refused.parameter, "faults");
    Faults::new(&many[1..], SAMPLE_TIME, COUNT).expect("as many as there can be");
}
