//! The motion that an open-loop simulation starts with, fitted to what was recorded.

use super::{FrozenServo, State};
use crate::log::Row;

/// A motion: position, rad, and velocity, rad a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub(super) position: f64,
    pub(super) velocity: f64,
}

/// The fit of a start: position and velocity at the first sample of a segment. They minimise the distance between
/// simulated and recorded positions. It is Levenberg–Marquardt with a step for each pass over the samples. The
/// derivatives come from simulations with slightly different starts.
#[derive(Debug, Clone)]
pub(super) struct StartFit {
    /// The best so far, with what it left and the equations for the next step.
    best: Option<(Motion, Equations)>,
    trial: Motion,
    damping: f64,
    /// Step of the numerical derivatives, rad and rad per sample.
    beside: Motion,
    run: Option<Run>,
}

/// The normal equations of a step.
#[derive(Debug, Clone, Copy, Default)]
struct Equations {
    matrix: [f64; 3],
    right: [f64; 2],
    squares: f64,
}

/// A simulation on its way from the trial, and from beside it.
#[derive(Debug, Clone)]
struct Run {
    states: [State; 3],
    equations: Equations,
}

impl StartFit {
    /// From a first guess; `speed` is what the velocity is usually like, rad a sample.
    pub(super) fn new(guess: Motion, speed: f64) -> Self {
        /// Part of the usual speed, far above rounding and far below what bends.
        const BESIDE: f64 = 1e-4;
        let beside = Motion {
            position: BESIDE * speed,
            velocity: BESIDE * speed,
        };
        Self {
            best: None,
            trial: guess,
            damping: 1e-3,
            beside,
            run: None,
        }
    }

    /// The best start.
    pub(super) fn start(&self) -> Motion {
        self.best.map_or(self.trial, |(best, _)| best)
    }

    /// From the trial, and from beside it.
    fn run(&self, servo: &FrozenServo, command: f64) -> Run {
        let Motion { position, velocity } = self.trial;
        let [aside, faster] = [self.beside.position, self.beside.velocity];
        let starts = [(0.0, 0.0), (aside, 0.0), (0.0, faster)];
        Run {
            states: starts
                .map(|(aside, faster)| servo.start(position + aside, velocity + faster, command)),
            equations: Equations::default(),
        }
    }

    /// A sample, and the command that acts from it on.
    pub(super) fn add(&mut self, servo: &FrozenServo, sample: &Row, command: f64) {
        let mut run = match self.run.take() {
            Some(run) => run,
            None => self.run(servo, command),
        };
        let Run { states, equations } = &mut run;
        let position = states[0].position;
        let slopes = [
            (states[1].position - position) / self.beside.position,
            (states[2].position - position) / self.beside.velocity,
        ];
        let error = sample.position - position;
        equations.matrix[0] += slopes[0] * slopes[0];
        equations.matrix[1] += slopes[0] * slopes[1];
        equations.matrix[2] += slopes[1] * slopes[1];
        equations.right[0] += slopes[0] * error;
        equations.right[1] += slopes[1] * error;
        equations.squares += error * error;
        for state in states {
            servo.advance(state, command);
        }
        self.run = Some(run);
    }

    /// All samples have been played: whether another step is worth it.
    pub(super) fn step(&mut self) -> bool {
        /// A step that takes away no more than this part of the squares is the last.
        const WORTH: f64 = 1e-6;
        let Some(Run {
            equations: found, ..
        }) = self.run.take()
        else {
            return false;
        };
        let gained = match &self.best {
            Some((_, best)) => best.squares - found.squares,
            None => f64::INFINITY,
        };
        if gained >= 0.0 && found.squares.is_finite() {
            self.best = Some((self.trial, found));
            self.damping *= 0.1;
        } else {
            self.damping *= 10.0;
        }
        let Some((best, equations)) = self.best else {
            return false;
        };
        if (0.0..=WORTH * equations.squares).contains(&gained) {
            return false;
        }
        let Some([position, velocity]) = equations.solved(self.damping) else {
            return false;
        };
        self.trial = Motion {
            position: best.position + position,
            velocity: best.velocity + velocity,
        };
        true
    }
}

impl Equations {
    /// The step that they ask for, damped.
    fn solved(&self, damping: f64) -> Option<[f64; 2]> {
        let [first, mixed, second] = self.matrix;
        let (first, second) = ((1.0 + damping) * first, (1.0 + damping) * second);
        let determinant = first * second - mixed * mixed;
        let [one, other] = self.right;
        let step = [
            (second * one - mixed * other) / determinant,
            (first * other - mixed * one) / determinant,
        ];
        step.iter().all(|part| part.is_finite()).then_some(step)
    }
}
