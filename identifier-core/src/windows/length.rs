use super::piece::{Moments, Piece};
use crate::linalg::NormalEquations;
use crate::number::Number;

/// The unknowns of the windows: a, b, Coulomb friction, and b times the delay of the command in samples.
pub(crate) const COLUMNS: usize = 4;

/// A row of the equations: the change of the velocity, and what acts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Row<F> {
    change: F,
    columns: [F; COLUMNS],
}

/// Windows of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Length<F> {
    /// The last piece, whose direction the next may tell.
    last: Piece<F>,
    /// The velocity in the piece before.
    before: F,
    /// What acted in that piece: velocity, command, direction and later command.
    acting: [Moments<F>; COLUMNS],
    /// Pieces without a gap, and of them those in motion.
    pieces: u8,
    moving: u8,
    lines: [Row<F>; 2],
    pairs: [Row<F>; 2],
    /// Ω θ = Y of the windows, each of unit variance by the sensor's noise.
    pub(super) equations: NormalEquations<F, COLUMNS>,
    /// Windows in them.
    pub(super) count: F,
    /// Mean of the lines, in which the load is, and their number.
    mean: Row<F>,
    lines_in_mean: F,
}

/// The scales of a length, machine units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale<F> {
    /// 1/m.
    pub(super) per_length: F,
    /// One over the standard deviation of a window by the sensor's noise.
    pub(super) weight: F,
    /// Velocity that is surely motion.
    pub(super) least: F,
    /// Windows that are remembered.
    pub(super) memory: F,
}

impl<F: Number> Scale<F> {
    /// That of twice the length.
    pub(super) fn twice(&self) -> Self {
        let [half, four] = [0.5, 4.0].map(F::from_f64);
        Self {
            per_length: half * self.per_length,
            weight: four * self.weight,
            least: half * self.least,
            memory: self.memory,
        }
    }

    /// The direction in a piece, by its velocity and those of its neighbours; none if the servo may have stood. At a
    /// reversal the velocity is taken to run through zero in a straight line.
    fn direction(&self, before: F, own: F, after: F) -> Option<Moments<F>> {
        let half = F::from_f64(0.5);
        let forward = before - after > F::ZERO;
        let directed = |x: F| if forward { x } else { -x };
        let [from, along, to] = [before, own, after].map(directed);
        if from > self.least && to < -self.least {
            // The part before the reversal, of a line with the mean velocity of the piece.
            let slope = half * (from - to);
            let part = ((along + half * slope) * slope.reciprocal()).limited(F::ZERO, F::ONE);
            let twice = part + part;
            return Some(Moments {
                mean: directed(twice - F::ONE),
                early: directed(twice - part * part - half),
            });
        }
        let sign = if own > F::ZERO { F::ONE } else { -F::ONE };
        (own.magnitude() > self.least).then(|| Moments {
            mean: sign,
            early: half * sign,
        })
    }
}

impl<F: Number> Row<F> {
    fn by(&self, other: &Self, of: impl Fn(F, F) -> F) -> Self {
        let [a, b, c, delay] = &self.columns;
        let [a2, b2, c2, delay2] = &other.columns;
        Self {
            change: of(self.change, other.change),
            columns: [of(*a, *a2), of(*b, *b2), of(*c, *c2), of(*delay, *delay2)],
        }
    }

    fn scaled(&self, by: F) -> Self {
        self.by(self, |own, _| by * own)
    }

    /// What the unknowns leave of the change.
    fn left(&self, unknowns: &[F; COLUMNS]) -> F {
        let terms = self.columns.iter().zip(unknowns);
        terms.fold(self.change, |left, (column, unknown)| {
            left - *column * *unknown
        })
    }
}

impl<F: Number> Length<F> {
    pub(super) fn new() -> Self {
        Self {
            last: Piece::default(),
            before: F::ZERO,
            acting: [Moments::default(); COLUMNS],
            pieces: 0,
            moving: 0,
            lines: [Row::default(); 2],
            pairs: [Row::default(); 2],
            equations: NormalEquations::default(),
            count: F::ZERO,
            mean: Row::default(),
            lines_in_mean: F::ZERO,
        }
    }

    /// Begins a motion anew after a gap.
    pub(super) fn interrupt(&mut self) {
        (self.pieces, self.moving) = (0, 0);
    }

    /// Takes a piece. Returns the one before it, of which all is known now, and whether there is a new window.
    pub(super) fn push(&mut self, scale: &Scale<F>, piece: &Piece<F>) -> (Option<Piece<F>>, bool) {
        let mut own = core::mem::replace(&mut self.last, *piece);
        let before = core::mem::replace(&mut self.before, own.velocity.mean);
        self.pieces = self.pieces.saturating_add(1);
        if self.pieces < 3 {
            return ((self.pieces == 2).then_some(own), false);
        }
        let [velocity, after] = [own.velocity.mean, piece.velocity.mean];
        if own.direction.is_none() {
            own.direction = scale.direction(before, velocity, after);
        }
        let Some(direction) = own.direction else {
            self.moving = 0;
            return (Some(own), false);
        };
        // Between samples a position is no straight line.
        let bend = F::from_f64(1.0 / 24.0) * scale.per_length * scale.per_length;
        let curved = Moments {
            early: own.velocity.early - bend * (after - before),
            ..own.velocity
        };
        let is_new = self.add(scale, [curved, own.command, direction, own.later]);
        (Some(own), is_new)
    }

    /// Takes what acts in a piece: a line with the piece before, a pair of pairs of lines, and a window of their
    /// difference.
    fn add(&mut self, scale: &Scale<F>, acting: [Moments<F>; COLUMNS]) -> bool {
        let before = core::mem::replace(&mut self.acting, acting);
        // By a triangle over both pieces.
        let of = |before: &Moments<F>, own: &Moments<F>| before.mean - before.early + own.early;
        let [velocity, command, direction, later] = &acting;
        let [
            velocity_before,
            command_before,
            direction_before,
            later_before,
        ] = &before;
        let line = Row {
            change: scale.per_length * (velocity.mean - velocity_before.mean),
            columns: [
                -of(velocity_before, velocity),
                of(command_before, command),
                -of(direction_before, direction),
                of(later_before, later),
            ],
        };
        let [second, first] = self.lines;
        self.lines = [line, second];
        let pair = line.by(&second, |own, other| own + other + other);
        let pair = pair.by(&first, |own, other| own + other);
        let [previous, earlier] = self.pairs;
        self.pairs = [pair, previous];
        self.moving = self.moving.saturating_add(1);
        // The first line has no piece before it.
        if self.moving > 3 {
            self.add_to_mean(&pair.scaled(F::from_f64(0.25)));
        }
        let is_window = self.moving > 5;
        if is_window {
            let window = pair.by(&earlier, |own, other| own - other);
            self.add_window(scale.memory, &window.scaled(scale.weight));
        }
        is_window
    }

    fn add_to_mean(&mut self, line: &Row<F>) {
        /// The load is a mean over these.
        const LINES: f64 = 64.0;
        self.lines_in_mean = (self.lines_in_mean + F::ONE).smaller(F::from_f64(LINES));
        let part = self.lines_in_mean.reciprocal();
        self.mean = self.mean.by(line, |mean, own| mean + part * (own - mean));
    }

    /// Takes a window. One that moves less than a quarter of the usual by its command makes nothing forgotten.
    fn add_window(&mut self, memory: F, window: &Row<F>) {
        /// Square of that part.
        const LITTLE: f64 = 1.0 / 16.0;
        let [_, command, ..] = window.columns;
        let usual = F::from_f64(LITTLE) * self.equations.square(1);
        if self.count * command * command > usual || self.count == F::ZERO {
            if self.count < memory {
                self.count += F::ONE;
            } else {
                self.equations.fade(F::ONE - memory.reciprocal());
            }
        }
        self.equations.add(&window.columns, window.change);
    }

    /// The mean of the lines' columns.
    pub(super) fn mean_columns(&self) -> [F; COLUMNS] {
        self.mean.columns
    }

    /// The load that is left to a servo, and the lines that it is a mean of.
    pub(super) fn load(&self, unknowns: &[F; COLUMNS]) -> (F, F) {
        (self.mean.left(unknowns), self.lines_in_mean)
    }
}
