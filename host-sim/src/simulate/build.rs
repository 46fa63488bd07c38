//! From a scenario to a loop on its test rig.
//!
//! A new estimator is an arm of [`identifier_in`].

use identifier_core::Settings;
use identifier_core::control::{Controller, Shaped};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{
    GaussNewtonIdentifier, GradientIdentifier, GradientRecursion, IdentifiableSet, Identify,
};
use identifier_core::measurement::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::parameters::{AllUnknowns, Parameter, ParameterSet, Unknown};
use identifier_core::settings::{FromSettings, SettingsError};
use rivals::FilteredLeastSquares;

use super::{LocalLoop, SimulatedAxis, Simulation};
use crate::loops::{
    DirectEstimator, DynIdentifier, FixedIdentifier, FixedLoop, PidLoop, RelayLoop, Running,
    WholeRecord, known,
};
use crate::scenario::dispatch::{with_number, with_set, with_types, with_velocity};
use crate::scenario::{Arithmetic, Estimator, Fault, Scenario};
use identifier_log::experiment::Outcome;

impl Simulation {
    /// Builds the experiment of a scenario.
    ///
    /// # Errors
    /// The key that something cannot be built from.
    pub fn build(scenario: &Scenario) -> Result<Self, Fault> {
        let settings = scenario.settings()?;
        if is_fixed_point(scenario) {
            return Ok(Self {
                rig: SimulatedAxis::build::<f64>(scenario)?.counting_from(0),
                closed: closed_by_pid(scenario, &settings, 0)?,
            });
        }
        with_number!(scenario => simulation(scenario, &settings))
    }
}

fn simulation<N: Number>(scenario: &Scenario, settings: &Settings) -> Result<Simulation, Fault> {
    let closed = match scenario.identifier.law {
        Estimator::RelayLeastSquares => relay_loop::<N>(scenario)?,
        _ => floating_loop::<N>(scenario, settings, 0)?,
    };
    Ok(Simulation {
        rig: SimulatedAxis::build::<N>(scenario)?,
        closed,
    })
}

/// True if the loop of a scenario is computed in fixed point.
fn is_fixed_point(scenario: &Scenario) -> bool {
    let identifier = &scenario.identifier;
    identifier.arithmetic == Arithmetic::Fixed && !identifier.law.is_rival()
}

/// The PID's loop with the identifier beside it, in the number format of the scenario, at rest at a count. The settings
/// are those of [`Scenario::settings_for`].
///
/// # Errors
/// The key that it cannot be built from.
pub(crate) fn closed_by_pid(
    scenario: &Scenario,
    settings: &Settings,
    start: i32,
) -> Result<LocalLoop, Fault> {
    if is_fixed_point(scenario) {
        return with_types!(scenario, Word => fixed_loop(scenario, settings, start))
            .map_err(|error| scenario.fault(&error));
    }
    with_number!(scenario => floating_loop(scenario, settings, start))
}

fn floating_loop<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
    start: i32,
) -> Result<LocalLoop, Fault> {
    let identifier = identifier_in::<N>(scenario, settings)?;
    with_velocity!(scenario, N => pid::<N>(settings, identifier, start))
        .map_err(|error| scenario.fault(&error))
}

fn pid<N: Number, V: VelocityEstimate<N, State: Send> + Send + 'static>(
    settings: &Settings,
    identifier: Box<dyn DynIdentifier>,
    start: i32,
) -> Result<LocalLoop, SettingsError> {
    let controller: Controller<N, V, Shaped<N>> = settings.build()?;
    Ok(Box::new(PidLoop::new(controller, identifier, start)))
}

fn fixed_loop<V, S, const P: usize>(
    scenario: &Scenario,
    settings: &Settings,
    start: i32,
) -> Result<LocalLoop, SettingsError>
where
    V: VelocityEstimate<Word, State: Send> + Send + 'static,
    S: ParameterSet<P> + Send + 'static,
{
    let remembers = remembers(scenario);
    Ok(Box::new(FixedLoop::<V, S, P>::new(
        settings, start, remembers,
    )?))
}

/// The identifier of a scenario beside any controller, in the number format of the scenario. The settings are those of
/// [`Scenario::settings_for`].
///
/// # Errors
/// The key that it cannot be built from.
pub(crate) fn identifier(
    scenario: &Scenario,
    settings: &Settings,
) -> Result<Box<dyn DynIdentifier + Send>, Fault> {
    if is_fixed_point(scenario) {
        return with_types!(scenario, Word => fixed_identifier(scenario, settings))
            .map_err(|error| scenario.fault(&error));
    }
    with_number!(scenario => identifier_in(scenario, settings))
}

/// True if the gradient of a scenario has its memory.
fn remembers(scenario: &Scenario) -> bool {
    scenario.identifier.law == Estimator::Gradient
}

fn fixed_identifier<V, S, const P: usize>(scenario: &Scenario, settings: &Settings) -> Built
where
    V: VelocityEstimate<Word, State: Send> + Send + 'static,
    S: ParameterSet<P> + Send + 'static,
{
    let remembers = remembers(scenario);
    Ok(Box::new(FixedIdentifier::<V, S, P>::new(
        settings, remembers,
    )?))
}

/// The same in a number format.
pub(super) fn identifier_in<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
) -> Result<Box<dyn DynIdentifier + Send>, Fault> {
    let built = match scenario.identifier.law {
        Estimator::Gradient => with_types!(scenario, N => gradient::<N>(settings)),
        Estimator::Paper | Estimator::PdGradient => {
            with_types!(scenario, N => without_memory::<N>(settings))
        }
        Estimator::GaussNewton if scenario.has_terms() => {
            // Those that the settings do not require never enter.
            gauss_newton::<N, AllUnknowns, { Unknown::COUNT }>(&with_terms(scenario, settings))
        }
        Estimator::GaussNewton => with_set!(scenario => gauss_newton::<N>(settings)),
        Estimator::Fit => {
            scenario.check_terms_of_fit()?;
            return Ok(Box::new(WholeRecord));
        }
        Estimator::RelayLeastSquares => {
            // Its relay makes its command; the least squares take any.
            let units = scenario.checked_units()?;
            let law = FilteredLeastSquares::<N>::new(&units, &scenario.least_squares());
            return Ok(Box::new(DirectEstimator::new(law.map_err(fault_of_rival)?)));
        }
    };
    built.map_err(|error| scenario.fault(&error))
}

/// A setting that a rival cannot be built from, by its key.
fn fault_of_rival(error: OutOfRange) -> Fault {
    let key = match error.parameter {
        "cutoff" => "filter_cutoff",
        other => other,
    };
    Fault::new(format!("identifier.{key}"), error)
}

type Built = Result<Box<dyn DynIdentifier + Send>, SettingsError>;

fn gradient<N, V, S, const P: usize>(settings: &Settings) -> Built
where
    N: Number,
    V: VelocityEstimate<N, State: Send> + Send + 'static,
    S: ParameterSet<P> + Send + 'static,
{
    beside(settings, |law: &GradientIdentifier<N, V, S, P>| {
        known(settings, law)
    })
}

fn without_memory<N, V, S, const P: usize>(settings: &Settings) -> Built
where
    N: Number,
    V: VelocityEstimate<N, State: Send> + Send + 'static,
    S: ParameterSet<P> + Send + 'static,
{
    beside(settings, |law: &GradientRecursion<N, V, S, P>| {
        known(settings, law)
    })
}

/// An identifier, behind the amplifier if one is declared, with its outcome beforehand.
fn beside<N, I>(settings: &Settings, known: impl FnOnce(&I) -> Outcome) -> Built
where
    N: Number,
    I: Identify<N, State: Send> + FromSettings + Send + 'static,
{
    let (amplifier, behind) = settings.amplifier()?;
    let amplifier = settings
        .identifier
        .terms
        .declares_amplifier()
        .then_some(amplifier);
    let identifier: I = behind.build()?;
    let known = known(&identifier);
    Ok(Box::new(Running::<N, _>::new(identifier, amplifier, known)))
}

/// The load is one of the parameters of a model with terms. Without friction its friction stays at zero.
fn with_terms(scenario: &Scenario, settings: &Settings) -> Settings {
    let mut settings = *settings;
    settings.identifier.known.coulomb |= !scenario.identifier.estimates(Parameter::Coulomb);
    settings
}

/// It needs no estimate to begin with, but for a gain that it is not to find.
fn gauss_newton<N: Number, S: IdentifiableSet<P> + Send + 'static, const P: usize>(
    settings: &Settings,
) -> Built {
    let given = &settings.identifier;
    if given.known.b && given.initial.b.is_none() {
        return Err(SettingsError::NotGiven {
            setting: "initial.b",
        });
    }
    beside(settings, |_: &GaussNewtonIdentifier<N, S, P>| {
        Outcome::default()
    })
}

/// The loop of the method to compare with, which commands a relay.
fn relay_loop<N: Number>(scenario: &Scenario) -> Result<LocalLoop, Fault> {
    if scenario.stated.identifier.initial.b.is_none() {
        let setting = "initial.b";
        return Err(scenario.fault(&SettingsError::NotGiven { setting }));
    }
    let built = || {
        let config = scenario.least_squares();
        Allowed::Above(0.0).check("initial.b", config.b)?;
        let law = FilteredLeastSquares::new(&scenario.units(), &config)?;
        Ok(RelayLoop::<N>::new(scenario.relay()?, law))
    };
    Ok(Box::new(built().map_err(fault_of_rival)?))
}
