use core::marker::PhantomData;

use super::fitted::{COVARIANCE_FACTOR, FITTED, FirstFitSolution, GaussNewtonFitted};
use super::wait::FirstFitWait;
use crate::constants::{Encode, encode};
use crate::fit::{EarlyCommand, Fit, FitResult, Fitter, NumberedBlock, Record};
use crate::linalg::Factors;
use crate::model::IdentifiableSet;
use crate::number::Number;
use crate::parameters::{Parameter, Unknown, unknowns_fingerprint};
use crate::reason::Reason;

const COULOMB: usize = Parameter::Coulomb as usize;
const LOAD: usize = Parameter::Load as usize;

/// The background's half of the fast identifier. It collects at most W blocks that a
/// [`GaussNewtonRecursion`](super::GaussNewtonRecursion) of the same settings has recorded. It fits the parameters with
/// which the recursion starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonFitter<N, S, const P: usize, const W: usize = 256> {
    pub(crate) fitter: Fitter<N>,
    /// Blocks in motion after which a first fit is overdue.
    pub(crate) patience: u32,
    /// Those of the parameters that it fits.
    pub(crate) free: [bool; FITTED],
    pub(crate) set: PhantomData<S>,
}

encode! {
    [N: Encode, S: IdentifiableSet<P>, const P: usize, const W: usize]
    GaussNewtonFitter<N, S, P, W> as "GaussNewtonFitter" { fitter, patience, free, set }
    also unknowns_fingerprint(&S::UNKNOWNS, W)
}

/// The state of the background's half: the record and the fit in progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussNewtonFitterState<N, const W: usize = 256> {
    record: Record<N, W>,
    /// Blocks since the last fit began.
    fresh: usize,
    fit: Option<Fit<N, FITTED>>,
    /// The number of the block that follows the last.
    next: u32,
    wait: FirstFitWait,
    /// Variance of the position's noise, by the last result that was good.
    noise: Option<N>,
}

impl<N, S, const P: usize, const W: usize> GaussNewtonFitter<N, S, P, W>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// True if a recursion can start from a fit result. It waits for motion in both directions, which separates
    /// friction from load. It also waits for the time at which the command acts.
    fn is_good(result: &FitResult<N>, full: bool) -> bool {
        if full {
            result.is_good(0.2)
        } else {
            result.is_good(0.03) && !result.is_open()
        }
    }

    /// Motion in one direction shows only d − c sign(q̇). This makes c as large as possible and d the rest. So the
    /// result does not depend on where the fit ended.
    fn take_all_for_friction(&self, estimates: &mut [N; FITTED], direction: N) {
        if !self.free[COULOMB] || !self.free[LOAD] {
            return;
        }
        let resistance = estimates[COULOMB] - direction * estimates[LOAD];
        let friction = resistance.limited(N::ZERO, N::REACH);
        estimates[COULOMB] = friction;
        estimates[LOAD] = direction * (friction - resistance);
    }

    /// A fit result with its covariance in factors.
    fn explained(&self, result: &FitResult<N>) -> FirstFitSolution<N> {
        let factor = N::from_f64(COVARIANCE_FACTOR);
        // Motion in one direction determines only d − c sign(q̇), not c and d separately.
        let half = N::from_f64(0.5) * result.acceleration;
        let mut ambiguity = [N::ZERO; FITTED];
        ambiguity[COULOMB] = half;
        ambiguity[LOAD] = half * result.only_direction;
        let one_way = result.only_direction != N::ZERO;
        let covariance = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                let known = factor * result.covariance[i][j];
                if S::HAS_COULOMB && one_way && self.free[i] && self.free[j] {
                    (known + ambiguity[i] * ambiguity[j]).to_f64()
                } else {
                    known.to_f64()
                }
            })
        });
        let mut estimates = result.parameters;
        if one_way {
            self.take_all_for_friction(&mut estimates, result.only_direction);
        }
        let noise = self.fitter.relative(result.noise);
        FirstFitSolution {
            estimates,
            covariance: Factors::from_matrix(&covariance),
            unexplained: result.unexplained,
            noise,
            per_noise: noise.reciprocal_root(),
            bandwidth: result.bandwidth,
            acceleration: result.acceleration,
            one_way,
        }
    }

    /// The state at the start: an empty record.
    #[must_use]
    pub fn start(&self) -> GaussNewtonFitterState<N, W> {
        GaussNewtonFitterState {
            record: Record::empty(),
            fresh: 0,
            fit: None,
            next: 0,
            wait: FirstFitWait::START,
            noise: None,
        }
    }

    /// Takes a block, in the order in which they were recorded. One that does not follow the last begins the record
    /// anew and ends the fit in progress.
    pub fn take(&self, state: &mut GaussNewtonFitterState<N, W>, block: &NumberedBlock<N>) {
        state.wait.take(self.patience, block);
        if block.number != state.next {
            self.begin_anew(state);
        }
        state.next = block.number.wrapping_add(1);
        state.record.push(&block.block);
        state.fresh += 1;
    }

    /// Forgets the record, and the fit in progress.
    pub fn begin_anew(&self, state: &mut GaussNewtonFitterState<N, W>) {
        state.record.clear();
        state.fresh = 0;
        state.fit = None;
    }

    /// Continues the fit in progress by at most `budget` blocks, or begins one if it is time: when half of the record is
    /// there, and again whenever a quarter is new. A result from which the recursion can start ends the record. Another
    /// result is passed on only if it gives a new reason to report.
    pub fn work(
        &self,
        state: &mut GaussNewtonFitterState<N, W>,
        budget: u32,
    ) -> Option<GaussNewtonFitted<N>> {
        if state.fit.is_none() {
            if state.record.len() < W / 2 || state.fresh < W / 4 {
                return None;
            }
            state.fresh = 0;
            state.record.hold();
            state.fit = Some(self.fitter.begin_fit(state.record.len()));
        }
        let fit = state.fit.as_mut()?;
        let mut result = (0..budget).find_map(|_| self.fitter.work(fit, &state.record))?;
        state.fit = None;
        state.record.release();
        let is_full = state.record.is_full();
        if let Some(result) = &mut result
            && S::UNKNOWNS.contains(&Unknown::Delay)
        {
            // The recursion finds the time at which the command acts.
            result.early = EarlyCommand::No;
        }
        let good = result.filter(|result| Self::is_good(result, is_full));
        if let Some(good) = good {
            state.noise = Some(good.noise);
            self.begin_anew(state);
            state.wait.end();
        } else {
            let reason = result.map_or(Reason::TooLittleMotion, |result| result.rejection_reason());
            if !is_full || !state.wait.object(self.patience, reason) {
                return None;
            }
        }
        Some(GaussNewtonFitted {
            last: state.next.wrapping_sub(1),
            explained: good.map(|result| self.explained(&result)),
        })
    }

    /// Why no first fit has succeeded after a second of motion: see [`Report`](crate::identify::Report).
    #[must_use]
    pub fn rejection_reason(&self, state: &GaussNewtonFitterState<N, W>) -> Option<Reason> {
        state.wait.reason(self.patience)
    }

    /// Standard deviation of the position's noise: see [`Report`](crate::identify::Report).
    #[must_use]
    pub fn noise(&self, state: &GaussNewtonFitterState<N, W>) -> Option<f64> {
        Some(libm::sqrt(state.noise?.to_f64()))
    }
}
