use core::marker::PhantomData;

use super::automatic_gamma::gamma_by_limit;
use super::plant_box::{nominal_box, plant_box};
use super::{FromSettings, Settings, SettingsError};
use crate::adaptation::{Gradient, GradientConfig};
use crate::control::Gains;
use crate::error::Allowed;
use crate::identifier::GradientIdentifier;
use crate::interval::Interval;
use crate::linalg::PositiveDefinite;
use crate::measurement::standstill::Standstill;
use crate::measurement::velocity::{Transfer, VelocityEstimate};
use crate::model::{CommandCorrection, ModelLoop, ZeroOrderHoldStep};
use crate::number::Number;
use crate::parameters::{Parameter, ParameterSet};
use crate::stability::{Certificate, SampledLoop, StabilityCheck, automatic_mu};
use crate::units::Units;

/// The checked settings of the gradient identifiers, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GradientPlan<const P: usize> {
    pub(crate) units: Units,
    /// Gains of the correction, in command form.
    pub(crate) gains: Gains,
    pub(crate) gamma: PositiveDefinite<P>,
    pub(crate) mu: f64,
    /// The known part of α = a + b k_d.
    pub(crate) decay: Decay,
    pub(crate) frozen: [bool; P],
    pub(crate) initial: [f64; P],
    pub(crate) bounds: [Interval; P],
    pub(crate) largest_command: Option<f64>,
    pub(crate) stability_check: Option<StabilityCheck>,
}

/// The smallest α that the servo may have, 1/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Decay {
    /// From the parameter range.
    Known(f64),
    /// Without a parameter range: this per b̂. It is half of k_d, so that it still holds for an estimate twice too
    /// large.
    PerGain(f64),
}

/// The largest b̂, ĉ and |d̂|, SI. They are far beyond any servo, and keep the model loop in the range of single
/// precision.
pub(crate) const LARGEST: f64 = 1e9;

/// The smallest b̂, SI, if no bound is given.
pub(crate) const SMALLEST_GAIN: f64 = 1e-6;

/// The range of an estimate, and the names of bounds and initial value.
pub(crate) fn allowed(
    parameter: Parameter,
    units: &Units,
) -> (Allowed, &'static str, &'static str) {
    let fastest = ZeroOrderHoldStep::<f64>::LARGEST_RATE / units.rate();
    match parameter {
        Parameter::A => (Allowed::Within(-fastest, fastest), "bounds.a", "initial.a"),
        Parameter::B => (Allowed::PositiveUpTo(LARGEST), "bounds.b", "initial.b"),
        Parameter::Coulomb => (
            Allowed::Within(0.0, LARGEST),
            "bounds.coulomb",
            "initial.coulomb",
        ),
        Parameter::Load => (
            Allowed::Within(-LARGEST, LARGEST),
            "bounds.load",
            "initial.load",
        ),
    }
}

impl<const P: usize> GradientPlan<P> {
    /// Checks everything that a gradient identifier of a parameter set needs.
    pub(crate) fn new<S: ParameterSet<P>>(
        settings: &Settings,
        velocity: &Transfer,
    ) -> Result<Self, SettingsError> {
        let units = settings.units()?;
        let given = &settings.identifier;
        if let Some(setting) = given.terms.of_amplifier().next() {
            return Err(SettingsError::NoAmplifier { setting });
        }
        let gains = settings.correction_gains()?;
        let plant_box = plant_box(settings)?;
        let nominal = nominal_box(settings)?;
        let mu = given.mu.unwrap_or_else(|| automatic_mu(&gains, &nominal));

        let mut bounds = [nominal.b(); P];
        let mut initial = [0.0; P];
        let own = S::PARAMETERS.into_iter().zip(&mut bounds).zip(&mut initial);
        for ((parameter, bounds), initial) in own {
            let (allowed, bounds_name, initial_name) = allowed(parameter, &units);
            let widest = || match parameter {
                Parameter::A => [0.0, ZeroOrderHoldStep::<f64>::LARGEST_RATE / units.rate()],
                Parameter::B => {
                    let most =
                        SampledLoop::new(&units, &gains, velocity).most_gain(nominal.b().max());
                    [SMALLEST_GAIN.min(nominal.b().min()), most]
                }
                Parameter::Coulomb => [0.0, LARGEST],
                Parameter::Load => [-LARGEST, LARGEST],
            };
            let [low, high] = given.bounds.get(parameter).unwrap_or_else(widest);
            allowed.check(bounds_name, low)?;
            allowed.check(bounds_name, high)?;
            *bounds = Interval::new(bounds_name, low, high)?;
            let start = given.initial.get(parameter).unwrap_or(match parameter {
                Parameter::B => libm::sqrt(nominal.b().min() * nominal.b().max()),
                _ => 0.0_f64.max(low).min(high),
            });
            *initial = Allowed::Within(low, high).check(initial_name, start)?;
        }
        let stability_check = match &plant_box {
            Some(plant_box) => {
                let certificate = Certificate::new(&gains, plant_box, mu)?;
                SampledLoop::new(&units, &gains, velocity).check(plant_box)?;
                Some(StabilityCheck {
                    certificate,
                    gain_margin: SampledLoop::new(&units, &gains, velocity).gain_margin(plant_box),
                })
            }
            None => None,
        };
        for (parameter, bounds) in S::PARAMETERS.iter().zip(&bounds) {
            if *parameter == Parameter::B {
                let from = nominal.b().max().min(bounds.max());
                SampledLoop::new(&units, &gains, velocity).check_estimates(from, bounds.max())?;
            }
        }
        let gamma = match (given.gamma, settings.largest_command()) {
            (Some(gamma), _) => PositiveDefinite::new(
                S::PARAMETERS
                    .map(|own| S::PARAMETERS.map(|other| gamma[own as usize][other as usize])),
            )?,
            (None, Some(limit)) => gamma_by_limit::<S, P>(&units, &nominal, &gains, limit)?,
            (None, None) => return Err(SettingsError::NotGiven { setting: "gamma" }),
        };
        Ok(Self {
            units,
            gains,
            gamma,
            mu,
            decay: match &plant_box {
                Some(plant_box) => Decay::Known(plant_box.slowest_decay(gains.kd())),
                None => Decay::PerGain(gains.kd() / 2.0),
            },
            frozen: S::PARAMETERS.map(|parameter| given.known.get(parameter)),
            initial,
            bounds,
            largest_command: settings.largest_command(),
            stability_check,
        })
    }
}

impl<N, V, S, const P: usize> FromSettings for GradientIdentifier<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    /// # Errors
    /// See [`SettingsError`]. It names a range or the certificate's inequality. It may also name the servo whose
    /// sampled loop is unstable, or the estimate whose sampled correction is.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let velocity = settings.velocity::<N, V>()?;
        let plan = GradientPlan::<P>::new::<S>(settings, &velocity.transfer())?;
        let units = plan.units;
        let scale = S::PARAMETERS.map(|parameter| parameter.scale(&units) / units.velocity());
        let gamma = plan.gamma.scaled(scale)?;
        let rates = |parameter: Parameter| parameter.scale(&units);
        let (known, per_gain) = match plan.decay {
            Decay::Known(decay) => (decay * units.rate(), 0.0),
            // Per machine unit of b̂.
            Decay::PerGain(per_gain) => (0.0, per_gain * units.rate() / units.acceleration()),
        };
        let gradient = GradientConfig {
            gamma,
            mu: plan.mu * units.rate(),
            slowest_decay: known,
            decay_per_gain: per_gain,
            bounds: core::array::from_fn(|i| plan.bounds[i].scaled(rates(S::PARAMETERS[i]))),
            frozen: plan.frozen,
        };
        Ok(Self {
            model: ModelLoop::new(velocity, CommandCorrection::new(&units, &plan.gains)),
            law: Gradient::new(&gradient)?,
            standstill: Standstill::new(&units),
            most: N::from_f64(settings.most_increment(&units, N::REACH.to_f64())?),
            initial: core::array::from_fn(|i| plan.initial[i] * rates(S::PARAMETERS[i])),
            bounds: plan.bounds,
            gamma: *plan.gamma.entries(),
            mu: plan.mu,
            units,
            stability_check: plan.stability_check,
            set: PhantomData,
        })
    }
}
