//! A listening identifier under any input, in both formats, and with the amplifier off.

use crate::support::{
    Kind, Loop, amplitude_for, learn, on_all_cores, ordinary_servo, per_cent, quantile, shown,
};
use identifier_core::Settings;
use identifier_core::error::StepError;
use identifier_core::identifier::{Event, GaussNewtonIdentifier, Identify};
use identifier_core::number::Number;
use identifier_core::parameters::{ServoParameters, Unknowns};
use proptest::prelude::*;

type Identifier<N> = GaussNewtonIdentifier<N, Unknowns<4>, 4>;

fn is_finite(p: &ServoParameters) -> bool {
    [p.a, p.b, p.coulomb, p.load].iter().all(|x| x.is_finite())
}

/// The estimates of both formats after 10 s of the same record, and the greater of their errors.
fn in_format<N: Number>(
    record: &[(f64, f64)],
    config: &Settings,
) -> (ServoParameters, ServoParameters) {
    let identifier = config.build::<Identifier<N>>().expect("settings");
    let mut state = identifier.start();
    for &(increment, command) in record {
        learn(&identifier, &mut state, (increment, command));
    }
    let errors = identifier
        .report(&state)
        .errors_of_parameters()
        .expect("started");
    (shown(&identifier, &state), errors)
}

#[test]
fn f32_and_f64_agree_within_the_estimates_wander() {
    let differences = on_all_cores(60, |i| {
        let servo = ordinary_servo(i + 5000);
        let amplitude = amplitude_for(Kind::Pid, &servo, 0.4);
        let mut run = Loop::new(Kind::Pid, &servo, amplitude);
        let samples = (10.0 / servo.sample_time) as u64;
        // The same command in both formats.
        let record: Vec<(f64, f64)> = (0..samples)
            .map(|_| run.sample())
            .map(|(increment, command)| (increment, f64::from(command as f32)))
            .collect();
        let (single, _) = in_format::<f32>(&record, &servo.settings());
        let (double, _) = in_format::<f64>(&record, &servo.settings());
        let truth = servo.parameters;
        [
            (single.b / double.b - 1.0).abs() / 1e-3,
            (single.a - double.a).abs() / (0.01 * truth.a).max(0.03),
            (single.load - double.load).abs() / (3e-3 * servo.authority()),
        ]
    });
    for (i, name) in ["b", "a", "load"].into_iter().enumerate() {
        let values: Vec<f64> = differences.iter().map(|d| d[i]).collect();
        println!(
            "{name}: difference of the formats over the figure asked for: median {:.4}, 95 % {:.4}, worst {:.4}",
            quantile(&values, 0.5),
            quantile(&values, 0.95),
            quantile(&values, 1.0)
        );
        assert!(quantile(&values, 0.95) < 0.3, "{name}");
    }
}

#[test]
fn an_amplifier_that_is_off_is_reported_and_not_learnt_from() {
    let runs = on_all_cores(60, |i| {
        let mut servo = ordinary_servo(i + 6000);
        // Friction that holds the load: without the amplifier the servo is at rest. One that ran
        // away under its load could not be distinguished from a load that rose to the command's size.
        let friction = 1.3 * servo.parameters.load.abs() + 0.02 * servo.authority();
        servo.parameters.coulomb = friction;
        let amplitude = amplitude_for(Kind::Pid, &servo, 0.3);
        let identifier = servo
            .settings()
            .build::<Identifier<f32>>()
            .expect("settings");
        let mut state = identifier.start();
        let mut run = Loop::new(Kind::Pid, &servo, amplitude);
        let mut noticed = f64::INFINITY;
        let second = (1.0 / servo.sample_time) as u64;
        let mut before = shown(&identifier, &state);
        for k in 0..9 * second {
            run.powered = !(4 * second..6 * second).contains(&k);
            if k == 4 * second {
                before = shown(&identifier, &state);
            }
            let (increment, command) = run.sample();
            let seen = learn(&identifier, &mut state, (increment, command));
            if seen.event == Event::NotFollowing && k >= 4 * second {
                noticed = noticed.min(k as f64 * servo.sample_time - 4.0);
            }
        }
        let after = shown(&identifier, &state);
        (
            servo,
            noticed,
            (after.b / before.b - 1.0).abs(),
            (after.b / servo.parameters.b - 1.0).abs(),
            servo.parameters.coulomb > 0.0,
        )
    });
    let noticed = per_cent(&runs, |r| r.1 < 2.0);
    let kept = per_cent(&runs, |r| r.3 < 0.01);
    println!(
        "amplifier off for 2 s: noticed {noticed:.1} %, b within 1 % three seconds later {kept:.1} %"
    );
    // The others coasted while the command was at its limit: a load of that size would have the same effect.
    assert!(noticed >= 75.0);
    assert!(kept >= 90.0);
}

/// A millisecond and counts of a milliradian.
fn milliradians() -> Settings {
    Settings {
        resolution: 1e-3,
        ..Settings::new(1e-3, 1.0)
    }
}

#[test]
fn errors_leave_the_state_untouched() {
    let mut config = milliradians();
    config.identifier.max_speed = Some(101.0);
    let identifier: Identifier<f32> = config.build().expect("settings");
    let mut state = identifier.start();
    for (increment, command, error) in [
        (f32::NAN, 1.0, StepError::CountJumped),
        (f32::INFINITY, 1.0, StepError::CountJumped),
        (102.0, 1.0, StepError::CountJumped),
        (1e9, 1.0, StepError::CountJumped),
        (1.0, f32::NAN, StepError::CommandNotFinite),
        (1.0, f32::NEG_INFINITY, StepError::CommandNotFinite),
    ] {
        let before = state;
        assert_eq!(identifier.learn(&mut state, increment, command), Err(error));
        assert_eq!(before, state);
    }
    assert!(identifier.learn(&mut state, 101.0, 1.0).is_ok());
}

/// Any sample: ordinary ones, huge ones, and NaN.
fn any_sample() -> impl Strategy<Value = (f32, f32)> {
    let increment = prop_oneof![
        8 => (-50_i32..50).prop_map(|x| x as f32),
        1 => (-16_000_000_i32..16_000_000).prop_map(|x| x as f32),
        1 => any::<f32>(),
    ];
    let command = prop_oneof![8 => -10.0_f32..10.0, 1 => -1e7_f32..1e7, 1 => any::<f32>()];
    (increment, command)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn no_output_is_nan(
        samples in prop::collection::vec(any_sample(), 300..1500),
        time in 0.05_f64..0.5,
        guess in prop::option::of(0.01_f64..1e4),
    ) {
        let mut config = milliradians();
        config.identifier.start_time = Some(time);
        config.identifier.initial.b = guess;
        let identifier: GaussNewtonIdentifier<f32, Unknowns<4>, 4, 64> = config.build().expect("settings");
        let mut state = identifier.start();
        for (k, &(increment, command)) in samples.iter().enumerate() {
            // A motion that follows the command every other while, so that fits are found.
            let increment = if k / 200 % 2 == 0 { (command * 3.0).round() } else { increment };
            if let Ok(seen) = identifier.learn(&mut state, increment, command) {
                prop_assert!(seen.output_error.is_finite());
            }
            identifier.work(&mut state, 200);
            prop_assert!(is_finite(&shown(&identifier, &state)));
            if let Some(errors) = identifier.report(&state).errors_of_parameters() {
                prop_assert!(is_finite(&errors), "{errors:?}");
            }
        }
    }
}
