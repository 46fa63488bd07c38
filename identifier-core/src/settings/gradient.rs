use core::marker::PhantomData;

use super::automatic_gamma::gamma_by_limit;
use super::full_scales::{bounded, bounds, full_scales};
use super::parameter_range::{LARGEST, SMALLEST_GAIN, allowed, nominal_range, parameter_range};
use super::{FromSettings, Settings, SettingsError};
use crate::control::Gains;
use crate::error::{Allowed, OutOfRange};
use crate::gradient::{
    Certificate, Gradient, GradientConfig, GradientIdentifier, GradientRecursion, ParameterRange,
    StabilityCheck, automatic_mu,
};
use crate::interval::Interval;
use crate::measurement::standstill::Standstill;
use crate::measurement::velocity::{Transfer, VelocityEstimate};
use crate::model::{ModelLoop, ZeroOrderHoldStep};
use crate::number::Arithmetic;
use crate::parameters::{Parameter, ParameterSet, PerParameter};
use crate::scales::FullScales;
use crate::stability::SampledLoop;
use crate::units::Units;
use crate::windows::{Pieces, WindowSettings};

/// The checked settings of the gradient identifiers, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
struct GradientPlan<const P: usize> {
    pub(crate) units: Units,
    /// Gains of the correction, in command form.
    pub(crate) gains: Gains,
    pub(crate) gamma: [f64; P],
    pub(crate) mu: f64,
    /// The known part of α = a + b k_d.
    pub(crate) decay: Decay,
    pub(crate) frozen: [bool; P],
    pub(crate) initial: [f64; P],
    pub(crate) bounds: [Interval; P],
    pub(crate) nominal: ParameterRange,
    pub(crate) stability_check: Option<StabilityCheck>,
}

/// The smallest α that the servo may have, 1/s.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Decay {
    /// From the parameter range.
    Known(f64),
    /// Without a parameter range: this per b̂. It is half of k_d, so that it still holds for an estimate twice too
    /// large.
    PerGain(f64),
}

/// What a gradient identifier needs whatever its parameters are, as checked. One copy serves every set of parameters.
struct Correction<'a> {
    settings: &'a Settings,
    sampled_loop: SampledLoop,
    units: Units,
    gains: Gains,
    parameter_range: Option<ParameterRange>,
    nominal: ParameterRange,
    mu: f64,
}

impl<'a> Correction<'a> {
    #[inline(never)]
    fn new(settings: &'a Settings, velocity: &Transfer) -> Result<Self, SettingsError> {
        let units = settings.units()?;
        let given = &settings.identifier;
        if let Some(setting) = given.terms.of_amplifier().next() {
            return Err(SettingsError::NoAmplifier { setting });
        }
        let gains = settings.correction_gains()?;
        let parameter_range = parameter_range(settings)?;
        let nominal = nominal_range(settings)?;
        let mu = given.mu.unwrap_or_else(|| automatic_mu(&gains, &nominal));
        Ok(Self {
            settings,
            sampled_loop: SampledLoop::new(&units, &gains, velocity),
            units,
            gains,
            parameter_range,
            nominal,
            mu,
        })
    }

    /// Bounds and initial value of a parameter.
    #[inline(never)]
    fn bounds(&self, parameter: Parameter) -> Result<(Interval, f64), SettingsError> {
        let (given, nominal) = (&self.settings.identifier, &self.nominal);
        let (allowed, bounds_name, initial_name) = allowed(parameter, &self.units);
        let widest = || match parameter {
            Parameter::A => [
                0.0,
                ZeroOrderHoldStep::<f64>::LARGEST_RATE / self.units.rate(),
            ],
            Parameter::B => {
                let most = self.sampled_loop.most_gain(nominal.b().max());
                [SMALLEST_GAIN.min(nominal.b().min()), most]
            }
            Parameter::Coulomb => [0.0, LARGEST],
            Parameter::Load => [-LARGEST, LARGEST],
        };
        let [low, high] = given.bounds.get(parameter).unwrap_or_else(widest);
        allowed.check(bounds_name, low)?;
        allowed.check(bounds_name, high)?;
        let bounds = Interval::new(bounds_name, low, high)?;
        let start = given.initial.get(parameter).unwrap_or(match parameter {
            Parameter::B => libm::sqrt(nominal.b().min() * nominal.b().max()),
            _ => 0.0_f64.max(low).min(high),
        });
        let initial = Allowed::Within(low, high).check(initial_name, start)?;
        Ok((bounds, initial))
    }

    /// The check of the parameter range, and then that of the estimates of b up to their bound.
    #[inline(never)]
    fn stability_check(
        &self,
        most_gain: Option<f64>,
    ) -> Result<Option<StabilityCheck>, SettingsError> {
        let sampled_loop = &self.sampled_loop;
        let stability_check = match &self.parameter_range {
            Some(parameter_range) => {
                let certificate = Certificate::new(&self.gains, parameter_range, self.mu)?;
                sampled_loop.check(parameter_range)?;
                Some(StabilityCheck {
                    certificate,
                    gain_margin: sampled_loop.gain_margin(parameter_range),
                })
            }
            None => None,
        };
        if let Some(most) = most_gain {
            sampled_loop.check_estimates(self.nominal.b().max().min(most), most)?;
        }
        Ok(stability_check)
    }
}

impl<const P: usize> GradientPlan<P> {
    /// Checks everything that a gradient identifier of a parameter set needs.
    pub(crate) fn new<S: ParameterSet<P>>(
        settings: &Settings,
        velocity: &Transfer,
    ) -> Result<Self, SettingsError> {
        let correction = Correction::new(settings, velocity)?;
        let given = &settings.identifier;
        let mut bounds = [correction.nominal.b(); P];
        let mut initial = [0.0; P];
        let mut most_gain = None;
        let own = S::PARAMETERS.into_iter().zip(&mut bounds).zip(&mut initial);
        for ((parameter, bounds), initial) in own {
            (*bounds, *initial) = correction.bounds(parameter)?;
            if parameter == Parameter::B {
                most_gain = Some(bounds.max());
            }
        }
        let stability_check = correction.stability_check(most_gain)?;
        let Correction {
            units,
            gains,
            parameter_range,
            nominal,
            mu,
            ..
        } = correction;
        let gamma = match (given.gamma, settings.largest_command()) {
            (Some(gamma), _) => {
                for parameter in S::PARAMETERS {
                    let name = match parameter {
                        Parameter::A => "gamma.a",
                        Parameter::B => "gamma.b",
                        Parameter::Coulomb => "gamma.coulomb",
                        Parameter::Load => "gamma.load",
                    };
                    Allowed::Above(0.0).check(name, gamma.get(parameter))?;
                }
                S::PARAMETERS.map(|parameter| gamma.get(parameter))
            }
            (None, Some(limit)) => gamma_by_limit::<S, P>(&units, &nominal, &gains, limit)?,
            (None, None) => return Err(SettingsError::NotGiven { setting: "gamma" }),
        };
        Ok(Self {
            units,
            gains,
            gamma,
            mu,
            decay: match &parameter_range {
                Some(parameter_range) => Decay::Known(parameter_range.slowest_decay(gains.kd())),
                None => Decay::PerGain(gains.kd() / 2.0),
            },
            frozen: S::PARAMETERS.map(|parameter| given.known.get(parameter)),
            initial,
            bounds,
            nominal,
            stability_check,
        })
    }

    /// The same for an arithmetic, with the full scales of the signals.
    fn in_arithmetic<N: Arithmetic, S: ParameterSet<P>>(
        settings: &Settings,
        velocity: &Transfer,
    ) -> Result<(Self, FullScales), SettingsError> {
        if !N::IS_FIXED {
            return Ok((Self::new::<S>(settings, velocity)?, FullScales::NONE));
        }
        let mut plan = Self::new::<S>(&bounded::<S, P>(settings)?, velocity)?;
        plan.keep_within_bounds::<S>(settings)?;
        Ok((plan, full_scales::<N>(settings)?))
    }

    /// Keeps b̂ below the bound that gives its full scale.
    fn keep_within_bounds<S: ParameterSet<P>>(
        &mut self,
        settings: &Settings,
    ) -> Result<(), SettingsError> {
        for (i, parameter) in S::PARAMETERS.into_iter().enumerate() {
            if let (Parameter::B, Some([_, most])) = (parameter, bounds(settings, parameter)?) {
                let own = self.bounds[i];
                self.bounds[i] = Interval::new("bounds.b", own.min(), own.max().min(most))?;
                Allowed::AtMost(most).check("initial.b", self.initial[i])?;
            }
        }
        Ok(())
    }

    /// Pieces and windows of the memory. Γ gives the ratios of what the estimates may be off by, the middle of b's range
    /// its size.
    fn windows<N: Arithmetic, S: ParameterSet<P>>(
        &self,
        settings: &Settings,
        scales: &FullScales,
    ) -> Result<(Pieces<N>, WindowSettings<N::Real>), SettingsError> {
        /// The longest piece, s: in it an acceleration changes little.
        const LONGEST: f64 = 8e-3;
        /// A usual delay besides the hold's, s.
        const DELAY: f64 = 3e-3;
        /// Output error up to which a model follows, standard deviations of the noise: eight counts of an encoder.
        const NEAR: f64 = 28.0;
        let units = &self.units;
        let most = LONGEST / units.sample_time();
        let samples = (0..)
            .map(|k| Pieces::<N>::MOST >> k)
            .find(|&samples| samples == 1 || f64::from(samples) <= most * (1.0 + 1e-9))
            .unwrap_or(1);
        let noise = libm::sqrt(settings.noise_variance(units)?);
        let near = N::signal(NEAR * noise, scales.position);
        let [least, most] = [self.nominal.b().min(), self.nominal.b().max()];
        let b = libm::sqrt(least * most / 2.0);
        let gamma = |wanted| {
            let mut own = S::PARAMETERS.into_iter().zip(self.gamma).zip(self.frozen);
            let ((_, gamma), frozen) = own.find(|((own, _), _)| *own == wanted)?;
            (!frozen).then_some(gamma)
        };
        let of_b = gamma(Parameter::B).unwrap_or(1.0);
        let spread = |parameter: Parameter| {
            let share = libm::sqrt(gamma(parameter).unwrap_or(0.0) / of_b);
            b * share * parameter.scale(units)
        };
        let spread = [
            spread(Parameter::A),
            spread(Parameter::B),
            spread(Parameter::Coulomb),
            b * Parameter::B.scale(units) * DELAY / units.sample_time(),
        ];
        Ok((
            Pieces::new(samples, near, [scales.velocity, scales.command]),
            WindowSettings::new(samples, noise, &spread),
        ))
    }

    /// The estimator with an automatic Γ, as large as its limits permit: each parameter has a bound, and all of them
    /// have one together.
    fn lowered_law<N: Arithmetic, S: ParameterSet<P>>(
        &mut self,
        scales: &FullScales,
    ) -> Result<Gradient<N, P>, SettingsError> {
        for _ in 0..=P {
            match self.law::<N, S>(scales) {
                Err(SettingsError::Range(OutOfRange {
                    parameter: "gamma",
                    value,
                    allowed: Allowed::PositiveUpTo(most),
                })) => {
                    let root = libm::sqrt(most / value);
                    self.gamma = self.gamma.map(|entry| entry * (root * root));
                }
                other => return other,
            }
        }
        self.law::<N, S>(scales)
    }

    /// The estimator.
    fn law<N: Arithmetic, S: ParameterSet<P>>(
        &self,
        scales: &FullScales,
    ) -> Result<Gradient<N, P>, SettingsError> {
        let units = &self.units;
        let scale = S::PARAMETERS.map(|parameter| parameter.scale(units));
        let (slowest_decay, decay_per_gain) = match self.decay {
            Decay::Known(decay) => (decay * units.rate(), 0.0),
            // Per machine unit of b̂.
            Decay::PerGain(per_gain) => (0.0, per_gain * units.rate() / units.acceleration()),
        };
        let own = S::PARAMETERS.into_iter().zip(self.initial);
        let of_gain = own.map(|(parameter, initial)| match parameter {
            Parameter::B => initial * parameter.scale(units),
            _ => 0.0,
        });
        let gamma: [f64; P] = core::array::from_fn(|i| {
            let scale = scale[i] / units.velocity();
            self.gamma[i] * (scale * scale)
        });
        for entry in gamma {
            Allowed::Above(0.0).check("gamma", entry)?;
        }
        let config = GradientConfig {
            parameters: S::PARAMETERS,
            gamma,
            given: self.gamma,
            mu: self.mu * units.rate(),
            rate: units.rate(),
            slowest_decay,
            decay_per_gain,
            bounds: core::array::from_fn(|i| self.bounds[i].scaled(scale[i])),
            initial_gain: of_gain.sum(),
            frozen: self.frozen,
        };
        Ok(Gradient::new(&config, scales)?)
    }
}

impl Settings {
    /// Lowers a chosen Γ to the range of a number format, by one factor: it adapts more slowly.
    ///
    /// # Errors
    /// Another setting that the identifier would reject; Γ is then unchanged.
    pub fn lower_gamma<N, V, S, const P: usize>(&mut self) -> Result<(), SettingsError>
    where
        N: Arithmetic,
        V: VelocityEstimate<N>,
        S: ParameterSet<P>,
    {
        let velocity = self.velocity::<N, V>()?.transfer();
        let (mut plan, scales) = GradientPlan::<P>::in_arithmetic::<N, S>(self, &velocity)?;
        let before = plan.gamma[0];
        plan.lowered_law::<N, S>(&scales)?;
        let factor = plan.gamma[0] / before;
        if let Some(gamma) = &mut self.identifier.gamma {
            *gamma = PerParameter::from_fn(|parameter| factor * gamma.get(parameter));
        }
        Ok(())
    }
}

impl<N, V, S, const P: usize> FromSettings for GradientRecursion<N, V, S, P>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    /// # Errors
    /// See [`SettingsError`]. It names a range or the certificate's inequality. It may also name the servo whose
    /// sampled loop is unstable, or the estimate whose sampled correction is.
    ///
    /// In fixed point also a missing bound from which a full scale follows: `bounds.b` (unless there is a parameter
    /// range), `bounds.coulomb` or `bounds.load`. Also a range, bound, gain or sample time
    /// that does not fit, with the value that would.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let velocity = settings.velocity::<N, V>()?;
        let (mut plan, scales) =
            GradientPlan::<P>::in_arithmetic::<N, S>(settings, &velocity.transfer())?;
        let law = match settings.identifier.gamma {
            Some(_) => plan.law::<N, S>(&scales),
            None => plan.lowered_law::<N, S>(&scales),
        };
        let (pieces, windows) = plan.windows::<N, S>(settings, &scales)?;
        let GradientPlan { units, gains, .. } = plan;
        let reach = N::REACH.value(scales.velocity);
        Ok(Self {
            model: ModelLoop::new(velocity, &units, &gains, &scales),
            law: law?,
            pieces,
            windows,
            standstill: Standstill::new(&units, &scales),
            most: N::signal(settings.most_increment(&units, reach)?, scales.velocity),
            increments: N::counts(scales.velocity),
            initial: core::array::from_fn(|i| {
                let parameter = S::PARAMETERS[i];
                scales.estimate_of(parameter, plan.initial[i] * parameter.scale(&units))
            }),
            bounds: plan.bounds,
            gamma: plan.gamma,
            mu: plan.mu,
            scales,
            units,
            stability_check: plan.stability_check,
            set: PhantomData,
        })
    }
}

impl<N, V, S, const P: usize> FromSettings for GradientIdentifier<N, V, S, P>
where
    N: Arithmetic,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    /// # Errors
    /// As [`GradientRecursion`]'s.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError> {
        let recursion: GradientRecursion<N, V, S, P> = settings.build()?;
        Ok(Self {
            memory: recursion.memory(),
            recursion,
        })
    }
}
