//! The table of the unknowns of a model with optional terms, and the kinds of quantity that they are.
//!
//! q̈ = −a q̇ − δa |q̇| + b D(u(t − τ)) + d − (c + s exp(−(q̇/v_s)²)) sign q̇ + g_s sin q + g_c cos q
//! + r_s sin Nq + r_c cos Nq,
//!
//! D being the dead band of the bridge. A model has the unknowns of its [`UnknownSet`](super::UnknownSet);
//! a term that is not among them costs nothing.

use super::Parameter;
use crate::number::Number;
use crate::units::Units;

/// A row of the table of unknowns.
struct Row {
    name: &'static str,
    quantity: Quantity,
    meaning: &'static str,
    role: Role,
}

/// The role of an unknown in a model.
#[derive(Clone, Copy)]
enum Role {
    Parameter(Parameter),
    /// The size of a term. It has a usual share of the quantity that it acts beside, and changes a part of the model.
    Size(Term, f64, Changed),
}

/// The part of a model that a term changes.
#[derive(Clone, Copy)]
pub(super) enum Changed {
    /// The command before it acts.
    Command,
    /// The load, with the angle.
    Load,
    /// Friction that grows with the speed.
    ViscousFriction,
    /// Friction that knows the direction only.
    CoulombFriction,
}

/// Usual sizes of terms, as a share of the quantities that they act beside.
pub(crate) struct UsualSizes<N> {
    /// Share of Coulomb friction.
    pub(crate) coulomb: N,
    /// Share of the servo's usual value of each other quantity.
    pub(crate) other: PerQuantity<N>,
}

macro_rules! unknowns {
    ($($(#[$doc:meta])* $unknown:ident: $name:literal, $quantity:ident, $meaning:literal, $role:expr;)*) => {
        /// An unknown of a model: one of the four parameters, or the size of an optional term.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub enum Unknown {
            $($(#[$doc])* $unknown,)*
        }

        impl Unknown {
            /// The number of unknowns.
            pub const COUNT: usize = [$(Self::$unknown),*].len();

            /// All unknowns, in the order of a model that has them all.
            pub const ALL: [Self; Self::COUNT] = [$(Self::$unknown),*];

            const fn row(self) -> Row {
                use Changed::{Command, CoulombFriction, Load, ViscousFriction};
                use Role::Size;
                match self {
                    $(Self::$unknown => Row {
                        name: $name,
                        quantity: Quantity::$quantity,
                        meaning: $meaning,
                        role: $role,
                    },)*
                }
            }
        }
    };
}

/// The usual size of what motor and amplifier add, and of what bearings and masses do, as a share of the quantity that it
/// acts beside.
const OF_ELECTRONICS: f64 = 0.1;
const OF_MECHANICS: f64 = 0.3;

// A set begins with a and b, and the load, if it is one of them, comes last.
unknowns! {
    /// a, viscous friction over inertia, 1/s.
    A: "a", Rate, "viscous friction over inertia", Role::Parameter(Parameter::A);
    /// b, gain over inertia, rad/s² per command unit.
    B: "b", Gain, "gain over inertia", Role::Parameter(Parameter::B);
    /// c, Coulomb friction over inertia, rad/s².
    Coulomb: "coulomb", Acceleration, "Coulomb friction over inertia", Role::Parameter(Parameter::Coulomb);
    /// τ, the total delay from command to acceleration, s.
    Delay: "delay", Time, "delay from command to acceleration", Size(Term::Delay, OF_ELECTRONICS, Command);
    /// δa, the half difference of viscous friction forwards and backwards, over inertia, 1/s.
    Asymmetry: "asymmetry", Rate, "asymmetry of viscous friction",
        Size(Term::Asymmetry, OF_MECHANICS, ViscousFriction);
    /// s, friction over inertia that fades with speed as exp(−(q̇/v_s)²), rad/s².
    LowSpeed: "low-speed", Acceleration, "low-speed friction",
        Size(Term::LowSpeed, OF_MECHANICS, CoulombFriction);
    /// g_s, gravity over inertia in proportion to sin q, rad/s².
    GravitySine: "gravity-sine", Acceleration, "gravity with sin q", Size(Term::Gravity, OF_MECHANICS, Load);
    /// g_c, gravity over inertia in proportion to cos q, rad/s².
    GravityCosine: "gravity-cosine", Acceleration, "gravity with cos q", Size(Term::Gravity, OF_MECHANICS, Load);
    /// r_s, ripple over inertia in proportion to sin Nq, rad/s².
    RippleSine: "ripple-sine", Acceleration, "ripple with sin Nq", Size(Term::Ripple, OF_ELECTRONICS, Load);
    /// r_c, ripple over inertia in proportion to cos Nq, rad/s².
    RippleCosine: "ripple-cosine", Acceleration, "ripple with cos Nq", Size(Term::Ripple, OF_ELECTRONICS, Load);
    /// δ, the dead band of the bridge to either side, command units.
    DeadBand: "dead-band", Command, "dead band of the power stage", Size(Term::DeadBand, OF_ELECTRONICS, Command);
    /// d, constant load over inertia, rad/s².
    Load: "load", Acceleration, "load over inertia", Role::Parameter(Parameter::Load);
}

impl Unknown {
    /// The parameter that it is; none for the size of a term.
    #[must_use]
    pub const fn parameter(self) -> Option<Parameter> {
        match self.row().role {
            Role::Parameter(parameter) => Some(parameter),
            Role::Size(..) => None,
        }
    }

    /// The term whose size it is; none for a parameter.
    #[must_use]
    pub const fn term(self) -> Option<Term> {
        match self.row().role {
            Role::Parameter(_) => None,
            Role::Size(term, ..) => Some(term),
        }
    }

    /// The part of the model that it changes; none for a parameter.
    pub(super) const fn changes(self) -> Option<Changed> {
        match self.row().role {
            Role::Parameter(_) => None,
            Role::Size(_, _, changed) => Some(changed),
        }
    }

    /// The usual size of a term, from the sizes that a share makes of the quantities beside it. Zero for a parameter.
    pub(crate) fn usual_size<N: Number>(self, sizes: impl FnOnce(N) -> UsualSizes<N>) -> N {
        let Role::Size(_, share, changed) = self.row().role else {
            return N::ZERO;
        };
        let sizes = sizes(N::from_f64(share));
        match changed {
            Changed::CoulombFriction => sizes.coulomb,
            _ => sizes.other.get(self),
        }
    }

    /// Its name in configurations and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.row().name
    }

    /// Its meaning, for a table.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        self.row().meaning
    }

    /// The kind of quantity that it is.
    #[must_use]
    pub const fn quantity(self) -> Quantity {
        self.row().quantity
    }

    /// Its unit.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        self.quantity().unit()
    }

    /// Machine units per SI unit.
    #[must_use]
    pub fn scale(self, units: &Units) -> f64 {
        PerQuantity::machine(units).get(self)
    }
}

impl From<Parameter> for Unknown {
    fn from(parameter: Parameter) -> Self {
        parameter.unknown()
    }
}

macro_rules! terms {
    ($($(#[$doc:meta])* $term:ident: $name:literal;)*) => {
        /// An optional term of the model.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub enum Term {
            $($(#[$doc])* $term,)*
        }

        impl Term {
            /// All terms, in the order in which they enter where several are demanded.
            pub const ALL: [Self; [$(Self::$term),*].len()] = [$(Self::$term),*];

            /// Its name in configurations and results.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$term => $name,)*
                }
            }
        }
    };
}

terms! {
    /// Total delay of the command.
    Delay: "delay";
    /// Gravity on an absolute angle.
    Gravity: "gravity";
    /// Viscous friction that differs with the direction.
    Asymmetry: "asymmetry";
    /// Dead band of the bridge.
    DeadBand: "dead-band";
    /// Friction that changes at low speed.
    LowSpeed: "low-speed";
    /// Ripple of a declared order.
    Ripple: "ripple";
}

impl Term {
    /// True if an unknown is one of its sizes.
    pub(crate) fn is_of(self, unknown: Unknown) -> bool {
        unknown.term() == Some(self)
    }

    pub(super) const fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// The kind of quantity that an unknown is. Its unit, its scales and the size of a usual value all follow
/// from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Rate of decay, 1/s.
    Rate,
    /// Acceleration per command, rad/s² per command unit.
    Gain,
    /// A force over inertia, rad/s².
    Acceleration,
    /// Time, s.
    Time,
    /// Command, command units.
    Command,
}

/// A value for each kind of quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerQuantity<T> {
    /// For a rate.
    pub rate: T,
    /// For a gain.
    pub gain: T,
    /// For an acceleration.
    pub acceleration: T,
    /// For a time.
    pub time: T,
    /// For a command.
    pub command: T,
}

impl Quantity {
    /// Its unit.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Rate => "1/s",
            Self::Gain => "rad/s² per command unit",
            Self::Acceleration => "rad/s²",
            Self::Time => "s",
            Self::Command => "command units",
        }
    }
}

impl<T: Copy> PerQuantity<T> {
    /// The value for the kind of quantity that an unknown is.
    #[inline]
    #[must_use]
    pub fn get(&self, unknown: Unknown) -> T {
        match unknown.quantity() {
            Quantity::Rate => self.rate,
            Quantity::Gain => self.gain,
            Quantity::Acceleration => self.acceleration,
            Quantity::Time => self.time,
            Quantity::Command => self.command,
        }
    }
}

impl PerQuantity<f64> {
    /// Machine units per SI unit.
    pub(crate) fn machine(units: &Units) -> Self {
        Self {
            rate: units.rate(),
            gain: units.acceleration(),
            acceleration: units.acceleration(),
            time: 1.0 / units.sample_time(),
            command: 1.0,
        }
    }

    /// Units of a block of `samples` per unit of a sample.
    pub(crate) fn block(samples: f64) -> Self {
        Self {
            rate: samples,
            gain: samples * samples,
            acceleration: samples * samples,
            time: 1.0 / samples,
            command: 1.0,
        }
    }
}
