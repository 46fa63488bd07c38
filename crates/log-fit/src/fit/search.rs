//! A fit at one horizon: the search for the least innovations, and its uncertainty.

use super::fitter::RecordFitter;
use super::spectrum::{MAX_UNKNOWNS, Spectrum, Vector};
use super::sums::{Covariances, Sums};
use super::{Effect, Horizon, ModelPass, Values};

/// Settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// The most steps.
    pub steps: u32,
    /// Relative gain below which a step is the last.
    pub tolerance: f64,
}

/// A fit at one horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// The estimates.
    pub values: Values,
    /// The horizon.
    pub horizon: Horizon,
    /// The sums of the last pass.
    pub sums: Sums,
    /// Variances of the free effects, in their order.
    pub covariances: Covariances,
}

impl Fitted {
    /// Standard errors by chance and autocorrelation of the free effects, in their order.
    #[must_use]
    pub fn std_errors(&self) -> Vector {
        self.covariances.variances.map(libm::sqrt)
    }
}

impl RecordFitter<'_> {
    /// A step of a search for an effect's value, no further than the search's model of it holds.
    fn moved(&self, values: &Values, effect: Effect, step: f64) -> f64 {
        /// Factor by which a positive quantity changes at most.
        const FACTOR: f64 = 3.0;
        /// The same of a resonance, beyond which its phase is another.
        const RESONANCE: f64 = 1.2;
        /// Change of a delay: samples, and of the longest.
        const DELAY: [f64; 2] = [1.0, 0.15];
        let value = values.get(effect);
        if !step.is_finite() {
            return value;
        }
        let wanted = value + step;
        let wanted = match effect {
            Effect::B | Effect::LowSpeedVelocity | Effect::ResonanceDamping => {
                wanted.clamp(value / FACTOR, value * FACTOR)
            }
            Effect::ResonanceFrequency => wanted.clamp(value / RESONANCE, value * RESONANCE),
            Effect::Delay => {
                let most = DELAY[0].max(DELAY[1] * self.longest_delay());
                wanted.clamp(value - most, value + most)
            }
            _ => wanted,
        };
        let [low, high] = self.bounds(values, effect);
        wanted.clamp(low, high)
    }

    /// The unknowns that a step would take beyond a bound at which they stand.
    fn stopped(
        &self,
        values: &Values,
        free: &[Effect],
        step: &Vector,
        held: &mut [bool; MAX_UNKNOWNS],
    ) -> bool {
        let mut found = false;
        for (i, &effect) in free.iter().enumerate() {
            let [low, high] = self.bounds(values, effect);
            let value = values.get(effect);
            if !held[i] && ((value <= low && step[i] < 0.0) || (value >= high && step[i] > 0.0)) {
                held[i] = true;
                found = true;
            }
        }
        found
    }

    /// The free effects that stand at a bound and that the record would have beyond it.
    #[must_use]
    pub fn held(
        &self,
        values: &Values,
        free: &[Effect],
        horizon: Horizon,
        sums: &Sums,
    ) -> [bool; MAX_UNKNOWNS] {
        let mut held = walked(free, horizon);
        self.stopped(values, free, &sums.gradient, &mut held);
        held
    }

    /// Searches the minimum of the innovations' squares at one horizon: Levenberg and Marquardt's way, with bounds.
    /// None if the model diverges from the start.
    #[must_use]
    pub fn search(
        &self,
        values: &Values,
        free: &[Effect],
        horizon: Horizon,
        search: Search,
    ) -> Option<(Values, Sums)> {
        /// Damping at the start, its least and the factor by which it changes.
        const DAMPING: [f64; 3] = [1e-4, 1e-10, 10.0];
        /// Trials from one place.
        const TRIALS: u32 = 6;
        let pass = self.pass(values, horizon);
        let mut values = *values;
        let mut sums = Sums::new(&pass, &values, free)?;
        let [mut damping, least, factor] = DAMPING;
        for _ in 0..search.steps {
            if !(self.goes_on)() {
                break;
            }
            let mut better = None;
            for number in 0..TRIALS {
                let trial = self.trial(&values, free, horizon, &sums, damping);
                // The first is nearly always better, and its tangents are needed then.
                if number == 0 || squares(&pass, &trial) < sums.squares {
                    let found = Sums::new(&pass, &trial, free);
                    better = found
                        .filter(|found| found.squares < sums.squares)
                        .map(|found| (trial, found));
                }
                if better.is_some() {
                    break;
                }
                damping = (damping * factor).max(DAMPING[0]);
            }
            let Some((trial, found)) = better else { break };
            let gain = (sums.squares - found.squares) / sums.squares;
            values = trial;
            sums = found;
            damping = (damping / factor).max(least);
            if gain < search.tolerance.max(0.02 / sums.rows) {
                break;
            }
        }
        Some((values, sums))
    }

    fn trial(
        &self,
        values: &Values,
        free: &[Effect],
        horizon: Horizon,
        sums: &Sums,
        damping: f64,
    ) -> Values {
        let mut held = walked(free, horizon);
        let mut step = [0.0; MAX_UNKNOWNS];
        for _ in 0..4 {
            let mut places = [0; MAX_UNKNOWNS];
            let mut count = 0;
            for i in 0..free.len() {
                if !held[i] {
                    places[count] = i;
                    count += 1;
                }
            }
            let mut matrix = [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS];
            let mut right = [0.0; MAX_UNKNOWNS];
            for (a, &i) in places[..count].iter().enumerate() {
                right[a] = sums.gradient[i];
                for (b, &j) in places[..count].iter().enumerate() {
                    matrix[a][b] = sums.hessian[i][j];
                }
            }
            let solved = Spectrum::new(&matrix, count).solve(&right, damping);
            step = [0.0; MAX_UNKNOWNS];
            for (a, &i) in places[..count].iter().enumerate() {
                step[i] = solved[a];
            }
            if !self.stopped(values, free, &step, &mut held) {
                break;
            }
        }
        let mut trial = *values;
        for (i, &effect) in free.iter().enumerate() {
            trial.set(effect, self.moved(values, effect, step[i]));
        }
        trial
    }

    /// A search and the covariances at its end.
    #[must_use]
    pub fn fit(
        &self,
        values: &Values,
        free: &[Effect],
        horizon: Horizon,
        search: Search,
    ) -> Option<Fitted> {
        let (values, mut sums) = self.search(values, free, horizon, search)?;
        sums.repeated = self.repeated(&values, horizon);
        let covariances = sums.covariances(&self.held(&values, free, horizon, &sums));
        Some(Fitted {
            values,
            horizon,
            sums,
            covariances,
        })
    }
}

/// A load that walks takes a constant one over, which is not fitted then.
fn walked(free: &[Effect], horizon: Horizon) -> [bool; MAX_UNKNOWNS] {
    let mut held = [false; MAX_UNKNOWNS];
    for (held, &effect) in held.iter_mut().zip(free) {
        *held = horizon.walk.is_some() && effect == Effect::Load;
    }
    held
}

/// The innovations' squares without tangents; infinite if the model diverges.
fn squares(pass: &ModelPass<'_>, values: &Values) -> f64 {
    let mut squares = 0.0;
    let ran = pass.run(values, &[], &mut |row| {
        squares += row.innovation * row.innovation / row.variance;
    });
    if ran { squares } else { f64::INFINITY }
}
