use identifier_core::Settings;
use identifier_core::identifier::{DelayedInputs, GaussNewtonIdentifier, IdentifiableSet};
use identifier_core::number::Number;
use identifier_core::parameters::{Term, Terms, Unknown, UnknownSet};
use identifier_core::settings::SettingsError;

/// A servo with a delay of up to six samples, without a load.
#[derive(Debug, Clone, Copy)]
pub(super) struct LateServo;

impl UnknownSet<4> for LateServo {
    // a and b come first; a load, if there is one, last.
    const UNKNOWNS: [Unknown; 4] = [Unknown::A, Unknown::B, Unknown::Coulomb, Unknown::Delay];
}

impl IdentifiableSet<4> for LateServo {
    // 4 (4 - 1)/2, the lower triangle of the covariance.
    type Lower<N: Number> = [N; 6];
    // The last eight commands are stored.
    type Inputs<N: Number> = DelayedInputs<N, 8>;
}

pub(super) type LateIdentifier = GaussNewtonIdentifier<f32, LateServo, 4>;

pub(super) fn build() -> Result<LateIdentifier, SettingsError> {
    let mut settings = Settings::new(1e-3, 10_000.0);
    settings.identifier.terms.demanded = Terms::NONE.with(Term::Delay);
    settings.build()
}
