//! Detection of an oscillating loop.
//!
//! The error of a loop that settles oscillates about zero and decays, and the command with it. Six half-cycles
//! running that do not decay, each with a good part of the command behind it, are an oscillation (after
//! T. Hägglund, "A control-loop performance monitor", Control Engineering Practice 3, 1995). Half-cycles that
//! the setpoint makes are its own.

use super::{Use, WatchSettings};
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::units::Units;

/// Limits of a half-cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Oscillation<N> {
    /// The command's range in it, at least, command units.
    command: N,
    /// Its length, at most, samples.
    pub(super) longest: i32,
    /// Minimum ratio of a half-cycle to the one before.
    min_ratio: N,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct OscillationState<N> {
    /// True if the error is positive in this half-cycle.
    positive: bool,
    /// Samples that it lasts.
    age: i32,
    /// Its largest error, counts.
    peak: N,
    /// That of the half-cycle before.
    before: N,
    /// Lowest and highest command.
    command: [N; 2],
    /// Where the setpoint was when the half-cycles began.
    setpoint: N,
    half_cycles: u32,
}

impl<N: Number> OscillationState<N> {
    /// Half-cycles running that have not decayed.
    pub(super) fn half_cycles(&self) -> u32 {
        self.half_cycles
    }

    pub(super) fn forget(&mut self) {
        self.half_cycles = 0;
    }
}

impl<N: Number> Oscillation<N> {
    /// Half-cycles running that are an oscillation.
    pub(super) const HALF_CYCLES: u32 = 6;
    /// The smallest, counts.
    pub(super) const MIN_PEAK: i32 = 8;
    /// Half of it: the error must pass this on the other side to begin a new half-cycle.
    const TURN_COUNTS: i32 = 4;
    /// Minimum ratio of a half-cycle to the one before,
    const MIN_DECAY_RATIO: f64 = 0.7;
    /// and in operation, where a load that oscillates makes the loop oscillate evenly: there a loop must grow by itself.
    const MIN_GROWTH_RATIO: f64 = 1.1;
    /// The share of the command's limit that it moves through at least.
    const MIN_COMMAND_SHARE: f64 = 0.2;
    /// The longest, s.
    const MAX_HALF_CYCLE_TIME: f64 = 0.5;

    pub(super) fn new(settings: &WatchSettings, units: &Units) -> Self {
        let longest =
            (Self::MAX_HALF_CYCLE_TIME / units.sample_time()).max(f64::from(Self::MIN_PEAK));
        Self {
            command: N::from_f64(Self::MIN_COMMAND_SHARE * settings.limit()),
            longest: longest as i32,
            min_ratio: N::from_f64(match settings.used_for {
                Use::Commissioning => Self::MIN_DECAY_RATIO,
                Use::Operation => Self::MIN_GROWTH_RATIO,
            }),
        }
    }

    pub(super) fn start(&self) -> OscillationState<N> {
        OscillationState {
            positive: true,
            ..OscillationState::default()
        }
    }

    #[inline]
    pub(super) fn process(
        &self,
        state: &mut OscillationState<N>,
        setpoint: Option<N>,
        position: N,
        command: N,
    ) -> Result<(), Reason> {
        let Some(setpoint) = setpoint else {
            state.half_cycles = 0;
            state.age = 0;
            return Ok(());
        };
        let error = setpoint - position;
        let size = error.magnitude();
        let positive = error > N::ZERO;
        let moved = (setpoint - state.setpoint).magnitude();
        if moved > N::from_count(Self::MIN_PEAK) && moved + moved > state.peak {
            state.setpoint = setpoint;
            state.half_cycles = 0;
        }
        if state.age <= self.longest {
            state.age += 1;
        }
        if positive != state.positive && size >= N::from_count(Self::TURN_COUNTS) {
            state.half_cycles = if self.is_oscillation(state) {
                state.half_cycles + 1
            } else {
                0
            };
            state.before = state.peak;
            state.positive = positive;
            state.age = 0;
            state.peak = size;
            state.command = [command; 2];
            if state.half_cycles >= Self::HALF_CYCLES {
                return Err(Reason::Oscillating);
            }
            return Ok(());
        }
        if positive == state.positive && size > state.peak {
            state.peak = size;
        }
        let [low, high] = &mut state.command;
        if command < *low {
            *low = command;
        }
        if command > *high {
            *high = command;
        }
        Ok(())
    }

    /// True if the half-cycle that has ended is one of an oscillation.
    fn is_oscillation(&self, state: &OscillationState<N>) -> bool {
        let [low, high] = state.command;
        state.age <= self.longest
            && state.peak >= N::from_count(Self::MIN_PEAK)
            && state.peak >= self.min_ratio * state.before
            && high - low >= self.command
    }
}
