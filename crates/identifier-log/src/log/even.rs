//! The time of a log: its rows as samples of one length, whatever its stamps are.
//!
//! Two clocks may be true of rows whose stamps are uneven. The rows of a drive are even, and a logger stamped them
//! late. A row is then the next sample. The rows of a loop in software are as uneven as their stamps. The position at
//! even times is then interpolated. The command, held from its stamp to the next, is averaged over each sample. The
//! motion says which ([`Clock`] is chosen by the bits that either saves).

use std::ops::Range;

use super::clock::{Jitter, Tick, Ticks, usual_steps};
use super::code_length::TimedMotion;
use super::row::Row;
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

impl EvenRows {
    /// The motion of rows with their stamps, about one of `steps` (s) apart, or as `stated`. The positions are continued, and `cell` is
    /// their smallest change.
    pub(super) fn new(
        mut rows: Vec<Row>,
        settings: &LogSettings,
        steps: &[f64],
        stated: Option<f64>,
        cell: f64,
    ) -> Self {
        /// Part of the rows with the stamp before, to a part of a step, from which stamps are too coarse.
        const COARSE: f64 = 0.2;
        const SAME: f64 = 0.05;
        /// Part of the rows without a position from which position and command have stamps of their own.
        const BLANK: f64 = 0.1;
        /// Part of the rows that may have the sample of another row.
        const MAX_SHARE: f64 = 0.01;
        /// Deviation of stamps that are cut to a grid, samples: with lost rows it would grow.
        const MAX_CUT: f64 = 1.0;
        /// Bits that the clock which contradicts the stamps must save.
        const NEEDED: f64 = 10.0;
        let is_whole = |row: &Row| row.position.is_finite();
        let measured = rows.iter().filter(|row| is_whole(row));
        let stamps: Vec<f64> = measured.map(|row| row.time).collect();
        let blank = (rows.len() - stamps.len()) as f64;
        let longest = settings
            .bridge
            .max(BRIDGED)
            .max(usual_gap(&stamps, steps[0]))
            + 1;
        let is_cut = |from, to| settings.leaves_out_between(from, to);
        let clocks = |steps: &[f64]| -> Vec<Ticks> {
            let ticks = |step: &f64| Ticks::new(&stamps, *step, longest, &is_cut);
            steps.iter().map(ticks).collect()
        };
        if blank > BLANK * rows.len() as f64 {
            let own = usual_steps(stamps.iter().copied())
                .map_or(steps[0], |own| clocks(&own[..1])[0].step);
            return Self::as_stamped(&rows, settings, longest, stated.unwrap_or(own));
        }
        rows.retain(is_whole);
        let gapless = |step: &f64| Ticks::gapless(&stamps, *step, longest, &is_cut);
        if let Some(gapless) = steps.iter().find_map(gapless) {
            return Self::on_clock(rows, &gapless, stated);
        }
        let mut clocks = clocks(steps);
        clocks.retain(|ticks| ticks.doubled() <= MAX_SHARE * stamps.len() as f64);
        let likeliest = (clocks.iter()).min_by(|one, other| one.bits.total_cmp(&other.bits));
        let Some(first) = likeliest.cloned() else {
            return Self::as_stamped(&rows, settings, longest, stated.unwrap_or(steps[0]));
        };
        let complete = first.row_by_row(&stamps);
        let same = stamps
            .windows(2)
            .filter(|pair| (0.0..SAME * first.step).contains(&(pair[1] - pair[0])))
            .count() as f64;
        let is_coarse = same > COARSE * stamps.len() as f64;
        if is_coarse && settings.units.time != TimeUnit::Sample {
            return Self::on_clock(rows, &complete, stated);
        }
        if complete.jitter.largest < MAX_CUT {
            clocks.push(complete);
        }
        clocks.retain(|ticks| ticks.of != first.of);
        let is_exact = first.jitter.rms < UNEVEN;
        if is_exact && clocks.is_empty() {
            return Self::on_clock(rows, &first, stated);
        }
        let pieces = first.pieces();
        let even = |ticks: &Ticks| {
            let after = |row: usize| match ticks.of[row + 1] {
                Tick::Begins => 1.0,
                Tick::After(samples) => f64::from(samples),
            };
            bits(&rows, &pieces, first.step, cell, &after)
        };
        let after = |row: usize| (stamps[row + 1] - stamps[row]) / first.step;
        let mut best = match is_exact {
            true => (even(&first), Some(&first)),
            false => (bits(&rows, &pieces, first.step, cell, &after), None),
        };
        if !is_exact {
            clocks.insert(0, first.clone());
        }
        for ticks in &clocks {
            let even = even(ticks);
            if even + NEEDED < best.0 {
                best = (even, Some(ticks));
            }
        }
        match best.1 {
            Some(ticks) => Self::on_clock(rows, ticks, stated),
            None => Self::as_stamped(&rows, settings, longest, stated.unwrap_or(first.step)),
        }
    }

    /// Every row the sample that it is on a clock. The rows of a log without a gap stay where they are.
    fn on_clock(mut rows: Vec<Row>, ticks: &Ticks, stated: Option<f64>) -> Self {
        let mut all = Self {
            rows: Vec::new(),
            sample_time: stated.unwrap_or(ticks.step),
            clock: Clock::Even,
            jitter: ticks.jitter,
        };
        let (mut from, mut sample) = (0.0, 0.0);
        for (row, tick) in rows.iter_mut().zip(&ticks.of) {
            match tick {
                Tick::Begins => {
                    row.begins = true;
                    (from, sample) = (row.time, 0.0);
                }
                Tick::After(after) => {
                    sample += f64::from(*after);
                    if ticks.jitter.rms >= UNEVEN {
                        row.time = from + sample * all.sample_time;
                    }
                }
            }
        }
        if ticks.is_gapless() {
            all.rows = rows;
            return all;
        }
        for (row, tick) in rows.iter().zip(&ticks.of) {
            match (tick, all.rows.last().copied()) {
                (Tick::After(0), _) => continue,
                (Tick::After(after), Some(last)) => all.bridge(&last, row, *after),
                _ => {}
            }
            all.rows.push(*row);
        }
        all
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
                known_torque: between(from.known_torque, to.known_torque),
                velocity: both(from.velocity, to.velocity),
                bridged: true,
                begins: false,
            });
        }
    }

    /// The motion at even times, from rows with stamped times.
    fn as_stamped(rows: &[Row], settings: &LogSettings, longest: u32, step: f64) -> Self {
        let mut all = Self {
            sample_time: step,
            clock: Clock::Stamped,
            ..Self::default()
        };
        for piece in pieces(rows, settings, (f64::from(longest) + 0.5) * step) {
            Piece::of(&rows[piece]).resampled(step, &mut all.rows);
        }
        all
    }
}

/// The samples that are missing again and again, as between the blocks of a logger that writes in between: one more is no break.
fn usual_gap(stamps: &[f64], step: f64) -> u32 {
    /// Part of the rows with a gap before them from which it is usual, and the longest.
    const USUAL: f64 = 0.02;
    const LONGEST: f64 = 20.0;
    let mut gaps: Vec<f64> = stamps
        .windows(2)
        .map(|pair| ((pair[1] - pair[0]) / step).round())
        .filter(|gap| *gap <= LONGEST)
        .collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let place = (1.0 - USUAL) * gaps.len() as f64;
    gaps.get(place as usize).map_or(0, |gap| *gap as u32)
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

/// Bits of the motion of rows if each is so many samples before the next.
fn bits(
    rows: &[Row],
    pieces: &[Range<usize>],
    step: f64,
    cell: f64,
    after: &dyn Fn(usize) -> f64,
) -> f64 {
    /// Least and longest time to the next row, samples.
    const ALLOWED: [f64; 2] = [1e-3, 20.0];
    let mut motion = TimedMotion::default();
    for piece in pieces {
        for index in piece.clone() {
            let passed = if index + 1 < piece.end {
                after(index).clamp(ALLOWED[0], ALLOWED[1])
            } else {
                1.0
            };
            let row = &rows[index];
            motion.add(
                step * passed,
                row.position,
                row.command,
                index == piece.start,
            );
        }
    }
    motion.bits(step, cell)
}

#[cfg(test)]
mod tests {
    use super::Clock;
    use crate::log::{Log, LogError, Table};
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

    fn log(times: &[f64], positions: &[f64], commands: &[f64]) -> Log {
        read(times, positions, commands).expect("a log")
    }

    fn read(times: &[f64], positions: &[f64], commands: &[f64]) -> Result<Log, LogError> {
        let columns = [("t", times), ("q", positions), ("u", commands)];
        let columns = columns.map(|(name, column)| (name.to_owned(), column.to_vec()));
        let table = Table::of_columns("log", columns.to_vec()).expect("one length");
        let mut settings = LogSettings::with_position(Column::named("q"));
        settings.time = Some(Column::named("t"));
        settings.command = Some(Column::named("u"));
        Log::new(&table, &settings, None)
    }

    fn even() -> Vec<f64> {
        (0..ROWS).map(|row| STEP * row as f64).collect()
    }

    #[test]
    fn the_motion_says_which_clock_its_rows_have() {
        for part in [0.1, 0.25] {
            // Each step is longer or shorter, as of a loop that waits: the stamps are true.
            let mut time = 0.0;
            let mut uneven = even();
            for (row, stamp) in uneven.iter_mut().enumerate() {
                time += STEP * (1.0 + part * noise(row));
                *stamp = time;
            }
            let (commands, positions) = moved(&uneven);
            let found = log(&uneven, &positions, &commands);
            assert_eq!(found.found.clock, Clock::Stamped, "{part}");
            for row in found.rows().iter().step_by(37) {
                let after = uneven.partition_point(|time| *time <= row.time);
                let after = after.min(ROWS - 1);
                let (low, high) = (positions[after - 1], positions[after]);
                let off = (low.min(high) - row.position).max(row.position - low.max(high));
                assert!(off < 1e-3, "{off}");
            }
            // An even drive whose rows are stamped late.
            let (commands, positions) = moved(&even());
            let late: Vec<f64> = (even().iter().enumerate())
                .map(|(row, time)| time + part * STEP * noise(row))
                .collect();
            let found = log(&late, &positions, &commands);
            assert_eq!(found.found.clock, Clock::Even, "{part}");
            assert_eq!(found.rows().len(), ROWS);
            assert!((found.rows()[500].position - positions[500]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_few_single_positions_far_from_the_others_are_left_out_and_many_are_a_fault() {
        let (commands, positions) = moved(&even());
        let with = |every: usize| {
            let mut far = positions.clone();
            (far.iter_mut().skip(7).step_by(every)).for_each(|position| *position += 30.0);
            read(&even(), &far, &commands)
        };
        let found = with(500).expect("a log");
        assert_eq!((found.found.spikes, found.found.bridged), (4, 4));
        for (row, position) in found.rows().iter().zip(&positions) {
            assert!((row.position - position).abs() < 0.05, "{row:?}");
        }
        let refused = with(100).expect_err("many").to_string();
        assert!(refused.contains("20 spikes"), "{refused}");
    }

    #[test]
    fn stamps_that_are_cut_to_a_coarse_grid_are_rows_one_after_the_other() {
        let (commands, positions) = moved(&even());
        for grid in [3.0, 5.0, 10.0, 50.0].map(|steps| steps * STEP) {
            let cut = even().into_iter().map(|time| (time / grid).round() * grid);
            let found = log(&cut.collect::<Vec<_>>(), &positions, &commands);
            let shape = (found.rows().len(), found.segments().len());
            assert_eq!(shape, (ROWS, 1), "{grid}");
            assert!((found.sample_time / STEP - 1.0).abs() < 0.01, "{grid}");
            let mut both = found.rows().iter().zip(&positions);
            let same = both.all(|(row, position)| (row.position - position).abs() < 1e-12);
            assert!(same, "{grid}");
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
        let found = log(&times, &of_position, &of_command);
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
        times[700..].iter_mut().for_each(|time| *time += 0.3);
        times[1400..].iter_mut().for_each(|time| *time -= 2.0);
        let found = log(&times, &positions, &commands);
        let begins = (0..found.rows().len()).filter(|row| found.rows()[*row].begins);
        assert_eq!(begins.collect::<Vec<_>>(), [0, 700, 1400]);
    }
}
