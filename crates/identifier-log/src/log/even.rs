//! The time of a log: its rows as samples of one length, whatever its stamps are.
//!
//! Two clocks may be true of rows whose stamps are uneven. The rows of a drive are even, and a logger stamped them
//! late. A row is then the next sample. The rows of a loop in software are as uneven as their stamps. The position at
//! even times is then interpolated. The command, held from its stamp to the next, is averaged over each sample. The
//! motion says which ([`Clock`] is chosen by the bits that either saves).

use std::ops::Range;

use super::clock::{Jitter, Tick, Ticks};
use super::row::Row;
use crate::readings::Signals;
use crate::scenario::{LogSettings, TimeUnit};

/// The clock of a log's rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clock {
    /// One row after the other, even whatever the stamps say.
    #[default]
    Even,
    /// As stamped.
    Stamped,
}

/// The samples of a log.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct EvenRows {
    pub(super) rows: Vec<Row>,
    /// Time from one to the next, s.
    pub(super) sample_time: f64,
    pub(super) clock: Clock,
    /// Deviation of the stamps from an even clock.
    pub(super) jitter: Jitter,
}

/// Longest gap, samples, that straight lines bridge without a statement.
const BRIDGED: u32 = 3;
/// Deviation from an even clock, part of a sample, from which the clocks differ.
const UNEVEN: f64 = 0.02;
/// Longest time from one position to the next, samples, within a motion with stamped times.
const LONGEST: f64 = BRIDGED as f64 + 1.5;

/// The usual time from one row to the next, s. It is the mean of the steps without a missing sample. None if the time
/// never advances.
pub(super) fn usual_step(rows: &[Row]) -> Option<f64> {
    /// Steps that are examined.
    const MAX_STEPS: usize = 100_000;
    /// A step of this many medians has a sample missing.
    const MIN_GAP: f64 = 1.5;
    /// Largest share of gaps among the steps.
    const MAX_GAP_SHARE: f64 = 0.1;
    let steps = rows.windows(2).map(|pair| pair[1].time - pair[0].time);
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).take(MAX_STEPS).collect();
    if steps.is_empty() {
        return None;
    }
    steps.sort_unstable_by(f64::total_cmp);
    let whole = steps.partition_point(|step| *step <= MIN_GAP * steps[steps.len() / 2]);
    let few = (steps.len() - whole) as f64 <= MAX_GAP_SHARE * steps.len() as f64;
    let counted = if few { &steps[..whole] } else { &steps };
    Some(counted.iter().sum::<f64>() / counted.len() as f64)
}

impl EvenRows {
    /// The motion of rows with their stamps, `step` (s) apart. The positions are continued, and `cell` is their
    /// smallest change.
    ///
    pub(super) fn new(
        mut rows: Vec<Row>,
        settings: &LogSettings,
        mut step: f64,
        cell: f64,
    ) -> Self {
        /// Part of the rows with the stamp before from which stamps are too coarse.
        const COARSE: f64 = 0.2;
        /// Part of the rows without a position from which position and command have stamps of their own.
        const BLANK: f64 = 0.1;
        let count = rows.len() as f64;
        let steps = || rows.windows(2).map(|pair| pair[1].time - pair[0].time);
        let still = steps().filter(|step| *step == 0.0).count() as f64;
        let back = steps().filter(|step| *step < 0.0).count() as f64;
        if back == 0.0 && still > COARSE * count && settings.units.time != TimeUnit::Sample {
            let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
                return Self::default();
            };
            let from = first.time;
            step = (last.time - from) / (count - 1.0);
            for (row, index) in rows.iter_mut().zip(0..) {
                row.time = from + f64::from(index) * step;
            }
        }
        let is_whole = |row: &Row| row.position.is_finite();
        let blank = rows.iter().filter(|row| !is_whole(row)).count();
        if blank as f64 > BLANK * count {
            let measured: Vec<Row> = rows.iter().copied().filter(is_whole).collect();
            let own = usual_step(&measured).unwrap_or(step);
            return Self::as_stamped(&rows, settings, own);
        }
        if blank > 0 {
            rows.retain(is_whole);
        }
        let rows = match Self::in_place(rows, settings, step) {
            Ok(even) => return even,
            Err(rows) => rows,
        };
        let even = Self::by_rows(&rows, settings, step);
        if let Some(even) = even.filter(|even| even.jitter.rms() < UNEVEN) {
            return even;
        }
        let pieces = pieces(&rows, settings, LONGEST * step);
        if !is_even(&rows, &pieces, step, cell) {
            return Self::as_stamped(&rows, settings, step);
        }
        if let Some(even) = Self::by_rows(&rows, settings, step) {
            return even;
        }
        let mut rows = rows;
        for piece in pieces {
            let piece = &mut rows[piece];
            let Some(from) = piece.first().map(|row| row.time) else {
                continue;
            };
            for (row, index) in piece.iter_mut().zip(0..) {
                row.time = from + f64::from(index) * step;
            }
        }
        Self::by_rows(&rows, settings, step).unwrap_or_default()
    }

    /// Takes every row as the sample after the last.
    fn in_place(mut rows: Vec<Row>, settings: &LogSettings, step: f64) -> Result<Self, Vec<Row>> {
        let Some(first) = rows.first() else {
            return Err(rows);
        };
        let mut ticks = Ticks::new(step, first.time);
        let is_next = |pair: &[Row]| {
            !settings.leaves_out_between(pair[0].time, pair[1].time)
                && ticks.tick(pair[1].time) == Tick::After(1)
        };
        if !rows.windows(2).all(is_next) || ticks.jitter().rms() >= UNEVEN {
            return Err(rows);
        }
        let length = rows[rows.len() - 1].time - first.time;
        let sample_time = length / (rows.len() - 1) as f64;
        rows[0].begins = true;
        Ok(Self {
            rows,
            sample_time,
            clock: Clock::Even,
            jitter: ticks.jitter(),
        })
    }

    /// Every row the sample that its stamp is next to: none where stamps and samples do not go together.
    fn by_rows(rows: &[Row], settings: &LogSettings, step: f64) -> Option<Self> {
        /// Part of the rows that may be bridged, or have the place of another row.
        const MAX_SHARE: f64 = 0.01;
        let bridge = settings.bridge.max(BRIDGED);
        let mut all = Self {
            sample_time: step,
            ..Self::default()
        };
        let (mut time, mut samples) = (0.0, 0.0);
        let (mut bridged, mut too_early) = (0_u32, 0_u32);
        let mut last: Option<(Row, Ticks)> = None;
        for row in rows {
            let mut row = *row;
            let before = last.filter(|(last, _)| {
                row.time >= last.time && !settings.leaves_out_between(last.time, row.time)
            });
            let next = before.map(|(from, mut ticks)| (from, ticks.tick(row.time), ticks));
            match next {
                Some((_, Tick::Back | Tick::TooEarly, _)) => {
                    too_early += 1;
                    continue;
                }
                Some((from, Tick::After(after), ticks)) if after <= bridge + 1 => {
                    bridged += after - 1;
                    all.bridge(&from, &row, after);
                    time += row.time - from.time;
                    samples += f64::from(after);
                    last = Some((row, ticks));
                }
                _ => {
                    row.begins = true;
                    all.jitter = all
                        .jitter
                        .with(last.map(|(_, ticks)| ticks.jitter()).unwrap_or_default());
                    last = Some((row, Ticks::new(step, row.time)));
                }
            }
            all.rows.push(row);
        }
        all.jitter = all
            .jitter
            .with(last.map(|(_, ticks)| ticks.jitter()).unwrap_or_default());
        if samples > 0.0 {
            all.sample_time = time / samples;
        }
        let allowed = MAX_SHARE * rows.len() as f64;
        let is_stated = settings.bridge > 0;
        let is_sound =
            f64::from(too_early) <= allowed && (is_stated || f64::from(bridged) <= allowed);
        is_sound.then_some(all)
    }

    /// Adds the samples between two rows, the later of which is `after` samples after the other.
    fn bridge(&mut self, from: &Row, to: &Row, after: u32) {
        for sample in 1..after {
            let part = f64::from(sample) / f64::from(after);
            let between = |from: f64, to: f64| from + part * (to - from);
            let both = |from: Option<f64>, to: Option<f64>| Some(between(from?, to?));
            self.rows.push(Row {
                line: to.line,
                time: between(from.time, to.time),
                reference: both(from.reference, to.reference),
                position: between(from.position, to.position),
                command: both(from.command, to.command),
                injection: between(from.injection, to.injection),
                velocity: both(from.velocity, to.velocity),
                bridged: true,
                begins: false,
            });
        }
    }

    /// The motion at even times, from rows with stamped times.
    fn as_stamped(rows: &[Row], settings: &LogSettings, step: f64) -> Self {
        let mut all = Self {
            sample_time: step,
            clock: Clock::Stamped,
            ..Self::default()
        };
        let longest = LONGEST.max(f64::from(settings.bridge) + 1.5);
        for piece in pieces(rows, settings, longest * step) {
            Piece::of(&rows[piece]).resampled(step, &mut all.rows);
        }
        all
    }
}

/// The rows between breaks. A break is a step back in time, or one of more than `longest` from one position to the
/// next.
fn pieces(rows: &[Row], settings: &LogSettings, longest: f64) -> Vec<Range<usize>> {
    let mut pieces = Vec::new();
    let (mut first, mut measured) = (0, f64::NAN);
    for (index, row) in rows.iter().enumerate() {
        let before = rows[index.max(1) - 1].time;
        let is_break = row.time < before
            || (row.position.is_finite() && row.time - measured > longest)
            || (index > first && settings.leaves_out_between(before, row.time));
        if is_break {
            pieces.push(first..index);
            first = index;
            measured = f64::NAN;
        }
        if row.position.is_finite() {
            measured = row.time;
        }
    }
    pieces.push(first..rows.len());
    pieces
}

/// A motion without a break: what is held at every stamp, and the position at those that have one.
struct Piece<'a> {
    rows: &'a [Row],
    /// The rows with a position.
    measured: Vec<&'a Row>,
}

impl<'a> Piece<'a> {
    fn of(rows: &'a [Row]) -> Self {
        let mut measured: Vec<&Row> = Vec::new();
        for row in rows.iter().filter(|row| row.position.is_finite()) {
            // If two positions have the same time, the first counts.
            if measured.last().is_none_or(|last| row.time > last.time) {
                measured.push(row);
            }
        }
        Self { rows, measured }
    }

    /// Adds the samples, `step` (s) apart, from the first position to the last.
    fn resampled(&self, step: f64, into: &mut Vec<Row>) {
        let (Some(first), Some(last)) = (self.measured.first(), self.measured.last()) else {
            return;
        };
        let count = ((last.time - first.time) / step + 1e-6) as usize;
        let (mut place, mut held) = (0, 0);
        for sample in 0..=count {
            let time = first.time + sample as f64 * step;
            while place + 2 < self.measured.len() && self.measured[place + 1].time <= time {
                place += 1;
            }
            while self
                .rows
                .get(held + 1)
                .is_some_and(|next| next.time <= time)
            {
                held += 1;
            }
            into.push(Row {
                time,
                position: self.position(place, time),
                velocity: self.velocity(place, time),
                command: self.command(held, time, step),
                begins: sample == 0,
                bridged: false,
                ..self.rows[held]
            });
        }
    }

    /// The cubic through the two positions around a time, with the slopes of those beside them.
    fn position(&self, place: usize, time: f64) -> f64 {
        let at = |index: usize| self.measured[index.min(self.measured.len() - 1)];
        let (from, to) = (at(place), at(place + 1));
        let length = to.time - from.time;
        if length <= 0.0 {
            return from.position;
        }
        let slope = |index: usize| {
            let (before, after) = (at(index.max(1) - 1), at(index + 1));
            length * (after.position - before.position) / (after.time - before.time)
        };
        let (v, w) = (
            slope(place),
            slope((place + 1).min(self.measured.len() - 1)),
        );
        let (way, x) = (to.position - from.position, (time - from.time) / length);
        from.position + x * (v + x * (3.0 * way - 2.0 * v - w + x * (v + w - 2.0 * way)))
    }

    fn velocity(&self, place: usize, time: f64) -> Option<f64> {
        let from = self.measured[place];
        let to = self.measured.get(place + 1)?;
        let part = (time - from.time) / (to.time - from.time);
        Some(from.velocity? + part * (to.velocity? - from.velocity?))
    }

    /// The mean of the held command over the sample from `time` on, whose row is the last before it.
    fn command(&self, row: usize, time: f64, step: f64) -> Option<f64> {
        let (mut value, mut sum, mut from) = (self.rows[row].command?, 0.0, time);
        for next in &self.rows[row + 1..] {
            if next.time >= time + step {
                break;
            }
            sum += value * (next.time - from);
            from = next.time;
            value = next.command.unwrap_or(value);
        }
        sum += value * (time + step - from);
        Some(sum / step)
    }
}

/// True if even rows encode the motion in fewer bits than rows with stamped times.
fn is_even(rows: &[Row], pieces: &[Range<usize>], step: f64, cell: f64) -> bool {
    /// Bits that the clock which contradicts the stamps must save.
    const NEEDED: f64 = 10.0;
    let bits = |time: &dyn Fn(f64) -> f64| {
        let mut signals = Signals::default();
        for piece in pieces {
            let piece = &rows[piece.clone()];
            for (index, row) in piece.iter().enumerate() {
                let passed = piece
                    .get(index + 1)
                    .map_or(step, |next| next.time - row.time);
                signals.add(time(passed), row.position, row.command, index == 0);
            }
        }
        signals.told(step, cell)
    };
    let even = bits(&|passed| {
        if passed < 2.5 * step {
            step
        } else {
            step * (passed / step).round()
        }
    });
    even + NEEDED < bits(&|passed| passed.max(1e-3 * step))
}

#[cfg(test)]
mod tests {
    use super::Clock;
    use crate::log::{Log, Table};
    use crate::scenario::{Column, LogSettings};

    const STEP: f64 = 2e-3;
    const ROWS: usize = 2000;

    /// Numbers from −1 to 1 in no order.
    fn noise(k: usize) -> f64 {
        let mixed = (k as u64 ^ (k as u64 >> 7)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = (mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 11;
        mixed as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Commands that change every 0.1 s, and the counts of the servo q̈ = −10 q̇ + 110 u at some times.
    fn moved(times: &[f64]) -> (Vec<f64>, Vec<f64>) {
        const COUNT: f64 = std::f64::consts::TAU / 8192.0;
        let (mut q, mut v) = (0.0, 0.0);
        let (mut commands, mut positions) = (Vec::new(), Vec::new());
        for (row, time) in times.iter().enumerate() {
            let command = 5.0 * noise((10.0 * time).max(0.0) as usize);
            commands.push(command);
            positions.push((q / COUNT).round() * COUNT);
            let step = times.get(row + 1).map_or(STEP, |next| next - time) / 50.0;
            for _ in 0..50 {
                v += step * (110.0 * command - 10.0 * v);
                q += step * v;
            }
        }
        (commands, positions)
    }

    fn log(times: &[f64], positions: Vec<f64>, commands: Vec<f64>) -> Log {
        let of = |name: &str, column: Vec<f64>| (name.to_owned(), column);
        let columns = vec![
            of("t", times.to_vec()),
            of("q", positions),
            of("u", commands),
        ];
        let table = Table::of_columns("log", columns).expect("one length");
        let mut settings = LogSettings::with_position(Column::named("q"));
        settings.time = Some(Column::named("t"));
        settings.command = Some(Column::named("u"));
        Log::new(&table, &settings, None).expect("a log")
    }

    fn even() -> Vec<f64> {
        (0..ROWS).map(|row| STEP * row as f64).collect()
    }

    #[test]
    fn the_motion_says_which_clock_its_rows_have() {
        for part in [0.1, 0.25] {
            // Each step is longer or shorter, as of a loop that waits: the stamps are true.
            let mut time = 0.0;
            let uneven: Vec<f64> = (0..ROWS)
                .map(|row| {
                    time += STEP * (1.0 + part * noise(row));
                    time
                })
                .collect();
            let (commands, positions) = moved(&uneven);
            let found = log(&uneven, positions.clone(), commands);
            assert_eq!(found.found.clock, Clock::Stamped, "{part}");
            for row in found.rows().iter().step_by(37) {
                let after = uneven
                    .partition_point(|time| *time <= row.time)
                    .min(ROWS - 1);
                let (low, high) = (positions[after - 1], positions[after]);
                let off = (low.min(high) - row.position).max(row.position - low.max(high));
                assert!(off < 1e-3, "{off}");
            }
            // An even drive whose rows are stamped late.
            let (commands, positions) = moved(&even());
            let late: Vec<f64> = (even().iter().enumerate())
                .map(|(row, time)| time + part * STEP * noise(row))
                .collect();
            let found = log(&late, positions.clone(), commands);
            assert_eq!(found.found.clock, Clock::Even, "{part}");
            assert_eq!(found.rows().len(), ROWS);
            assert!((found.rows()[500].position - positions[500]).abs() < 1e-12);
        }
    }

    #[test]
    fn two_topics_are_joined_by_their_own_stamps() {
        let (commands, positions) = moved(&even());
        let mut times = Vec::new();
        let (mut of_position, mut of_command) = (Vec::new(), Vec::new());
        for row in 0..ROWS {
            times.extend([STEP * row as f64, STEP * row as f64 + 1e-6]);
            of_command.extend([commands[row], f64::NAN]);
            of_position.extend([f64::NAN, positions[row]]);
        }
        let found = log(&times, of_position, of_command);
        assert!((found.sample_time / STEP - 1.0).abs() < 1e-6);
        for (row, sample) in found.rows().iter().zip(0..).take(ROWS - 1) {
            assert!((row.position - positions[sample]).abs() < 1e-9);
            let beside = commands[sample.min(ROWS - 2) + 1];
            let command = row.command.expect("a command");
            let (low, high) = (commands[sample].min(beside), commands[sample].max(beside));
            assert!((low - 1e-9..=high + 1e-9).contains(&command), "{sample}");
        }
    }

    #[test]
    fn a_gap_and_a_time_that_begins_again_are_breaks() {
        let (commands, positions) = moved(&even());
        let mut times = even();
        for time in &mut times[700..] {
            *time += 0.3;
        }
        for time in &mut times[1400..] {
            *time -= 2.0;
        }
        let found = log(&times, positions, commands);
        let begins: Vec<usize> = (0..found.rows().len())
            .filter(|row| found.rows()[*row].begins)
            .collect();
        assert_eq!(begins, [0, 700, 1400]);
    }
}
