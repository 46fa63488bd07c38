//! Under any input: no panic, no NaN, no estimate outside its bounds.

use crate::support::{certified, learn_as_the_paper, shown};
use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::error::StepError;
use identifier_core::identifier::{GaussNewtonIdentifier, GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, PerParameter, ServoParameters, Unknowns};
use identifier_core::settings::{ControllerSettings, FromSettings, SettingsError};
use proptest::prelude::*;

type Identifier<N> = GradientIdentifier<N, LowPass<N>, Unknowns<2>, 2>;

/// A loop that is certified.
fn settings(limit: Option<f64>) -> Settings {
    let mut settings = Settings {
        resolution: 6e-4,
        ..certified()
    };
    let controller = settings.controller.as_mut().expect("it has one");
    *controller = controller.limited(limit.unwrap_or(f64::INFINITY));
    learn_as_the_paper(&mut settings);
    let learning = &mut settings.identifier;
    learning.initial.a = Some(0.0);
    learning.mu = None;
    learning.gamma = Some(gamma(20.0, 3000.0));
    settings
}

fn gamma(a: f64, b: f64) -> PerParameter<f64> {
    PerParameter::new(a, b, 0.0, 0.0)
}

/// Numbers of every kind, finite and not.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1e4_f64..1e4,
        1 => -1e38_f64..1e38,
        1 => any::<f64>(),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
    ]
}

/// Any sample: ordinary ones, huge ones, and those that are no numbers.
fn any_sample() -> impl Strategy<Value = (f64, f64)> {
    let increment =
        prop_oneof![8 => (-50_i32..50).prop_map(f64::from), 1 => -1.6e7..1.6e7, 1 => any_number()];
    let command = prop_oneof![8 => -10.0..10.0, 1 => -1e7..1e7, 1 => any_number()];
    (increment, command)
}

fn is_within_reach<N: Number>(number: N) -> bool {
    number.magnitude() <= N::REACH
}

fn abuse<N: Number>(limit: Option<f64>, inputs: &[(f64, f64)]) -> Result<(), TestCaseError> {
    let settings = settings(limit);
    let controller: Controller<N, LowPass<N>> = settings.build().expect("valid");
    let identifier: Identifier<N> = settings.build().expect("certified");
    let mut control = ControlState::default();
    let mut state = identifier.start();
    for &(error, increment) in inputs {
        let before = control;
        let (error, increment) = (N::from_f64(error), N::from_f64(increment));
        match controller.process(&mut control, error, increment) {
            Ok(sample) => {
                prop_assert!(sample.command.is_finite());
                prop_assert!(error.is_finite() && increment.is_finite());
                let learnt = identifier.learn(&mut state, sample.increment, sample.command);
                prop_assert!(
                    learnt.is_ok(),
                    "the identifier takes what the controller takes"
                );
            }
            Err(refused) => {
                prop_assert!(control == before, "a refused sample leaves the state alone");
                let is_right = match refused {
                    StepError::ErrorNotFinite => !error.is_finite(),
                    StepError::TooFarApart => error.is_finite(),
                    StepError::CountJumped => !is_within_reach(increment),
                    _ => false,
                };
                prop_assert!(is_right, "{refused}");
            }
        }
        assert_within(&identifier, &state)?;
    }
    Ok(())
}

/// The same for an identifier that listens to the commands of another controller.
fn mislead<N: Number>(inputs: &[(f64, f64)]) -> Result<(), TestCaseError> {
    let identifier: Identifier<N> = settings(None).build().expect("certified");
    let mut state = identifier.start();
    for &(increment, command) in inputs {
        let (increment, command) = (N::from_f64(increment), N::from_f64(command));
        let before = state;
        match identifier.learn(&mut state, increment, command) {
            Ok(_) => prop_assert!(increment.is_finite() && command.is_finite()),
            Err(refused) => {
                prop_assert!(state == before, "a refused sample leaves the state alone");
                let is_right = match refused {
                    StepError::CommandNotFinite => !is_within_reach(command),
                    StepError::CountJumped => !is_within_reach(increment),
                    _ => false,
                };
                prop_assert!(is_right, "{refused}");
            }
        }
        assert_within(&identifier, &state)?;
    }
    Ok(())
}

/// The same for a law that fits, whose work takes turns with the samples: nothing that is not finite
/// comes out of it.
fn mislead_fit<N, I>(
    settings: &Settings,
    inputs: &[(f64, f64)],
    is_free: bool,
) -> Result<(), TestCaseError>
where
    N: Number,
    I: Identify<N, State: PartialEq> + FromSettings,
{
    let identifier: I = settings.build().expect("valid");
    let mut state = identifier.start();
    for (k, &(increment, command)) in inputs.iter().enumerate() {
        let before = state.clone();
        // A motion that follows the command every other while, so that fits are found, or never.
        let follows = !is_free && k / 200 % 2 == 0;
        let increment = if follows {
            (3.0 * command).round()
        } else {
            increment
        };
        match identifier.learn(&mut state, N::from_f64(increment), N::from_f64(command)) {
            Ok(seen) => prop_assert!(seen.output_error.is_finite()),
            Err(_) => {
                // A trial of a fit may have diverged to NaN, which equals nothing.
                let untouched = state == before || format!("{state:?}") == format!("{before:?}");
                prop_assert!(untouched, "a refused sample leaves the state alone");
            }
        }
        identifier.work(&mut state, 100);
        let finite = |found: ServoParameters| {
            let mut all = Parameter::ALL.iter();
            all.all(|of| found.get(*of).is_finite())
        };
        let found = shown(&identifier, &state);
        let errors = identifier.report(&state).errors_of_parameters();
        prop_assert!(finite(found), "{found:?}");
        prop_assert!(errors.is_none_or(finite), "{errors:?}");
    }
    Ok(())
}

/// Estimates within the bounds of [`settings`], and finite.
fn assert_within<N: Number>(
    identifier: &Identifier<N>,
    state: &<Identifier<N> as Identify<N>>::State,
) -> Result<(), TestCaseError> {
    let estimates = identifier.estimates_in(&identifier.snapshot(state));
    prop_assert!((-1e-6..=100.001).contains(&estimates.a), "{estimates:?}");
    prop_assert!((4.999..=5000.1).contains(&estimates.b), "{estimates:?}");
    prop_assert!(estimates.load.is_finite(), "{estimates:?}");
    Ok(())
}

proptest! {
    #[test]
    fn the_fitting_estimators_survive_any_input(
        samples in prop_oneof![
            3 => prop::collection::vec(any_sample(), 1..1500),
            1 => prop::collection::vec((any_number(), any_number()), 1..1500),
        ],
        is_free: bool,
        start_time in 0.032_f64..0.5,
        guess in prop::option::of(5.0_f64..5e3),
        is_guided: bool,
    ) {
        let mut settings = if is_guided { settings(None) } else { Settings::new(1e-3, 6283.0) };
        settings.identifier.start_time = Some(start_time);
        settings.identifier.initial.b = guess;
        mislead_fit::<f32, GaussNewtonIdentifier<f32, Unknowns<4>, 4, 32>>(&settings, &samples, is_free)?;
        mislead_fit::<f64, GaussNewtonIdentifier<f64, Unknowns<4>, 4, 32>>(&settings, &samples, is_free)?;
    }
}

proptest! {
    #[test]
    fn the_gradient_estimator_survives_any_input(
        inputs in prop::collection::vec((any_number(), any_number()), 1..400),
    ) {
        for limit in [None, Some(1.0)] {
            abuse::<f32>(limit, &inputs)?;
            abuse::<f64>(limit, &inputs)?;
        }
        mislead::<f32>(&inputs)?;
        mislead::<f64>(&inputs)?;
    }

    #[test]
    fn no_configuration_panics(
        numbers in prop::array::uniform16(any_number()),
        small in prop::array::uniform4(1e-5_f64..1.0),
    ) {
        let built = build(&numbers, &small);
        if let Err(error) = built {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}

proptest! {
    #[test]
    fn single_precision_survives_any_allowed_configuration(
        exponents in prop::array::uniform8(-1.0_f64..1.0),
        bounded: bool,
        inputs in prop::collection::vec((any_number(), any_number()), 1..200),
    ) {
        let [t, rho, kp, kd, ki, mu, ga, gb] = exponents;
        let sample_time = 10_f64.powf(-3.0 + 3.0 * t);
        let mut settings = Settings {
            resolution: 10_f64.powf(-5.0 + 6.0 * rho),
            cutoff: 1.0 / sample_time,
            controller: Some(ControllerSettings::pid(
                10_f64.powf(9.0 * kp),
                10_f64.powf(9.0 * kd),
                10_f64.powf(9.0 * ki),
            )),
            ..Settings::new(sample_time, 1.0)
        };
        let learning = &mut settings.identifier;
        learning.initial.b = Some(1.0);
        learning.bounds.a = Some([0.0, 0.5 / sample_time]);
        learning.bounds.b = bounded.then_some([1e-6, 1e9]);
        learning.gamma = Some(gamma(10_f64.powf(9.0 * ga), 10_f64.powf(9.0 * gb)));
        learning.mu = Some(10_f64.powf(6.0 * mu));
        let controller: Controller<f32, LowPass<f32>> = settings.build().expect("in range");
        let Ok(identifier) = settings.build::<Identifier<f32>>() else {
            return Ok(());
        };
        let mut control = ControlState::default();
        let mut state = identifier.start();
        for (error, increment) in inputs {
            let (error, increment) = (f32::from_f64(error), f32::from_f64(increment));
            if let Ok(sample) = controller.process(&mut control, error, increment) {
                prop_assert!(sample.command.is_finite(), "{sample:?}");
                identifier.update(&mut state, sample.increment, sample.command);
            }
            let estimates = shown(&identifier, &state);
            prop_assert!(estimates.a.is_finite() && estimates.b.is_finite(), "{estimates:?}");
            prop_assert!(estimates.load.is_finite(), "{estimates:?}");
        }
    }
}

/// An identifier of arbitrary numbers.
fn build(n: &[f64; 16], small: &[f64; 4]) -> Result<Identifier<f32>, SettingsError> {
    let mut settings = Settings {
        sample_time: small[0].min(n[0].abs()),
        resolution: small[1],
        cutoff: 1.0 / small[0],
        controller: Some(ControllerSettings {
            limit: [n[4], n[5]],
            ..ControllerSettings::pid(n[1], n[2], n[3])
        }),
        ..Settings::new(1e-3, 1.0)
    }
    .with_servo_range([n[6], n[7]], [n[8], n[9]]);
    let learning = &mut settings.identifier;
    learning.initial.a = Some(n[13]);
    learning.initial.b = Some(n[14]);
    learning.bounds.a = Some([-n[15], n[15]]);
    learning.bounds.b = Some([small[3], n[15]]);
    learning.gamma = Some(gamma(n[11], n[12]));
    learning.mu = Some(n[10]);
    settings.build()
}
