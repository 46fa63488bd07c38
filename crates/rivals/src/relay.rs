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

/// Identification from the limit cycles under R relays with delay, one after the other.
///
/// One: Tan, Lee, Huang and Jiang, "Friction modeling and adaptive compensation using a relay feedback approach", IEEE
/// Transactions on Industrial Electronics 48(1), 2001. Model and friction follow from the balances of the cycle, see
/// [`LimitCycle`].
///
/// Two: Besançon-Voda and Besançon, "Analysis of a two-relay system configuration with application to Coulomb friction
/// identification", Automatica 35(8), 1999. The energy that Coulomb friction takes from the swing does not grow with
/// its velocity, that of viscous friction does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayCycles<N, const R: usize> {
    relays: [Relay<N>; R],
    cycle: LimitCycle,
}

/// State of [`RelayCycles`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayCyclesState<N, const R: usize> {
    relay: RelayState,
    command: N,
    /// The number of the relay that acts.
    at: usize,
    cycles: [LimitCycleState<N>; R],
}

impl<N: Number, const R: usize> RelayCycles<N, R> {
    /// Steady cycles after which the next relay takes over.
    pub const CYCLES: u32 = 8;

    /// The experiment with one relay, or with two of different level.
    #[must_use]
    pub fn new(units: &Units, relays: [Relay<N>; R]) -> Self {
        const { assert!(R == 1 || R == 2, "one relay or two") };
        Self {
            relays,
            cycle: LimitCycle::new(units),
        }
    }

    /// The state before the first sample.
    #[must_use]
    pub fn start(&self) -> RelayCyclesState<N, R> {
        RelayCyclesState {
            relay: self.relays[0].start(),
            command: N::ZERO,
            at: 0,
            cycles: [self.cycle.start(); R],
        }
    }

    /// One sample: by how much the position moved since the last, and the error q_d − q, machine
    /// units. The command to be held from now on.
    #[inline]
    pub fn process(&self, state: &mut RelayCyclesState<N, R>, increment: N, error: N) -> N {
        let (relay, cycle) = (&self.relays[state.at], &mut state.cycles[state.at]);
        self.cycle.process(cycle, increment, state.command);
        if self.cycle.steady_cycles(cycle) >= Self::CYCLES {
            state.at = R - 1;
        }
        state.command = relay.process(&mut state.relay, error);
        state.command
    }

    /// a, b and c, SI; none until every limit cycle is steady.
    #[must_use]
    pub fn estimates(&self, state: &RelayCyclesState<N, R>) -> Option<ServoParameters> {
        match &state.cycles[..] {
            [only] => self.cycle.estimates(only),
            [first, second] => self.cycle.estimates_of_two(first, second),
            _ => None,
        }
    }
}
