//! Which samples of an even clock the rows of a log are, by their time stamps.
//!
//! A row is a sample of a drive whose stamp came late, or a row before it was lost. One stamp cannot tell: those after it
//! can, because a lost row moves all of them. So several histories of lost rows are followed side by side, each with a
//! clock of its own. What a history costs in bits decides (a Viterbi decoder with per-survivor processing: Raheli,
//! Polydoros, Tzou, IEEE Trans. Communications 43, 1995).

use std::ops::Range;

/// The place of a row on the clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tick {
    /// The time begins anew.
    Begins,
    /// It is the sample this number of samples after the last row's: the same sample for 0.
    After(u32),
}

/// The usual times from one row to the next, s, from small to large: the median, which few lost rows do not move, and the
/// mean, which coarse stamps do not move. None if the time never advances.
pub(crate) fn usual_steps(stamps: &[f64]) -> Option<[f64; 2]> {
    /// A step of more medians is a pause.
    const PAUSE: f64 = 20.0;
    let mut steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let back = steps.partition_point(|step| *step <= 0.0);
    let median = *steps.get(usize::midpoint(back, steps.len()))?;
    let counted = steps.iter().filter(|step| step.abs() <= PAUSE * median);
    let mean = counted.clone().sum::<f64>() / counted.count() as f64;
    Some([median, mean])
}

/// The rows of a log on an even clock.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    /// Of each row.
    pub(super) of: Vec<Tick>,
    /// Time of a sample, s: the slope of the stamps by least squares.
    pub(super) step: f64,
    /// Deviation of the stamps from the clock.
    pub(super) jitter: Jitter,
    /// Bits of the stamps on it, but for a constant.
    pub(super) bits: f64,
}

/// A history of the rows so far.
#[derive(Debug, Clone, Copy)]
struct History {
    bits: f64,
    /// The last sample: its number, and its time on the clock, s.
    sample: u64,
    at: f64,
    /// Time of a sample, s.
    step: f64,
    /// Rows since the time began, and in all.
    rows: f64,
    all: f64,
    /// Its last row among those of all histories.
    place: usize,
}

impl Ticks {
    /// The likeliest samples of stamps, s, of a clock whose samples are about `step` (s) apart. More than `longest` samples
    /// from row to row, and a row that `is_cut` off from the one before, begin the time anew.
    pub(super) fn new(
        stamps: &[f64],
        step: f64,
        longest: u32,
        is_cut: &dyn Fn(f64, f64) -> bool,
    ) -> Self {
        /// Histories that are followed.
        const FOLLOWED: usize = 6;
        /// Deviation of the stamps below which no history is doubtful, samples.
        const EXACT: f64 = 0.02;
        let steps = || stamps.windows(2).map(|pair| pair[1] - pair[0]);
        let uneven = steps().map(|passed| (passed / step - 1.0).abs().min(4.0));
        // The mean size of the difference of two normal numbers is 2/√π of their deviation.
        let deviation = 0.886 * uneven.sum::<f64>() / stamps.len() as f64;
        let mut places = vec![(0, Tick::Begins)];
        let mut histories = vec![History {
            bits: 0.0,
            sample: 0,
            at: stamps.first().copied().unwrap_or(0.0),
            step,
            rows: 1.0,
            all: 1.0,
            place: 0,
        }];
        let mut next = Vec::new();
        for pair in stamps.windows(2) {
            next.clear();
            for history in &histories {
                if is_cut(pair[0], pair[1]) {
                    next.push(history.begun(pair[1], 0.0));
                } else {
                    history.continued(pair[1], longest, deviation.max(EXACT), &mut next);
                }
            }
            histories.clear();
            while let Some((likeliest, tick)) = (next.iter().copied())
                .min_by(|one, other| one.0.bits.total_cmp(&other.0.bits))
                .filter(|_| histories.len() < FOLLOWED)
            {
                next.retain(|(other, _)| {
                    other.sample != likeliest.sample
                        || (other.at - likeliest.at).abs() >= 0.5 * likeliest.step
                });
                places.push((likeliest.place, tick));
                histories.push(History {
                    place: places.len() - 1,
                    ..likeliest
                });
            }
        }
        let mut place = histories[0].place;
        let mut of: Vec<Tick> = stamps
            .iter()
            .map(|_| {
                let (before, tick) = places[place];
                place = before;
                tick
            })
            .collect();
        of.reverse();
        let scale = (deviation.max(EXACT) * step).log2();
        Self {
            bits: histories[0].bits + stamps.len() as f64 * scale,
            ..Self::measured(of, stamps, step)
        }
    }

    /// Step and jitter of known samples.
    fn measured(of: Vec<Tick>, stamps: &[f64], step: f64) -> Self {
        let mut sample = 0.0;
        let rows: Vec<(Tick, [f64; 2])> = (of.iter().zip(stamps))
            .map(|(tick, stamp)| {
                sample += match tick {
                    Tick::Begins => 1.0,
                    Tick::After(samples) => f64::from(*samples),
                };
                (*tick, [sample, *stamp])
            })
            .filter(|(tick, _)| *tick != Tick::After(0))
            .collect();
        let centred = rows
            .chunk_by(|_, (next, _)| *next != Tick::Begins)
            .flat_map(|piece| {
                let mean = |of: usize| {
                    piece.iter().map(|(_, row)| row[of]).sum::<f64>() / piece.len() as f64
                };
                let [sample, stamp] = [mean(0), mean(1)];
                (piece.iter()).map(move |(_, row)| [row[0] - sample, row[1] - stamp])
            });
        let [mut squares, mut products] = [0.0; 2];
        for [sample, stamp] in centred.clone() {
            squares += sample * sample;
            products += sample * stamp;
        }
        let step = if products > 0.0 {
            products / squares
        } else {
            step
        };
        let mut jitter = Jitter::default();
        for [sample, stamp] in centred {
            let off = (stamp / step - sample).abs();
            jitter.rms += off * off / rows.len() as f64;
            jitter.largest = jitter.largest.max(off);
        }
        jitter.rms = jitter.rms.sqrt();
        Self {
            of,
            step,
            jitter,
            bits: f64::INFINITY,
        }
    }

    /// The same rows, each the sample after the last: those of stamps that are cut to a grid.
    pub(super) fn row_by_row(&self, stamps: &[f64]) -> Self {
        let next = |tick: &Tick| match tick {
            Tick::After(_) => Tick::After(1),
            Tick::Begins => Tick::Begins,
        };
        Self::measured(self.of.iter().map(next).collect(), stamps, self.step)
    }

    /// Rows that have the sample of the row before.
    pub(super) fn doubled(&self) -> f64 {
        let doubled = self.of.iter().filter(|tick| **tick == Tick::After(0));
        doubled.count() as f64
    }

    /// The rows between two beginnings of the time.
    pub(super) fn pieces(&self) -> Vec<Range<usize>> {
        let begins = (0..self.of.len()).filter(|row| self.of[*row] == Tick::Begins);
        let mut firsts: Vec<usize> = begins.collect();
        firsts.push(self.of.len());
        firsts.windows(2).map(|pair| pair[0]..pair[1]).collect()
    }
}

impl History {
    /// Bits of a row that is lost, of a row twice, of a time that begins anew, and of a stamp that says nothing. Between
    /// two beginnings of the time there are more than two such stamps.
    const LOST: f64 = 6.0;
    const TWICE: f64 = 16.0;
    const ANEW: f64 = 12.0;
    const NOTHING: f64 = 10.0;

    /// The time begins anew at a stamp, s.
    fn begun(&self, stamp: f64, bits: f64) -> (Self, Tick) {
        let begun = Self {
            bits: self.bits + bits,
            sample: self.sample + 1,
            at: stamp,
            rows: 1.0,
            ..*self
        };
        (begun, Tick::Begins)
    }

    /// Adds its continuations by a stamp, s, that deviates by so much, samples.
    fn continued(&self, stamp: f64, longest: u32, deviation: f64, into: &mut Vec<(Self, Tick)>) {
        /// Rows that the clock remembers, and those that the first step is worth.
        const MEMORY: f64 = 256.0;
        const FIRST: f64 = 12.0;
        let later = (stamp - self.at) / self.step;
        let longest = f64::from(longest);
        if later.abs() > longest + 0.5 {
            into.push(self.begun(stamp, Self::ANEW));
        }
        // Growing and then fading memory of a line: Kalata's α and β of least squares.
        let rows = (self.rows + 1.0).min(MEMORY);
        let all = (self.all + FIRST).min(MEMORY);
        let of_time = (4.0 * rows - 2.0) / (rows * (rows + 1.0));
        let of_step = 6.0 / (all * (all + 1.0));
        let far = later.round().clamp(3.0, longest.max(3.0));
        for (after, bits) in [
            (0.0, Self::TWICE),
            (1.0, 0.0),
            (2.0, Self::LOST),
            (far, Self::LOST),
        ] {
            let off = later - after;
            let size = (off / deviation) * (off / deviation);
            // Student's distribution of three degrees of freedom.
            let unlikely = 2.0 * (1.0 + size / 3.0).log2();
            let pull = off / (1.0 + size / 16.0);
            into.push((
                Self {
                    bits: self.bits + bits + unlikely.min(Self::NOTHING),
                    sample: self.sample + after as u64,
                    at: self.at + self.step * (after + of_time * pull),
                    step: self.step * (1.0 + of_step * pull),
                    rows,
                    all: self.all + 1.0,
                    place: self.place,
                },
                Tick::After(after as u32),
            ));
        }
    }
}

/// Deviation of the time stamps of a log from an even clock, parts of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jitter {
    /// Root mean square.
    pub rms: f64,
    /// The largest.
    pub largest: f64,
}
