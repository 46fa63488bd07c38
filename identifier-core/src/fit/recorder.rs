use super::block::{Block, Blocking, NumberedBlock};
use crate::number::Number;

/// Condenses samples to blocks: the interrupt's share of a record. A sample costs a few additions, the
/// last of a block a few multiplications. The default has no sample yet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Recorder<N> {
    open: Open<N>,
    /// The last block, until it is taken or the next takes its place.
    complete: Option<NumberedBlock<N>>,
    /// Velocity over the last block, counts per sample.
    velocity: N,
    /// The number of the next block.
    next: u32,
    /// The number with which recording last began.
    first: u32,
}

/// The block that is being gathered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Open<N> {
    travel: N,
    sum: N,
    weighted: N,
    samples: u32,
    /// The command that acts now; its effect comes with the next increment.
    acting: Option<N>,
}

impl<N: Number> Recorder<N> {
    /// Begins anew if samples are missing: a number is left out.
    pub fn begin_anew(&mut self) {
        let first = self.next.wrapping_add(1);
        *self = Self {
            next: first,
            first,
            ..Self::default()
        };
    }

    /// Takes a sample: the increment, counts, of the sample that ends, and the command from now on, command units.
    #[inline]
    pub fn push(&mut self, blocking: &Blocking<N>, increment: N, command: N) {
        let open = &mut self.open;
        let Some(acted) = open.acting.replace(command) else {
            return;
        };
        open.travel += increment;
        // ∑ⱼ (m − j − ½) uⱼ is the sum of the running sums, less half the last.
        open.sum += acted;
        open.weighted += open.sum;
        open.samples += 1;
        if open.samples >= blocking.samples {
            self.close(blocking.per_sample);
        }
    }

    /// Samples in the open block.
    fn samples(&self) -> N {
        N::from_count(self.open.samples as i32)
    }

    fn close(&mut self, per_sample: N) {
        let half = N::from_f64(0.5);
        let samples = self.samples();
        let open = &self.open;
        let command = open.sum * per_sample;
        let moment = (open.weighted - half * open.sum) * per_sample * per_sample;
        self.velocity = open.travel * per_sample;
        self.complete = Some(NumberedBlock {
            number: self.next,
            samples,
            block: Block {
                travel: open.travel,
                command,
                first_moment: moment - half * command,
            },
        });
        self.next = self.next.wrapping_add(1);
        self.open = Open {
            acting: open.acting,
            ..Open::default()
        };
    }

    /// The block that was completed since the last one was taken.
    #[inline]
    pub fn take(&mut self) -> Option<NumberedBlock<N>> {
        self.complete.take()
    }

    /// Velocity over the last block, counts per sample; zero before the first.
    pub(crate) fn velocity(&self) -> N {
        self.velocity
    }

    /// True if the block of a number was recorded since recording last began.
    pub(crate) fn has_recorded(&self, number: u32) -> bool {
        number.wrapping_sub(self.first) < self.next.wrapping_sub(self.first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_wrap_and_leave_one_out_where_recording_begins_anew() {
        let blocking = Blocking::new(1);
        let first = u32::MAX - 1;
        let mut recorder = Recorder::<f32> {
            next: first,
            first,
            ..Recorder::default()
        };
        let next = |recorder: &mut Recorder<f32>| {
            recorder.push(&blocking, 1.0, 1.0);
            recorder.take().map(|block| block.number)
        };
        // The first sample gives only the command that acts.
        for number in [None, Some(first), Some(u32::MAX), Some(0)] {
            assert_eq!(next(&mut recorder), number);
        }
        let recorded = |recorder: &Recorder<f32>| {
            [first - 1, first, u32::MAX, 0, 1, 2].map(|number| recorder.has_recorded(number))
        };
        let before = [false, true, true, true, false, false];
        assert_eq!(recorded(&recorder), before);
        recorder.begin_anew();
        assert_eq!(recorded(&recorder), [false; 6]);
        for number in [None, Some(2)] {
            assert_eq!(next(&mut recorder), number);
        }
        let after = [false, false, false, false, false, true];
        assert_eq!(recorded(&recorder), after);
    }
}
