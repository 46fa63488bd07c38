//! The effects that a fit may estimate.

/// An effect of the servo, of its amplifier or of its encoder that a fit may estimate.
///
/// q̈ (1 + i(q)) = −½ i′(q) q̇² − (a ± δa + a₂|q̇|) q̇ + b (1 + t_s sin Mq + t_c cos Mq) C(u(t − τ)) + d
/// + g_s sin q + g_c cos q + r_s sin Nq + r_c cos Nq − (c + s exp(−(q̇/v_s)²) + λ|F|) sign q̇,
///
/// i(q) = i_s sin Kq + i_c cos Kq. F is the acceleration by the command. C is the front end of the amplifier: current
/// loop, dead band, limit and gain by direction. The encoder shows q + e_s sin q + e_c cos q. The units of values are
/// counts, samples and command units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Effect {
    /// a, viscous friction over inertia, 1/sample.
    A,
    /// b, gain over inertia, counts/sample² per command unit.
    B,
    /// c, Coulomb friction over inertia, counts/sample².
    Coulomb,
    /// d, load over inertia, counts/sample².
    Load,
    /// τ, delay from command to acceleration, samples; negative where the command was recorded late.
    Delay,
    /// Time constant of the current loop, samples.
    CurrentLoop,
    /// δa, half the difference of viscous friction between the directions, 1/sample.
    Asymmetry,
    /// a₂, friction that grows with the square of the velocity, 1/count.
    Quadratic,
    /// s, friction that fades with speed, counts/sample².
    LowSpeed,
    /// v_s, the speed at which it fades, counts/sample.
    LowSpeedVelocity,
    /// g_s, gravity with sin q, counts/sample².
    GravitySine,
    /// g_c, gravity with cos q, counts/sample².
    GravityCosine,
    /// r_s, ripple with sin Nq, counts/sample².
    RippleSine,
    /// r_c, ripple with cos Nq, counts/sample².
    RippleCosine,
    /// Dead band of the bridge to either side, command units.
    DeadBand,
    /// λ, friction per acceleration by the command, 1.
    LoadFriction,
    /// Relative change of the gain over the record, 1.
    GainDrift,
    /// Relative change of all friction over the record, 1.
    FrictionDrift,
    /// Command from which on the amplifier gives less than it is asked, command units.
    HiddenLimit,
    /// Part of the command beyond the hidden limit that is lost, 1.
    LimitSlope,
    /// Half the relative difference of the gain between the directions of the command, 1.
    GainAsymmetry,
    /// t_s, ripple of the gain with sin Mq, 1.
    TorqueRippleSine,
    /// t_c, ripple of the gain with cos Mq, 1.
    TorqueRippleCosine,
    /// i_s, inertia with sin Kq, 1.
    InertiaSine,
    /// i_c, inertia with cos Kq, 1.
    InertiaCosine,
    /// Twist of a compliant shaft per acceleration, which it follows at once, sample².
    Compliance,
    /// ω, resonance of motor and load on the spring between them, both free, rad/sample.
    ResonanceFrequency,
    /// ζ, its damping, 1.
    ResonanceDamping,
    /// ρ, the load's share of the inertia behind that spring, 1; zero without one.
    LoadShare,
    /// Play between motor and encoder, counts.
    Backlash,
    /// e_s, error of an eccentric encoder with sin q, counts.
    EccentricitySine,
    /// e_c, error of an eccentric encoder with cos q, counts.
    EccentricityCosine,
}

impl Effect {
    /// The number of effects.
    pub const COUNT: usize = Self::ALL.len();

    /// All effects.
    pub const ALL: [Self; 32] = [
        Self::A,
        Self::B,
        Self::Coulomb,
        Self::Load,
        Self::Delay,
        Self::CurrentLoop,
        Self::Asymmetry,
        Self::Quadratic,
        Self::LowSpeed,
        Self::LowSpeedVelocity,
        Self::GravitySine,
        Self::GravityCosine,
        Self::RippleSine,
        Self::RippleCosine,
        Self::DeadBand,
        Self::LoadFriction,
        Self::GainDrift,
        Self::FrictionDrift,
        Self::HiddenLimit,
        Self::LimitSlope,
        Self::GainAsymmetry,
        Self::TorqueRippleSine,
        Self::TorqueRippleCosine,
        Self::InertiaSine,
        Self::InertiaCosine,
        Self::Compliance,
        Self::ResonanceFrequency,
        Self::ResonanceDamping,
        Self::LoadShare,
        Self::Backlash,
        Self::EccentricitySine,
        Self::EccentricityCosine,
    ];

    /// The effects of every servo.
    pub const BASE: [Self; 5] = [Self::A, Self::B, Self::Coulomb, Self::Load, Self::Delay];

    /// The powers of a count and of a sample in its unit.
    #[must_use]
    pub const fn unit(self) -> [i32; 2] {
        match self {
            Self::A | Self::Asymmetry | Self::ResonanceFrequency => [0, -1],
            Self::B
            | Self::Coulomb
            | Self::Load
            | Self::LowSpeed
            | Self::GravitySine
            | Self::GravityCosine
            | Self::RippleSine
            | Self::RippleCosine => [1, -2],
            Self::Delay | Self::CurrentLoop => [0, 1],
            Self::Quadratic => [-1, 0],
            Self::LowSpeedVelocity => [1, -1],
            Self::Compliance => [0, 2],
            Self::Backlash | Self::EccentricitySine | Self::EccentricityCosine => [1, 0],
            _ => [0, 0],
        }
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
    /// N, the order of ripple, 1.
    pub order: f64,
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
        order: 1.0,
        gain_order: 1.0,
        inertia_order: 1.0,
    };

    /// The value of an effect.
    #[must_use]
    pub const fn get(&self, effect: Effect) -> f64 {
        self.values[effect as usize]
    }

    /// The twist of a shaft per acceleration, sample². The shaft is stiff, or it is the spring behind the motor with κ
    /// = ρ/((1 − ρ) ω²).
    #[must_use]
    pub fn twist(&self) -> f64 {
        let share = self.get(Effect::LoadShare);
        if share > 0.0 {
            let frequency = self.get(Effect::ResonanceFrequency);
            return share / ((1.0 - share) * frequency * frequency);
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
