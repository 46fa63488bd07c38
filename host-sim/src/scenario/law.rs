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

impl BaselineSettings {
    /// The part of k_p that counts as a low gain where none is given.
    const LOW: f64 = 0.05;

    /// What a baseline takes where nothing is stated; the same for every servo and case.
    #[must_use]
    pub fn of(baseline: Baseline) -> Self {
        Self {
            relay: 1.0,
            relay_delay: 0.005,
            forgetting: match baseline {
                // One second at 1 kHz, the paper's.
                Baseline::RelayLeastSquares => 0.999,
                // Twenty seconds of blocks.
                Baseline::MultiStepLeastSquares => 0.999,
                // Ten seconds at 1 kHz.
                _ => 0.9999,
            },
            filter_cutoff: 50.0,
            proportional_gain: None,
            block: 0.02,
        }
    }
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

    /// The name in scenarios and results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RelayLeastSquares => "relay-least-squares",
            Self::ProportionalLeastSquares => "proportional-least-squares",
            Self::TwoDegreesOfFreedom => "two-degrees-of-freedom",
            Self::MultiStepLeastSquares => "multi-step-least-squares",
            Self::RelayCycle => "relay-cycle",
            Self::TwoRelays => "two-relays",
            Self::ClosedLoopArx => "closed-loop-arx",
            Self::MechanicalLeastSquares => "mechanical-least-squares",
        }
    }

    /// What it finds.
    #[must_use]
    pub fn parameters(self) -> &'static [Parameter] {
        use Parameter::{A, B, Coulomb, Load};
        match self {
            Self::RelayLeastSquares
            | Self::ProportionalLeastSquares
            | Self::MultiStepLeastSquares
            | Self::ClosedLoopArx => &[A, B],
            Self::TwoDegreesOfFreedom | Self::RelayCycle | Self::TwoRelays => &[A, B, Coulomb],
            Self::MechanicalLeastSquares => &[A, B, Load],
        }
    }

    /// What closes its loop.
    #[must_use]
    pub fn closing(self) -> Closing {
        match self {
            Self::RelayLeastSquares | Self::RelayCycle | Self::TwoRelays => Closing::Relay,
            Self::ProportionalLeastSquares | Self::MultiStepLeastSquares => Closing::Proportional,
            Self::TwoDegreesOfFreedom => Closing::TwoDegreesOfFreedom,
            Self::ClosedLoopArx | Self::MechanicalLeastSquares => Closing::Pid,
        }
    }

    /// The keys of `[identifier]` that it takes.
    #[must_use]
    pub fn keys(self) -> &'static [&'static str] {
        match self {
            Self::RelayLeastSquares => &["relay", "forgetting", "filter_cutoff"],
            Self::ProportionalLeastSquares => &["proportional_gain", "filter_cutoff"],
            Self::TwoDegreesOfFreedom => &["filter_cutoff"],
            Self::MultiStepLeastSquares => &["proportional_gain", "forgetting", "block"],
            Self::RelayCycle | Self::TwoRelays => &["relay", "relay_delay"],
            Self::ClosedLoopArx | Self::MechanicalLeastSquares => &["forgetting", "filter_cutoff"],
        }
    }
}

impl Law {
    /// The names of the laws that a recorded log can be replayed with.
    pub const REPLAYABLE: &'static str = "\"gradient\", \"gauss-newton\", \"window\", \
        \"relay-least-squares\", \"closed-loop-arx\", \"mechanical-least-squares\", \"proportional-least-squares\" and \
        \"multi-step-least-squares\"";

    /// The law's name in scenarios and results.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Gradient => "gradient",
            Self::GaussNewton => "gauss-newton",
            Self::Window => "window",
            Self::PdGradient => "pd-gradient",
            Self::Baseline(baseline, _) => baseline.name(),
        }
    }

    /// What closes its loop.
    #[must_use]
    pub fn closing(&self) -> Closing {
        match self {
            Self::Gradient | Self::GaussNewton | Self::Window => Closing::Pid,
            Self::PdGradient => Closing::Pd,
            Self::Baseline(baseline, _) => baseline.closing(),
        }
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

    /// What a user must know beforehand, for a table.
    #[must_use]
    pub fn prior(&self) -> &'static str {
        match self {
            Self::Gradient => "box of a and b, gains of the PID",
            Self::GaussNewton | Self::Window => "nothing",
            Self::PdGradient => "box of a and b, gains of the PD",
            Self::Baseline(baseline, _) => match baseline {
                Baseline::RelayLeastSquares => "a safe relay, bandwidth",
                Baseline::ProportionalLeastSquares => "a safe low gain, bandwidth",
                Baseline::TwoDegreesOfFreedom => "b without the load's inertia, bandwidth",
                Baseline::MultiStepLeastSquares => "a safe low gain, a sample time for the model",
                Baseline::RelayCycle => "a safe relay and delay",
                Baseline::TwoRelays => "two safe relays and a delay",
                Baseline::ClosedLoopArx => "a controller, bandwidth",
                Baseline::MechanicalLeastSquares => "a controller, bandwidth, order of b",
            },
        }
    }

    /// Where the method is from: a number is the paper's reference.
    #[must_use]
    pub fn source(&self) -> &'static str {
        match self {
            Self::Gradient => "the paper",
            Self::GaussNewton | Self::Window => "this project",
            Self::PdGradient => "[7]",
            Self::Baseline(baseline, _) => match baseline {
                Baseline::RelayLeastSquares => "[2], [14]",
                Baseline::ProportionalLeastSquares => "[4]",
                Baseline::TwoDegreesOfFreedom => "[5]",
                Baseline::MultiStepLeastSquares => "[6]",
                Baseline::RelayCycle => "[8]",
                Baseline::TwoRelays => "[9]",
                Baseline::ClosedLoopArx => "flight controllers",
                Baseline::MechanicalLeastSquares => "motor-control firmware",
            },
        }
    }
}
