//! The columns of a log as signals, and the bits of a column's code.
//!
//! An observer of a column (critically damped, pole p) predicts each of its values from those before. Its error is
//! regressed on the observer's response to the possible causes of the motion. These are the column's own forces
//! (friction, damping, spring, a constant) and the held command. The measure is the length of the code of the raw
//! column in cells of its smallest step. Coefficients and scale come from the other half of the blocks of rows. Bits
//! that a command saves there are no chance.

use super::line::line;

/// Columns with one time.
#[derive(Debug, Clone, Default)]
pub(crate) struct Signals {
    /// Time from each row to the next, s.
    dt: Vec<f64>,
    /// True where the motion before is unknown.
    begins: Vec<bool>,
    /// The columns as measured, NaN where a row has no value, and held.
    measured: Vec<Vec<f64>>,
    held: Vec<Vec<f64>>,
    /// The usual time from row to row, s.
    step: f64,
    /// The smallest steps of the columns.
    cells: Vec<f64>,
}

/// The order of a servo's column under its command: a position twice its integral, a velocity once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    Velocity = 1,
    Position = 2,
}

/// The effort of encoding a column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Poles of the observer, parts of 1/(row step).
    pub(super) poles: &'static [f64],
    /// One row in this number is encoded.
    pub(super) thinnings: &'static [usize],
    /// With static friction, too.
    pub(super) sticks: bool,
}

impl Effort {
    pub(super) const WHOLE: Self = Self {
        poles: &[5.0, 1.0, 0.3, 0.1, 0.03, 0.01],
        thinnings: &[1, 4, 16, 64],
        sticks: true,
    };
    pub(super) const SCREEN: Self = Self {
        poles: &[1.0, 0.1],
        thinnings: &[1, 4],
        sticks: false,
    };
}

/// The forces on a column, one of its rows each: damping, spring, friction, a constant, the command.
const FORCES: usize = 5;
const DAMPING: usize = 0;
const SPRING: usize = 1;
const FRICTION: usize = 2;
const COMMAND: usize = 4;

/// The code of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Code {
    pub(super) bits: f64,
    /// The effect of a unit of the command, column units per s or s².
    pub(super) gain: f64,
}

impl Code {
    const NONE: Self = Self {
        bits: f64::INFINITY,
        gain: 0.0,
    };

    fn shorter(self, other: Self) -> Self {
        if other.bits < self.bits { other } else { self }
    }
}

/// The codes of a column at each thinning.
#[derive(Debug, Clone)]
pub(super) struct Told {
    /// By its own past alone.
    pub(super) alone: Vec<Code>,
    /// By each command.
    pub(super) moved: Vec<Vec<Code>>,
}

impl Signals {
    /// From columns with the time from each row to the next, s, and their smallest steps.
    pub(crate) fn new(
        dt: Vec<f64>,
        begins: Vec<bool>,
        measured: Vec<Vec<f64>>,
        cells: Vec<f64>,
    ) -> Self {
        let mut usual = dt.clone();
        let middle = usual.len() / 2;
        let step = match usual.is_empty() {
            true => 1.0,
            false => *usual.select_nth_unstable_by(middle, f64::total_cmp).1,
        };
        let held = measured.iter().map(|column| held(column)).collect();
        Self {
            dt,
            begins,
            measured,
            held,
            step,
            cells,
        }
    }

    /// The next row of a position and the command that moves it, which lasts so long, s.
    pub(crate) fn add(&mut self, dt: f64, position: f64, command: Option<f64>, begins: bool) {
        self.dt.push(dt);
        self.begins.push(begins);
        self.measured.resize(2, Vec::new());
        self.measured[0].push(position);
        self.measured[1].push(command.unwrap_or(0.0));
    }

    /// The bits of the position's code given its command, row by row.
    pub(crate) fn told(self, step: f64, cell: f64) -> f64 {
        /// Rows that are encoded: the first ones.
        const ROWS: usize = 8000;
        const EACH: Effort = Effort {
            thinnings: &[1],
            ..Effort::WHOLE
        };
        let Self {
            mut dt,
            mut begins,
            mut measured,
            ..
        } = self;
        dt.truncate(ROWS);
        begins.truncate(ROWS);
        measured.iter_mut().for_each(|column| column.truncate(ROWS));
        let mut signals = Self::new(dt, begins, measured, vec![cell; 2]);
        signals.step = step;
        let told = signals.tell(0, &[1], Order::Position, EACH);
        let all = told.alone.iter().chain(told.moved.iter().flatten());
        all.map(|code| code.bits).fold(f64::INFINITY, f64::min)
    }

    pub(super) fn rows(&self) -> usize {
        self.dt.len()
    }

    pub(super) fn columns(&self) -> usize {
        self.measured.len()
    }

    pub(super) fn held(&self, column: usize) -> &[f64] {
        &self.held[column]
    }

    /// True for columns of which one is nearly a line over the other.
    pub(crate) fn are_alike(&self, one: usize, other: usize) -> bool {
        const LEFT: f64 = 0.1;
        line(&self.held[one], &self.held[other]).1 < LEFT
    }

    pub(super) fn dt(&self) -> &[f64] {
        &self.dt
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

    /// The codes of a column by itself and by each of some commands.
    pub(super) fn tell(
        &self,
        column: usize,
        commands: &[usize],
        order: Order,
        effort: Effort,
    ) -> Told {
        /// Fewest values of a thinning, and the least observations.
        const MIN_VALUES: usize = 100;
        const MIN_TOLD: usize = 40;
        let values = self.measured[column]
            .iter()
            .filter(|value| value.is_finite());
        let values = values.count();
        let all: f64 = self.dt.iter().sum();
        let mut told = Told {
            alone: Vec::new(),
            moved: vec![Vec::new(); commands.len()],
        };
        for &thinning in effort.thinnings {
            if thinning > 1 && values / thinning < MIN_VALUES {
                break;
            }
            let mut alone = Code::NONE;
            let mut moved = vec![Code::NONE; commands.len()];
            for &part in effort.poles {
                let pole = part / (self.step * thinning as f64);
                if pole * all < 10.0 {
                    continue;
                }
                for sticks in [false, true] {
                    if sticks && !effort.sticks {
                        continue;
                    }
                    let mut observed = Observed::new(self, column, order, pole, thinning, sticks);
                    if observed.misses.len() < MIN_TOLD {
                        continue;
                    }
                    alone = alone.shorter(observed.code(self.cells[column], false));
                    for (place, &command) in commands.iter().enumerate() {
                        observed.move_by(self, column, &self.held[command]);
                        moved[place] =
                            moved[place].shorter(observed.code(self.cells[column], true));
                    }
                }
            }
            told.alone.push(alone);
            for (all, code) in told.moved.iter_mut().zip(moved) {
                all.push(code);
            }
        }
        told
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

/// The prediction errors of an observer of a column, and its responses to the possible forces.
struct Observed {
    order: Order,
    pole: f64,
    thinning: usize,
    /// Innovations, the responses with each, and the half of the blocks that it is in.
    misses: Vec<f64>,
    responses: Vec<[f64; FORCES]>,
    folds: Vec<bool>,
    /// The part of a force that acts at standstill, for each row. It is all of the force without static friction.
    gate: Vec<f64>,
}

impl Observed {
    fn new(
        signals: &Signals,
        column: usize,
        order: Order,
        pole: f64,
        thinning: usize,
        sticks: bool,
    ) -> Self {
        /// Blocks of rows that are encoded in turn.
        const BLOCKS: usize = 40;
        let values = &signals.measured[column];
        let rows = values.len();
        let mut observer = Observer::new(order, pole, thinning);
        let mut misses = Vec::with_capacity(rows);
        let mut folds = Vec::with_capacity(rows);
        let mut states = Vec::with_capacity(rows);
        let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
        for row in 0..rows {
            let value = values[row];
            if signals.begins[row] {
                observer.begin();
            }
            let told = observer.correct(value, |observer, gains| {
                let miss = value - observer.at;
                observer.at += gains[0] * miss;
                observer.rate += gains[1] * miss;
                miss
            });
            if let Some(miss) = told {
                misses.push(miss);
                folds.push(row * BLOCKS / rows % 2 == 1);
            }
            if value.is_finite() {
                sum += value;
                count += 1.0;
            }
            let rate = match order {
                Order::Position => observer.rate,
                Order::Velocity => observer.at,
            };
            squares += rate * rate;
            states.push([observer.at, rate]);
            observer.pass(signals.dt[row]);
        }
        let mean = sum / f64::max(count, 1.0);
        let per_step = match order {
            Order::Position => pole,
            Order::Velocity => 2.0,
        };
        let still = signals.cells[column] * per_step
            + 1e-3 * (squares / rows.max(1) as f64).sqrt()
            + f64::MIN_POSITIVE;
        let moves = |rate: f64| rate.abs() / (rate.abs() + still);
        let gate: Vec<f64> = (states.iter())
            .map(|[_, rate]| if sticks { moves(*rate) } else { 1.0 })
            .collect();
        let mut observed = Self {
            order,
            pole,
            thinning,
            responses: vec![[0.0; FORCES]; misses.len()],
            misses,
            folds,
            gate,
        };
        let gate = std::mem::take(&mut observed.gate);
        observed.respond(signals, column, 0, &|row, forces| {
            let [at, rate] = states[row];
            let friction = -rate / (rate.abs() + still);
            for (force, own) in forces.iter_mut().zip([-rate, mean - at, friction, 1.0]) {
                *force = own * gate[row];
            }
        });
        observed.gate = gate;
        observed
    }

    /// Puts a command in the place of the last.
    fn move_by(&mut self, signals: &Signals, column: usize, command: &[f64]) {
        let mean = command.iter().sum::<f64>() / command.len().max(1) as f64;
        let gate = std::mem::take(&mut self.gate);
        self.respond(signals, column, COMMAND, &|row, forces| {
            forces[0] = (command[row] - mean) * gate[row];
        });
        self.gate = gate;
    }

    /// The observer's responses to what sets the forces of a row, kept from a place on.
    fn respond(
        &mut self,
        signals: &Signals,
        column: usize,
        place: usize,
        force: &dyn Fn(usize, &mut [f64]),
    ) {
        let count = if place == COMMAND { 1 } else { COMMAND };
        let mut states = [(0.0, 0.0); COMMAND];
        let mut forces = [0.0; COMMAND];
        let mut observer = Observer::new(self.order, self.pole, self.thinning);
        let mut told = 0;
        for (row, value) in signals.measured[column].iter().enumerate() {
            if signals.begins[row] {
                observer.begin();
            }
            let is_first = value.is_finite() && observer.is_lost;
            let gains = observer.correct(*value, |_, gains| gains);
            if is_first || signals.begins[row] {
                states = [(0.0, 0.0); COMMAND];
            }
            if let Some([of_at, of_rate]) = gains {
                let kept = &mut self.responses[told][place..place + count];
                for (response, (at, rate)) in kept.iter_mut().zip(&mut states) {
                    *response = *at;
                    *rate -= of_rate * *at;
                    *at -= of_at * *at;
                }
                told += 1;
            }
            let time = signals.dt[row];
            force(row, &mut forces);
            for ((at, rate), force) in states[..count].iter_mut().zip(forces) {
                match self.order {
                    Order::Position => {
                        *at += time * (*rate + 0.5 * force * time);
                        *rate += force * time;
                    }
                    Order::Velocity => *at += force * time,
                }
            }
            observer.pass(time);
        }
    }

    /// The code by the forces, the command's among them or not; a spring has to pay.
    fn code(&self, cell: f64, has_command: bool) -> Code {
        const SPRING_COSTS: f64 = 10.0;
        let with = |has_spring: bool, costs: f64| {
            let mut bits = costs;
            let mut gain = 0.0;
            for fold in [false, true] {
                let mut on = [true; FORCES];
                on[SPRING] = has_spring && self.order == Order::Position;
                on[COMMAND] = has_command;
                let found = self.regression(fold, on);
                bits += self.length(fold, &found, cell);
                gain += 0.5 * found[COMMAND];
            }
            Code { bits, gain }
        };
        let plain = with(false, 0.0);
        match self.order {
            Order::Position => plain.shorter(with(true, SPRING_COSTS)),
            Order::Velocity => plain,
        }
    }

    fn left(&self, row: usize, found: &[f64; FORCES]) -> f64 {
        let told =
            (self.responses[row].iter().zip(found)).map(|(response, force)| response * force);
        self.misses[row] - told.sum::<f64>()
    }

    /// Robust least squares over the rows of the other half. A force that can only brake is set to zero if it would
    /// drive.
    fn regression(&self, fold: bool, mut on: [bool; FORCES]) -> [f64; FORCES] {
        const TURNS: usize = 3;
        const WEIGHINGS: usize = 3;
        let rows: Vec<usize> = (0..self.misses.len())
            .filter(|row| self.folds[*row] != fold)
            .collect();
        let mut scales = [0.0; FORCES];
        for row in &rows {
            for (scale, response) in scales.iter_mut().zip(&self.responses[*row]) {
                *scale += response * response;
            }
        }
        let scales = scales.map(|sum| (sum / rows.len().max(1) as f64).sqrt() + f64::MIN_POSITIVE);
        let mut found = [0.0; FORCES];
        let mut sizes = vec![0.0; rows.len()];
        for _ in 0..TURNS {
            let mut weights = vec![1.0; rows.len()];
            for _ in 0..WEIGHINGS {
                found = self.solved(&rows, &weights, &scales, on);
                let mut squares = 0.0;
                for (size, row) in sizes.iter_mut().zip(&rows) {
                    *size = self.left(*row, &found).abs();
                    squares += *size * *size;
                }
                let rms = (squares / rows.len().max(1) as f64).sqrt();
                let usual = 4.5 * median(&sizes) + 0.3 * rms + f64::MIN_POSITIVE;
                for (weight, size) in weights.iter_mut().zip(&sizes) {
                    *weight = 1.0 / (1.0 + (size / usual) * (size / usual));
                }
            }
            let drives = [DAMPING, SPRING, FRICTION].map(|force| on[force] && found[force] < 0.0);
            if drives == [false; 3] {
                break;
            }
            for (on, drives) in on.iter_mut().zip(drives) {
                *on &= !drives;
            }
        }
        found
    }

    fn solved(
        &self,
        rows: &[usize],
        weights: &[f64],
        scales: &[f64; FORCES],
        on: [bool; FORCES],
    ) -> [f64; FORCES] {
        const RIDGE: f64 = 1e-8;
        let mut gram = [[0.0; FORCES]; FORCES];
        let mut right = [0.0; FORCES];
        for (row, weight) in rows.iter().zip(weights) {
            let response = &self.responses[*row];
            let miss = weight * self.misses[*row];
            for i in 0..FORCES {
                right[i] += miss * response[i];
                let weighted = weight * response[i];
                for j in 0..=i {
                    gram[i][j] += weighted * response[j];
                }
            }
        }
        for i in 0..FORCES {
            right[i] = if on[i] { right[i] / scales[i] } else { 0.0 };
            for j in 0..=i {
                let is_on = on[i] && on[j];
                gram[i][j] = if is_on {
                    gram[i][j] / (scales[i] * scales[j])
                } else {
                    0.0
                };
            }
            gram[i][i] += if on[i] {
                RIDGE * rows.len() as f64
            } else {
                1.0
            };
        }
        let mut found = cholesky(gram, right);
        for (force, scale) in found.iter_mut().zip(scales) {
            *force /= scale;
        }
        found
    }

    /// Bits of the rows of a half, with the scale of the other half. The distribution is Student's with two degrees of
    /// freedom, whose sums over a cell have a closed form.
    fn length(&self, fold: bool, found: &[f64; FORCES], cell: f64) -> f64 {
        const SAMPLED: usize = 1000;
        const LEAST: f64 = 1e-12;
        let of = |half: bool| (0..self.misses.len()).filter(move |row| self.folds[*row] == half);
        let cumulated = |t: f64| 0.5 * t / (2.0 + t * t).sqrt();
        let bits = |left: f64, scale: f64| {
            let left = left.abs();
            let inside =
                cumulated((left + 0.5 * cell) / scale) - cumulated((left - 0.5 * cell) / scale);
            -(inside.max(LEAST)).log2()
        };
        let others: Vec<f64> = of(!fold).map(|row| self.left(row, found)).collect();
        let sizes: Vec<f64> = others.iter().map(|left| left.abs()).collect();
        let usual = median(&sizes).max(0.125 * cell);
        let each = others.len().div_ceil(SAMPLED).max(1);
        let scales = (-3..7).map(|power| (usual * 2_f64.powi(power)).max(cell / 16.0));
        let total = |scale: &f64| {
            let sampled = others.iter().step_by(each);
            sampled.map(|left| bits(*left, *scale)).sum::<f64>()
        };
        let best = scales
            .map(|scale| (total(&scale), scale))
            .min_by(|one, other| one.0.total_cmp(&other.0));
        let scale = best.map_or(1.0, |(_, scale)| scale);
        of(fold).map(|row| bits(self.left(row, found), scale)).sum()
    }
}

/// An observer that is corrected at every n-th value. Its pole expands at a beginning.
struct Observer {
    order: Order,
    pole: f64,
    thinning: usize,
    at: f64,
    rate: f64,
    /// Time since it began, and since its last correction, s.
    age: f64,
    since: f64,
    values: usize,
    /// True until there is a first value.
    is_lost: bool,
}

impl Observer {
    fn new(order: Order, pole: f64, thinning: usize) -> Self {
        Self {
            order,
            pole,
            thinning,
            at: 0.0,
            rate: 0.0,
            age: 0.0,
            since: 0.0,
            values: 0,
            is_lost: true,
        }
    }

    fn begin(&mut self) {
        (self.rate, self.age, self.since) = (0.0, 0.0, 0.0);
        self.is_lost = true;
    }

    /// Takes a value: what `with` makes of the gains where it corrects.
    fn correct<T>(&mut self, value: f64, with: impl FnOnce(&mut Self, [f64; 2]) -> T) -> Option<T> {
        if value.is_nan() {
            return None;
        }
        if std::mem::take(&mut self.is_lost) {
            (self.at, self.since, self.values) = (value, 0.0, 0);
            return None;
        }
        self.values += 1;
        if self.values < self.thinning {
            return None;
        }
        self.age += self.since;
        let kept = (-f64::max(self.pole, 2.0 / self.age) * self.since).exp();
        let gains = match self.order {
            Order::Position => [1.0 - kept * kept, (1.0 - kept) * (1.0 - kept) / self.since],
            Order::Velocity => [1.0 - kept, 0.0],
        };
        let taken = with(self, gains);
        (self.since, self.values) = (0.0, 0);
        Some(taken)
    }

    fn pass(&mut self, time: f64) {
        self.at += time * self.rate;
        self.since += time;
    }
}

/// The middle of some numbers, zero of none.
fn median(numbers: &[f64]) -> f64 {
    let mut sorted = numbers.to_vec();
    let middle = sorted.len() / 2;
    match sorted.is_empty() {
        true => 0.0,
        false => *sorted.select_nth_unstable_by(middle, f64::total_cmp).1,
    }
}

/// The solution of symmetric equations, by the lower half of a positive definite matrix.
fn cholesky(mut gram: [[f64; FORCES]; FORCES], mut right: [f64; FORCES]) -> [f64; FORCES] {
    for i in 0..FORCES {
        for j in 0..=i {
            let products = (0..j).map(|k| gram[i][k] * gram[j][k]);
            let rest = gram[i][j] - products.sum::<f64>();
            gram[i][j] = if i == j {
                rest.max(f64::MIN_POSITIVE).sqrt()
            } else {
                rest / gram[j][j]
            };
        }
    }
    for i in 0..FORCES {
        let products = (0..i).map(|k| gram[i][k] * right[k]);
        right[i] = (right[i] - products.sum::<f64>()) / gram[i][i];
    }
    for i in (0..FORCES).rev() {
        let products = (i + 1..FORCES).map(|k| gram[k][i] * right[k]);
        right[i] = (right[i] - products.sum::<f64>()) / gram[i][i];
    }
    right
}
