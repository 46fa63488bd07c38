//! From a scenario to a loop on its test rig.
//!
//! A new law is an arm of [`method`].

use std::f64::consts::TAU;

use identifier_core::Settings;
use identifier_core::adaptation::IdentifiableSet;
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::FixedVelocity;
use identifier_core::identifier::{
    BehindAmplifier, GaussNewtonIdentifier, GradientIdentifier, Identify, TermWindowIdentifier,
    WindowIdentifier,
};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use identifier_core::parameters::{AllUnknowns, Parameter, ParameterSet};
use identifier_core::settings::{FromSettings, SettingsError};
use identifier_core::units::Units;
use rivals::{
    ClosedLoopArx, DirectEstimator, FilteredLeastSquares, MechanicalLeastSquares, RelayCycle,
    TwoRelays,
};
use virtual_servo::faults::Faults;
use virtual_servo::{SensorErrors, Servo};

use super::sensor::Sensor;
use super::{LocalLoop, Rig, Simulation};
use crate::experiment::Outcome;
use crate::loops::{
    BatchLeastSquares, Beside, Cycle, Direct, FixedLoop, Learner, LeastSquares, PidLoop, RelayLoop,
    RelayMethod, TwoCycles, TwoDegreesLoop, gamma_of,
};
use crate::scenario::dispatch::{with_number, with_set, with_types, with_velocity, with_words};
use crate::scenario::{Arithmetic, Baseline, BaselineSettings, Fault, Law, Scenario};

/// Blocks of a window: a PC has the memory for every sample of half a second at 1 kHz.
const WINDOW_BLOCKS: usize = 512;

/// The same with terms, for which a block should be a sample: two seconds at 1 kHz.
const TERM_WINDOW_BLOCKS: usize = 2048;

/// Commands that an amplifier may hold back.
const HELD_BACK: usize = 128;

impl Simulation {
    /// What a scenario describes.
    ///
    /// # Errors
    /// The key that something cannot be built from.
    pub fn of(scenario: &Scenario) -> Result<Self, Fault> {
        let reference = scenario.reference::<f64>()?;
        let settings = scenario
            .settings_for(Some(&reference))
            .map_err(|error| scenario.fault(&error))?;
        if in_words(scenario) {
            return Ok(Self {
                rig: Rig::of::<f64>(scenario)?.counting_from(0),
                closed: closed_by_pid(scenario, &settings, 0)?,
            });
        }
        with_number!(scenario => simulation(scenario, &settings))
    }
}

fn simulation<N: Number>(scenario: &Scenario, settings: &Settings) -> Result<Simulation, Fault> {
    method::<N>(scenario, settings)?.simulation(scenario, settings)
}

/// Whether the loop of a scenario is computed in fixed point.
fn in_words(scenario: &Scenario) -> bool {
    let baseline = matches!(scenario.identifier.law, Law::Baseline(..));
    scenario.identifier.arithmetic == Arithmetic::Fixed && !baseline
}

impl Rig<'_> {
    /// That of a scenario, its signals those that a loop in this number format takes.
    pub(crate) fn of<N: Number>(scenario: &Scenario) -> Result<Self, Fault> {
        let reference = scenario.reference::<N>()?;
        let units = scenario.checked_units()?;
        let (time, seed) = (units.sample_time(), scenario.noise_seed());
        let servo = Servo::at_rest(&scenario.servo()?, &scenario.effects, time, seed);
        let errors = SensorErrors::new(&scenario.sensor, time, seed);
        let faults = Faults::new(&scenario.faults, time, units.position_unit())
            .map_err(|error| Fault::new(format!("fault.{}", error.parameter), error))?;
        let mut progress = reference.start();
        Ok(Self {
            sample_time: units.sample_time(),
            position_unit: units.position_unit(),
            samples: scenario.samples(),
            reference: Box::new(move || reference.process(&mut progress).to_f64()),
            sensor: match scenario.counts_per_rev {
                Some(counts) => Sensor::encoder(counts, 0),
                None => Sensor::ideal::<N>(units.position()),
            },
            sensor_errors: errors
                .map_err(|error| Fault::new(format!("encoder.{}", error.parameter), error))?,
            servo: servo.map_err(|error| Fault::of_effect(&error))?,
            faults: (!scenario.faults.is_empty()).then_some(faults),
        })
    }

    /// The same with a counter that shows `start` where the servo starts; an ideal sensor counts
    /// position units.
    pub(crate) fn counting_from(mut self, start: i32) -> Self {
        self.sensor = match self.sensor {
            Sensor::Encoder { encoder, .. } => Sensor::Encoder { encoder, start },
            Sensor::Ideal { .. } => Sensor::encoder(TAU / self.position_unit, start),
        };
        self
    }
}

/// What a law is to the loop that it works in.
pub(super) enum Method<N: Number> {
    /// It listens beside the PID.
    Listening(Box<dyn Learner<N>>),
    /// It commands a relay.
    Relay(Box<dyn RelayMethod<N>>),
    /// It closes a loop of its own, in double precision.
    Own(LocalLoop),
}

impl<N: Number> Method<N> {
    /// Its loop on the rig.
    pub(super) fn simulation(
        self,
        scenario: &Scenario,
        settings: &Settings,
    ) -> Result<Simulation, Fault> {
        Ok(match self {
            Self::Listening(learner) => Simulation {
                rig: Rig::of::<N>(scenario)?,
                closed: beside_pid(scenario, settings, learner, 0)?,
            },
            Self::Relay(method) => {
                let mut rig = Rig::of::<N>(scenario)?;
                if !method.follows() {
                    rig.reference = Box::new(|| 0.0);
                }
                Simulation {
                    rig,
                    closed: Box::new(RelayLoop::new(method)),
                }
            }
            Self::Own(closed) => Simulation {
                rig: Rig::of::<f64>(scenario)?,
                closed,
            },
        })
    }
}

/// The PID's loop with what listens beside it, in the number format of the scenario, at rest at a
/// count; the settings are those of [`Scenario::settings_for`].
///
/// # Errors
/// The key that it cannot be built from.
pub(crate) fn closed_by_pid(
    scenario: &Scenario,
    settings: &Settings,
    start: i32,
) -> Result<LocalLoop, Fault> {
    if in_words(scenario) {
        return with_words!(scenario => words(settings, start))
            .map_err(|error| scenario.fault(&error));
    }
    with_number!(scenario => listened_to(scenario, settings, start))
}

fn listened_to<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
    start: i32,
) -> Result<LocalLoop, Fault> {
    let learner = learner::<N>(scenario, settings)?;
    beside_pid(scenario, settings, learner, start)
}

fn beside_pid<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
    learner: Box<dyn Learner<N>>,
    start: i32,
) -> Result<LocalLoop, Fault> {
    with_velocity!(scenario, N => pid::<N>(settings, learner, start))
        .map_err(|error| scenario.fault(&error))
}

fn pid<N: Number, V: VelocityEstimate<N> + 'static>(
    settings: &Settings,
    learner: Box<dyn Learner<N>>,
    start: i32,
) -> Result<LocalLoop, SettingsError> {
    Ok(Box::new(PidLoop::<N, V>::new(settings, learner, start)?))
}

fn words<V, S, const P: usize>(settings: &Settings, start: i32) -> Result<LocalLoop, SettingsError>
where
    V: FixedVelocity + 'static,
    S: ParameterSet<P> + 'static,
{
    Ok(Box::new(FixedLoop::<V, S, P>::new(settings, start)?))
}

/// The law of a scenario, listening beside whatever controller runs; the settings are those of
/// [`Scenario::settings_for`].
///
/// # Errors
/// The key that it cannot be built from.
pub(crate) fn learner<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
) -> Result<Box<dyn Learner<N>>, Fault> {
    if let Law::Baseline(Baseline::RelayLeastSquares, own) = &scenario.identifier.law {
        // Its relay makes its command; the least squares listen to any.
        let law =
            FilteredLeastSquares::new(&scenario.checked_units()?, &scenario.least_squares(own));
        return Ok(Box::new(Direct::new(law.map_err(fault_of_rival)?)));
    }
    match method::<N>(scenario, settings)? {
        Method::Listening(learner) => Ok(learner),
        Method::Relay(_) | Method::Own(_) => Err(Fault::new(
            "identifier.law",
            format!(
                "\"{}\" closes a loop of its own: it cannot listen beside a controller",
                scenario.identifier.law.name()
            ),
        )),
    }
}

/// The law of a scenario in a number format.
pub(super) fn method<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
) -> Result<Method<N>, Fault> {
    let units = scenario.checked_units()?;
    let listening = match &scenario.identifier.law {
        Law::Gradient | Law::PdGradient => with_types!(scenario, N => gradient::<N>(settings)),
        Law::GaussNewton if scenario.has_terms() => {
            gauss_newton_with_terms::<N>(scenario, settings)
        }
        Law::GaussNewton => with_set!(scenario => gauss_newton::<N>(settings)),
        Law::Window if scenario.has_terms() => window_with_terms::<N>(scenario, settings),
        Law::Window => with_set!(scenario => window::<N>(settings)),
        Law::Baseline(baseline, own) => {
            return rival(scenario, &units, *baseline, own).map_err(fault_of_rival);
        }
    };
    listening
        .map(Method::Listening)
        .map_err(|error| scenario.fault(&error))
}

/// What a rival cannot be built from, by its key.
fn fault_of_rival(error: OutOfRange) -> Fault {
    let key = match error.parameter {
        "cutoff" => "filter_cutoff",
        "sample_time" => "block",
        other => other,
    };
    Fault::new(format!("identifier.{key}"), error)
}

type Listening<N> = Result<Box<dyn Learner<N>>, SettingsError>;

fn gradient<N, V, S, const P: usize>(settings: &Settings) -> Listening<N>
where
    N: Number,
    V: VelocityEstimate<N> + 'static,
    S: ParameterSet<P> + 'static,
{
    type Law<N, V, S, const P: usize> = GradientIdentifier<N, V, S, P>;
    listening(settings, |law: &Law<N, V, S, P>| Outcome {
        gamma: gamma_of::<S, P>(settings),
        mu: Some(law.mu()),
        certified: law.certificate().is_some(),
        gain_margin: law.gain_margin(),
        ..Outcome::default()
    })
}

/// An identifier, behind the amplifier if one is declared, with what is known of it beforehand.
fn listening<N, I>(settings: &Settings, known: impl FnOnce(&I) -> Outcome) -> Listening<N>
where
    N: Number,
    I: Identify<N> + FromSettings + 'static,
{
    if settings.identifier.terms.declares_amplifier() {
        let behind: BehindAmplifier<N, I, HELD_BACK> = settings.build()?;
        let known = known(behind.identifier());
        return Ok(Box::new(Beside::new(behind, known)));
    }
    let identifier: I = settings.build()?;
    let known = known(&identifier);
    Ok(Box::new(Beside::new(identifier, known)))
}

fn gauss_newton<N: Number, S: IdentifiableSet<P> + 'static, const P: usize>(
    settings: &Settings,
) -> Listening<N> {
    fitting::<N, GaussNewtonIdentifier<N, S, P>>(settings)
}

/// Every term that there is; those that the settings do not ask for stay away.
fn gauss_newton_with_terms<N: Number>(scenario: &Scenario, settings: &Settings) -> Listening<N> {
    gauss_newton::<N, AllUnknowns, 12>(&with_terms(scenario, settings))
}

/// The load is one of the parameters of a model with terms, and without friction its friction stays at
/// zero.
fn with_terms(scenario: &Scenario, settings: &Settings) -> Settings {
    let mut settings = *settings;
    settings.identifier.known.coulomb |= !scenario.identifier.estimates(Parameter::Coulomb);
    settings
}

/// A window of as many blocks as a model with terms needs.
fn window_with_terms<N: Number>(scenario: &Scenario, settings: &Settings) -> Listening<N> {
    let settings = with_terms(scenario, settings);
    fitting::<N, TermWindowIdentifier<N, TERM_WINDOW_BLOCKS>>(&settings)
}

fn window<N: Number, S: IdentifiableSet<P> + 'static, const P: usize>(
    settings: &Settings,
) -> Listening<N> {
    fitting::<N, WindowIdentifier<N, S, P, WINDOW_BLOCKS>>(settings)
}

/// A law that fits: it needs no estimate to begin with, but for a gain that it is not to find.
fn fitting<N, I>(settings: &Settings) -> Listening<N>
where
    N: Number,
    I: Identify<N> + FromSettings + 'static,
{
    let given = &settings.identifier;
    if given.known.b && given.initial.b.is_none() {
        return Err(SettingsError::NotGiven {
            setting: "initial.b",
        });
    }
    listening(settings, |_: &I| Outcome::default())
}

/// A method that is there for comparison.
fn rival<N: Number>(
    scenario: &Scenario,
    units: &Units,
    baseline: Baseline,
    own: &BaselineSettings,
) -> Result<Method<N>, OutOfRange> {
    let config = scenario.least_squares(own);
    Allowed::Above(0.0).check("initial.b", config.b)?;
    let relay = |part: f64| scenario.relay::<N>(part * own.relay, own);
    Ok(match baseline {
        Baseline::ClosedLoopArx => direct(ClosedLoopArx::new(units, &config)?),
        Baseline::MechanicalLeastSquares => direct(MechanicalLeastSquares::new(units, &config)?),
        Baseline::MultiStepLeastSquares => direct(scenario.multi_step(own)?),
        Baseline::ProportionalLeastSquares => {
            let law = BatchLeastSquares::new(units, own.filter_cutoff)?;
            Method::Listening(Box::new(law))
        }
        Baseline::RelayLeastSquares => {
            // The paper's relay has no delay.
            let prompt = BaselineSettings {
                relay_delay: 0.0,
                ..*own
            };
            let relay = scenario.relay(own.relay, &prompt)?;
            let law = FilteredLeastSquares::new(units, &config)?;
            Method::Relay(Box::new(LeastSquares::new(relay, law)))
        }
        Baseline::RelayCycle => {
            let law = RelayCycle::new(units, relay(1.0)?);
            Method::Relay(Box::new(Cycle::new(law)))
        }
        Baseline::TwoRelays => {
            let law = TwoRelays::new(units, [relay(1.0)?, relay(0.5)?]);
            Method::Relay(Box::new(TwoCycles::new(law)))
        }
        Baseline::TwoDegreesOfFreedom => Method::Own(Box::new(TwoDegreesLoop::new(
            units,
            scenario.controller(),
            config.b,
            own.filter_cutoff,
            scenario.samples(),
        )?)),
    })
}

fn direct<N: Number, E: DirectEstimator<N> + 'static>(estimator: E) -> Method<N> {
    Method::Listening(Box::new(Direct::new(estimator)))
}
