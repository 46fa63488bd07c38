use crate::{LimitCycle, LimitCycleState};
use identifier_core::error::{Allowed, OutOfRange};
use identifier_core::number::Number;
use identifier_core::parameters::ServoParameters;
use identifier_core::units::Units;

/// A relay with delay: ± a level by the sign that the error had some samples ago.
///
/// Around a servo the delay feeds the swing what friction takes from it, so a limit cycle appears
/// whose frequency and size follow from the servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relay<N> {
    level: N,
    delay: u32,
}

/// State of [`Relay`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RelayState {
    up: bool,
    wait: u32,
}

impl<N: Number> Relay<N> {
    /// A relay of a level (command units) and a delay in samples.
    ///
    /// # Errors
    /// `relay` must be above zero.
    pub fn new(level: f64, delay: u32) -> Result<Self, OutOfRange> {
        Allowed::Above(0.0).check("relay", level)?;
        Ok(Self {
            level: N::from_f64(level),
            delay,
        })
    }

    /// The state before the first sample: up.
    #[must_use]
    pub fn start(&self) -> RelayState {
        RelayState {
            up: true,
            wait: self.delay,
        }
    }

    /// The command for an error q_d − q.
    #[inline]
    pub fn process(&self, state: &mut RelayState, error: N) -> N {
        let wanted = error >= N::ZERO;
        if wanted == state.up {
            state.wait = self.delay;
        } else if state.wait == 0 {
            state.up = wanted;
            state.wait = self.delay;
        } else {
            state.wait -= 1;
        }
        if state.up { self.level } else { -self.level }
    }
}

/// Identification from the limit cycle under one relay with delay: Tan, Lee, Huang and Jiang,
/// "Friction modeling and adaptive compensation using a relay feedback approach", IEEE Transactions
/// on Industrial Electronics 48(1), 2001. Model and friction follow from the balances of the cycle,
/// see [`LimitCycle`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayCycle<N> {
    relay: Relay<N>,
    cycle: LimitCycle,
}

/// State of [`RelayCycle`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayCycleState<N> {
    relay: RelayState,
    command: N,
    cycle: LimitCycleState<N>,
}

impl<N: Number> RelayCycle<N> {
    /// The experiment with a relay.
    #[must_use]
    pub fn new(units: &Units, relay: Relay<N>) -> Self {
        Self {
            relay,
            cycle: LimitCycle::new(units),
        }
    }

    /// The state before the first sample.
    #[must_use]
    pub fn start(&self) -> RelayCycleState<N> {
        RelayCycleState {
            relay: self.relay.start(),
            command: N::ZERO,
            cycle: self.cycle.start(),
        }
    }

    /// One sample: by how much the position moved since the last, and the error q_d − q, machine
    /// units. The command to be held from now on.
    #[inline]
    pub fn process(&self, state: &mut RelayCycleState<N>, increment: N, error: N) -> N {
        self.cycle
            .process(&mut state.cycle, increment, state.command);
        state.command = self.relay.process(&mut state.relay, error);
        state.command
    }

    /// a, b and c, SI; none until the limit cycle is steady.
    #[must_use]
    pub fn estimates(&self, state: &RelayCycleState<N>) -> Option<ServoParameters> {
        self.cycle.estimates(&state.cycle)
    }
}

/// Identification from the limit cycles under two relays, one after the other: Besançon-Voda and
/// Besançon, "Analysis of a two-relay system configuration with application to Coulomb friction
/// identification", Automatica 35(8), 1999. The energy that Coulomb friction takes from the swing does not
/// grow with its velocity, that of viscous friction does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoRelays<N> {
    relays: [Relay<N>; 2],
    cycle: LimitCycle,
}

/// State of [`TwoRelays`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoRelaysState<N> {
    relay: RelayState,
    command: N,
    second: bool,
    cycles: [LimitCycleState<N>; 2],
}

impl<N: Number> TwoRelays<N> {
    /// Steady cycles after which the second relay takes over.
    pub const CYCLES: u32 = 8;

    /// The experiment with two relays of different level.
    #[must_use]
    pub fn new(units: &Units, relays: [Relay<N>; 2]) -> Self {
        Self {
            relays,
            cycle: LimitCycle::new(units),
        }
    }

    /// The state before the first sample.
    #[must_use]
    pub fn start(&self) -> TwoRelaysState<N> {
        TwoRelaysState {
            relay: self.relays[0].start(),
            command: N::ZERO,
            second: false,
            cycles: [self.cycle.start(); 2],
        }
    }

    /// One sample: by how much the position moved since the last, and the error q_d − q, machine
    /// units. The command to be held from now on.
    #[inline]
    pub fn process(&self, state: &mut TwoRelaysState<N>, increment: N, error: N) -> N {
        let [first, second] = &mut state.cycles;
        let (relay, cycle) = if state.second {
            (&self.relays[1], second)
        } else {
            (&self.relays[0], first)
        };
        self.cycle.process(cycle, increment, state.command);
        if self.cycle.steady_cycles(cycle) >= Self::CYCLES {
            state.second = true;
        }
        state.command = relay.process(&mut state.relay, error);
        state.command
    }

    /// a, b and c, SI; none until both limit cycles are steady.
    #[must_use]
    pub fn estimates(&self, state: &TwoRelaysState<N>) -> Option<ServoParameters> {
        let [first, second] = &state.cycles;
        self.cycle.estimates_of_two(first, second)
    }
}
