//! A run or a log as the fit takes it: counts, commands, angles.

use std::f64::consts::TAU;

use identifier_core::identification::{Effect, Record, Values};

/// A recorded motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Recording {
    positions: Vec<f64>,
    commands: Vec<f64>,
    angles: Vec<[f64; 2]>,
    begins: Vec<usize>,
    /// Samples of the log to one of the record.
    pub(crate) block: f64,
    stride: usize,
    /// Distance between the ends of the motion, rad; zero on an axis without angle.
    span: f64,
}

/// A sample of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Logged {
    /// Rad.
    pub(crate) position: f64,
    /// The command from there on.
    pub(crate) command: f64,
    /// A motion begins here.
    pub(crate) begins: bool,
}

/// The most samples of a record: those of a longer log are taken together in blocks.
const MAX_SAMPLES: usize = 1 << 15;

impl Recording {
    /// Of the samples of a log with the counts per rad; `turns` for an axis that turns.
    pub(crate) fn new(
        samples: impl ExactSizeIterator<Item = Logged>,
        per_rad: f64,
        turns: bool,
    ) -> Self {
        let block = match samples.len() {
            count if count <= MAX_SAMPLES => 1,
            // Two samples of the record to a block.
            count => (2 * count).div_ceil(MAX_SAMPLES).max(2),
        };
        let mut motions: Vec<Vec<Logged>> = Vec::new();
        for sample in samples {
            if sample.begins || motions.is_empty() {
                motions.push(Vec::new());
            }
            if let Some(motion) = motions.last_mut() {
                motion.push(sample);
            }
        }
        let mut recording = Self {
            positions: Vec::new(),
            commands: Vec::new(),
            angles: Vec::new(),
            begins: Vec::new(),
            block: if block > 1 { 0.5 * block as f64 } else { 1.0 },
            stride: if block > 1 { 2 } else { 1 },
            span: 0.0,
        };
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for motion in &motions {
            let blocks = if block > 1 {
                in_blocks(motion, block)
            } else {
                motion.clone()
            };
            // Differences count alone: a far origin would cost digits.
            let Some(origin) = blocks.first().map(|first| first.position) else {
                continue;
            };
            recording.begins.push(recording.positions.len());
            for (k, sample) in blocks.iter().enumerate() {
                let position = sample.position;
                recording.positions.push((position - origin) * per_rad);
                recording.commands.push(sample.command);
                ends = [ends[0].min(position), ends[1].max(position)];
                if turns {
                    let next = blocks.get(k + 1).map_or(position, |next| next.position);
                    let middle = 0.5 * (position + next);
                    recording.angles.push([middle.sin(), middle.cos()]);
                }
            }
        }
        if turns {
            recording.span = (ends[1] - ends[0]).max(0.0);
        }
        recording
    }

    /// As a record.
    pub(crate) fn record(&self) -> Record<'_> {
        Record {
            positions: &self.positions,
            commands: &self.commands,
            angles: &self.angles,
            begins: &self.begins,
            stride: self.stride,
        }
    }

    /// Distance between the ends of the motion, rad; zero on an axis without angle.
    pub(super) fn span(&self) -> f64 {
        self.span
    }

    /// The mean of gravity over the motion, as far as less than a revolution leaves it alike to a load,
    /// counts/sample².
    pub(super) fn inseparable_gravity(&self, values: &Values) -> f64 {
        let count = self.angles.len().max(1) as f64;
        let mean = |axis: usize| self.angles.iter().map(|wave| wave[axis]).sum::<f64>() / count;
        let gravity =
            values.get(Effect::GravitySine) * mean(0) + values.get(Effect::GravityCosine) * mean(1);
        gravity.abs() * (1.0 - self.span / TAU).max(0.0)
    }

    /// True if the servo moved in both directions, by more than its encoder's noise can.
    pub(super) fn reverses(&self) -> bool {
        /// Part of the way to either side.
        const SHARE: f64 = 0.02;
        let [mut ahead, mut back] = [0.0; 2];
        for pair in self.positions.windows(2) {
            let step = pair[1] - pair[0];
            ahead += step.max(0.0);
            back -= step.min(0.0);
        }
        ahead.min(back) > SHARE * (ahead + back)
    }

    /// The magnitude of the command below which a part of it lies, for each of some parts.
    pub(super) fn levels<const L: usize>(&self, parts: [f64; L]) -> [f64; L] {
        let mut sizes: Vec<f64> = self.commands.iter().map(|command| command.abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let last = sizes.len().saturating_sub(1);
        parts.map(|part| {
            let level = sizes.get((part * last as f64) as usize);
            level.copied().unwrap_or(0.0)
        })
    }
}

/// A motion in whole blocks of samples, each as two: the commands have the block's mean and first moment, and
/// the position in its middle is interpolated.
fn in_blocks(motion: &[Logged], block: usize) -> Vec<Logged> {
    let mut blocks = Vec::new();
    let positions = motion.iter().step_by(block).map(|first| first.position);
    let ends = positions.clone().skip(1);
    for ((samples, first), next) in motion.chunks_exact(block).zip(positions).zip(ends) {
        let count = block as f64;
        let [mut mean, mut moment] = [0.0; 2];
        for (k, sample) in samples.iter().enumerate() {
            let place = (k as f64 + 0.5) / count - 0.5;
            mean += sample.command / count;
            moment += sample.command * place / count;
        }
        let half = |position, command| Logged {
            position,
            command,
            begins: false,
        };
        blocks.push(half(first, mean - 4.0 * moment));
        blocks.push(half(0.5 * (first + next), mean + 4.0 * moment));
    }
    blocks
}
