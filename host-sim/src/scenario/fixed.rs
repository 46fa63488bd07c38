//! The types of a loop in fixed point, chosen at run time.

use identifier_core::fixed_point::{FixedAveragedDifference, FixedLowPass, FixedVelocity};
use identifier_core::measurement::velocity::BackwardDifference;
use identifier_core::parameters::ParameterSet;

use super::{Scenario, Velocity, WithSet};

/// A computation that works with any velocity estimate and parameter set on words.
pub(crate) trait WithWords {
    /// Its result.
    type Output;

    /// Does it, for the P parameters of S.
    fn with<V, S, const P: usize>(self) -> Self::Output
    where
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static;
}

impl Scenario {
    /// Does a computation with the velocity estimate and the parameter set of the scenario.
    pub(crate) fn with_words<W: WithWords>(&self, work: W) -> W::Output {
        struct Chosen<V, W> {
            work: W,
            velocity: std::marker::PhantomData<V>,
        }

        impl<V: FixedVelocity + 'static, W: WithWords> WithSet for Chosen<V, W> {
            type Output = W::Output;

            fn with<S: ParameterSet<P> + 'static, const P: usize>(self) -> W::Output {
                self.work.with::<V, S, P>()
            }
        }

        fn set<V: FixedVelocity + 'static, W: WithWords>(
            scenario: &Scenario,
            work: W,
        ) -> W::Output {
            scenario.model_set().with(Chosen::<V, W> {
                work,
                velocity: std::marker::PhantomData,
            })
        }

        match self.velocity {
            Velocity::LowPass => set::<FixedLowPass, W>(self, work),
            Velocity::Difference => set::<BackwardDifference, W>(self, work),
            Velocity::AveragedDifference => set::<FixedAveragedDifference, W>(self, work),
        }
    }
}
