//! The laws: all that is known of each in one table.

use identifier_core::ControllerSettings;
use identifier_core::parameters::Parameter;

use super::Identification;
use super::kind::Choice;

/// A row of the table.
#[derive(Debug, Clone, Copy)]
struct Row {
    kind: Kind,
    /// The parameters that it can find.
    finds: &'static [Parameter],
    closing: Closing,
    /// Knowledge that the user needs beforehand.
    prior: &'static str,
    /// Its source: a number is the paper's reference.
    source: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Γ-gradient.
    Gradient,
    /// Gauss–Newton: it finds its own initial estimates.
    Fit,
    /// A fit to the whole record when it is complete.
    Record,
    /// A method to compare with.
    Rival,
}

/// The controller of the loop in which a law works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Closing {
    /// The scenario's PID.
    Pid,
    /// The scenario's PID without its integral.
    Pd,
    /// A proportional controller of low gain.
    Proportional,
    /// A controller with two degrees of freedom of the method's own.
    TwoDegreesOfFreedom,
    /// A relay.
    Relay,
}

const AB: &[Parameter] = &[Parameter::A, Parameter::B];
const ABC: &[Parameter] = &[Parameter::A, Parameter::B, Parameter::Coulomb];
const ABD: &[Parameter] = &[Parameter::A, Parameter::B, Parameter::Load];
const ALL: &[Parameter] = &Parameter::ALL;

#[rustfmt::skip]
const GRADIENT: &[&str] = &["gamma", "mu", "bounds", "plant_box", "correction", "bandwidth", "max_speed"];

macro_rules! laws {
    ($(
        $(#[$doc:meta])*
        $law:ident: $name:literal, $kind:ident, $finds:expr, $closing:ident, $prior:literal, $source:literal,
        $keys:expr;
    )*) => {
        /// The method that identifies the servo.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Law {
            $($(#[$doc])* $law,)*
        }

        impl Law {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$law),*];

            /// Their names and keys, in the same order.
            pub(super) const CHOICES: &'static [Choice] = &[$(Choice { name: $name, takes: $keys }),*];

            const fn row(self) -> Row {
                match self {
                    $(Self::$law => Row {
                        kind: Kind::$kind,
                        finds: $finds,
                        closing: Closing::$closing,
                        prior: $prior,
                        source: $source,
                    },)*
                }
            }
        }
    };
}

laws! {
    /// The Γ-gradient law (11).
    Gradient: "gradient", Gradient, ALL, Pid, "box of a and b, gains of the PID", "the paper",
        GRADIENT;
    /// Recursive Gauss–Newton.
    GaussNewton: "gauss-newton", Fit, ALL, Pid, "nothing", "this project",
        &[
            "bounds", "uncertainty", "noise", "bandwidth", "max_speed", "start_time", "memory",
            "required_terms", "low_speed_velocity", "ripple_order", "revolution",
        ];
    /// One fit to the whole record, with the effects that it needs.
    Fit: "fit", Record, ALL, Pid, "nothing", "this project",
        &["required_terms", "low_speed_velocity", "ripple_order", "revolution"];
    /// The gradient's ancestor, in the loop of a PD controller: θ̂˙ = −Γ [q̇_e, k_d q̇_e − k_p e_e]ᵀ
    /// (μ ε + ε̇) (Garrido and Miranda, "Autotuning of a DC servomechanism using closed loop
    /// identification", IECON 2006). It assumes a servo without load and friction: a load leaves a
    /// constant ε that no integral takes over.
    PdGradient: "pd-gradient", Gradient, AB, Pd, "box of a and b, gains of the PD", "[7]",
        GRADIENT;
    /// Recursive least squares on filtered signals in the loop of a relay.
    RelayLeastSquares: "relay-least-squares", Rival, AB, Relay, "a safe relay, bandwidth", "[2], [14]",
        &["relay", "forgetting", "filter_cutoff"];
    /// Off-line least squares in the loop of a proportional controller of low gain.
    ProportionalLeastSquares: "proportional-least-squares", Rival, AB, Proportional, "a safe low gain, bandwidth", "[4]",
        &["proportional_gain", "filter_cutoff"];
    /// Two degrees of freedom tuned from the rotor's inertia, off-line least squares, tuned again.
    TwoDegreesOfFreedom: "two-degrees-of-freedom", Rival, ABC, TwoDegreesOfFreedom, "b without the load's inertia, bandwidth", "[5]",
        &["filter_cutoff"];
    /// Multi-step recursive extended least squares in a proportional loop.
    MultiStepLeastSquares: "multi-step-least-squares", Rival, AB, Proportional, "a safe low gain, a sample time for the model", "[6]",
        &["proportional_gain", "forgetting", "block"];
    /// The limit cycle of a relay with delay.
    RelayCycle: "relay-cycle", Rival, ABC, Relay, "a safe relay and delay", "[8]",
        &["relay", "relay_delay"];
    /// The limit cycles of two relays.
    TwoRelays: "two-relays", Rival, ABC, Relay, "two safe relays and a delay", "[9]",
        &["relay", "relay_delay"];
    /// Closed-loop ARX by recursive least squares.
    ClosedLoopArx: "closed-loop-arx", Rival, AB, Pid, "a controller, bandwidth", "flight controllers",
        &["forgetting", "filter_cutoff"];
    /// Mechanical recursive least squares on differentiated position.
    MechanicalLeastSquares: "mechanical-least-squares", Rival, ABD, Pid, "a controller, bandwidth, order of b", "motor-control firmware",
        &["forgetting", "filter_cutoff"];
}

impl Law {
    /// The law's name in scenarios and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        Self::CHOICES[self as usize].name
    }

    /// The parameters that it can find.
    #[must_use]
    pub const fn finds(self) -> &'static [Parameter] {
        self.row().finds
    }

    /// The controller of its loop.
    #[must_use]
    pub const fn closing(self) -> Closing {
        self.row().closing
    }

    /// Knowledge that the user needs beforehand, for a table.
    #[must_use]
    pub const fn prior(self) -> &'static str {
        self.row().prior
    }

    /// Source of the method: a number is the paper's reference.
    #[must_use]
    pub const fn source(self) -> &'static str {
        self.row().source
    }

    /// True if it can take a log of any controller.
    #[must_use]
    pub fn is_replayable(self) -> bool {
        matches!(self.closing(), Closing::Pid | Closing::Proportional)
            || self == Self::RelayLeastSquares
    }

    /// True if it computes its result after the experiment, from all that was recorded.
    #[must_use]
    pub fn is_off_line(self) -> bool {
        matches!(
            self,
            Self::Fit | Self::ProportionalLeastSquares | Self::TwoDegreesOfFreedom
        )
    }

    /// True for a Γ-gradient law.
    #[must_use]
    pub fn is_gradient(self) -> bool {
        self.row().kind == Kind::Gradient
    }

    /// True for a law that finds its own initial estimates.
    #[must_use]
    pub fn fits(self) -> bool {
        self.row().kind == Kind::Fit
    }

    /// True for the fit to the whole record.
    #[must_use]
    pub fn takes_whole_record(self) -> bool {
        self.row().kind == Kind::Record
    }

    /// True for a method to compare with.
    #[must_use]
    pub fn is_rival(self) -> bool {
        self.row().kind == Kind::Rival
    }

    /// Checks that it can estimate these parameters.
    ///
    /// # Errors
    /// Why not, and which it can.
    pub(super) fn check_parameters(self, parameters: &[Parameter]) -> Result<(), String> {
        let finds = self.finds();
        if let Some(foreign) = parameters.iter().find(|wanted| !finds.contains(wanted)) {
            let names: Vec<_> = finds
                .iter()
                .map(|own| format!("\"{}\"", own.name()))
                .collect();
            return Err(format!(
                "\"{}\" cannot estimate \"{}\": it estimates [{}] and nothing else",
                self.name(),
                foreign.name(),
                names.join(", ")
            ));
        }
        let always: &[Parameter] = match self.row().kind {
            Kind::Rival => AB,
            Kind::Record => ALL,
            Kind::Gradient | Kind::Fit => &[],
        };
        match always.iter().find(|own| !parameters.contains(own)) {
            Some(missing) => Err(format!("this law always estimates \"{}\"", missing.name())),
            None => Ok(()),
        }
    }
}

/// The settings of the methods to compare with; each takes its own part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RivalSettings {
    /// The relay's command, ± this, command units.
    pub relay: f64,
    /// The relay's delay, s.
    pub relay_delay: f64,
    /// Forgetting factor.
    pub forgetting: f64,
    /// Cut-off of the filters of input and output, rad/s.
    pub filter_cutoff: f64,
    /// Gain of the proportional loop, command units per rad; none for a twentieth of kp.
    pub proportional_gain: Option<f64>,
    /// Sample time of a discrete-time model, s.
    pub block: f64,
}

impl RivalSettings {
    /// The part of k_p that counts as a low gain where none is given.
    const LOW_GAIN: f64 = 0.05;

    /// Default values, the same for every servo and case.
    pub(super) const TYPICAL: Self = Self {
        relay: 1.0,
        relay_delay: 0.005,
        // Ten seconds at 1 kHz.
        forgetting: 0.9999,
        filter_cutoff: 50.0,
        proportional_gain: None,
        block: 0.02,
    };

    /// Default values of a law.
    #[must_use]
    pub const fn for_law(law: Law) -> Self {
        match law {
            // One second at 1 kHz, the paper's; twenty seconds of blocks.
            Law::RelayLeastSquares | Law::MultiStepLeastSquares => Self {
                forgetting: 0.999,
                ..Self::TYPICAL
            },
            _ => Self::TYPICAL,
        }
    }
}

impl Identification {
    /// Takes a law, with the parameters that it estimates by default.
    pub fn set_law(&mut self, law: Law) {
        self.law = law;
        self.rival = RivalSettings::for_law(law);
        let default = match law.row().kind {
            Kind::Rival | Kind::Record => law.finds(),
            Kind::Gradient | Kind::Fit => AB,
        };
        self.parameters = default.to_vec();
    }

    /// The controller of the loop that the law closes, from the declared one.
    pub(super) fn controller(&self, declared: ControllerSettings) -> ControllerSettings {
        match self.law.closing() {
            Closing::Pd => ControllerSettings {
                ki: 0.0,
                ..declared
            },
            Closing::Proportional => {
                let low = RivalSettings::LOW_GAIN * declared.kp;
                ControllerSettings {
                    kp: self.rival.proportional_gain.unwrap_or(low),
                    kd: 0.0,
                    ki: 0.0,
                    ..declared
                }
            }
            _ => declared,
        }
    }
}
