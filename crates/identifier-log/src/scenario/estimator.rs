//! The estimators, with all facts about each in one table.

use identifier_core::parameters::Parameter;
use identifier_core::settings::ControllerSettings;

use super::Identification;
use super::kind::Choice;

/// A row of the table.
#[derive(Debug, Clone, Copy)]
struct Row {
    kind: Kind,
    /// The parameters that it can find.
    finds: &'static [Parameter],
    closing: LoopKind,
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

/// The controller of the loop in which an estimator works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoopKind {
    /// The scenario's PID.
    Pid,
    /// The scenario's PID without its integral.
    Pd,
    /// A relay.
    Relay,
}

const AB: &[Parameter] = &[Parameter::A, Parameter::B];
const ALL: &[Parameter] = &Parameter::ALL;

#[rustfmt::skip]
const GRADIENT: &[&str] = &["gamma", "mu", "bounds", "servo_range", "correction", "bandwidth", "max_speed"];

macro_rules! laws {
    ($(
        $(#[$doc:meta])*
        $law:ident: $name:literal, $kind:ident, $finds:expr, $closing:ident, $prior:literal, $source:literal,
        $keys:expr;
    )*) => {
        /// The method that identifies the servo.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Estimator {
            $($(#[$doc])* $law,)*
        }

        impl Estimator {
            /// All of them.
            pub const ALL: &'static [Self] = &[$(Self::$law),*];

            /// Their names and keys, in the same order.
            pub const CHOICES: &'static [Choice] = &[$(Choice { name: $name, takes: $keys }),*];

            const fn row(self) -> Row {
                match self {
                    $(Self::$law => Row {
                        kind: Kind::$kind,
                        finds: $finds,
                        closing: LoopKind::$closing,
                        prior: $prior,
                        source: $source,
                    },)*
                }
            }
        }
    };
}

laws! {
    /// The Γ-gradient estimator (11) with a memory.
    Gradient: "gradient", Gradient, ALL, Pid, "range of a and b, gains of the PID", "this project",
        GRADIENT;
    /// Recursive Gauss–Newton.
    GaussNewton: "gauss-newton", Fit, ALL, Pid, "nothing", "this project",
        &[
            "bounds", "noise", "bandwidth", "max_speed", "start_time", "memory", "required_terms",
            "low_speed_velocity", "ripple_order", "revolution",
        ];
    /// One fit to the whole record, with the effects that it needs.
    Fit: "fit", Record, ALL, Pid, "nothing", "this project",
        &["required_terms", "low_speed_velocity", "ripple_order", "revolution"];
    /// The Γ-gradient estimator (11) alone, as the paper has it.
    Paper: "paper", Gradient, ALL, Pid, "range of a and b, gains of the PID", "the paper",
        GRADIENT;
    /// The gradient's ancestor, in the loop of a PD controller: θ̂˙ = −Γ [q̇_e, k_d q̇_e − k_p e_e]ᵀ (μ ε + ε̇).
    /// Literature: Garrido and Miranda, "Autotuning of a DC servomechanism using closed loop identification", IECON 2006.
    /// It assumes a servo without load and friction: a load leaves a constant ε that no integral takes over.
    PdGradient: "pd-gradient", Gradient, AB, Pd, "range of a and b, gains of the PD", "[7]",
        GRADIENT;
    /// Recursive least squares on filtered signals in the loop of a relay.
    RelayLeastSquares: "relay-least-squares", Rival, AB, Relay, "a safe relay amplitude, bandwidth", "[2], [14]",
        &["relay", "forgetting", "filter_cutoff"];
}

impl Estimator {
    /// The estimator's name in scenarios and results.
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
    pub const fn closing(self) -> LoopKind {
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
        self.closing() == LoopKind::Pid || self == Self::RelayLeastSquares
    }

    /// The parameters that it estimates unless others are stated.
    pub(super) fn default_parameters(self) -> &'static [Parameter] {
        match self.row().kind {
            Kind::Rival | Kind::Record => self.finds(),
            Kind::Gradient | Kind::Fit => AB,
        }
    }

    /// True for a Γ-gradient estimator.
    #[must_use]
    pub fn is_gradient(self) -> bool {
        self.row().kind == Kind::Gradient
    }

    /// True for an estimator that finds its own initial estimates.
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
    pub fn check_parameters(self, parameters: &[Parameter]) -> Result<(), String> {
        let finds = self.finds();
        if let Some(foreign) = parameters.iter().find(|wanted| !finds.contains(wanted)) {
            let names: Vec<_> = finds
                .iter()
                .map(|own| format!("\"{}\"", own.name()))
                .collect();
            return Err(format!(
                "\"{}\" cannot estimate \"{}\": it estimates only [{}]",
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
            Some(missing) => Err(format!(
                "this estimator always estimates \"{}\"",
                missing.name()
            )),
            None => Ok(()),
        }
    }
}

/// The settings of the method to compare with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RivalSettings {
    /// The relay's command, ± this, command units.
    pub relay: f64,
    /// Forgetting factor.
    pub forgetting: f64,
    /// Cut-off of the filters of input and output, rad/s.
    pub filter_cutoff: f64,
}

impl RivalSettings {
    /// Default values, the same for every servo and case.
    pub const TYPICAL: Self = Self {
        relay: 1.0,
        // One second at 1 kHz, the paper's.
        forgetting: 0.999,
        filter_cutoff: 50.0,
    };
}

impl Identification {
    /// Takes an estimator, with the parameters that it estimates by default.
    pub fn set_estimator(&mut self, law: Estimator) {
        self.law = law;
        self.rival = RivalSettings::TYPICAL;
        self.parameters = law.default_parameters().to_vec();
    }

    /// The controller of the loop that the estimator closes, from the declared one.
    #[must_use]
    pub fn controller(&self, declared: ControllerSettings) -> ControllerSettings {
        match self.law.closing() {
            LoopKind::Pd => ControllerSettings {
                ki: 0.0,
                ..declared
            },
            _ => declared,
        }
    }
}
