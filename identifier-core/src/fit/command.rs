use super::block::Block;
use super::record::Blocks;
use crate::number::Number;

/// A command that acts in a part of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HeldCommand<N> {
    /// From and to, parts of a block.
    from: N,
    to: N,
    /// Its mean, command units.
    pub(super) mean: N,
    /// By how much it would fall in a block.
    pub(super) falls: N,
}

impl<N: Number> HeldCommand<N> {
    /// The commands that act in the block of an index, late by a delay, blocks, zero or more. The mean command of the first
    /// has acted for ever.
    pub(super) fn late(record: &impl Blocks<N>, index: usize, delay: N) -> [Option<Self>; 4] {
        let whole = delay.whole();
        let part = delay - N::from_count(whole);
        let ago = whole.unsigned_abs() as usize;
        let before = Block {
            travel: N::ZERO,
            command: record.block(0).map_or(N::ZERO, |first| first.command),
            first_moment: N::ZERO,
        };
        let at = |ago: usize| {
            let block = index.checked_sub(ago).and_then(|place| record.block(place));
            *block.unwrap_or(&before)
        };
        let [oldest, late, early] = [at(ago + 2), at(ago + 1), at(ago)];
        let rest = N::ONE - part;
        let [first, second] = command_of(&late, &oldest);
        let [third, fourth] = command_of(&early, &late);
        [
            first.between(rest, N::ONE),
            second.between(rest, N::ONE),
            third.between(N::ZERO, rest),
            fourth.between(N::ZERO, rest),
        ]
    }

    /// For how long it acts, blocks.
    pub(super) fn time(&self) -> N {
        self.to - self.from
    }

    /// The additional distance per unit of gain because it falls, over the square of the time, command units.
    pub(super) fn first_moment(&self) -> N {
        N::from_f64(1.0 / 12.0) * self.falls * self.time()
    }

    /// When it begins, and when it ends.
    pub(super) fn ends(&self) -> [N; 2] {
        let half = N::from_f64(0.5) * self.falls * self.time();
        [self.mean + half, self.mean - half]
    }

    /// The part that acts between two times. None if it ends before or begins after them.
    fn between(&self, from: N, to: N) -> Option<Self> {
        let begins = from.larger(self.from);
        let ends = to.smaller(self.to);
        let half = N::from_f64(0.5);
        let later = half * (begins + ends - self.from - self.to);
        (begins <= ends).then(|| Self {
            from: begins,
            to: ends,
            mean: self.mean - self.falls * later,
            falls: self.falls,
        })
    }
}

/// The command of a block that follows another. It is one step from the last command of the other, if mean and first
/// moment are those of such a step. Else it falls evenly.
fn command_of<N: Number>(block: &Block<N>, before: &Block<N>) -> [HeldCommand<N>; 2] {
    /// A step nearer to the beginning or the end of a block is none.
    const NEAR: f64 = 0.02;
    let [six, twelve] = [6.0, 12.0].map(N::from_f64);
    let last = before.command - six * before.first_moment;
    let change = block.command - last;
    let (zero, one, near) = (N::ZERO, N::ONE, N::from_f64(NEAR));
    let at = if change == zero {
        zero
    } else {
        -(block.first_moment + block.first_moment) * change.reciprocal()
    };
    let held = |from, to, mean, falls| HeldCommand {
        from,
        to,
        mean,
        falls,
    };
    if at > near && at < one - near {
        let next = last + change * (one - at).reciprocal();
        [held(zero, at, last, zero), held(at, one, next, zero)]
    } else {
        let even = held(zero, one, block.command, twelve * block.first_moment);
        [held(zero, zero, even.ends()[0], zero), even]
    }
}

/// The mean and the first moment of successive commands in a block. The first moment is the additional distance per
/// unit of gain because they came earlier than evenly spread.
pub(super) fn moments<N: Number>(commands: &[Option<HeldCommand<N>>; 4]) -> [N; 2] {
    let half = N::from_f64(0.5);
    let (mut time, mut mean, mut displacement) = (N::ZERO, N::ZERO, N::ZERO);
    for held in commands.iter().flatten() {
        let own = held.time();
        displacement += own * (mean + own * (half * held.mean + held.first_moment()));
        mean += own * held.mean;
        time += own;
    }
    [mean, displacement - half * mean]
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::{HeldCommand, moments};
    use crate::fit::{Block, Blocking, Blocks, Recorder};

    impl Blocks<f64> for Vec<Block<f64>> {
        fn block(&self, index: usize) -> Option<&Block<f64>> {
            self.get(index)
        }
    }

    /// Blocks of eight samples of a command.
    fn recorded(command: impl Fn(usize) -> f64) -> Vec<Block<f64>> {
        let (blocking, mut recorder) = (Blocking::new(8), Recorder::default());
        let blocks = (0..=80).filter_map(|k| {
            recorder.push(&blocking, 0.0, command(k));
            Some(recorder.take()?.block)
        });
        blocks.collect()
    }

    /// A mass under the commands of the blocks, late by a delay: position and velocity.
    fn pushed(record: &Vec<Block<f64>>, delay: f64) -> [f64; 2] {
        (0..record.len()).fold([0.0; 2], |[position, velocity], index| {
            let [mean, first_moment] = moments(&HeldCommand::late(record, index, delay));
            let moved = velocity + 0.5 * mean + first_moment;
            [position + moved, velocity + mean]
        })
    }

    #[test]
    fn a_step_is_late_by_any_part_of_a_block() {
        for at in [21, 24, 27, 30] {
            let record = recorded(|k| if k < at { 1.0 } else { -3.0 });
            for delay in [0.0, 0.125, 0.5, 0.9, 1.0, 2.3] {
                let step = at as f64 / 8.0 + delay;
                let mut acted = Vec::new();
                for index in 0..record.len() {
                    let mut begins = index as f64;
                    for held in HeldCommand::late(&record, index, delay).iter().flatten() {
                        if held.time() > 1e-9 {
                            acted.push((begins, held.mean));
                        }
                        begins += held.time();
                    }
                }
                let changed = acted.into_iter().find(|(_, mean)| *mean < 0.0);
                let (first, mean) = changed.expect("a step");
                let off = (first - step).abs().max((mean + 3.0_f64).abs());
                assert!(off < 1e-9, "{at} {delay}: {first} {mean}");
            }
        }
    }

    #[test]
    fn a_mass_goes_as_under_the_late_command_of_the_samples() {
        let command = |k: usize| match k {
            8..=60 => ((k * 7919) % 13) as f64 - 6.0,
            _ => 0.0,
        };
        let record = recorded(command);
        for samples in [0_usize, 8, 16] {
            let late = |k: usize| k.checked_sub(samples).map_or(0.0, command);
            let exact = pushed(&recorded(late), 0.0);
            let own = pushed(&record, samples as f64 / 8.0);
            assert!((own[0] - exact[0]).abs() < 1e-9 && (own[1] - exact[1]).abs() < 1e-9);
        }
        // Late by a part of a block the velocity is the same in the end, and the way shorter by what the delay costs.
        let [displacement, velocity] = pushed(&record, 0.0);
        let [late_displacement, late_velocity] = pushed(&record, 0.375);
        assert!((late_velocity - velocity).abs() < 1e-9);
        let off = displacement - late_displacement - 0.375 * velocity;
        assert!(off.abs() < 1e-9, "{off}");
    }
}
