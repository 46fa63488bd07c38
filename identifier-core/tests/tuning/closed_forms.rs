//! Tuning against closed forms.

use std::f64::consts::TAU;

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::parameters::ServoParameters;
use identifier_core::tuning::{
    AxisForces, Cap, Goal, PredictedResponse, StepMeasure, Tuner, Tuning, TuningError,
    TuningSettings,
};
use virtual_servo::Effects;

use crate::support::{bench_of, identified, step, tuned, worked};

const SERVO: ServoParameters = ServoParameters::new(0.2174, 257.7, 0.0, 0.0);

const KNOWN: [f64; 3] = [0.0; 3];

/// 1 kHz, an ideal sensor, no limit, a step of 0.1 rad.
fn settings(goal: Goal) -> TuningSettings {
    TuningSettings {
        goal,
        ..TuningSettings::new(1e-3, 0.0, f64::INFINITY, 0.1)
    }
}

/// The gains for a servo that is known.
fn gains(settings: &TuningSettings, servo: ServoParameters) -> Tuning {
    let tuning = settings.tune(&identified(servo, 0.0, KNOWN));
    tuning.expect("within reach")
}

#[track_caller]
fn assert_near(found: f64, expected: f64, part: f64) {
    let off = found / expected - 1.0;
    assert!(off.abs() < part, "{found} {expected}");
}

/// The times, over ω, at which a closed form is looked at.
fn grid() -> impl DoubleEndedIterator<Item = f64> {
    (0..400_000).map(|i| f64::from(i) * 1e-4)
}

/// The rise time of a step in closed form.
fn rise_time(shape: impl Fn(f64) -> f64) -> f64 {
    assert!(shape(0.0).abs() < 1e-12, "{}", shape(0.0));
    let reaches = |level: f64| grid().find(|&t| shape(t) >= level).expect("it does");
    reaches(0.9) - reaches(0.1)
}

#[test]
fn the_gains_place_the_poles() {
    let (omega, a) = (20.0_f64, SERVO.a);
    let tuning = gains(&settings(Goal::Bandwidth(omega)), SERVO);
    // s³ + 2ω s² + 2ω² s + ω³ times (s + a)/s, without the second integral.
    assert_near(SERVO.b * tuning.kd, 2.0 * omega, 1e-9);
    assert_near(SERVO.b * tuning.kp, 2.0 * omega * (omega + a), 1e-9);
    assert_near(SERVO.b * tuning.ki, omega.powi(2) * (omega + 2.0 * a), 1e-9);
    assert_near(tuning.reference_filter, 1.5 * tuning.kp / tuning.ki, 1e-9);
}

/// With a far above ω, 2ω s² + 2ω (ω + a) s + ω² (ω + 2a) over a is s² + 2ω s + 2ω² but for the pole at −a: its step through
/// the filter of the reference rises in 2.2/ω, and does not overshoot.
#[test]
fn a_servo_that_damps_itself_steps_as_one_of_second_order() {
    let omega = 5.0;
    let settings = TuningSettings {
        sample_time: 1e-4,
        cutoff: Some(10_000.0),
        ..settings(Goal::Bandwidth(omega))
    };
    let predicted = gains(&settings, ServoParameters { a: 500.0, ..SERVO }).predicted_response;
    // (1 + s)·2/((1 + 1.5 s)(s² + 2s + 2)): the residues at −1/1.5 and −1 ± j.
    let slow = -1.0_f64 / 1.5;
    let of_slow = 2.0 * (1.0 + slow) / (1.5 * slow * (slow * slow + 2.0 * slow + 2.0));
    // At s = −1 + j: 2j/((1 + 1.5 s) s 2j) = 1/((1 + 1.5 s) s).
    let (re, im) = (0.5 - 1.5, -0.5 - 1.5);
    let power = re * re + im * im;
    let rise = rise_time(|t| {
        let pair = (re * t.cos() + im * t.sin()) / power;
        1.0 + of_slow * (slow * t).exp() + 2.0 * pair * (-t).exp()
    });
    assert!((rise - 2.2).abs() < 0.05, "{rise}");
    assert_near(predicted.rise_time * omega, rise, 0.02);
    assert!(predicted.overshoot < 0.01, "{predicted:?}");
}

/// The step of the placement is (1 + 2s)/((1 + 3s)(1 + s)(1 + s + s²)) ÷ s, s over ω, by partial fractions. The response to a
/// unit of load is s/((s² + ω s + ω²)(s + ω)) ÷ s.
#[test]
fn a_slow_loop_has_the_step_and_the_compliance_of_its_placement() {
    // The residues at −1/3, at −1 and at −1/2 ± j √3/2.
    let slow = -1.0 / 3.0;
    let of_slow = (1.0 + 2.0 * slow) / (3.0 * slow * (1.0 + slow) * (1.0 + slow + slow * slow));
    let of_real = -0.5;
    let half = 0.75_f64.sqrt();
    // At s = −1/2 + j h: 1 + 2s = 2jh, s (1 + s) = −1, 2s + 1 = 2jh, and the residue is −1/(1 + 3s).
    let (re, im) = (1.0 - 1.5, 3.0 * half);
    let power = re * re + im * im;
    let (of_re, of_im) = (-re / power, im / power);
    let shape = |t: f64| {
        let pair = of_re * (half * t).cos() - of_im * (half * t).sin();
        1.0 + of_slow * (slow * t).exp() + of_real * (-t).exp() + 2.0 * pair * (-0.5 * t).exp()
    };
    let rise = rise_time(shape);
    assert!((rise - Tuner::RISE).abs() < 3e-4, "{rise}");
    let overshoot = grid().map(shape).fold(0.0, f64::max) - 1.0;
    let settled = grid().rfind(|&t| (shape(t) - 1.0).abs() > 0.02);

    // A cut-off far above the loop, and samples far below.
    let omega = 5.0;
    let settings = TuningSettings {
        cutoff: Some(3000.0),
        ..settings(Goal::Bandwidth(omega))
    };
    let predicted = gains(&settings, ServoParameters { a: 0.0, ..SERVO }).predicted_response;
    assert_near(predicted.rise_time * omega, rise, 0.01);
    let off = predicted.overshoot - overshoot;
    assert!(off.abs() < 0.005, "{predicted:?}");
    let settled = settled.expect("it begins outside");
    assert_near(predicted.settling_time * omega, settled, 0.02);
    // s³/((s² + ω s + ω²)(s + ω)) nowhere exceeds one.
    assert!(predicted.sensitivity < 1.03, "{predicted:?}");

    // 1/((s + 1)(s² + s + 1)) = 1/(s + 1) − s/(s² + s + 1).
    let answer =
        |t: f64| (-t).exp() - (-0.5 * t).exp() * ((half * t).cos() - 0.5 / half * (half * t).sin());
    let largest = grid().map(answer).fold(0.0, f64::max);
    assert_near(predicted.compliance, largest / (omega * omega), 0.01);
}

#[test]
fn a_response_time_is_met() {
    for time in [0.04, 0.1, 0.7] {
        for (coulomb, counts) in [(0.0, f64::INFINITY), (5.0, 10_000.0)] {
            let servo = ServoParameters { coulomb, ..SERVO };
            let settings = TuningSettings {
                resolution: TAU / counts,
                ..settings(Goal::ResponseTime(time))
            };
            let tuning = settings.tune(&identified(servo, 5e-4, KNOWN));
            let tuning = tuning.expect("within reach");
            assert_near(tuning.predicted_response.rise_time, time, 0.02);
            assert_eq!(tuning.cap, None);
        }
    }
}

/// The step that is shown is the one that was measured for the promise.
#[test]
fn the_shown_step_is_the_predicted_one() {
    let settings = TuningSettings {
        resolution: 1e-4,
        ..settings(Goal::Bandwidth(40.0))
    };
    let servo = identified(SERVO, 1e-3, KNOWN);
    let tuner = Tuner::new(&settings, &servo).expect("valid");
    let tuning = settings.tune(&servo).expect("within reach");
    let mut measure = StepMeasure::<f64>::new(settings.step, settings.resolution);
    let step = tuner.step(&tuning).expect("valid");
    for sample in step.take(200) {
        let counts = sample.position / settings.resolution;
        let off = counts - counts.round();
        assert!(off.abs() < 1e-6, "the encoder shows whole counts");
    }
    let until = 25.0 / tuning.bandwidth;
    step.take_while(|sample| sample.time < until)
        .for_each(|sample| measure.take(sample.position));
    let rise = measure.rise().expect("it rises") * settings.sample_time;
    assert_near(rise, tuning.predicted_response.rise_time, 1e-9);
    let settled = f64::from(measure.settled().expect("it settles")) * settings.sample_time;
    assert_near(settled, tuning.predicted_response.settling_time, 1e-9);
}

/// With a known to be 3, k_p and k_i count on it; if a may be 0.3 too, on that alone, or that servo would oscillate.
#[test]
fn uncertain_friction_is_not_relied_on() {
    let servo = ServoParameters { a: 3.0, ..SERVO };
    for (error, least) in [(0.0, 3.0), (0.9, 0.3)] {
        let tuning =
            settings(Goal::Bandwidth(1.5)).tune(&identified(servo, 0.0, [error, 0.0, 0.0]));
        let found = servo.b * tuning.expect("within reach").kp;
        assert!((found - 3.0 * (1.5 + least)).abs() < 1e-9, "{found}");
    }
}

#[test]
fn each_cap_is_named_and_is_the_one_that_helps() {
    type Change = fn(&mut TuningSettings);
    let rows: [(Cap, Change, Change); 4] = [
        (Cap::Delay, |_| {}, |s| s.sample_time = 5e-4),
        (Cap::CommandLimit, |s| s.command = 2.0, |s| s.command = 4.0),
        (
            Cap::EncoderNoise,
            |s| (s.resolution, s.command, s.step) = (TAU / 4096.0, 10.0, 0.02),
            |s| s.resolution /= 2.0,
        ),
        (
            Cap::UnseenResonance,
            |s| s.resonance = Some(300.0),
            |s| s.resonance = Some(400.0),
        ),
    ];
    let [_, limited, ..] = rows.map(|(cap, change, relief)| {
        let mut settings = settings(Goal::Stiffest);
        change(&mut settings);
        let tuning = gains(&settings, SERVO);
        assert_eq!(tuning.cap, Some(cap));
        relief(&mut settings);
        let relieved = gains(&settings, SERVO);
        assert!(relieved.bandwidth > 1.15 * tuning.bandwidth, "{cap}");
        tuning.bandwidth
    });
    // 0.33 ω² step/b = 2, a being small.
    let part = 0.33 * limited * limited * 0.1 / SERVO.b / 2.0;
    assert!((0.97..1.0).contains(&part), "{part}");
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
    let tuning = gains(&settings, SERVO);
    let g = 1.0 - (-0.3_f64).exp();
    let (mut power, mut velocity) = (0.0, 0.0);
    let increments = [1.0, -1.0].into_iter().chain(std::iter::repeat(0.0));
    for (k, increment) in increments.take(1000).enumerate() {
        velocity += g * (increment - velocity);
        let position = if k == 0 { tuning.kp } else { 0.0 };
        power += (position + tuning.kd / 1e-3 * velocity).powi(2);
    }
    let expected = 1e-3 / 12.0_f64.sqrt() * power.sqrt();
    assert_near(tuning.predicted_response.noise, expected, 1e-9);
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
    type Change = fn(&mut TuningSettings, f64);
    let changes: [(&str, Change); 11] = [
        ("sample_time", |s, to| s.sample_time = to),
        ("resolution", |s, to| s.resolution = to),
        ("cutoff", |s, to| s.cutoff = Some(to)),
        ("command", |s, to| s.command = to),
        ("command_delay", |s, to| s.command_delay = to),
        ("response_time", |s, to| s.goal = Goal::ResponseTime(to)),
        ("bandwidth", |s, to| s.goal = Goal::Bandwidth(to)),
        ("max_sensitivity", |s, to| s.max_sensitivity = to),
        ("max_noise", |s, to| s.max_noise = to),
        ("resonance", |s, to| s.resonance = Some(to)),
        ("step", |s, to| s.step = to),
    ];
    let refused = |name: &str, value| {
        let mut bad = good;
        let (_, change) = changes
            .iter()
            .find(|(of, _)| *of == name)
            .expect("a setting");
        change(&mut bad, value);
        let Err(TuningError::OutOfRange(refused)) = Tuner::new(&bad, &servo) else {
            panic!("{name}");
        };
        refused
    };
    for (name, _) in changes {
        for value in [f64::NAN, -1.0] {
            assert_eq!(refused(name, value).parameter, name);
        }
    }
    for (name, value) in [
        ("sample_time", 0.0),
        ("command", 0.0),
        ("response_time", 0.0),
        ("bandwidth", f64::INFINITY),
        ("max_noise", 0.0),
        ("resonance", 0.0),
    ] {
        assert_eq!(refused(name, value).parameter, name);
    }
    // Those of every door: the command line, Python and C have them too.
    for sentence in include_str!("refusals.txt").lines() {
        let (name, rest) = sentence.split_once(" = ").expect("a value");
        let value = rest.split(' ').next().expect("a word").parse();
        assert_eq!(
            refused(name, value.expect("a number")).to_string(),
            sentence
        );
    }
    let few = OutOfRange {
        parameter: "step",
        value: 0.009,
        allowed: Allowed::AtLeast(0.01),
    };
    assert_eq!(refused("step", 0.009), few);
}

#[test]
fn a_servo_with_large_standard_errors_gets_no_gains() {
    let goal = settings(Goal::Stiffest);
    let of_b = |error: f64| tuned(&goal, &identified(SERVO, 0.0, [0.0, error * SERVO.b, 0.0])).0;
    assert!(of_b(0.01).is_ok());
    assert_eq!(of_b(0.4), Err(TuningError::NotKnown));
    let nothing = identified(ServoParameters { b: 0.0, ..SERVO }, 0.0, KNOWN);
    assert_eq!(goal.tune(&nothing), Err(TuningError::NotKnown));
}

/// The integral of the step grows to the friction's command, k_i · step · (t − T_r) + k_p · step = c/b, within 25/ω where
/// 24.4 ω² > c/step.
#[test]
fn a_step_that_friction_stops_is_not_predicted() {
    let rubbing = ServoParameters::new(SERVO.a, SERVO.b, 10.0, 0.0);
    let servo = identified(rubbing, 0.0, KNOWN);
    let step = |bandwidth| settings(Goal::Bandwidth(bandwidth)).tune(&servo);
    assert_eq!(step(1.8), Err(TuningError::DoesNotArrive));
    // After a motion against it, twice the friction's command is to be gathered.
    let slowest = |bandwidth| {
        let predicted = step(bandwidth).expect("it arrives").predicted_response;
        predicted.slowest_rise_time * bandwidth
    };
    assert!(slowest(2.5) > 0.99 * PredictedResponse::MAX_TIME);
    assert!(slowest(3.5) < 0.9 * PredictedResponse::MAX_TIME);
}

/// The gains of a bandwidth for an axis with forces beside its servo.
fn beside(forces: AxisForces, bandwidth: f64) -> Result<Tuning, TuningError> {
    let tuner = Tuner::new(
        &settings(Goal::Bandwidth(bandwidth)),
        &identified(STICKING, 0.0, KNOWN),
    )?;
    worked(&tuner.with_forces(forces)).0
}

const STICKING: ServoParameters = ServoParameters::new(1.5, 257.7, 30.0, 0.0);

/// The predicted rise is that of a loop around an exact servo with the same forces, and not that without.
#[test]
fn a_predicted_step_has_the_slope_of_gravity_and_friction_at_rest() {
    let goal = settings(Goal::Bandwidth(40.0));
    for (slope, low_speed) in [(600.0, 0.0), (-600.0, 0.0), (0.0, 60.0)] {
        let forces = AxisForces {
            wave: [slope, 0.0],
            order: 1.0,
            low_speed,
            per_low_speed_velocity: 1.0 / 0.5,
            ..AxisForces::default()
        };
        let tuning = beside(forces, 40.0).expect("it is faster than the slope");
        let effects = Effects {
            gravity: [slope, 0.0],
            low_speed_friction: low_speed,
            low_speed_velocity: if low_speed > 0.0 { 0.5 } else { 0.0 },
            ..Effects::NONE
        };
        let moved = |effects| {
            let bench = bench_of(&tuning, &goal, &STICKING, effects, 0.0);
            step(bench, &goal, 1.0).rise().expect("it rises") * goal.sample_time
        };
        let [with, without] = [&effects, &Effects::NONE].map(moved);
        let predicted = tuning.predicted_response.rise_time;
        println!("{predicted} {with} {without}");
        assert!((predicted / with - 1.0).abs() < 0.02, "{predicted} {with}");
        assert!((predicted / without - 1.0).abs() > 0.03, "{predicted}");
    }
}

#[test]
fn gains_that_are_slower_than_gravity_are_refused() {
    let with = |slope| AxisForces {
        wave: [slope, 0.0],
        order: 1.0,
        ..AxisForces::default()
    };
    // The gains' own stiffness is 2ω (ω + a), 495 1/s².
    assert!(beside(with(200.0), 15.0).is_ok());
    assert_eq!(beside(with(450.0), 15.0), Err(TuningError::DoesNotArrive));
}

/// The overshoots and rises of a loop around an exact servo, with forces that the axis may have.
fn overshoots_and_rises(tuning: &Tuning, effects: &[Effects]) -> Vec<[f64; 2]> {
    let goal = settings(Goal::Bandwidth(40.0));
    let moved = |effects| {
        let bench = bench_of(tuning, &goal, &STICKING, effects, 0.0);
        let step = step(bench, &goal, 1.0);
        let rise = step.rise().expect("it rises") * goal.sample_time;
        [step.overshoot(), rise]
    };
    effects.iter().map(moved).collect()
}

/// Friction at rest of any size and speed up to the most that there may be.
#[test]
fn the_prediction_bounds_what_friction_at_rest_may_do() {
    let most = 45.0;
    let with = |most_low_speed| {
        let forces = AxisForces {
            most_low_speed,
            ..AxisForces::default()
        };
        beside(forces, 40.0).expect("gains").predicted_response
    };
    let effects: Vec<Effects> = [(0.4, 0.05), (0.7, 0.2), (1.0, 0.05), (1.0, 0.5)]
        .map(|(part, speed)| Effects {
            low_speed_friction: part * most,
            low_speed_velocity: speed,
            ..Effects::NONE
        })
        .to_vec();
    let [plain, bounds] = [0.0, most].map(with);
    let tuning = beside(AxisForces::default(), 40.0).expect("gains");
    let steps = overshoots_and_rises(&tuning, &effects);
    println!("{plain:?} {bounds:?} {steps:?}");
    for [overshoot, rise] in &steps {
        assert!(*overshoot <= bounds.overshoot + 0.01, "{overshoot}");
        assert!(*rise >= 0.97 * bounds.quickest_rise_time, "{rise}");
    }
    assert!(
        steps
            .iter()
            .any(|[overshoot, _]| *overshoot > plain.overshoot + 0.01)
    );
}

/// Friction at rest stops it beyond its place, until the integral moves it on and farther beyond on the other side.
#[test]
fn the_predicted_overshoot_is_that_of_an_axis_that_hunts() {
    let (low_speed, speed) = (90.0, 0.3);
    let forces = AxisForces {
        low_speed,
        per_low_speed_velocity: 1.0 / speed,
        ..AxisForces::default()
    };
    let goal = settings(Goal::Bandwidth(30.0));
    let tuning = beside(forces, 30.0).expect("gains");
    let effects = Effects {
        low_speed_friction: low_speed,
        low_speed_velocity: speed,
        ..Effects::NONE
    };
    let overshoot = |times| {
        let bench = bench_of(&tuning, &goal, &STICKING, &effects, 0.0);
        step(bench, &goal, times * PredictedResponse::MAX_TIME / 30.0).overshoot()
    };
    let predicted = tuning.predicted_response.overshoot;
    let [first, hunting] = [1.0, 4.0].map(overshoot);
    println!("{predicted} {first} {hunting}");
    assert!((predicted - hunting).abs() < 0.02 && hunting > first + 0.05);
}

/// A step from any place of the waves is within the bounds, and one of them is not within those of the first place.
#[test]
fn the_prediction_of_cogging_is_that_from_all_places_of_its_waves() {
    let (force, order) = (25.0, 60);
    let forces = AxisForces {
        wave: [force, 0.0],
        order: f64::from(order),
        ..AxisForces::default()
    };
    let tuning = beside(forces, 40.0).expect("gains");
    let predicted = tuning.predicted_response;
    let effects: Vec<Effects> = (0..8)
        .map(|place| {
            let phase = f64::from(place) * TAU / 8.0;
            Effects {
                ripple: [force * phase.cos(), force * phase.sin()],
                ripple_order: order,
                ..Effects::NONE
            }
        })
        .collect();
    let steps = overshoots_and_rises(&tuning, &effects);
    println!("{predicted:?} {steps:?}");
    for [overshoot, rise] in &steps {
        assert!(*overshoot <= predicted.overshoot + 0.03, "{overshoot}");
        let rises = 0.85 * predicted.quickest_rise_time..1.15 * predicted.slowest_rise_time;
        assert!(rises.contains(rise), "{rise}");
    }
    let rises = |one: &[f64; 2]| (one[1] / predicted.rise_time - 1.0).abs() > 0.05;
    assert!(steps.iter().any(rises));
}
