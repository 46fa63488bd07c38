//! From a scenario to an identifier with its state.

use identifier_core::Settings;
use identifier_core::identifier::{
    GaussNewtonIdentifier, GradientIdentifier, IdentifierError, Identify, WindowIdentifier,
};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;
use identifier_core::settings::FromSettings;

use super::Outcome;
use super::learner::{Beside, Learner};
use crate::scenario::{Law, Scenario, WithTypes, place};

/// Blocks of a window: a PC has the memory for every sample of half a second at 1 kHz.
const WINDOW_BLOCKS: usize = 512;

pub(super) type Built<N> = Result<(Box<dyn Learner<N>>, Outcome), IdentifierError>;

/// The identifier of a scenario, with what is known of it beforehand; the settings are those of
/// [`Scenario::settings_for`].
///
/// # Errors
/// Whatever the core refuses; never for a scenario that was read for a run.
pub(crate) fn learner<N: Number>(scenario: &Scenario, settings: &Settings) -> Built<N> {
    match &scenario.identifier.law {
        Law::Gradient | Law::PdGradient => scenario.with_types(Gradient(settings)),
        Law::GaussNewton => scenario.with_types(GaussNewton(settings)),
        Law::Window => scenario.with_types(Window(settings)),
        Law::Baseline(baseline, own) => Ok((
            super::baseline::learner(scenario, *baseline, own),
            Outcome::default(),
        )),
    }
}

struct Gradient<'a>(&'a Settings);

impl<N: Number> WithTypes<N> for Gradient<'_> {
    type Output = Built<N>;

    fn with<V, S, const P: usize>(self) -> Built<N>
    where
        V: VelocityEstimate<N> + 'static,
        S: ParameterSet<P> + 'static,
    {
        let built: GradientIdentifier<N, V, S, P> = self.0.build()?;
        let outcome = Outcome {
            gamma: self.0.identifier.gamma.map(rows::<S, P>),
            mu: Some(built.mu()),
            certified: built.certificate().is_some(),
            gain_margin: built.gain_margin(),
            ..Outcome::default()
        };
        Ok((Box::new(Beside::new(built)), outcome))
    }
}

/// The rows and columns of a set's parameters in a matrix over all four.
pub(super) fn rows<S: ParameterSet<P>, const P: usize>(matrix: [[f64; 4]; 4]) -> Vec<Vec<f64>> {
    let places = S::PARAMETERS.map(place);
    let row = |i: usize| places.iter().map(|&j| matrix[i][j]).collect();
    places.iter().map(|&i| row(i)).collect()
}

struct GaussNewton<'a>(&'a Settings);

impl<N: Number> WithTypes<N> for GaussNewton<'_> {
    type Output = Built<N>;

    fn with<V, S, const P: usize>(self) -> Built<N>
    where
        V: VelocityEstimate<N> + 'static,
        S: ParameterSet<P> + 'static,
    {
        fitting::<N, GaussNewtonIdentifier<N, S, P>>(self.0)
    }
}

struct Window<'a>(&'a Settings);

impl<N: Number> WithTypes<N> for Window<'_> {
    type Output = Built<N>;

    fn with<V, S, const P: usize>(self) -> Built<N>
    where
        V: VelocityEstimate<N> + 'static,
        S: ParameterSet<P> + 'static,
    {
        fitting::<N, WindowIdentifier<N, S, P, WINDOW_BLOCKS>>(self.0)
    }
}

/// A law that fits: it needs no estimate to begin with, but for a gain that it is not to find.
fn fitting<N, I>(settings: &Settings) -> Built<N>
where
    N: Number,
    I: Identify<N> + FromSettings + 'static,
{
    let given = &settings.identifier;
    if given.known.b && given.initial.b.is_none() {
        return Err(IdentifierError::NotGiven {
            setting: "initial.b",
        });
    }
    let identifier: I = settings.build()?;
    Ok((Box::new(Beside::new(identifier)), Outcome::default()))
}
