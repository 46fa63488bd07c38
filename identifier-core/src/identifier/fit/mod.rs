//! Fits of the servo's parameters to a record of what it did and what was asked of it.

mod record;

pub use record::{Block, Blocking, Record};

use crate::adaptation::NormalEquations;
use crate::model::{FrictionStep, Innovation, ListeningModel, Tangents};
use crate::number::Number;
use crate::parameters::{AbCoulombLoad, ModelParameters};

/// The unknowns of a fit: a, b, c, d, then the model's position and velocity at the start.
const UNKNOWNS: usize = 6;

/// Places of the unknowns.
const A: usize = 0;
const B: usize = 1;
const COULOMB: usize = 2;
const POSITION: usize = 4;
const VELOCITY: usize = 5;

/// Variance of a count's rounding.
pub(super) const ROUNDING: f64 = 1.0 / 12.0;

/// Levenberg–Marquardt fit of the model, driven by the recorded command, to the recorded motion.
///
/// **Start.** With the model's parameters at zero and the *measured* motion in place of its own,
/// the output error is linear in the parameters, and the tangents are its regressors: one pass
/// gives a least-squares estimate that needs no first guess (equation error behind the filter
/// 1/(p + ω)²; Young, Recursive Estimation and Time-Series Analysis, 2nd edition 2011, chapter 8).
/// It is solved with and without friction. Guesses that were given are further starts, and if none
/// of these explains the motion, so is a ladder of gains.
///
/// **Passes.** From each start at most [`Fitter::PASSES`] passes of the [`ListeningModel`]; the
/// start that explains the motion best wins. The correction of the model keeps its output error
/// bounded for every trial, however far off.
///
/// All is computed in units of a block: with m samples to a block, a m T, b (m T)²/ρ and so on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fitter<N> {
    step: FrictionStep<N>,
    /// Variance of the position noise, counts².
    noise: N,
    low: [N; 4],
    high: [N; 4],
    /// What was given.
    prior: Prior<N>,
    free: [bool; 4],
    /// Units of a block per unit of a sample.
    scale: [f64; 4],
    bandwidth: Option<N>,
}

/// What a fitter is made from, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FitterConfig {
    pub(super) block: u32,
    pub(super) noise: f64,
    pub(super) low: [f64; 4],
    pub(super) high: [f64; 4],
    pub(super) initial: [Option<f64>; 4],
    pub(super) deviation: [Option<f64>; 4],
    /// Parameters to be found; the others stay at their initial value, or zero.
    pub(super) free: [bool; 4],
    pub(super) bandwidth: Option<f64>,
}

/// What is known before a fit, units of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Prior<N> {
    /// Guesses: one more start.
    initial: [Option<N>; 4],
    /// Deviation of the noise over those of the guesses; zero where they bind nothing.
    weight: [N; 4],
}

/// What a fit found, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found<N> {
    /// a, b, c, d.
    pub(super) parameters: [N; 4],
    pub(super) covariance: [[N; 4]; 4],
    /// Variance of what the fit leaves unexplained, counts²; at least the encoder's.
    pub(super) unexplained: N,
    /// Root mean square of acceleration over that of velocity, 1/sample.
    pub(super) bandwidth: N,
    /// Whether a parameter was stopped by a bound.
    pub(super) at_bound: [bool; 4],
    /// The sum of all distances gone, counts.
    pub(super) path: N,
    /// The last output error, counts.
    pub(super) output_error: N,
    /// Root mean square of the acceleration that the command gives, counts per sample².
    pub(super) acceleration: N,
    /// The part of the motion that the fit leaves unexplained, 0 to 1: mean square of its errors
    /// over that of a model that stands.
    pub(super) left: f64,
    /// The direction of the motion if it never reversed, ±1; else zero.
    pub(super) only_direction: N,
    noise: N,
}

impl<N: Number> Found<N> {
    /// Whether a recursion can go on from it: the motion is explained, and b is known within a part
    /// `most` of itself.
    pub(super) fn is_good(&self, most: f64) -> bool {
        /// A fit that explains less does not know what moves the servo.
        const LEFT: f64 = 0.1;
        let b = self.parameters[B].to_f64();
        let variance = self.covariance[B][B].to_f64();
        let explained = self.left < LEFT || self.unexplained.to_f64() < 4.0 * self.noise.to_f64();
        let finite = (0..4).all(|i| {
            self.parameters[i].is_finite()
                && self.covariance[i].iter().all(|entry| entry.is_finite())
        });
        finite && explained && !self.at_bound[B] && variance <= most * most * b * b
    }
}

/// A fit under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit<N> {
    prior: Prior<N>,
    blocks: usize,
    next: usize,
    stage: Stage,
    survey: Survey<N>,
    omega: N,
    correction: Innovation<N>,
    pass: Pass<N>,
    linear: [[N; UNKNOWNS]; 2],
    /// The cost of a model that stands.
    standing_cost: N,
    trial: [N; UNKNOWNS],
    damping: N,
    passes: u32,
    this: Option<Best<N>>,
    best: Option<Best<N>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    Survey,
    Linear,
    From(u32),
}

/// What the record shows without a model.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Survey<N> {
    path: N,
    command: N,
    command_square: N,
    travel_square: N,
    /// The furthest since the last reversal, relative to the present position.
    extreme: N,
    direction: N,
    reversals: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Pass<N> {
    model: ListeningModel<N>,
    tangents: Tangents<N, UNKNOWNS>,
    equations: NormalEquations<N, UNKNOWNS>,
    last_error: N,
    lag_one: N,
    speed_square: N,
    acceleration_square: N,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Best<N> {
    unknowns: [N; UNKNOWNS],
    pass: Pass<N>,
}

impl<N: Number> Fitter<N> {
    /// The most passes from one start.
    const PASSES: u32 = 12;

    /// A pass that lowers the cost by less than this fraction is the last.
    const ENOUGH: f64 = 1e-4;

    /// The factor by which a pass that helps, or does not, changes the damping.
    const CHANGE: f64 = 10.0;

    /// Levenberg's and Marquardt's damping at the start.
    const FIRST_DAMPING: f64 = 1e-3;

    /// Standard deviations of the initial position (its rounding), counts, and of the initial
    /// velocity, in counts per block.
    const INITIAL: [f64; 2] = [0.288_675, 1e3];

    /// Factors on the gain that the amplitudes suggest, from where to start if nothing better is
    /// known.
    const LADDER: [f64; 5] = [1.0, 0.2, 5.0, 0.03, 30.0];

    /// A fit explains the motion if the variance of the errors is below this many times the
    /// encoder's; then no further start is tried.
    const EXPLAINED: f64 = 2.0;

    pub(super) fn new(config: &FitterConfig) -> Self {
        let m = f64::from(config.block.max(1));
        let scale = [m, m * m, m * m, m * m];
        let of = |values: &[f64; 4]| core::array::from_fn(|i| N::from_f64(values[i] * scale[i]));
        let mut high: [N; 4] = of(&config.high);
        let most = N::from_f64(crate::model::HeldStep::<N>::LARGEST_RATE);
        high[A] = high[A].limited(-most, most);
        let mut low: [N; 4] = of(&config.low);
        low[A] = low[A].limited(-most, most);
        Self {
            step: FrictionStep::new(),
            noise: N::from_f64(config.noise),
            low,
            high,
            prior: Prior {
                initial: core::array::from_fn(|i| {
                    config.initial[i].map(|value| N::from_f64(value * scale[i]))
                }),
                weight: core::array::from_fn(|i| {
                    N::from_f64(config.deviation[i].map_or(0.0, |deviation| {
                        libm::sqrt(config.noise) / (deviation * scale[i])
                    }))
                }),
            },
            free: config.free,
            scale,
            bandwidth: config.bandwidth.map(|omega| N::from_f64(omega * m)),
        }
    }

    /// What was given as known.
    pub(super) fn given(&self) -> Prior<N> {
        self.prior
    }

    /// What a fit found, as known before the next: with ten times its deviations, and a fiftieth of
    /// the value on top, so that a servo may change.
    pub(super) fn known_from(&self, found: &Found<N>) -> Prior<N> {
        let noise = libm::sqrt(self.noise.to_f64());
        Prior {
            initial: core::array::from_fn(|i| {
                Some(N::from_f64(found.parameters[i].to_f64() * self.scale[i]))
            }),
            weight: core::array::from_fn(|i| {
                let deviation = 10.0 * libm::sqrt(found.covariance[i][i].to_f64())
                    + 0.02 * libm::fabs(found.parameters[i].to_f64());
                if self.free[i] && deviation > 0.0 {
                    N::from_f64(noise / (deviation * self.scale[i]))
                } else {
                    N::ZERO
                }
            }),
        }
    }

    /// Begins a fit over what the record holds.
    pub(super) fn begin(&self, blocks: usize, prior: Prior<N>) -> Fit<N> {
        Fit {
            prior,
            blocks,
            next: 0,
            stage: Stage::Survey,
            survey: Survey {
                path: N::ZERO,
                command: N::ZERO,
                command_square: N::ZERO,
                travel_square: N::ZERO,
                extreme: N::ZERO,
                direction: N::ZERO,
                reversals: 0,
            },
            omega: N::ZERO,
            correction: Innovation::critically_damped(N::ZERO),
            pass: Pass::at(&[N::ZERO; UNKNOWNS]),
            linear: [[N::ZERO; UNKNOWNS]; 2],
            standing_cost: N::ZERO,
            trial: [N::ZERO; UNKNOWNS],
            damping: N::ZERO,
            passes: 0,
            this: None,
            best: None,
        }
    }

    /// Goes on with a fit by one block of the record, or by what is between two passes. Answers
    /// once it has ended: with what it found, or none if the servo has not moved.
    pub(super) fn work<const W: usize>(
        &self,
        fit: &mut Fit<N>,
        record: &Record<N, W>,
    ) -> Option<Option<Found<N>>> {
        if fit.next < fit.blocks {
            if let Some(block) = record.get(fit.next) {
                match fit.stage {
                    Stage::Survey => fit.survey.observe(block),
                    Stage::Linear => {
                        let direction = direction(record, fit.next);
                        self.linear_block(fit, block, direction);
                    }
                    Stage::From(_) => self.model_block(fit, block),
                }
            }
            fit.next += 1;
            return None;
        }
        fit.next = 0;
        match fit.stage {
            Stage::Survey => {
                if fit.survey.path < N::from_f64(MOVED) {
                    return Some(None);
                }
                let blocks = fit.blocks as f64;
                let least = 6.0 / blocks;
                let most = 0.3;
                let turning = core::f64::consts::PI * f64::from(fit.survey.reversals) / blocks;
                let omega = self
                    .bandwidth
                    .map_or(turning, N::to_f64)
                    .max(least)
                    .min(most);
                fit.omega = N::from_f64(omega);
                fit.correction = Innovation::critically_damped(fit.omega);
                fit.stage = Stage::Linear;
                fit.pass = Pass::at(&[N::ZERO; UNKNOWNS]);
                self.add_initial(fit);
            }
            Stage::Linear => {
                let none = N::ZERO;
                fit.standing_cost = fit.pass.equations.cost();
                let mut free = self.free_unknowns();
                fit.linear[0] = fit.pass.equations.solve(none, &free);
                free[COULOMB] = false;
                fit.linear[1] = fit.pass.equations.solve(none, &free);
                fit.stage = Stage::From(0);
                self.begin_start(fit, 0);
            }
            Stage::From(start) => {
                if !self.end_pass(fit) {
                    self.begin_pass(fit);
                    return None;
                }
                let better =
                    |a: &Best<N>, b: &Best<N>| a.pass.equations.cost() < b.pass.equations.cost();
                if let Some(this) = fit.this.take()
                    && fit.best.is_none_or(|best| better(&this, &best))
                {
                    fit.best = Some(this);
                }
                let explained = fit.best.is_some_and(|best| {
                    best.pass.equations.cost().to_f64()
                        < Self::EXPLAINED * self.noise.to_f64() * fit.blocks as f64
                });
                let guesses = 3;
                let last = guesses + Self::LADDER.len() as u32;
                let next = start + 1;
                if next >= last || (explained && next >= guesses) {
                    return Some(self.found(fit));
                }
                fit.stage = Stage::From(next);
                self.begin_start(fit, next);
            }
        }
        None
    }

    fn free_unknowns(&self) -> [bool; UNKNOWNS] {
        let [a, b, c, d] = self.free;
        [a, b, c, d, true, true]
    }

    /// The unknowns to start from.
    fn begin_start(&self, fit: &mut Fit<N>, start: u32) {
        let mut trial = fit.linear[usize::from(start == 1)];
        // Where nothing better is known the gain is what the amplitudes suggest.
        let suggested = fit.survey.gain(fit.omega, fit.blocks);
        if trial[B] <= N::ZERO {
            trial[B] = suggested;
        }
        if start == 2 {
            if fit.prior.initial.iter().all(Option::is_none) {
                fit.next = fit.blocks;
                fit.this = None;
                fit.passes = Self::PASSES;
                return;
            }
            for (value, initial) in trial.iter_mut().zip(fit.prior.initial) {
                *value = initial.unwrap_or(*value);
            }
        }
        if let Some(&factor) = start
            .checked_sub(3)
            .and_then(|step| Self::LADDER.get(step as usize))
        {
            trial = [N::ZERO; UNKNOWNS];
            trial[B] = suggested * N::from_f64(factor);
        }
        for i in 0..4 {
            let value = if self.free[i] {
                trial[i]
            } else {
                self.prior.initial[i].unwrap_or(N::ZERO)
            };
            let value = if value.is_finite() { value } else { N::ZERO };
            trial[i] = value.limited(self.low[i], self.high[i]);
        }
        for value in &mut trial[POSITION..] {
            if !value.is_finite() {
                *value = N::ZERO;
            }
        }
        fit.trial = trial;
        fit.damping = N::from_f64(Self::FIRST_DAMPING);
        fit.passes = 0;
        fit.this = None;
        self.begin_pass(fit);
    }

    fn begin_pass(&self, fit: &mut Fit<N>) {
        fit.next = 0;
        fit.pass = Pass::at(&fit.trial);
        self.add_initial(fit);
        for i in 0..4 {
            let weight = fit.prior.weight[i];
            if let Some(initial) = fit.prior.initial[i].filter(|_| weight > N::ZERO) {
                let mut row = [N::ZERO; UNKNOWNS];
                row[i] = weight;
                let error = (initial - fit.trial[i]) * weight;
                fit.pass.equations.add(&row, error);
            }
        }
    }

    /// What is known of the initial state, as two more measurements.
    fn add_initial(&self, fit: &mut Fit<N>) {
        let noise = libm::sqrt(self.noise.to_f64());
        for (place, deviation) in [POSITION, VELOCITY].into_iter().zip(Self::INITIAL) {
            let mut row = [N::ZERO; UNKNOWNS];
            row[place] = N::from_f64(noise / deviation);
            let error = -(fit.trial[place] * row[place]);
            fit.pass.equations.add(&row, error);
        }
    }

    /// One block of the linear pass: the model stands, the servo's own motion drives the tangents.
    fn linear_block(&self, fit: &mut Fit<N>, block: &Block<N>, direction: N) {
        let pass = &mut fit.pass;
        let command = block.command;
        let correction = &fit.correction;
        // The model of zero gain: its velocity is what the correction gave it.
        let drive = correction.velocity * pass.model.error;
        let before = pass.model.velocity;
        let half = N::from_f64(0.5);
        let pull = correction.position * pass.model.error;
        pass.model.error = pass.model.error - pull - before - half * drive;
        pass.model.velocity = before + drive;
        let own = [-block.travel, command, -direction, N::ONE];
        for i in 0..UNKNOWNS {
            let position = pass.tangents.position[i];
            let mut change = -(correction.velocity * position);
            let mut ahead = N::ZERO;
            if let Some(&own) = own.get(i) {
                // A servo that friction holds answers to nothing.
                if direction != N::ZERO || i == A {
                    change += own;
                    ahead = if i == B { block.lead } else { N::ZERO };
                }
            }
            let velocity = pass.tangents.velocity[i];
            pass.tangents.position[i] =
                position - correction.position * position + velocity + half * change + ahead;
            pass.tangents.velocity[i] = velocity + change;
        }
        pass.model.observe(block.travel);
        pass.measure(&self.free);
    }

    fn model_block(&self, fit: &mut Fit<N>, block: &Block<N>) {
        let [a, b, c, d, _, _] = fit.trial;
        let parameters = ModelParameters {
            x: a,
            gain: b,
            coulomb: c,
            load: d,
        };
        let pass = &mut fit.pass;
        let before = pass.model.velocity;
        let response = self.step.step.response(a);
        let (way, phase) = pass.model.advance::<AbCoulombLoad, 4>(
            &self.step,
            &response,
            &parameters,
            block.command,
            &fit.correction,
        );
        pass.tangents
            .advance::<AbCoulombLoad, 4>(a, block.command, &fit.correction, way, phase);
        let moving = phase.moving_part();
        pass.model.error = pass.model.error - b * block.lead * moving;
        // The tangents of first order are half a block ahead of the motion.
        pass.tangents.position[B] += block.lead * moving;
        let change = pass.model.velocity - before;
        pass.speed_square += way * way;
        pass.acceleration_square += change * change;
        pass.model.observe(block.travel);
        pass.measure(&self.free);
    }

    /// Judges the pass; true if it was the last from this start.
    fn end_pass(&self, fit: &mut Fit<N>) -> bool {
        if fit.passes >= Self::PASSES {
            return true;
        }
        let cost = fit.pass.equations.cost();
        let mut little = false;
        let mut helped = cost.is_finite();
        if let Some(best) = &fit.this {
            let least = best.pass.equations.cost();
            little = (least - cost).magnitude() <= N::from_f64(Self::ENOUGH) * least;
            helped = helped && cost < least;
        }
        if helped {
            fit.this = Some(Best {
                unknowns: fit.trial,
                pass: fit.pass,
            });
        }
        let factor = if helped {
            1.0 / Self::CHANGE
        } else {
            Self::CHANGE
        };
        fit.damping = fit.damping * N::from_f64(factor);
        fit.passes += 1;
        let Some(best) = &fit.this else {
            return true;
        };
        if little || fit.passes >= Self::PASSES {
            return true;
        }
        fit.trial = self.next_trial(&best.unknowns, &best.pass.equations, fit.damping);
        false
    }

    /// A trial and a step from it. A parameter that stands at a bound and would leave it is kept
    /// there and the step taken without it: the others must not make up for what it may not do.
    fn next_trial(
        &self,
        unknowns: &[N; UNKNOWNS],
        equations: &NormalEquations<N, UNKNOWNS>,
        damping: N,
    ) -> [N; UNKNOWNS] {
        let mut free = self.free_unknowns();
        let mut step = equations.solve(damping, &free);
        for _ in 0..4 {
            let mut held = false;
            for i in 0..4 {
                let at = unknowns[i];
                let outward = (at <= self.low[i] && step[i] < N::ZERO)
                    || (at >= self.high[i] && step[i] > N::ZERO);
                if free[i] && outward {
                    free[i] = false;
                    held = true;
                }
            }
            if !held {
                break;
            }
            step = equations.solve(damping, &free);
        }
        core::array::from_fn(|i| {
            let moved = unknowns[i] + step[i];
            if i < 4 && moved.is_finite() {
                moved.limited(self.low[i], self.high[i])
            } else if moved.is_finite() {
                moved
            } else {
                unknowns[i]
            }
        })
    }

    fn found(&self, fit: &Fit<N>) -> Option<Found<N>> {
        /// The largest correlation from block to block that can be told from one.
        const MOST_CORRELATED: f64 = 0.999;
        let best = fit.best.as_ref()?;
        let cost = best.pass.equations.cost().to_f64();
        let freedom = fit.blocks.saturating_sub(UNKNOWNS).max(1) as f64;
        let unexplained = (cost / freedom).max(self.noise.to_f64());
        // Errors that go on from block to block as ρᵏ tell less than white ones.
        let correlation = if cost > 0.0 {
            (best.pass.lag_one.to_f64() / cost).clamp(0.0, MOST_CORRELATED)
        } else {
            0.0
        };
        let coloured = unexplained * (1.0 + correlation) / (1.0 - correlation);
        let covariance = best.pass.equations.covariance();
        let per = self.scale.map(|scale| 1.0 / scale);
        let at_bound = core::array::from_fn(|i| {
            let value = best.unknowns[i];
            self.free[i] && (value <= self.low[i] || value >= self.high[i])
        });
        let speed = best.pass.speed_square.to_f64();
        let acceleration = best.pass.acceleration_square.to_f64();
        let bandwidth = if speed > 0.0 {
            libm::sqrt(acceleration / speed) * per[A]
        } else {
            0.0
        };
        Some(Found {
            parameters: core::array::from_fn(|i| N::from_f64(best.unknowns[i].to_f64() * per[i])),
            covariance: core::array::from_fn(|i| {
                core::array::from_fn(|j| {
                    if self.free[i] && self.free[j] {
                        let value = covariance[i][j].to_f64();
                        N::from_f64(coloured * value * per[i] * per[j])
                    } else {
                        N::ZERO
                    }
                })
            }),
            unexplained: N::from_f64(unexplained),
            bandwidth: N::from_f64(bandwidth),
            at_bound,
            path: fit.survey.path,
            output_error: best.pass.last_error,
            acceleration: N::from_f64(
                libm::sqrt(fit.survey.command_square.to_f64() / fit.blocks as f64)
                    * best.unknowns[B].to_f64()
                    * per[B],
            ),
            left: cost / fit.standing_cost.to_f64().max(cost).max(f64::MIN_POSITIVE),
            only_direction: if fit.survey.reversals == 0 {
                fit.survey.direction
            } else {
                N::ZERO
            },
            noise: self.noise,
        })
    }
}

/// The shortest way, counts, from which anything can be learnt.
const MOVED: f64 = 8.0;

impl<N: Number> Survey<N> {
    fn observe(&mut self, block: &Block<N>) {
        /// A reversal is a way back of more counts than the encoder's edge can fake.
        const BACK: f64 = 2.0;
        let back = N::from_f64(BACK);
        self.path += block.travel.magnitude();
        self.travel_square += block.travel * block.travel;
        self.command += block.command;
        self.command_square += block.command * block.command;
        self.extreme += block.travel;
        let ahead = self.extreme * self.direction;
        if self.direction == N::ZERO {
            if self.extreme.magnitude() > back {
                self.direction = if self.extreme > N::ZERO {
                    N::ONE
                } else {
                    -N::ONE
                };
                self.extreme = N::ZERO;
            }
        } else if ahead > N::ZERO {
            self.extreme = N::ZERO;
        } else if ahead < -back {
            self.direction = -self.direction;
            self.extreme = N::ZERO;
            self.reversals += 1;
        }
    }

    /// The gain that turns the command's unrest into the motion's at the frequency ω.
    fn gain(&self, omega: N, blocks: usize) -> N {
        let count = blocks as f64;
        let mean = self.command.to_f64() / count;
        let unrest = (self.command_square.to_f64() / count - mean * mean).max(1e-12);
        let speed = self.travel_square.to_f64() / count;
        N::from_f64(omega.to_f64() * libm::sqrt(speed / unrest))
    }
}

impl<N: Number> Pass<N> {
    fn at(unknowns: &[N; UNKNOWNS]) -> Self {
        let mut tangents = Tangents::NONE;
        tangents.position[POSITION] = N::ONE;
        tangents.velocity[VELOCITY] = N::ONE;
        Self {
            model: ListeningModel {
                error: -unknowns[POSITION],
                velocity: unknowns[VELOCITY],
            },
            tangents,
            equations: NormalEquations::empty(),
            last_error: N::ZERO,
            lag_one: N::ZERO,
            speed_square: N::ZERO,
            acceleration_square: N::ZERO,
        }
    }

    #[inline]
    fn measure(&mut self, free: &[bool; 4]) {
        let mut row = self.tangents.position;
        for (entry, &free) in row.iter_mut().zip(free) {
            if !free {
                *entry = N::ZERO;
            }
        }
        let error = self.model.error;
        self.equations.add(&row, error);
        self.lag_one += error * self.last_error;
        self.last_error = error;
    }
}

/// The direction in which the servo moved during a block, zero where it stood: by its own travel,
/// or, if that is within the encoder's rounding, by that of its neighbours too.
fn direction<N: Number, const W: usize>(record: &Record<N, W>, index: usize) -> N {
    /// Travel beyond an edge that is crossed to and fro.
    const BEYOND: f64 = 1.5;
    let beyond = N::from_f64(BEYOND);
    let travel = |index: usize| record.get(index).map_or(N::ZERO, |block| block.travel);
    let own = travel(index);
    let around = own + travel(index + 1) + index.checked_sub(1).map_or(N::ZERO, travel);
    for way in [own, around] {
        if way > beyond {
            return N::ONE;
        }
        if way < -beyond {
            return -N::ONE;
        }
    }
    N::ZERO
}
