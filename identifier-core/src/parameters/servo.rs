/// The parameters of a servo q̈ = −a q̇ + b u + d − c sign(q̇), (2) with Coulomb friction added.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ServoParameters {
    /// a = f/J: viscous friction over inertia, 1/s.
    pub a: f64,
    /// b = k/J: input gain over inertia, rad/s² per command unit.
    pub b: f64,
    /// c: Coulomb friction over inertia, rad/s².
    pub coulomb: f64,
    /// d = p/J: constant disturbance over inertia, rad/s².
    pub load: f64,
}

impl ServoParameters {
    /// The servo with a further load, given as the command that balances it: b times `command` is
    /// added.
    #[must_use]
    pub fn with_load_of(self, command: f64) -> Self {
        Self {
            load: self.load + self.b * command,
            ..self
        }
    }
}
