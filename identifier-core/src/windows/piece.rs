use crate::constants::encode;
use crate::number::{Arithmetic, Encoded, Number};

/// A quantity over a piece of m samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Moments<F> {
    /// Its mean.
    pub(crate) mean: F,
    /// ∑ⱼ (m − j − ½) xⱼ/m²: its share in the displacement within the piece.
    pub(crate) early: F,
}

/// A piece of a motion, machine units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Piece<F> {
    /// Velocity: travel and mean displacement over m.
    pub(crate) velocity: Moments<F>,
    /// The command that acted.
    pub(crate) command: Moments<F>,
    /// What a command that acts a sample later has besides.
    pub(crate) later: Moments<F>,
    /// The direction of the motion, −1 to 1; none if it is not known.
    pub(crate) direction: Option<Moments<F>>,
}

impl<F: Number> Moments<F> {
    /// Of both pieces together.
    fn joined(&self, next: &Self) -> Self {
        let [half, quarter] = [0.5, 0.25].map(F::from_f64);
        Self {
            mean: half * (self.mean + next.mean),
            early: quarter * (self.early + self.mean + next.early),
        }
    }
}

impl<F: Number> Piece<F> {
    /// It and the next, of the same length.
    pub(super) fn joined(&self, next: &Self) -> Self {
        let directions = self.direction.zip(next.direction);
        Self {
            velocity: self.velocity.joined(&next.velocity),
            command: self.command.joined(&next.command),
            later: self.later.joined(&next.later),
            direction: directions.map(|(own, next)| own.joined(&next)),
        }
    }
}

/// A piece as the interrupt hands it to the background: sums in the numbers of the interrupt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredPiece<N: Arithmetic> {
    number: u32,
    velocity: N::Integral,
    command: N::Integral,
    direction: N::Integral,
    /// The command before it, and its last.
    edges: [N; 2],
    /// Samples in which friction held the model.
    stuck: u16,
    /// The model has followed the servo all the time.
    has_followed: bool,
}

/// The sums of the interrupt between samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measuring<N: Arithmetic> {
    /// The command that acts.
    command: N,
    /// Samples until the piece is complete.
    left: u16,
    /// Its first increment was made by its first command.
    is_whole: bool,
    was_near: bool,
    now: MeasuredPiece<N>,
    /// The last that was completed, until it is taken.
    done: MeasuredPiece<N>,
    is_done: bool,
}

/// Pieces of a length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pieces<N: Arithmetic> {
    samples: u16,
    /// The output error up to which a model follows.
    near: N,
    per_length: N::Real,
    /// Exponents of the full scales of velocity and command.
    velocity: i32,
    command: i32,
}

encode! {
    [N: Encoded] Pieces<N> as "Pieces" { samples, near, per_length, velocity, command }
}

impl<N: Arithmetic> Measuring<N> {
    /// The increment since the last sample, and the direction of the model meanwhile. True if a piece is complete.
    #[inline(always)]
    pub(crate) fn add(&mut self, increment: N, direction: Option<N>) -> bool {
        increment.integrate(&mut self.now.velocity);
        self.command.integrate(&mut self.now.command);
        if let Some(direction) = direction {
            direction.integrate(&mut self.now.direction);
        }
        self.left = self.left.wrapping_sub(1);
        self.left == 0
    }

    /// The command that acts from now on.
    #[inline(always)]
    pub(crate) fn hold(&mut self, command: N) {
        self.command = command;
    }

    /// Hands on the piece that is complete, and begins the next.
    #[inline(always)]
    pub(crate) fn complete(&mut self, pieces: &Pieces<N>, output_error: N) {
        let is_near = output_error.magnitude() <= pieces.near;
        self.done = self.now;
        let [_, last] = &mut self.done.edges;
        *last = self.command;
        self.done.has_followed &= is_near & self.was_near;
        self.is_done = self.is_whole;
        self.begin(pieces);
        (self.is_whole, self.was_near) = (true, is_near);
    }

    /// Begins the next piece.
    #[inline(always)]
    fn begin(&mut self, pieces: &Pieces<N>) {
        self.now = MeasuredPiece::new(self.now.number.wrapping_add(1), self.command);
        self.left = pieces.samples;
    }

    /// Drops the piece that has begun, and one that was not taken.
    pub(crate) fn interrupt(&mut self, pieces: &Pieces<N>) {
        self.begin(pieces);
        (self.is_whole, self.was_near, self.is_done) = (false, false, false);
    }

    /// The model has not followed.
    pub(crate) fn lose(&mut self) {
        self.now.has_followed = false;
    }

    /// Friction holds the model until the next sample.
    #[inline]
    pub(crate) fn stick(&mut self) {
        self.now.stuck = self.now.stuck.wrapping_add(1);
    }

    /// The piece that was completed, once.
    #[inline]
    pub(crate) fn take(&mut self) -> Option<MeasuredPiece<N>> {
        core::mem::take(&mut self.is_done).then_some(self.done)
    }
}

impl<N: Arithmetic> MeasuredPiece<N> {
    const fn new(number: u32, before: N) -> Self {
        Self {
            number,
            velocity: N::NOTHING,
            command: N::NOTHING,
            direction: N::NOTHING,
            edges: [before; 2],
            stuck: 0,
            has_followed: true,
        }
    }

    /// Its number among all pieces: one that is missing was lost.
    pub(crate) fn number(&self) -> u32 {
        self.number
    }
}

impl<N: Arithmetic> Pieces<N> {
    /// The most samples of a piece.
    pub(crate) const MOST: u16 = 512;

    /// Pieces of a power of two of `samples`, in the full scales of the interrupt: exponents of velocity and command.
    /// `near` is the output error up to which a model follows, as a signal.
    pub(crate) fn new(samples: u16, near: N, [velocity, command]: [i32; 2]) -> Self {
        Self {
            samples,
            near,
            per_length: <N::Real as Number>::from_f64(1.0 / f64::from(samples)),
            velocity,
            command,
        }
    }

    pub(crate) fn start(&self) -> Measuring<N> {
        Measuring {
            command: N::ZERO,
            left: self.samples,
            is_whole: false,
            was_near: false,
            now: MeasuredPiece::new(0, N::ZERO),
            done: MeasuredPiece::new(0, N::ZERO),
            is_done: false,
        }
    }

    /// A measured piece in machine units.
    pub(crate) fn piece(&self, measured: &MeasuredPiece<N>) -> Piece<N::Real> {
        let half = <N::Real as Number>::from_f64(0.5);
        let of = |integral: &N::Integral, exponent| {
            let [sum, double] = N::integrals(integral, exponent);
            Moments {
                mean: sum * self.per_length,
                early: (double - half * sum) * self.per_length * self.per_length,
            }
        };
        let command = of(&measured.command, self.command);
        let edges = measured.edges.map(|edge| {
            let value = edge.value(self.command);
            <N::Real as Number>::from_f64(value) * self.per_length
        });
        let [before, last] = edges;
        let mean = before - last;
        let early = before - (half * mean + command.mean) * self.per_length;
        // A model that friction holds most of the time knows no direction.
        let is_known = measured.has_followed && measured.stuck <= self.samples / 2;
        Piece {
            velocity: of(&measured.velocity, self.velocity),
            command,
            later: Moments { mean, early },
            direction: is_known.then(|| of(&measured.direction, 0)),
        }
    }
}
