//! The fit: start, search, horizon.

use super::gain::Diffuse;
use super::spectrum::{MAX_UNKNOWNS, Spectrum, Vector};
use super::sums::{Covariances, Sums};
use super::weak_form::{Start, starts};
use super::{Effect, Horizon, ModelPass, Record, Survey, Values};

/// A record and the range in which its servo may lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitter<'a> {
    /// The record.
    pub record: &'a Record<'a>,
    /// Its figures.
    pub survey: Survey,
    /// The earliest that the command acts, samples: negative where it was recorded late.
    pub earliest: f64,
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
    /// Standard errors by chance and colour of the free effects, in their order.
    #[must_use]
    pub fn std_errors(&self) -> Vector {
        self.covariances.variances.map(libm::sqrt)
    }
}

/// Settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// The most steps.
    pub steps: u32,
    /// Relative gain below which a step is the last.
    pub tolerance: f64,
}

impl<'a> Fitter<'a> {
    /// The longest delay beyond the earliest: samples, and radians at the bandwidth of the motion.
    const MAX_DELAY: [f64; 2] = [6.0, 0.3];
    /// The earliest command that a start may have, samples.
    const EARLIEST: f64 = -3.5;
    /// The largest a, 1/sample.
    const MAX_RATE: f64 = 0.5;

    /// None where there is no motion.
    #[must_use]
    pub fn new(record: &'a Record<'a>) -> Option<Self> {
        Some(Self {
            record,
            survey: Survey::new(record)?,
            earliest: Self::EARLIEST,
        })
    }

    /// The model at a horizon.
    #[must_use]
    pub fn pass(&self, values: &Values, horizon: Horizon) -> ModelPass<'a> {
        let velocity = self.survey.velocity;
        let usual = values.get(Effect::B).abs() * self.survey.command;
        let noise = super::ROUNDING_DEVIATION;
        let [velocity_variance, load] = [velocity / noise, 0.3 * usual / noise].map(|x| x * x);
        ModelPass {
            record: self.record,
            horizon,
            damping: values.get(Effect::A),
            diffuse: Diffuse {
                velocity: velocity_variance,
                load,
            },
        }
    }

    fn longest_delay(&self) -> f64 {
        let [samples, angle] = Self::MAX_DELAY;
        samples.max(angle / self.survey.bandwidth)
    }

    /// The least and the largest value of an effect.
    #[must_use]
    pub fn bounds(&self, values: &Values, effect: Effect) -> [f64; 2] {
        let ends = f64::INFINITY;
        let limit = self.survey.command;
        match effect {
            Effect::A => [-2.0 / self.record.len() as f64, Self::MAX_RATE],
            Effect::B => [1e-9, ends],
            Effect::Coulomb | Effect::DeadBand => [0.0, ends],
            Effect::Delay => [self.earliest, self.earliest.max(0.0) + self.longest_delay()],
            Effect::CurrentLoop => [0.0, 50.0],
            Effect::LowSpeed => [-values.get(Effect::Coulomb), ends],
            Effect::LowSpeedVelocity => [1e-9, 2.0 * self.survey.velocity],
            Effect::LoadFriction => [0.0, 0.6],
            Effect::HiddenLimit => [0.0, 1.3 * limit],
            Effect::GainAsymmetry
            | Effect::TorqueRippleSine
            | Effect::TorqueRippleCosine
            | Effect::InertiaSine
            | Effect::InertiaCosine => [-0.9, 0.9],
            Effect::GainDrift | Effect::FrictionDrift => [-1.9, 1.9],
            Effect::Compliance => [0.0, ends],
            _ => [-ends, ends],
        }
    }

    /// The size beside which an error of one of the four parameters is small or large: b itself, for friction and
    /// load the acceleration by the largest command, for a that over the velocity; zero for other effects.
    #[must_use]
    pub fn usual_size(&self, values: &Values, effect: Effect) -> f64 {
        let gain = values.get(Effect::B).abs();
        let acceleration = gain * self.survey.command;
        match effect {
            Effect::A => acceleration / self.survey.velocity,
            Effect::B => gain,
            Effect::Coulomb | Effect::Load => acceleration,
            _ => 0.0,
        }
    }

    /// A step of a search for an effect's value, no further than the search's model of it holds.
    fn moved(&self, values: &Values, effect: Effect, step: f64) -> f64 {
        /// Factor by which a positive quantity changes at most.
        const FACTOR: f64 = 3.0;
        /// Change of a delay: samples, and of the longest.
        const DELAY: [f64; 2] = [1.0, 0.15];
        let value = values.get(effect);
        if !step.is_finite() {
            return value;
        }
        let wanted = value + step;
        let wanted = match effect {
            Effect::B | Effect::LowSpeedVelocity => wanted.clamp(value / FACTOR, value * FACTOR),
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

    /// Searches the minimum of the innovations' squares at one horizon: Levenberg and Marquardt's way, with
    /// bounds. None if the model runs away from the start.
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
        let (values, sums) = self.search(values, free, horizon, search)?;
        let covariances = sums.covariances(&self.held(&values, free, horizon, &sums));
        Some(Fitted {
            values,
            horizon,
            sums,
            covariances,
        })
    }

    /// The first estimates, at the likeliest of the starts, their delay free.
    #[must_use]
    pub fn start(&self) -> Option<Values> {
        /// Starts whose gains differ by less than this factor are one.
        const SAME: f64 = 1.22;
        /// Starts that are searched from.
        const TRIED: usize = 3;
        /// Horizons of the search, widths of the start's weights, and the least of each, samples.
        const HORIZONS: [[f64; 2]; 2] = [[2.0, 6.0], [8.0, 25.0]];
        let found = starts(self.record, &self.survey);
        let mut order = [0; super::weak_form::MAX_STARTS];
        for (i, place) in order.iter_mut().enumerate() {
            *place = i;
        }
        let explained = |place: &usize| {
            found[*place].map_or(f64::NEG_INFINITY, |start| {
                if start.values.get(Effect::B) > 0.0 {
                    start.explained
                } else {
                    f64::NEG_INFINITY
                }
            })
        };
        order.sort_unstable_by(|one, other| explained(other).total_cmp(&explained(one)));
        let mut tried: [Option<Start>; TRIED] = [None; TRIED];
        let mut count = 0;
        for start in order.iter().filter_map(|&place| found[place]) {
            let gain = start.values.get(Effect::B);
            let is_new = gain > 0.0
                && tried.iter().flatten().all(|other| {
                    let ratio = gain / other.values.get(Effect::B);
                    !(1.0 / SAME..SAME).contains(&ratio)
                });
            if is_new && count < TRIED {
                tried[count] = Some(start);
                count += 1;
            }
        }
        let most = self.record.len() as f64 / 6.0;
        let widest = tried
            .iter()
            .flatten()
            .map(|start| (HORIZONS[1][0] * start.width).max(HORIZONS[1][1]))
            .fold(0.0, f64::max)
            .min(most);
        let mut best: Option<(f64, Values)> = None;
        for start in tried.iter().flatten() {
            let mut values = start.values;
            let [low, high] = self.bounds(&values, Effect::Delay);
            values.set(Effect::Delay, values.get(Effect::Delay).clamp(low, high));
            let first = (HORIZONS[0][0] * start.width)
                .max(HORIZONS[0][1])
                .min(widest);
            let mut likelihood = f64::INFINITY;
            for white in [first, widest] {
                let horizon = Horizon { white, walk: None };
                let search = Search {
                    steps: 6,
                    tolerance: 1e-5,
                };
                let Some((found, sums)) = self.search(&values, &Effect::BASE, horizon, search)
                else {
                    continue;
                };
                values = found;
                likelihood = sums.minus_two_log_likelihood();
            }
            if best.is_none_or(|(least, _)| likelihood < least) && likelihood.is_finite() {
                best = Some((likelihood, values));
            }
        }
        best.map(|(_, values)| values)
    }

    /// Where the command acts before it was recorded it was recorded late: by how much, samples, and its
    /// standard error, with the estimates at a long horizon, at which a command that already answers the
    /// position cannot explain it.
    #[must_use]
    pub fn lateness(&self, values: &Values) -> Option<Lateness> {
        let rows = self.record.len() as f64;
        let white = (8.0 / self.survey.bandwidth).clamp(30.0, (rows / 10.0).max(30.0));
        let search = Search {
            steps: 10,
            tolerance: 1e-7,
        };
        let horizon = Horizon { white, walk: None };
        let fitted = self.fit(values, &Effect::BASE, horizon, search)?;
        Some(Lateness {
            samples: -fitted.values.get(Effect::Delay),
            std_error: fitted.std_errors()[4],
            values: fitted.values,
        })
    }

    /// The horizon with the least robust variance, and the likeliest of those that are nearly as good; the
    /// noise of a filter that trusts its model less than the model deserves costs variance, that of one that
    /// trusts it more costs bias, which the segments' disagreement shows.
    #[must_use]
    pub fn best_horizon(
        &self,
        values: &Values,
        free: &[Effect],
        horizons: impl Iterator<Item = Horizon>,
        search: Search,
    ) -> Option<Fitted> {
        /// Logarithm of a standard error within which two horizons are as good.
        const AS_GOOD: f64 = 0.25;
        /// By which a walking load must be better than a constant one.
        const WALK_MUST_GAIN: f64 = 0.4;
        let mut best: [Option<Fitted>; 2] = [None; 2];
        let mut least = [f64::INFINITY; 2];
        let mut scores = [f64::INFINITY; 2];
        for horizon in horizons {
            let Some(fitted) = self.fit(values, free, horizon, search) else {
                continue;
            };
            let score = self.spread(&fitted, free);
            if score.is_nan() || fitted.covariances.condition.is_infinite() {
                continue;
            }
            let family = usize::from(horizon.walk.is_some());
            let likelihood = |fitted: &Fitted| fitted.sums.minus_two_log_likelihood();
            // Of those as good as the least so far the likeliest stands.
            let stands = match &best[family] {
                None => true,
                Some(_) if score < least[family] - AS_GOOD => true,
                Some(kept) => {
                    let kept_is_good = scores[family] < least[family].min(score) + AS_GOOD;
                    score < least[family] + AS_GOOD
                        && (!kept_is_good || likelihood(&fitted) < likelihood(kept))
                }
            };
            least[family] = least[family].min(score);
            if stands {
                best[family] = Some(fitted);
                scores[family] = score;
            }
        }
        let walks = least[1] < least[0] - WALK_MUST_GAIN;
        let [constant, walking] = best;
        if walks {
            walking.or(constant)
        } else {
            constant.or(walking)
        }
    }

    /// The load of a fit and its standard error: where a load walks its mean, by the disagreement of the
    /// segments.
    #[must_use]
    pub fn load(&self, fitted: &Fitted, free: &[Effect]) -> (f64, f64) {
        const SEGMENTS: usize = 16;
        /// Neighbours of a load that walks agree more than strangers.
        const COLOUR: f64 = 1.5;
        let load = fitted.values.get(Effect::Load);
        if fitted.horizon.walk.is_none() {
            let place = free.iter().position(|&effect| effect == Effect::Load);
            let error = place.map_or(0.0, |place| fitted.std_errors()[place]);
            return (load, error);
        }
        let mut sums = [[0.0; 2]; SEGMENTS];
        let length = self.record.len();
        self.pass(&fitted.values, fitted.horizon)
            .run(&fitted.values, &[], &mut |row| {
                let sum = &mut sums[row.sample * SEGMENTS / length];
                sum[0] += row.walk;
                sum[1] += 1.0;
            });
        let means = sums.map(|[sum, rows]| sum / f64::max(rows, 1.0));
        let count = SEGMENTS as f64;
        let mean = means.iter().sum::<f64>() / count;
        let scatter = means
            .iter()
            .map(|one| (one - mean) * (one - mean))
            .sum::<f64>();
        let error = COLOUR * libm::sqrt(scatter / (count - 1.0) / count);
        (load + mean, error)
    }

    /// The relative standard errors of a fit, in one logarithm.
    fn spread(&self, fitted: &Fitted, free: &[Effect]) -> f64 {
        let errors = fitted.std_errors();
        let of = |effect: Effect| {
            let place = free.iter().position(|&one| one == effect);
            place.map_or(f64::NAN, |place| errors[place])
        };
        let values = &fitted.values;
        let usual = self.usual_size(values, Effect::Coulomb);
        let rate = self.usual_size(values, Effect::A);
        let floor = |value: f64, share: f64| value.abs() + share;
        let log = |error: f64, scale: f64, least: f64| {
            let error = if error.is_finite() { error } else { least };
            libm::log(error / scale)
        };
        let mut spread = log(of(Effect::B), values.get(Effect::B), values.get(Effect::B))
            + 0.5
                * log(
                    of(Effect::Coulomb),
                    floor(values.get(Effect::Coulomb), 0.02 * usual),
                    usual,
                )
            + 0.5
                * log(
                    of(Effect::A),
                    floor(values.get(Effect::A), 0.03 * rate),
                    rate,
                );
        if values.get(Effect::A) <= self.bounds(values, Effect::A)[0] {
            spread += 1.0;
        }
        spread
    }

    /// A geometric series of horizons, of a constant load and of one that walks.
    pub fn horizons(&self) -> impl Iterator<Item = Horizon> {
        /// Ratio of the series.
        const RATIO: f64 = 2.2;
        let samples = self.record.len();
        let rows = samples as f64;
        let shortest = self.survey.shortest_horizon(samples);
        let longest = rows / 6.0;
        let series = move |first: f64, last: f64| {
            core::iter::successors(Some(first), move |last| Some(last * RATIO))
                .take_while(move |&one| one < last)
        };
        let constant = series(shortest, longest).map(|white| Horizon { white, walk: None });
        let walking = series((0.5 * shortest).max(4.0), rows / 12.0).map(move |walk| Horizon {
            white: longest.max(walk),
            walk: Some(walk),
        });
        constant.chain(walking)
    }

    /// Horizons about one.
    pub fn horizons_about(&self, horizon: Horizon) -> impl Iterator<Item = Horizon> {
        let samples = self.record.len();
        let shortest = self.survey.shortest_horizon(samples);
        let longest = samples as f64 / 6.0;
        [1.0 / 1.8, 1.0, 1.8, 4.0]
            .into_iter()
            .filter_map(move |factor| match horizon.walk {
                None => Some(Horizon {
                    white: (horizon.white * factor).clamp(shortest, longest.max(shortest)),
                    walk: None,
                }),
                Some(_) if factor > 2.0 => None,
                Some(walk) => Some(Horizon {
                    white: horizon.white,
                    walk: Some((walk * factor).max((0.5 * shortest).max(4.0))),
                }),
            })
    }
}

/// How late the command was recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lateness {
    /// By how much, samples; negative is a delay of the servo.
    pub samples: f64,
    /// Standard error.
    pub std_error: f64,
    /// The estimates with it.
    pub values: Values,
}

impl Lateness {
    /// True if it cannot be a delay: beyond 0.6 samples, and beyond 0.3 by four standard errors.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.samples > 0.6 && self.samples - 0.3 > 4.0 * self.std_error
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

/// The innovations' squares without tangents; infinite if the model runs away.
fn squares(pass: &ModelPass<'_>, values: &Values) -> f64 {
    let mut squares = 0.0;
    let ran = pass.run(values, &[], &mut |row| {
        squares += row.innovation * row.innovation / row.variance;
    });
    if ran { squares } else { f64::INFINITY }
}
