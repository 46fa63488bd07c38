//! Velocity estimate and parameter set, chosen at run time.

use identifier_core::measurement::velocity::{
    AveragedDifference, BackwardDifference, LowPass, VelocityEstimate,
};
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;

use super::{Scenario, Velocity, WithSet};

/// A computation that works with any velocity estimate; the scenario says with which.
pub trait WithVelocity<N: Number> {
    /// Its result.
    type Output;

    /// Does it.
    fn with<V: VelocityEstimate<N> + 'static>(self) -> Self::Output;
}

/// A computation that works with any velocity estimate and parameter set; the scenario says with
/// which.
pub trait WithTypes<N: Number> {
    /// Its result.
    type Output;

    /// Does it, for the P parameters of S.
    fn with<V, S, const P: usize>(self) -> Self::Output
    where
        V: VelocityEstimate<N> + 'static,
        S: ParameterSet<P> + 'static;
}

impl Velocity {
    /// Does a computation with this estimate.
    pub fn with<N: Number, W: WithVelocity<N>>(self, work: W) -> W::Output {
        match self {
            Self::LowPass => work.with::<LowPass<N>>(),
            Self::Difference => work.with::<BackwardDifference>(),
            Self::AveragedDifference => work.with::<AveragedDifference<N>>(),
        }
    }
}

impl Scenario {
    /// Does a computation with the velocity estimate and the parameter set of the scenario.
    pub fn with_types<N: Number, W: WithTypes<N>>(&self, work: W) -> W::Output {
        struct Outer<'a, W>(&'a Scenario, W);

        impl<N: Number, W: WithTypes<N>> WithVelocity<N> for Outer<'_, W> {
            type Output = W::Output;

            fn with<V: VelocityEstimate<N> + 'static>(self) -> W::Output {
                let Self(scenario, work) = self;
                scenario.model_set().with(Inner::<N, V, W> {
                    work,
                    types: std::marker::PhantomData,
                })
            }
        }

        struct Inner<N, V, W> {
            work: W,
            types: std::marker::PhantomData<(N, V)>,
        }

        impl<N: Number, V: VelocityEstimate<N> + 'static, W: WithTypes<N>> WithSet for Inner<N, V, W> {
            type Output = W::Output;

            fn with<S: ParameterSet<P> + 'static, const P: usize>(self) -> W::Output {
                self.work.with::<V, S, P>()
            }
        }

        self.velocity.with(Outer(self, work))
    }
}
