//! From a scenario to a controller and an identifier in fixed point.

use identifier_core::fixed_point::{
    FixedAveragedDifference, FixedGradientIdentifier, FixedLowPass, FixedVelocity, Ranges,
};
use identifier_core::identifier::{IdentifierConfig, IdentifierError};
use identifier_core::measurement::velocity::{
    AveragedDifference, BackwardDifference, LowPass, VelocityEstimate,
};
use identifier_core::parameters::ParameterSet;

use super::{GradientSettings, Law, Reference, Scenario, VelocitySettings, WithSet};

/// The parts, and what is known of them beforehand.
pub(crate) struct FixedParts<V, S, const P: usize> {
    pub(crate) identifier: FixedGradientIdentifier<V, S, P>,
    pub(crate) gamma: Vec<Vec<f64>>,
    pub(crate) mu: f64,
}

/// A computation with the parts of a scenario, whatever their types.
pub(crate) trait WithFixed {
    type Output;

    /// Does it: W is the velocity estimate on numbers, V that on words.
    fn with<W, V, S, const P: usize>(
        self,
        parts: FixedParts<V, S, P>,
    ) -> Result<Self::Output, IdentifierError>
    where
        W: VelocityEstimate<f64>,
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static;
}

/// Chooses the types that a scenario asks for.
pub(crate) struct Choose<'a> {
    pub(crate) scenario: &'a Scenario,
}

impl Choose<'_> {
    /// Does a computation with the parts.
    ///
    /// # Errors
    /// Whatever refuses a part.
    pub(crate) fn with<T: WithFixed>(self, work: T) -> Result<T::Output, IdentifierError> {
        let Self { scenario } = self;
        let units = &scenario.controller.units;
        match scenario.controller.velocity {
            VelocitySettings::LowPass(cutoff) => {
                let velocity = LowPass::<f64>::new(units, cutoff)?;
                set::<LowPass<f64>, FixedLowPass, T>(scenario, velocity, work)
            }
            VelocitySettings::Difference => {
                set::<BackwardDifference, BackwardDifference, T>(scenario, BackwardDifference, work)
            }
            VelocitySettings::AveragedDifference => {
                let velocity = AveragedDifference::<f64>::new();
                set::<AveragedDifference<f64>, FixedAveragedDifference, T>(scenario, velocity, work)
            }
        }
    }
}

fn set<W, V, T>(scenario: &Scenario, velocity: W, work: T) -> Result<T::Output, IdentifierError>
where
    W: VelocityEstimate<f64>,
    V: FixedVelocity + for<'a> From<&'a W> + 'static,
    T: WithFixed,
{
    scenario.identifier.model_set().with(Built {
        scenario,
        velocity,
        work,
        words: std::marker::PhantomData::<V>,
    })
}

struct Built<'a, W, V, T> {
    scenario: &'a Scenario,
    velocity: W,
    work: T,
    words: std::marker::PhantomData<V>,
}

impl<W, V, T> WithSet for Built<'_, W, V, T>
where
    W: VelocityEstimate<f64>,
    V: FixedVelocity + for<'a> From<&'a W> + 'static,
    T: WithFixed,
{
    type Output = Result<T::Output, IdentifierError>;

    fn with<S: ParameterSet<P> + 'static, const P: usize, const Q: usize>(self) -> Self::Output {
        let Self {
            scenario,
            velocity,
            work,
            ..
        } = self;
        let config: IdentifierConfig = scenario.identifier_config();
        let default = GradientSettings::default();
        let settings = match &scenario.identifier.law {
            Law::Gradient(settings) | Law::PdGradient(settings) => settings,
            _ => &default,
        };
        let units = &scenario.controller.units;
        let played = Reference::<f64>::new(units, &scenario.excitation)?;
        let law = scenario.gradient_law::<S, P>(settings, &played)?;
        let ranges = scenario
            .identifier
            .ranges
            .unwrap_or_else(|| Ranges::of(&config));
        let identifier = FixedGradientIdentifier::<V, S, P>::new(&config, &law, &ranges, velocity)?;
        work.with::<W, V, S, P>(FixedParts {
            identifier,
            gamma: law.gamma.entries().iter().map(|row| row.to_vec()).collect(),
            mu: law.mu(&config),
        })
    }
}

/// Nothing but the building.
struct Try;

impl WithFixed for Try {
    type Output = ();

    fn with<W, V, S, const P: usize>(self, _: FixedParts<V, S, P>) -> Result<(), IdentifierError>
    where
        W: VelocityEstimate<f64>,
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static,
    {
        Ok(())
    }
}

/// Whether a scenario's parts fit fixed point.
///
/// # Errors
/// What does not, and what would.
pub(crate) fn check(scenario: &Scenario) -> Result<(), IdentifierError> {
    Choose { scenario }.with(Try)
}
