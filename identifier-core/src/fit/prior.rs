use super::survey::{larger, root};
use super::{FitResult, Fitter};
use crate::adaptation::IdentifiableSet;
use crate::constants::{Encode, encode};
use crate::measurement::angle::AngleSettings;
use crate::number::Number;
use crate::parameters::{PerQuantity, Term, Terms, Unknown, UsualSizes};

/// The configuration of a fitter, machine units of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FitterConfig<const P: usize = 4> {
    pub(crate) block: u32,
    /// Blocks in motion after which a first fit is overdue.
    pub(crate) patience: u32,
    pub(crate) noise: f64,
    pub(crate) low: [f64; P],
    pub(crate) high: [f64; P],
    pub(crate) initial: [Option<f64>; P],
    pub(crate) deviation: [Option<f64>; P],
    /// Unknowns that may be fitted; the others keep their initial value, or zero.
    pub(crate) free: [bool; P],
    pub(crate) bandwidth: Option<f64>,
    /// Standard deviation of the velocity before the first block, position units per sample, of a motion that begins at rest
    /// and is so short that a model may go through it alone; none of a servo that runs.
    pub(crate) at_first: Option<f64>,
    pub(crate) angle: AngleSettings<f64>,
    pub(crate) per_low_speed_velocity: f64,
    /// Terms that enter without evidence for them.
    pub(crate) demanded: Terms,
}

/// The knowledge before a fit, units of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Prior<N, const P: usize> {
    /// Initial values: one more start; for a term, that it is fitted.
    pub(super) initial: [Option<N>; P],
    /// Reciprocal standard deviations of the initial values; zero where nothing is known.
    pub(super) weight: [N; P],
}

encode! {
    [N: Encode, const P: usize] Prior<N, P> as "Prior" { initial, weight }
}

impl<N: Number, const P: usize> Prior<N, P> {
    /// The given initial values.
    pub(super) fn from_config(config: &FitterConfig<P>, scale: &[f64; P]) -> Self {
        Self {
            initial: core::array::from_fn(|i| {
                config.initial[i].map(|value| N::from_f64(value * scale[i]))
            }),
            weight: core::array::from_fn(|i| {
                N::from_f64(
                    config.deviation[i].map_or(0.0, |deviation| 1.0 / (deviation * scale[i])),
                )
            }),
        }
    }
}

impl<N, S, const P: usize> Fitter<N, S, P>
where
    N: Number,
    S: IdentifiableSet<P>,
{
    /// The prior from the settings.
    pub(crate) fn given_with_terms(&self) -> Prior<N, P> {
        self.prior
    }

    /// The same without terms.
    pub(crate) fn given(&self) -> Prior<N, P> {
        let mut prior = self.prior;
        for (initial, unknown) in prior.initial.iter_mut().zip(S::UNKNOWNS) {
            if unknown.term().is_some() {
                *initial = None;
            }
        }
        prior
    }

    /// A fit result as the prior of the next fit: with ten times its standard deviations, and a
    /// fiftieth of the value on top, so that a servo may change.
    pub(crate) fn known_from(&self, result: &FitResult<N, P>) -> Prior<N, P> {
        let entered = result.entered::<S>();
        let fitted = |i: usize| match S::UNKNOWNS[i].term() {
            Some(term) => entered.has(term),
            None => true,
        };
        let [errors, share] = [10.0, 0.02].map(N::from_f64);
        Prior {
            initial: core::array::from_fn(|i| {
                fitted(i).then(|| result.parameters[i] * self.scale[i])
            }),
            weight: core::array::from_fn(|i| {
                let deviation = errors * root(result.covariance[i][i])
                    + share * result.parameters[i].magnitude();
                if self.free[i] && fitted(i) && deviation > N::ZERO {
                    (deviation * self.scale[i]).reciprocal()
                } else {
                    N::ZERO
                }
            }),
        }
    }

    /// A prior with a term besides those of a result, of a size that is usual for what that says of the
    /// servo.
    pub(crate) fn admitting(
        &self,
        mut prior: Prior<N, P>,
        result: &FitResult<N, P>,
        term: Term,
    ) -> Prior<N, P> {
        let entered = result.entered::<S>().with(term);
        for (i, unknown) in S::UNKNOWNS.into_iter().enumerate() {
            let enters = unknown.term().is_some_and(|term| entered.has(term));
            if self.free[i] && enters && prior.initial[i].is_none() {
                prior.initial[i] = Some(self.prior.initial[i].unwrap_or(N::ZERO));
                let deviation = result.usual_size::<S>(unknown) * self.scale[i];
                prior.weight[i] = deviation.reciprocal();
            }
        }
        prior
    }

    /// The initial unknowns of the model of a fit with this prior; zero for those that are not known.
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
}

impl<N: Number, const P: usize> FitResult<N, P> {
    /// The terms that were fitted.
    pub(crate) fn entered<S: IdentifiableSet<P>>(&self) -> Terms {
        let mut entered = Terms::NONE;
        for (i, unknown) in S::UNKNOWNS.into_iter().enumerate() {
            if let Some(term) = unknown.term().filter(|_| self.covariance[i][i] > N::ZERO) {
                entered = entered.with(term);
            }
        }
        entered
    }

    /// The usual size of a term of this servo, machine units of a sample.
    pub(crate) fn usual_size<S: IdentifiableSet<P>>(&self, unknown: Unknown) -> N {
        /// Friction is at least this part of the motion's acceleration or bandwidth.
        const MIN_FRICTION_SHARE: f64 = 0.1;
        let of = |wanted: Unknown| {
            let place = S::UNKNOWNS.iter().position(|&own| own == wanted);
            place.map_or(N::ZERO, |i| self.parameters[i])
        };
        let fine = N::from_f64(MIN_FRICTION_SHARE);
        let acceleration = self.acceleration;
        let bandwidth = larger(self.bandwidth, N::from_f64(1e-9));
        unknown.usual_size(|share: N| UsualSizes {
            coulomb: share * larger(of(Unknown::Coulomb), fine * acceleration),
            other: PerQuantity {
                rate: share * larger(of(Unknown::A), fine * bandwidth),
                gain: share * of(Unknown::B),
                acceleration: share * acceleration,
                // Of the time in which the loop settles, at least a sample.
                time: larger(share * bandwidth.reciprocal(), N::ONE),
                command: share * acceleration * of(Unknown::B).reciprocal(),
            },
        })
    }
}
