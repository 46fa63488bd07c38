//! Whether the motion is what the command makes.
//!
//! Time is cut into blocks of M samples. With D the counts of a block, A = D − D⁻ is the servo's mean
//! acceleration over two blocks. The same follows from the commands: over two blocks a command weighs as
//! a triangle, W = ∑ w u, and
//!
//!   A = b W + M² (d − c sign v) − a M (D + D⁻)/2.
//!
//! Two questions are put to each block in which the servo moves one way.
//!
//! *The change.* A − A⁻ is free of load and friction, and b (W − W⁻), less the viscous brake, is what it
//! must be. The ratio of the two is the share of the command that acts: one for a sound servo, less for a
//! weak actuator, zero for a dead one, below zero for a reversed one. A step of the load spoils three
//! blocks and no more; so one is no evidence, and five are. This is sharp wherever the command changes.
//!
//! *The level.* A itself, even with a step of the load in the command's favour, must be a good part of
//! b W. This is for large commands that do not change: those of a loop that runs away.
//!
//! Of a servo that is not known, b > 0 alone is: its motion must not change against the command's change,
//! and it must not gain speed against a command that no load explains.

use super::model::{MODEL_ERROR, Model};
use crate::commission::StopReason;
use crate::number::Number;

/// The comparison over blocks of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response<N> {
    /// Samples of a block, M.
    length: i32,
    scale: N,
    /// M² and 1/M².
    area: N,
    per_sample: N,
    /// The change of W that tells something, and the W that no load explains.
    least: N,
    strong: N,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponseState<N> {
    samples: i32,
    /// Of this block: counts, the sum of the commands and the sum of its partial sums.
    counts: N,
    sum: N,
    double_sum: N,
    /// The largest command of this block and of the one before, to either side.
    largest: [N; 2],
    /// Of the block before: what its commands add to the next.
    carried: N,
    /// Counts of the block before and the one before that.
    before: [N; 2],
    /// A⁻ and the commands' part of it.
    acceleration: N,
    weighed: N,
    /// Whether the servo has turned in this block.
    turned: bool,
    /// Samples running without a count, and the most of them in this block.
    quiet: i32,
    longest: i32,
    /// Blocks so far, and those running in which it moved one way, as long as they are few.
    blocks: i32,
    one_way: i32,
    /// The change: blocks of evidence, those of them against the command, and sums over them in counts
    /// squared, of the measured change by the command's and of the latter by itself.
    evidence: i32,
    against: i32,
    product: N,
    square: N,
    /// Blocks running that were no evidence.
    idle: i32,
    /// The level: running blocks against the command.
    level: i32,
}

/// What is known of the servo's response, in the number format of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known<N> {
    gain: N,
    x: N,
    coulomb: N,
    load: N,
    /// What speaks for the command whatever the motion: a step of the load, and the model's error.
    favour: N,
}

/// What a block has shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block<N> {
    /// The mean acceleration, counts a sample squared.
    pub(super) acceleration: N,
    /// The counts of this block and of the one before the last.
    pub(super) counts: [N; 2],
    /// The largest command in it and in the block before, to either side.
    pub(super) command: N,
    /// M².
    pub(super) area: N,
}

impl<N: Number> Known<N> {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            gain: N::from_f64(model.gain),
            x: N::from_f64(model.x),
            coulomb: N::from_f64(model.coulomb),
            load: N::from_f64(model.load),
            favour: N::from_f64(
                MODEL_ERROR * model.load_step + (MODEL_ERROR - 1.0) * model.coulomb,
            ),
        }
    }
}

impl<N: Number> Response<N> {
    /// Blocks against the command that are a fault, and those at their beginning that do not tell which.
    const ENOUGH: i32 = 5;
    const UNCLEAR: i32 = 2;
    /// The same for a relay, with which nobody steps the load, and for the level.
    const FEW: i32 = 3;
    /// Blocks within which a fault is found, if each is telling.
    pub(super) const BLOCKS: i32 = Self::ENOUGH + 3;
    /// Blocks without evidence after which older evidence is forgotten.
    const IDLE: i32 = 16;
    /// A block is evidence if its command changes the motion by so many counts,
    const FAINT: i32 = 6;
    /// and it speaks for the command on its own from so many on.
    pub(super) const TELLING: i32 = 14;
    /// Evidence, counts squared: the encoder's rounding makes up 1.3 counts of a block's change, so the
    /// share is known to 0.04.
    const EVIDENCE: i32 = 1000;
    /// The same of a servo that is not known: by so many counts its motion must have changed.
    const VISIBLE: i32 = 8;
    /// A block in which the servo has moved no further than this may hold a turn, counts.
    const SLIP: i32 = 2;
    /// A servo at standstill has passed so many counts fewer than its mean speed would have it.
    const STOOD: i32 = 3;
    /// A command that acts by a smaller share contradicts.
    const WEAK: f64 = 0.65;
    /// A dead actuator's share, at most, and a reversed one's.
    const DEAD: f64 = 0.2;
    const REVERSED: f64 = -0.4;
    /// One block weighs no more than so many times what its command explains.
    const CREDIT: f64 = 2.5;

    /// Over blocks of so many samples, for commands up to a limit.
    pub(super) fn new(length: i32, limit: f64) -> Self {
        /// The change of the command that tells something, as a share of the limit: of a smaller one what is
        /// not known of delay and friction makes up too much.
        const LEAST: f64 = 0.05;
        /// The command that neither a load nor a step of it explains: either is 30 %.
        const STRONG: f64 = 0.7;
        let samples = f64::from(length);
        let area = samples * samples;
        Self {
            length,
            scale: N::from_f64(samples),
            area: N::from_f64(area),
            per_sample: N::from_f64(1.0 / area),
            least: N::from_f64(LEAST * limit * area),
            strong: N::from_f64(STRONG * limit * area),
        }
    }

    pub(super) fn length(&self) -> i32 {
        self.length
    }

    /// Nothing has been seen yet.
    pub(super) fn start(&self) -> ResponseState<N> {
        let zero = N::ZERO;
        ResponseState {
            samples: 0,
            counts: zero,
            sum: zero,
            double_sum: zero,
            largest: [zero; 2],
            carried: zero,
            before: [zero; 2],
            acceleration: zero,
            weighed: zero,
            turned: false,
            quiet: 0,
            longest: 0,
            blocks: 0,
            one_way: 0,
            evidence: 0,
            against: 0,
            idle: 0,
            product: zero,
            square: zero,
            level: 0,
        }
    }

    /// `relay` says that a relay gives the command. Returns what a block that has ended has shown.
    #[inline]
    pub(super) fn process(
        &self,
        state: &mut ResponseState<N>,
        increment: N,
        command: N,
        known: Option<&Known<N>>,
        relay: bool,
    ) -> Result<Option<Block<N>>, StopReason> {
        let [largest, _] = &mut state.largest;
        if command.magnitude() > *largest {
            *largest = command.magnitude();
        }
        state.turned |= increment * state.counts < N::ZERO;
        state.quiet = if increment == N::ZERO {
            state.quiet + 1
        } else {
            0
        };
        state.longest = state.longest.max(state.quiet);
        state.counts += increment;
        state.double_sum += state.sum + N::from_f64(0.5) * command;
        state.sum += command;
        state.samples += 1;
        if state.samples < self.length {
            return Ok(None);
        }
        self.end_block(state, known, relay)
    }

    fn end_block(
        &self,
        state: &mut ResponseState<N>,
        known: Option<&Known<N>>,
        relay: bool,
    ) -> Result<Option<Block<N>>, StopReason> {
        /// Blocks that A and A⁻ are made of.
        const PART: i32 = 3;
        let [before, first] = state.before;
        let weighed = state.carried + state.double_sum;
        let acceleration = state.counts - before;
        let change = acceleration - state.acceleration;
        let cause = weighed - state.weighed;
        let half = N::from_f64(0.5) * self.scale;
        let counts = state.counts;

        let [largest, largest_before] = state.largest;
        let command = larger(largest, largest_before);
        state.largest = [N::ZERO, largest];
        state.carried = self.scale * state.sum - state.double_sum;
        state.before = [state.counts, before];
        (state.acceleration, state.weighed) = (acceleration, weighed);
        (state.counts, state.sum, state.double_sum) = (N::ZERO, N::ZERO, N::ZERO);
        state.samples = 0;
        // It stood within the block if at the speed of this one or the last there would have been counts.
        let size = larger(counts.magnitude(), before.magnitude());
        let stood = N::from_count(state.longest) * size > N::from_count(Self::STOOD) * self.scale;
        let rests = counts.magnitude() <= N::from_count(Self::SLIP);
        state.one_way = if state.turned || stood || rests {
            0
        } else if counts * before > N::ZERO {
            (state.one_way + 1).min(PART)
        } else {
            1
        };
        state.turned = false;
        (state.quiet, state.longest) = (0, 0);
        state.blocks = (state.blocks + 1).min(PART);
        if state.blocks < PART {
            return Ok(None);
        }
        let one_way = state.one_way >= PART;
        let enough = if relay { Self::FEW } else { Self::ENOUGH };
        match known {
            _ if !one_way => {}
            Some(known) => {
                let slowed = known.x * half * (counts - first);
                let least = known.gain * self.least;
                state.compare(change + slowed, known.gain * cause, least, enough)?;
                let braked = known.x * half * (counts + before)
                    + self.area * (known.coulomb * sign_of(counts) - known.load);
                let favour = self.area * known.favour;
                state.compare_level(acceleration + braked, known.gain * weighed, favour)?;
            }
            None => {
                state.compare_signs(change, cause, self.least)?;
                let gains = acceleration * sign_of(counts);
                let against = -(weighed * sign_of(counts));
                state.compare_level_signs(gains, against, self.strong)?;
            }
        }
        Ok(Some(Block {
            acceleration: acceleration * self.per_sample,
            counts: [counts, first],
            command,
            area: self.area,
        }))
    }
}

impl<N: Number> ResponseState<N> {
    /// The change that was measured with that which the command must make, counts.
    fn compare(&mut self, change: N, cause: N, least: N, enough: i32) -> Result<(), StopReason> {
        let size = cause.magnitude();
        if size < N::from_count(Response::<N>::FAINT) || size < least {
            self.idle += 1;
            if self.idle >= Response::<N>::IDLE {
                self.acquit();
            }
            return Ok(());
        }
        self.idle = 0;
        let credit = N::from_f64(Response::<N>::CREDIT) * size;
        let product = change.limited(-credit, credit) * cause;
        let square = cause * cause;
        self.evidence += 1;
        if product >= N::from_f64(Response::<N>::WEAK) * square {
            let most = 4 * self.against >= 3 * self.evidence;
            if size >= N::from_count(Response::<N>::TELLING) || !most {
                self.acquit();
            }
            return Ok(());
        }
        self.against += 1;
        if self.against > Response::<N>::UNCLEAR || enough <= Response::<N>::FEW {
            self.product += product;
            self.square += square;
        }
        let weighty = self.square >= N::from_count(Response::<N>::EVIDENCE);
        if self.against < enough || !weighty {
            return Ok(());
        }
        let share = |share: f64| N::from_f64(share) * self.square;
        Err(if self.product < share(Response::<N>::REVERSED) {
            StopReason::Reversed
        } else if self.product < share(Response::<N>::DEAD) {
            StopReason::ActuatorDead
        } else {
            StopReason::ActuatorWeak
        })
    }

    /// The same for a servo that is not known: only the sign is.
    fn compare_signs(&mut self, change: N, cause: N, least: N) -> Result<(), StopReason> {
        let visible = N::from_count(Response::<N>::VISIBLE);
        if cause.magnitude() < least || change.magnitude() < visible {
            return Ok(());
        }
        if change * cause > N::ZERO {
            self.acquit();
            return Ok(());
        }
        self.against += 1;
        if self.against < Response::<N>::ENOUGH {
            return Ok(());
        }
        Err(StopReason::Reversed)
    }

    /// What acts of a command by the motion, and what should, counts; a step of the load in its favour.
    fn compare_level(&mut self, acts: N, force: N, favour: N) -> Result<(), StopReason> {
        let size = force.magnitude();
        let along = acts * sign_of(force);
        let contradicts = size >= N::from_count(Response::<N>::TELLING)
            && along + favour < N::from_f64(Response::<N>::WEAK) * size;
        self.level = if contradicts { self.level + 1 } else { 0 };
        if self.level < Response::<N>::FEW {
            return Ok(());
        }
        let share = |share: f64| N::from_f64(share) * size;
        Err(if along < share(Response::<N>::REVERSED) {
            StopReason::Reversed
        } else {
            StopReason::ActuatorDead
        })
    }

    /// The same for a servo that is not known: `gains` is what it gains of speed, and `against` the command
    /// against its motion.
    fn compare_level_signs(&mut self, gains: N, against: N, strong: N) -> Result<(), StopReason> {
        let contradicts = against >= strong && gains >= N::from_count(Response::<N>::VISIBLE);
        self.level = if contradicts { self.level + 1 } else { 0 };
        if self.level < Response::<N>::FEW {
            return Ok(());
        }
        Err(StopReason::Reversed)
    }

    fn acquit(&mut self) {
        self.evidence = 0;
        self.against = 0;
        self.idle = 0;
        self.product = N::ZERO;
        self.square = N::ZERO;
    }
}

fn larger<N: Number>(one: N, other: N) -> N {
    if one > other { one } else { other }
}

/// ±1.
fn sign_of<N: Number>(value: N) -> N {
    if value < N::ZERO { -N::ONE } else { N::ONE }
}
