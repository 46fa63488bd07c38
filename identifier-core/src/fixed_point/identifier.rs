use core::marker::PhantomData;

use super::arithmetic::{Sum, Word, value};
use super::controller::{FixedControlSample, FixedController};
use super::gradient::FixedGradient;
use super::model::{FixedModelLoop, FixedModelState, FixedParameters};
use super::ranges::{Ranges, Scales};
use super::travel::FixedTravel;
use super::velocity::FixedVelocity;
use crate::adaptation::GradientUpdate;
use crate::identifier::{GradientIdentifier, GradientLaw, IdentifierConfig, IdentifierError};
use crate::measurement::velocity::VelocityEstimate;
use crate::model::ServoParameters;
use crate::parameters::{Parameter, ParameterSet};
use crate::units::Units;

/// The paper's identifier on words: model loop, Γ-gradient law and load estimate, for the
/// parameter set S.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedGradientIdentifier<V, S, const P: usize> {
    model: FixedModelLoop<V>,
    law: FixedGradient<P>,
    travel: FixedTravel,
    scales: Scales,
    initial: [Sum; P],
    units: Units,
    gain_margin: Option<f64>,
    set: PhantomData<S>,
}

/// What the identifier remembers between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedGradientState<F, const P: usize> {
    model: FixedModelState<F>,
    estimates: [Sum; P],
    load_command: Word,
    travelled: i64,
}

/// What one sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedIdentification {
    /// Output error ε = q − q_e before the update, a fraction of the error's range.
    pub output_error: Word,
    /// What the law did.
    pub update: GradientUpdate,
    /// True when the output error had left its range and the model starts again where the servo
    /// is; the estimates are kept.
    pub restarted: bool,
}

impl<V, S, const P: usize> FixedGradientIdentifier<V, S, P>
where
    V: FixedVelocity,
    S: ParameterSet<P>,
{
    /// Builds the identifier for these ranges and the velocity estimate that the controller uses,
    /// as numbers and as words.
    ///
    /// # Errors
    /// Whatever refuses the identifier on numbers, see [`IdentifierError`]; and the range, gain or
    /// sample time that does not fit words, with what would.
    pub fn new<W>(
        config: &IdentifierConfig,
        law: &GradientLaw<P>,
        ranges: &Ranges,
        velocity: W,
    ) -> Result<Self, IdentifierError>
    where
        W: VelocityEstimate<f64>,
        V: for<'a> From<&'a W>,
    {
        let checked = GradientIdentifier::<f64, W, S, P>::new(config, law, velocity)?;
        let units = config.units;
        let controller = FixedController::new(config, ranges, V::from(&velocity))?;
        let scales = Scales::new(config, ranges)?.with_mu(law.mu(config) * units.rate());
        Ok(Self {
            model: FixedModelLoop::new(controller, &scales),
            law: FixedGradient::new::<S>(config, law, &scales)?,
            travel: FixedTravel::new(&units),
            scales,
            initial: S::PARAMETERS.map(|parameter| {
                let machine = parameter.of(&config.initial) * parameter.scale(&units);
                Sum::of(machine, scales.of(parameter))
            }),
            units,
            gain_margin: checked.gain_margin(),
            set: PhantomData,
        })
    }

    /// The controller that the model loop has, to close the real loop with: the two cannot differ.
    #[inline]
    #[must_use]
    pub fn controller(&self) -> &FixedController<V> {
        &self.model.controller
    }

    /// The gain margin of the sampled loop over the box, where a box was given and certified.
    #[must_use]
    pub fn gain_margin(&self) -> Option<f64> {
        self.gain_margin
    }

    /// The state at the start: the model at rest where the servo is, the estimates at their
    /// initial values.
    #[must_use]
    pub fn start(&self) -> FixedGradientState<V::State, P> {
        FixedGradientState {
            model: FixedModelState::at_rest(),
            estimates: self.initial,
            load_command: Word::ZERO,
            travelled: 0,
        }
    }

    /// One sample, after the controller's.
    #[inline]
    pub fn process(
        &self,
        state: &mut FixedGradientState<V::State, P>,
        real: &FixedControlSample,
    ) -> FixedIdentification {
        let FixedGradientState {
            model,
            estimates,
            load_command,
            travelled,
        } = state;
        self.model.observe(model, real);
        let output_error = self.model.output_error(model);
        let stays = S::HAS_COULOMB && self.travel.stays(travelled, real.counts);
        if stays {
            self.model.stand_beside(model);
        }
        let command = self.model.command(model, real);
        let regressor = self.model.regressor::<S, P>(model, &command);
        let update = if stays {
            GradientUpdate::Held
        } else {
            self.law.update(
                estimates,
                &regressor,
                output_error,
                command.output_error_rate,
            )
        };
        let parameters = FixedParameters::of_set::<S, P>(estimates);
        self.model
            .advance::<S, P>(model, real, &command, &parameters);
        *load_command = command.load;
        FixedIdentification {
            output_error,
            update,
            restarted: self.model.restart_if_lost(model),
        }
    }

    /// The output error of a sample as a number, counts (position units).
    #[must_use]
    pub fn output_error(&self, seen: &FixedIdentification) -> f64 {
        value(seen.output_error, self.scales.position)
    }

    /// The estimates in SI; the load is the part found as a parameter plus b̂ k_i ∫ε.
    #[must_use]
    pub fn estimates(&self, state: &FixedGradientState<V::State, P>) -> ServoParameters {
        let of = |wanted: Parameter| {
            S::PARAMETERS
                .iter()
                .zip(&state.estimates)
                .find(|(parameter, _)| **parameter == wanted)
                .map_or(0.0, |(_, estimate)| {
                    let machine = estimate.value(self.scales.of(wanted));
                    machine / wanted.scale(&self.units)
                })
        };
        ServoParameters {
            a: of(Parameter::A),
            b: of(Parameter::B),
            coulomb: of(Parameter::Coulomb),
            load: of(Parameter::Load),
        }
        .with_load_of(value(state.load_command, self.scales.command))
    }
}
