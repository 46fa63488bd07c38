//! Least squares over the windows of a time scale, and what is predicted of blocks of them that are left out.

use super::windows::{Bins, Column, Window};
use crate::fit::{MAX_UNKNOWNS, Matrix, Spectrum, Vector};

/// A model of what accelerates the servo.
#[derive(Debug, PartialEq)]
pub(super) struct Model {
    columns: &'static [Column],
    /// True if the command acts.
    is_driven: bool,
    /// True if the servo is held where it does not move.
    pub(super) is_held: bool,
}

use Column as C;

const BASE: [Column; 3] = [C::Velocity, C::Command, C::Load];

/// All that are tried; each has [`BASE`] besides.
pub(super) const MODELS: [Model; 9] = [
    model(&[], false),
    model(&[C::Direction], false),
    model(&[C::Direction, C::CommandChange], false),
    model(&[C::Direction, C::Sine, C::Cosine], false),
    model(&[C::Direction, C::CommandChange, C::Sine, C::Cosine], false),
    model(&[C::Direction, C::Spring], false),
    model(&[C::Direction, C::CommandChange, C::Spring], false),
    model(&[C::Direction], true),
    model(&[C::Direction, C::Sine, C::Cosine], true),
];

const fn model(columns: &'static [Column], is_held: bool) -> Model {
    of(columns, is_held, true)
}

/// The models by which a command is judged, and the same without it. A column under a loop of its own moves as on a spring.
pub(super) const JUDGED: [[Model; 3]; 2] = [judged(true), judged(false)];

const fn judged(is_driven: bool) -> [Model; 3] {
    [
        of(&[C::Direction], false, is_driven),
        of(&[C::Direction, C::Spring], false, is_driven),
        of(&[C::Direction], true, is_driven),
    ]
}

const fn of(columns: &'static [Column], is_held: bool, is_driven: bool) -> Model {
    Model {
        columns,
        is_driven,
        is_held,
    }
}

/// What a model says.
#[derive(Debug, PartialEq)]
pub(super) struct Solution {
    pub(super) model: &'static Model,
    /// The coefficient of each column; zero of one that the model lacks.
    pub(super) values: [f64; Column::COUNT],
    /// Standard errors, by blocks left out in turn.
    pub(super) std_errors: [f64; Column::COUNT],
    /// By how much each is off if what is missed of the acceleration comes with it.
    pub(super) shifts: [f64; Column::COUNT],
    /// The part of the acceleration of left-out blocks that is not predicted.
    pub(super) missed: f64,
}

impl Solution {
    pub(super) fn has(&self, column: Column) -> bool {
        self.model.columns.contains(&column)
    }

    pub(super) fn value(&self, column: Column) -> f64 {
        self.values[column as usize]
    }
}

/// The products of columns and acceleration in blocks of windows.
pub(super) struct Blocks {
    windows: usize,
    /// By columns and, last, the acceleration.
    sums: Vec<[[f64; WIDTH]; WIDTH]>,
}

const WIDTH: usize = Column::COUNT + 1;

/// Part of the diagonal of equations, against columns that are nearly one.
const DAMPING: f64 = 1e-9;

impl Blocks {
    /// Those of windows in which the servo moves; none if there are none.
    pub(super) fn new(bins: &Bins, count: usize, noise: f64, held: bool) -> Option<Self> {
        /// The part of a window in which the servo moves, where many do and else, and how many that is.
        const MOVING: [f64; 2] = [0.9, 0.6];
        const MANY: usize = 80;
        /// The same where the servo may be held in between.
        const BARELY: f64 = 0.05;
        /// Blocks, each of two windows that follow each other where there are as many.
        const BLOCKS: [usize; 2] = [6, 16];
        let windows = bins.windows(count, noise, held);
        let moves = |least: f64| move |window: &&Window| window.moving > least;
        let many = windows.iter().filter(moves(MOVING[0])).count() > MANY;
        let least = match (held, many) {
            (true, _) => BARELY,
            (false, true) => MOVING[0],
            (false, false) => MOVING[1],
        };
        // One that is never held says the same twice.
        if held && windows.iter().all(|window| window.moving > MOVING[0]) {
            return None;
        }
        let blocks = (bins.count() / (8 * count)).clamp(BLOCKS[0], BLOCKS[1]);
        let mut sums = vec![[[0.0; WIDTH]; WIDTH]; blocks];
        let mut taken = 0;
        let all = windows.len();
        for (place, window) in windows
            .iter()
            .enumerate()
            .filter(|(_, of)| moves(least)(of))
        {
            taken += 1;
            let mut row = [window.acceleration; WIDTH];
            row[..Column::COUNT].copy_from_slice(&window.columns);
            let sums = &mut sums[place * blocks / all];
            for (sums, one) in sums.iter_mut().zip(row) {
                for (sum, other) in sums.iter_mut().zip(row) {
                    *sum += one * other;
                }
            }
        }
        sums.retain(|block| block[WIDTH - 1][WIDTH - 1] > 0.0);
        (sums.len() > 1).then_some(Self {
            windows: taken,
            sums,
        })
    }

    /// The mean square of the windows' accelerations.
    pub(super) fn mean_square(&self) -> f64 {
        let squares = self.sums.iter().map(|block| block[WIDTH - 1][WIDTH - 1]);
        squares.sum::<f64>() / self.windows as f64
    }

    /// Fits a model; none if there are too few windows.
    pub(super) fn solve(&self, model: &'static Model) -> Option<Solution> {
        /// Windows to an unknown.
        const MIN_WINDOWS: usize = 4;
        let base = BASE.iter();
        let base = base.filter(|column| model.is_driven || **column != C::Command);
        let columns: Vec<usize> = base
            .chain(model.columns)
            .map(|column| *column as usize)
            .collect();
        if self.windows < MIN_WINDOWS * columns.len() {
            return None;
        }
        let equations: Vec<Equations> = self
            .sums
            .iter()
            .map(|sums| Equations::new(sums, &columns))
            .collect();
        let mut total = Equations::default();
        equations.iter().for_each(|block| total.add(block, 1.0));
        let mut missed = 0.0;
        let mut left_out = Vec::new();
        for block in &equations {
            let mut others = total;
            others.add(block, -1.0);
            let solution = (others.spectrum(columns.len())).solve(&others.right, DAMPING);
            missed += block.missed(&solution, columns.len());
            left_out.push(solution);
        }
        let spectrum = total.spectrum(columns.len());
        let solution = spectrum.solve(&total.right, DAMPING);
        let [mut values, mut std_errors, mut shifts] = [[0.0; Column::COUNT]; 3];
        let count = left_out.len() as f64;
        for (place, &column) in columns.iter().enumerate() {
            let mean = left_out.iter().map(|one| one[place]).sum::<f64>() / count;
            let squares: f64 = left_out.iter().map(|one| (one[place] - mean).powi(2)).sum();
            values[column] = solution[place];
            std_errors[column] = ((count - 1.0) / count * squares).sqrt();
            let mut unit = Vector::default();
            unit[place] = 1.0;
            let inverse = spectrum.solve(&unit, DAMPING)[place];
            shifts[column] = (missed * inverse.max(0.0)).sqrt();
        }
        Some(Solution {
            model,
            values,
            std_errors,
            shifts,
            missed: missed / total.squares,
        })
    }
}

/// Normal equations.
#[derive(Debug, Clone, Copy, Default)]
struct Equations {
    hessian: Matrix,
    right: Vector,
    squares: f64,
}

impl Equations {
    fn new(sums: &[[f64; WIDTH]; WIDTH], columns: &[usize]) -> Self {
        let mut equations = Self {
            squares: sums[WIDTH - 1][WIDTH - 1],
            ..Self::default()
        };
        for (i, &row) in columns.iter().enumerate() {
            equations.right[i] = sums[row][WIDTH - 1];
            for (j, &column) in columns.iter().enumerate() {
                equations.hessian[i][j] = sums[row][column];
            }
        }
        equations
    }

    fn add(&mut self, other: &Self, weight: f64) {
        for i in 0..MAX_UNKNOWNS {
            self.right[i] += weight * other.right[i];
            for j in 0..MAX_UNKNOWNS {
                self.hessian[i][j] += weight * other.hessian[i][j];
            }
        }
        self.squares += weight * other.squares;
    }

    fn spectrum(&self, count: usize) -> Spectrum {
        Spectrum::new(&self.hessian, count)
    }

    /// The squares that a solution leaves.
    fn missed(&self, solution: &Vector, count: usize) -> f64 {
        let mut missed = self.squares;
        for i in 0..count {
            let along: f64 = (0..count).map(|j| self.hessian[i][j] * solution[j]).sum();
            missed += solution[i] * (along - 2.0 * self.right[i]);
        }
        missed.max(0.0)
    }
}
