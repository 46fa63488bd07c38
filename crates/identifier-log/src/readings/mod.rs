//! Finds the measured column and its command. Readings compete by the bits that a command saves in the acceleration of the
//! column that it moves, over [time scales](log_fit::predicted): what it predicts of blocks that are left out, beside what the
//! column's own friction, damping and spring predict. No name excludes a reading; each contradiction to a name halves what its
//! bits count.

mod grid;
mod line;
mod signals;

pub(crate) use grid::{Positions, is_usual, is_whole};
use line::line;
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
    /// Bits that the command saves in the acceleration of the measured column.
    pub(crate) bits: f64,
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
        /// Doubts beyond the least with which a trial is not weighed.
        const MAX_MORE: i32 = 3;
        let least = trials
            .iter()
            .map(|trial| trial.reservation)
            .min()
            .unwrap_or(0);
        trials.retain(|trial| trial.reservation <= least + MAX_MORE);
        if trials.len() > MOST {
            let mut screened = weigh(&signals.thinned(SCREENED), &trials);
            sort(&mut screened, |reading| {
                score(reading.bits + HEARD, reading.trial.reservation)
            });
            trials = screened
                .iter()
                .take(MOST)
                .map(|reading| reading.trial)
                .collect();
        }
        let mut readings = weigh(&signals.thinned(ROWS), &trials);
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

/// The readings of some trials: the smaller saving at two time scales that follow each other, of those that save most. A
/// column by itself is predicted by the order that does it better.
fn weigh(signals: &Signals, trials: &[Trial]) -> Vec<Reading> {
    let predicted = log_fit::parallel::map(trials, |trial| signals.predicted(trial));
    let predicted: Vec<_> = predicted.collect();
    let alone = |measured: usize, span: f64| {
        let own = trials.iter().zip(&predicted);
        let own = own.filter(|(trial, _)| trial.measured == measured);
        let of_span =
            own.flat_map(|(_, all)| all.iter().filter(|of| of.span.total_cmp(&span).is_eq()));
        of_span.map(|of| of.alone).fold(f64::INFINITY, f64::min)
    };
    let readings = trials.iter().zip(&predicted).map(|(trial, all)| {
        let saved = all.iter().map(|of| {
            let ratio = alone(trial.measured, of.span) / of.driven.max(f64::MIN_POSITIVE);
            of.windows * ratio.log2()
        });
        let saved: Vec<f64> = saved.collect();
        let pairs = saved.windows(2).map(|pair| pair[0].min(pair[1]));
        Reading {
            trial: *trial,
            bits: pairs.fold(0.0, f64::max),
        }
    });
    readings.collect()
}

/// Columns that are derived from others: each with that other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Kin {
    /// Columns that hold another one over again.
    pub(crate) copies: Vec<Option<usize>>,
    /// Columns that hold another's rate.
    pub(crate) rates: Vec<Option<usize>>,
    /// Columns that hold the rate of another's rate.
    pub(crate) accelerations: Vec<Option<usize>>,
}

impl Kin {
    pub(crate) fn of(signals: &Signals) -> Self {
        const ROWS: usize = 4000;
        /// Part of the variance in which copies differ.
        const COPY: f64 = 1e-5;
        let few = signals.thinned(ROWS);
        let columns = few.columns();
        let none = vec![None; columns];
        let [mut copies, mut rates, mut accelerations] = [none.clone(), none.clone(), none];
        for column in 0..columns {
            let integral = few.integrated(few.held(column));
            let twice = few.integrated(&integral);
            for other in (0..columns).filter(|other| *other != column) {
                let is_copy = || line(few.held(column), few.held(other)).1 < COPY;
                if other < column && copies[other].is_none() && is_copy() {
                    copies[column].get_or_insert(other);
                }
                let position = few.position(other);
                if few.is_one(&position, &integral, 1) {
                    rates[column].get_or_insert(other);
                }
                if few.is_one(&position, &twice, 2) {
                    accelerations[column].get_or_insert(other);
                }
            }
        }
        Self {
            copies,
            rates,
            accelerations,
        }
    }

    /// True for a command that is derived from what it would move, or the other way.
    pub(crate) fn are(of: &[Option<usize>], measured: usize, command: usize) -> bool {
        of[command] == Some(measured) || of[measured] == Some(command)
    }
}

#[cfg(test)]
mod tests {
    use super::{Contest, HEARD, Kin, Order, Reading, Signals, Trial};

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
    fn best(columns: Vec<Vec<f64>>, cells: &[f64]) -> (Reading, bool) {
        let rows = columns[0].len();
        let count = columns.len();
        let begins = (0..rows).map(|row| row == 0).collect();
        let columns = [columns.clone(), columns];
        let signals = Signals::new(vec![STEP; rows], begins, columns, cells.to_vec());
        let mut trials = Vec::new();
        for measured in 0..count {
            for command in (0..count).filter(|command| *command != measured) {
                let trial = |order| Trial {
                    measured,
                    command,
                    order,
                    reservation: 0,
                };
                trials.extend([Order::Position, Order::Velocity].map(trial));
            }
        }
        let best = Contest::of(&signals, trials).0[0];
        (best, signals.is_reversed(&best.trial, 0.0))
    }

    #[test]
    fn a_servo_is_found_without_names_with_its_order_and_sign() {
        let [position, velocity, command, _] = servo(3000, false);
        let reversed = command.iter().map(|u| -u).collect();
        for (measured, command, order, sign, cell) in [
            (&position, &command, Order::Position, 1.0, COUNT),
            (&position, &reversed, Order::Position, -1.0, COUNT),
            (&velocity, &command, Order::Velocity, 1.0, 0.01),
        ] {
            let columns = vec![command.clone(), measured.clone()];
            let (found, is_reversed) = best(columns, &[0.01, cell]);
            let trial = (found.trial.measured, found.trial.order);
            assert_eq!(trial, (1, order), "{found:?}");
            assert!(found.bits > HEARD, "{found:?}");
            assert_eq!(is_reversed, sign < 0.0, "{found:?}");
        }
    }

    #[test]
    fn a_controller_s_fine_output_is_not_what_its_encoder_commands() {
        let [position, _, command, _] = servo(3000, true);
        let (found, _) = best(vec![command, position], &[1e-6, COUNT]);
        let trial = (found.trial.measured, found.trial.command);
        assert_eq!(trial, (1, 0), "{found:?}");
    }

    #[test]
    fn a_command_without_effect_saves_nothing() {
        let [position, ..] = servo(3000, false);
        let foreign = (0..3000).map(|row| libm::cos((row / 70) as f64 * 1.7));
        let (found, _) = best(vec![foreign.collect(), position], &[0.01, COUNT]);
        assert!(found.bits < HEARD, "{found:?}");
    }

    #[test]
    fn copies_and_rates_are_known() {
        let [position, velocity, command, _] = servo(3000, false);
        let degrees = position.iter().map(|q| q.to_degrees()).collect();
        // What an accelerometer shows, in g.
        let accelerations = velocity.windows(2).map(|pair| pair[1] - pair[0]);
        let mut accelerations: Vec<f64> = accelerations.map(|of| of / STEP / 9.806_65).collect();
        accelerations.push(0.0);
        let kin_of = |columns: Vec<Vec<f64>>| {
            let begins = (0..3000).map(|row| row == 0).collect();
            let cells = vec![COUNT; columns.len()];
            let columns = [columns.clone(), columns];
            Kin::of(&Signals::new(vec![STEP; 3000], begins, columns, cells))
        };
        let kin = kin_of(vec![position, velocity, command, degrees, accelerations]);
        assert_eq!(kin.copies, [None, None, None, Some(0), None]);
        assert_eq!((kin.rates[1], kin.rates[2]), (Some(0), None));
        let accelerations = (kin.accelerations[4], kin.accelerations[2]);
        assert_eq!(accelerations, (Some(0), None));
    }
}
