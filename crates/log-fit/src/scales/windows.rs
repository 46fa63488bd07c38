//! The equation of motion, integrated twice over windows of a record.

use crate::fit::Record;

/// What may accelerate a servo, each a column of the equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Column {
    /// −q̇.
    Velocity,
    /// u.
    Command,
    /// −sign q̇.
    Direction,
    /// One: the load.
    Load,
    /// −u̇: by it the command acts later.
    CommandChange,
    /// sin q and cos q.
    Sine,
    /// See `Sine`.
    Cosine,
    /// −q.
    Spring,
}

impl Column {
    pub(super) const COUNT: usize = 8;
}

/// A window: its mean acceleration, and the means of what may cause it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    pub(super) acceleration: f64,
    pub(super) columns: [f64; Column::COUNT],
    /// The part of it in which the servo moved.
    pub(super) moving: f64,
}

/// The motions of a record in equal bins.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bins {
    /// Samples to a bin.
    pub(super) samples: usize,
    motions: Vec<Motion>,
}

/// A motion: positions at the ends of its bins, and means over each.
#[derive(Debug, Clone, PartialEq)]
struct Motion {
    positions: Vec<f64>,
    commands: Vec<f64>,
    sines: Vec<f64>,
    cosines: Vec<f64>,
}

impl Bins {
    /// A bin for each measurement.
    pub(super) fn new(record: &Record<'_>) -> Self {
        let samples = record.stride.max(1);
        let motions = record.motions().map(|(first, end)| {
            let count = (end - first).saturating_sub(1) / samples;
            let from = |bin: usize| first + bin * samples;
            let mean = |of: &dyn Fn(usize) -> f64| {
                let bins = (0..count).map(|bin| {
                    let parts = from(bin)..from(bin + 1);
                    parts.map(of).sum::<f64>() / samples as f64
                });
                bins.collect()
            };
            let wave = |place: usize| {
                mean(&|sample| record.angles.get(sample).map_or(0.0, |angle| angle[place]))
            };
            Motion {
                positions: (0..=count).map(|bin| record.positions[from(bin)]).collect(),
                commands: mean(&|sample| record.commands[sample]),
                sines: wave(0),
                cosines: wave(1),
            }
        });
        Self {
            samples,
            motions: motions.collect(),
        }
    }

    /// All bins.
    pub(super) fn count(&self) -> usize {
        let counts = self.motions.iter().map(|motion| motion.commands.len());
        counts.sum()
    }

    /// The same in bins of twice the length.
    pub(super) fn halved(&self) -> Self {
        let mean = |of: &[f64]| {
            of.chunks_exact(2)
                .map(|two| 0.5 * (two[0] + two[1]))
                .collect()
        };
        let motions = self.motions.iter().map(|motion| Motion {
            positions: motion.positions.iter().copied().step_by(2).collect(),
            commands: mean(&motion.commands),
            sines: mean(&motion.sines),
            cosines: mean(&motion.cosines),
        });
        Self {
            samples: 2 * self.samples,
            motions: motions.collect(),
        }
    }

    /// The windows of four boxes of some bins, half a box apart or farther. `noise` is the deviation of a position. A servo
    /// that is `held` in between has no acceleration there, whatever acts on it.
    pub(super) fn windows(&self, bins: usize, noise: f64, held: bool) -> Vec<Window> {
        /// The most windows.
        const MOST: usize = 8000;
        let apart = (bins / 2).max(self.count().div_ceil(MOST));
        let motions = self.motions.iter();
        let motions = motions.filter(|motion| motion.commands.len() + 3 > 4 * bins);
        motions
            .flat_map(|motion| motion.windows(bins, self.samples as f64, apart, noise, held))
            .collect()
    }
}

impl Motion {
    fn windows(
        &self,
        bins: usize,
        samples: f64,
        apart: usize,
        noise: f64,
        held: bool,
    ) -> Vec<Window> {
        let per = 1.0 / (bins as f64 * samples);
        let directions = self.directions(bins, noise);
        let moving: Vec<f64> = directions.iter().map(|sign| sign.abs()).collect();
        let of_bins = |of: &[f64]| {
            let masked = of.iter().zip(&moving);
            let acting = masked.map(|(value, moving)| if held { value * moving } else { *value });
            every(of_boxes(boxed(acting.collect(), bins), bins), apart)
        };
        let change = |of: &[f64]| -> Vec<f64> {
            let ends = of.iter().zip(&of[bins.min(of.len())..]);
            ends.map(|(from, to)| per * (to - from)).collect()
        };
        let velocity = change(&self.positions);
        let acceleration = twice_boxed(change(&velocity), bins);
        let mut command_change = change(&self.commands);
        command_change.extend(command_change.last().copied());
        let columns = [
            every(of_boxes(velocity, bins), apart),
            of_bins(&self.commands),
            of_bins(&directions),
            of_bins(&vec![1.0; moving.len()]),
            every(of_boxes(command_change, bins), apart),
            of_bins(&self.sines),
            of_bins(&self.cosines),
            of_bins(&self.positions[..moving.len()]),
        ];
        let shares = every(of_boxes(boxed(moving.clone(), bins), bins), apart);
        let windows = every(acceleration, apart).into_iter().zip(shares);
        let windows = windows.enumerate().map(|(place, (acceleration, moving))| {
            let [
                velocity,
                command,
                direction,
                load,
                change,
                sine,
                cosine,
                position,
            ] = columns.each_ref().map(|column| column[place]);
            Window {
                acceleration,
                columns: [
                    -velocity, command, -direction, load, -change, sine, cosine, -position,
                ],
                moving,
            }
        });
        windows.collect()
    }

    /// The direction of the motion in each bin, by the means of positions ahead of it and behind it; zero where noise or the
    /// steps of an encoder hide it.
    fn directions(&self, bins: usize, noise: f64) -> Vec<f64> {
        /// Deviations of such a difference, and the part of a count that steps leave in it.
        const SIGNIFICANT: f64 = 3.0;
        const STEPS: f64 = 0.35;
        let around = (bins / 3).max(1);
        let least = SIGNIFICANT * noise * (2.0 / around as f64).sqrt() + STEPS;
        let means = boxed(self.positions.clone(), around);
        let last = means.len().saturating_sub(1);
        let of = |bin: usize| {
            let behind = (bin + 1).saturating_sub(around);
            let moved = means[(bin + 1).min(last)] - means[behind.min(last)];
            if moved.abs() > least {
                moved.signum()
            } else {
                0.0
            }
        };
        (0..self.commands.len()).map(of).collect()
    }
}

/// The means of some values from each on.
fn boxed(mut values: Vec<f64>, count: usize) -> Vec<f64> {
    let length = (values.len() + 1).saturating_sub(count);
    let mut sum: f64 = values.iter().take(count - 1).sum();
    for from in 0..length {
        sum += values[from + count - 1];
        let first = std::mem::replace(&mut values[from], sum / count as f64);
        sum -= first;
    }
    values.truncate(length);
    values
}

fn twice_boxed(values: Vec<f64>, count: usize) -> Vec<f64> {
    boxed(boxed(values, count), count)
}

/// The means over windows of what has been averaged over their first box. From one end of a bin to the next that mean runs
/// in a straight line, because what acts is held.
fn of_boxes(means: Vec<f64>, count: usize) -> Vec<f64> {
    let over = boxed(means, count);
    let between = over.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    twice_boxed(between.collect(), count)
}

fn every(values: Vec<f64>, apart: usize) -> Vec<f64> {
    values.into_iter().step_by(apart).collect()
}
