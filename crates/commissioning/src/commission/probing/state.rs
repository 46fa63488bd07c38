use super::super::half_cycles::HalfCycles;
use super::super::regression::RegressionState;
use super::super::rough_model::{Breakaway, RoughModel};
use super::observer::ObserverState;
use super::plan::{COMMANDS, Plan};
use identifier_core::number::Number;
use identifier_core::reason::Reason;

/// A probing motion under way. Counts and samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ProbingState<N> {
    pub(super) stage: ProbingStage,
    pub(super) ending: Option<Result<(), Reason>>,
    pub(super) samples: u32,
    pub(super) position: N,
    /// The command from which the ramp began.
    pub(super) held: N,
    /// How it broke away, if the ramp did that.
    pub(super) broke_away: Option<Breakaway<N>>,
    /// The speed at which that was noticed, as the ramp explains it.
    pub(super) noticed_speed: N,
    /// The direction of the present push.
    pub(super) direction: N,
    /// The furthest position in it.
    pub(super) extreme: N,
    /// The direction of the last count.
    pub(super) motion_direction: N,
    /// True if the encoder shows a standstill.
    pub(super) stands: bool,
    /// The ramp's distance from its beginning, command units.
    pub(super) ramp: N,
    /// The position of the last standstill.
    pub(super) origin: N,
    /// Commands and displacement since then.
    pub(super) free_motion: FreeMotion<N>,
    /// Where and when the first count was passed.
    pub(super) first_count: Option<FirstCount<N>>,
    /// The guess from which the regression is to begin.
    pub(super) pending_estimate: Option<Guess<N>>,
    pub(super) servo: RoughModel<N>,
    /// The first estimate of b.
    pub(super) guessed: N,
    pub(super) observed: ObserverState<N>,
    pub(super) gathered: RegressionState<N>,
    pub(super) commands: [N; COMMANDS],
    pub(super) newest: usize,
    /// Samples since the encoder last moved.
    pub(super) still: u32,
    /// Samples for which all of the command has been given.
    pub(super) at_limit: u32,
    /// Samples since the motion is to end.
    pub(super) ending_for: u32,
    /// Command added beyond the predicted one.
    pub(super) extra: N,
    /// Acceleration and amplitude of the present half-cycle.
    pub(super) acceleration: N,
    pub(super) amplitude: N,
    /// The direction in which it did not move under all of the command.
    pub(super) blocked: Option<N>,
    /// Reversals at the low and at the high end.
    pub(super) reversals: [u32; 2],
    /// Its half-cycles as the counts show them, and how many of them the relay did not plan.
    pub(super) half_cycles: HalfCycles<N>,
    pub(super) ringing: u32,
    /// True if there is a new estimate since the evidence was last judged.
    pub(super) is_new: bool,
    pub(super) evidence: Option<u32>,
    pub(super) held_at: N,
    /// The part of its usual bandwidth with which it is held.
    pub(super) held_by: N,
    /// The sample in which it last turned while it was held.
    pub(super) turned_at: u32,
    pub(super) stage_since: u32,
    /// The commands that may act in this sample.
    pub(super) allowed: [N; 2],
}

/// The first knowledge of a servo: b, and its acceleration without a command in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Guess<N> {
    pub(super) gain: N,
    pub(super) without: N,
    pub(super) forward: bool,
    pub(super) broke_away: Option<Breakaway<N>>,
    /// The speed at which that was noticed, as the ramp explains it; zero if the ramp has not moved it.
    pub(super) speed: N,
}

/// Stages of the probing motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum ProbingStage {
    /// The command grows until the servo moves.
    #[default]
    Seek,
    /// It is accelerated in the direction of the push.
    Push,
    /// It is braked out of it.
    Brake,
    /// It is braked for good.
    Stop,
    /// It is held where it stopped.
    Hold,
}

/// A motion that the ramp did not begin, from rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct FreeMotion<N> {
    /// The command with which it began.
    pub(super) base: N,
    /// True if it began when the servo was disabled.
    pub(super) is_released: bool,
    /// Samples, the integral of the command beyond that one, and the integral of that.
    pub(super) time: N,
    pub(super) pushed: N,
    pub(super) motion_direction: N,
    /// These three at the furthest place, and that.
    pub(super) furthest: [N; 4],
}

impl<N: Number> FreeMotion<N> {
    /// The motion of a servo that was disabled this number of samples ago.
    pub(super) fn released(samples: u32) -> Self {
        Self {
            is_released: true,
            time: N::from_count(samples.clamp(1, 1 << 20) as i32),
            ..Self::from(N::ZERO)
        }
    }

    /// One that begins under a command.
    pub(super) fn from(base: N) -> Self {
        Self {
            base,
            ..Self::default()
        }
    }

    /// Takes a sample: the command that acted, and how far the servo is.
    pub(super) fn follow(&mut self, acted: N, moved: N) {
        let push = acted - self.base;
        self.time += N::ONE;
        self.motion_direction += self.pushed + N::from_f64(0.5) * push;
        self.pushed += push;
        if moved.magnitude() > self.furthest[3].magnitude() {
            self.furthest = [self.time, self.pushed, self.motion_direction, moved];
        }
    }
}

impl<N: Number> FreeMotion<N> {
    /// The servo that reverses within a number of samples under the commands so far; `given` is the last. It follows
    /// from distance and speed `against` the direction of the ramp: w t²/2 − b ∬u = q and w t − b ∫u = v. None if it
    /// does not reverse, or the encoder does not clearly show that it is braked.
    pub(super) fn turns(&self, direction: N, against: N, given: N, within: N) -> Option<Guess<N>> {
        /// Counts by which the ramp must have held it back, and counts a sample that it must have fallen in the mean.
        const HELD_BACK: f64 = 4.0;
        const FAST: f64 = 4.0;
        let half = N::from_f64(0.5);
        let fallen = self.furthest[3].magnitude();
        let held_back = fallen - half * against * self.time;
        let pushed = direction * self.pushed;
        let against_it = half * pushed * self.time - direction * self.motion_direction;
        let is_fast = fallen > N::from_f64(FAST) * self.time;
        let is_braked = held_back > N::from_f64(HELD_BACK) && against_it > N::ZERO;
        if !(self.is_released && is_fast && is_braked) {
            return None;
        }
        let gain = held_back * against_it.reciprocal();
        let falls = (against + gain * pushed) * self.time.reciprocal();
        let braking = gain * direction * (given - self.base) - falls;
        (braking * within > against).then(|| Guess {
            gain,
            without: -(direction * falls) - gain * self.base,
            forward: direction < N::ZERO,
            broke_away: None,
            speed: N::ZERO,
        })
    }

    /// The turning point of a motion by the load whose last count has just been reversed: midway between the two
    /// counts.
    pub(super) fn turning(&self) -> [N; 4] {
        let half = N::from_f64(0.5);
        let [time, pushed, motion_direction, moved] = self.furthest;
        [
            half * (time + self.time),
            half * (pushed + self.pushed),
            half * (motion_direction + self.motion_direction),
            moved,
        ]
    }
}

/// The first edge that the ramp has passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FirstCount<N> {
    pub(super) sample: u32,
    pub(super) command: N,
    /// Counts, one or more.
    pub(super) moved: N,
}

impl<N: Number> ProbingState<N> {
    pub(super) fn new(plan: &Plan<N>, held: Option<N>) -> Self {
        let held = held.unwrap_or(N::ZERO);
        Self {
            held,
            direction: plan.first_direction,
            motion_direction: plan.first_direction,
            free_motion: FreeMotion::from(held),
            commands: [held; COMMANDS],
            half_cycles: HalfCycles::from(N::ZERO),
            held_by: N::ONE,
            allowed: plan.command,
            ..Self::default()
        }
    }

    /// Confines the command of this sample.
    pub(in crate::commission) fn allow(&mut self, commands: [N; 2]) {
        self.allowed = commands;
    }

    /// The command within those that may act; zero of one that is no number.
    pub(super) fn confined(&self, command: N) -> N {
        let [least, most] = self.allowed;
        if command.is_finite() {
            command.limited(least, most)
        } else {
            N::ZERO
        }
    }

    /// Position from where the motion began, counts.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn position(&self) -> N {
        self.position
    }

    /// The model of the servo so far.
    #[must_use]
    pub(crate) fn servo(&self) -> &RoughModel<N> {
        &self.servo
    }

    /// The command at which the servo broke away, if it did.
    pub(crate) fn broke_away(&self) -> Option<Breakaway<N>> {
        self.broke_away
    }

    /// Samples after which there was evidence, if there is.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn evidence(&self) -> Option<u32> {
        self.evidence
    }

    /// True if it is away from where the first motion began.
    pub(in crate::commission) fn is_away(&self) -> bool {
        self.position != N::ZERO
    }

    /// True if it accelerates or brakes a servo whose friction is estimated.
    pub(in crate::commission) fn is_oscillating(&self) -> bool {
        self.servo.is_known() && matches!(self.stage, ProbingStage::Push | ProbingStage::Brake)
    }

    /// Aims in a direction from here on.
    pub(super) fn aim(&mut self, direction: N) {
        self.direction = direction;
        self.extreme = self.position;
    }

    /// Takes in the direction of a count. The holding loop reduces its bandwidth at each half-cycle that is faster
    /// than its own. Slower half-cycles are those of a load on a spring, which the loop damps.
    pub(super) fn move_on(&mut self, motion_direction: N, hold_half_cycle: u32) {
        /// The part of the bandwidth that remains after a reversal, and the least part. First for a servo that its
        /// load moves, then for one that friction held until the ramp moved it.
        const LEFT: f64 = 0.8;
        const LEAST: [f64; 2] = [0.4, 0.1];
        if motion_direction != self.motion_direction && self.stage == ProbingStage::Hold {
            if self.samples.saturating_sub(self.turned_at) < hold_half_cycle {
                let least = LEAST[usize::from(self.broke_away.is_some())];
                self.held_by =
                    (N::from_f64(LEFT) * self.held_by).limited(N::from_f64(least), N::ONE);
            }
            self.turned_at = self.samples;
        }
        self.motion_direction = motion_direction;
    }

    /// Half-cycles continue with another model. Friction that this one has estimated is no longer added.
    pub(super) fn push_on_with(&mut self, servo: &RoughModel<N>) {
        let motion_direction = self.direction;
        let response_motions =
            |servo: &RoughModel<N>| motion_direction * servo.command(N::ZERO, motion_direction);
        let learnt = response_motions(servo) - response_motions(&self.servo);
        self.extra = (self.extra - learnt).limited(N::ZERO, self.extra);
    }

    /// True if a braked servo has passed its furthest position: it moves back, or is at standstill.
    pub(super) fn has_turned(&self) -> bool {
        self.stands || self.direction * (self.position - self.extreme) < N::ZERO
    }

    /// True if it has not moved for long enough under all of the command.
    pub(super) fn is_jammed(&self, plan: &Plan<N>) -> bool {
        self.still.min(self.at_limit) > plan.ramp.jammed()
    }

    pub(super) fn enter(&mut self, stage: ProbingStage) {
        self.stage = stage;
        self.stage_since = self.samples;
    }

    /// Remembers a command.
    pub(super) fn give(&mut self, command: N) {
        self.newest = (self.newest + 1) % self.commands.len();
        self.commands[self.newest] = command;
    }

    /// The command that was given a number of samples before the last.
    pub(super) fn given(&self, before: usize) -> N {
        let length = self.commands.len();
        self.commands[(self.newest + length - before) % length]
    }
}
