use identifier_core::parameters::Unknown;

/// What is identified of a servo, in the order in which a commissioning tells it.
pub(super) const COMMISSIONED: [Unknown; 5] = [
    Unknown::A,
    Unknown::B,
    Unknown::Coulomb,
    Unknown::Load,
    Unknown::Delay,
];

/// Symbol and meaning.
#[must_use]
pub(super) fn described(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::A => "a, viscous friction over inertia",
        Unknown::B => "b, gain over inertia",
        Unknown::Coulomb => "c, Coulomb friction over inertia",
        Unknown::Load => "d, load over inertia",
        Unknown::Delay => "delay from command to acceleration",
        Unknown::Asymmetry => "asymmetry of viscous friction",
        Unknown::LowSpeed => "friction that fades with speed",
        Unknown::GravitySine => "gravity with sin q",
        Unknown::GravityCosine => "gravity with cos q",
        Unknown::RippleSine => "ripple with sin Nq",
        Unknown::RippleCosine => "ripple with cos Nq",
        Unknown::DeadBand => "dead band of the bridge",
    }
}
