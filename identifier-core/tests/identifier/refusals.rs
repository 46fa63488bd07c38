//! Impossible settings are refused by name, with a value that would do, and leave the state unchanged.

use crate::support::certified;
use identifier_core::control::CommandLimit;
use identifier_core::error::StepError;
use identifier_core::identifier::{GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{PerParameter, Unknowns};
use identifier_core::settings::{ControllerSettings, FromSettings, SettingsError};
use identifier_core::units::Units;
use identifier_core::{GaussNewton, GradientLoop, Settings};

type Listener = GradientIdentifier<f32, LowPass<f32>, Unknowns<3>, 3>;

fn valid() -> Settings {
    let mut settings = certified();
    settings.identifier.gamma = Some(PerParameter::new(23.0, 1700.0, 100.0, 0.0));
    settings
}

#[test]
fn every_setting_out_of_range_is_named() {
    fn refusal<T: FromSettings>(change: impl FnOnce(&mut Settings)) -> String {
        let mut settings = valid();
        change(&mut settings);
        let refused = settings.build::<T>().err().expect("refused");
        refused.to_string()
    }
    fn pid(settings: &mut Settings, kp: f64, kd: f64, ki: f64) {
        settings.controller = Some(ControllerSettings::pid(kp, kd, ki));
    }
    fn controller(settings: &mut Settings) -> &mut ControllerSettings {
        settings.controller.as_mut().expect("it has one")
    }
    fn range(settings: &mut Settings, a: [f64; 2], b: [f64; 2]) {
        *settings = settings.with_servo_range(a, b);
    }
    assert!(valid().build::<GradientLoop<f32, 3>>().is_ok());
    assert!(valid().build::<GaussNewton>().is_ok());
    type Change = fn(&mut Settings);
    let of_gradient: [(&str, Change); 29] = [
        // The first thing that is named is the first thing wrong.
        ("sample_time", |s| *s = Settings::new(-1.0, 10_000.0)),
        ("sample_time", |s| s.sample_time = 0.0),
        ("sample_time", |s| s.sample_time = f64::NAN),
        ("resolution", |s| s.resolution = -1.0),
        ("resolution", |s| s.resolution = f64::NAN),
        ("cutoff", |s| s.cutoff = 4000.0),
        ("kp", |s| pid(s, -1.0, 0.19, 4.0)),
        ("kp", |s| s.identifier.correction = Some([0.0, 1.0, 1.0])),
        ("kd", |s| pid(s, 9.0, f64::NAN, 4.0)),
        ("ki", |s| pid(s, 9.0, 0.19, f64::NAN)),
        ("limit_low", |s| controller(s).limit = [1.0, 2.0]),
        ("limit_high", |s| controller(s).limit = [-1.0, 0.0]),
        ("reference_filter", |s| {
            controller(s).reference_filter = 0.02
        }),
        ("notch", |s| controller(s).notch = 300.0),
        ("controller", |s| s.controller = None),
        ("servo_range.b", |s| range(s, [0.0, 1.0], [9.0, 8.0])),
        ("a_min", |s| range(s, [-1.0, 1.0], [110.0, 200.0])),
        ("b_min", |s| range(s, [0.0, 1.0], [0.0, 1.0])),
        ("gamma", |s| {
            s.identifier.gamma = None;
            pid(s, 9.0, 0.19, 4.0);
        }),
        ("gamma.b", |s| {
            s.identifier.gamma = Some(PerParameter::new(1.0, -1.0, 1.0, 0.0))
        }),
        ("mu", |s| s.identifier.mu = Some(0.0)),
        ("mu", |s| s.identifier.mu = Some(10.5)),
        ("bounds.a", |s| s.identifier.bounds.a = Some([0.0, 501.0])),
        ("bounds.b", |s| s.identifier.bounds.b = Some([0.0, 10.0])),
        ("bounds.coulomb", |s| {
            s.identifier.bounds.coulomb = Some([-1.0, 10.0])
        }),
        ("initial.a", |s| s.identifier.initial.a = Some(-1.0)),
        ("initial.b", |s| s.identifier.initial.b = Some(f64::NAN)),
        ("initial.b", |s| {
            s.identifier.initial.b = Some(1.0);
            s.identifier.bounds.b = Some([2.0, 3.0]);
        }),
        ("max_speed", |s| s.identifier.max_speed = Some(-1.0)),
    ];
    for (name, change) in of_gradient {
        let answer = refusal::<GradientLoop<f32, 3>>(change);
        let is_named = answer.starts_with(name) || answer.contains(&format!("has no {name}:"));
        assert!(is_named, "{name}: {answer}");
    }
    assert!(CommandLimit::symmetric(f64::NAN).is_err());
    assert!(Units::new(1e-3, f64::INFINITY).is_err());
    let of_gauss_newton: [(&str, Change); 8] = [
        ("bandwidth", |s| s.identifier.bandwidth = Some(-1.0)),
        ("start_time", |s| s.identifier.start_time = Some(f64::NAN)),
        ("max_speed", |s| s.identifier.max_speed = Some(0.0)),
        ("memory", |s| s.identifier.memory = Some(1e-6)),
        ("noise", |s| s.identifier.noise = Some(0.0)),
        ("uncertainty", |s| s.identifier.uncertainty.a = Some(-1.0)),
        ("bounds.b", |s| s.identifier.bounds.b = Some([-1.0, 5.0])),
        ("initial.b", |s| {
            s.identifier.bounds.b = Some([1.0, 5.0]);
            s.identifier.initial.b = Some(7.0);
        }),
    ];
    for (name, change) in of_gauss_newton {
        let answer = refusal::<GaussNewton>(change);
        assert!(answer.starts_with(name), "{name}: {answer}");
    }
}

#[test]
fn a_listener_needs_no_controller_but_a_range_or_gains() {
    let mut settings = valid();
    settings.controller = None;
    assert!(settings.build::<Listener>().is_ok());
    let refusal = |settings: &Settings| settings.build::<Listener>().expect_err("no").to_string();
    settings.identifier.bandwidth = Some(1e6);
    assert!(refusal(&settings).contains("bandwidth"));
    settings.identifier.parameter_range = None;
    settings.identifier.initial.b = Some(200.0);
    assert!(refusal(&settings).contains("correction"));
    settings.identifier.correction = Some([9.0, 0.19, 4.0]);
    assert!(settings.build::<Listener>().is_ok());
}

#[test]
fn an_estimate_whose_correction_sampling_makes_unstable_is_refused_with_the_bound_that_would_do() {
    let mut settings = valid();
    settings.identifier.bounds.b = Some([5.0, 1e6]);
    let refused = settings.build::<Listener>().expect_err("unstable");
    let SettingsError::Estimate(error) = refused else {
        panic!("{refused}");
    };
    assert!(error.stable >= 1000.0 && error.stable < 1e6, "{error}");
    settings.identifier.bounds.b = Some([5.0, error.stable]);
    assert!(settings.build::<Listener>().is_ok(), "{error}");
}

#[test]
fn default_bounds_do_not_depend_on_the_guess() {
    use identifier_core::parameters::Parameter;
    let bounds = |guess: f64| {
        let mut settings = valid();
        settings.identifier.parameter_range = None;
        settings.identifier.initial.b = Some(guess);
        let built = settings.build::<Listener>().expect("valid");
        let b = built.bounds(Parameter::B).expect("there");
        (b.min(), b.max())
    };
    let (low, high) = bounds(257.7);
    for guess in [50.0, 1000.0] {
        let (other_low, other_high) = bounds(guess);
        assert!((other_low - low).abs() < 1e-12);
        // To the resolution of the search.
        assert!((other_high / high).ln().abs() < 0.1, "{other_high} {high}");
    }
    assert!(low < 1e-3 && high > 1000.0, "{low} {high}");
}

fn impossible_samples_change_nothing<I>(settings: &Settings)
where
    I: FromSettings + Identify<f32, State: PartialEq>,
{
    let identifier: I = settings.build().expect("valid");
    let mut state = identifier.start();
    for k in 0..1000 {
        let command = if k % 100 < 50 { 1.0 } else { -1.0 };
        let seen = identifier.process(&mut state, k % 7, command);
        seen.expect("it can be");
    }
    for (increment, command, error) in [
        (1.0, f32::NAN, StepError::CommandNotFinite),
        (1.0, f32::NEG_INFINITY, StepError::CommandNotFinite),
        (f32::NAN, 0.0, StepError::CountJumped),
        (f32::INFINITY, 0.0, StepError::CountJumped),
        (1e9, 0.0, StepError::CountJumped),
        // 100 rad/s are 159 counts in a sample.
        (161.0, 0.0, StepError::CountJumped),
    ] {
        let before = state.clone();
        assert_eq!(identifier.learn(&mut state, increment, command), Err(error));
        assert!(state == before);
    }
    let before = state.clone();
    let jumped = identifier.process(&mut state, i32::MIN, 0.0);
    assert_eq!(jumped, Err(StepError::CountJumped));
    assert!(state == before);
    assert!(identifier.learn(&mut state, 159.0, 1.0).is_ok());
}

#[test]
fn an_impossible_sample_leaves_the_state_unchanged() {
    let mut settings = valid();
    settings.identifier.max_speed = Some(100.0);
    impossible_samples_change_nothing::<Listener>(&settings);
    impossible_samples_change_nothing::<GaussNewton>(&settings);

    let servo_loop: GradientLoop<f32, 3> = settings.build().expect("valid");
    let mut state = servo_loop.start(0);
    let before = state;
    for (setpoint, offset, count, error) in [
        (0, 0.0, 161, StepError::CountJumped),
        (0, f32::NAN, 0, StepError::ErrorNotFinite),
        (i32::MAX, 0.0, 0, StepError::TooFarApart),
    ] {
        let refused = servo_loop.process(&mut state, setpoint, offset, count);
        assert_eq!(refused.err(), Some(error));
    }
    assert!(state == before);
}
