//! Settings of any numbers: built or refused with a sentence; a loop that is built takes a sample.

#![no_main]

use identifier_core::Settings;
use identifier_core::fixed_point::{FixedGradientIdentifier, Word};
use identifier_core::identifier::{GaussNewtonIdentifier, GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::AbCoulombLoad;
use identifier_core::settings::FromSettings;
use libfuzzer_sys::fuzz_target;

type Gradient = GradientIdentifier<f32, LowPass<f32>, AbCoulombLoad, 4>;
type GaussNewton = GaussNewtonIdentifier<f64, AbCoulombLoad, 4, 32>;
type Fixed = FixedGradientIdentifier<LowPass<Word>, AbCoulombLoad, 4>;

fn build<N: Copy, I: Identify<N> + FromSettings>(
    settings: &Settings,
    [increment, command]: [N; 2],
) {
    match settings.build::<I>() {
        Ok(identifier) => {
            let mut state = identifier.start();
            // Either is allowed: a command beyond a declared limit is refused.
            let _ = identifier.learn(&mut state, increment, command);
            let found = identifier.estimates(&state);
            assert!(found.a.is_finite() && found.b.is_finite(), "{found:?}");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Ok(settings) = postcard::from_bytes::<Settings>(bytes) else {
        return;
    };
    build::<f32, Gradient>(&settings, [1.0, 0.5]);
    build::<f64, GaussNewton>(&settings, [1.0, 0.5]);
    build::<Word, Fixed>(&settings, [Word::ONE, Word::ONE]);
});
