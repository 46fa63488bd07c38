//! Tuning against closed forms.

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::{Cap, Goal, StepMeasure, Tuner, TuningError, TuningSettings};

use crate::support::{identified, tuned};

const SERVO: ServoParameters = ServoParameters {
    a: 0.2174,
    b: 257.7,
    coulomb: 0.0,
    load: 0.0,
};

const KNOWN: [f64; 3] = [0.0; 3];

/// 1 kHz, an ideal sensor, no limit, a step of 0.1 rad.
fn settings(goal: Goal) -> TuningSettings {
    TuningSettings {
        goal,
        ..TuningSettings::new(1e-3, 0.0, f64::INFINITY, 0.1)
    }
}

#[test]
fn the_gains_place_the_poles() {
    let omega = 20.0;
    let tuning = settings(Goal::Bandwidth(omega))
        .tune(&identified(SERVO, 0.0, KNOWN))
        .expect("within reach");
    // (s + ω)² (s + ω/5), multiplied out.
    let close = |x: f64, y: f64| (x - y).abs() < 1e-9 * y;
    assert!(close(SERVO.a + SERVO.b * tuning.kd, 2.2 * omega));
    assert!(close(SERVO.b * tuning.kp, 1.4 * omega.powi(2)));
    assert!(close(SERVO.b * tuning.ki, 0.2 * omega.powi(3)));
}

/// With a = 60 and ω = 20 the servo damps more than 2ω + ω/5: the third pole is at a − 2ω.
#[test]
fn a_servo_that_damps_itself_needs_no_derivative() {
    let (omega, a) = (20.0, 60.0);
    let servo = ServoParameters { a, ..SERVO };
    let tuning = settings(Goal::Bandwidth(omega))
        .tune(&identified(servo, 0.0, KNOWN))
        .expect("within reach");
    let close = |x: f64, y: f64| (x - y).abs() < 1e-9 * y;
    assert_eq!(tuning.kd.to_bits(), 0.0_f64.to_bits());
    assert!(close(
        servo.b * tuning.kp,
        omega * omega + 2.0 * omega * omega
    ));
    assert!(close(servo.b * tuning.ki, omega * omega * omega));
}

/// The step of the placement is 1 + 0.625 e^(−ωt/5) − (1.625 + 1.5 ωt) e^(−ωt).
#[test]
fn a_slow_loop_steps_as_its_placement() {
    let shape = |t: f64| 1.0 + 0.625 * (-0.2 * t).exp() - (1.625 + 1.5 * t) * (-t).exp();
    let grid = || (0..400_000).map(|i| f64::from(i) * 1e-4);
    let reaches = |level: f64| grid().find(|&t| shape(t) >= level).expect("it does");
    let rise = reaches(0.9) - reaches(0.1);
    assert!((rise - Tuner::RISE).abs() < 3e-4, "{rise}");
    let overshoot = grid().map(shape).fold(0.0, f64::max) - 1.0;
    let settled = grid().rfind(|&t| (shape(t) - 1.0).abs() > 0.02);

    // A cut-off far above the loop, and samples far below.
    let omega = 5.0;
    let settings = TuningSettings {
        cutoff: Some(3000.0),
        ..settings(Goal::Bandwidth(omega))
    };
    let tuning = settings
        .tune(&identified(SERVO, 0.0, KNOWN))
        .expect("within reach");
    let promise = tuning.promise;
    assert!(
        (promise.rise_time * omega / rise - 1.0).abs() < 0.01,
        "{promise:?}"
    );
    assert!((promise.overshoot - overshoot).abs() < 0.005, "{promise:?}");
    let settled = settled.expect("it begins outside");
    assert!(
        (promise.settling_time * omega / settled - 1.0).abs() < 0.02,
        "{promise:?}"
    );
    // s³/((s + ω)² (s + ω/5)) nowhere exceeds one.
    assert!(promise.sensitivity < 1.03, "{promise:?}");
}

/// The response to a unit of load is s/((s + ω)² (s + ω/5)) ÷ s: its largest value in closed form.
#[test]
fn compliance_is_that_of_the_placement() {
    let omega = 5.0;
    let settings = TuningSettings {
        cutoff: Some(3000.0),
        ..settings(Goal::Bandwidth(omega))
    };
    let tuning = settings
        .tune(&identified(SERVO, 0.0, KNOWN))
        .expect("within reach");
    // 1/((s+1)²(s+0.2)): (e^(−0.2t) − e^(−t))/0.64 − t e^(−t)/0.8.
    let answer = |t: f64| ((-0.2 * t).exp() - (-t).exp()) / 0.64 - t * (-t).exp() / 0.8;
    let largest = (0..200_000)
        .map(|i| answer(f64::from(i) * 1e-4))
        .fold(0.0, f64::max);
    let expected = largest / (omega * omega);
    assert!(
        (tuning.promise.compliance / expected - 1.0).abs() < 0.01,
        "{tuning:?}"
    );
}

#[test]
fn a_response_time_is_met() {
    for time in [0.03, 0.1, 0.7] {
        for (coulomb, counts) in [(0.0, f64::INFINITY), (5.0, 10_000.0)] {
            let servo = ServoParameters { coulomb, ..SERVO };
            let settings = TuningSettings {
                resolution: std::f64::consts::TAU / counts,
                ..settings(Goal::ResponseTime(time))
            };
            let tuning = settings
                .tune(&identified(servo, 5e-4, KNOWN))
                .expect("within reach");
            let off = tuning.promise.rise_time / time - 1.0;
            assert!(off.abs() < 0.02, "{time} {coulomb}: {tuning:?}");
            assert_eq!(tuning.cap, None);
        }
    }
}

/// The step that is shown is the one that was measured for the promise.
#[test]
fn the_shown_step_is_the_promised_one() {
    let settings = TuningSettings {
        resolution: 1e-4,
        ..settings(Goal::Bandwidth(40.0))
    };
    let tuner = Tuner::new(&settings, &identified(SERVO, 1e-3, KNOWN)).expect("valid");
    let tuning = settings
        .tune(&identified(SERVO, 1e-3, KNOWN))
        .expect("within reach");
    let mut measure = StepMeasure::<f64>::new(settings.step, settings.resolution);
    let step = tuner.step(&tuning).expect("valid");
    for sample in step.take(200) {
        let counts = sample.position / settings.resolution;
        assert!(
            (counts - counts.round()).abs() < 1e-6,
            "the encoder shows whole counts"
        );
    }
    let until = 25.0 / tuning.bandwidth;
    step.take_while(|sample| sample.time < until)
        .for_each(|sample| measure.take(sample.position));
    let rise = measure.rise().expect("it rises") * settings.sample_time;
    assert!(
        (rise / tuning.promise.rise_time - 1.0).abs() < 1e-9,
        "{rise}"
    );
    let settled = f64::from(measure.settled().expect("it settles")) * settings.sample_time;
    assert!((settled / tuning.promise.settling_time - 1.0).abs() < 1e-9);
}

/// With a known to be 3, ω = 1.5 needs hardly any derivative; if a may be 0.3 too, it needs nine times
/// as much, or that servo would oscillate.
#[test]
fn uncertain_friction_is_not_relied_on() {
    let servo = ServoParameters { a: 3.0, ..SERVO };
    let tuned = |error: f64| {
        let errors = [error, 0.0, 0.0];
        settings(Goal::Bandwidth(1.5))
            .tune(&identified(servo, 0.0, errors))
            .expect("within reach")
    };
    assert!((servo.b * tuned(0.0).kd - 0.3).abs() < 1e-9);
    assert!((servo.b * tuned(0.9).kd - 3.0).abs() < 1e-9);
}

#[test]
fn each_cap_is_named_and_is_the_one_that_helps() {
    let servo = identified(SERVO, 0.0, KNOWN);
    let at = |settings: TuningSettings| settings.tune(&servo).expect("some gains");
    let plain = settings(Goal::Stiffest);
    let limited = TuningSettings {
        command: 2.0,
        ..plain
    };
    let coarse = TuningSettings {
        resolution: std::f64::consts::TAU / 4096.0,
        command: 10.0,
        step: 0.02,
        ..plain
    };
    let resonant = TuningSettings {
        resonance: Some(300.0),
        ..plain
    };
    for (settings, cap, relief) in [
        (
            plain,
            Cap::Delay,
            TuningSettings {
                sample_time: 5e-4,
                ..plain
            },
        ),
        (
            limited,
            Cap::CommandLimit,
            TuningSettings {
                command: 4.0,
                ..limited
            },
        ),
        (
            coarse,
            Cap::EncoderNoise,
            TuningSettings {
                resolution: coarse.resolution / 2.0,
                ..coarse
            },
        ),
        (
            resonant,
            Cap::Resonance,
            TuningSettings {
                resonance: Some(400.0),
                ..resonant
            },
        ),
    ] {
        let (tuning, relieved) = (at(settings), at(relief));
        assert_eq!(tuning.cap, Some(cap));
        assert!(relieved.bandwidth > 1.15 * tuning.bandwidth, "{cap}");
    }
    // 4 · 2.2 ω = 300, and 1.4 ω² step/b = 2.
    let resonant = at(resonant).bandwidth;
    assert!(
        (0.99..1.0).contains(&(resonant * 8.8 / 300.0)),
        "{resonant}"
    );
    let limited = at(limited).bandwidth;
    let command = 1.4 * limited * limited * 0.1 / SERVO.b;
    assert!((0.97..1.0).contains(&(command / 2.0)), "{limited}");
}

/// A first sample of k_p + k_d g/T counts, then a decay.
#[test]
fn noise_is_that_of_white_rounding_through_the_controller() {
    let settings = TuningSettings {
        resolution: 1e-3,
        cutoff: Some(300.0),
        command: 100.0,
        ..settings(Goal::Bandwidth(30.0))
    };
    let tuning = settings
        .tune(&identified(SERVO, 0.0, KNOWN))
        .expect("within reach");
    let g = 1.0 - (-0.3_f64).exp();
    let mut power = 0.0;
    let mut velocity = 0.0;
    for k in 0..1000 {
        let increment = match k {
            0 => 1.0,
            1 => -1.0,
            _ => 0.0,
        };
        velocity += g * (increment - velocity);
        let position = if k == 0 { tuning.kp } else { 0.0 };
        power += (position + tuning.kd / 1e-3 * velocity).powi(2);
    }
    let expected = 1e-3 / 12.0_f64.sqrt() * power.sqrt();
    assert!((tuning.promise.noise / expected - 1.0).abs() < 1e-9);
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let servo = identified(SERVO, 0.0, KNOWN);
    let good = TuningSettings {
        resolution: 1e-3,
        command: 10.0,
        ..settings(Goal::Stiffest)
    };
    assert!(Tuner::new(&good, &servo).is_ok());
    for (bad, name) in [
        (
            TuningSettings {
                sample_time: 0.0,
                ..good
            },
            "sample_time",
        ),
        (
            TuningSettings {
                resolution: -1.0,
                ..good
            },
            "resolution",
        ),
        (
            TuningSettings {
                cutoff: Some(4000.0),
                ..good
            },
            "cutoff",
        ),
        (
            TuningSettings {
                command: 0.0,
                ..good
            },
            "command",
        ),
        (
            TuningSettings {
                command: f64::NAN,
                ..good
            },
            "command",
        ),
        (
            TuningSettings {
                command_delay: -1e-3,
                ..good
            },
            "command_delay",
        ),
        (
            TuningSettings {
                goal: Goal::ResponseTime(0.0),
                ..good
            },
            "response_time",
        ),
        (
            TuningSettings {
                goal: Goal::Bandwidth(f64::INFINITY),
                ..good
            },
            "bandwidth",
        ),
        (
            TuningSettings {
                max_sensitivity: 1.0,
                ..good
            },
            "max_sensitivity",
        ),
        (
            TuningSettings {
                max_noise: 0.0,
                ..good
            },
            "max_noise",
        ),
        (
            TuningSettings {
                step: 0.009,
                ..good
            },
            "step",
        ),
        (
            TuningSettings {
                resonance: Some(0.0),
                ..good
            },
            "resonance",
        ),
    ] {
        match Tuner::new(&bad, &servo) {
            Err(TuningError::OutOfRange(OutOfRange { parameter, .. })) => {
                assert_eq!(parameter, name);
            }
            other => panic!("{name}: {other:?}"),
        }
    }
    let few = Tuner::new(
        &TuningSettings {
            step: 0.009,
            ..good
        },
        &servo,
    );
    assert_eq!(
        few.err(),
        Some(TuningError::OutOfRange(OutOfRange {
            parameter: "step",
            value: 0.009,
            allowed: Allowed::AtLeast(0.01),
        }))
    );
}

#[test]
fn a_servo_with_large_standard_errors_gets_no_gains() {
    let goal = settings(Goal::Stiffest);
    let of_b = |error: f64| tuned(&goal, &identified(SERVO, 0.0, [0.0, error * SERVO.b, 0.0])).0;
    assert!(of_b(0.01).is_ok());
    assert_eq!(of_b(0.4), Err(TuningError::NotKnown));
    let nothing = ServoParameters { b: 0.0, ..SERVO };
    assert_eq!(
        goal.tune(&identified(nothing, 0.0, KNOWN)),
        Err(TuningError::NotKnown)
    );
}

/// The integral of the step grows to the friction's command, k_i · step · t = c/b, within 25/ω where
/// 0.5 ω² > c/step.
#[test]
fn a_step_that_friction_stops_is_not_promised() {
    let servo = ServoParameters {
        coulomb: 10.0,
        ..SERVO
    };
    let step = |bandwidth| {
        let goal = settings(Goal::Bandwidth(bandwidth));
        goal.tune(&identified(servo, 0.0, KNOWN))
    };
    assert_eq!(step(3.5), Err(TuningError::DoesNotArrive));
    let promise = step(6.0).expect("it arrives").promise;
    // Where the integral balances friction, it does not slow the servo.
    assert!(
        (promise.quickest_rise_time * 6.0 / Tuner::RISE - 1.0).abs() < 0.02,
        "{promise:?}"
    );
    assert!(
        promise.rise_time > 4.0 * promise.quickest_rise_time,
        "{promise:?}"
    );
}
