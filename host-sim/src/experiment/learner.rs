//! The identifiers of the core behind one face, so that one loop serves them all.

use identifier_core::adaptation::GradientUpdate;
use identifier_core::control::{ControlSample, ControlState};
use identifier_core::identifier::{
    GaussNewtonIdentifier, GaussNewtonIdentifierState, GradientIdentifier, GradientIdentifierState,
    Recorded, Window, WindowIdentifier, WindowState,
};
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use identifier_core::parameters::ParameterSet;

use crate::scenario::WindowSettings;

/// What one sample showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen<N> {
    /// Output error, machine units, for laws with a model.
    pub(crate) output_error: Option<N>,
    /// Whether a guard shortened the law's step.
    pub(crate) slowed: bool,
    /// Whether the model had to be started again.
    pub(crate) restarted: bool,
}

impl<N: Number> Seen<N> {
    /// What a method without a model sees.
    pub(crate) fn nothing() -> Self {
        Self {
            output_error: None,
            slowed: false,
            restarted: false,
        }
    }
}

/// What the controller was given, machine units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Given<N: Number, F> {
    /// Its state before the sample.
    pub(crate) before: ControlState<N, F>,
    /// Reference, position and injection.
    pub(crate) sample: Recorded<N>,
}

/// An identifier with its state.
pub(crate) trait Learner<N: Number, F> {
    /// Takes in a sample: what the controller was given, its state before that and what it did.
    fn process(&mut self, given: &Given<N, F>, real: &ControlSample<N>) -> Seen<N>;

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
    fn process(&mut self, _: &Given<N, V::State>, real: &ControlSample<N>) -> Seen<N> {
        let seen = self.identifier.process(&mut self.state, real);
        Seen {
            output_error: Some(seen.output_error),
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

/// Recursive Gauss–Newton that takes over from a window once that is full: what the first samples
/// showed, seen again from near the truth, is worth more than what the recursion made of it on the
/// way there.
pub(crate) struct GaussNewtonLearner<
    N: Number,
    V: VelocityEstimate<N>,
    S,
    const P: usize,
    const Q: usize,
> {
    identifier: GaussNewtonIdentifier<N, V, S, P>,
    state: GaussNewtonIdentifierState<N, V::State, P>,
    first: Option<WindowLearner<N, V, S, P, Q>>,
}

impl<N, V, S, const P: usize, const Q: usize> GaussNewtonLearner<N, V, S, P, Q>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    pub(crate) fn new(
        identifier: GaussNewtonIdentifier<N, V, S, P>,
        window: WindowIdentifier<N, V, S, P, Q>,
        settings: WindowSettings,
    ) -> Self {
        Self {
            state: identifier.start(),
            identifier,
            first: Some(WindowLearner::new(window, settings)),
        }
    }
}

impl<N, V, S, const P: usize, const Q: usize> Learner<N, V::State>
    for GaussNewtonLearner<N, V, S, P, Q>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    fn process(&mut self, given: &Given<N, V::State>, real: &ControlSample<N>) -> Seen<N> {
        let seen = self.identifier.process(&mut self.state, real);
        if let Some(first) = &mut self.first {
            first.process(given, real);
            if first.window.is_full() {
                first.fit();
                let WindowLearner {
                    identifier: window,
                    state,
                    ..
                } = first;
                // Without a fit there is nothing to take over.
                if window.fits(state) > 0 {
                    self.identifier.adopt(&mut self.state, window.found(state));
                }
                self.first = None;
            }
        }
        Seen {
            output_error: Some(seen.output_error),
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
        if let Some(first) = &mut self.first {
            first.join(control);
        }
        self.identifier.join(&mut self.state, control);
    }
}

pub(crate) struct WindowLearner<
    N: Number,
    V: VelocityEstimate<N>,
    S,
    const P: usize,
    const Q: usize,
> {
    identifier: WindowIdentifier<N, V, S, P, Q>,
    state: WindowState<N, V::State, P, Q>,
    window: Window<N, { WindowSettings::LONGEST }>,
    fit_every: u32,
    until_fit: u32,
}

impl<N, V, S, const P: usize, const Q: usize> WindowLearner<N, V, S, P, Q>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    pub(crate) fn new(
        identifier: WindowIdentifier<N, V, S, P, Q>,
        settings: WindowSettings,
    ) -> Self {
        Self {
            state: identifier.start(),
            identifier,
            window: Window::of_length(settings.length),
            fit_every: settings.fit_every,
            until_fit: settings.fit_every,
        }
    }

    /// A fit over all that the window holds; a simulator has all the background time it wants.
    fn fit(&mut self) {
        self.identifier.begin(&mut self.state, &self.window);
        while !self
            .identifier
            .work(&mut self.state, &self.window, u32::MAX)
        {}
    }
}

impl<N, V, S, const P: usize, const Q: usize> Learner<N, V::State> for WindowLearner<N, V, S, P, Q>
where
    N: Number,
    V: VelocityEstimate<N>,
    S: ParameterSet<P>,
{
    fn process(&mut self, given: &Given<N, V::State>, _: &ControlSample<N>) -> Seen<N> {
        self.identifier.record(
            &mut self.state,
            &mut self.window,
            &given.before,
            given.sample,
        );
        self.until_fit -= 1;
        if self.until_fit == 0 {
            self.until_fit = self.fit_every;
            self.fit();
        }
        Seen {
            output_error: Some(self.identifier.output_error(&self.state)),
            slowed: false,
            restarted: false,
        }
    }

    fn estimates(&self) -> ServoParameters {
        self.identifier.estimates(&self.state)
    }

    fn standard_errors(&self) -> Option<ServoParameters> {
        Some(self.identifier.standard_errors(&self.state))
    }

    fn join(&mut self, _: &ControlState<N, V::State>) {
        self.window.clear();
    }
}
