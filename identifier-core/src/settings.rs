//! The settings that every part is built from: plain numbers in SI, and one fallible
//! [`Settings::build`].

use crate::control::{CommandLimit, Gains};
use crate::error::{Allowed, OutOfRange};
use crate::identifier::SettingsError;
use crate::parameters::Parameter;
use crate::units::Units;
use crate::unknowns::{Term, Terms};

/// The settings of a loop and its identifier, SI. For a linear axis read m for rad.
///
/// Optional settings have a default that is stated with them. [`Settings::new`] fills all of them in,
/// so that a configuration names only what differs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Settings {
    /// Sample time, s.
    pub sample_time: f64,
    /// Position of one count, rad: 2π over the counts of a revolution after fourfold evaluation.
    pub resolution: f64,
    /// Cut-off of a [`LowPass`](crate::measurement::velocity::LowPass) velocity estimate, rad/s; other
    /// estimates have none.
    pub cutoff: f64,
    /// The PID that closes the loop; none where another controller does and the identifier only
    /// listens.
    pub controller: Option<ControllerSettings>,
    /// The identifier.
    pub identifier: IdentifierSettings,
}

/// The PID (3) and its limit, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ControllerSettings {
    /// Proportional gain, command units per rad.
    pub kp: f64,
    /// Derivative gain on the measured velocity, command units per rad/s.
    pub kd: f64,
    /// Integral gain, command units per rad s.
    pub ki: f64,
    /// Lowest and highest command, command units; infinite for none.
    pub limit: [f64; 2],
}

/// The settings of the identifiers, SI; each uses its own part.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct IdentifierSettings {
    /// Estimates to begin with. None: zero, or for b the middle of the box. Gauss–Newton and window
    /// need none of them.
    pub initial: PerParameter<Option<f64>>,
    /// Parameters that are known: they stay at their initial values.
    pub known: PerParameter<bool>,
    /// Bounds of the estimates, lowest and highest. None: as wide as the sample time and the
    /// correction permit, independent of the initial values.
    pub bounds: PerParameter<Option<[f64; 2]>>,
    /// Standard deviations of the initial estimates, for Gauss–Newton and window. None: no initial
    /// information.
    pub uncertainty: PerParameter<Option<f64>>,
    /// Standard deviation of the position noise, rad. None: an encoder's, a count over √12.
    pub noise: Option<f64>,
    /// Where the true servo may lie, to be certified. None: nothing is certified.
    pub plant_box: Option<BoxSettings>,
    /// Γ of the gradient law, symmetric positive definite over a, b, Coulomb friction and load in
    /// this order; only the rows and columns of the model's parameters count.
    pub gamma: Option<[[f64; 4]; 4]>,
    /// μ of the gradient law, 1/s. None: chosen from gains and box.
    pub mu: Option<f64>,
    /// Gains of the gradient's correction in command form (kp, kd, ki as of a PID). None: those of
    /// the controller, which makes the model loop the paper's.
    pub correction: Option<[f64; 3]>,
    /// Bandwidth of the position loop, rad/s, for the correction in acceleration form; right within a
    /// factor of four. None: follows from the sample time and the first fit.
    pub bandwidth: Option<f64>,
    /// The time span of Gauss–Newton's first fit, s. None: a second; the fit is tried from half of it
    /// on until it succeeds. Also the time span of a window; none: half a second.
    pub start_time: Option<f64>,
    /// The memory of Gauss–Newton, s, for a servo that changes. None: unlimited.
    pub memory: Option<f64>,
    /// Optional terms of the model, for Gauss–Newton and window. They are not serialised: what
    /// settings are sent to, a drive and its store, has no terms.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub terms: TermSettings,
    /// The fastest that the servo can move, rad/s; a larger jump of the count is refused. None: what
    /// the number format counts exactly in a sample.
    pub max_speed: Option<f64>,
    /// The ranges of the signals in fixed point. None: they follow from limit, gains and bounds.
    pub ranges: Option<RangeSettings>,
}

/// Which optional terms a model has, and what is declared of them, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TermSettings {
    /// Terms that are estimated as soon as the motion allows.
    pub demanded: Terms,
    /// Terms that are estimated once there is evidence for them.
    pub allowed: Terms,
    /// The delay that is known, s; besides the current loop, if that is declared too. It acts in
    /// [`BehindAmplifier`](crate::identifier::BehindAmplifier); if it is a term to be estimated, the
    /// estimate begins at it.
    pub delay: f64,
    /// The dead band that is known, command units: as the delay.
    pub dead_band: f64,
    /// The time constant of a first-order current loop, s, which acts in
    /// [`BehindAmplifier`](crate::identifier::BehindAmplifier).
    pub current_loop: f64,
    /// v_s of friction at low speed, rad/s.
    pub low_speed_velocity: Option<f64>,
    /// The order N of the ripple: periods to a revolution.
    pub ripple_order: Option<f64>,
    /// The angle after which gravity and ripple repeat, rad: 2π on a motor's shaft; a pole pitch in m
    /// over which a linear motor's ripple of order one repeats.
    pub revolution: f64,
}

impl Default for TermSettings {
    fn default() -> Self {
        Self::NONE
    }
}

impl TermSettings {
    /// No term, nothing declared, a revolution of 2π.
    pub const NONE: Self = Self {
        demanded: Terms::NONE,
        allowed: Terms::NONE,
        delay: 0.0,
        dead_band: 0.0,
        current_loop: 0.0,
        low_speed_velocity: None,
        ripple_order: None,
        revolution: core::f64::consts::TAU,
    };

    /// Whether an effect of the amplifier is declared.
    #[must_use]
    pub fn declares_amplifier(&self) -> bool {
        self.of_amplifier().next().is_some()
    }

    /// The effects of the amplifier that are declared, by their settings.
    pub(crate) fn of_amplifier(&self) -> impl Iterator<Item = &'static str> {
        [
            ("delay", self.delay),
            ("dead_band", self.dead_band),
            ("current_loop", self.current_loop),
        ]
        .into_iter()
        .filter_map(|(setting, value)| (value != 0.0).then_some(setting))
    }

    /// Whether a term may be estimated.
    #[must_use]
    pub fn may_enter(&self, term: Term) -> bool {
        self.demanded.or(self.allowed).has(term)
    }
}

/// The ranges of a loop's signals in fixed point, SI: the full scales of the words are no smaller. A
/// signal beyond its range saturates, it never wraps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RangeSettings {
    /// Position error and output error, rad.
    pub error: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Command, command units.
    pub command: f64,
}

/// Lowest and highest a (1/s) and b (rad/s² per command unit) of the servo.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BoxSettings {
    /// a, 1/s.
    pub a: [f64; 2],
    /// b, rad/s² per command unit.
    pub b: [f64; 2],
}

/// A value for each of the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PerParameter<T> {
    /// For a.
    pub a: T,
    /// For b.
    pub b: T,
    /// For Coulomb friction.
    pub coulomb: T,
    /// For the load.
    pub load: T,
}

impl<T: Copy> PerParameter<T> {
    /// The value for a parameter.
    #[must_use]
    pub fn of(&self, parameter: Parameter) -> T {
        match parameter {
            Parameter::A => self.a,
            Parameter::B => self.b,
            Parameter::Coulomb => self.coulomb,
            Parameter::Load => self.load,
        }
    }

    /// One for each parameter.
    #[must_use]
    pub fn from_fn(mut of: impl FnMut(Parameter) -> T) -> Self {
        Self {
            a: of(Parameter::A),
            b: of(Parameter::B),
            coulomb: of(Parameter::Coulomb),
            load: of(Parameter::Load),
        }
    }
}

/// A diagonal Γ over a, b, Coulomb friction and load.
#[must_use]
pub fn diagonal(entries: [f64; 4]) -> [[f64; 4]; 4] {
    core::array::from_fn(|i| core::array::from_fn(|j| if i == j { entries[i] } else { 0.0 }))
}

/// A part that [`Settings::build`] can build.
pub trait FromSettings: Sized {
    /// Builds it.
    ///
    /// # Errors
    /// The setting that is not allowed, by name, and what is.
    fn from_settings(settings: &Settings) -> Result<Self, SettingsError>;
}

impl IdentifierSettings {
    /// Nothing stated.
    pub const UNSTATED: Self = Self {
        initial: NONE,
        known: PerParameter {
            a: false,
            b: false,
            coulomb: false,
            load: false,
        },
        bounds: PerParameter {
            a: None,
            b: None,
            coulomb: None,
            load: None,
        },
        uncertainty: NONE,
        noise: None,
        plant_box: None,
        gamma: None,
        mu: None,
        correction: None,
        bandwidth: None,
        start_time: None,
        memory: None,
        terms: TermSettings::NONE,
        max_speed: None,
        ranges: None,
    };
}

const NONE: PerParameter<Option<f64>> = PerParameter {
    a: None,
    b: None,
    coulomb: None,
    load: None,
};

impl ControllerSettings {
    /// A PID without a limit.
    #[must_use]
    pub fn pid(kp: f64, kd: f64, ki: f64) -> Self {
        Self {
            kp,
            kd,
            ki,
            limit: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The same with |u| ≤ `limit`, command units.
    #[must_use]
    pub fn limited(self, limit: f64) -> Self {
        Self {
            limit: [-limit, limit],
            ..self
        }
    }

    /// The gains.
    ///
    /// # Errors
    /// See [`Gains::new`].
    pub fn gains(&self) -> Result<Gains, OutOfRange> {
        Gains::new(self.kp, self.kd, self.ki)
    }

    /// The limit.
    ///
    /// # Errors
    /// See [`CommandLimit::asymmetric`].
    pub fn command_limit(&self) -> Result<CommandLimit, OutOfRange> {
        CommandLimit::of(self.limit)
    }
}

impl Settings {
    /// Part of the sample rate that the default cut-off of a low-pass velocity estimate is: 500 rad/s
    /// at 1 kHz, as in the paper's experiment.
    const CUTOFF: f64 = 0.5;

    /// Settings for a sample time (s) and an encoder's counts per revolution after fourfold
    /// evaluation, nothing else stated.
    #[must_use]
    pub fn new(sample_time: f64, counts_per_revolution: f64) -> Self {
        Self {
            sample_time,
            resolution: core::f64::consts::TAU / counts_per_revolution,
            cutoff: Self::CUTOFF / sample_time,
            controller: None,
            identifier: IdentifierSettings::UNSTATED,
        }
    }

    /// Builds a part: a controller, an identifier, or a loop of both.
    ///
    /// # Errors
    /// The setting that is not allowed, by name, and what is.
    pub fn build<T: FromSettings>(&self) -> Result<T, SettingsError> {
        T::from_settings(self)
    }

    /// Sample time and position unit.
    ///
    /// # Errors
    /// `sample_time` or `resolution` out of range.
    pub fn units(&self) -> Result<Units, OutOfRange> {
        Units::new(self.sample_time, self.resolution).map_err(|error| OutOfRange {
            parameter: match error.parameter {
                "position_unit" => "resolution",
                other => other,
            },
            ..error
        })
    }

    /// The controller.
    ///
    /// # Errors
    /// [`SettingsError::NotGiven`] if there is none.
    pub fn own_controller(&self) -> Result<&ControllerSettings, SettingsError> {
        self.controller.as_ref().ok_or(SettingsError::NotGiven {
            setting: "controller",
        })
    }

    /// The gains of the gradient's correction in command form: those stated, or the controller's, or,
    /// where the identifier listens to another controller, gains that follow from box and bandwidth.
    ///
    /// # Errors
    /// A gain out of range; [`SettingsError::NotGiven`] if there is nothing that they follow from.
    pub fn correction_gains(&self) -> Result<Gains, SettingsError> {
        match (self.identifier.correction, self.controller) {
            (Some([kp, kd, ki]), _) => Ok(Gains::new(kp, kd, ki)?),
            (None, Some(controller)) => Ok(controller.gains()?),
            (None, None) => self.chosen_correction(),
        }
    }

    /// For the servo in the middle of the box both fast poles of the error loop at −ω and a slow one
    /// near −ω/20 for the integral, which takes the load: k_p = ω²/b, k_d = 2ω/b, k_i = k_p ω/20.
    fn chosen_correction(&self) -> Result<Gains, SettingsError> {
        /// Part of ω at which the integral acts.
        const INTEGRAL: f64 = 0.05;
        let Some(BoxSettings { b: [min, max], .. }) = self.identifier.plant_box else {
            return Err(SettingsError::NotGiven {
                setting: "correction",
            });
        };
        let omega = self.bandwidth()?;
        let b = Allowed::Above(0.0).check("plant_box.b", libm::sqrt(min * max))?;
        let kp = omega * omega / b;
        Ok(Gains::new(kp, 2.0 * omega / b, INTEGRAL * omega * kp)?)
    }

    /// Bandwidth of the correction, rad/s: the one stated, or a twentieth of the sample rate, which is
    /// what position loops are commonly sampled at.
    pub(crate) fn bandwidth(&self) -> Result<f64, OutOfRange> {
        /// Part of the sample rate.
        const COMMON: f64 = 0.05;
        let most = 0.5 / self.sample_time;
        let stated = self.identifier.bandwidth;
        Allowed::PositiveUpTo(most).check("bandwidth", stated.unwrap_or(COMMON / self.sample_time))
    }

    /// The largest increment that is taken, machine units, at most `reach`.
    pub(crate) fn most_increment(&self, units: &Units, reach: f64) -> Result<f64, OutOfRange> {
        let Some(speed) = self.identifier.max_speed else {
            return Ok(reach);
        };
        let speed = Allowed::Above(0.0).check("max_speed", speed)?;
        // At least a count, the increment of the slowest motion.
        Ok((speed * units.velocity()).max(1.0).min(reach))
    }

    /// The largest |u| that the controller's limit allows, command units.
    pub(crate) fn largest_command(&self) -> Option<f64> {
        let [low, high] = self.controller?.limit;
        let limit = high.max(-low);
        Allowed::Above(0.0).holds(limit).then_some(limit)
    }
}
