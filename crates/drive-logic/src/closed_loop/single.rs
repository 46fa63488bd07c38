//! The loop in single precision, with one of several estimators. The choice is made once, when the loop is built, and
//! costs a branch or two per sample.

use drive_link::{Estimates, Estimator, NotAllowed};
use identifier_core::control::{ControlSample, Setpoint, Shaped, ShapedState};
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::identifier::{
    ExpectedMotion, GaussNewtonRecursion, GradientMemory, GradientRecursion, IdentifiableSet,
    Identify, MachineEstimates, ServoLoop, ServoLoopState, SettledEstimates, Update,
};
use identifier_core::measurement::{LowPass, VelocityEstimate};
use identifier_core::model::{Amplifier, AmplifierState};
use identifier_core::parameters::{
    IdentifiedServo, ParameterSet, ServoParameters, Unknown, Unknowns,
};
use identifier_core::settings::{FromSettings, Settings};

use super::unknowns::{UNKNOWNS, WithTerms};
use super::{BLOCKS, Handover, Learning, MAX_DELAYED, MotionPart, StepMonitor};
use crate::conversion;

type Velocity = LowPass<f32>;

/// Gauss–Newton in the sample interrupt; its first fit is made in the background.
type Recursion = GaussNewtonRecursion<f32, Unknowns<4>, 4, BLOCKS>;

/// The same with the terms that are demanded.
type Termed = GaussNewtonRecursion<f32, WithTerms, UNKNOWNS, BLOCKS>;

/// Controller and identifier of a servo, with their states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClosedLoop(Estimators);

#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "terms",
    expect(
        clippy::large_enum_variant,
        reason = "one is kept, in a static place, and any estimator may follow"
    )
)]
enum Estimators {
    Gradient(With<Gradient>),
    GradientWithFriction(With<GradientWithFriction>),
    GaussNewton(With<Recursion>),
    WithTerms(With<Termed>),
}

type Gradient = GradientRecursion<f32, Velocity, Unknowns<2>, 2>;
type GradientWithFriction = GradientRecursion<f32, Velocity, Unknowns<3>, 3>;

/// The identifier of a loop, which converts its numbers to SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Identifier {
    Gradient(Gradient),
    GradientWithFriction(GradientWithFriction),
    GaussNewton(Recursion),
    WithTerms(Termed),
}

/// State of an identifier, machine units; [`Identifier::estimates`] converts it to SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Learnt {
    Gradient(<Gradient as Identify<f32>>::Snapshot),
    GradientWithFriction(<GradientWithFriction as Identify<f32>>::Snapshot),
    GaussNewton(<Recursion as Identify<f32>>::Snapshot),
    WithTerms(<Termed as Identify<f32>>::Snapshot),
}

/// Estimates that have settled, with their errors, machine units; [`Identifier::settled_in`] converts them to SI.
pub(crate) type Settled = SettledEstimates<f32, 4>;

/// A loop with one identifier, which learns behind the amplifier if one is declared.
#[derive(Debug, Clone, Copy, PartialEq)]
struct With<I: Identify<f32>> {
    servo_loop: ServoLoop<f32, Velocity, I, Shaped<f32>>,
    amplifier: Option<(
        Amplifier<f32, MAX_DELAYED>,
        AmplifierState<f32, MAX_DELAYED>,
    )>,
    state:
        ServoLoopState<f32, <Velocity as VelocityEstimate<f32>>::State, I::State, ShapedState<f32>>,
}

impl<I: Identify<f32> + FromSettings> With<I> {
    /// The loop of an estimator. Built where it is returned: copies of it would add up on the stack.
    #[inline(never)]
    fn build(
        settings: &Settings,
        amplifier: Amplifier<f32, MAX_DELAYED>,
        law: impl FnOnce(Self) -> Estimators,
    ) -> Result<ClosedLoop, NotAllowed> {
        let servo_loop: ServoLoop<_, _, I, _> = settings.build()?;
        Ok(ClosedLoop(law(Self {
            state: servo_loop.start(0),
            servo_loop,
            amplifier: amplifier.acts().then(|| (amplifier, amplifier.start())),
        })))
    }
}

impl<I: Identify<f32>> With<I> {
    /// Where the servo is: terms that depend on the angle have it from the counter, in every run alike.
    fn place(&mut self, count: i32) {
        let identifier = self.servo_loop.identifier();
        let position = identifier.increment(count);
        identifier.place(self.state.identification_mut(), position);
    }

    #[inline]
    fn learnt(&self) -> I::Snapshot {
        let identifier = self.servo_loop.identifier();
        identifier.snapshot(self.state.identification())
    }
}

impl<S, const P: usize> With<GaussNewtonRecursion<f32, S, P, BLOCKS>>
where
    S: IdentifiableSet<P>,
{
    fn with_errors(&self, found: Estimates) -> Estimates {
        let identifier = self.servo_loop.identifier();
        let report = identifier.report(self.state.identification());
        let error_of = |unknown: Unknown| {
            let has_entered = unknown.term().is_some_and(|term| report.entered.has(term));
            report.standard_error_of(unknown).filter(|_| has_entered)
        };
        Estimates {
            standard_errors: report.errors_of_parameters(),
            terms: found.terms.map(|sizes| sizes.with_errors(error_of)),
            ..found
        }
    }

    #[inline(never)]
    fn know(&mut self, servo: &IdentifiedServo, motion: &ExpectedMotion) {
        let identifier = self.servo_loop.identifier();
        *self.state.identification_mut() = identifier.start_from_known(servo, motion);
    }

    #[inline]
    fn exchange<'a>(&mut self, hand_on: impl FnOnce(MotionPart) -> Option<&'a Learning>) -> bool {
        let identifier = self.servo_loop.identifier();
        let state = self.state.identification_mut();
        let Some(block) = identifier.take_block(state) else {
            return false;
        };
        if let Some(Learning::Fit(fitted)) = hand_on(MotionPart::Block(block)) {
            identifier.take_over(state, fitted);
        }
        true
    }
}

impl<S, const P: usize> With<GradientRecursion<f32, Velocity, S, P>>
where
    S: ParameterSet<P>,
{
    #[inline]
    fn exchange<'a>(&mut self, hand_on: impl FnOnce(MotionPart) -> Option<&'a Learning>) -> bool {
        let identifier = self.servo_loop.identifier();
        let state = self.state.identification_mut();
        let Some(piece) = identifier.take_piece(state) else {
            return false;
        };
        let estimates = identifier.machine_estimates(state);
        if let Some(Learning::Correction(found)) = hand_on(MotionPart::Piece(piece, estimates)) {
            identifier.take_over(state, found);
        }
        true
    }
}

/// The same for the loop of each estimator.
macro_rules! for_each_estimator {
    ($laws:expr, $own:pat => $done:expr) => {
        match $laws {
            Estimators::Gradient($own) => $done,
            Estimators::GradientWithFriction($own) => $done,
            Estimators::GaussNewton($own) => $done,
            Estimators::WithTerms($own) => $done,
        }
    };
}

/// The same in the variant of the estimator's name.
macro_rules! variant_of_each {
    ($laws:expr, $own:pat => $of:ident($done:expr)) => {
        match $laws {
            Estimators::Gradient($own) => $of::Gradient($done),
            Estimators::GradientWithFriction($own) => $of::GradientWithFriction($done),
            Estimators::GaussNewton($own) => $of::GaussNewton($done),
            Estimators::WithTerms($own) => $of::WithTerms($done),
        }
    };
}

impl ClosedLoop {
    /// A loop at rest at count zero, behind the amplifier of its servo.
    ///
    /// # Errors
    /// The setting that is not allowed.
    #[inline]
    pub(crate) fn new(
        settings: &Settings,
        law: Estimator,
        amplifier: Amplifier<f32, MAX_DELAYED>,
    ) -> Result<Self, NotAllowed> {
        match law {
            Estimator::Gradient { friction: false } => {
                With::build(settings, amplifier, Estimators::Gradient)
            }
            Estimator::Gradient { friction: true } => {
                With::build(settings, amplifier, Estimators::GradientWithFriction)
            }
            Estimator::GaussNewton if settings.identifier.terms.demanded.is_empty() => {
                With::build(settings, amplifier, Estimators::GaussNewton)
            }
            Estimator::GaussNewton => With::build(settings, amplifier, Estimators::WithTerms),
        }
    }

    /// Puts a loop that has done no sample yet at another count, holding a load from rest.
    pub(crate) fn start(&mut self, Handover { last, count, .. }: &Handover) {
        for_each_estimator!(&mut self.0, own => {
            own.servo_loop.hold_from(&mut own.state, *count, last);
            own.place(*count);
        });
    }

    /// The same, holding a servo that another controller has held until then.
    pub(crate) fn take_over(&mut self, Handover { last, count, .. }: &Handover) {
        for_each_estimator!(&mut self.0, own => {
            own.servo_loop.take_over(&mut own.state, *count, last);
            own.place(*count);
        });
    }

    /// A sample: measure, control, act as the monitor has it; have the step checked, with its count; then learn, while the
    /// command acts.
    ///
    /// # Errors
    /// The monitor ended the run. After a [`ControlStepError`](identifier_core::drive::ControlStepError) the actuator was
    /// released.
    #[inline]
    pub(crate) fn sample<S: PositionSensor, A: Actuator<f32>, M: StepMonitor>(
        &mut self,
        setpoint: Setpoint<f32>,
        sensor: &mut S,
        actuator: &mut A,
        mut monitor: M,
    ) -> Result<(ControlSample<f32>, Update<f32>), M::End> {
        for_each_estimator!(&mut self.0, own => {
            let acting = |sample: &ControlSample<f32>| monitor.acting(sample);
            let step =
                own.servo_loop.control_step_with(&mut own.state, setpoint, sensor, actuator, acting);
            let sample = monitor.check::<S, A>(step.map(|sample| (sample, own.state.count())))?;
            let mut acted = sample;
            if let Some((amplifier, state)) = &mut own.amplifier {
                acted.command = amplifier.process(state, sample.command);
            }
            Ok((sample, own.servo_loop.learn(&mut own.state, &acted)))
        })
    }

    /// The state of its identifier.
    #[inline]
    pub(crate) fn learnt(&self) -> Learnt {
        variant_of_each!(&self.0, own => Learnt(own.learnt()))
    }

    /// Its identifier.
    pub(crate) fn identifier(&self) -> Identifier {
        variant_of_each!(&self.0, own => Identifier(*own.servo_loop.identifier()))
    }

    /// Estimates with their standard errors, SI, where its estimator has them; none before the first fit.
    #[inline(never)]
    pub(crate) fn all_estimates(&self) -> Option<Estimates> {
        let found = self.identifier().estimates(&self.learnt())?;
        Some(match &self.0 {
            Estimators::GaussNewton(own) => own.with_errors(found),
            Estimators::WithTerms(own) => own.with_errors(found),
            _ => found,
        })
    }

    /// Starts Gauss–Newton from an identified servo and skips its first fit. Another estimator starts as always.
    pub(crate) fn know(&mut self, servo: &IdentifiedServo, motion: &ExpectedMotion) {
        match &mut self.0 {
            Estimators::GaussNewton(own) => own.know(servo, motion),
            Estimators::WithTerms(own) => own.know(servo, motion),
            _ => {}
        }
    }

    /// The estimates of Gauss–Newton without terms, if they have settled, and begins a check of them.
    #[cold]
    #[inline(never)]
    pub(crate) fn examine(&mut self) -> Option<Settled> {
        let Estimators::GaussNewton(own) = &mut self.0 else {
            return None;
        };
        let (identifier, state) = (own.servo_loop.identifier(), own.state.identification_mut());
        let settled = identifier.settled(state);
        identifier.check_estimates(state);
        settled
    }

    /// Transfers the part of the motion that the sample completed, if any. It continues from what has come back. True if
    /// there was a part.
    #[inline]
    pub(crate) fn exchange<'a>(
        &mut self,
        hand_on: impl FnOnce(MotionPart) -> Option<&'a Learning>,
    ) -> bool {
        for_each_estimator!(&mut self.0, own => own.exchange(hand_on))
    }

    /// The memory of its estimator, which works in the background; none of Gauss–Newton.
    pub(crate) fn memory(&self) -> Option<GradientMemory<f32>> {
        match &self.0 {
            Estimators::Gradient(own) => Some(own.servo_loop.identifier().memory()),
            Estimators::GradientWithFriction(own) => Some(own.servo_loop.identifier().memory()),
            Estimators::GaussNewton(_) | Estimators::WithTerms(_) => None,
        }
    }
}

impl Identifier {
    /// Estimates, SI; none before the first fit, and of a loop of another estimator.
    #[inline(never)]
    pub(crate) fn estimates(&self, learnt: &Learnt) -> Option<Estimates> {
        use conversion::estimates;
        let found = match (self, learnt) {
            (Self::Gradient(own), Learnt::Gradient(found)) => return Some(estimates(own, found)),
            (Self::GradientWithFriction(own), Learnt::GradientWithFriction(found)) => {
                return Some(estimates(own, found));
            }
            (Self::GaussNewton(own), Learnt::GaussNewton(found)) => estimates(own, found),
            (Self::WithTerms(own), Learnt::WithTerms(found)) => estimates(own, found),
            _ => return None,
        };
        (found.servo.b > 0.0).then_some(found)
    }

    /// Settled estimates and their standard errors, SI; none of a loop of another estimator.
    pub(crate) fn settled_in(&self, settled: &Settled) -> Option<[ServoParameters; 2]> {
        match self {
            Self::GaussNewton(own) => Some(own.settled_in(settled)),
            _ => None,
        }
    }
}
