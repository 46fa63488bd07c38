//! What a servo has beside q̈ = −a q̇ + b u + d − c sign(q̇).

use core::fmt;

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::model::ServoParameters;

/// The effects of a real servo, SI. Zero is an effect that is absent, and [`Effects::NONE`] a servo
/// that has none.
///
/// The command passes, in this order: the hidden limit, the dead band, the delay, the current loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effects {
    /// Time from a command to its acting, s: any fraction of a sample, up to
    /// [`Effects::LONGEST_DELAY`] and [`Effects::MOST_DELAYED`] samples.
    pub delay: f64,
    /// Time constant of the first-order lag with which the acting command follows, s.
    pub current_loop: f64,
    /// Half of what viscous friction has more in positive direction than in negative, 1/s: it is
    /// −(a + δa sign q̇) q̇, with |δa| no larger than a.
    pub asymmetry: f64,
    /// What friction has in addition at low speed, s e^(−(q̇/v)²), rad/s²; no less than −c. With a
    /// positive one the servo breaks away at c + s (Stribeck).
    pub low_speed_friction: f64,
    /// The speed v in it, rad/s.
    pub low_speed_velocity: f64,
    /// [g_s, g_c], rad/s²: gravity accelerates by g_s sin q + g_c cos q, q being zero where the servo
    /// starts.
    pub gravity: [f64; 2],
    /// [r_s, r_c], rad/s²: cogging accelerates by r_s sin Nq + r_c cos Nq.
    pub ripple: [f64; 2],
    /// Its order N, periods per revolution.
    pub ripple_order: u32,
    /// The command that a bridge lets pass without effect to either side, command units: u acts as
    /// u − clamp(u, −δ, δ).
    pub dead_band: f64,
    /// Resonance of motor and load on the spring between them, both free, rad/s. The encoder is the
    /// motor's, and so is friction; load and gravity act behind the spring. a and b are those of both
    /// as one rigid body.
    pub resonance: f64,
    /// Its damping ratio; none for [`Effects::RESONANCE_DAMPING`].
    pub resonance_damping: Option<f64>,
    /// The load's share of the inertia.
    pub inertia_ratio: f64,
    /// Play between the motor and an encoder on the load, rad: the load is taken along by the end of
    /// the play and stands within it, without an effect on the motor.
    pub backlash: f64,
    /// Relative change of b in a second, 1/s.
    pub gain_drift: f64,
    /// Relative change of all friction in a second, 1/s.
    pub friction_drift: f64,
    /// Where the amplifier clips although nobody says so, command units.
    pub hidden_limit: f64,
    /// Standard deviation, rad/s², and time constant, s, of a load that wanders in addition
    /// (first-order Gauss–Markov).
    pub load_wander: [f64; 2],
}

/// Why a servo cannot have some effects.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum EffectError {
    /// A value outside its range.
    Range(OutOfRange),
    /// An effect that needs another value beside it.
    Needs {
        /// What is given.
        effect: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// Two effects that contradict each other: the encoder is on the load for the one and on the motor
    /// for the other.
    Contradiction {
        /// The one.
        effect: &'static str,
        /// The other.
        other: &'static str,
    },
}

impl EffectError {
    /// The name of the value that is wrong.
    #[must_use]
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::Range(error) => error.parameter,
            Self::Needs { effect, .. } | Self::Contradiction { effect, .. } => effect,
        }
    }
}

impl From<OutOfRange> for EffectError {
    fn from(error: OutOfRange) -> Self {
        Self::Range(error)
    }
}

impl fmt::Display for EffectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(error) => error.fmt(f),
            Self::Needs { effect, needs } => {
                write!(
                    f,
                    "{effect} does nothing without {needs}: state both or none"
                )
            }
            Self::Contradiction { effect, other } => write!(
                f,
                "{effect} has the encoder on the load, {other} on the motor: state one of them"
            ),
        }
    }
}

impl core::error::Error for EffectError {}

impl Effects {
    /// The servo as the identifiers' model has it.
    pub const NONE: Self = Self {
        delay: 0.0,
        current_loop: 0.0,
        asymmetry: 0.0,
        low_speed_friction: 0.0,
        low_speed_velocity: 0.0,
        gravity: [0.0; 2],
        ripple: [0.0; 2],
        ripple_order: 0,
        dead_band: 0.0,
        resonance: 0.0,
        resonance_damping: None,
        inertia_ratio: 0.0,
        backlash: 0.0,
        gain_drift: 0.0,
        friction_drift: 0.0,
        hidden_limit: 0.0,
        load_wander: [0.0; 2],
    };

    /// The longest delay, s.
    pub const LONGEST_DELAY: f64 = 0.1;
    /// The longest delay, samples.
    pub const MOST_DELAYED: usize = 64;
    /// The longest time constant of a current loop, s.
    pub const SLOWEST_CURRENT_LOOP: f64 = 1.0;
    /// The largest of the accelerations that depend on the angle, rad/s².
    pub const LARGEST_ACCELERATION: f64 = 1e6;
    /// The highest order of a ripple.
    pub const HIGHEST_ORDER: u32 = 10_000;
    /// The highest resonance, rad/s.
    pub const HIGHEST_RESONANCE: f64 = 1e5;
    /// The damping ratio of a resonance of which none is stated: steel with little play.
    pub const RESONANCE_DAMPING: f64 = 0.02;
    /// The fastest drift, 1/s.
    pub const FASTEST_DRIFT: f64 = 0.1;

    /// Whether a servo of these parameters can have them, at a sample time in s.
    ///
    /// # Errors
    /// The first value that is not allowed, that lacks its companion or that contradicts another.
    pub fn check(&self, servo: &ServoParameters, sample_time: f64) -> Result<(), EffectError> {
        const NOT_NEGATIVE: Allowed = Allowed::AtLeast(0.0);
        const SHARE: Allowed = Allowed::Between(0.0, 1.0);
        const ANGULAR: Allowed = Allowed::Within(
            -Effects::LARGEST_ACCELERATION,
            Effects::LARGEST_ACCELERATION,
        );
        const DRIFT: Allowed = Allowed::Within(-Effects::FASTEST_DRIFT, Effects::FASTEST_DRIFT);

        let longest = Self::LONGEST_DELAY.min(Self::MOST_DELAYED as f64 * sample_time);
        Allowed::Within(0.0, longest).check("delay", self.delay)?;
        Allowed::Within(0.0, Self::SLOWEST_CURRENT_LOOP)
            .check("current_loop", self.current_loop)?;
        Allowed::Within(-servo.a, servo.a).check("asymmetry", self.asymmetry)?;
        Allowed::AtLeast(-servo.coulomb).check("low_speed_friction", self.low_speed_friction)?;
        NOT_NEGATIVE.check("low_speed_velocity", self.low_speed_velocity)?;
        for value in self.gravity {
            ANGULAR.check("gravity", value)?;
        }
        for value in self.ripple {
            ANGULAR.check("ripple", value)?;
        }
        let order = f64::from(self.ripple_order);
        Allowed::Within(0.0, f64::from(Self::HIGHEST_ORDER)).check("ripple_order", order)?;
        NOT_NEGATIVE.check("dead_band", self.dead_band)?;
        Allowed::Within(0.0, Self::HIGHEST_RESONANCE).check("resonance", self.resonance)?;
        if let Some(damping) = self.resonance_damping {
            Allowed::Within(0.0, 1.0).check("resonance_damping", damping)?;
        }
        if self.inertia_ratio != 0.0 {
            SHARE.check("inertia_ratio", self.inertia_ratio)?;
        }
        NOT_NEGATIVE.check("backlash", self.backlash)?;
        DRIFT.check("gain_drift", self.gain_drift)?;
        DRIFT.check("friction_drift", self.friction_drift)?;
        NOT_NEGATIVE.check("hidden_limit", self.hidden_limit)?;
        for value in self.load_wander {
            NOT_NEGATIVE.check("load_wander", value)?;
        }
        self.check_companions()
    }

    fn check_companions(&self) -> Result<(), EffectError> {
        let low_speed = (
            self.low_speed_friction != 0.0,
            self.low_speed_velocity != 0.0,
        );
        let ripple = (any(self.ripple), self.ripple_order != 0);
        let resonance = (self.resonance != 0.0, self.inertia_ratio != 0.0);
        together("low_speed_friction", "low_speed_velocity", low_speed)?;
        together("ripple", "ripple_order", ripple)?;
        together("resonance", "inertia_ratio", resonance)?;
        if self.resonance_damping.is_some() {
            together("resonance_damping", "resonance", (true, resonance.0))?;
        }
        let [deviation, time] = self.load_wander;
        if deviation > 0.0 {
            Allowed::Above(0.0).check("load_wander", time)?;
        }
        if self.backlash > 0.0 && resonance.0 {
            return Err(EffectError::Contradiction {
                effect: "backlash",
                other: "resonance",
            });
        }
        Ok(())
    }

    /// Whether something happens to the command before it acts, apart from its lag.
    pub(crate) fn change_the_command(&self) -> bool {
        any([self.delay, self.dead_band, self.hidden_limit])
    }

    /// Whether the closed form of a, b, c and d does not describe the motion.
    pub(crate) fn change_the_motion(&self) -> bool {
        let without = Self {
            delay: 0.0,
            dead_band: 0.0,
            hidden_limit: 0.0,
            backlash: 0.0,
            ..*self
        };
        without != Self::NONE
    }

    /// The same effects on another servo: what belongs to its friction is as large a share of it.
    #[must_use]
    pub fn carried_over(&self, from: &ServoParameters, to: &ServoParameters) -> Self {
        let share = |of: f64, whole: f64| if of > 0.0 { whole / of } else { 0.0 };
        let low_speed_friction = self.low_speed_friction * share(from.coulomb, to.coulomb);
        let still_there = low_speed_friction != 0.0;
        Self {
            asymmetry: self.asymmetry * share(from.a, to.a),
            low_speed_friction,
            low_speed_velocity: if still_there {
                self.low_speed_velocity
            } else {
                0.0
            },
            ..*self
        }
    }
}

impl Default for Effects {
    fn default() -> Self {
        Self::NONE
    }
}

/// Whether any of some values is not zero.
pub(crate) fn any<const COUNT: usize>(values: [f64; COUNT]) -> bool {
    values.iter().any(|&value| value != 0.0)
}

/// Whether of two values both are given, or neither.
fn together(
    first: &'static str,
    second: &'static str,
    given: (bool, bool),
) -> Result<(), EffectError> {
    let (effect, needs) = match given {
        (true, false) => (first, second),
        (false, true) => (second, first),
        _ => return Ok(()),
    };
    Err(EffectError::Needs { effect, needs })
}
