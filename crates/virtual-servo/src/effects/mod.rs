//! The effects of a servo beside q̈ = −a q̇ + b u + d − c sign(q̇).

mod check;
mod error;

pub use error::EffectError;

use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::parameters::{ServoParameters, Unknown};

/// The effects of a real servo, SI. Zero is an effect that is absent, and [`Effects::NONE`] a servo
/// that has none.
///
/// The command passes, in this order: the hidden limit, the dead band, the delay, the current loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effects {
    /// Time from a command to its acting, s: any fraction of a sample, up to
    /// [`Effects::MAX_DELAY`] and [`Effects::MAX_DELAYED_SAMPLES`] samples.
    pub delay: f64,
    /// Time constant of the first-order lag with which the acting command follows, s.
    pub current_loop: f64,
    /// Half of the excess of viscous friction in positive direction over that in negative, 1/s. The friction is −(a +
    /// δa sign q̇) q̇, with |δa| no larger than a.
    pub asymmetry: f64,
    /// Additional friction at low speed, s e^(−(q̇/v)²), rad/s²; no less than −c. With a
    /// positive one the servo breaks away at c + s (Stribeck).
    pub low_speed_friction: f64,
    /// The speed v in it, rad/s.
    pub low_speed_velocity: f64,
    /// κ, 1/rad: drag κ |q̇| q̇ in addition, up to [`Effects::LARGEST_DRAG`].
    pub quadratic_friction: f64,
    /// Additional Coulomb friction as a share of the motor's acceleration |b u|, up to [`Effects::LARGEST_SHARE`]. A
    /// gear under load has it.
    pub load_dependent_friction: f64,
    /// [g_s, g_c], rad/s²: gravity accelerates by g_s sin q + g_c cos q, q being zero where the servo
    /// starts.
    pub gravity: [f64; 2],
    /// [r_s, r_c], rad/s²: cogging accelerates by r_s sin Nq + r_c cos Nq.
    pub ripple: [f64; 2],
    /// Its order N, periods per revolution.
    pub ripple_order: u32,
    /// Further waves of cogging, each [r_s, r_c] and N.
    pub ripples: [([f64; 2], u32); Self::FURTHER_RIPPLES],
    /// [t_s, t_c]: torque ripple changes b with the angle to b (1 + t_s sin Nq + t_c cos Nq). Together they are up to
    /// [`Effects::LARGEST_SHARE`].
    pub torque_ripple: [f64; 2],
    /// Its order N, periods per revolution.
    pub torque_ripple_order: u32,
    /// [j_s, j_c]: the inertia at an angle is 1 + j_s sin Nq + j_c cos Nq of its mean. Together they are up to
    /// [`Effects::LARGEST_SHARE`]. With two masses it is the load's. The values a, b, c and d are those of the mean.
    pub inertia_variation: [f64; 2],
    /// Its order N, periods per revolution.
    pub inertia_order: u32,
    /// Half of what b has more for positive commands than for negative, as a share of b, up to
    /// [`Effects::LARGEST_SHARE`].
    pub gain_asymmetry: f64,
    /// The command to either side of zero that a bridge ignores, command units: u acts as u − clamp(u, −δ, δ).
    pub dead_band: f64,
    /// Resonance of motor and load on the spring between them, both free, rad/s. Friction is the motor's, but for
    /// `load_friction`, and so is the encoder, but for `encoder_on_load`. Load and gravity act behind the spring. The values a and b are those of both as one rigid body.
    pub resonance: f64,
    /// Its damping ratio; none for [`Effects::RESONANCE_DAMPING`].
    pub resonance_damping: Option<f64>,
    /// The load's share of the inertia.
    pub inertia_ratio: f64,
    /// Coulomb friction of the load behind the spring, rad/s² of both as one rigid body, in addition to the motor's.
    pub load_friction: f64,
    /// True if the encoder shows the load and not the motor.
    pub encoder_on_load: bool,
    /// Play from end to end, rad. With a resonance it is that of the coupling: within it motor and load do not feel
    /// each other. Without one it lies between the motor and an encoder on the load. The end of the backlash takes the
    /// encoder along. Within it the encoder is at standstill, without an effect on the motor.
    pub backlash: f64,
    /// Relative change of b in a second, 1/s.
    pub gain_drift: f64,
    /// Relative change of all friction in a second, 1/s.
    pub friction_drift: f64,
    /// A limit of the amplifier that the controller does not know, command units.
    pub hidden_limit: f64,
    /// Standard deviation, rad/s², and time constant, s, of a load that wanders in addition
    /// (first-order Gauss–Markov).
    pub load_wander: [f64; 2],
}

impl Effects {
    /// The servo as the identifiers' model has it.
    pub const NONE: Self = Self {
        delay: 0.0,
        current_loop: 0.0,
        asymmetry: 0.0,
        low_speed_friction: 0.0,
        low_speed_velocity: 0.0,
        quadratic_friction: 0.0,
        load_dependent_friction: 0.0,
        gravity: [0.0; 2],
        ripple: [0.0; 2],
        ripple_order: 0,
        ripples: [([0.0; 2], 0); Self::FURTHER_RIPPLES],
        torque_ripple: [0.0; 2],
        torque_ripple_order: 0,
        inertia_variation: [0.0; 2],
        inertia_order: 0,
        gain_asymmetry: 0.0,
        dead_band: 0.0,
        resonance: 0.0,
        resonance_damping: None,
        inertia_ratio: 0.0,
        load_friction: 0.0,
        encoder_on_load: false,
        backlash: 0.0,
        gain_drift: 0.0,
        friction_drift: 0.0,
        hidden_limit: 0.0,
        load_wander: [0.0; 2],
    };

    /// The waves of cogging beside the first.
    pub const FURTHER_RIPPLES: usize = 3;
    /// The longest delay, s.
    pub const MAX_DELAY: f64 = 0.1;
    /// The longest delay, samples.
    pub const MAX_DELAYED_SAMPLES: usize = 64;
    /// The longest time constant of a current loop, s.
    pub const SLOWEST_CURRENT_LOOP: f64 = 1.0;
    /// The largest of the accelerations that depend on the angle, rad/s².
    pub const LARGEST_ACCELERATION: f64 = 1e6;
    /// The largest drag, 1/rad.
    pub const LARGEST_DRAG: f64 = 1e6;
    /// The largest share of gain, inertia and the motor's push.
    pub const LARGEST_SHARE: f64 = 0.9;
    /// The highest order of what repeats in a revolution.
    pub const HIGHEST_ORDER: u32 = 10_000;
    /// The highest resonance, rad/s.
    pub const HIGHEST_RESONANCE: f64 = 1e5;
    /// The damping ratio of a resonance of which none is stated: steel with little backlash.
    pub const RESONANCE_DAMPING: f64 = 0.02;
    /// The shares of the inertia that a load can have.
    pub const INERTIA_RATIOS: [f64; 2] = [0.001, 0.999];
    /// The fastest drift, 1/s.
    pub const FASTEST_DRIFT: f64 = 0.1;
    /// The fastest decay of motion and current where they are integrated, per sample: that many steps
    /// are not too many.
    pub const FASTEST_DECAY: f64 = 1000.0;

    /// Checks each value by itself, for a servo of these parameters and a sample time, s.
    fn check_ranges(&self, servo: &ServoParameters, sample_time: f64) -> Result<(), OutOfRange> {
        const NOT_NEGATIVE: Allowed = Allowed::AtLeast(0.0);
        const ANGULAR: Allowed = Allowed::Within(
            -Effects::LARGEST_ACCELERATION,
            Effects::LARGEST_ACCELERATION,
        );
        const SHARE: Allowed = Allowed::Within(-Effects::LARGEST_SHARE, Effects::LARGEST_SHARE);
        const DRIFT: Allowed = Allowed::Within(-Effects::FASTEST_DRIFT, Effects::FASTEST_DRIFT);

        let longest = Self::MAX_DELAY.min(Self::MAX_DELAYED_SAMPLES as f64 * sample_time);
        Allowed::Within(0.0, longest).check("delay", self.delay)?;
        if self.current_loop != 0.0 {
            let fastest = sample_time / Self::FASTEST_DECAY;
            Allowed::Within(fastest, Self::SLOWEST_CURRENT_LOOP)
                .check("current_loop", self.current_loop)?;
        }
        Allowed::Within(-servo.a, servo.a).check("asymmetry", self.asymmetry)?;
        Allowed::AtLeast(-servo.coulomb).check("low_speed_friction", self.low_speed_friction)?;
        NOT_NEGATIVE.check("low_speed_velocity", self.low_speed_velocity)?;
        Allowed::Within(0.0, Self::LARGEST_DRAG)
            .check("quadratic_friction", self.quadratic_friction)?;
        Allowed::Within(0.0, Self::LARGEST_SHARE)
            .check("load_dependent_friction", self.load_dependent_friction)?;
        for value in self.gravity {
            ANGULAR.check("gravity", value)?;
        }
        let further = self.ripples.iter().flat_map(|(wave, _)| wave);
        for value in self.ripple.iter().chain(further) {
            ANGULAR.check("ripple", *value)?;
        }
        for (name, [sine, cosine]) in [
            ("torque_ripple", self.torque_ripple),
            ("inertia_variation", self.inertia_variation),
        ] {
            SHARE.check(name, libm::hypot(sine, cosine))?;
        }
        SHARE.check("gain_asymmetry", self.gain_asymmetry)?;
        for (name, order) in [
            ("ripple_order", self.ripple_order),
            ("torque_ripple_order", self.torque_ripple_order),
            ("inertia_order", self.inertia_order),
        ] {
            Allowed::Within(0.0, f64::from(Self::HIGHEST_ORDER)).check(name, f64::from(order))?;
        }
        NOT_NEGATIVE.check("dead_band", self.dead_band)?;
        Allowed::Within(0.0, Self::HIGHEST_RESONANCE).check("resonance", self.resonance)?;
        if let Some(damping) = self.resonance_damping {
            Allowed::Within(0.0, 1.0).check("resonance_damping", damping)?;
        }
        if self.inertia_ratio != 0.0 {
            let [least, most] = Self::INERTIA_RATIOS;
            Allowed::Within(least, most).check("inertia_ratio", self.inertia_ratio)?;
        }
        NOT_NEGATIVE.check("load_friction", self.load_friction)?;
        NOT_NEGATIVE.check("backlash", self.backlash)?;
        DRIFT.check("gain_drift", self.gain_drift)?;
        DRIFT.check("friction_drift", self.friction_drift)?;
        NOT_NEGATIVE.check("hidden_limit", self.hidden_limit)?;
        for value in self.load_wander {
            NOT_NEGATIVE.check("load_wander", value)?;
        }
        Ok(())
    }

    /// The true size of a term, SI; zero for a parameter.
    #[must_use]
    pub fn size_of(&self, unknown: Unknown) -> f64 {
        match unknown {
            Unknown::Delay => self.delay,
            Unknown::Asymmetry => self.asymmetry,
            Unknown::LowSpeed => self.low_speed_friction,
            Unknown::GravitySine => self.gravity[0],
            Unknown::GravityCosine => self.gravity[1],
            Unknown::RippleSine => self.ripple[0],
            Unknown::RippleCosine => self.ripple[1],
            Unknown::DeadBand => self.dead_band,
            Unknown::A | Unknown::B | Unknown::Coulomb | Unknown::Load => 0.0,
        }
    }

    /// True if motor and load are two masses on a spring.
    pub(crate) fn are_two_masses(&self) -> bool {
        self.resonance > 0.0
    }

    /// True if the command is changed before it acts, apart from its lag.
    pub(crate) fn change_the_command(&self) -> bool {
        any([self.delay, self.dead_band, self.hidden_limit])
    }

    /// True if the closed form of a, b, c and d does not describe the motion.
    pub(crate) fn change_the_motion(&self) -> bool {
        let without = Self {
            delay: 0.0,
            dead_band: 0.0,
            hidden_limit: 0.0,
            backlash: 0.0,
            encoder_on_load: false,
            ..*self
        };
        without != Self::NONE
    }

    /// The same effects on another servo. Effects of its friction are the same share of it. If the servo has no such
    /// friction, they are unchanged.
    #[must_use]
    pub fn carried_over(&self, from: &ServoParameters, to: &ServoParameters) -> Self {
        let share = |of: f64, whole: f64| if of > 0.0 { whole / of } else { 1.0 };
        let low_speed_friction = self.low_speed_friction * share(from.coulomb, to.coulomb);
        // Rounding must not make more of it than a servo can have.
        let low_speed_friction = low_speed_friction.max(-to.coulomb);
        let still_there = low_speed_friction != 0.0;
        Self {
            asymmetry: (self.asymmetry * share(from.a, to.a)).clamp(-to.a, to.a),
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

/// True if any of some values is not zero.
pub(crate) fn any<const COUNT: usize>(values: [f64; COUNT]) -> bool {
    values.iter().any(|&value| value != 0.0)
}
