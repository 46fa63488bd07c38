//! The effects that a fit may estimate.

macro_rules! effects {
    ($(#[$meta:meta])* pub enum Effect { $($(#[$doc:meta])* $effect:ident: $unit:expr;)* }) => {
        $(#[$meta])*
        pub enum Effect {
            $($(#[$doc])* $effect,)*
        }

        impl Effect {
            /// All effects.
            pub const ALL: [Self; [$(Self::$effect),*].len()] = [$(Self::$effect),*];

            /// The powers of a count and of a sample in its unit.
            #[must_use]
            pub const fn unit(self) -> [i32; 2] {
                match self {
                    $(Self::$effect => $unit,)*
                }
            }
        }
    };
}

effects! {
/// An effect of the servo, of its amplifier or of its encoder that a fit may estimate.
///
/// q̈ (1 + i(q)) = −½ i′(q) q̇² − (a ± δa + a₂|q̇|) q̇ + b (1 + t_s sin Mq + t_c cos Mq) C(u(t − τ)) + d
/// + g_s sin q + g_c cos q + ∑ (r_s sin Nq + r_c cos Nq) − (c + s exp(−(q̇/v_s)²) + λ|F|) sign q̇,
///
/// i(q) = i_s sin Kq + i_c cos Kq. F is the acceleration by the command. C is the front end of the amplifier: current
/// loop, dead band, limit and gain by direction. The encoder shows q + e_s sin q + e_c cos q. The units of values are
/// counts, samples and command units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Effect {
    /// a, viscous friction over inertia, 1/sample.
    A: [0, -1];
    /// b, gain over inertia, counts/sample² per command unit.
    B: [1, -2];
    /// c, Coulomb friction over inertia, counts/sample².
    Coulomb: [1, -2];
    /// d, load over inertia, counts/sample².
    Load: [1, -2];
    /// τ, delay from command to acceleration, samples; negative where the command was recorded late.
    Delay: [0, 1];
    /// Time constant of the current loop, samples.
    CurrentLoop: [0, 1];
    /// δa, half the difference of viscous friction between the directions, 1/sample.
    Asymmetry: [0, -1];
    /// a₂, friction that grows with the square of the velocity, 1/count.
    Quadratic: [-1, 0];
    /// s, friction that fades with speed, counts/sample².
    LowSpeed: [1, -2];
    /// v_s, the speed at which it fades, counts/sample.
    LowSpeedVelocity: [1, -1];
    /// g_s, gravity with sin q, counts/sample².
    GravitySine: [1, -2];
    /// g_c, gravity with cos q, counts/sample².
    GravityCosine: [1, -2];
    /// r_s, ripple with sin Nq, counts/sample².
    RippleSine: [1, -2];
    /// r_c, ripple with cos Nq, counts/sample².
    RippleCosine: [1, -2];
    /// Those of further waves of ripple.
    RippleSine2: [1, -2];
    /// See `RippleSine2`.
    RippleCosine2: [1, -2];
    /// See `RippleSine2`.
    RippleSine3: [1, -2];
    /// See `RippleSine2`.
    RippleCosine3: [1, -2];
    /// See `RippleSine2`.
    RippleSine4: [1, -2];
    /// See `RippleSine2`.
    RippleCosine4: [1, -2];
    /// Dead band of the bridge to either side, command units.
    DeadBand: [0, 0];
    /// λ, friction per acceleration by the command, 1.
    LoadFriction: [0, 0];
    /// Relative change of the gain over the record, 1.
    GainDrift: [0, 0];
    /// Relative change of all friction over the record, 1.
    FrictionDrift: [0, 0];
    /// Command from which on the amplifier gives less than it is asked, command units.
    HiddenLimit: [0, 0];
    /// Part of the command beyond the hidden limit that is lost, 1.
    LimitSlope: [0, 0];
    /// Half the relative difference of the gain between the directions of the command, 1.
    GainAsymmetry: [0, 0];
    /// t_s, ripple of the gain with sin Mq, 1.
    TorqueRippleSine: [0, 0];
    /// t_c, ripple of the gain with cos Mq, 1.
    TorqueRippleCosine: [0, 0];
    /// i_s, inertia with sin Kq, 1.
    InertiaSine: [0, 0];
    /// i_c, inertia with cos Kq, 1.
    InertiaCosine: [0, 0];
    /// Twist of a compliant shaft per acceleration, which it follows at once, sample².
    Compliance: [0, 2];
    /// ω, resonance of motor and load on the spring between them, both free, rad/sample.
    ResonanceFrequency: [0, -1];
    /// ζ, its damping, 1.
    ResonanceDamping: [0, 0];
    /// ρ, the load's share of the inertia behind that spring, 1; zero without one.
    LoadShare: [0, 0];
    /// One where the encoder shows the load behind the spring, zero where it shows the motor.
    EncoderOnLoad: [0, 0];
    /// Play between motor and encoder, counts.
    Backlash: [1, 0];
    /// e_s, error of an eccentric encoder with sin q, counts.
    EccentricitySine: [1, 0];
    /// e_c, error of an eccentric encoder with cos q, counts.
    EccentricityCosine: [1, 0];
}
}

impl Effect {
    /// The number of effects.
    pub const COUNT: usize = Self::ALL.len();

    /// The effects of every servo.
    pub const BASE: [Self; 5] = [Self::A, Self::B, Self::Coulomb, Self::Load, Self::Delay];

    /// The highest order of cogging that is looked for.
    pub const MAX_ORDER: u32 = 252;

    /// The forces that go with an angle: gravity, then the waves of ripple.
    pub const FORCES: [[Self; 2]; 5] = [
        [Self::GravitySine, Self::GravityCosine],
        [Self::RippleSine, Self::RippleCosine],
        [Self::RippleSine2, Self::RippleCosine2],
        [Self::RippleSine3, Self::RippleCosine3],
        [Self::RippleSine4, Self::RippleCosine4],
    ];

    /// Which of these forces it is, and which part of it.
    pub(crate) const fn force(self) -> Option<[usize; 2]> {
        let place = (self as usize).wrapping_sub(Self::GravitySine as usize);
        if place < 2 * Self::FORCES.len() {
            Some([place / 2, place % 2])
        } else {
            None
        }
    }

    /// True of a part of a wave whose order is the setting of a column.
    pub(crate) const fn is_wave(self) -> bool {
        self.force().is_some()
            || matches!(
                self,
                Self::TorqueRippleSine
                    | Self::TorqueRippleCosine
                    | Self::InertiaSine
                    | Self::InertiaCosine
            )
    }

    /// True of an effect of every servo.
    pub(super) const fn is_base(self) -> bool {
        (self as usize) < Self::BASE.len()
    }
}

/// An effect whose tangent a pass computes, with its setting. The setting is the order of a wave, the speed at which
/// friction fades or the level of a limit. It is also the frequency of a resonance, or the width of a backlash. Zero is
/// the model's own setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column {
    /// The effect.
    pub effect: Effect,
    /// Its setting.
    pub setting: f64,
}

impl From<Effect> for Column {
    fn from(effect: Effect) -> Self {
        Self {
            effect,
            setting: 0.0,
        }
    }
}

/// The values of all effects, counts and samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Values {
    values: [f64; Effect::COUNT],
    /// The orders of the [forces](Effect::FORCES) of an angle, 1: one for gravity, then each N of ripple.
    pub orders: [f64; Effect::FORCES.len()],
    /// M, the order of the gain's ripple, 1.
    pub gain_order: f64,
    /// K, the order of the inertia's variation, 1.
    pub inertia_order: f64,
}

impl Values {
    /// The damping with which a resonance is looked for, 1.
    pub const USUAL_DAMPING: f64 = 0.05;

    /// No effect.
    pub const NONE: Self = Self {
        values: [0.0; Effect::COUNT],
        orders: [1.0; Effect::FORCES.len()],
        gain_order: 1.0,
        inertia_order: 1.0,
    };

    /// The waves of ripple, sine and cosine and order, that it has.
    pub fn ripples(&self) -> impl Iterator<Item = ([Effect; 2], f64)> {
        let waves = Effect::FORCES.into_iter().zip(self.orders).skip(1);
        waves.filter(|([sine, cosine], _)| self.get(*sine) != 0.0 || self.get(*cosine) != 0.0)
    }

    /// The amplitude of the largest.
    pub(crate) fn largest_ripple(&self) -> f64 {
        let sizes = self
            .ripples()
            .map(|(wave, _)| wave.map(|part| self.get(part)));
        sizes.fold(0.0, |most, [sine, cosine]| {
            f64::max(most, libm::hypot(sine, cosine))
        })
    }

    /// The value of an effect.
    #[must_use]
    pub const fn get(&self, effect: Effect) -> f64 {
        self.values[effect as usize]
    }

    /// The twist of a shaft per acceleration, by which the encoder leads both masses, sample². The shaft is stiff, or it
    /// is the spring behind the motor with κ = ρ/((1 − ρ) ω²). An encoder on the load lags by 1/ω².
    #[must_use]
    pub fn twist(&self) -> f64 {
        let share = self.get(Effect::LoadShare);
        if share > 0.0 {
            let frequency = self.get(Effect::ResonanceFrequency);
            let ratio = if self.get(Effect::EncoderOnLoad) > 0.0 {
                -1.0
            } else {
                share / (1.0 - share)
            };
            return ratio / (frequency * frequency);
        }
        self.get(Effect::Compliance)
    }

    /// True if there are the effects of every servo alone.
    pub(super) fn is_plain(&self) -> bool {
        let mut extra = self.values[Effect::BASE.len()..].iter();
        extra.all(|&value| value == 0.0)
    }

    /// The same with each effect multiplied by its factor.
    #[must_use]
    pub fn scaled(mut self, factor: impl Fn(Effect) -> f64) -> Self {
        for effect in Effect::ALL {
            self.values[effect as usize] *= factor(effect);
        }
        self
    }

    /// Sets the value of an effect.
    pub const fn set(&mut self, effect: Effect, value: f64) {
        self.values[effect as usize] = value;
    }

    /// The same with another value of an effect.
    #[must_use]
    pub const fn with(mut self, effect: Effect, value: f64) -> Self {
        self.set(effect, value);
        self
    }
}
