//! The paper's loop in fixed point with bounds on every estimate: under any input, and beside floating point.

use fixed::types::I16F16;
use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller, Setpoint};
use identifier_core::error::StepError;
use identifier_core::fixed_point::{FixedLoop, Word};
use identifier_core::identifier::Identify;
use identifier_core::measurement::LowPass;
use identifier_core::settings::{ControllerSettings, ParameterRangeSettings};
use proptest::prelude::*;

fn settings(sample_time: f64) -> Settings {
    let mut settings = Settings {
        cutoff: 500.0,
        controller: Some(ControllerSettings::pid(9.0, 0.19, 4.0).limited(10.0)),
        ..Settings::new(sample_time, 10_000.0)
    };
    let learning = &mut settings.identifier;
    learning.parameter_range = Some(ParameterRangeSettings {
        a: [0.0, 50.0],
        b: [110.0, 1000.0],
    });
    learning.initial.b = Some(110.0);
    learning.initial.coulomb = Some(1.0);
    learning.bounds.a = Some([0.0, 100.0]);
    learning.bounds.b = Some([5.0, 5000.0]);
    learning.bounds.coulomb = Some([0.0, 100.0]);
    learning.bounds.load = Some([-100.0, 100.0]);
    learning.gamma = Some(gamma([20.0, 1000.0, 100.0]));
    settings
}

fn gamma(diagonal: [f64; 3]) -> [[f64; 4]; 4] {
    let mut gamma = [[0.0; 4]; 4];
    for (i, entry) in diagonal.into_iter().enumerate() {
        gamma[i][i] = entry;
    }
    gamma
}

/// The same with a filter of the reference, s.
fn filtered(reference_filter: f64) -> Settings {
    let mut settings = settings(1e-3);
    let controller = settings.controller.as_mut().expect("it has one");
    controller.reference_filter = reference_filter;
    settings
}

/// None, and time constants from a sample on.
fn reference_filters() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 1e-3_f64..0.3, Just(100.0)]
}

type Words = FixedLoop<3>;

proptest! {
    /// With any sensor readings nothing wraps (the tests check every sum for it), no estimate
    /// leaves its bounds, and the command stays within its limit.
    #[test]
    fn nothing_wraps_with_any_input(
        samples in prop::collection::vec(
            (
                prop_oneof![any::<i32>(), -100_000_i32..100_000],
                any::<i32>(),
                prop_oneof![any::<i32>(), -1_000_i32..1_000],
            ),
            1..200,
        ),
        reference_filter in reference_filters(),
    ) {
        let words: Words = filtered(reference_filter).build().expect("it fits");
        let mut state = words.start(0);
        for (setpoint, offset, count) in samples {
            let offset = I16F16::from_bits(offset);
            match words.process(&mut state, setpoint, offset, count) {
                Ok(step) => {
                    let command = words.controller().command(step.control.command);
                    prop_assert!(command.abs() <= 10.0 + 1e-6);
                }
                Err(error) => prop_assert_eq!(error, StepError::CountJumped),
            }
            let found = words.identifier().estimates(state.identification()).expect("estimates");
            prop_assert!((0.0..=100.0 + 1e-6).contains(&found.a), "{found:?}");
            prop_assert!((5.0 - 1e-4..=5000.0 + 1e-3).contains(&found.b), "{found:?}");
            prop_assert!((0.0..=100.0 + 1e-6).contains(&found.coulomb), "{found:?}");
            prop_assert!(found.load.is_finite());
        }
    }

    /// The words' controller is the numbers' controller.
    #[test]
    fn the_controller_is_that_of_floating_point(
        steps in prop::collection::vec((-2000_i32..2000, -20_i32..20), 1..300),
        reference_filter in reference_filters(),
    ) {
        let settings = filtered(reference_filter);
        let exact: Controller<f64, LowPass<f64>> = settings.build().expect("valid");
        let words: Controller<Word, LowPass<Word>> = settings.build().expect("it fits");
        let mut exact_state = ControlState::default();
        let mut state = words.start();
        let mut count = 0;
        for (setpoint, moved) in steps {
            count += moved;
            let real = exact
                .process(
                    &mut exact_state,
                    Setpoint { count: setpoint, offset: 0.0 }.error(count),
                    f64::from(moved),
                )
                .expect("finite");
            let error = words.error(setpoint, I16F16::ZERO, count);
            let found = words
                .process(&mut state, error, words.increment(moved))
                .expect("slow enough");
            // Each sample rounds the filtered reference by a last bit of the error.
            let last_bit = 9.0 * settings.resolution * 8192.0 / f64::from(1 << 30);
            let remembered = (1e3 * reference_filter).min(300.0);
            let tolerance = 1e-6 + last_bit * remembered;
            prop_assert!((words.command(found.command) - real.command).abs() < tolerance);
            prop_assert!((words.velocity(found.velocity) - real.velocity).abs() < 1e-5);
        }
    }
}
