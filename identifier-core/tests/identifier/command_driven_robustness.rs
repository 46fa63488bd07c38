//! A listening identifier in both formats, and with the amplifier off.

use crate::support::{
    Kind, Loop, amplitude_for, learn, on_all_cores, ordinary_servo, per_cent, report, shown,
};
use identifier_core::Settings;
use identifier_core::identifier::{Event, GaussNewtonIdentifier, Identify};
use identifier_core::number::Number;
use identifier_core::parameters::{ServoParameters, Unknowns};

type Identifier<N> = GaussNewtonIdentifier<N, Unknowns<4>, 4>;

/// The estimates of a format after 10 s of a record.
fn in_format<N: Number>(record: &[(f64, f64)], config: &Settings) -> ServoParameters {
    let identifier = config.build::<Identifier<N>>().expect("settings");
    let mut state = identifier.start();
    for &(increment, command) in record {
        learn(&identifier, &mut state, (increment, command));
    }
    assert!(identifier.is_running(&state));
    shown(&identifier, &state)
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
        let single = in_format::<f32>(&record, &servo.settings());
        let double = in_format::<f64>(&record, &servo.settings());
        let truth = servo.parameters;
        [
            (single.b / double.b - 1.0).abs() / 1e-3,
            (single.a - double.a).abs() / (0.01 * truth.a).max(0.03),
            (single.load - double.load).abs() / (3e-3 * servo.authority()),
        ]
    });
    for (i, name) in ["b", "a", "load"].into_iter().enumerate() {
        // Over the figure that is asked for.
        let [_, _, most, _] = report(name, &differences, |difference| difference[i]);
        assert!(most < 0.3, "{name}");
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
        let identifier: Identifier<f32> = servo.settings().build().expect("settings");
        let mut state = identifier.start();
        let mut run = Loop::new(Kind::Pid, &servo, amplitude);
        let mut noticed = f64::INFINITY;
        let second = (1.0 / servo.sample_time) as u64;
        for k in 0..9 * second {
            run.powered = !(4 * second..6 * second).contains(&k);
            let (increment, command) = run.sample();
            let seen = learn(&identifier, &mut state, (increment, command));
            if seen.event == Event::NotFollowing && k >= 4 * second {
                noticed = noticed.min(k as f64 * servo.sample_time - 4.0);
            }
        }
        let b = shown(&identifier, &state).b;
        (noticed, (b / servo.parameters.b - 1.0).abs())
    });
    let noticed = per_cent(&runs, |run| run.0 < 2.0);
    let kept = per_cent(&runs, |run| run.1 < 0.01);
    println!(
        "amplifier off for 2 s: noticed {noticed:.1} %, b within 1 % three seconds later {kept:.1} %"
    );
    // The others coasted while the command was at its limit: a load of that size would have the same effect.
    assert!(noticed >= 75.0);
    assert!(kept >= 90.0);
}
