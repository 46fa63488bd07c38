use core::marker::PhantomData;

use super::arithmetic::{Sum, Word, limit, limit_to_half, power, product, value, word};
use super::controller::IncrementWord;
use super::gradient::FixedGradient;
use super::model::{FixedModelLoop, FixedModelState, FixedObserved, FixedParameters};
use super::ranges::{FullScales, bounds};
use super::rest::{FixedRest, FixedRestState};
use crate::constants::{Encode, encode};
use crate::error::{Allowed, OutOfRange, StepError};
use crate::identifier::{Event, Identify, MachineEstimates, Update};
use crate::interval::Interval;
use crate::measurement::velocity::VelocityEstimate;
use crate::parameters::{Parameter, ParameterSet, PerParameter, ServoParameters, set_fingerprint};
use crate::settings::{FromSettings, GradientPlan, Settings, SettingsError};
use crate::stability::{Certificate, StabilityCheck};
use crate::units::Units;

/// The paper's identifier on words, for the parameter set S. It has the model loop, the Γ-gradient estimator with a
/// diagonal Γ, and the load estimate. On numbers it is [`GradientIdentifier`](crate::identifier::GradientIdentifier).
///
/// It listens to any controller. Increments and commands are [`Word`]s, fractions of full scales that follow from the
/// settings. [`Identify::increment`] converts counts, [`FixedGradientIdentifier::command_word`] command units. A
/// [`FixedController`](super::FixedController) built from the same settings has the same words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedGradientIdentifier<V, S, const P: usize> {
    model: FixedModelLoop<V>,
    law: FixedGradient<P>,
    rest: FixedRest,
    increment: IncrementWord,
    /// The largest increment that is taken.
    most: Word,
    initial: [Sum; P],
    bounds: [Interval; P],
    scales: FullScales,
    units: Units,
    mu: f64,
    stability_check: Option<StabilityCheck>,
    set: PhantomData<S>,
}

encode! {
    [V: Encode, S: ParameterSet<P>, const P: usize]
    FixedGradientIdentifier<V, S, P> as "FixedGradientIdentifier" {
        model, law, rest, increment, most, initial, bounds, scales, units, mu, stability_check, set,
    }
    also set_fingerprint(&S::PARAMETERS)
}

/// State of the identifier between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedGradientState<F, const P: usize> {
    model: FixedModelState<F>,
    estimates: [Sum; P],
    rest: FixedRestState,
}

/// The estimates of a sample, fractions of their full scales.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedGradientEstimates<const P: usize> {
    parameters: [Sum; P],
    /// The part of the load that the correction's integral carries, of the command's full scale.
    load_command: Word,
}

/// The settings with every bound that fixed point needs for a parameter set.
fn bounded<S: ParameterSet<P>, const P: usize>(
    settings: &Settings,
    units: &Units,
) -> Result<Settings, SettingsError> {
    let largest = FullScales::largest_rate(units);
    let mut filled = *settings;
    for parameter in S::PARAMETERS {
        let found = bounds(settings, parameter)?;
        let not_given = |setting| SettingsError::NotGiven { setting };
        let all = &mut filled.identifier.bounds;
        match parameter {
            Parameter::A => {
                let found = found.unwrap_or([0.0, largest]);
                for bound in found {
                    Allowed::Within(-largest, largest).check("bounds.a", bound)?;
                }
                all.a = Some(found);
            }
            // Where it follows from the box, the sampled correction may ask for less.
            Parameter::B => {
                found.ok_or(not_given("bounds.b"))?;
                if settings.identifier.known.b {
                    all.b = found;
                }
            }
            Parameter::Coulomb => all.coulomb = Some(found.ok_or(not_given("bounds.coulomb"))?),
            Parameter::Load => all.load = Some(found.ok_or(not_given("bounds.load"))?),
        }
    }
    Ok(filled)
}

impl<V, S, const P: usize> FromSettings for FixedGradientIdentifier<V, S, P>
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    /// # Errors
    /// As for the floating-point identifier, see [`SettingsError`]. Also a missing bound from which a full scale
    /// follows: `bounds.b` (unless there is a parameter range), `bounds.coulomb` or `bounds.load`. Also a Γ that is not
    /// diagonal. Also a range, bound, gain or sample time that does not fit the fixed-point format, with the value that
    /// would.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let velocity = V::with_cutoff(&settings.units()?, settings.cutoff)?;
        let filled = bounded::<S, P>(settings, &settings.units()?)?;
        let mut plan = GradientPlan::<P>::new::<S>(&filled, &velocity.transfer())?;
        plan.gamma.check_diagonal()?;
        for (i, parameter) in S::PARAMETERS.into_iter().enumerate() {
            if let (Parameter::B, Some([_, most])) = (parameter, bounds(settings, parameter)?) {
                let own = plan.bounds[i];
                plan.bounds[i] = Interval::new("bounds.b", own.min(), own.max().min(most))?;
                Allowed::AtMost(most).check("initial.b", plan.initial[i])?;
            }
        }
        let scales = FullScales::from_settings(settings)?;
        let units = plan.units;
        let mut law = FixedGradient::new::<S>(&plan, &scales);
        if settings.identifier.gamma.is_none() {
            // A chosen Γ takes the room that there is: each parameter has a bound, and all of them have one together.
            for _ in 0..=P {
                let Err(OutOfRange {
                    parameter: "gamma",
                    value,
                    allowed: Allowed::PositiveUpTo(most),
                }) = law
                else {
                    break;
                };
                plan.gamma = plan.gamma.scaled([libm::sqrt(most / value); P])?;
                law = FixedGradient::new::<S>(&plan, &scales);
            }
        }
        Ok(Self {
            model: FixedModelLoop::new(velocity, &units, &plan.gains, &scales),
            law: law?,
            rest: FixedRest::new(&units, &scales),
            increment: IncrementWord::new(&scales),
            most: scales.most_increment(settings)?,
            initial: core::array::from_fn(|i| {
                let parameter = S::PARAMETERS[i];
                let machine = plan.initial[i] * parameter.scale(&units);
                Sum::from_value(machine, scales.estimate(parameter))
            }),
            bounds: plan.bounds,
            scales,
            units,
            mu: plan.mu,
            stability_check: plan.stability_check,
            set: PhantomData,
        })
    }
}

impl<V, S, const P: usize> FixedGradientIdentifier<V, S, P>
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    /// The certificate of the parameter range; none without one.
    #[must_use]
    pub fn certificate(&self) -> Option<&Certificate> {
        self.stability_check
            .as_ref()
            .map(|stability_check| &stability_check.certificate)
    }

    /// The gain margin of the sampled loop over the parameter range; none without one. See
    /// [`SampledLoop::gain_margin`](crate::stability::SampledLoop::gain_margin).
    #[must_use]
    pub fn gain_margin(&self) -> Option<f64> {
        self.stability_check
            .map(|stability_check| stability_check.gain_margin)
    }

    /// The μ in use, 1/s: the one given, or the automatic one.
    #[must_use]
    pub fn mu(&self) -> f64 {
        self.mu
    }

    /// The bounds that an estimate is kept in, SI; none for a parameter that the model does not have.
    #[must_use]
    pub fn bounds(&self, wanted: Parameter) -> Option<Interval> {
        let mut own = S::PARAMETERS.into_iter().zip(self.bounds);
        own.find(|(parameter, _)| *parameter == wanted)
            .map(|(_, bounds)| bounds)
    }

    /// A command in command units as a word; saturated, zero for NaN.
    #[must_use]
    pub fn command_word(&self, command: f64) -> Word {
        limit_to_half(word(command, self.scales.command))
    }

    /// A command as a number, command units.
    #[must_use]
    pub fn command(&self, command: Word) -> f64 {
        value(command, self.scales.command)
    }

    /// The output error of a sample as a number, counts (position units).
    #[must_use]
    pub fn output_error(&self, seen: &Update<Word>) -> f64 {
        value(seen.output_error, self.scales.position)
    }

    /// True if a command overcomes load and friction by the estimates; decided as in the floating-point
    /// identifier.
    #[cold]
    fn should_move(&self, state: &FixedGradientState<V::State, P>, command: Word) -> bool {
        let parameters = FixedParameters::from_values::<S, P>(&state.estimates);
        let pushed = self.model.pushed(&state.model, command, &parameters);
        let held = parameters.coulomb + parameters.coulomb;
        pushed.abs() > held + self.rest.hidden_acceleration()
    }
}

impl<V, S, const P: usize> Identify<Word> for FixedGradientIdentifier<V, S, P>
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    type State = FixedGradientState<V::State, P>;
    type Snapshot = FixedGradientEstimates<P>;

    fn start(&self) -> Self::State {
        FixedGradientState {
            model: self.model.start(),
            estimates: self.initial,
            rest: self.rest.at_rest(),
        }
    }

    /// A fraction of the velocity's full scale, saturated.
    #[inline]
    fn increment(&self, moved: i32) -> Word {
        self.increment.word(moved)
    }

    /// Any word is a command: one beyond its range saturates.
    #[inline]
    fn check(&self, increment: Word, _: Word) -> Result<(), StepError> {
        if increment > self.most || increment < -self.most {
            Err(StepError::CountJumped)
        } else {
            Ok(())
        }
    }

    /// Increment and command are fractions of their full scales, and so is the output error that it
    /// answers with. Values beyond saturate.
    #[inline]
    fn update(&self, state: &mut Self::State, increment: Word, command: Word) -> Update<Word> {
        let increment = limit(increment);
        let FixedObserved {
            output_error,
            rate,
            regressor,
        } = self.model.observe::<S, P>(&mut state.model, increment);
        let stands = if S::HAS_COULOMB {
            self.rest.stands(&mut state.rest, increment)
        } else {
            self.rest.rests(&mut state.rest, increment)
        };
        let mut event = Event::None;
        if stands {
            if S::HAS_COULOMB {
                self.model.hold_at_measurement(&mut state.model);
            }
            let should_move = self.should_move(state, command);
            event = if self.rest.resists(&mut state.rest, should_move) {
                Event::NotFollowing
            } else {
                Event::Standing
            };
        } else {
            let gain = FixedParameters::from_values::<S, P>(&state.estimates).gain;
            let estimates = &mut state.estimates;
            if self
                .law
                .update(estimates, &regressor, output_error, rate, gain)
            {
                event = Event::Slowed;
            }
        }
        let parameters = FixedParameters::from_values::<S, P>(&state.estimates);
        if self
            .model
            .advance::<S, P>(&mut state.model, rate, command, &parameters)
        {
            event = Event::Restarted;
        }
        if S::HAS_COULOMB && self.model.is_stuck(&state.model) && self.rest.pauses(&state.rest) {
            self.model.hold_at_measurement(&mut state.model);
        }
        Update {
            output_error,
            event,
        }
    }

    #[inline]
    fn snapshot(&self, state: &Self::State) -> Self::Snapshot {
        FixedGradientEstimates {
            parameters: state.estimates,
            load_command: self.model.load_command(&state.model),
        }
    }

    /// The load is the parameter d̂ plus b̂ k_i ∫ε.
    fn estimates_in(&self, shown: &Self::Snapshot) -> ServoParameters {
        let of = |wanted: Parameter| {
            S::PARAMETERS
                .iter()
                .zip(&shown.parameters)
                .find(|(parameter, _)| **parameter == wanted)
                .map_or(0.0, |(_, estimate)| {
                    let machine = estimate.value(self.scales.estimate(wanted));
                    machine / wanted.scale(&self.units)
                })
        };
        ServoParameters {
            a: of(Parameter::A),
            b: of(Parameter::B),
            coulomb: of(Parameter::Coulomb),
            load: of(Parameter::Load),
        }
        .with_load_of(self.command(shown.load_command))
    }

    fn at_bounds_in(&self, shown: &Self::Snapshot) -> PerParameter<bool> {
        let at = self.law.at_bounds(&shown.parameters);
        PerParameter::from_fn(|wanted| {
            let place = S::PARAMETERS.iter().position(|&own| own == wanted);
            place.is_some_and(|place| at[place])
        })
    }

    fn resume_moving(&self, state: &mut Self::State, increment: Word) {
        state.model = self.model.alongside(&state.model, increment);
    }
}

impl<V, S, const P: usize> MachineEstimates<Word> for FixedGradientIdentifier<V, S, P>
where
    V: VelocityEstimate<Word>,
    S: ParameterSet<P>,
{
    #[inline]
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<Word> {
        let of = |wanted: Parameter| {
            let mut own = S::PARAMETERS.iter().zip(&state.estimates);
            own.find(|(parameter, _)| **parameter == wanted)
                .map_or(Word::ZERO, |(_, estimate)| estimate.word())
        };
        let (b, load_command) = (of(Parameter::B), self.model.load_command(&state.model));
        PerParameter {
            a: of(Parameter::A),
            b,
            coulomb: of(Parameter::Coulomb),
            // Each is at most one half.
            load: of(Parameter::Load) + product(b, load_command),
        }
    }

    fn machine_unit(&self, parameter: Parameter) -> f64 {
        power(self.scales.estimate(parameter)) / parameter.scale(&self.units)
    }
}
