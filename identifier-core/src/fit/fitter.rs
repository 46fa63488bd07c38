use core::marker::PhantomData;

use super::block::Block;
use super::levenberg_marquardt::{Descent, DescentSettings, Explanation};
use super::pass::{Pass, PassSums};
use super::record::Record;
use super::survey::{MIN_TRAVEL_COUNTS, Survey, larger};
use super::{A, B, FitResult, FitterConfig, Prior};
use crate::adaptation::IdentifiableSet;
use crate::constants::{Encode, encode};
use crate::linalg::NormalEquations;
use crate::measurement::angle::AngleSettings;
use crate::measurement::direction::direction;
use crate::model::{Acting, FrictionStep, Innovation, KnownInputs, ModelValues};
use crate::number::Number;
use crate::parameters::{AbCoulombLoad, PerQuantity, Term, Terms, Unknown, unknowns_fingerprint};

/// Levenberg–Marquardt fit of the model, driven by the recorded command, to the recorded motion.
///
/// **Start.** With the model's parameters at zero and the *measured* motion in place of its own, the
/// output error is linear in the parameters, and the tangents are its regressors: one pass gives a
/// least-squares estimate that needs no first guess (equation error behind the filter 1/(p + ω)²;
/// Young, Recursive Estimation and Time-Series Analysis, 2nd edition 2011, chapter 8). It is solved
/// with and without friction. Given initial values are further starts, and if none of these explains
/// the motion, a geometric series of gains is tried.
///
/// **Passes.** From each start a [descent](Fitter::DESCENT) in passes of the
/// [`ObserverModel`](crate::model::ObserverModel); the start that explains the motion best wins. The
/// correction of the model keeps its output error bounded for every trial.
///
/// **Terms.** The model may have optional terms, those of the [`UnknownSet`] S. A term is fitted if the
/// prior has an initial value of it. Of those that may enter and have not, a last pass finds the one
/// that explains most of the errors that are left.
///
/// P is the number of unknowns in S, and Q that with the initial position and velocity of the model.
/// All is computed in units of a block: with m samples to a block, a m T, b (m T)²/ρ and so on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fitter<N, S = AbCoulombLoad, const P: usize = 4, const Q: usize = 6> {
    pub(super) step: FrictionStep<N>,
    /// Blocks in motion after which a first fit is overdue.
    pub(super) patience: u32,
    /// Variance of the position noise, counts².
    pub(super) noise: N,
    pub(super) low: [N; P],
    pub(super) high: [N; P],
    /// The given initial values.
    pub(super) prior: Prior<N, P>,
    /// The fitted unknowns: a parameter always, a term where it may enter.
    pub(super) free: [bool; P],
    /// Units of a block per unit of a sample.
    pub(super) scale: [N; P],
    pub(super) per_scale: [N; P],
    /// Weights of the initial position and velocity, see [`Fitter::INITIAL`].
    pub(super) initial_weight: [N; 2],
    pub(super) bandwidth: Option<N>,
    /// The angle as the models need it.
    pub(super) angle: AngleSettings<N>,
    per_low_speed_velocity: N,
    pub(super) demanded: Terms,
    set: PhantomData<S>,
}

encode! {
    [N: Encode, S: IdentifiableSet<P>, const P: usize, const Q: usize] Fitter<N, S, P, Q> as "Fitter" {
        step, patience, noise, low, high, prior, free, scale, per_scale, initial_weight, bandwidth, angle,
        per_low_speed_velocity, demanded, set,
    }
    also unknowns_fingerprint(&S::UNKNOWNS, Q)
}

/// A fit under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit<N, I, const P: usize, const Q: usize> {
    pub(super) prior: Prior<N, P>,
    /// The known inputs at the first block.
    pub(super) inputs: I,
    pub(super) blocks: usize,
    pub(super) next: usize,
    pub(super) stage: FitStage,
    pub(super) survey: Survey<N>,
    pub(super) omega: N,
    pub(super) correction: Innovation<N>,
    pub(super) pass: Pass<N, I, Q>,
    pub(super) linear: [[N; Q]; 2],
    /// The part of the motion that the command explains beyond friction and load, with the sign of the gain.
    pub(super) command_share: N,
    /// The cost of a model at rest.
    pub(super) standing_cost: N,
    pub(super) trial: [N; Q],
    pub(super) descent: Descent<N, Q, PassSums<N>>,
    pub(super) best: Option<Explanation<N, Q, PassSums<N>>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FitStage {
    Survey,
    Linear,
    From(u32),
    /// The term that explains the rest best is chosen.
    Weigh,
    /// The result is made.
    End,
}

impl<N, S, const P: usize, const Q: usize> Fitter<N, S, P, Q>
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

    /// A fit explains the motion if the variance of the errors is below this many times the
    /// encoder's; then no further start is tried.
    const EXPLAINED_VARIANCE: f64 = 2.0;

    /// The fastest correction, 1/block.
    const MAX_OMEGA: f64 = 0.3;

    pub(crate) fn new(config: &FitterConfig<P>) -> Self {
        const {
            assert!(
                Q == P + 2,
                "the unknowns of the set, then initial position and velocity"
            )
        };
        let m = f64::from(config.block.max(1));
        let scale = S::UNKNOWNS.map(|unknown| PerQuantity::block(m).get(unknown));
        let of = |values: &[f64; P]| core::array::from_fn(|i| N::from_f64(values[i] * scale[i]));
        let mut high: [N; P] = of(&config.high);
        let most = N::from_f64(crate::model::ZeroOrderHoldStep::<N>::LARGEST_RATE);
        high[A] = high[A].limited(-most, most);
        let mut low: [N; P] = of(&config.low);
        low[A] = low[A].limited(-most, most);
        Self {
            step: FrictionStep::new(),
            patience: config.patience,
            noise: N::from_f64(config.noise),
            low,
            high,
            prior: Prior::from_config(config, &scale),
            free: config.free,
            scale: scale.map(N::from_f64),
            per_scale: scale.map(|scale| N::from_f64(1.0 / scale)),
            initial_weight: Self::INITIAL
                .map(|deviation| N::from_f64(libm::sqrt(config.noise) / deviation)),
            bandwidth: config.bandwidth.map(|omega| N::from_f64(omega * m)),
            angle: AngleSettings::new(config.angle.revolution, config.angle.order),
            per_low_speed_velocity: N::from_f64(config.per_low_speed_velocity / m),
            demanded: config.demanded,
            set: PhantomData,
        }
    }

    /// Begins a fit to the record.
    pub(super) fn begin_fit(
        &self,
        blocks: usize,
        prior: Prior<N, P>,
        inputs: S::Inputs<N>,
    ) -> Fit<N, S::Inputs<N>, P, Q> {
        Fit {
            prior,
            inputs,
            blocks,
            next: 0,
            stage: FitStage::Survey,
            survey: Survey::NONE,
            omega: N::ZERO,
            correction: Innovation::critically_damped(N::ZERO),
            pass: Pass::at(&[N::ZERO; Q], P, inputs),
            linear: [[N::ZERO; Q]; 2],
            command_share: N::ZERO,
            standing_cost: N::ZERO,
            trial: [N::ZERO; Q],
            descent: Descent::begin(&Self::DESCENT),
            best: None,
        }
    }

    /// Continues a fit by one block of the record, or by the work between two passes. Returns once it
    /// has ended: with its result, or none if the servo has not moved.
    pub(super) fn work<const W: usize>(
        &self,
        fit: &mut Fit<N, S::Inputs<N>, P, Q>,
        record: &Record<N, S::Inputs<N>, W>,
    ) -> Option<Option<FitResult<N, P>>> {
        if fit.next < fit.blocks {
            if let Some(block) = record.get(fit.next) {
                match fit.stage {
                    FitStage::Survey => fit.survey.observe(block),
                    FitStage::Linear => {
                        let travel = |index: usize| Some(record.get(index)?.travel);
                        let direction = direction(fit.next, travel);
                        self.linear_block(fit, block, direction);
                    }
                    FitStage::From(_) | FitStage::Weigh => self.model_block(fit, block),
                    FitStage::End => {}
                }
            }
            fit.next += 1;
            return None;
        }
        fit.next = 0;
        match fit.stage {
            FitStage::Survey => {
                if fit.survey.path < N::from_f64(MIN_TRAVEL_COUNTS) {
                    return Some(None);
                }
                let per_block = N::from_count(fit.blocks.max(1) as i32).reciprocal();
                let least = N::from_f64(6.0) * per_block;
                let turning = N::from_f64(core::f64::consts::PI)
                    * N::from_count(fit.survey.reversals as i32)
                    * per_block;
                let omega = larger(self.bandwidth.unwrap_or(turning), least);
                fit.omega = omega.limited(N::ZERO, N::from_f64(Self::MAX_OMEGA));
                fit.correction = Innovation::critically_damped(fit.omega);
                fit.stage = FitStage::Linear;
                fit.pass = Pass::at(&[N::ZERO; Q], P, fit.inputs);
                self.add_initial(fit);
            }
            FitStage::Linear => {
                let none = N::ZERO;
                fit.standing_cost = fit.pass.equations.cost();
                let mut free = self.free_unknowns(&fit.prior);
                fit.linear[0] = fit.pass.equations.solve(none, &free);
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
                let pass = Explanation {
                    unknowns: fit.trial,
                    equations: fit.pass.equations,
                    sums: fit.pass.sums,
                };
                let free = self.free_unknowns(&fit.prior);
                let bounds = [&self.low, &self.high];
                if let Some(trial) = fit.descent.descend(&Self::DESCENT, pass, free, bounds) {
                    fit.trial = trial;
                    self.begin_pass(fit);
                    return None;
                }
                if let Some(this) = fit.descent.best()
                    && this.is_better_than(fit.best.as_ref())
                {
                    fit.best = Some(*this);
                }
                let explained = fit.best.is_some_and(|best| {
                    let explained = N::from_f64(Self::EXPLAINED_VARIANCE) * self.noise;
                    best.equations.cost() < explained * N::from_count(fit.blocks as i32)
                });
                let guesses = 3;
                let last = guesses + Self::GAIN_FACTORS.len() as u32;
                let next = match start + 1 {
                    Self::FROM_PRIOR if !Self::knows_a_parameter(&fit.prior) => guesses,
                    next => next,
                };
                if next >= last || (explained && next >= guesses) {
                    if !self.has_candidates(&fit.prior) {
                        // Apart from the end of the pass: a slice of its own.
                        fit.stage = FitStage::End;
                        fit.next = fit.blocks;
                        return None;
                    }
                    fit.trial = fit.best.as_ref()?.unknowns;
                    fit.stage = FitStage::Weigh;
                    self.begin_pass(fit);
                    return None;
                }
                fit.stage = FitStage::From(next);
                self.begin_start(fit, next);
            }
            FitStage::Weigh => return Some(self.result(fit, self.suggestion(fit))),
            FitStage::End => return Some(self.result(fit, None)),
        }
        None
    }

    /// The part of the errors that no other unknown explains and the gain does, 0 to 1, with its sign.
    fn command_share(equations: &NormalEquations<N, Q>, free: [bool; Q], gain: N) -> N {
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

    /// True if a term is to be fitted without evidence for it.
    pub(crate) fn demands(&self, term: Term) -> bool {
        self.demanded.has(term)
    }

    /// The unknowns that a fit with this prior fits.
    #[inline]
    pub(super) fn free_unknowns(&self, prior: &Prior<N, P>) -> [bool; Q] {
        core::array::from_fn(|i| match S::UNKNOWNS.get(i) {
            Some(unknown) => {
                self.free[i] && (unknown.term().is_none() || prior.initial[i].is_some())
            }
            None => true,
        })
    }

    /// The unknowns whose tangents a pass measures.
    #[inline]
    pub(super) fn measured_unknowns(&self, fit: &Fit<N, S::Inputs<N>, P, Q>) -> [bool; Q] {
        match fit.stage {
            FitStage::Weigh => core::array::from_fn(|i| self.free.get(i).is_none_or(|&free| free)),
            _ => self.free_unknowns(&fit.prior),
        }
    }

    /// The unknowns as those of a model.
    #[inline]
    pub(super) fn values(&self, unknowns: &[N; Q]) -> ModelValues<N> {
        let own = core::array::from_fn(|i| unknowns[i]);
        let mut values = ModelValues::from_values::<S, P>(&own);
        values.terms.per_low_speed_velocity = self.per_low_speed_velocity;
        values
    }

    /// The inputs of a model over a block, whose travel is known.
    #[inline]
    pub(super) fn acting(
        &self,
        inputs: &mut S::Inputs<N>,
        block: &Block<N>,
        values: &ModelValues<N>,
    ) -> Acting<N> {
        // Where the block ends; its middle is half of the travel back.
        inputs.take(
            &self.angle,
            &values.terms,
            block.travel,
            block.command,
            -block.travel,
        )
    }
}
