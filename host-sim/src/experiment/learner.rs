//! The identifiers of the core behind one face, so that one loop serves them all.

use identifier_core::adaptation::GradientUpdate;
use identifier_core::control::{ControlSample, ControlState};
use identifier_core::identifier::{
    GaussNewtonIdentifier, GaussNewtonIdentifierState, GradientIdentifier, GradientIdentifierState,
};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;

/// What one sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen<N> {
    /// Output error, machine units.
    pub(crate) output_error: N,
    /// Whether a guard shortened the law's step.
    pub(crate) slowed: bool,
    /// Whether the model had to be started again.
    pub(crate) restarted: bool,
}

/// An identifier with its state.
pub(crate) trait Learner<N: Number, F> {
    /// Takes in a sample of the real loop.
    fn process(&mut self, real: &ControlSample<N>) -> Seen<N>;

    /// The estimates, SI.
    fn estimates(&self) -> ServoParameters;

    /// Their standard errors, SI, for laws that have them.
    fn standard_errors(&self) -> Option<ServoParameters>;

    /// Joins a loop in motion, before its next sample; the estimates are kept.
    fn join(&mut self, control: &ControlState<N, F>);
}

pub(crate) struct GradientLearner<N: Number, V: VelocityEstimate<N>, S, const P: usize> {
    identifier: GradientIdentifier<N, V, S, P>,
    state: GradientIdentifierState<N, V::State, P>,
}

impl<N, V, S, const P: usize> GradientLearner<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    pub(crate) fn new(identifier: GradientIdentifier<N, V, S, P>) -> Self {
        Self {
            state: identifier.start(),
            identifier,
        }
    }
}

impl<N, V, S, const P: usize> Learner<N, V::State> for GradientLearner<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    fn process(&mut self, real: &ControlSample<N>) -> Seen<N> {
        let seen = self.identifier.process(&mut self.state, real);
        Seen {
            output_error: seen.output_error,
            slowed: seen.update == GradientUpdate::Slowed,
            restarted: seen.restarted,
        }
    }

    fn estimates(&self) -> ServoParameters {
        self.identifier.estimates(&self.state)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        None
    }

    fn join(&mut self, control: &ControlState<N, V::State>) {
        self.identifier.join(&mut self.state, control);
    }
}

pub(crate) struct GaussNewtonLearner<N: Number, V: VelocityEstimate<N>, S, const P: usize> {
    identifier: GaussNewtonIdentifier<N, V, S, P>,
    state: GaussNewtonIdentifierState<N, V::State, P>,
}

impl<N, V, S, const P: usize> GaussNewtonLearner<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    pub(crate) fn new(identifier: GaussNewtonIdentifier<N, V, S, P>) -> Self {
        Self {
            state: identifier.start(),
            identifier,
        }
    }
}

impl<N, V, S, const P: usize> Learner<N, V::State> for GaussNewtonLearner<N, V, S, P>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    fn process(&mut self, real: &ControlSample<N>) -> Seen<N> {
        let seen = self.identifier.process(&mut self.state, real);
        Seen {
            output_error: seen.output_error,
            slowed: false,
            restarted: seen.restarted,
        }
    }

    fn estimates(&self) -> ServoParameters {
        self.identifier.estimates(&self.state)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        Some(self.identifier.standard_errors(&self.state))
    }

    fn join(&mut self, control: &ControlState<N, V::State>) {
        self.identifier.join(&mut self.state, control);
    }
}
