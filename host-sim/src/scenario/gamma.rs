//! Γ of the gradient estimators: chosen from parameter range and reference, and shown.

use identifier_core::Settings;
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::Word;
use identifier_core::measurement::VelocityEstimate;
use identifier_core::parameters::{ParameterSet, PerParameter, ServoParameters};
use identifier_core::settings::{ParameterRangeSettings, SettingsError};

use identifier_log::log::Log;

use super::dispatch::with_types;
use super::{Arithmetic, Estimator, Scenario};

/// The parameter range around one servo if none is stated: b within a factor of three, a up to three times.
pub(crate) fn range_around(servo: &ServoParameters) -> ParameterRangeSettings {
    const FACTOR: f64 = 3.0;
    ParameterRangeSettings {
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
    const SIMULATED_TIME: f64 = 10.0;
    /// Γ of an estimator without a memory over that of one with it.
    const WITHOUT_MEMORY: f64 = 100.0;

    let samples = (SIMULATED_TIME / scenario.sample_time()).min(Log::MAX_REFERENCES as f64) as u32;
    let gamma = with_types!(scenario, f64 => automatic_gamma(settings, reference, samples))?;
    let factor = match scenario.identifier.law {
        Estimator::Gradient => 1.0,
        _ => WITHOUT_MEMORY,
    };
    settings.identifier.gamma = Some(PerParameter::from_fn(|of| factor * gamma.get(of)));
    if scenario.identifier.arithmetic == Arithmetic::Fixed {
        with_types!(scenario, Word => lower(settings));
    }
    Ok(())
}

/// Other rejections of fixed point come from building the identifier.
fn lower<V, S, const P: usize>(settings: &mut Settings)
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    let _ = settings.lower_gamma::<Word, V, S, P>();
}

fn automatic_gamma<V, S, const P: usize>(
    settings: &Settings,
    reference: &impl Excitation<f64>,
    samples: u32,
) -> Result<PerParameter<f64>, SettingsError>
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
    settings.identifier.gamma.map(|gamma| {
        let entry = |of, beside| if of == beside { gamma.get(of) } else { 0.0 };
        let row = |of| S::PARAMETERS.map(|beside| entry(of, beside)).to_vec();
        S::PARAMETERS.map(row).to_vec()
    })
}
