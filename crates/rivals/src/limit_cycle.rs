use crate::plausible;
use identifier_core::number::Number;
use identifier_core::parameters::{Parameter, ServoParameters};
use identifier_core::units::Units;

/// The balances of a limit cycle: the parameters of q̈ = −a q̇ + b u + d − c s, s = sign q̇, from a periodic
/// motion.
///
/// Multiplied by 1, q, q̇ and s and integrated over one period, the derivatives drop out:
///
/// - 0 = b ∮u − c ∮s + d P
/// - −∮q̇² = b ∮q u − c ∮q s + d ∮q
/// - 0 = −a ∮q̇² + b ∮q̇ u − c ∮|q̇|
/// - 0 = −a ∮|q̇| + b ∮s u − c P + d ∮s
///
/// four linear equations. The second and the third are the describing function's balance of
/// amplitude and phase (Gelb and Vander Velde, Multiple-Input Describing Functions, 1968) without
/// its neglect of harmonics: the command is known, so no shape need be assumed. All integrals are
/// sums over the samples of increments and commands; the command is held, so ∮q̇ u is exact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitCycle {
    units: Units,
}

/// The integrals over a period, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Integrals<N> {
    period: N,
    command: N,
    position: N,
    direction: N,
    position_command: N,
    position_direction: N,
    velocity_squared: N,
    velocity_command: N,
    path: N,
    direction_command: N,
}

impl<N: Number> Integrals<N> {
    const NONE: Self = Self {
        period: N::ZERO,
        command: N::ZERO,
        position: N::ZERO,
        direction: N::ZERO,
        position_command: N::ZERO,
        position_direction: N::ZERO,
        velocity_squared: N::ZERO,
        velocity_command: N::ZERO,
        path: N::ZERO,
        direction_command: N::ZERO,
    };

    fn each(self, other: Self, f: impl Fn(N, N) -> N) -> Self {
        Self {
            period: f(self.period, other.period),
            command: f(self.command, other.command),
            position: f(self.position, other.position),
            direction: f(self.direction, other.direction),
            position_command: f(self.position_command, other.position_command),
            position_direction: f(self.position_direction, other.position_direction),
            velocity_squared: f(self.velocity_squared, other.velocity_squared),
            velocity_command: f(self.velocity_command, other.velocity_command),
            path: f(self.path, other.path),
            direction_command: f(self.direction_command, other.direction_command),
        }
    }
}

/// State of a [`LimitCycle`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitCycleState<N> {
    running: Integrals<N>,
    place: N,
    last_increment: N,
    last_command: N,
    begun: bool,
    last: Integrals<N>,
    steady: Integrals<N>,
    steady_cycles: u32,
}

impl LimitCycle {
    /// Alike cycles in a row that a steady limit cycle needs.
    pub const STEADY_CYCLES: u32 = 3;

    /// Relative difference of period and mean square velocity up to which two cycles in a row are alike.
    const TOLERANCE: f64 = 0.02;

    /// From the loop's units.
    #[must_use]
    pub fn new(units: &Units) -> Self {
        Self { units: *units }
    }

    /// No cycle yet.
    #[must_use]
    pub fn start<N: Number>(&self) -> LimitCycleState<N> {
        LimitCycleState {
            running: Integrals::NONE,
            place: N::ZERO,
            last_increment: N::ZERO,
            last_command: N::ZERO,
            begun: false,
            last: Integrals::NONE,
            steady: Integrals::NONE,
            steady_cycles: 0,
        }
    }

    /// One sample: the increment of the position and the command that was held meanwhile. A cycle
    /// begins where the command rises.
    #[inline]
    pub fn process<N: Number>(&self, state: &mut LimitCycleState<N>, increment: N, command: N) {
        if state.last_command < N::ZERO && command > N::ZERO {
            if state.begun {
                self.end_cycle(state);
            }
            state.running = Integrals::NONE;
            state.place = N::ZERO;
            state.begun = true;
        }
        // The mean direction: within the sample in which the servo turns, the velocity passes zero
        // in a straight line, from half the change below the increment to half above it.
        let half = N::from_f64(0.5);
        let turn = half * (increment - state.last_increment).magnitude();
        let direction = if increment.magnitude() < turn {
            increment * turn.reciprocal()
        } else if increment > N::ZERO {
            N::ONE
        } else if increment < N::ZERO {
            -N::ONE
        } else {
            N::ZERO
        };
        let middle = state.place + half * increment;
        let sum = &mut state.running;
        sum.period += N::ONE;
        sum.command += command;
        sum.position += middle;
        sum.direction += direction;
        sum.position_command += middle * command;
        sum.position_direction += middle * direction;
        sum.velocity_squared += increment * increment;
        sum.velocity_command += increment * command;
        sum.path += increment.magnitude();
        sum.direction_command += direction * command;
        state.place += increment;
        state.last_increment = increment;
        state.last_command = command;
    }

    fn end_cycle<N: Number>(&self, state: &mut LimitCycleState<N>) {
        let tolerance = N::from_f64(Self::TOLERANCE);
        let alike = |new: N, old: N| (new - old).magnitude() <= tolerance * old;
        let (new, old) = (&state.running, &state.last);
        let mean_square = new.velocity_squared * old.period;
        let steady = alike(new.period, old.period)
            && alike(mean_square, old.velocity_squared * new.period)
            // A servo that drifts does not swing about a place.
            && state.place.magnitude() <= tolerance * new.path;
        if steady {
            state.steady_cycles += 1;
            // An average that follows slowly: ten cycles' memory at most.
            let weight = N::from_f64(1.0 / f64::from(state.steady_cycles.min(10)));
            state.steady = state
                .steady
                .each(*new, |mean, new| mean + weight * (new - mean));
        } else {
            state.steady_cycles = 0;
            state.steady = Integrals::NONE;
        }
        state.last = state.running;
    }

    /// Cycles in a row that were alike.
    #[must_use]
    pub fn steady_cycles<N: Number>(&self, state: &LimitCycleState<N>) -> u32 {
        state.steady_cycles
    }

    /// a, b and c from one cycle, SI; none unless it is steady.
    #[must_use]
    pub fn estimates<N: Number>(&self, state: &LimitCycleState<N>) -> Option<ServoParameters> {
        let cycle = self.balance(state)?;
        // With g = g₀ + g₁ c from the balance of q, and x from that of q̇, the balance of s is an
        // equation in c alone.
        let slope = cycle.path / cycle.velocity_squared;
        let drive = cycle.velocity_command * slope - cycle.direction_command;
        let friction = cycle.moving - cycle.path * slope;
        let coulomb = -cycle.gain * drive / (friction + cycle.gain_per_friction * drive);
        let gain = cycle.gain + cycle.gain_per_friction * coulomb;
        let x = (gain * cycle.velocity_command - coulomb * cycle.path) / cycle.velocity_squared;
        self.servo(x, gain, coulomb)
    }

    /// a, b and c from two cycles of different size, SI: the balances of q give b, those of q̇ separate
    /// friction that grows with the velocity from friction that does not. None unless both are steady.
    #[must_use]
    pub fn estimates_of_two<N: Number>(
        &self,
        first: &LimitCycleState<N>,
        second: &LimitCycleState<N>,
    ) -> Option<ServoParameters> {
        let (one, two) = (self.balance(first)?, self.balance(second)?);
        let gain = 0.5 * (one.gain + two.gain);
        let determinant = one.velocity_squared * two.path - two.velocity_squared * one.path;
        let x = gain * (one.velocity_command * two.path - two.velocity_command * one.path)
            / determinant;
        let coulomb = gain
            * (one.velocity_squared * two.velocity_command
                - two.velocity_squared * one.velocity_command)
            / determinant;
        self.servo(x, gain, coulomb)
    }

    fn servo(&self, x: f64, gain: f64, coulomb: f64) -> Option<ServoParameters> {
        plausible(ServoParameters {
            a: x / Parameter::A.scale(&self.units),
            b: gain / Parameter::B.scale(&self.units),
            coulomb: coulomb / Parameter::Coulomb.scale(&self.units),
            load: 0.0,
        })
    }

    /// The steady cycle without the load, which the balance of 1 gives.
    fn balance<N: Number>(&self, state: &LimitCycleState<N>) -> Option<Balance> {
        if state.steady_cycles < Self::STEADY_CYCLES {
            return None;
        }
        let cycle = &state.steady;
        let value = N::to_f64;
        let period = value(cycle.period);
        let mean_position = value(cycle.position) / period;
        let mean_direction = value(cycle.direction) / period;
        let command = value(cycle.position_command) - mean_position * value(cycle.command);
        let direction = value(cycle.position_direction) - mean_position * value(cycle.direction);
        let velocity_squared = value(cycle.velocity_squared);
        Some(Balance {
            velocity_squared,
            velocity_command: value(cycle.velocity_command),
            path: value(cycle.path),
            direction_command: value(cycle.direction_command)
                - mean_direction * value(cycle.command),
            moving: period - mean_direction * value(cycle.direction),
            gain: -velocity_squared / command,
            gain_per_friction: direction / command,
        })
    }
}

/// A cycle's integrals without the load.
#[derive(Debug, Clone, Copy)]
struct Balance {
    velocity_squared: f64,
    velocity_command: f64,
    path: f64,
    direction_command: f64,
    moving: f64,
    gain: f64,
    gain_per_friction: f64,
}
