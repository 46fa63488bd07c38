use core::fmt;

use super::gradient::plant_box;
use super::{ControllerSettings, Settings, SettingsError, diagonal};
use crate::adaptation::Gradient;
use crate::control::{ControlState, Controller};
use crate::excitation::Excitation;
use crate::interval::Interval;
use crate::linalg::PositiveDefinite;
use crate::measurement::velocity::VelocityEstimate;
use crate::model::ZeroOrderHoldStep;
use crate::parameters::{Parameter, ParameterSet};
use crate::stability::PlantBox;
use crate::units::Units;

/// Why no Γ can be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum GainError {
    /// The reference leaves a servo of the box at rest.
    AtRest,
    /// The loop around a servo of the box leaves the range of numbers.
    Unstable,
}

impl fmt::Display for GainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AtRest => {
                "the reference does not move the servo, so that nothing can be learnt and no gamma \
                 follows from it: choose a reference that moves, or state gamma"
            }
            Self::Unstable => {
                "the loop around a servo of the box is unstable, so that no gamma follows from it: \
                 lower the gains, sample faster, or shrink the box"
            }
        })
    }
}

impl core::error::Error for GainError {}

impl Settings {
    /// The automatic Γ for the parameters of the set S in the loop of these settings with the velocity
    /// estimate V: from the box, or without one the servo of the initial estimates, the reference, of
    /// which `samples` are played, and the sample time. It is over a, b, Coulomb friction and load, with
    /// one on the diagonal for a parameter that S does not have.
    ///
    /// A loop that another controller closes is taken to be like the correction's.
    ///
    /// # Errors
    /// A setting that is not allowed, or is missing; [`GainError`] if the reference leaves a servo of the
    /// box at rest, or the loop around one is unstable.
    pub fn automatic_gamma<V, S, const P: usize>(
        &self,
        reference: &impl Excitation<f64>,
        samples: u32,
    ) -> Result<[[f64; 4]; 4], SettingsError>
    where
        V: VelocityEstimate<f64>,
        S: ParameterSet<P>,
    {
        let units = self.units()?;
        let gains = self.correction_gains()?;
        let like_the_correction = ControllerSettings::pid(gains.kp(), gains.kd(), gains.ki());
        let automatic = AutomaticGain {
            units,
            plant_box: self.assumed_box()?,
            kd: gains.kd(),
            samples,
        };
        let in_loop = Self {
            controller: self.controller.or(Some(like_the_correction)),
            ..*self
        };
        let controller: Controller<f64, V> = in_loop.build()?;
        let gamma = automatic.gamma::<S, V, _, P>(&controller, reference)?;
        let place = |parameter| Parameter::ALL.iter().position(|&one| one == parameter);
        let mut spread = diagonal([1.0; 4]);
        for (row, of) in gamma.entries().iter().zip(S::PARAMETERS) {
            for (&entry, beside) in row.iter().zip(S::PARAMETERS) {
                if let (Some(i), Some(j)) = (place(of), place(beside)) {
                    spread[i][j] = entry;
                }
            }
        }
        Ok(spread)
    }

    /// The box that Γ is chosen for: the stated one, or the servo of the initial estimates.
    fn assumed_box(&self) -> Result<PlantBox, SettingsError> {
        if let Some(stated) = plant_box(self)? {
            return Ok(stated);
        }
        let initial = &self.identifier.initial;
        let b = initial.b.ok_or(SettingsError::NotGiven {
            setting: "initial.b",
        })?;
        let a = initial.a.unwrap_or(0.0).max(0.0);
        Ok(PlantBox::new(
            Interval::new("initial.a", a, a)?,
            Interval::new("initial.b", b, b)?,
        )?)
    }
}

/// The automatic Γ: from the box, the excitation and the sample time.
///
/// The sampled loop around each corner servo of the box is simulated with the reference, and the
/// second moments of the regressor (9) are taken, E q̇² and E u². From these:
///
/// - **Ratio.** (11) moves an estimate at a rate proportional to Γᵢᵢ E φᵢ². Equal rates ask for
///   Γ_a/Γ_b = E u²/E q̇², and Γ_c/Γ_b = E u² for friction and load; the smallest such ratio of the
///   corners is taken, since a Γ_a too large in proportion to Γ_b makes â oscillate (one too small
///   only makes it slower).
/// - **Size.** The guard allows T φᵀΓφ up to ρ α_min. Γ is sized so that the *mean* of T φᵀΓφ
///   reaches [`AutomaticGain::STRENGTH`] times that bound at the corner where it is smallest: the
///   guard then sets the pace in the transients, where the information is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct AutomaticGain {
    /// Sample time and resolution of the loop, SI.
    units: Units,
    /// The box of servos.
    plant_box: PlantBox,
    /// The derivative gain k_d, for the smallest α.
    kd: f64,
    /// Samples that are simulated at each corner.
    samples: u32,
}

impl AutomaticGain {
    /// Mean of T φᵀΓφ over the guard's bound, at the least excited corner.
    const STRENGTH: f64 = 1.0;

    /// Γ for the parameters of a set under a controller and an excitation, SI.
    ///
    /// # Errors
    /// If the excitation leaves a corner servo at rest, or the loop around one is unstable, no Γ
    /// follows from what is seen.
    fn gamma<S, V, E, const P: usize>(
        &self,
        controller: &Controller<f64, V>,
        excitation: &E,
    ) -> Result<PositiveDefinite<P>, GainError>
    where
        S: ParameterSet<P>,
        V: VelocityEstimate<f64>,
        E: Excitation<f64>,
    {
        let (a, b) = (self.plant_box.a(), self.plant_box.b());
        let corners = [
            (a.min(), b.min()),
            (a.min(), b.max()),
            (a.max(), b.min()),
            (a.max(), b.max()),
        ]
        .map(|(a, b)| self.moments(controller, excitation, a, b));
        if corners
            .iter()
            .any(|m| !m.command.is_finite() || !m.velocity.is_finite())
        {
            return Err(GainError::Unstable);
        }
        if corners
            .iter()
            .any(|m| m.command == 0.0 || m.velocity == 0.0)
        {
            return Err(GainError::AtRest);
        }
        // Friction and load have regressors of magnitude one.
        let moment = |m: &Moments, parameter: Parameter| match parameter {
            Parameter::A => m.velocity,
            Parameter::B => m.command,
            Parameter::Coulomb | Parameter::Load => 1.0,
        };
        let least =
            |of: &dyn Fn(&Moments) -> f64| corners.iter().map(of).fold(f64::INFINITY, f64::min);
        let ratios = S::PARAMETERS.map(|p| least(&|m: &Moments| m.command / moment(m, p)));
        let strength = least(&|m: &Moments| {
            let terms = S::PARAMETERS.iter().zip(ratios);
            terms.map(|(&p, ratio)| ratio * moment(m, p)).sum()
        });
        let decay = self.plant_box.slowest_decay(self.kd);
        let bound = Gradient::<f64, P>::GUARD * decay / self.units.sample_time();
        let gamma_b = Self::STRENGTH * bound / strength;
        PositiveDefinite::diagonal(ratios.map(|ratio| ratio * gamma_b))
            .map_err(|_| GainError::Unstable)
    }

    /// E q̇² and E u² of the loop around one servo, SI.
    fn moments<V, E>(
        &self,
        controller: &Controller<f64, V>,
        excitation: &E,
        a: f64,
        b: f64,
    ) -> Moments
    where
        V: VelocityEstimate<f64>,
        E: Excitation<f64>,
    {
        let step = ZeroOrderHoldStep::<f64>::new();
        let x = a * self.units.rate();
        let gain = b * self.units.acceleration();
        let mut reference = excitation.start();
        let mut control = ControlState::default();
        let (mut position, mut velocity, mut increment) = (0.0, 0.0, 0.0);
        let mut sum = Moments {
            velocity: 0.0,
            command: 0.0,
        };
        for _ in 0..self.samples {
            let wanted = excitation.process(&mut reference);
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
        let count = f64::from(self.samples);
        let per_velocity = self.units.velocity();
        Moments {
            velocity: sum.velocity / (count * per_velocity * per_velocity),
            command: sum.command / count,
        }
    }
}

/// Second moments of the regressor, SI.
#[derive(Debug, Clone, Copy)]
struct Moments {
    velocity: f64,
    command: f64,
}
