//! Detection of a standstill that is none: a stuck encoder, a dead actuator.

use super::blocks::WatchBlock;
use super::model::{LOW_SPEED, MODEL_ERROR, Model};
use super::{Use, WatchSettings};
use identifier_core::number::Number;
use identifier_core::reason::Reason;
use identifier_core::units::Units;

/// When a servo cannot have stopped, and when it cannot remain at standstill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StandstillWatch<N> {
    /// Forgetting factor of the mean command, per sample.
    smoothing: N,
    /// Forgetting factor of the highest and the lowest command of a standstill.
    fading: N,
    /// Ranges of the command that move any servo, with a step of the load and without, command units.
    ranges: [N; 2],
    /// Samples for which an unknown servo may be at standstill under a command that must move it.
    patience: i32,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct StandstillWatchState<N> {
    /// The increment before, counts.
    last: N,
    /// Since the last count: how fast the servo is at least, counts a sample,
    glide: N,
    /// and how far it has come at least, counts.
    passed: N,
    /// True if it came to standstill sooner than is likely.
    abrupt: bool,
    /// Counts from where it came to standstill.
    away: N,
    /// Mean of the command,
    command: N,
    /// and its lowest and highest at this standstill.
    range: [N; 2],
    /// Where the setpoint was when it began, counts.
    setpoint: N,
    /// The command under which it came to standstill where a load had moved it, before that its holding command.
    settled: N,
    /// The largest error since the last standstill, counts, and whether the setpoint moved since.
    farthest: N,
    asked: bool,
    /// Samples of this standstill, up to a maximum,
    still: i32,
    /// and of those, running, in which it had to move and did not, below zero where the relay pushes down.
    pushed: i32,
    able: AccelerationLimits<N>,
}

/// Capabilities of a servo.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct AccelerationLimits<N> {
    /// Largest deceleration, counts per sample squared: by friction and load,
    braking: N,
    /// and for a unit of command; zero before it is identified.
    gain: N,
    /// Ranges of the command at which it may be at standstill, with a load step and without, command units,
    stands: [N; 2],
    /// and around which command, and how far from it, after a step of the load.
    holding: N,
    reach: N,
    /// Samples until it counts as at standstill, and those for which it may remain there although it must move.
    settling: i32,
    patience: i32,
}

impl<N: Number> AccelerationLimits<N> {
    /// The same with a load that this command balances.
    pub(super) fn with_holding_of(self, command: N) -> Self {
        Self {
            holding: command,
            ..self
        }
    }

    /// The same, and braked as this servo may be.
    pub(super) fn with_braking_of(self, model: &Model) -> Self {
        Self {
            braking: N::from_f64(MODEL_ERROR * model.braking),
            gain: N::from_f64(MODEL_ERROR * model.gain),
            ..self
        }
    }
}

impl<N: Number> StandstillWatch<N> {
    /// Counts that are missed before the encoder is said to be stuck.
    const MISSED_COUNTS: i32 = 7;
    /// Counts of a servo at standstill.
    const SLIP_COUNTS: i32 = 2;
    /// The part of the command's reach beyond which it balances another load.
    const LOADED: f64 = 0.5;
    /// Largest possible braking over the largest change of speed observed.
    const UNKNOWN_BRAKING: f64 = 4.0;
    /// The shares of the command's limit beyond which friction cannot hold any servo, with a load step and without.
    /// Coulomb friction is 20 % in either direction, with a tenth in reserve.
    const RANGES: [f64; 2] = [0.8, 0.5];
    /// A setpoint that moves by this many counts commands a motion; the command's change is then no
    /// answer to a load.
    const SETPOINT_STEP: i32 = 20;
    /// Braking beyond which a stop is abrupt, over the largest possible.
    const LIKELY_BRAKING: f64 = 0.4;
    /// Memory of the command, s.
    const SMOOTHING_TIME: f64 = 5e-3;
    /// Memory of the range of the command, s: a load that changes more slowly is no fault.
    const FADING_TIME: f64 = 1.0;
    /// The time for which a servo may be at standstill under a command that must move it, s. Unknown servo,
    const MAX_PATIENCE: f64 = 0.1;
    /// and the least for an identified one.
    const MIN_PATIENCE: f64 = 0.02;

    pub(super) fn new(settings: &WatchSettings, units: &Units) -> Self {
        let sample_time = units.sample_time();
        let over = |time: f64| N::from_f64(-libm::expm1(-sample_time / time));
        Self {
            smoothing: over(Self::SMOOTHING_TIME),
            fading: over(Self::FADING_TIME),
            ranges: Self::RANGES.map(|share| N::from_f64(share * settings.limit())),
            patience: Self::longest_patience(sample_time),
        }
    }

    fn longest_patience(sample_time: f64) -> i32 {
        Self::samples(Self::MAX_PATIENCE, sample_time)
    }

    fn samples(time: f64, sample_time: f64) -> i32 {
        /// The fewest, so that a delay of the command has passed.
        const MIN_SAMPLES: f64 = 8.0;
        // A cast saturates.
        (time / sample_time).max(MIN_SAMPLES) as i32
    }

    pub(super) fn start(&self) -> StandstillWatchState<N> {
        StandstillWatchState {
            able: AccelerationLimits {
                braking: N::REACH,
                stands: self.ranges,
                reach: N::REACH,
                settling: self.patience,
                patience: self.patience,
                ..AccelerationLimits::default()
            },
            ..StandstillWatchState::default()
        }
    }

    /// This command acts when it begins.
    pub(super) fn begin(state: &mut StandstillWatchState<N>, command: N) {
        state.command = command;
        state.range = [command; 2];
    }

    /// Capabilities of a known servo.
    pub(super) fn able(
        model: &Model,
        settings: &WatchSettings,
        sample_time: f64,
    ) -> AccelerationLimits<N> {
        // The share of the command's limit beyond breakaway that a command which must move the servo has: in operation
        // a load may change a little in any moment.
        // It may also turn from a step to one side to a step to the other.
        let (push_share, load_steps) = match settings.used_for {
            Use::Commissioning => (0.05, 1.0),
            Use::Operation => (0.08, 2.0),
        };
        // To either side of the holding command, and a step of the load.
        let load_step = MODEL_ERROR * model.load_step / model.gain;
        let friction = 2.0 * LOW_SPEED * model.breakaway + push_share * settings.limit();
        let reach = LOW_SPEED * model.breakaway + load_step + push_share * settings.limit();
        // Until it has moved by what counts as motion, under a push that is hardly more than friction.
        let push = push_share * settings.limit() * model.gain;
        let moves = libm::sqrt(2.0 * f64::from(Self::MISSED_COUNTS) / push);
        let least = f64::from(Self::samples(Self::MIN_PATIENCE, sample_time));
        let most = f64::from(Self::longest_patience(sample_time));
        let shows = moves + model.delay as f64;
        let patience = shows.max(least.min(most)).min(most);
        let settling = match settings.used_for {
            Use::Commissioning => patience,
            // A fine encoder shows a standstill sooner.
            Use::Operation => (1.5 * shows).max(patience / 2.0).min(patience),
        };
        AccelerationLimits {
            braking: N::from_f64(MODEL_ERROR * model.braking),
            gain: N::from_f64(MODEL_ERROR * model.gain),
            stands: [friction + load_steps * load_step, friction].map(N::from_f64),
            holding: N::from_f64(-model.load / model.gain),
            reach: N::from_f64(reach),
            settling: settling as i32,
            patience: patience as i32,
        }
    }

    pub(super) fn know(state: &mut StandstillWatchState<N>, able: &AccelerationLimits<N>) {
        state.able = *able;
        state.settled = able.holding;
    }

    /// The servo was seen to change its speed by so much, counts a sample squared.
    #[inline]
    pub(super) fn learn(state: &mut StandstillWatchState<N>, acceleration: N) {
        let braking = N::from_f64(Self::UNKNOWN_BRAKING) * acceleration;
        if state.able.gain == N::ZERO
            && (state.able.braking == N::REACH || braking > state.able.braking)
        {
            state.able.braking = braking;
        }
    }

    #[inline]
    pub(super) fn process(
        &self,
        state: &mut StandstillWatchState<N>,
        increment: N,
        command: N,
        under: Under<N>,
    ) -> Result<(), Reason> {
        if state.able.gain > N::ZERO {
            Self::stops(state, increment, command)?;
        }
        self.stands(state, increment, command, under)
    }

    /// True if the servo can have stopped as soon as the encoder, sample by sample: where a sample has
    /// many counts.
    #[inline]
    fn stops(state: &mut StandstillWatchState<N>, increment: N, command: N) -> Result<(), Reason> {
        if increment == N::ZERO {
            state.glide = state.glide - state.braking(command);
            if state.glide > N::ZERO {
                state.passed += state.glide;
                if state.passed > N::from_count(Self::MISSED_COUNTS) {
                    return Err(Reason::EncoderStuck);
                }
            }
        } else {
            // A reading that jumps is no speed: two must agree on it.
            let slower = if increment.magnitude() < state.last.magnitude() {
                increment
            } else {
                state.last
            };
            state.passed = N::ZERO;
            state.glide = slower.magnitude() - N::ONE;
        }
        state.last = increment;
        Ok(())
    }

    /// The same over blocks, where a sample has few, and whether the servo can have changed its speed so
    /// soon at all.
    pub(super) fn jolts(
        state: &mut StandstillWatchState<N>,
        block: &WatchBlock<N>,
    ) -> Result<(), Reason> {
        let [now, _, before] = block.counts;
        let possible = N::from_f64(2.0) * block.area * state.braking(block.largest);
        let missed = N::from_count(Self::MISSED_COUNTS);
        let change = (now - before).magnitude() - missed;
        let sudden = change > N::from_f64(Self::LIKELY_BRAKING) * possible;
        state.abrupt |= now == N::ZERO && sudden;
        if change <= possible || state.able.gain == N::ZERO {
            return Ok(());
        }
        let (size, past) = (now.magnitude(), before.magnitude());
        let half = N::from_f64(0.5);
        // The block in which the encoder fails shows only a part of it: it waits for the next.
        if now == N::ZERO {
            Err(Reason::EncoderStuck)
        } else if size > past + missed + possible {
            Err(Reason::EncoderJumped)
        } else if now * before < N::ZERO && size > half * past {
            Err(Reason::Reversed)
        } else {
            Ok(())
        }
    }

    /// True if the servo can be at standstill under this command.
    #[inline]
    fn stands(
        &self,
        state: &mut StandstillWatchState<N>,
        increment: N,
        command: N,
        under: Under<N>,
    ) -> Result<(), Reason> {
        state.command += self.smoothing * (command - state.command);
        state.away += increment;
        if let Under::Control { setpoint, error } = under {
            state.asked |= state.is_asked(setpoint);
            if error.magnitude() > state.farthest {
                state.farthest = error.magnitude();
            }
        }
        if state.away.magnitude() > N::from_count(Self::SLIP_COUNTS) {
            state.away = N::ZERO;
            state.still = 0;
            state.pushed = 0;
            state.abrupt = false;
            return Ok(());
        }
        // The braking command is not yet the one of the standstill.
        if state.still < state.able.settling {
            state.still += 1;
            state.range = [state.command; 2];
            if state.still == state.able.settling {
                state.settle(under);
            }
        }
        let [low, high] = &mut state.range;
        *low += self.fading * (state.command - *low);
        *high += self.fading * (state.command - *high);
        if state.command < *low {
            *low = state.command;
        }
        if state.command > *high {
            *high = state.command;
        }
        let [low, high] = state.range;
        let pushed = match under {
            Under::Nothing => false,
            Under::Push => true,
            Under::Control { setpoint, .. } => {
                let [disturbed, undisturbed] = state.able.stands;
                let stands = if state.is_asked(setpoint) {
                    undisturbed
                } else {
                    disturbed
                };
                state.command - low > stands
                    || high - state.command > stands
                    || [state.able.holding, state.settled]
                        .iter()
                        .all(|&holding| (state.command - holding).magnitude() > state.able.reach)
            }
        };
        if !pushed {
            state.pushed = 0;
            return Ok(());
        }
        // A relay of few counts turns within those of a standstill: the time of one push does not count for the next.
        state.pushed = match under {
            Under::Push if command < state.able.holding => state.pushed.min(0).saturating_sub(1),
            _ => state.pushed.max(0).saturating_add(1),
        };
        if state.pushed.saturating_abs() < state.able.patience {
            Ok(())
        } else if state.abrupt {
            Err(Reason::EncoderStuck)
        } else {
            Err(Reason::ActuatorDead)
        }
    }
}

impl<N: Number> StandstillWatchState<N> {
    /// Samples for which the servo may be at standstill although it must move.
    #[cfg(test)]
    pub(super) fn patience(&self) -> i32 {
        self.able.patience
    }

    /// It has come to standstill. This command balances the load, except for friction, if a load moved the servo at a
    /// constant setpoint, or if it reached its setpoint.
    fn settle(&mut self, under: Under<N>) {
        let Under::Control { setpoint, error } = under else {
            return;
        };
        let arrived = error.magnitude() <= N::from_count(StandstillWatch::<N>::SETPOINT_STEP);
        let is_moved = self.farthest > N::from_count(StandstillWatch::<N>::MISSED_COUNTS);
        let away = (self.command - self.able.holding).magnitude();
        let is_loaded = away > N::from_f64(StandstillWatch::<N>::LOADED) * self.able.reach;
        if is_loaded && is_moved && (arrived || !self.asked) {
            self.settled = self.command;
        }
        (self.setpoint, self.farthest, self.asked) = (setpoint, N::ZERO, false);
    }

    /// True if the setpoint has moved since the standstill began.
    fn is_asked(&self, setpoint: N) -> bool {
        let moved = (setpoint - self.setpoint).magnitude();
        moved > N::from_count(StandstillWatch::<N>::SETPOINT_STEP)
    }

    /// Largest deceleration of the servo, counts per sample squared.
    #[inline]
    fn braking(&self, command: N) -> N {
        self.able.braking + self.able.gain * command.magnitude()
    }
}

/// The influence that a servo is under.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Under<N> {
    /// Disabled, or a command that need not move it.
    Nothing,
    /// A command that must move it.
    Push,
    /// A controller with this setpoint and this error, counts.
    Control { setpoint: N, error: N },
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sample, from 1, in which a relay of 3 about a command is found to move nothing, and the patience. It pushes down for the
    /// samples that `is_down` holds for.
    fn found(
        rate: f64,
        balance: f64,
        position: impl Fn(i32) -> f64,
        is_down: impl Fn(i32, i32) -> bool,
    ) -> (Option<i32>, i32) {
        let settings = WatchSettings {
            sample_time: 1.0 / rate,
            resolution: 1e-3,
            travel: [-0.5, 2.0],
            speed: 30.0,
            command: [-9.0, 9.0],
            used_for: Use::Commissioning,
        };
        let units = Units::new(settings.sample_time, settings.resolution).expect("valid");
        let watch = StandstillWatch::<f64>::new(&settings, &units);
        let mut state = watch.start();
        state.able = state.able.with_holding_of(balance);
        StandstillWatch::begin(&mut state, balance);
        let patience = state.patience();
        let found = (1..20 * patience).find(|&sample| {
            let increment = position(sample) - position(sample - 1);
            let push = if is_down(sample, patience) { -3.0 } else { 3.0 };
            let seen = watch.process(&mut state, increment, balance + push, Under::Push);
            seen == Err(Reason::ActuatorDead)
        });
        (found, patience)
    }

    const RATES: [f64; 5] = [250.0, 1e3, 4e3, 10e3, 20e3];
    /// Commands that balance no load, and one larger than the relay, up and down.
    const BALANCES: [f64; 3] = [0.0, 5.0, -5.0];

    #[test]
    fn a_relay_of_few_counts_turns_and_does_not_stand() {
        for (rate, balance) in RATES.iter().flat_map(|&rate| BALANCES.map(|by| (rate, by))) {
            // Three edges to and fro, which are within the counts of a servo at standstill.
            let position = |sample: i32| {
                let half_cycles = f64::from(sample) / (0.04 * rate);
                (1.8 * libm::sin(core::f64::consts::PI * half_cycles)).floor()
            };
            let turning = found(rate, balance, position, |sample, _| position(sample) >= 0.0);
            assert_eq!(turning.0, None, "{rate} {balance}");
            let (lasting, patience) = found(rate, balance, position, |_, _| false);
            assert_eq!(lasting, Some(patience), "{rate} {balance}");
        }
    }

    #[test]
    fn a_relay_that_stands_after_a_turn_is_found_within_the_patience_from_there() {
        for (rate, balance) in RATES.iter().flat_map(|&rate| BALANCES.map(|by| (rate, by))) {
            let (seen, patience) = found(rate, balance, |_| 0.0, |sample, most| sample >= most);
            assert_eq!(seen, Some(2 * patience - 1), "{rate} {balance}");
        }
    }
}
