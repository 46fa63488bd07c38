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

/// The usual times from one row to the next, s: the median of the steps, which few lost rows do not move, and the mean,
/// which coarse stamps do not move. Rows that a buffer hands over in bursts have the stamps of these. None if the time never
/// advances.
pub(crate) fn usual_steps(stamps: impl Iterator<Item = f64> + Clone) -> Option<[f64; 2]> {
    /// A step of more medians is a pause.
    const PAUSE: f64 = 20.0;
    /// Part of the steps that are pauses, and of the time within bursts, from and up to which rows come in bursts.
    const PAUSES: f64 = 0.05;
    const WITHIN: f64 = 0.2;
    let next = stamps.clone().skip(1);
    let mut steps: Vec<f64> = next.zip(stamps).map(|(next, stamp)| next - stamp).collect();
    steps.sort_unstable_by(f64::total_cmp);
    let back = steps.partition_point(|step| *step <= 0.0);
    let mut median = *steps.get(usize::midpoint(back, steps.len()))?;
    let pauses = &steps[steps.partition_point(|step| *step <= PAUSE * median)..];
    let [paused, all] = [pauses, &steps[back..]].map(|of| of.iter().sum::<f64>());
    if pauses.len() as f64 > PAUSES * steps.len() as f64 && paused > (1.0 - WITHIN) * all {
        median = pauses[pauses.len() / 2];
    }
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
        /// Places of rows on which the histories may still differ.
        const MOST_PLACES: usize = 4096;
        let steps = || stamps.windows(2).map(|pair| pair[1] - pair[0]);
        let uneven = steps().map(|passed| (passed / step - 1.0).abs().min(4.0));
        // The mean size of the difference of two normal numbers is 2/√π of their deviation.
        let deviation = 0.886 * uneven.sum::<f64>() / stamps.len() as f64;
        let mut settled = Vec::with_capacity(stamps.len());
        let mut places = vec![(BEFORE_FIRST, Tick::Begins)];
        let mut most_places = MOST_PLACES;
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
            if places.len() > most_places {
                settle(&mut histories, &mut places, &mut settled);
                most_places = MOST_PLACES.max(2 * places.len());
            }
        }
        let mut of = settled;
        let likeliest = path(&places, histories[0].place);
        of.extend(likeliest.iter().map(|place| places[*place].1));
        let scale = (deviation.max(EXACT) * step).log2();
        Self {
            bits: histories[0].bits + stamps.len() as f64 * scale,
            ..Self::measured(of, stamps, step)
        }
    }

    /// The samples of stamps that leave no doubt: one step (s) after the other but for a hundredth, or a pause. A step twice
    /// as long is a lost row, or of stamps that are cut.
    pub(super) fn gapless(
        stamps: &[f64],
        step: f64,
        longest: u32,
        is_cut: &dyn Fn(f64, f64) -> bool,
    ) -> Option<Self> {
        /// Deviation of a step, and of the stamps from their clock, samples.
        const EXACT: f64 = 0.01;
        let mut of = Vec::with_capacity(stamps.len());
        of.push(Tick::Begins);
        for pair in stamps.windows(2) {
            let later = (pair[1] - pair[0]) / step;
            if is_cut(pair[0], pair[1]) || later.abs() > f64::from(longest) + 0.5 {
                of.push(Tick::Begins);
            } else if (later - 1.0).abs() < EXACT {
                of.push(Tick::After(1));
            } else {
                return None;
            }
        }
        let found = Self::measured(of, stamps, step);
        (found.jitter.largest < EXACT).then_some(found)
    }

    /// True if each row is the sample after the last.
    pub(super) fn is_gapless(&self) -> bool {
        let mut ticks = self.of.iter();
        ticks.all(|tick| matches!(tick, Tick::Begins | Tick::After(1)))
    }

    /// Step and jitter of known samples.
    fn measured(of: Vec<Tick>, stamps: &[f64], step: f64) -> Self {
        let mut all = Self {
            of,
            step,
            jitter: Jitter::default(),
            bits: f64::INFINITY,
        };
        let pieces = all.pieces();
        // Anew in each pass: a long log has no copy of its stamps.
        let centred = |piece: &Range<usize>| {
            let mut number = 0.0;
            let ticks = all.of[piece.clone()].iter().zip(&stamps[piece.clone()]);
            let rows = ticks.filter_map(move |(tick, stamp)| {
                number += match tick {
                    Tick::Begins => 0.0,
                    Tick::After(samples) => f64::from(*samples),
                };
                (*tick != Tick::After(0)).then_some([number, *stamp])
            });
            let count = rows.clone().count() as f64;
            let mean = |place: usize| rows.clone().map(|row| row[place]).sum::<f64>() / count;
            let [number, stamp] = [mean(0), mean(1)];
            rows.map(move |row| [row[0] - number, row[1] - stamp])
        };
        let [mut squares, mut products] = [0.0; 2];
        for [number, stamp] in pieces.iter().flat_map(centred) {
            squares += number * number;
            products += number * stamp;
        }
        let step = if products > 0.0 {
            products / squares
        } else {
            step
        };
        let (mut jitter, mut rows) = (Jitter::default(), 0.0);
        for [number, stamp] in pieces.iter().flat_map(centred) {
            let off = (stamp / step - number).abs();
            jitter.rms += off * off;
            jitter.largest = jitter.largest.max(off);
            rows += 1.0;
        }
        jitter.rms = (jitter.rms / rows).sqrt();
        (all.step, all.jitter) = (step, jitter);
        all
    }

    /// The same rows, each the sample after the last: those of stamps that are cut to a grid.
    pub(super) fn row_by_row(&self, stamps: &[f64]) -> Self {
        // From one stamp of a coarse grid to the next there is no gap.
        let most = usual_steps(stamps.iter().copied()).map_or(0.0, |[grid, _]| 1.5 * grid);
        let next = |(tick, step): (&Tick, f64)| match tick {
            Tick::Begins if !(0.0..most).contains(&step) => Tick::Begins,
            _ => Tick::After(1),
        };
        let steps = stamps.windows(2).map(|pair| pair[1] - pair[0]);
        let before = std::iter::once(f64::INFINITY).chain(steps);
        Self::measured(
            self.of.iter().zip(before).map(next).collect(),
            stamps,
            self.step,
        )
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

/// The place before the first.
const BEFORE_FIRST: usize = usize::MAX;

/// The places of a history up to its last, each with the place before it.
fn path(places: &[(usize, Tick)], last: usize) -> Vec<usize> {
    let before = |place: &usize| Some(places[*place].0).filter(|before| *before != BEFORE_FIRST);
    let mut path: Vec<usize> = std::iter::successors(Some(last), before).collect();
    path.reverse();
    path
}

/// Moves the ticks in which all histories agree from their places to those that are settled: a long log has no tree of
/// places as long.
fn settle(histories: &mut [History], places: &mut Vec<(usize, Tick)>, settled: &mut Vec<Tick>) {
    let paths: Vec<Vec<usize>> = histories
        .iter()
        .map(|history| path(places, history.place))
        .collect();
    let agree = |row: &usize| paths.iter().all(|path| path[*row] == paths[0][*row]);
    // A history keeps its last place.
    let agreed = (0..paths[0].len() - 1).take_while(agree).count();
    settled.extend(paths[0][..agreed].iter().map(|place| places[*place].1));
    let mut kept = Vec::new();
    for (history, path) in histories.iter_mut().zip(&paths) {
        history.place = path[agreed..].iter().fold(BEFORE_FIRST, |before, place| {
            kept.push((before, places[*place].1));
            kept.len() - 1
        });
    }
    *places = kept;
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
