//! Settings of any numbers: built or refused with a sentence; a loop that is built takes a sample.

#![no_main]

use std::sync::LazyLock;

use fuzz::certified;
use identifier_core::Settings;
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{GaussNewtonIdentifier, GradientIdentifier, Identify};
use identifier_core::measurement::LowPass;
use identifier_core::parameters::Unknowns;
use identifier_core::settings::FromSettings;
use libfuzzer_sys::fuzz_target;

type Gradient = GradientIdentifier<f32, LowPass<f32>, Unknowns<4>, 4>;
type GaussNewton = GaussNewtonIdentifier<f64, Unknowns<4>, 4, 32>;
type Fixed = GradientIdentifier<Word, LowPass<Word>, Unknowns<4>, 4>;

fn build<N: Copy, I: Identify<N> + FromSettings>(
    settings: &Settings,
    [increment, command]: [N; 2],
) {
    match settings.build::<I>() {
        Ok(identifier) => {
            let mut state = identifier.start();
            // Either is allowed: a command beyond a declared limit is refused.
            let _ = identifier.learn(&mut state, increment, command);
            let found = identifier.estimates_in(&identifier.snapshot(&state));
            assert!(found.a.is_finite() && found.b.is_finite(), "{found:?}");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// More than settings take.
const MAX_BYTES: usize = 1024;

/// Those of a certified loop as bytes.
static CERTIFIED: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut room = [0; MAX_BYTES];
    let bytes = postcard::to_slice(&certified(), &mut room);
    bytes.expect("there is room").to_vec()
});

fuzz_target!(|changes: &[u8]| {
    // Changes of bits: few of them leave settings that are built, which bytes at random never are.
    let mut bytes = CERTIFIED.clone();
    bytes.resize(bytes.len().max(changes.len()), 0);
    for (byte, change) in bytes.iter_mut().zip(changes) {
        *byte ^= change;
    }
    let Ok(settings) = postcard::from_bytes::<Settings>(&bytes) else {
        return;
    };
    build::<f32, Gradient>(&settings, [1.0, 0.5]);
    build::<f64, GaussNewton>(&settings, [1.0, 0.5]);
    build::<Word, Fixed>(&settings, [Word::ONE, Word::ONE]);
});
