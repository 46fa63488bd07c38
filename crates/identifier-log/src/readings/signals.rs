//! The columns of a log as signals, and what their time scales say of them.

use log_fit::Predicted;

use super::Trial;
use super::line::line;

/// Columns with one time.
#[derive(Debug, Clone)]
pub(crate) struct Signals {
    /// Time from each row to the next, s.
    dt: Vec<f64>,
    /// True where the motion before is unknown.
    begins: Vec<bool>,
    /// The columns as positions, continued where they begin again, NaN where a row has no value.
    measured: Vec<Vec<f64>>,
    /// The columns as commands, held.
    held: Vec<Vec<f64>>,
    /// The usual time from row to row, s.
    step: f64,
    /// The smallest steps of the columns.
    cells: Vec<f64>,
}

/// The order of a servo's column under its command: a position twice its integral, a velocity once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    Velocity,
    Position,
}

impl Signals {
    /// From columns as positions and as commands with the time from each row to the next, s, and their smallest steps.
    pub(crate) fn new(
        dt: Vec<f64>,
        begins: Vec<bool>,
        [measured, commands]: [Vec<Vec<f64>>; 2],
        cells: Vec<f64>,
    ) -> Self {
        let mut usual = dt.clone();
        let middle = usual.len() / 2;
        let step = match usual.is_empty() {
            true => 1.0,
            false => *usual.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        let held = commands.iter().map(|column| held(column)).collect();
        Self {
            dt,
            begins,
            measured,
            held,
            step,
            cells,
        }
    }

    pub(super) fn rows(&self) -> usize {
        self.dt.len()
    }

    pub(super) fn columns(&self) -> usize {
        self.measured.len()
    }

    /// The values of a column as positions, the one before where there is none.
    pub(super) fn position(&self, column: usize) -> Vec<f64> {
        held(&self.measured[column])
    }

    pub(super) fn held(&self, column: usize) -> &[f64] {
        &self.held[column]
    }

    /// True for columns of which one is nearly a line over the other.
    pub(crate) fn are_alike(&self, one: usize, other: usize) -> bool {
        const LEFT: f64 = 0.1;
        line(&self.held[one], &self.held[other]).1 < LEFT
    }

    /// The integral of a column's values.
    pub(super) fn integrated(&self, of: &[f64]) -> Vec<f64> {
        let mut integral = 0.0;
        let rows = of.iter().zip(&self.dt);
        let all = rows.map(|(value, time)| {
            integral += value * time;
            integral
        });
        all.collect()
    }

    /// True if an integral changes as positions do, in a unit that fits: by first or second changes, since no integral is
    /// without a drift.
    pub(super) fn is_one(&self, positions: &[f64], integral: &[f64], order: usize) -> bool {
        /// Part of the deviation in which they differ, and by how much a unit may be off.
        const LEFT: f64 = 0.05;
        const UNIT: f64 = 0.1;
        /// Units of a rate for one of its position's: the same, degrees, rpm, rpm of degrees, standard gravity.
        const UNITS: [f64; 6] = [1.0, 0.017_453_3, 57.295_8, 9.549_3, 1.0 / 6.0, 0.101_972];
        /// Rows over which a change is looked at, each with its own part of noise and delay, and the fewest changes.
        const SPANS: [usize; 4] = [4, 16, 64, 256];
        const MIN_CHANGES: usize = 100;
        SPANS.iter().any(|&span| {
            let [of, by] = [positions, integral].map(|of| self.changes(of, span, order));
            let (gain, left) = line(&of, &by);
            let is_unit = UNITS.iter().any(|unit| (gain * unit - 1.0).abs() < UNIT);
            of.len() > MIN_CHANGES && is_unit && left < LEFT * LEFT
        })
    }

    /// The changes of some values over a span, the first or the second, within each motion.
    fn changes(&self, of: &[f64], span: usize, order: usize) -> Vec<f64> {
        let mut begun = 0;
        let motions = self.begins.iter().map(|begins| {
            begun += usize::from(*begins);
            begun
        });
        let motions: Vec<usize> = motions.collect();
        let ends = (0..of.len().saturating_sub(order * span))
            .filter(|from| motions[*from] == motions[from + order * span]);
        let change = |from: usize| of[from + span] - of[from];
        match order {
            1 => ends.map(change).collect(),
            _ => ends
                .map(|from| change(from + span) - change(from))
                .collect(),
        }
    }

    /// True if the command of a trial goes against the motion, by its time scales. `radian` are the column's units of a rad;
    /// zero where it is no angle.
    pub(crate) fn is_reversed(&self, trial: &Trial, radian: f64) -> bool {
        const ROWS: usize = 4000;
        let radian = radian / self.cells[trial.measured];
        let scales = self
            .thinned(ROWS)
            .motion(trial, |positions, commands, begins| {
                log_fit::scales_of(positions, commands, begins, radian)
            });
        log_fit::surest(&scales)
            .is_some_and(|scale| scale.values.get(log_fit::fit::Effect::B) < 0.0)
    }

    /// What the command of a trial predicts of the measured column, in its smallest steps.
    pub(super) fn predicted(&self, trial: &Trial) -> Vec<Predicted> {
        let mut found = self.motion(trial, log_fit::predicted);
        // The prediction of a velocity is one of the first order.
        for of in found.iter_mut().filter(|_| trial.order == Order::Velocity) {
            for missed in [&mut of.driven, &mut of.alone] {
                *missed *= 4.0 / of.span;
            }
        }
        found
    }

    /// Hands over the positions of a trial in its smallest steps, its command, and the rows at which a motion begins.
    fn motion<T>(&self, trial: &Trial, to: impl Fn(&[f64], &[f64], &[usize]) -> T) -> T {
        let cell = self.cells[trial.measured];
        let measured = self.position(trial.measured);
        let (positions, count) = match trial.order {
            Order::Position => (measured, cell),
            Order::Velocity => (self.integrated(&measured), cell * self.step),
        };
        let positions: Vec<f64> = positions.iter().map(|position| position / count).collect();
        let begins = (0..self.rows()).filter(|row| *row == 0 || self.begins[*row]);
        to(
            &positions,
            self.held(trial.command),
            &begins.collect::<Vec<_>>(),
        )
    }

    /// At most this number of rows: every r-th value as measured. A held column has the mean of the rows between.
    pub(super) fn thinned(&self, most: usize) -> Self {
        let each = self.rows().div_ceil(most).max(1);
        if each == 1 {
            return self.clone();
        }
        let whole = self.rows() / each;
        let groups = || (0..whole).map(|group| group * each..(group + 1) * each);
        let sum = |of: &[f64]| of.iter().sum::<f64>();
        let mean = |column: &Vec<f64>| {
            groups()
                .map(|rows| {
                    let weighted = rows.clone().map(|row| self.dt[row] * column[row]);
                    weighted.sum::<f64>() / sum(&self.dt[rows])
                })
                .collect()
        };
        Self {
            dt: groups().map(|rows| sum(&self.dt[rows])).collect(),
            begins: groups()
                .map(|rows| self.begins[rows].iter().any(|begins| *begins))
                .collect(),
            measured: (self.measured.iter())
                .map(|column| groups().map(|rows| column[rows.start]).collect())
                .collect(),
            held: self.held.iter().map(mean).collect(),
            step: self.step * each as f64,
            cells: self.cells.clone(),
        }
    }
}

/// The values of a column, the one before where there is none.
pub(crate) fn held(column: &[f64]) -> Vec<f64> {
    let mut last = 0.0;
    let hold = |value: &f64| {
        if value.is_finite() {
            last = *value;
        }
        last
    };
    column.iter().map(hold).collect()
}
