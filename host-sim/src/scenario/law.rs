//! The laws: what each needs, what it finds and what closes its loop.

use identifier_core::ControllerSettings;
use identifier_core::parameters::Parameter;

/// What identifies the servo.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// The Γ-gradient law (11).
    Gradient,
    /// Recursive Gauss–Newton.
    GaussNewton,
    /// Windowed Gauss–Newton.
    Window,
    /// The gradient's ancestor, in the loop of a PD controller: θ̂˙ = −Γ [q̇_e, k_d q̇_e − k_p e_e]ᵀ
    /// (μ ε + ε̇) (Garrido and Miranda, "Autotuning of a DC servomechanism using closed loop
    /// identification", IECON 2006). It assumes a servo without load and friction: a load leaves a
    /// constant ε that no integral takes over.
    PdGradient,
    /// A method that is there for comparison.
    Baseline(Baseline, BaselineSettings),
}

/// The methods that the paper stands beside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Baseline {
    /// Recursive least squares on filtered signals in the loop of a relay.
    RelayLeastSquares,
    /// Off-line least squares in the loop of a proportional controller of low gain.
    ProportionalLeastSquares,
    /// Two degrees of freedom tuned from the rotor's inertia, off-line least squares, tuned again.
    TwoDegreesOfFreedom,
    /// Multi-step recursive extended least squares in a proportional loop.
    MultiStepLeastSquares,
    /// The limit cycle of a relay with delay.
    RelayCycle,
    /// The limit cycles of two relays.
    TwoRelays,
    /// Closed-loop ARX by recursive least squares.
    ClosedLoopArx,
    /// Mechanical recursive least squares on differentiated position.
    MechanicalLeastSquares,
}

/// What the baselines need; each takes its own part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselineSettings {
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
    /// Time over which a discrete-time model takes one of its samples, s.
    pub block: f64,
}

/// What closes the loop in which a law works.
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

/// What there is to say of a law: a new one is a row of [`Law::method`], and a line of the choices of
/// [`LAWS`](super::keys::LAWS).
#[derive(Debug, Clone, Copy)]
struct Method {
    name: &'static str,
    /// What it can find.
    finds: &'static [Parameter],
    closing: Closing,
    /// What a user must know beforehand.
    prior: &'static str,
    /// Where it is from: a number is the paper's reference.
    source: &'static str,
}

const AB: &[Parameter] = &[Parameter::A, Parameter::B];
const ABC: &[Parameter] = &[Parameter::A, Parameter::B, Parameter::Coulomb];
const ABD: &[Parameter] = &[Parameter::A, Parameter::B, Parameter::Load];
const ALL: &[Parameter] = &[
    Parameter::A,
    Parameter::B,
    Parameter::Coulomb,
    Parameter::Load,
];

const fn method(
    name: &'static str,
    finds: &'static [Parameter],
    closing: Closing,
    prior: &'static str,
    source: &'static str,
) -> Method {
    Method {
        name,
        finds,
        closing,
        prior,
        source,
    }
}

const fn fitting(name: &'static str) -> Method {
    method(name, ALL, Closing::Pid, "nothing", "this project")
}

impl BaselineSettings {
    /// The part of k_p that counts as a low gain where none is given.
    const LOW: f64 = 0.05;

    /// What a baseline takes where nothing is stated; the same for every servo and case.
    pub(super) const TYPICAL: Self = Self {
        relay: 1.0,
        relay_delay: 0.005,
        // Ten seconds at 1 kHz.
        forgetting: 0.9999,
        filter_cutoff: 50.0,
        proportional_gain: None,
        block: 0.02,
    };

    /// The same with the memory of the method.
    #[must_use]
    pub const fn of(baseline: Baseline) -> Self {
        match baseline {
            // One second at 1 kHz, the paper's; twenty seconds of blocks.
            Baseline::RelayLeastSquares | Baseline::MultiStepLeastSquares => Self {
                forgetting: 0.999,
                ..Self::TYPICAL
            },
            _ => Self::TYPICAL,
        }
    }
}

impl Baseline {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::RelayLeastSquares,
        Self::ProportionalLeastSquares,
        Self::TwoDegreesOfFreedom,
        Self::MultiStepLeastSquares,
        Self::RelayCycle,
        Self::TwoRelays,
        Self::ClosedLoopArx,
        Self::MechanicalLeastSquares,
    ];

    #[rustfmt::skip]
    const fn method(self) -> Method {
        use Closing::{Pid, Proportional, Relay, TwoDegreesOfFreedom};
        match self {
            Self::RelayLeastSquares =>
                method("relay-least-squares", AB, Relay, "a safe relay, bandwidth", "[2], [14]"),
            Self::ProportionalLeastSquares =>
                method("proportional-least-squares", AB, Proportional, "a safe low gain, bandwidth", "[4]"),
            Self::TwoDegreesOfFreedom => method(
                "two-degrees-of-freedom", ABC, TwoDegreesOfFreedom,
                "b without the load's inertia, bandwidth", "[5]",
            ),
            Self::MultiStepLeastSquares => method(
                "multi-step-least-squares", AB, Proportional,
                "a safe low gain, a sample time for the model", "[6]",
            ),
            Self::RelayCycle => method("relay-cycle", ABC, Relay, "a safe relay and delay", "[8]"),
            Self::TwoRelays => method("two-relays", ABC, Relay, "two safe relays and a delay", "[9]"),
            Self::ClosedLoopArx =>
                method("closed-loop-arx", AB, Pid, "a controller, bandwidth", "flight controllers"),
            Self::MechanicalLeastSquares => method(
                "mechanical-least-squares", ABD, Pid,
                "a controller, bandwidth, order of b", "motor-control firmware",
            ),
        }
    }

    /// The name in scenarios and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.method().name
    }

    /// What it finds.
    #[must_use]
    pub const fn parameters(self) -> &'static [Parameter] {
        self.method().finds
    }
}

impl Law {
    #[rustfmt::skip]
    const fn method(&self) -> Method {
        match self {
            Self::Gradient =>
                method("gradient", ALL, Closing::Pid, "box of a and b, gains of the PID", "the paper"),
            Self::PdGradient =>
                method("pd-gradient", AB, Closing::Pd, "box of a and b, gains of the PD", "[7]"),
            Self::GaussNewton => fitting("gauss-newton"),
            Self::Window => fitting("window"),
            Self::Baseline(baseline, _) => baseline.method(),
        }
    }

    /// The law's name in scenarios and results.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.method().name
    }

    /// What closes its loop.
    #[must_use]
    pub const fn closing(&self) -> Closing {
        self.method().closing
    }

    /// What a user must know beforehand, for a table.
    #[must_use]
    pub const fn prior(&self) -> &'static str {
        self.method().prior
    }

    /// Where the method is from: a number is the paper's reference.
    #[must_use]
    pub const fn source(&self) -> &'static str {
        self.method().source
    }

    /// Whether it can take a log that some other controller recorded.
    #[must_use]
    pub fn is_replayable(&self) -> bool {
        matches!(self.closing(), Closing::Pid | Closing::Proportional)
            || matches!(self, Self::Baseline(Baseline::RelayLeastSquares, _))
    }

    /// Whether it computes its result after the experiment, from all that was recorded.
    #[must_use]
    pub fn is_off_line(&self) -> bool {
        matches!(
            self,
            Self::Baseline(
                Baseline::ProportionalLeastSquares | Baseline::TwoDegreesOfFreedom,
                _
            )
        )
    }

    /// Whether it is a Γ-gradient law.
    #[must_use]
    pub fn is_gradient(&self) -> bool {
        matches!(self, Self::Gradient | Self::PdGradient)
    }

    /// Whether it finds its own beginning, so that it needs no initial estimates.
    #[must_use]
    pub fn fits(&self) -> bool {
        matches!(self, Self::GaussNewton | Self::Window)
    }

    /// What it estimates where the user does not choose.
    pub(super) fn default_parameters(&self) -> Vec<Parameter> {
        match self {
            Self::Baseline(baseline, _) => baseline.parameters().to_vec(),
            _ => AB.to_vec(),
        }
    }

    /// Whether it can estimate these parameters.
    ///
    /// # Errors
    /// Why not, and what it does.
    pub(super) fn can_estimate(&self, parameters: &[Parameter]) -> Result<(), String> {
        let Method { name, finds, .. } = self.method();
        if let Some(foreign) = parameters.iter().find(|wanted| !finds.contains(wanted)) {
            let names: Vec<_> = finds
                .iter()
                .map(|own| format!("\"{}\"", own.name()))
                .collect();
            return Err(format!(
                "\"{name}\" cannot estimate \"{}\": it estimates [{}] and nothing else",
                foreign.name(),
                names.join(", ")
            ));
        }
        let always: &[Parameter] = match self {
            Self::Baseline(..) => AB,
            _ => &[],
        };
        match always.iter().find(|own| !parameters.contains(own)) {
            Some(missing) => Err(format!("this law always estimates \"{}\"", missing.name())),
            None => Ok(()),
        }
    }

    /// The controller of the loop that the law closes, from the declared one.
    pub(super) fn controller(&self, declared: ControllerSettings) -> ControllerSettings {
        match (self.closing(), self) {
            (Closing::Pd, _) => ControllerSettings {
                ki: 0.0,
                ..declared
            },
            (Closing::Proportional, Self::Baseline(_, settings)) => {
                let low = BaselineSettings::LOW * declared.kp;
                ControllerSettings {
                    kp: settings.proportional_gain.unwrap_or(low),
                    kd: 0.0,
                    ki: 0.0,
                    ..declared
                }
            }
            _ => declared,
        }
    }
}
