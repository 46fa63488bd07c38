//! Whether the motion changes as the command does.
//!
//! Time is cut into blocks of M samples. With D the counts of a block, A = D − D⁻ is the servo's mean
//! acceleration over two blocks, and A − A⁻ its change, free of load and, while the servo does not turn,
//! of Coulomb friction. The same change follows from the commands: over two blocks a command weighs as
//! a triangle, and b times the change of that sum, less the viscous brake, is what A − A⁻ must be. The
//! ratio of the two is the share of the command that acts: one for a sound servo, less for a weak
//! actuator, zero for a dead one, below zero for a reversed one. A step of the load changes three blocks
//! and no more; so one block is no evidence, and five running are.

use super::model::Model;
use crate::commission::StopReason;
use crate::number::Number;

/// The comparison over blocks of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response<N> {
    /// Samples of a block, M.
    length: i32,
    scale: N,
    /// 1/M².
    per_sample: N,
    /// The change of the commands' weighed sum that tells something of a servo that is not known.
    least: N,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponseState<N> {
    samples: i32,
    /// Of this block: counts, the sum of the commands and the sum of its partial sums.
    counts: N,
    sum: N,
    double_sum: N,
    /// Of the block before: what its commands add to the next.
    carried: N,
    /// Counts of the block before and the one before that.
    before: [N; 2],
    /// A⁻ and the commands' part of it.
    acceleration: N,
    weighed: N,
    /// Blocks so far, as long as there are too few.
    blocks: i32,
    /// Running blocks that contradict the command.
    contradictions: i32,
    /// Sums over the last of them, counts squared: measured change by that of the command, and the
    /// latter by itself.
    product: N,
    square: N,
}

/// What is known of the servo's response, in the number format of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known<N> {
    gain: N,
    x: N,
}

impl<N: Number> Known<N> {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            gain: N::from_f64(model.gain),
            x: N::from_f64(model.x),
        }
    }
}

impl<N: Number> Response<N> {
    /// Running contradictions that are a fault, and those at its beginning that do not tell which.
    const ENOUGH: i32 = 5;
    const UNCLEAR: i32 = 2;
    /// Blocks within which a fault is found, if each is telling.
    pub(super) const BLOCKS: i32 = Self::ENOUGH + 3;
    /// A block is telling if its command changes the motion by so many counts.
    pub(super) const TELLING: i32 = 20;
    /// The same of a servo that is not known: by so many counts its motion must have changed.
    const VISIBLE: i32 = 8;
    /// A block in which the servo has moved no further than this may hold a turn, counts.
    const SLIP: i32 = 2;
    /// A command that acts by a smaller share contradicts.
    const WEAK: f64 = 0.65;
    /// A dead actuator's share, at most, and a reversed one's.
    const DEAD: f64 = 0.2;
    const REVERSED: f64 = -0.4;
    /// One block weighs no more than so many times what its command explains.
    const CREDIT: f64 = 2.5;

    /// Over blocks of so many samples; `least` is the change of the command, command units, that tells
    /// something of a servo that is not known.
    pub(super) fn new(length: i32, least: f64) -> Self {
        let samples = f64::from(length);
        Self {
            length,
            scale: N::from_f64(samples),
            per_sample: N::from_f64(1.0 / (samples * samples)),
            least: N::from_f64(least * samples * samples),
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
            carried: zero,
            before: [zero; 2],
            acceleration: zero,
            weighed: zero,
            blocks: 0,
            contradictions: 0,
            product: zero,
            square: zero,
        }
    }

    /// Returns the mean acceleration where a block has ended, counts a sample squared.
    #[inline]
    pub(super) fn process(
        &self,
        state: &mut ResponseState<N>,
        increment: N,
        command: N,
        known: Option<&Known<N>>,
    ) -> Result<Option<N>, StopReason> {
        state.counts += increment;
        state.double_sum += state.sum + N::from_f64(0.5) * command;
        state.sum += command;
        state.samples += 1;
        if state.samples < self.length {
            return Ok(None);
        }
        self.end_block(state, known)
    }

    fn end_block(
        &self,
        state: &mut ResponseState<N>,
        known: Option<&Known<N>>,
    ) -> Result<Option<N>, StopReason> {
        /// Blocks until A and A⁻ are both there.
        const FIRST: i32 = 3;
        let [before, first] = state.before;
        let weighed = state.carried + state.double_sum;
        let acceleration = state.counts - before;
        let change = acceleration - state.acceleration;
        let cause = weighed - state.weighed;
        let slowed = N::from_f64(0.5) * self.scale * (state.counts - first);
        let one_way = Self::one_way([state.counts, before, first]);

        state.carried = self.scale * state.sum - state.double_sum;
        state.before = [state.counts, before];
        (state.acceleration, state.weighed) = (acceleration, weighed);
        (state.counts, state.sum, state.double_sum) = (N::ZERO, N::ZERO, N::ZERO);
        state.samples = 0;
        if state.blocks < FIRST {
            state.blocks += 1;
            return Ok(None);
        }
        if one_way {
            match known {
                Some(known) => state.compare(change + known.x * slowed, known.gain * cause)?,
                None => state.compare_signs(change, cause, self.least)?,
            }
        }
        Ok(Some(acceleration * self.per_sample))
    }

    /// Whether the servo moved one way in all of these blocks.
    fn one_way(counts: [N; 3]) -> bool {
        let slip = N::from_count(Self::SLIP);
        counts.iter().all(|&counts| counts > slip) || counts.iter().all(|&counts| counts < -slip)
    }
}

impl<N: Number> ResponseState<N> {
    /// The change that was measured with that which the command must make, counts.
    fn compare(&mut self, change: N, cause: N) -> Result<(), StopReason> {
        if cause.magnitude() < N::from_count(Response::<N>::TELLING) {
            return Ok(());
        }
        let credit = N::from_f64(Response::<N>::CREDIT) * cause.magnitude();
        let product = change.limited(-credit, credit) * cause;
        let square = cause * cause;
        if product >= N::from_f64(Response::<N>::WEAK) * square {
            self.acquit();
            return Ok(());
        }
        self.contradictions += 1;
        if self.contradictions > Response::<N>::UNCLEAR {
            self.product += product;
            self.square += square;
        }
        if self.contradictions < Response::<N>::ENOUGH {
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
        let telling = cause.magnitude() >= least
            && change.magnitude() >= N::from_count(Response::<N>::VISIBLE);
        if !telling {
            return Ok(());
        }
        if change * cause > N::ZERO {
            self.acquit();
            return Ok(());
        }
        self.contradictions += 1;
        if self.contradictions < Response::<N>::ENOUGH {
            return Ok(());
        }
        Err(StopReason::Reversed)
    }

    fn acquit(&mut self) {
        self.contradictions = 0;
        self.product = N::ZERO;
        self.square = N::ZERO;
    }
}
