use core::marker::PhantomData;

use super::gain::KalmanGain;
use super::levenberg_marquardt::{Descent, DescentSettings, Explanation};
use super::pass::{Pass, PassSums};
use super::record::Blocks;
use super::statistics::{MIN_TRAVEL_COUNTS, RecordStatistics, root};
use super::{A, B, FitResult, FitterConfig, Prior, QUANTISATION_VARIANCE};
use crate::constants::{Encode, encode};
use crate::linalg::NormalEquations;
use crate::measurement::direction::direction;
use crate::model::{FrictionStep, IdentifiableSet, ModelValues};
use crate::number::Number;
use crate::parameters::{PerQuantity, Unknown, Unknowns, unknowns_fingerprint};

/// Levenberg–Marquardt fit of the model, driven by the recorded command, to the recorded motion.
///
/// **Start.** The model's parameters are zero, and the *measured* motion replaces its own. The output error is then
/// linear in the parameters, and the tangents are its regressors. One pass gives a least-squares estimate that needs no
/// first guess. This is the equation error behind a filter of second order (Young, Recursive Estimation and Time-Series
/// Analysis, 2nd edition 2011, chapter 8). It is solved with and without friction. Given initial values are further
/// starts. If none of these explains the motion, a geometric series of gains is tried.
///
/// **Passes.** From each start a [descent](Descent) in passes of the `ObserverModel`; the start that explains the
/// motion best wins. The gain of a Kalman filter keeps the model with the motion. So its output error is bounded for
/// every trial, and white if the model is complete.
///
/// **Horizons.** The best memory of the filter is unknown. After the starts the fit is repeated
/// with a shorter and a longer one. The fit with the least uncertainty counts. The variances include the differences of
/// the others beyond chance.
///
/// **Noise.** The noise of the position is the scale of the innovations, so that it is no setting.
///
/// **Terms.** The model may have optional terms, those of the set S. A term is fitted if the
/// prior has an initial value of it.
///
/// P is the number of unknowns in S. All is computed in units of a block. With m samples to a block these are a m T, b
/// (m T)²/ρ and so on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitter<N, S = Unknowns<4>, const P: usize = 4> {
    pub(super) step: FrictionStep<N>,
    /// The least variance of the position noise, counts²: that of its rounding.
    pub(super) noise: N,
    pub(super) low: [N; P],
    pub(super) high: [N; P],
    /// The given initial values.
    pub(super) prior: Prior<N, P>,
    /// The fitted unknowns: a parameter always, a term if it may enter.
    pub(super) free: [bool; P],
    /// Units of a block per unit of a sample.
    pub(super) scale: [N; P],
    pub(super) per_scale: [N; P],
    /// The horizon that follows from a given bandwidth, blocks.
    horizon: Option<N>,
    /// Variance of the velocity before the first block of a motion that begins at rest, counts² per block².
    pub(super) at_first: Option<N>,
    /// Rad per count of the angle from where the record begins, and 1/v_s, blocks per count.
    pub(super) resolution: N,
    pub(super) per_low_speed_velocity: N,
    set: PhantomData<S>,
}

encode! {
    [N: Encode, S: IdentifiableSet<P>, const P: usize] Fitter<N, S, P> as "Fitter" {
        step, noise, low, high, prior, free, scale, per_scale, horizon, at_first, resolution,
        per_low_speed_velocity, set,
    }
    also unknowns_fingerprint(&S::UNKNOWNS, P)
}

/// A fit in progress. [`Fitter::work`] makes a result of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit<N, const P: usize> {
    pub(super) prior: Prior<N, P>,
    pub(super) blocks: usize,
    pub(super) next: usize,
    pub(super) stage: FitStage,
    pub(super) statistics: RecordStatistics<N>,
    /// That of the gain, blocks.
    pub(super) horizon: N,
    /// Variance of the position noise, counts².
    pub(super) noise: N,
    pub(super) pass: Pass<N, P>,
    pub(super) linear: [[N; P]; 2],
    /// The part of the motion that the linear estimate leaves.
    pub(super) linear_left: Option<N>,
    /// The part of the motion that the command explains beyond friction and load, with the sign of the gain.
    pub(super) command_share: N,
    /// The cost of a model at rest, and the part of it that the first horizon's fit leaves.
    pub(super) standing_cost: N,
    pub(super) left: N,
    pub(super) trial: [N; P],
    pub(super) descent: Descent<N, P, PassSums<N, P>>,
    pub(super) best: Option<Explanation<N, P, PassSums<N, P>>>,
    /// The part of the squared differences between horizons that chance does not explain.
    pub(super) disagreement: [N; P],
}

impl<N: Number, const P: usize> Fit<N, P> {
    /// The part of the squared motion that its least-squares estimate leaves, which the first two passes make.
    pub fn linear_left(&self) -> Option<N> {
        self.linear_left
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FitStage {
    RecordStatistics,
    Linear,
    From(u32),
    /// At a further horizon.
    At(usize),
    /// The result is made.
    End,
}

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// The descent from a start.
    pub(super) const DESCENT: DescentSettings = DescentSettings {
        damping: 1e-3,
        max_passes: 12,
        min_change: 1e-4,
    };

    /// A fit explains the motion if the variance of the errors is below this many times the encoder's. Then no further
    /// start is tried.
    const EXPLAINED_VARIANCE: f64 = 2.0;

    /// Horizons, blocks: that of the starts, a shorter and a longer one.
    const HORIZONS: [f64; 3] = [21.0, 6.0, 74.0];

    /// The same for a motion that begins at rest. The last is an open-loop simulation, and that one counts.
    const HORIZONS_FROM_REST: [f64; 3] = {
        let [start, _, longer] = Self::HORIZONS;
        [start, longer, Self::OPEN_LOOP_MEMORY]
    };

    /// More than the blocks of any record.
    pub(super) const OPEN_LOOP_MEMORY: f64 = 1e4;

    /// The longest horizon, of the record.
    const LONGEST_HORIZON: f64 = 1.0 / 4.0;

    /// A fitter for a short motion from rest, or nearly. The motion is short enough for an open-loop simulation. It
    /// fits all unknowns, in machine units of a sample, to a record whose blocks have this number of samples.
    ///
    /// - `speed` is the standard deviation of the velocity before the first block, counts per sample.
    /// - `low` and `high` are the bounds of the unknowns; a is kept within ±[`FrictionStep::LARGEST_RATE`] of a block.
    /// - `initial` are values to start from. `deviation` are their standard deviations, above zero. None without
    ///   prior knowledge.
    pub fn from_rest(
        block: u32,
        speed: f64,
        [low, high]: [[f64; P]; 2],
        [initial, deviation]: [[Option<f64>; P]; 2],
    ) -> Self {
        Self::new(&FitterConfig {
            block,
            noise: QUANTISATION_VARIANCE,
            low,
            high,
            initial,
            deviation,
            free: [true; P],
            bandwidth: None,
            at_first: Some(speed),
        })
    }

    /// The same for a set with gravity or friction at low speed. Gravity is a function of the angle from where the motion
    /// begins, and the load that there is at its beginning: g_s sin q + g_c (cos q − 1). `resolution` is in rad per count,
    /// and the speed v_s below which friction rises in counts per sample.
    #[must_use]
    pub fn with_terms(self, resolution: f64, low_speed: f64) -> Self {
        let samples = self.scale[A].to_f64();
        Self {
            resolution: N::from_f64(resolution),
            per_low_speed_velocity: N::from_f64(1.0 / (low_speed * samples)),
            ..self
        }
    }

    pub(crate) fn new(config: &FitterConfig<P>) -> Self {
        let m = f64::from(config.block.max(1));
        let scale = S::UNKNOWNS.map(|unknown| PerQuantity::block(m).get(unknown));
        let of = |values: &[f64; P]| core::array::from_fn(|i| N::from_f64(values[i] * scale[i]));
        let mut high: [N; P] = of(&config.high);
        let most = N::from_f64(FrictionStep::<N>::LARGEST_RATE);
        high[A] = high[A].limited(-most, most);
        let mut low: [N; P] = of(&config.low);
        low[A] = low[A].limited(-most, most);
        Self {
            step: FrictionStep::new(),
            noise: N::from_f64(config.noise),
            low,
            high,
            prior: Prior::from_config(config, &scale),
            free: config.free,
            scale: scale.map(N::from_f64),
            per_scale: scale.map(|scale| N::from_f64(1.0 / scale)),
            horizon: config.bandwidth.map(|omega| N::from_f64(1.0 / (omega * m))),
            at_first: config
                .at_first
                .map(|velocity| N::from_f64(velocity * m * velocity * m)),
            resolution: N::ZERO,
            per_low_speed_velocity: N::ZERO,
            set: PhantomData,
        }
    }

    /// The initial unknowns of the model of a fit with this prior; zero for those without a given value.
    pub(super) fn begin_values(&self, prior: &Prior<N, P>) -> [N; P] {
        core::array::from_fn(|i| {
            let own = |values: &[Option<N>; P]| values.get(i).copied().flatten();
            let fixed = own(&self.prior.initial);
            own(&prior.initial).or(fixed).unwrap_or(N::ZERO)
        })
    }

    /// True if a fit has an initial value of one of the parameters.
    pub(super) fn knows_a_parameter(prior: &Prior<N, P>) -> bool {
        let mut known = prior.initial.iter().zip(S::UNKNOWNS);
        known.any(|(initial, unknown)| initial.is_some() && unknown.term().is_none())
    }

    /// Begins a fit to a record of this number of blocks.
    pub fn begin_fit(&self, blocks: usize) -> Fit<N, P> {
        Fit {
            prior: self.prior,
            blocks,
            next: 0,
            stage: FitStage::RecordStatistics,
            statistics: RecordStatistics::default(),
            horizon: N::ONE,
            noise: self.noise,
            pass: Pass::at_first(KalmanGain::begin(N::ONE, N::ZERO), N::ZERO),
            linear: [[N::ZERO; P]; 2],
            linear_left: None,
            command_share: N::ZERO,
            standing_cost: N::ZERO,
            left: N::ONE,
            trial: [N::ZERO; P],
            descent: Descent::begin(&Self::DESCENT),
            best: None,
            disagreement: [N::ZERO; P],
        }
    }

    /// A horizon of a fit to a record of this number of blocks. None if it is close to the first.
    fn horizon(&self, place: usize, blocks: usize) -> Option<N> {
        /// The least ratio of horizons.
        const APART: f64 = 1.5;
        let share = N::from_f64(Self::LONGEST_HORIZON);
        let longest = (share * N::from_count(blocks as i32)).larger(N::ONE);
        let horizons = match self.at_first {
            Some(_) => Self::HORIZONS_FROM_REST,
            None => Self::HORIZONS,
        };
        let [first, ..] = horizons.map(N::from_f64);
        let first = self.horizon.unwrap_or(first).limited(N::ONE, longest);
        if place == 0 {
            return Some(first);
        }
        let own = *horizons.get(place)?;
        if own >= Self::OPEN_LOOP_MEMORY {
            return Some(N::from_f64(own));
        }
        let own = N::from_f64(own).limited(N::ONE, longest);
        let apart = N::from_f64(APART);
        (self.horizon.is_none() && (own > apart * first || own * apart < first)).then_some(own)
    }

    /// Continues a fit by one block of the record, or by the work between two passes. Returns once it
    /// has ended: with its result, or none if the servo has not moved.
    pub fn work(
        &self,
        fit: &mut Fit<N, P>,
        record: &impl Blocks<N>,
    ) -> Option<Option<FitResult<N, P>>> {
        if fit.next < fit.blocks {
            if let Some(block) = record.block(fit.next) {
                match fit.stage {
                    FitStage::RecordStatistics => fit.statistics.observe(block),
                    FitStage::Linear => {
                        let travel = |index: usize| Some(record.block(index)?.travel);
                        let direction = direction(fit.next, travel);
                        self.linear_block(fit, record, block, direction);
                    }
                    FitStage::From(_) | FitStage::At(_) => self.model_block(fit, record, block),
                    FitStage::End => {}
                }
            }
            fit.next += 1;
            return None;
        }
        fit.next = 0;
        match fit.stage {
            FitStage::RecordStatistics => {
                if fit.statistics.path < N::from_f64(MIN_TRAVEL_COUNTS) {
                    return Some(None);
                }
                fit.horizon = self.horizon(0, fit.blocks).unwrap_or(N::ONE);
                fit.stage = FitStage::Linear;
                fit.pass = self.first_pass(fit);
            }
            FitStage::Linear => {
                let none = N::ZERO;
                fit.standing_cost = fit.pass.equations.cost();
                let mut free = self.free_unknowns(&fit.prior);
                fit.linear[0] = fit.pass.equations.solve(none, &free);
                let left = fit.standing_cost - fit.pass.equations.explained_by(&free);
                fit.linear_left = Some(left * fit.standing_cost.reciprocal());
                fit.command_share =
                    Self::command_share(&fit.pass.equations, free, fit.linear[0][B]);
                for (free, unknown) in free.iter_mut().zip(S::UNKNOWNS) {
                    *free &= unknown != Unknown::Coulomb;
                }
                fit.linear[1] = fit.pass.equations.solve(none, &free);
                fit.stage = FitStage::From(0);
                self.begin_start(fit, 0);
            }
            FitStage::From(start) => {
                if self.descends(fit) {
                    return None;
                }
                if let Some(this) = fit.descent.best().copied()
                    && this.is_better_than(fit.best.as_ref())
                {
                    self.keep(fit, this);
                }
                let explained = fit.best.is_some_and(|best| {
                    let explained = N::from_f64(Self::EXPLAINED_VARIANCE) * fit.noise;
                    best.equations.cost() < explained * N::from_count(fit.blocks as i32)
                });
                let guesses = 3;
                let last = guesses + Self::GAIN_FACTORS.len() as u32;
                let next = match start + 1 {
                    Self::FROM_PRIOR if !Self::knows_a_parameter(&fit.prior) => guesses,
                    next => next,
                };
                if next < last && !(explained && next >= guesses) {
                    fit.stage = FitStage::From(next);
                    self.begin_start(fit, next);
                    return None;
                }
                let cost = fit.best.as_ref()?.equations.cost();
                let standing = fit.standing_cost.larger(cost);
                if standing > N::ZERO {
                    fit.left = cost * standing.reciprocal();
                }
                self.begin_horizon(fit, 1);
            }
            FitStage::At(place) => {
                if self.descends(fit) {
                    return None;
                }
                if let Some(this) = fit.descent.best().copied() {
                    let noise = fit.noise;
                    if self.at_first.is_some() || self.compare(fit, &this) {
                        self.keep(fit, this);
                    }
                    fit.noise = noise.smaller(self.errors(fit, &this).noise);
                }
                self.begin_horizon(fit, place + 1);
            }
            FitStage::End => return Some(self.result(fit)),
        }
        None
    }

    /// The least distance back of a reversal that separates friction from load. It exceeds the counts that an edge of
    /// the encoder or its noise produces at rest, and a part of the whole path.
    pub(super) fn reversal(&self, fit: &Fit<N, P>) -> N {
        const COUNTS: f64 = 2.0;
        const SHARE: f64 = 0.01;
        let [counts, share] = [COUNTS, SHARE].map(N::from_f64);
        (counts * root(self.relative(fit.noise))).larger(share * fit.statistics.path)
    }

    /// Takes a pass of a descent. True if the descent continues.
    fn descends(&self, fit: &mut Fit<N, P>) -> bool {
        let pass = Explanation {
            unknowns: fit.trial,
            equations: fit.pass.equations,
            sums: fit.pass.sums,
        };
        let free = self.free_unknowns(&fit.prior);
        let bounds = [&self.low, &self.high];
        let next = fit.descent.descend(&Self::DESCENT, pass, free, bounds);
        if let Some(trial) = next {
            fit.trial = trial;
            self.begin_pass(fit);
        }
        next.is_some()
    }

    /// Keeps the best pass of a descent.
    fn keep(&self, fit: &mut Fit<N, P>, pass: Explanation<N, P, PassSums<N, P>>) {
        fit.noise = self.errors(fit, &pass).noise;
        fit.best = Some(pass);
    }

    /// Continues from the best unknowns at a further horizon, or ends.
    fn begin_horizon(&self, fit: &mut Fit<N, P>, place: usize) {
        let Some(best) = &fit.best else { return };
        fit.trial = best.unknowns;
        let next = (place..Self::HORIZONS.len())
            .find_map(|place| Some((place, self.horizon(place, fit.blocks)?)));
        if let Some((place, horizon)) = next {
            fit.stage = FitStage::At(place);
            fit.horizon = horizon;
            fit.descent = Descent::begin(&Self::DESCENT);
            self.begin_pass(fit);
        } else {
            // Apart from the end of the pass: a slice of its own.
            fit.stage = FitStage::End;
            fit.next = fit.blocks;
        }
    }

    /// The part of the errors that no other unknown explains and the gain does, 0 to 1, with its sign.
    fn command_share(equations: &NormalEquations<N, P>, free: [bool; P], gain: N) -> N {
        let mut others = free;
        others[B] = false;
        let without = equations.explained_by(&others);
        let rest = equations.cost() - without;
        if rest <= N::ZERO {
            return N::ZERO;
        }
        let share = (equations.explained_by(&free) - without) * rest.reciprocal();
        if gain < N::ZERO { -share } else { share }
    }

    /// The unknowns that a fit with this prior fits.
    #[inline]
    pub(super) fn free_unknowns(&self, prior: &Prior<N, P>) -> [bool; P] {
        core::array::from_fn(|i| match S::UNKNOWNS.get(i) {
            Some(unknown) => {
                self.free[i] && (unknown.term().is_none() || prior.initial[i].is_some())
            }
            None => true,
        })
    }

    /// The unknowns as those of a model.
    #[inline]
    pub(super) fn values(&self, unknowns: &[N; P]) -> ModelValues<N> {
        let own = core::array::from_fn(|i| unknowns[i]);
        let mut values = ModelValues::from_values::<S, P>(&own);
        if S::HAS_COULOMB_TERMS {
            values.terms.per_low_speed_velocity = self.per_low_speed_velocity;
        }
        values
    }
}
