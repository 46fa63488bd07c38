//! Whatever is fed in: no panic, no NaN, no estimate outside its bounds.

use identifier_core::adaptation::PositiveDefinite;
use identifier_core::control::{CommandLimit, ControlState, Gains};
use identifier_core::error::StepError;
use identifier_core::identifier::{
    Bounds, GaussNewtonIdentifier, GradientIdentifier, GradientLaw, IdentifierConfig,
    IdentifierError, Recorded, Uncertainty, Window, WindowIdentifier,
};
use identifier_core::interval::Interval;
use identifier_core::measurement::velocity::LowPass;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::parameters::{Ab, AbCoulombLoad};
use identifier_core::stability::PlantBox;
use identifier_core::units::Units;
use proptest::prelude::*;

fn config(limit: CommandLimit) -> IdentifierConfig {
    let interval = |min, max| Interval::new("interval", min, max).expect("ordered");
    IdentifierConfig {
        units: Units::new(1e-3, 6e-4).expect("valid"),
        gains: Gains::new(9.0, 0.19, 4.0).expect("valid"),
        limit,
        plant_box: Some(
            PlantBox::new(interval(0.0, 50.0), interval(110.0, 1000.0)).expect("valid"),
        ),
        initial: start(0.0, 50.0),
        bounds: bounds(interval(0.0, 100.0), interval(5.0, 5000.0)),
    }
}

fn start(a: f64, b: f64) -> ServoParameters {
    ServoParameters {
        a,
        b,
        coulomb: 0.0,
        load: 0.0,
    }
}

fn bounds(a: Interval, b: Interval) -> Bounds {
    let interval = |min, max| Interval::new("interval", min, max).expect("ordered");
    Bounds {
        a,
        b,
        coulomb: interval(0.0, 1e4),
        load: interval(-1e4, 1e4),
    }
}

fn law(mu: Option<f64>) -> GradientLaw<2> {
    GradientLaw {
        gamma: PositiveDefinite::new([[20.0, 10.0], [10.0, 3000.0]]).expect("positive definite"),
        mu,
        frozen: [false; 2],
    }
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

fn abuse<N: Number>(limit: CommandLimit, inputs: &[(f64, f64)]) -> Result<(), TestCaseError> {
    let config = config(limit);
    let law = law(None);
    let velocity = LowPass::<N>::new(&config.units, 500.0).expect("valid");
    let controller = config.controller(velocity);
    let identifier =
        GradientIdentifier::<_, _, Ab, 2>::new(&config, &law, velocity).expect("certified");
    let mut control = ControlState::at_rest(N::ZERO);
    let mut state = identifier.start();
    for &(reference, position) in inputs {
        let before = control;
        let (reference, position) = (N::from_f64(reference), N::from_f64(position));
        match controller.process(&mut control, reference, position) {
            Ok(sample) => {
                prop_assert!(sample.command.is_finite());
                prop_assert!(reference.is_finite() && position.is_finite());
                identifier.process(&mut state, &sample);
            }
            Err(error) => {
                prop_assert!(control == before, "a refused sample leaves the state alone");
                match error {
                    StepError::ReferenceNotFinite => prop_assert!(!reference.is_finite()),
                    StepError::PositionNotFinite => prop_assert!(!position.is_finite()),
                    _ => prop_assert!(reference.is_finite() && position.is_finite()),
                }
            }
        }
        let estimates = identifier.estimates(&state);
        prop_assert!((-1e-6..=100.001).contains(&estimates.a), "{estimates:?}");
        prop_assert!((4.999..=5000.1).contains(&estimates.b), "{estimates:?}");
        prop_assert!(estimates.load.is_finite(), "{estimates:?}");
    }
    Ok(())
}

/// The same for the laws that fit: nothing that is not finite comes out of them.
fn abuse_fits<N: Number>(inputs: &[(f64, f64)]) -> Result<(), TestCaseError> {
    let config = config(CommandLimit::symmetric(10.0).expect("valid"));
    let velocity = LowPass::<N>::new(&config.units, 500.0).expect("valid");
    let controller = config.controller(velocity);
    let recursive = GaussNewtonIdentifier::<N, _, AbCoulombLoad, 4>::new(
        &config,
        &Uncertainty::UNSTATED,
        [false; 4],
        velocity,
    )
    .expect("certified");
    let windowed = WindowIdentifier::<N, _, AbCoulombLoad, 4, 6>::new(
        &config,
        &Uncertainty::UNSTATED,
        [false; 4],
        velocity,
    )
    .expect("certified");
    let mut control = ControlState::at_rest(N::ZERO);
    let mut recursive_state = recursive.start();
    let mut window_state = windowed.start();
    let mut window = Window::<N, 40>::empty();
    for &(reference, position) in inputs {
        let given = Recorded {
            reference: N::from_f64(reference),
            position: N::from_f64(position),
            injection: N::ZERO,
        };
        let before = control;
        let Ok(sample) = controller.process(&mut control, given.reference, given.position) else {
            continue;
        };
        recursive.process(&mut recursive_state, &sample);
        windowed.record(&mut window_state, &mut window, &before, given);
        if !windowed.is_fitting(&window_state) {
            windowed.begin(&mut window_state, &window);
        }
        windowed.work(&mut window_state, &window, 100);
        for found in [
            recursive.estimates(&recursive_state),
            recursive.standard_errors(&recursive_state),
            windowed.estimates(&window_state),
            windowed.standard_errors(&window_state),
        ] {
            let ServoParameters {
                a,
                b,
                coulomb,
                load,
            } = found;
            prop_assert!(
                [a, b, coulomb, load].iter().all(|x| x.is_finite()),
                "{found:?}"
            );
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn the_fitting_laws_survive_any_input(
        inputs in prop::collection::vec((any_number(), any_number()), 1..400),
    ) {
        abuse_fits::<f32>(&inputs)?;
        abuse_fits::<f64>(&inputs)?;
    }

    #[test]
    fn single_precision_survives_any_input(
        inputs in prop::collection::vec((any_number(), any_number()), 1..400),
    ) {
        abuse::<f32>(CommandLimit::NONE, &inputs)?;
        abuse::<f32>(CommandLimit::symmetric(1.0).expect("valid"), &inputs)?;
    }

    #[test]
    fn double_precision_survives_any_input(
        inputs in prop::collection::vec((any_number(), any_number()), 1..400),
    ) {
        abuse::<f64>(CommandLimit::NONE, &inputs)?;
        abuse::<f64>(CommandLimit::symmetric(1.0).expect("valid"), &inputs)?;
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
        inputs in prop::collection::vec((any_number(), any_number()), 1..200),
    ) {
        let [t, rho, kp, kd, ki, mu, ga, gb] = exponents;
        let sample_time = 10_f64.powf(-3.0 + 3.0 * t);
        let interval = |min, max| Interval::new("interval", min, max).expect("ordered");
        let config = IdentifierConfig {
            units: Units::new(sample_time, 10_f64.powf(-5.0 + 6.0 * rho)).expect("valid"),
            gains: Gains::new(
                10_f64.powf(9.0 * kp),
                10_f64.powf(9.0 * kd),
                10_f64.powf(9.0 * ki),
            )
            .expect("valid"),
            limit: CommandLimit::NONE,
            plant_box: None,
            initial: start(0.0, 1.0),
            bounds: bounds(interval(0.0, 0.5 / sample_time), interval(1e-6, 1e9)),
        };
        let law = GradientLaw {
            gamma: PositiveDefinite::diagonal([10_f64.powf(9.0 * ga), 10_f64.powf(9.0 * gb)])
                .expect("positive"),
            mu: Some(10_f64.powf(6.0 * mu)),
            frozen: [false; 2],
        };
        let velocity = LowPass::<f32>::new(&config.units, 1.0 / sample_time).expect("valid");
        let controller = config.controller(velocity);
        let Ok(identifier) = GradientIdentifier::<_, _, Ab, 2>::new(&config, &law, velocity) else {
            return Ok(());
        };
        let mut control = ControlState::at_rest(0.0);
        let mut state = identifier.start();
        for (reference, position) in inputs {
            let (reference, position) = (f32::from_f64(reference), f32::from_f64(position));
            if let Ok(sample) = controller.process(&mut control, reference, position) {
                prop_assert!(sample.command.is_finite(), "{sample:?}");
                identifier.process(&mut state, &sample);
            }
            let estimates = identifier.estimates(&state);
            prop_assert!(estimates.a.is_finite() && estimates.b.is_finite(), "{estimates:?}");
            prop_assert!(estimates.load.is_finite(), "{estimates:?}");
        }
    }
}

/// An identifier of arbitrary numbers.
fn build(
    n: &[f64; 16],
    small: &[f64; 4],
) -> Result<GradientIdentifier<f32, LowPass<f32>, Ab, 2>, IdentifierError> {
    let units = Units::new(small[0].min(n[0].abs()), small[1])?;
    let config = IdentifierConfig {
        units,
        gains: Gains::new(n[1], n[2], n[3])?,
        limit: CommandLimit::asymmetric(n[4], n[5])?,
        plant_box: Some(PlantBox::new(
            Interval::new("plant_box.a", n[6], n[7])?,
            Interval::new("plant_box.b", n[8], n[9])?,
        )?),
        initial: start(n[13], n[14]),
        bounds: bounds(
            Interval::new("bounds.a", -n[15], n[15])?,
            Interval::new("bounds.b", small[3], n[15])?,
        ),
    };
    let law = GradientLaw {
        gamma: PositiveDefinite::new([[n[11], small[2]], [small[2], n[12]]])?,
        mu: Some(n[10]),
        frozen: [false; 2],
    };
    let velocity = LowPass::<f32>::new(&units, 1.0 / small[0])?;
    GradientIdentifier::<_, _, Ab, 2>::new(&config, &law, velocity)
}

/// What a broken configuration is refused with.
fn refused(change: impl FnOnce(&mut IdentifierConfig)) -> IdentifierError {
    let mut config = config(CommandLimit::NONE);
    change(&mut config);
    let velocity = LowPass::<f64>::new(&config.units, 500.0).expect("valid");
    GradientIdentifier::<_, _, Ab, 2>::new(&config, &law(None), velocity)
        .expect_err("broken on purpose")
}

/// What a μ is refused with.
fn refused_mu(mu: f64) -> IdentifierError {
    let config = config(CommandLimit::NONE);
    let velocity = LowPass::<f64>::new(&config.units, 500.0).expect("valid");
    GradientIdentifier::<_, _, Ab, 2>::new(&config, &law(Some(mu)), velocity)
        .expect_err("broken on purpose")
}

#[test]
fn every_refusal_names_its_parameter() {
    let interval = |min, max| Interval::new("interval", min, max).expect("ordered");
    let parameter = |error: IdentifierError| match error {
        IdentifierError::Range(range) => range.parameter,
        other => panic!("{other}"),
    };
    assert_eq!(parameter(refused(|c| c.initial.a = -1.0)), "initial.a");
    assert_eq!(parameter(refused(|c| c.initial.b = f64::NAN)), "initial.b");
    assert_eq!(
        parameter(refused(|c| c.bounds.a = interval(0.0, 501.0))),
        "bounds.a"
    );
    assert_eq!(
        parameter(refused(|c| c.bounds.b = interval(0.0, 5000.0))),
        "bounds.b"
    );
    for (name, result) in [
        ("sample_time", Units::new(0.0, 1.0).map(|_| ())),
        ("sample_time", Units::new(f64::NAN, 1.0).map(|_| ())),
        ("position_unit", Units::new(1e-3, f64::INFINITY).map(|_| ())),
        ("kp", Gains::new(0.0, 1.0, 1.0).map(|_| ())),
        ("kd", Gains::new(1.0, -1.0, 1.0).map(|_| ())),
        ("ki", Gains::new(1.0, 1.0, f64::NAN).map(|_| ())),
        ("limit", CommandLimit::symmetric(f64::NAN).map(|_| ())),
        ("limit_low", CommandLimit::asymmetric(0.5, 1.0).map(|_| ())),
        (
            "limit_high",
            CommandLimit::asymmetric(-1.0, 0.0).map(|_| ()),
        ),
        (
            "b_min",
            PlantBox::new(interval(0.0, 1.0), interval(0.0, 1.0)).map(|_| ()),
        ),
        (
            "a_min",
            PlantBox::new(interval(-1.0, 1.0), interval(1.0, 2.0)).map(|_| ()),
        ),
    ] {
        let error = result.expect_err(name);
        assert_eq!(error.parameter, name);
        assert!(error.to_string().contains(name));
    }
    assert!(matches!(refused_mu(10.5), IdentifierError::Certificate(_)));
    assert!(matches!(refused_mu(0.1), IdentifierError::Certificate(_)));
}
