//! A record beside a model that nothing corrects: the prediction of a motion by its commands alone.

use crate::fit::{Effect, Horizon, RecordFitter, Values};

use super::Recording;

/// The measured position minus that of a servo with these values, for every sample of a recording
/// [of every sample](Recording::of_every_sample), counts. The recorded command alone drives the servo. None if there is
/// no motion or the servo leaves every bound.
///
/// **The start is fitted.** Position and velocity at the beginning of each motion minimise the errors over it, as in
/// published results. The first samples alone do not determine the velocity below the rounding of an encoder, and its
/// error would accumulate to more than the model's. Nothing else is fitted.
#[must_use]
pub fn free_run(recording: &Recording<'_>, values: &Values) -> Option<Vec<f64>> {
    /// The most steps of the fit.
    const STEPS: u32 = 8;
    /// Part of the usual speed, far above rounding and far below what bends.
    const BESIDE: f64 = 1e-4;
    let record = recording.record();
    // How the gain or the friction changed over another record says nothing of this one.
    let values = recording
        .about_middle(values)
        .with(Effect::GainDrift, 0.0)
        .with(Effect::FrictionDrift, 0.0);
    let motions: Vec<(usize, usize)> = record.motions().collect();
    let (squares, count) = motions
        .iter()
        .flat_map(|&(first, end)| first..end.saturating_sub(1))
        .map(|sample| record.increment(sample))
        .fold((0.0, 0.0), |(squares, count), moved| {
            (squares + moved * moved, count + 1.0)
        });
    let beside = BESIDE * f64::sqrt(squares / count);
    let fitter = RecordFitter::new(&record).filter(|_| beside > 0.0)?;
    let horizon = Horizon {
        white: record.len() as f64,
        walk: None,
    };
    let run = |starts: &[[f64; 2]]| {
        let mut pass = fitter.pass(&values, horizon);
        pass.starts = Some(starts);
        let mut errors = vec![f64::NAN; record.len()];
        let ran = pass.run(&values, &[], &mut |row| errors[row.sample] = row.innovation);
        ran.then_some(errors)
    };
    let guess = |&(first, _): &(usize, usize)| [0.0, record.increment(first)];
    let mut fits: Vec<StartFit> = motions
        .iter()
        .map(|motion| StartFit::new(guess(motion)))
        .collect();
    for _ in 0..STEPS {
        let trials = |[farther, faster]: [f64; 2]| {
            let moved = |fit: &StartFit| [fit.trial[0] + farther, fit.trial[1] + faster];
            fits.iter().map(moved).collect::<Vec<_>>()
        };
        let errors = run(&trials([0.0, 0.0]))?;
        let farther = run(&trials([beside, 0.0]))?;
        let faster = run(&trials([0.0, beside]))?;
        let mut is_worth_more = false;
        for (fit, &(first, end)) in fits.iter_mut().zip(&motions) {
            let mut equations = Equations::default();
            for sample in first..end {
                let error = errors[sample];
                let slopes = [&farther, &faster].map(|other| (other[sample] - error) / beside);
                equations.add(slopes, error);
            }
            is_worth_more |= fit.step(equations);
        }
        if !is_worth_more {
            break;
        }
    }
    let best: Vec<[f64; 2]> = fits.iter().map(StartFit::start).collect();
    run(&best)
}

/// The fit of a start by Levenberg and Marquardt's way: distance from the record, counts, and velocity.
struct StartFit {
    /// The best so far, and the equations for the next step.
    best: Option<([f64; 2], Equations)>,
    trial: [f64; 2],
    damping: f64,
}

/// The normal equations of a step.
#[derive(Clone, Copy, Default)]
struct Equations {
    matrix: [f64; 3],
    right: [f64; 2],
    squares: f64,
}

impl StartFit {
    const fn new(guess: [f64; 2]) -> Self {
        Self {
            best: None,
            trial: guess,
            damping: 1e-3,
        }
    }

    fn start(&self) -> [f64; 2] {
        self.best.map_or(self.trial, |(best, _)| best)
    }

    /// Takes the equations at the trial: whether another step is worth it.
    fn step(&mut self, found: Equations) -> bool {
        /// A step that takes away no more than this part of the squares is the last.
        const WORTH: f64 = 1e-6;
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
        let Some(step) = equations.solved(self.damping) else {
            return false;
        };
        self.trial = [best[0] + step[0], best[1] + step[1]];
        true
    }
}

impl Equations {
    fn add(&mut self, slopes: [f64; 2], error: f64) {
        self.matrix[0] += slopes[0] * slopes[0];
        self.matrix[1] += slopes[0] * slopes[1];
        self.matrix[2] += slopes[1] * slopes[1];
        self.right[0] -= slopes[0] * error;
        self.right[1] -= slopes[1] * error;
        self.squares += error * error;
    }

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
