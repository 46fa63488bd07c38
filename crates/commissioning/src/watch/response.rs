//! Comparison of the motion with the command's effect.
//!
//! Two tests apply to each [`WatchBlock`] with motion in one direction.
//!
//! *The change.* A − A⁻ is free of load and friction, and b (W − W⁻), less the viscous brake, is what it must be. The
//! ratio of the two is the share of the command that acts. It is one without a fault, less with a weak actuator, zero
//! with a dead one, negative with a reversed one. A load step disturbs at most three blocks. So five blocks are
//! evidence, and one is not. This test is precise whenever the command changes.
//!
//! *The level.* A itself, even with a load step in the direction of the command, must be a large part of b W. This
//! test is for large constant commands: those of a loop that runs away.
//!
//! For an unknown servo only b > 0 is assumed. Its acceleration must not change against the command's change. It must
//! not accelerate against a command that no load explains.
//!
//! A loop that runs away may leave its limits before that is certain. The level of the last block alone
//! then names the reason.

use super::blocks::BlockPart;
use super::blocks::{Blocks, BlocksState, WatchBlock};
use super::model::{MODEL_ERROR, Model};
use identifier_core::number::Number;
use identifier_core::reason::Reason;

/// The comparison over blocks of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ResponseCheck<N> {
    blocks: Blocks<N>,
    /// The change of W that is informative, and the W that no load explains.
    least: N,
    strong: N,
    /// The W that no load explains which was there before.
    held: N,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ResponseCheckState<N> {
    blocks: BlocksState<N>,
    /// The change: blocks of evidence, and those of them against the command. Then sums over them, counts squared:
    /// measured change times the command's, and the latter squared.
    evidence: i32,
    against: i32,
    product: N,
    square: N,
    /// Blocks running that were no evidence.
    idle: i32,
    /// The level: running blocks against the command, and what the last of all speaks for.
    level: i32,
    detected_fault: Option<Reason>,
}

/// The known response of the servo, in the number format of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known<N> {
    gain: N,
    x: N,
    coulomb: N,
    load: N,
    /// Allowance in favour of the command: a step of the load, and the model's error.
    favour: N,
}

impl<N: Number> Known<N> {
    /// The same with a load that this command balances.
    pub(super) fn with_holding_of(self, command: N) -> Self {
        Self {
            load: -(self.gain * command),
            ..self
        }
    }

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

impl<N: Number> ResponseCheck<N> {
    /// Blocks against the command that are a fault, and those at their beginning that do not show which.
    const BLOCKS_OF_FAULT: i32 = 5;
    const UNCLEAR_BLOCKS: i32 = 2;
    /// The same for a relay, during which no load steps, and for the level.
    const BLOCKS_OF_FAULT_UNDER_RELAY: i32 = 3;
    /// Blocks within which a fault is found, if each is informative.
    #[cfg(test)]
    pub(super) const BLOCKS: i32 = Self::BLOCKS_OF_FAULT + 3;
    /// Blocks without evidence after which older evidence is forgotten.
    const MAX_IDLE_BLOCKS: i32 = 16;
    /// A block is evidence if its command changes the motion by this many counts,
    const MIN_EFFECT: i32 = 6;
    /// and it speaks for the command on its own from this many on.
    pub(super) const CERTAIN_EFFECT: i32 = 14;
    /// Evidence, counts squared. Quantisation contributes 1.3 counts to a block's change, so the share has an error
    /// of 0.04.
    const MIN_EVIDENCE: i32 = 1000;
    /// The same for an unknown servo: minimum change of its motion, counts.
    const MIN_CHANGE: i32 = 8;
    /// A command that acts by a smaller share contradicts.
    const MIN_SHARE: f64 = 0.65;
    /// A dead actuator's share, at most, and a reversed one's.
    const MAX_DEAD_SHARE: f64 = 0.2;
    const MAX_REVERSED_SHARE: f64 = -0.4;
    /// The share of the limit of a command that a load does not explain, if it does not step.
    pub(super) const BEYOND_LOAD: f64 = 0.35;
    /// One block weighs no more than this many times what its command explains.
    const MAX_WEIGHT: f64 = 2.5;

    /// Over blocks of `parts` parts of `part` samples each, for commands up to a limit.
    pub(super) fn new(parts: i32, part: i32, limit: f64) -> Self {
        /// The smallest informative change of the command, as a share of the limit. Below it the errors of delay and
        /// friction are too large a part.
        const MIN_COMMAND_CHANGE: f64 = 0.05;
        // The command that neither a load nor a step of it explains.
        let beyond_step = 2.0 * Self::BEYOND_LOAD;
        let length = f64::from(parts) * f64::from(part);
        let area = length * length;
        Self {
            blocks: Blocks::new(parts, part),
            least: N::from_f64(MIN_COMMAND_CHANGE * limit * area),
            strong: N::from_f64(beyond_step * limit * area),
            held: N::from_f64(Self::BEYOND_LOAD * limit * area),
        }
    }

    /// `relay` says that a relay gives the command. Returns a block that has ended.
    pub(super) fn take(
        &self,
        state: &mut ResponseCheckState<N>,
        part: &BlockPart<N>,
        known: Option<&Known<N>>,
        relay: bool,
    ) -> Result<Option<WatchBlock<N>>, Reason> {
        let Some(block) = self.blocks.take(&mut state.blocks, part) else {
            return Ok(None);
        };
        match known {
            Some(known) => self.judge(state, &block, known, relay)?,
            None => self.judge_signs(state, &block)?,
        }
        Ok(Some(block))
    }

    fn judge(
        &self,
        state: &mut ResponseCheckState<N>,
        block: &WatchBlock<N>,
        known: &Known<N>,
        relay: bool,
    ) -> Result<(), Reason> {
        let [counts, before, first] = block.counts;
        let viscous = known.x * block.half;
        let braked = viscous * (counts + before)
            + block.area * (known.coulomb * sign_of(counts) - known.load);
        let favour = block.area * known.favour;
        let acts = block.moved + braked;
        let force = known.gain * block.weighed;
        let contradiction = contradiction(acts, force, favour);
        let faint = N::from_count(Self::MIN_EFFECT);
        let by_level = contradiction.filter(|_| force.magnitude() >= faint);
        state.detected_fault = by_level.or(self.gains_against(block, self.strong));
        if !block.one_direction {
            return Ok(());
        }
        let enough = if relay {
            Self::BLOCKS_OF_FAULT_UNDER_RELAY
        } else {
            Self::BLOCKS_OF_FAULT
        };
        let change = block.change + viscous * (counts - first);
        let (cause, least) = (known.gain * block.cause, known.gain * self.least);
        let reversed = N::from_f64(Self::MAX_REVERSED_SHARE) * cause.magnitude();
        let is_against = change * sign_of(cause) < reversed;
        if is_against && cause.magnitude() >= faint.larger(least) {
            state.detected_fault = Some(Reason::Reversed);
        }
        state.compare(change, cause, least, enough)?;
        let telling = N::from_count(Self::CERTAIN_EFFECT);
        state.count_level(contradiction.filter(|_| force.magnitude() >= telling))
    }

    /// True if the servo gains speed against a command.
    fn gains_against(&self, block: &WatchBlock<N>, least: N) -> Option<Reason> {
        let [counts, ..] = block.counts;
        let direction = sign_of(counts);
        let gains = block.moved * direction >= N::from_count(Self::MIN_CHANGE);
        let against = -(block.weighed * direction) >= least;
        (gains && against).then_some(Reason::Reversed)
    }

    fn judge_signs(
        &self,
        state: &mut ResponseCheckState<N>,
        block: &WatchBlock<N>,
    ) -> Result<(), Reason> {
        state.detected_fault = self.gains_against(block, self.held);
        if !block.one_direction {
            return Ok(());
        }
        state.compare_signs(block.change, block.cause, self.least)?;
        if state.against > 0 {
            state.detected_fault = Some(Reason::Reversed);
        }
        state.count_level(self.gains_against(block, self.strong))
    }
}

impl<N: Number> ResponseCheckState<N> {
    /// The change that was measured with that which the command must make, counts.
    fn compare(&mut self, change: N, cause: N, least: N, enough: i32) -> Result<(), Reason> {
        let size = cause.magnitude();
        if size < N::from_count(ResponseCheck::<N>::MIN_EFFECT) || size < least {
            self.idle += 1;
            if self.idle >= ResponseCheck::<N>::MAX_IDLE_BLOCKS {
                self.reset_evidence();
            }
            return Ok(());
        }
        self.idle = 0;
        let credit = N::from_f64(ResponseCheck::<N>::MAX_WEIGHT) * size;
        let product = change.limited(-credit, credit) * cause;
        let square = cause * cause;
        self.evidence += 1;
        if product >= N::from_f64(ResponseCheck::<N>::MIN_SHARE) * square {
            let most = 4 * self.against >= 3 * self.evidence;
            if size >= N::from_count(ResponseCheck::<N>::CERTAIN_EFFECT) || !most {
                self.reset_evidence();
            }
            return Ok(());
        }
        self.against += 1;
        if self.against > ResponseCheck::<N>::UNCLEAR_BLOCKS
            || enough <= ResponseCheck::<N>::BLOCKS_OF_FAULT_UNDER_RELAY
        {
            self.product += product;
            self.square += square;
        }
        let weighty = self.square >= N::from_count(ResponseCheck::<N>::MIN_EVIDENCE);
        if self.against < enough || !weighty {
            return Ok(());
        }
        let share = |share: f64| N::from_f64(share) * self.square;
        Err(
            if self.product < share(ResponseCheck::<N>::MAX_REVERSED_SHARE) {
                Reason::Reversed
            } else if self.product < share(ResponseCheck::<N>::MAX_DEAD_SHARE) {
                Reason::ActuatorDead
            } else {
                Reason::ActuatorWeak
            },
        )
    }

    /// The same for an unknown servo, of which only the sign of b is assumed.
    fn compare_signs(&mut self, change: N, cause: N, least: N) -> Result<(), Reason> {
        let visible = N::from_count(ResponseCheck::<N>::MIN_CHANGE);
        if cause.magnitude() < least || change.magnitude() < visible {
            return Ok(());
        }
        if change * cause > N::ZERO {
            self.reset_evidence();
            return Ok(());
        }
        self.against += 1;
        if self.against < ResponseCheck::<N>::BLOCKS_OF_FAULT {
            return Ok(());
        }
        Err(Reason::Reversed)
    }

    /// Takes in what the level of a block speaks for.
    fn count_level(&mut self, contradiction: Option<Reason>) -> Result<(), Reason> {
        let Some(reason) = contradiction else {
            self.level = 0;
            return Ok(());
        };
        self.level += 1;
        if self.level < ResponseCheck::<N>::BLOCKS_OF_FAULT_UNDER_RELAY {
            return Ok(());
        }
        Err(reason)
    }

    /// The uncertain indication of the last block.
    pub(super) fn detected_fault(&self) -> Option<Reason> {
        self.detected_fault
    }

    fn reset_evidence(&mut self) {
        self.evidence = 0;
        self.against = 0;
        self.idle = 0;
        self.product = N::ZERO;
        self.square = N::ZERO;
    }
}

/// Compares the effect of a command in the motion with the expected one, counts, with a load step in its favour.
/// Returns the fault if they contradict each other.
fn contradiction<N: Number>(acts: N, force: N, favour: N) -> Option<Reason> {
    let size = force.magnitude();
    let along = acts * sign_of(force);
    let share = |share: f64| N::from_f64(share) * size;
    (along + favour < share(ResponseCheck::<N>::MIN_SHARE)).then(|| {
        if along < share(ResponseCheck::<N>::MAX_REVERSED_SHARE) {
            Reason::Reversed
        } else {
            Reason::ActuatorDead
        }
    })
}

/// ±1.
fn sign_of<N: Number>(value: N) -> N {
    if value < N::ZERO { -N::ONE } else { N::ONE }
}
