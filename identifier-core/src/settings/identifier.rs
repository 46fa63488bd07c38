use crate::parameters::{PerParameter, Terms};

/// The settings of the identifiers, SI; each uses its own part.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct IdentifierSettings {
    /// Estimates to begin with. None: zero, or for b the middle of the parameter range. Gauss–Newton needs none of
    /// them.
    pub initial: PerParameter<Option<f64>>,
    /// Parameters that are known: they stay at their initial values.
    pub known: PerParameter<bool>,
    /// Bounds of the estimates, lowest and highest. None: as wide as the sample time and the
    /// correction permit, independent of the initial values.
    pub bounds: PerParameter<Option<[f64; 2]>>,
    /// Standard deviations of the initial estimates, for Gauss–Newton. None: no initial
    /// information.
    pub uncertainty: PerParameter<Option<f64>>,
    /// The least standard deviation of the position noise, rad; Gauss–Newton finds a larger one. None: an
    /// encoder's, a count over √12.
    pub noise: Option<f64>,
    /// Where the true servo may lie, to be certified. None: nothing is certified.
    #[cfg_attr(feature = "serde", serde(rename = "servo_range"))]
    pub parameter_range: Option<ParameterRangeSettings>,
    /// The diagonal of Γ, positive for each of the model's parameters; the others do not count. None: chosen from
    /// parameter range, gains and the limit of the controller, which must then be stated.
    pub gamma: Option<PerParameter<f64>>,
    /// μ of the gradient estimator, 1/s. None: chosen from gains and parameter range.
    pub mu: Option<f64>,
    /// Gains of the gradient's correction in command form (kp, kd, ki as of a PID). None: those of
    /// the controller, which makes the model loop the paper's.
    pub correction: Option<[f64; 3]>,
    /// Bandwidth of the position loop, rad/s, for the correction in acceleration form; right within a
    /// factor of four. None: follows from the sample time and the first fit.
    pub bandwidth: Option<f64>,
    /// The time span of Gauss–Newton's first fit, s. None: a second; the fit is tried from half of it
    /// on until it succeeds.
    pub start_time: Option<f64>,
    /// The memory of Gauss–Newton, s, for a servo that changes. None: unlimited.
    pub memory: Option<f64>,
    /// Optional terms of the model, for Gauss–Newton, and the declared amplifier, for every estimator.
    pub terms: TermSettings,
    /// The largest speed of the servo, rad/s. A larger jump of the count is rejected. None: the most that the number
    /// format counts exactly in a sample.
    pub max_speed: Option<f64>,
    /// The ranges of the signals in fixed point. None: they follow from limit, gains and bounds.
    pub ranges: Option<RangeSettings>,
}

/// The optional terms of a model and their declared values, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TermSettings {
    /// Terms that are estimated as soon as the motion allows.
    pub demanded: Terms,
    /// The declared delay, s, in addition to a declared current loop. It acts in
    /// [`Amplifier`](crate::model::Amplifier); if it is a term to be estimated, the estimate begins at it.
    pub delay: f64,
    /// The declared dead band, command units; it acts like the declared delay.
    pub dead_band: f64,
    /// The time constant of a first-order current loop, s, which acts in
    /// [`Amplifier`](crate::model::Amplifier).
    pub current_loop: f64,
    /// v_s of friction at low speed, rad/s.
    pub low_speed_velocity: Option<f64>,
    /// The order N of the ripple: periods to a revolution.
    pub ripple_order: Option<f64>,
    /// The angle after which gravity and ripple repeat, rad. It is 2π on a motor's shaft. For a linear motor it is the
    /// pole pitch in m over which the ripple of order one repeats.
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
        delay: 0.0,
        dead_band: 0.0,
        current_loop: 0.0,
        low_speed_velocity: None,
        ripple_order: None,
        revolution: core::f64::consts::TAU,
    };

    /// True if an effect of the amplifier is declared.
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
}

/// The ranges of a loop's signals in fixed point, SI: the full scales of the words are no smaller. A
/// signal beyond its range saturates, it never wraps. Laid out as C does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct RangeSettings {
    /// Position error and output error, rad.
    pub error: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Command, command units.
    pub command: f64,
}

/// Lowest and highest a (1/s) and b (rad/s² per command unit) of the servo, laid out as C does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[repr(C)]
pub struct ParameterRangeSettings {
    /// a, 1/s.
    pub a: [f64; 2],
    /// b, rad/s² per command unit.
    pub b: [f64; 2],
}

impl IdentifierSettings {
    /// Nothing stated.
    pub const UNSTATED: Self = Self {
        initial: PerParameter::all(None),
        known: PerParameter::all(false),
        bounds: PerParameter::all(None),
        uncertainty: PerParameter::all(None),
        noise: None,
        parameter_range: None,
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
