//! The loop of a drive, with one law or another, in single precision or fixed point: the choice is made
//! once, when it is built, and costs a branch or two a sample.

use drive_link::{Estimates, Format, Law, LoopSettings, NotAllowed, Why};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor, Setpoint, control_step};
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{
    DiagonalGradientIdentifier, ExpectedMotion, GaussNewtonFitted, GaussNewtonRecursion, Identify,
    NumberedBlock, RecordBlocks, ServoLoop, ServoLoopState, Update,
};
use identifier_core::measurement::velocity::{LowPass, LowPassState};
use identifier_core::parameters::{Ab, AbCoulomb, AbCoulombLoad, IdentifiedServo, ServoParameters};
use identifier_core::settings::{FromSettings, Settings, SettingsError};

use crate::fixed_loop::FixedLoop;
use crate::held::Held;
use crate::{fixed_loop, parts};

type Velocity = LowPass<f32>;

/// Blocks of Gauss–Newton's start record on the chip.
pub(crate) const BLOCKS: usize = 64;

/// Gauss–Newton in the sample interrupt; its first fit is made elsewhere.
pub(crate) type Recursion = GaussNewtonRecursion<f32, AbCoulombLoad, 4, BLOCKS>;

/// Controller and identifier of a servo, with their states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClosedLoop(Laws);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Laws {
    Gradient(With<Gradient>),
    GradientWithFriction(With<GradientWithFriction>),
    GaussNewton(With<Recursion>),
    Fixed(FixedLoop),
}

type Gradient = DiagonalGradientIdentifier<f32, Velocity, Ab, 2>;
type GradientWithFriction = DiagonalGradientIdentifier<f32, Velocity, AbCoulomb, 3>;

/// What a loop has learnt, in a few words: [`ClosedLoop::estimates`] says it in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Learnt {
    Gradient(<Gradient as Identify<f32>>::Snapshot),
    GradientWithFriction(<GradientWithFriction as Identify<f32>>::Snapshot),
    GaussNewton(<Recursion as Identify<f32>>::Snapshot),
    Fixed(<fixed_loop::Identifier as Identify<Word>>::Snapshot),
}

/// A control step with its count, or why it was not taken.
pub(crate) type Looked<S, A> = Result<
    (ControlSample<f32>, i32),
    ControlStepError<<S as PositionSensor>::Error, <A as Actuator<f32>>::Error>,
>;

/// What looks at a control step before anything is learnt from it, and may end the run.
///
/// A trait where a closure would do, because a method can be told to be inlined into every law's sample.
pub(crate) trait Look {
    /// How a run ends.
    type End;

    /// The step to learn from, unless the run ends with it.
    fn look<S: PositionSensor, A: Actuator<f32>>(
        self,
        taken: Looked<S, A>,
    ) -> Result<ControlSample<f32>, Self::End>;
}

/// A loop with one identifier.
#[derive(Debug, Clone, Copy, PartialEq)]
struct With<I: Identify<f32>> {
    servo_loop: ServoLoop<f32, Velocity, I>,
    state: ServoLoopState<f32, LowPassState<f32>, I::State>,
}

impl<I: Identify<f32> + FromSettings> With<I> {
    fn build(settings: &Settings) -> Result<Self, SettingsError> {
        let servo_loop: ServoLoop<f32, Velocity, I> = settings.build()?;
        Ok(Self {
            state: servo_loop.start(0),
            servo_loop,
        })
    }
}

impl<I: Identify<f32>> With<I> {
    #[inline]
    fn learnt(&self) -> I::Snapshot {
        let identifier = self.servo_loop.identifier();
        identifier.snapshot(self.state.identification())
    }

    fn estimates(&self, learnt: &I::Snapshot) -> Estimates {
        parts::estimates(self.servo_loop.identifier(), learnt)
    }
}

/// Does the same with the loop, whatever its law.
macro_rules! whatever_law {
    ($laws:expr, $own:pat => $done:expr, $fixed:pat => $fixed_done:expr) => {
        match $laws {
            Laws::Gradient($own) => $done,
            Laws::GradientWithFriction($own) => $done,
            Laws::GaussNewton($own) => $done,
            Laws::Fixed($fixed) => $fixed_done,
        }
    };
}

impl ClosedLoop {
    /// A loop at rest at count zero.
    ///
    /// # Errors
    /// The setting that is not allowed.
    pub(crate) fn new(settings: &LoopSettings) -> Result<Self, NotAllowed> {
        let LoopSettings { core, law, format } = settings;
        let laws = match (format, law) {
            (Format::Single, Law::Gradient { friction: false }) => {
                With::build(core).map(Laws::Gradient)
            }
            (Format::Single, Law::Gradient { friction: true }) => {
                With::build(core).map(Laws::GradientWithFriction)
            }
            (Format::Single, Law::GaussNewton) => With::build(core).map(Laws::GaussNewton),
            (Format::Fixed, Law::Gradient { friction: false }) => {
                FixedLoop::new(core).map(Laws::Fixed)
            }
            (Format::Fixed, _) => return Err(parts::refusal("law", Why::NotHere)),
        };
        laws.map(Self).map_err(parts::not_allowed)
    }

    /// Puts a loop that has done no sample yet at another count.
    pub(crate) fn start(&mut self, count: i32) {
        whatever_law!(
            &mut self.0,
            own => own.state.begin_at(count),
            fixed => fixed.start(count)
        );
    }

    /// The same, holding a servo that another controller has held until then.
    pub(crate) fn take_over(&mut self, held: &Held) {
        let Held { last, count, .. } = held;
        whatever_law!(
            &mut self.0,
            own => own.servo_loop.take_over(&mut own.state, *count, last),
            fixed => fixed.take_over(held)
        );
    }

    /// A sample: measure, control, act; have it looked at, with its count; then learn, while the command
    /// acts. What looks at it may end it.
    ///
    /// # Errors
    /// [`ControlStepError`], the actuator was released; or why what looks at it ended it.
    #[inline]
    pub(crate) fn sample<S: PositionSensor, A: Actuator<f32>, L: Look>(
        &mut self,
        setpoint: Setpoint<f32>,
        sensor: &mut S,
        actuator: &mut A,
        watch: L,
    ) -> Result<(ControlSample<f32>, Update<f32>), L::End> {
        whatever_law!(
            &mut self.0,
            own => {
                let taken = control_step(&own.servo_loop, &mut own.state, setpoint, sensor, actuator);
                let sample = watch.look::<S, A>(taken.map(|sample| (sample, own.state.count())))?;
                Ok((sample, own.servo_loop.learn(&mut own.state, &sample)))
            },
            fixed => {
                let taken = fixed.control(setpoint, sensor, actuator);
                let sample = watch.look::<S, A>(taken.map(|sample| (sample, fixed.count())))?;
                Ok((sample, fixed.learn()))
            }
        )
    }

    /// What it has learnt so far.
    #[inline]
    pub(crate) fn learnt(&self) -> Learnt {
        match &self.0 {
            Laws::Gradient(own) => Learnt::Gradient(own.learnt()),
            Laws::GradientWithFriction(own) => Learnt::GradientWithFriction(own.learnt()),
            Laws::GaussNewton(own) => Learnt::GaussNewton(own.learnt()),
            Laws::Fixed(fixed) => Learnt::Fixed(fixed.learnt()),
        }
    }

    /// The standard errors of what it has learnt, SI, where its law knows them.
    pub(crate) fn standard_errors(&self) -> Option<ServoParameters> {
        let Laws::GaussNewton(own) = &self.0 else {
            return None;
        };
        let identifier = own.servo_loop.identifier();
        identifier.standard_errors(own.state.identification())
    }

    /// What was learnt as estimates, SI; none before the first fit, and of a loop of another law.
    pub(crate) fn estimates(&self, learnt: &Learnt) -> Option<Estimates> {
        match (&self.0, learnt) {
            (Laws::Gradient(own), Learnt::Gradient(found)) => Some(own.estimates(found)),
            (Laws::GradientWithFriction(own), Learnt::GradientWithFriction(found)) => {
                Some(own.estimates(found))
            }
            (Laws::GaussNewton(own), Learnt::GaussNewton(found)) => {
                Some(own.estimates(found)).filter(|found| found.b > 0.0)
            }
            (Laws::Fixed(fixed), Learnt::Fixed(found)) => Some(fixed.estimates(found)),
            _ => None,
        }
    }

    /// Has Gauss–Newton go on from a servo that was identified, in place of its first fit; another law
    /// begins as it does.
    pub(crate) fn know(&mut self, servo: &IdentifiedServo, motion: &ExpectedMotion) {
        if let Laws::GaussNewton(own) = &mut self.0 {
            let identifier = own.servo_loop.identifier();
            *own.state.identification_mut() = identifier.start_from_known(servo, motion);
        }
    }

    /// Hands on the block of Gauss–Newton's record that the sample completed, if it did, and goes on
    /// from a first fit that has come back.
    #[inline]
    pub(crate) fn exchange(
        &mut self,
        hand_on: impl FnOnce(NumberedBlock<f32>) -> Option<GaussNewtonFitted<f32, AbCoulombLoad, 4>>,
    ) {
        let Laws::GaussNewton(own) = &mut self.0 else {
            return;
        };
        let identifier = own.servo_loop.identifier();
        let state = own.state.identification_mut();
        if let Some(block) = identifier.take_block(state)
            && let Some(fitted) = hand_on(block)
        {
            identifier.take_over(state, &fitted);
        }
    }
}
