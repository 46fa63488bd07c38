//! The loop of a drive, controller and identifier with their states, in single precision.

mod single;
#[cfg(feature = "terms")]
mod unknowns;
/// A build without terms estimates the four parameters.
#[cfg(not(feature = "terms"))]
mod unknowns {
    pub(super) const UNKNOWNS: usize = 4;
    pub(super) type WithTerms = identifier_core::parameters::Unknowns<UNKNOWNS>;
}

use drive_link::{Estimator, LoopSettings, NotAllowed, Why};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor};
use identifier_core::identifier::{
    GaussNewtonFitted, GradientCorrection, MeasuredPiece, NumberedBlock,
};
use identifier_core::parameters::PerParameter;

pub(crate) use self::single::{ClosedLoop, Identifier, Learnt, Settled};
use crate::built;

/// Blocks of Gauss–Newton's start record on the chip.
pub(crate) const BLOCKS: usize = 64;

/// The result of Gauss–Newton's first fit, which the background makes: for a recursion with terms too.
pub(crate) type Fitted = GaussNewtonFitted<f32>;

/// A part of the motion of a run that its estimator hands to the background.
#[derive(Debug)]
pub(crate) enum MotionPart {
    /// A block for Gauss–Newton's first fit.
    Block(NumberedBlock<f32>),
    /// A piece for the memory of the gradient, with the estimates at its end.
    Piece(MeasuredPiece<f32>, PerParameter<f32>),
}

/// What the background has made of it.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Learning {
    /// Gauss–Newton's first fit.
    Fit(Fitted),
    /// A correction of the gradient's estimates.
    Correction(GradientCorrection<f32>),
}

/// A control step with its count, or the reason why it was not taken.
pub(crate) type StepResult<S, A> = Result<
    (ControlSample<f32>, i32),
    ControlStepError<<S as PositionSensor>::Error, <A as Actuator<f32>>::Error>,
>;

/// Checks a control step before anything is learnt from it, and may end the run.
///
/// A trait and not a closure, because a method can be inlined into every estimator's sample by attribute.
pub(crate) trait StepMonitor {
    /// How a run ends.
    type End;

    /// The command that acts in place of the controller's.
    fn acting(&mut self, sample: &ControlSample<f32>) -> f32;

    /// The step to learn from, unless the run ends with it.
    fn check<S: PositionSensor, A: Actuator<f32>>(
        self,
        step: StepResult<S, A>,
    ) -> Result<ControlSample<f32>, Self::End>;
}

/// A servo as one controller hands it over to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Handover {
    /// The last sample of the controller that has held it.
    pub(crate) last: ControlSample<f32>,
    /// The count of that sample.
    pub(crate) count: i32,
    /// The count from which targets and travel count.
    pub(crate) origin: i32,
    /// The count at which the servo rested before, and is to rest again.
    pub(crate) rest_count: i32,
    /// Steps of a step input came meanwhile, or may have.
    pub(crate) missed_steps: bool,
}

/// At rest, before the first sample.
pub(crate) const AT_REST: ControlSample<f32> = ControlSample {
    error: 0.0,
    increment: 0.0,
    velocity: 0.0,
    command: 0.0,
};

/// Commands that a delay may hold back: six samples, above which a loop should be slower.
const MAX_DELAYED: usize = 8;

/// Checks settings without building their loop.
///
/// # Errors
/// The settings ask for terms of an estimator or a build that has none.
pub(crate) fn check(settings: &LoopSettings) -> Result<(), NotAllowed> {
    let terms = &settings.core.identifier.terms;
    if !terms.demanded.is_empty() && settings.law != Estimator::GaussNewton {
        return Err(NotAllowed::new("required_terms", Why::NotHere));
    }
    match terms.demanded.is_empty() {
        true => Ok(()),
        false => built::has_terms(),
    }
}
