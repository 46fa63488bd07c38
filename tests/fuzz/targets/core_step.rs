//! Samples of any numbers: estimates are finite and within their bounds, a refused sample leaves the state alone.

#![no_main]

use std::sync::LazyLock;

use arbitrary::Arbitrary;
use fuzz::certified;
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{GaussNewtonIdentifier, GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::{ServoParameters, Unknowns};
use identifier_core::settings::FromSettings;
use libfuzzer_sys::fuzz_target;

/// Most samples of an execution.
const MAX_SAMPLES: usize = 64;

/// Passes of the work between two samples, so that fits are in it.
const WORK: u32 = 100;

type Gradient = GradientIdentifier<f32, LowPass<f32>, Unknowns<4>, 4>;
type GaussNewton = GaussNewtonIdentifier<f32, Unknowns<4>, 4, 32>;
type Fixed = GradientIdentifier<Word, LowPass<Word>, Unknowns<4>, 4>;

#[derive(Debug, Arbitrary)]
enum Estimator {
    Gradient,
    GaussNewton,
    Fixed,
}

#[derive(Debug, Arbitrary)]
struct Samples {
    law: Estimator,
    /// Increment, position units, and command.
    samples: Vec<[f32; 2]>,
}

fn built<T: FromSettings>() -> T {
    let built = certified().build();
    built.unwrap_or_else(|error| panic!("the settings are sound: {error}"))
}

fn is_finite(found: ServoParameters) -> bool {
    let ServoParameters {
        a,
        b,
        coulomb,
        load,
    } = found;
    [a, b, coulomb, load].iter().all(|value| value.is_finite())
}

fn run<N: Copy, I: Identify<N>>(identifier: &I, samples: &[[f32; 2]], number: impl Fn(f32) -> N) {
    let mut state = identifier.start();
    for &[increment, command] in samples {
        let before = identifier.estimates_in(&identifier.snapshot(&state));
        let learnt = identifier.learn(&mut state, number(increment), number(command));
        if learnt.is_err() {
            assert_eq!(
                identifier.estimates_in(&identifier.snapshot(&state)),
                before,
                "a refused sample changed the estimates"
            );
        }
        identifier.work(&mut state, WORK);
        let found = identifier.estimates_in(&identifier.snapshot(&state));
        assert!(is_finite(found), "{found:?}");
        assert!(
            (-1e-3..=100.1).contains(&found.a) && (4.99..=5000.1).contains(&found.b),
            "{found:?}"
        );
        if let Some(errors) = identifier.report(&state).errors_of_parameters() {
            assert!(is_finite(errors), "{errors:?}");
        }
    }
}

static GRADIENT: LazyLock<Gradient> = LazyLock::new(built);
static GAUSS_NEWTON: LazyLock<GaussNewton> = LazyLock::new(built);
static FIXED: LazyLock<Fixed> = LazyLock::new(built);

fuzz_target!(|input: Samples| {
    let samples = &input.samples[..input.samples.len().min(MAX_SAMPLES)];
    match input.law {
        Estimator::Gradient => run(&*GRADIENT, samples, |number| number),
        Estimator::GaussNewton => run(&*GAUSS_NEWTON, samples, |number| number),
        Estimator::Fixed => run(&*FIXED, samples, |number| {
            Word::from_bits(number.to_bits().cast_signed())
        }),
    }
});
