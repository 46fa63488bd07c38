//! The record that a fit explains.

/// A recorded motion: what the encoder showed and what the servo was commanded.
///
/// A sample may be a part of a block of samples. With a `stride` of two every second sample has a measurement. A block
/// has the mean command ū and the first moment m = mean of u·(x − ½). Here x is the place in the block from 0 to 1. The
/// block is two samples with the commands ū ∓ 4m. Positions between measurements are interpolated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Record<'a> {
    /// Measured positions, counts.
    pub positions: &'a [f64],
    /// The command from each sample to the next, command units.
    pub commands: &'a [f64],
    /// sin q and cos q in the middle of each sample; empty for an axis without angle.
    pub angles: &'a [[f64; 2]],
    /// Counts to a rad of the angle; zero for an axis without angle.
    pub radian: f64,
    /// The samples at which a motion begins, in order, the first being 0.
    pub begins: &'a [usize],
    /// Samples from one measurement to the next, at least 1.
    pub stride: usize,
    /// The recorded commands of blocks, as many of each; else empty. The amplifier's nonlinear effects are computed
    /// from these, because half a block's mean has sizes that the command never had.
    pub recorded: &'a [f64],
}

impl<'a> Record<'a> {
    /// One motion of an axis without angle.
    pub(crate) const fn of(positions: &'a [f64], commands: &'a [f64]) -> Self {
        Self {
            positions,
            commands,
            angles: &[],
            radian: 0.0,
            begins: &[0],
            stride: 1,
            recorded: &[],
        }
    }
}

impl Record<'_> {
    /// Samples.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.positions.len()
    }

    /// True if there is no sample.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// True if a sample of a motion, from its first, has a measurement.
    #[inline]
    pub(super) const fn is_measured(&self, sample: usize) -> bool {
        self.stride <= 1 || sample.is_multiple_of(self.stride)
    }

    /// True if a sample is a part of a block.
    pub(super) const fn has_blocks(&self) -> bool {
        !self.recorded.is_empty()
    }

    /// A function of the command over a sample. For a part of a block it is computed from the block's recorded
    /// commands, by mean and first moment.
    #[inline]
    pub(super) fn over(&self, sample: usize, function: impl Fn(f64) -> f64) -> f64 {
        if !self.has_blocks() {
            return function(self.commands[sample]);
        }
        let length = 2 * self.recorded.len() / self.len().max(1);
        let first = sample / 2 * length;
        let Some(block) = self.recorded.get(first..first + length) else {
            return 0.0;
        };
        let slope = if sample.is_multiple_of(2) { -4.0 } else { 4.0 };
        let per_sample = 1.0 / length as f64;
        let weighted = block.iter().enumerate().map(|(k, &command)| {
            let place = (k as f64 + 0.5) * per_sample - 0.5;
            (1.0 + slope * place) * function(command)
        });
        per_sample * weighted.sum::<f64>()
    }

    /// The largest command.
    pub(super) fn largest_command(&self) -> f64 {
        let recorded = if self.has_blocks() {
            self.recorded
        } else {
            self.commands
        };
        (recorded.iter()).fold(0.0, |most, command| f64::max(most, command.abs()))
    }

    /// The motion from a sample to the next, counts; none at the end of a motion.
    pub(crate) fn increment(&self, sample: usize) -> f64 {
        match self.positions.get(sample + 1) {
            Some(next) => next - self.positions[sample],
            None => 0.0,
        }
    }

    /// The parts of the record in which the motion is continuous, as first sample and end.
    pub(crate) fn motions(&self) -> impl Iterator<Item = (usize, usize)> {
        let ends = self.begins.iter().skip(1).copied();
        let ends = ends.chain(core::iter::once(self.len()));
        self.begins.iter().copied().zip(ends)
    }

    /// The change of sin Nq and cos Nq over a sample of a motion, first sample and end.
    pub(super) fn wave_change(
        &self,
        (first, end): (usize, usize),
        sample: usize,
        order: f64,
    ) -> [f64; 2] {
        let (before, after) = (sample.max(first + 1) - 1, (sample + 1).min(end - 1));
        let (old, new) = (self.wave(before, order), self.wave(after, order));
        let per_sample = 1.0 / (after.saturating_sub(before)).max(1) as f64;
        [
            (new[0] - old[0]) * per_sample,
            (new[1] - old[1]) * per_sample,
        ]
    }

    /// sin q and cos q at a sample of a motion that begins at `first`, minus those at its beginning.
    #[inline]
    pub(super) fn wave_since(&self, first: usize, sample: usize) -> [f64; 2] {
        let of = |sample: usize| self.angles.get(sample).copied().unwrap_or([0.0; 2]);
        let [origin, before, after] = [first, sample.max(first + 1) - 1, sample].map(of);
        [0, 1].map(|i| 0.5 * (before[i] + after[i]) - origin[i])
    }

    /// sin Nq and cos Nq in the middle of a sample for an integer N ≥ 1. Both are zero on an axis without angle.
    pub(super) fn wave(&self, sample: usize, order: f64) -> [f64; 2] {
        let Some(&[sine, cosine]) = self.angles.get(sample) else {
            return [0.0; 2];
        };
        let product = |[s, c]: [f64; 2], [t, d]: [f64; 2]| [s * d + c * t, c * d - s * t];
        let (mut left, mut power, mut wave) = (order as u32, [sine, cosine], [0.0, 1.0]);
        while left > 0 {
            if left & 1 == 1 {
                wave = product(wave, power);
            }
            power = product(power, power);
            left >>= 1;
        }
        wave
    }
}
