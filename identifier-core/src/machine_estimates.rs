use crate::identify::Identify;
use crate::parameters::{Parameter, PerParameter};

/// The estimates as an identifier computes with them. A firmware that shows no others needs no double precision, which
/// a chip computes by software.
///
/// The SI value of an estimate is the machine value times [`MachineEstimates::machine_unit`]. This constant of the
/// configuration may be computed elsewhere.
pub trait MachineEstimates<N: Copy>: Identify<N> {
    /// a, b, Coulomb friction and load in machine units (see [`Units`](crate::units::Units)). In fixed point they are
    /// fractions of their full scales. A parameter that the model does not have is zero.
    fn machine_estimates(&self, state: &Self::State) -> PerParameter<N>;

    /// The SI value of a machine value of one.
    fn machine_unit(&self, parameter: Parameter) -> f64;
}
