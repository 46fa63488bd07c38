#[cfg(test)]
use super::DetectionTimes;
use super::blocks::{BlockPart, Parts, PartsState};
use super::bounds::{Bounds, BoundsState};
use super::following::{Following, FollowingState};
use super::known_servo::{KnownServo, MAX_DELAY_SAMPLES};
use super::oscillation::{Oscillation, OscillationState};
use super::readings::{Readings, ReadingsState};
use super::response::{Known, ResponseCheck, ResponseCheckState};
use super::standstill::{StandstillWatch, StandstillWatchState, Under};
use super::{Observation, Use, WatchSettings};
use identifier_core::error::OutOfRange;
use identifier_core::number::Number;
use identifier_core::reason::Reason;

/// Configuration of the watch over a servo and its encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoWatch<N> {
    bounds: Bounds<N>,
    readings: Readings<N>,
    motion: StandstillWatch<N>,
    oscillation: Oscillation<N>,
    following: Following,
    used_for: Use,
    parts: Parts,
    /// Samples of the longer blocks.
    longer: i32,
    /// Over shorter and over longer blocks.
    response: [ResponseCheck<N>; 2],
    /// The command that no load explains, if it does not step.
    beyond_load: N,
}

/// State of the watch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoWatchState<N> {
    bounds: BoundsState<N>,
    readings: ReadingsState<N>,
    motion: StandstillWatchState<N>,
    oscillation: OscillationState<N>,
    following: FollowingState<N>,
    /// The increment before, counts, and the samples running in which the servo gained speed against the command.
    last: N,
    gains_against: u32,
    /// Longer blocks that contradict the command while the servo does not follow.
    contradicted: u32,
    parts: PartsState<N>,
    /// A part that the longer blocks take in the next sample, for no sample to end both.
    part: Option<BlockPart<N>>,
    response: [ResponseCheckState<N>; 2],
    known: Option<Known<N>>,
    /// The last commands; the place of the newest, and how far back the one is that acts.
    commands: [N; MAX_DELAY_SAMPLES],
    newest: usize,
    delay: usize,
    /// The mean command that acted in the sample.
    command: N,
    /// The part of a sample in which the one before it still acts.
    late: N,
    /// True if there was a sample.
    begun: bool,
}

/// The places of the two lengths of blocks.
const SHORTER_BLOCKS: usize = 0;
const LONGER_BLOCKS: usize = 1;

impl<N: Number> ServoWatch<N> {
    /// All of them, for [`process_some`](Self::process_some).
    pub const ALL_DETECTORS: u32 = 0b1111;
    /// Length of the shorter blocks over which motion and command are compared, s,
    const SHORT_BLOCK_TIME: f64 = 2.5e-3;
    /// and the least in samples, so that the error of the delay is a small part.
    const MIN_BLOCK_SAMPLES: f64 = 6.0;
    /// The longer blocks are longer by this.
    const LONG_BLOCK_FACTOR: i32 = 4;

    /// # Errors
    /// The setting that is not allowed, by name.
    pub fn new(settings: &WatchSettings) -> Result<Self, OutOfRange> {
        let units = settings.check()?;
        let samples = libm::round(Self::SHORT_BLOCK_TIME / units.sample_time());
        let shorter = samples.max(Self::MIN_BLOCK_SAMPLES) as i32;
        Ok(Self {
            bounds: Bounds::new(settings, &units),
            readings: Readings::new(settings, &units),
            motion: StandstillWatch::new(settings, &units),
            oscillation: Oscillation::new(settings, &units),
            following: Following::new(&units),
            used_for: settings.used_for,
            parts: Parts::new(shorter),
            longer: Self::LONG_BLOCK_FACTOR * shorter,
            beyond_load: N::from_f64(ResponseCheck::<N>::BEYOND_LOAD * settings.limit()),
            response: [1, Self::LONG_BLOCK_FACTOR]
                .map(|parts| ResponseCheck::new(parts, shorter, settings.limit())),
        })
    }

    /// Begins with an unknown servo.
    #[must_use]
    pub fn start(&self) -> ServoWatchState<N> {
        ServoWatchState {
            bounds: self.bounds.start(),
            readings: self.readings.start(),
            motion: self.motion.start(),
            oscillation: self.oscillation.start(),
            following: FollowingState::default(),
            last: N::ZERO,
            gains_against: 0,
            contradicted: 0,
            parts: PartsState::default(),
            part: None,
            response: Default::default(),
            known: None,
            commands: [N::ZERO; MAX_DELAY_SAMPLES],
            newest: 0,
            delay: 0,
            command: N::ZERO,
            late: N::ZERO,
            begun: false,
        }
    }

    /// Begins with a servo of which only the delay of the commands is known, samples from 0 to [`MAX_DELAY_SAMPLES`]
    /// − 2.
    pub(crate) fn start_delayed(&self, delay: f64) -> ServoWatchState<N> {
        let whole = libm::floor(delay.max(0.0).min((MAX_DELAY_SAMPLES - 2) as f64));
        ServoWatchState {
            delay: whole as usize,
            ..self.start()
        }
    }

    /// From now on the servo is identified.
    pub fn know(&self, state: &mut ServoWatchState<N>, servo: &KnownServo<N>) {
        Readings::know(&mut state.readings, servo.change);
        StandstillWatch::know(&mut state.motion, &servo.able);
        state.known = Some(servo.response);
        state.delay = servo.delay;
        state.late = servo.part;
        state.restart_comparison();
    }

    /// Forgets the servo and all evidence against it: what was known may be wrong.
    pub(crate) fn forget(&self, state: &mut ServoWatchState<N>, command: N) {
        state.known = None;
        state.restart_comparison();
        state.forget_half_cycles();
        (state.gains_against, state.contradicted) = (0, 0);
        state.motion = self.motion.start();
        StandstillWatch::begin(&mut state.motion, command);
    }

    /// A sample.
    ///
    /// # Errors
    /// The fault. The state has taken the sample nevertheless; the next sample reports it again.
    pub fn process(
        &self,
        state: &mut ServoWatchState<N>,
        seen: &Observation<N>,
    ) -> Result<(), Reason> {
        self.process_some(state, seen, Self::ALL_DETECTORS)
    }

    /// A sample by some of the detectors, each a bit. They may take turns until the next sample, the lowest bit first:
    /// the one that takes the sample and checks time, reading and limits, then standstill, response and oscillation.
    ///
    /// # Errors
    /// As [`process`](Self::process).
    #[inline(never)]
    pub fn process_some(
        &self,
        state: &mut ServoWatchState<N>,
        seen: &Observation<N>,
        detectors: u32,
    ) -> Result<(), Reason> {
        if detectors & 1 != 0 {
            self.take(state, seen)?;
        }
        let (Some(increment), command) = (seen.increment, state.command) else {
            return Ok(());
        };
        if detectors & 2 != 0 {
            let under = match seen.setpoint {
                _ if seen.must_move => Under::Push,
                Some(setpoint) => Under::Control {
                    setpoint,
                    error: setpoint - seen.position,
                },
                None => Under::Nothing,
            };
            self.motion
                .process(&mut state.motion, increment, command, under)?;
        }
        if detectors & 4 != 0 {
            self.following
                .process(&mut state.following, seen.setpoint, seen.position);
            let waiting = state.part.take();
            state.part = self.parts.process(&mut state.parts, increment, command);
            if let Some(part) = waiting {
                self.compare(state, LONGER_BLOCKS, &part, seen)?;
            }
            if let Some(part) = state.part {
                self.compare(state, SHORTER_BLOCKS, &part, seen)?;
            }
        }
        if detectors & 8 == 0 {
            return Ok(());
        }
        self.oscillation.process(
            &mut state.oscillation,
            seen.setpoint,
            seen.position,
            command,
        )
    }

    /// Takes a sample, and checks its time, reading and limits.
    #[inline]
    fn take(&self, state: &mut ServoWatchState<N>, seen: &Observation<N>) -> Result<(), Reason> {
        if !state.begun {
            state.begun = true;
            state.commands = [seen.command; MAX_DELAY_SAMPLES];
            StandstillWatch::begin(&mut state.motion, seen.command);
        }
        self.bounds.time(&mut state.bounds, seen.late)?;
        let command = state.acting(seen.command);
        state.command = command;
        let speed = state.bounds.speed;
        (self.readings).process(&mut state.readings, seen.increment, speed, command)?;
        let Some(increment) = seen.increment else {
            state.restart_comparison();
            return Ok(());
        };
        state.follow_speed(increment, command, self.beyond_load);
        self.bounds
            .motion(&mut state.bounds, increment, seen.position)
            .map_err(|limit| state.detected_fault().unwrap_or(limit))
    }

    /// Compares motion and command over the shorter or the longer blocks.
    #[inline(never)]
    fn compare(
        &self,
        state: &mut ServoWatchState<N>,
        of: usize,
        part: &BlockPart<N>,
        seen: &Observation<N>,
    ) -> Result<(), Reason> {
        let relay = seen.must_move;
        let is_operation = self.used_for == Use::Operation || seen.excited;
        let (Some(response), Some(past)) = (self.response.get(of), state.response.get_mut(of))
        else {
            return Ok(());
        };
        let judged = response.take(past, part, state.known.as_ref(), relay);
        let block = match judged {
            Ok(Some(block)) => block,
            Ok(None) => return Ok(()),
            Err(reason) if is_operation && Self::is_explained(state, of, reason) => return Ok(()),
            Err(reason) => return Err(reason),
        };
        if relay {
            StandstillWatch::learn(&mut state.motion, block.acceleration.magnitude());
        }
        if relay || (state.known.is_some() && !seen.excited) {
            StandstillWatch::jolts(&mut state.motion, &block)?;
        }
        Ok(())
    }

    /// True if loads, another inertia or a resonance may explain a motion that is not the command's.
    fn is_explained(state: &mut ServoWatchState<N>, of: usize, reason: Reason) -> bool {
        /// Longer blocks that must agree: a push that sets in is over by then.
        const MIN_BLOCKS: u32 = 5;
        // A weak actuator and a heavy load are the same.
        let is_sure =
            state.known.is_some() && of == LONGER_BLOCKS && reason != Reason::ActuatorWeak;
        if Following::follows(&state.following) {
            state.contradicted = 0;
        } else if is_sure {
            state.contradicted = state.contradicted.saturating_add(1);
        }
        !is_sure || state.contradicted < MIN_BLOCKS
    }

    /// The number of samples within which each fault is found, with the present model of the servo.
    #[cfg(test)]
    pub(crate) fn detection_times(&self, state: &ServoWatchState<N>) -> DetectionTimes {
        DetectionTimes {
            overrun: Bounds::<N>::MAX_LATE_SAMPLES,
            encoder_lost: self.readings.lost_after as u32,
            smallest_jump: self.readings.smallest_jump(&state.readings),
            speed: libm::ceil(self.bounds.samples_until_too_fast()) as u32,
            standing: state.motion.patience() as u32,
            response: (ResponseCheck::<N>::BLOCKS * self.longer) as u32 + state.delay as u32,
            half_cycles: Oscillation::<N>::HALF_CYCLES,
            longest_half_cycle: self.oscillation.longest as u32,
        }
    }
}

impl<N: Number> ServoWatchState<N> {
    /// Half-cycles about the setpoint running that have not decayed.
    pub(crate) fn half_cycles(&self) -> u32 {
        self.oscillation.half_cycles()
    }

    /// Begins to count them anew: the loop is another one.
    pub(crate) fn forget_half_cycles(&mut self) {
        self.oscillation.forget();
    }

    fn restart_comparison(&mut self) {
        self.parts = PartsState::default();
        self.part = None;
        self.response = Default::default();
    }

    /// Takes in if the servo gains speed against a command that no load explains.
    #[inline]
    fn follow_speed(&mut self, increment: N, command: N, beyond_load: N) {
        let against = increment * command < N::ZERO && command.magnitude() >= beyond_load;
        let gains = increment.magnitude() > self.last.magnitude();
        self.gains_against = if against && gains {
            self.gains_against.saturating_add(1)
        } else {
            0
        };
        self.last = increment;
    }

    /// Why a limit may have been left: first a loop that acts in the wrong direction, then one that does not act.
    fn detected_fault(&self) -> Option<Reason> {
        /// Samples: a command that is two of them late has acted by then.
        const MIN_SAMPLES: u32 = 4;
        let against = (self.gains_against >= MIN_SAMPLES).then_some(Reason::Reversed);
        let [shorter, longer] = self
            .response
            .each_ref()
            .map(ResponseCheckState::detected_fault);
        let compared = match (shorter, longer) {
            (reversed @ Some(Reason::Reversed), _) | (_, reversed @ Some(Reason::Reversed)) => {
                reversed
            }
            _ => shorter.or(longer),
        };
        // A load takes a servo whose actuator is dead against the command too: less far than a reversed one.
        match self.known {
            Some(_) => compared.or(against),
            None => against.or(compared),
        }
    }

    /// The mean command that acts in a sample when this command is given.
    #[inline]
    fn acting(&mut self, command: N) -> N {
        self.newest = (self.newest + 1) % MAX_DELAY_SAMPLES;
        if let Some(place) = self.commands.get_mut(self.newest) {
            *place = command;
        }
        let given_before = |samples: usize| {
            let place = (self.newest + MAX_DELAY_SAMPLES - samples) % MAX_DELAY_SAMPLES;
            self.commands.get(place).copied().unwrap_or(command)
        };
        let (now, before) = (given_before(self.delay), given_before(self.delay + 1));
        now + self.late * (before - now)
    }
}
