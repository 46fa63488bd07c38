//! From a scenario to an identifier with its state.

use std::marker::PhantomData;

use identifier_core::excitation::Excitation;
use identifier_core::identifier::{
    GaussNewtonIdentifier, GradientIdentifier, IdentifierError, Uncertainty, WindowIdentifier,
};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;

use super::Outcome;
use super::learner::{GaussNewtonLearner, GradientLearner, Learner, WindowLearner};
use crate::scenario::{Law, Scenario, WithSet};

/// Why the parts can be relied on: a [`Scenario`] builds each of them once when it is read.
pub(crate) const CHECKED: &str = "the scenario was checked when it was read";

type Built<N, F> = Result<(Box<dyn Learner<N, F>>, Outcome), IdentifierError>;

/// The identifier of a scenario for a velocity estimate, with what is known of it beforehand.
///
/// # Errors
/// Whatever the core refuses; never for a scenario that was read for a run.
pub(crate) fn learner<N: Number, V: VelocityEstimate<N> + 'static>(
    scenario: &Scenario,
    velocity: V,
    reference: &impl Excitation<f64>,
) -> Built<N, V::State> {
    scenario.identifier.model_set().with(Choose {
        scenario,
        velocity,
        reference,
        number: PhantomData,
    })
}

struct Choose<'a, N, V, E> {
    scenario: &'a Scenario,
    velocity: V,
    reference: &'a E,
    number: PhantomData<N>,
}

impl<N, V, E> WithSet for Choose<'_, N, V, E>
where
    N: Number,
    V: VelocityEstimate<N> + 'static,
    E: Excitation<f64>,
{
    type Output = Built<N, V::State>;

    fn with<S: ParameterSet<P> + 'static, const P: usize, const Q: usize>(
        self,
    ) -> Built<N, V::State> {
        let Self {
            scenario,
            velocity,
            reference,
            ..
        } = self;
        let config = scenario.identifier_config();
        let identifier = &scenario.identifier;
        let mut outcome = Outcome {
            bounds: Some(config.bounds),
            ..Outcome::default()
        };
        let learner: Box<dyn Learner<N, V::State>> = match &identifier.law {
            Law::Gradient(settings) | Law::PdGradient(settings) => {
                let law = scenario.gradient_law::<S, P>(settings, reference)?;
                let built = GradientIdentifier::<N, V, S, P>::new(&config, &law, velocity)?;
                outcome.gamma = Some(law.gamma.entries().iter().map(|row| row.to_vec()).collect());
                outcome.mu = Some(law.mu(&config));
                outcome.certified = built.certificate().is_some();
                outcome.gain_margin = built.gain_margin();
                Box::new(GradientLearner::new(built))
            }
            Law::GaussNewton(uncertainty, settings) => {
                let frozen = identifier.frozen::<S, P>();
                let built = GaussNewtonIdentifier::<N, V, S, P>::new(
                    &config,
                    uncertainty,
                    frozen,
                    velocity,
                )?;
                outcome.certified = built.certificate().is_some();
                outcome.gain_margin = built.gain_margin();
                let window =
                    WindowIdentifier::<N, V, S, P, Q>::new(&config, uncertainty, frozen, velocity)?;
                Box::new(GaussNewtonLearner::new(built, window, *settings))
            }
            Law::Window(settings) => {
                let frozen = identifier.frozen::<S, P>();
                let built = WindowIdentifier::<N, V, S, P, Q>::new(
                    &config,
                    &Uncertainty::UNSTATED,
                    frozen,
                    velocity,
                )?;
                outcome.certified = built.gain_margin().is_some();
                outcome.gain_margin = built.gain_margin();
                Box::new(WindowLearner::new(built, *settings))
            }
            Law::Baseline(baseline, settings) => {
                outcome.bounds = None;
                super::baseline::learner(scenario, *baseline, settings)
            }
        };
        Ok((learner, outcome))
    }
}
