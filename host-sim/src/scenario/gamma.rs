//! Γ of the gradient estimators: chosen from parameter range and reference, and shown.

use identifier_core::Settings;
use identifier_core::error::Allowed;
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::Word;
use identifier_core::identifier::GradientIdentifier;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::parameters::{ParameterSet, ServoParameters};
use identifier_core::settings::{BoxSettings, SettingsError};

use super::dispatch::{with_types, with_words};
use super::reference::MAX_PLAYED;
use super::{Arithmetic, Scenario};

/// The parameter range around one servo if none is stated: b within a factor of three, a up to three times.
#[must_use]
pub(crate) fn box_around(servo: &ServoParameters) -> BoxSettings {
    const FACTOR: f64 = 3.0;
    BoxSettings {
        a: [0.0, FACTOR * servo.a],
        b: [servo.b / FACTOR, FACTOR * servo.b],
    }
}

/// Chooses Γ over all four parameters; one for a parameter that the model does not have.
pub(super) fn choose(
    scenario: &Scenario,
    settings: &mut Settings,
    reference: &impl Excitation<f64>,
) -> Result<(), SettingsError> {
    /// Time for which the reference is played, s.
    const PLAYED_TIME: f64 = 10.0;

    let samples = (PLAYED_TIME / scenario.sample_time()).min(MAX_PLAYED as f64) as u32;
    let gamma = with_types!(scenario, f64 => automatic_gamma(settings, reference, samples))?;
    settings.identifier.gamma = Some(gamma);
    if scenario.identifier.arithmetic == Arithmetic::Fixed {
        with_words!(scenario => slow_to_fixed_range(settings));
    }
    Ok(())
}

/// Reduces a chosen Γ to the range of fixed point, by one factor: it adapts more slowly. Other rejections of fixed
/// point come from building the identifier.
fn slow_to_fixed_range<V, S, const P: usize>(settings: &mut Settings)
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    // Each parameter has a bound, and all of them have one together.
    for _ in 0..=P {
        let built = settings.build::<GradientIdentifier<Word, V, S, P>>();
        let (Err(SettingsError::Range(refused)), Some(gamma)) =
            (built, &mut settings.identifier.gamma)
        else {
            return;
        };
        let (Allowed::PositiveUpTo(most), "gamma") = (refused.allowed, refused.parameter) else {
            return;
        };
        let factor = most / refused.value;
        for entry in gamma.iter_mut().flatten() {
            *entry *= factor;
        }
    }
}

fn automatic_gamma<V, S, const P: usize>(
    settings: &Settings,
    reference: &impl Excitation<f64>,
    samples: u32,
) -> Result<[[f64; 4]; 4], SettingsError>
where
    V: VelocityEstimate<f64>,
    S: ParameterSet<P>,
{
    settings.automatic_gamma::<V, S, P>(reference, samples)
}

/// Γ over the parameters of a set, SI.
pub(crate) fn gamma_over<S: ParameterSet<P>, const P: usize>(
    settings: &Settings,
) -> Option<Vec<Vec<f64>>> {
    let places = S::PARAMETERS.map(|parameter| parameter as usize);
    settings.identifier.gamma.map(|gamma| {
        let row = |i: usize| places.iter().map(|&j| gamma[i][j]).collect();
        places.iter().map(|&i| row(i)).collect()
    })
}
