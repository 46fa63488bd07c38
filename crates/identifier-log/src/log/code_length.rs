//! The length of a position's code: what tells whether rows are where a clock has them.
//!
//! An observer (critically damped, pole p) predicts each position from those before. Its error is regressed on the
//! observer's response to the possible causes of the motion. These are the servo's own forces (friction, damping, spring, a
//! constant) and the held command. The measure is the length of the code of the raw positions in steps of the encoder.
//! Coefficients and scale come from the other half of the blocks of rows. Bits that a command saves there are no chance.

/// A motion row by row.
#[derive(Debug, Clone, Default)]
pub(super) struct TimedMotion {
    /// Time from each row to the next, s.
    dt: Vec<f64>,
    /// True where the motion before is unknown.
    begins: Vec<bool>,
    positions: Vec<f64>,
    commands: Vec<f64>,
}

/// The forces on a servo: damping, spring, friction, a constant, the command.
const FORCES: usize = 5;
const DAMPING: usize = 0;
const SPRING: usize = 1;
const FRICTION: usize = 2;
const COMMAND: usize = 4;

impl TimedMotion {
    /// The next row, whose command lasts so long, s. Those beyond the first few thousand are left out.
    pub(super) fn add(&mut self, dt: f64, position: f64, command: Option<f64>, begins: bool) {
        const ROWS: usize = 8000;
        if self.dt.len() < ROWS {
            self.dt.push(dt);
            self.begins.push(begins);
            self.positions.push(position);
            self.commands.push(command.unwrap_or(0.0));
        }
    }

    /// The bits of the positions' code by their own past or by the command, whichever is shorter, in steps of `cell`.
    pub(super) fn bits(&self, step: f64, cell: f64) -> f64 {
        /// Poles of the observer, parts of 1/step.
        const POLES: [f64; 6] = [5.0, 1.0, 0.3, 0.1, 0.03, 0.01];
        /// The least observations.
        const MIN_TOLD: usize = 40;
        let all: f64 = self.dt.iter().sum();
        let poles = POLES.map(|part| part / step);
        let mut least = f64::INFINITY;
        for pole in poles.into_iter().filter(|pole| pole * all >= 10.0) {
            for sticks in [false, true] {
                let observed = Observed::new(self, pole, cell, sticks);
                if observed.misses.len() >= MIN_TOLD {
                    let both = [false, true].map(|is_driven| observed.bits(cell, is_driven));
                    least = least.min(both[0]).min(both[1]);
                }
            }
        }
        least
    }
}

/// The prediction errors of an observer of a motion, and its responses to the possible forces.
struct Observed {
    /// Innovations, the responses with each, and the half of the blocks that it is in.
    misses: Vec<f64>,
    responses: Vec<[f64; FORCES]>,
    folds: Vec<bool>,
}

impl Observed {
    /// That of a servo whose friction holds it at standstill, or of one that `sticks` not.
    fn new(motion: &TimedMotion, pole: f64, cell: f64, sticks: bool) -> Self {
        /// Blocks of rows that are encoded in turn.
        const BLOCKS: usize = 40;
        let rows = motion.positions.len();
        let mut observer = Observer::new(pole);
        let mut misses = Vec::with_capacity(rows);
        let mut folds = Vec::with_capacity(rows);
        let mut states = Vec::with_capacity(rows);
        let (mut squares, mut sum) = (0.0, 0.0);
        for (row, &value) in motion.positions.iter().enumerate() {
            if motion.begins[row] {
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
            sum += value;
            squares += observer.rate * observer.rate;
            states.push([observer.at, observer.rate]);
            observer.pass(motion.dt[row]);
        }
        let count = rows.max(1) as f64;
        let mean = |sum: f64| sum / count;
        let still = cell * pole + 1e-3 * mean(squares).sqrt() + f64::MIN_POSITIVE;
        let [position, command] = [sum, motion.commands.iter().sum()].map(mean);
        let force = |row: usize| -> [f64; FORCES] {
            let [at, rate] = states[row];
            let friction = -rate / (rate.abs() + still);
            let command = motion.commands[row] - command;
            // The part of a force that acts at standstill.
            let gate = if sticks {
                rate.abs() / (rate.abs() + still)
            } else {
                1.0
            };
            [-rate, position - at, friction, 1.0, command].map(|force| gate * force)
        };
        Self {
            responses: responses(motion, pole, misses.len(), force),
            misses,
            folds,
        }
    }

    /// The bits by the forces, the command's among them or not; a spring has to pay.
    fn bits(&self, cell: f64, has_command: bool) -> f64 {
        const SPRING_COSTS: f64 = 10.0;
        let with = |has_spring: bool| {
            let folds = [false, true].map(|fold| {
                let mut on = [true; FORCES];
                on[SPRING] = has_spring;
                on[COMMAND] = has_command;
                self.length(fold, &self.regression(fold, on), cell)
            });
            folds[0] + folds[1]
        };
        with(false).min(with(true) + SPRING_COSTS)
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
        const SMALL: f64 = 1e-280;
        let of = |half: bool| (0..self.misses.len()).filter(move |row| self.folds[*row] == half);
        let cumulated = |t: f64| 0.5 * t / (2.0 + t * t).sqrt();
        let bits = |lefts: &mut dyn Iterator<Item = f64>, per: f64| {
            let (mut bits, mut product) = (0.0, 1.0_f64);
            for left in lefts {
                let [from, to] = [left.abs() - 0.5 * cell, left.abs() + 0.5 * cell];
                product *= (cumulated(to * per) - cumulated(from * per)).max(LEAST);
                // A logarithm now and then, before the product is too small.
                if product < SMALL {
                    bits -= product.log2();
                    product = 1.0;
                }
            }
            bits - product.log2()
        };
        let others: Vec<f64> = of(!fold).map(|row| self.left(row, found)).collect();
        let sizes: Vec<f64> = others.iter().map(|left| left.abs()).collect();
        let usual = median(&sizes).max(0.125 * cell);
        let each = others.len().div_ceil(SAMPLED).max(1);
        let scales = (-3..7).map(|power| (usual * 2_f64.powi(power)).max(cell / 16.0));
        let total = |scale: &f64| bits(&mut others.iter().copied().step_by(each), 1.0 / scale);
        let best = scales
            .map(|scale| (total(&scale), scale))
            .min_by(|one, other| one.0.total_cmp(&other.0));
        let scale = best.map_or(1.0, |(_, scale)| scale);
        bits(&mut of(fold).map(|row| self.left(row, found)), 1.0 / scale)
    }
}

/// The observer's responses to the forces of a row, at each of its innovations.
fn responses(
    motion: &TimedMotion,
    pole: f64,
    count: usize,
    force: impl Fn(usize) -> [f64; FORCES],
) -> Vec<[f64; FORCES]> {
    let mut all = Vec::with_capacity(count);
    let mut states = [(0.0, 0.0); FORCES];
    let mut observer = Observer::new(pole);
    for (row, &value) in motion.positions.iter().enumerate() {
        if motion.begins[row] {
            observer.begin();
        }
        if observer.is_lost {
            states = [(0.0, 0.0); FORCES];
        }
        if let Some([of_at, of_rate]) = observer.correct(value, |_, gains| gains) {
            all.push(states.map(|(at, _)| at));
            for (at, rate) in &mut states {
                *rate -= of_rate * *at;
                *at -= of_at * *at;
            }
        }
        let time = motion.dt[row];
        for ((at, rate), force) in states.iter_mut().zip(force(row)) {
            *at += time * (*rate + 0.5 * force * time);
            *rate += force * time;
        }
        observer.pass(time);
    }
    all
}

/// An observer. Its pole expands at a beginning.
struct Observer {
    pole: f64,
    at: f64,
    rate: f64,
    /// Time since it began, and since its last correction, s.
    age: f64,
    since: f64,
    /// True until there is a first value.
    is_lost: bool,
}

impl Observer {
    fn new(pole: f64) -> Self {
        Self {
            pole,
            at: 0.0,
            rate: 0.0,
            age: 0.0,
            since: 0.0,
            is_lost: true,
        }
    }

    fn begin(&mut self) {
        (self.rate, self.age, self.since) = (0.0, 0.0, 0.0);
        self.is_lost = true;
    }

    /// Takes a value: what `with` makes of the gains where it corrects.
    fn correct<T>(&mut self, value: f64, with: impl FnOnce(&mut Self, [f64; 2]) -> T) -> Option<T> {
        if std::mem::take(&mut self.is_lost) {
            (self.at, self.since) = (value, 0.0);
            return None;
        }
        self.age += self.since;
        let kept = (-f64::max(self.pole, 2.0 / self.age) * self.since).exp();
        let gains = [1.0 - kept * kept, (1.0 - kept) * (1.0 - kept) / self.since];
        let taken = with(self, gains);
        self.since = 0.0;
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
