use super::parameter_range::nominal_range;
use super::{ControllerSettings, GainError, Settings, SettingsError};
use crate::control::{ControlState, Controller, Gains, Shaped};
use crate::error::Allowed;
use crate::excitation::Excitation;
use crate::gradient::Gradient;
use crate::measurement::velocity::VelocityEstimate;
use crate::model::ZeroOrderHoldStep;
use crate::parameters::{Parameter, ParameterSet, PerParameter};
use crate::stability::ParameterRange;
use crate::units::Units;

impl Settings {
    /// The automatic Γ for the parameters of the set S, in the loop of these settings with the velocity estimate V. It
    /// follows from the parameter range, or without one from the servo of the initial estimates. It also follows from
    /// the sample time and the reference, of which `samples` are played. It is one for a parameter that S does not have.
    ///
    /// A loop that another controller closes is taken to be like the correction's.
    ///
    /// # Errors
    /// A setting that is not allowed, or is missing. [`GainError`] if the reference leaves a servo of the parameter
    /// range at rest, or the loop around one is unstable.
    pub fn automatic_gamma<V, S, const P: usize>(
        &self,
        reference: &impl Excitation<f64>,
        samples: u32,
    ) -> Result<PerParameter<f64>, SettingsError>
    where
        V: VelocityEstimate<f64>,
        S: ParameterSet<P>,
    {
        let units = self.units()?;
        let gains = self.correction_gains()?;
        let like_the_correction = ControllerSettings::pid(gains.kp(), gains.kd(), gains.ki());
        let range = nominal_range(self)?;
        let in_loop = Self {
            controller: self.controller.or(Some(like_the_correction)),
            ..*self
        };
        let controller: Controller<f64, V, Shaped<f64>> = in_loop.build()?;
        let moments = corners(&range)
            .map(|(a, b)| simulated_moments(&units, &controller, reference, samples, a, b));
        let gamma = gamma_for::<S, P>(&units, &range, gains.kd(), moments)?;
        Ok(PerParameter::of_set::<S, P>(&gamma, 1.0))
    }
}

/// The corner servos of a parameter range: a, 1/s, and b, rad/s² per command unit.
fn corners(range: &ParameterRange) -> [(f64, f64); 4] {
    let (a, b) = (range.a(), range.b());
    [
        (a.min(), b.min()),
        (a.min(), b.max()),
        (a.max(), b.min()),
        (a.max(), b.max()),
    ]
}

/// The Γ of a loop whose reference is unknown. Its command is assumed to have an eighth of the limit in the root mean
/// square. It is at the loop's natural frequency ω = √(b k_p), so b u = ω q̇.
///
/// A larger share adapts slowly at a small motion. A smaller one disturbs the estimates of a servo that runs at its
/// limit.
///
/// # Errors
/// See [`GainError`].
pub(crate) fn gamma_by_limit<S: ParameterSet<P>, const P: usize>(
    units: &Units,
    range: &ParameterRange,
    gains: &Gains,
    limit: f64,
) -> Result<[f64; P], GainError> {
    /// Root mean square of the command over its limit.
    const SHARE: f64 = 0.125;
    let command = SHARE * limit * SHARE * limit;
    let moments = corners(range).map(|(_, b)| Moments {
        velocity: command * b / gains.kp(),
        command,
    });
    gamma_for::<S, P>(units, range, gains.kd(), moments)
}

/// Mean of T φᵀΓφ over the guard's bound, for the corner of the least excitation. With the whole bound the estimator would
/// disturb what its memory knows, until half a minute has passed.
const STRENGTH: f64 = 0.01;

/// The automatic Γ for the parameters of a set, SI. It follows from the second moments of the regressor (9), E q̇² and
/// E u², at the corners of a parameter range.
///
/// - **Ratio.** (11) moves an estimate at a rate proportional to Γᵢᵢ E φᵢ². Equal rates require Γ_a/Γ_b = E u²/E q̇²,
///   and Γ_c/Γ_b = E u² for friction and load. The smallest such ratio of the corners is used. A Γ_a too large in
///   proportion to Γ_b makes â oscillate; one too small only makes it slower.
/// - **Size.** The guard allows T φᵀΓφ up to ρ α_min. The size of Γ is such that the *mean* of T φᵀΓφ reaches
///   [`STRENGTH`] times that bound at the corner where it is smallest.
///
/// # Errors
/// No Γ follows from a servo at rest or a loop that is unstable.
fn gamma_for<S: ParameterSet<P>, const P: usize>(
    units: &Units,
    range: &ParameterRange,
    kd: f64,
    moments: [Moments; 4],
) -> Result<[f64; P], GainError> {
    let mut both = moments.iter().flat_map(|m| [m.command, m.velocity]);
    if !both.clone().all(f64::is_finite) {
        return Err(GainError::Unstable);
    }
    if both.any(|moment| moment == 0.0) {
        return Err(GainError::AtRest);
    }
    // Friction and load have regressors of magnitude one.
    let moment = |m: &Moments, parameter: Parameter| match parameter {
        Parameter::A => m.velocity,
        Parameter::B => m.command,
        Parameter::Coulomb | Parameter::Load => 1.0,
    };
    let ratios = S::PARAMETERS.map(|p| least(&moments, |m| m.command / moment(m, p)));
    let strength = least(&moments, |m| {
        let terms = S::PARAMETERS.iter().zip(ratios);
        terms.map(|(&p, ratio)| ratio * moment(m, p)).sum()
    });
    let bound = Gradient::<f64, P>::GUARD * range.slowest_decay(kd) / units.sample_time();
    let gamma_b = STRENGTH * bound / strength;
    let gamma = ratios.map(|ratio| ratio * gamma_b);
    let is_allowed = gamma.iter().all(|&entry| Allowed::Above(0.0).holds(entry));
    is_allowed.then_some(gamma).ok_or(GainError::Unstable)
}

fn least(moments: &[Moments; 4], of: impl Fn(&Moments) -> f64) -> f64 {
    moments.iter().map(of).fold(f64::INFINITY, f64::min)
}

/// E q̇² and E u² of the loop around one servo, SI, over this number of samples of a reference.
fn simulated_moments<V, E>(
    units: &Units,
    controller: &Controller<f64, V, Shaped<f64>>,
    reference: &E,
    samples: u32,
    a: f64,
    b: f64,
) -> Moments
where
    V: VelocityEstimate<f64>,
    E: Excitation<f64>,
{
    let step = ZeroOrderHoldStep::<f64>::new();
    let x = a * units.rate();
    let gain = b * units.acceleration();
    let mut excitation = reference.start();
    let mut control = ControlState::default();
    let (mut position, mut velocity, mut increment) = (0.0, 0.0, 0.0);
    let mut sum = Moments {
        velocity: 0.0,
        command: 0.0,
    };
    for _ in 0..samples {
        let wanted = reference.process(&mut excitation);
        let error = wanted - position;
        let Ok(sample) = controller.process(&mut control, error, increment) else {
            // Beyond the format's range: no number is large enough for it.
            sum.command = f64::INFINITY;
            break;
        };
        sum.velocity += velocity * velocity;
        sum.command += sample.command * sample.command;
        let motion = step.process(x, gain * sample.command, velocity);
        position += motion.increment;
        increment = motion.increment;
        velocity = motion.velocity;
    }
    let count = f64::from(samples);
    let per_velocity = units.velocity();
    Moments {
        velocity: sum.velocity / (count * per_velocity * per_velocity),
        command: sum.command / count,
    }
}

/// Second moments of the regressor, SI.
#[derive(Debug, Clone, Copy)]
struct Moments {
    velocity: f64,
    command: f64,
}
