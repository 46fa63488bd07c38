//! StandstillWatch and commands by blocks of M samples, which are made of shorter parts.
//!
//! With D the counts of a block, A = D − D⁻ is the servo's mean acceleration over two blocks, counts. The
//! same follows from the commands: over two blocks a command weighs as a triangle, W = ∑ w u, and
//!
//!   A = b W + M² (d − c sign v) − a M (D + D⁻)/2.

use identifier_core::number::Number;

/// Parts of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parts {
    /// Samples.
    length: i32,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct PartsState<N> {
    samples: i32,
    /// Samples running without a count.
    quiet: i32,
    part: BlockPart<N>,
}

/// Sums over a part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct BlockPart<N> {
    pub(super) counts: N,
    /// The sum of the commands, and the sum of its partial sums.
    pub(super) sum: N,
    pub(super) double_sum: N,
    /// The largest command to either side.
    pub(super) largest: N,
    /// True if the servo has turned in it.
    pub(super) turned: bool,
    /// The most samples running without a count, those of the part before included.
    pub(super) longest: i32,
}

impl Parts {
    pub(super) fn new(length: i32) -> Self {
        Self { length }
    }

    /// A sample; at the end of a part, its sums.
    #[inline]
    pub(super) fn process<N: Number>(
        &self,
        state: &mut PartsState<N>,
        increment: N,
        command: N,
    ) -> Option<BlockPart<N>> {
        let part = &mut state.part;
        part.largest = part.largest.larger(command.magnitude());
        if increment == N::ZERO {
            state.quiet = state.quiet.saturating_add(1);
            part.longest = part.longest.max(state.quiet);
        } else {
            state.quiet = 0;
            part.turned |= increment * part.counts < N::ZERO;
            part.counts += increment;
        }
        part.double_sum += part.sum + N::from_f64(0.5) * command;
        part.sum += command;
        state.samples += 1;
        if state.samples < self.length {
            return None;
        }
        state.samples = 0;
        Some(core::mem::take(&mut state.part))
    }
}

/// Blocks of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blocks<N> {
    /// Parts of a block.
    parts: i32,
    /// Samples of a part, and M.
    part: N,
    scale: N,
    /// M² and 1/M².
    area: N,
    per_area: N,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct BlocksState<N> {
    /// Parts of this block so far, and their sums: counts, the sum of the commands and the
    /// sum of its partial sums.
    parts: i32,
    counts: N,
    sum: N,
    double_sum: N,
    /// The largest command of this block and of the one before, to either side.
    largest: [N; 2],
    /// The contribution of the previous block's commands to W.
    carried: N,
    /// Counts of the block before and the one before that.
    before: [N; 2],
    /// A⁻ and W⁻.
    acceleration: N,
    weighed: N,
    /// True if the servo has turned in this block.
    turned: bool,
    /// The most samples running without a count in it.
    longest: i32,
    /// Number of blocks, and of successive blocks with motion in one direction, up to a maximum.
    blocks: i32,
    one_direction: i32,
}

/// Figures of a block that has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WatchBlock<N> {
    /// Counts of this block, the one before, and the one before that.
    pub(super) counts: [N; 3],
    /// A, counts.
    pub(super) moved: N,
    /// A, counts a sample squared.
    pub(super) acceleration: N,
    /// A − A⁻.
    pub(super) change: N,
    /// W.
    pub(super) weighed: N,
    /// W − W⁻.
    pub(super) cause: N,
    /// The largest command of the last two blocks, to either side.
    pub(super) largest: N,
    /// True if the servo has moved in one direction in all three, without a stop.
    pub(super) one_direction: bool,
    /// M/2 and M².
    pub(super) half: N,
    pub(super) area: N,
}

impl<N: Number> Blocks<N> {
    /// Blocks that A and A⁻ are made of.
    const BLOCKS: i32 = 3;
    /// A block in which the servo has moved no further than this may hold a turn, counts.
    const SLIP: i32 = 2;
    /// After a standstill within a block, the servo has moved this number of counts less than at its speed.
    const STOOD: i32 = 3;

    /// Of `parts` parts, each of `part` samples.
    pub(super) fn new(parts: i32, part: i32) -> Self {
        let samples = f64::from(parts) * f64::from(part);
        Self {
            parts,
            part: N::from_f64(f64::from(part)),
            scale: N::from_f64(samples),
            area: N::from_f64(samples * samples),
            per_area: N::from_f64(1.0 / (samples * samples)),
        }
    }

    /// A part; from the third block on, the figures of each at its end.
    #[inline]
    pub(super) fn take(
        &self,
        state: &mut BlocksState<N>,
        part: &BlockPart<N>,
    ) -> Option<WatchBlock<N>> {
        let [largest, _] = &mut state.largest;
        *largest = (*largest).larger(part.largest);
        state.turned |= part.turned || part.counts * state.counts < N::ZERO;
        state.longest = state.longest.max(part.longest);
        state.counts += part.counts;
        state.double_sum += part.double_sum + self.part * state.sum;
        state.sum += part.sum;
        state.parts += 1;
        if state.parts < self.parts {
            return None;
        }
        let block = self.end(state);
        state.blocks = (state.blocks + 1).min(Self::BLOCKS);
        (state.blocks == Self::BLOCKS).then_some(block)
    }

    fn end(&self, state: &mut BlocksState<N>) -> WatchBlock<N> {
        let [before, first] = state.before;
        let [largest, largest_before] = state.largest;
        let counts = state.counts;
        let weighed = state.carried + state.double_sum;
        let moved = counts - before;
        state.one_direction = if self.stops(state) {
            0
        } else if counts * before > N::ZERO {
            (state.one_direction + 1).min(Self::BLOCKS)
        } else {
            1
        };
        let block = WatchBlock {
            counts: [counts, before, first],
            moved,
            acceleration: moved * self.per_area,
            change: moved - state.acceleration,
            weighed,
            cause: weighed - state.weighed,
            largest: largest.larger(largest_before),
            one_direction: state.one_direction == Self::BLOCKS,
            half: N::from_f64(0.5) * self.scale,
            area: self.area,
        };
        *state = BlocksState {
            largest: [N::ZERO, largest],
            carried: self.scale * state.sum - state.double_sum,
            before: [counts, before],
            acceleration: moved,
            weighed,
            blocks: state.blocks,
            one_direction: state.one_direction,
            ..BlocksState::default()
        };
        block
    }

    /// True if the servo has reversed or stopped in the block that ends.
    fn stops(&self, state: &BlocksState<N>) -> bool {
        let [before, _] = state.before;
        let size = state.counts.magnitude();
        // At the speed of this block or the last there would have been counts.
        let missed = N::from_count(state.longest) * size.larger(before.magnitude());
        state.turned
            || size <= N::from_count(Self::SLIP)
            || missed > N::from_count(Self::STOOD) * self.scale
    }
}
