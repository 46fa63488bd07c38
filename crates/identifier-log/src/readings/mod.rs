//! Finds the measured column and its command. Readings compete by the bits that a command saves in the code of the
//! column that it moves. No name excludes a reading; each contradiction to a name halves what its bits count.
//!
//! A servo integrates. The information of a command some rows ahead is four times as large at four times as many rows.
//! A controller's fine output contains information about its own encoder only one row ahead. So the smaller saving of
//! two neighbouring thinnings counts.

mod grid;
mod line;
mod signals;

pub(crate) use grid::{Positions, is_usual, is_whole};
use line::line;
use signals::{Effort, Told};
pub(crate) use signals::{Order, Signals, held};

/// A measured column, the column that may command it, and the contradictions to their names.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trial {
    pub(crate) measured: usize,
    pub(crate) command: usize,
    pub(crate) order: Order,
    pub(crate) reservation: i32,
}

/// A trial with its evidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reading {
    pub(crate) trial: Trial,
    /// Bits that the command saves in the measured column.
    pub(crate) bits: f64,
    /// The effect of a unit of the command, measured units per s or s².
    pub(crate) gain: f64,
    /// True if the command goes against the motion, some rows ahead and four times as many.
    pub(crate) is_reversed: bool,
}

/// Bits below which a command has left no trace in a column.
pub(crate) const HEARD: f64 = 30.0;

impl Reading {
    /// A rival with this part of the score makes the reading ambiguous, with and without names that favour the reading.
    /// A column that was computed from others is predicted well by them.
    const NEAR: [f64; 2] = [1.0 / 1.5, 0.125];
    /// Doubts beyond which names speak against all readings.
    const MAX_RESERVATION: i32 = 2;

    /// Its bits, halved for each mismatch of a name. All bits of an incomplete servo are too many by about one factor.
    pub(crate) fn score(&self) -> f64 {
        score(self.bits, self.trial.reservation)
    }

    /// True if another reading that shares a column explains nearly as much. `is_named` is true if names favour this
    /// one.
    pub(crate) fn is_rivalled_by(&self, other: &Self, is_named: bool) -> bool {
        let pair = |of: &Self| [of.trial.measured, of.trial.command];
        let shares = pair(self).iter().any(|column| pair(other).contains(column));
        let near = Self::NEAR[usize::from(!is_named)];
        pair(self) != pair(other) && shares && other.score() > near * self.score()
    }

    /// True if it is no more than an appearance.
    pub(crate) fn is_ambiguous(&self) -> bool {
        self.trial.reservation > Self::MAX_RESERVATION || self.score() < 0.5 * HEARD
    }
}

/// The readings, the best first.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Contest(pub(crate) Vec<Reading>);

impl Contest {
    /// Lets the trials compete.
    pub(crate) fn of(signals: &Signals, mut trials: Vec<Trial>) -> Self {
        /// Trials that are weighed thoroughly, of more those that a screen over fewer rows finds.
        const MOST: usize = 12;
        const ROWS: usize = 4000;
        const SCREENED: usize = 1000;
        /// Doubts beyond the least with which a trial is not screened.
        const MAX_MORE: i32 = 3;
        if trials.len() > MOST {
            let least = trials
                .iter()
                .map(|trial| trial.reservation)
                .min()
                .unwrap_or(0);
            trials.retain(|trial| trial.reservation <= least + MAX_MORE);
            let mut screened = weigh(&signals.thinned(SCREENED), &trials, Effort::SCREEN);
            sort(&mut screened, |reading| {
                score(reading.bits + HEARD, reading.trial.reservation)
            });
            trials = screened
                .iter()
                .take(MOST)
                .map(|reading| reading.trial)
                .collect();
        }
        let mut readings = weigh(&signals.thinned(ROWS), &trials, Effort::WHOLE);
        let before = readings.clone();
        for reading in &mut readings {
            // A command that another column moves is measured itself.
            let is_moved = before.iter().any(|other| {
                other.trial.measured == reading.trial.command
                    && other.trial.command != reading.trial.measured
                    && other.bits > HEARD.max(0.25 * reading.bits)
            });
            reading.trial.reservation += i32::from(is_moved);
        }
        sort(&mut readings, Reading::score);
        Self(readings)
    }
}

/// Sorts a few readings, the largest first.
fn sort(readings: &mut [Reading], by: impl Fn(&Reading) -> f64) {
    for end in 1..readings.len() {
        let mut place = end;
        while place > 0 && by(&readings[place]) > by(&readings[place - 1]) {
            readings.swap(place, place - 1);
            place -= 1;
        }
    }
}

fn score(bits: f64, reservation: i32) -> f64 {
    bits.max(1.0) * 0.5_f64.powi(reservation)
}

fn weigh(signals: &Signals, trials: &[Trial], effort: Effort) -> Vec<Reading> {
    let mut measured: Vec<usize> = Vec::new();
    for trial in trials {
        if let Err(place) = measured.binary_search(&trial.measured) {
            measured.insert(place, trial.measured);
        }
    }
    let weighed = log_fit::parallel::map(&measured, |column| {
        let own = trials.iter().filter(|trial| trial.measured == *column);
        weigh_column(signals, *column, own.copied(), effort)
    });
    weighed.flatten().collect()
}

/// The readings of one measured column.
fn weigh_column(
    signals: &Signals,
    column: usize,
    trials: impl Iterator<Item = Trial>,
    effort: Effort,
) -> Vec<Reading> {
    let trials: Vec<Trial> = trials.collect();
    let orders = [Order::Position, Order::Velocity];
    let told = orders.map(|order| {
        let own = trials.iter().filter(|trial| trial.order == order);
        let own: Vec<Trial> = own.copied().collect();
        let commands: Vec<usize> = own.iter().map(|trial| trial.command).collect();
        (signals.tell(column, &commands, order, effort), own)
    });
    let alone: Vec<f64> = (0..told[0].0.alone.len().max(told[1].0.alone.len()))
        .map(|place| {
            let bits = |told: &Told| {
                told.alone
                    .get(place)
                    .map_or(f64::INFINITY, |code| code.bits)
            };
            told.iter()
                .map(|(told, _)| bits(told))
                .fold(f64::INFINITY, f64::min)
        })
        .collect();
    let readings = told.iter().flat_map(|(told, own)| {
        own.iter().zip(&told.moved).filter_map(|(trial, codes)| {
            let saved: Vec<f64> = (alone.iter().zip(codes))
                .map(|(alone, code)| alone - code.bits)
                .collect();
            let pairs = saved.windows(2).enumerate().map(|(place, pair)| {
                let better = place + usize::from(pair[1] > pair[0]);
                (pair[0].min(pair[1]), better)
            });
            let only = (saved.len() == 1).then(|| (saved[0], 0));
            let (bits, place) = pairs
                .chain(only)
                .max_by(|one, other| one.0.total_cmp(&other.0))?;
            let beside = codes
                .get(place + 1)
                .or_else(|| codes.get(place.checked_sub(1)?));
            Some(Reading {
                trial: *trial,
                bits: if bits.is_finite() { bits } else { 0.0 },
                gain: codes[place].gain,
                is_reversed: codes[place].gain < 0.0 && beside.is_none_or(|code| code.gain < 0.0),
            })
        })
    });
    readings.collect()
}

/// Columns that hold another one over again, and columns that hold another's rate: each with that other.
pub(crate) fn kin(signals: &Signals) -> (Vec<Option<usize>>, Vec<Option<usize>>) {
    const ROWS: usize = 4000;
    /// Part of the variance in which copies differ, and a rate from its position's.
    const COPY: f64 = 1e-5;
    const RATE: f64 = 0.05;
    /// Units of a rate for one of its position's: the same, degrees, rpm, rpm of degrees.
    const UNITS: [f64; 5] = [1.0, 0.017_453_3, 57.295_8, 9.549_3, 1.0 / 6.0];
    let few = signals.thinned(ROWS);
    let columns = few.columns();
    let (mut copies, mut rates) = (vec![None; columns], vec![None; columns]);
    for column in 0..columns {
        for other in (0..columns).filter(|other| *other != column) {
            let (of, by) = (few.held(column), few.held(other));
            if other < column && copies[other].is_none() && line(of, by).1 < COPY {
                copies[column].get_or_insert(other);
            }
            let mut integral = 0.0;
            let integrals: Vec<f64> = (of.iter().zip(few.dt()))
                .map(|(rate, time)| {
                    integral += rate * time;
                    integral
                })
                .collect();
            let (gain, left) = line(by, &integrals);
            let is_unit = UNITS.iter().any(|unit| (gain * unit - 1.0).abs() < 0.05);
            if is_unit && left < RATE * RATE {
                rates[column].get_or_insert(other);
            }
        }
    }
    (copies, rates)
}

#[cfg(test)]
mod tests {
    use super::{Contest, HEARD, Order, Reading, Signals, Trial, kin};

    const STEP: f64 = 2e-3;
    const COUNT: f64 = 0.001;

    /// Position, velocity and command of a servo in rows. It is in open loop, or under a controller that follows
    /// levels, which are the last column.
    fn servo(rows: usize, is_controlled: bool) -> [Vec<f64>; 4] {
        let [mut position, mut velocity, mut command, mut goal] = [const { Vec::new() }; 4];
        let (mut q, mut v) = (0.0_f64, 0.0_f64);
        for row in 0..rows {
            let level = libm::sin((row / 100) as f64 * 2.3) * 4.0;
            let counts = (q / COUNT).round() * COUNT;
            let u = match is_controlled {
                true => 6.0 * (level - counts) - 0.3 * v,
                false => level,
            };
            position.push(counts);
            velocity.push((v / 0.01).round() * 0.01);
            command.push(u);
            goal.push(level);
            for _ in 0..20 {
                let friction = 5.0 * v.clamp(-0.01, 0.01) / 0.01;
                v += STEP / 20.0 * (100.0 * u - 8.0 * v - friction);
                q += STEP / 20.0 * v;
            }
        }
        [position, velocity, command, goal]
    }

    /// The best of all readings of some columns without names.
    fn best(columns: Vec<Vec<f64>>, cells: &[f64]) -> Reading {
        let rows = columns[0].len();
        let count = columns.len();
        let begins = (0..rows).map(|row| row == 0).collect();
        let signals = Signals::new(vec![STEP; rows], begins, columns, cells.to_vec());
        let mut trials = Vec::new();
        for measured in 0..count {
            for command in (0..count).filter(|command| *command != measured) {
                for order in [Order::Position, Order::Velocity] {
                    trials.push(Trial {
                        measured,
                        command,
                        order,
                        reservation: 0,
                    });
                }
            }
        }
        Contest::of(&signals, trials).0[0]
    }

    #[test]
    fn a_servo_is_found_without_names_with_its_order_and_sign() {
        let [position, velocity, command, _] = servo(3000, false);
        let reversed = command.iter().map(|u| -u).collect();
        for (measured, command, order, sign, cell) in [
            (
                position.clone(),
                command.clone(),
                Order::Position,
                1.0,
                COUNT,
            ),
            (position, reversed, Order::Position, -1.0, COUNT),
            (velocity, command, Order::Velocity, 1.0, 0.01),
        ] {
            let found = best(vec![command, measured], &[0.01, cell]);
            assert_eq!(
                (found.trial.measured, found.trial.order),
                (1, order),
                "{found:?}"
            );
            assert!(found.bits > HEARD && found.gain * sign > 0.0, "{found:?}");
        }
    }

    #[test]
    fn a_controller_s_fine_output_is_not_what_its_encoder_commands() {
        let [position, _, command, _] = servo(3000, true);
        let found = best(vec![command, position], &[1e-6, COUNT]);
        assert_eq!(
            (found.trial.measured, found.trial.command),
            (1, 0),
            "{found:?}"
        );
    }

    #[test]
    fn a_command_without_effect_saves_nothing() {
        let [position, ..] = servo(3000, false);
        let foreign = (0..3000)
            .map(|row| libm::cos((row / 70) as f64 * 1.7))
            .collect();
        let found = best(vec![foreign, position], &[0.01, COUNT]);
        assert!(found.bits < HEARD, "{found:?}");
    }

    #[test]
    fn copies_and_rates_are_known() {
        let [position, velocity, command, _] = servo(3000, false);
        let degrees = position.iter().map(|q| q.to_degrees()).collect();
        let columns = vec![position, velocity, command, degrees];
        let begins = (0..3000).map(|row| row == 0).collect();
        let signals = Signals::new(vec![STEP; 3000], begins, columns, vec![COUNT; 4]);
        let (copies, rates) = kin(&signals);
        assert_eq!(copies, [None, None, None, Some(0)]);
        assert_eq!((rates[1], rates[2]), (Some(0), None));
    }
}
