//! The loop of a drive, with one law or another, in single precision or fixed point: the choice is made once, when it is built,
//! and costs a branch or two a sample.
//!
//! Gauss–Newton begins with a fit, whose work is for the background. But what the fit reads is what the
//! interrupt writes, so here it is done in the interrupt too, after everything else of the sample, a
//! block of the record at a time: [`ClosedLoop::work`].

use drive_link::{Estimates, Format, Law, LoopSettings, NotAllowed, Why};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, ControlStepError, PositionSensor, Setpoint, control_step};
use identifier_core::fixed_point::Word;
use identifier_core::identifier::{
    DiagonalGradientIdentifier, GaussNewtonIdentifier, IdentifierError, Identify, Seen, ServoLoop,
    ServoLoopState,
};
use identifier_core::measurement::velocity::{LowPass, LowPassState};
use identifier_core::parameters::{Ab, AbCoulomb, AbCoulombLoad};
use identifier_core::settings::{FromSettings, Settings};

use crate::fixed_loop::{self, FixedLoop};
use crate::parts;

type Velocity = LowPass<f32>;

/// Blocks of Gauss–Newton's start record on the chip.
const BLOCKS: usize = 64;

/// Controller and identifier of a servo, with their states. Gauss–Newton's start record has W blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClosedLoop<const W: usize = BLOCKS>(Laws<W>);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Laws<const W: usize> {
    Gradient(With<Gradient>),
    GradientWithFriction(With<GradientWithFriction>),
    GaussNewton(With<GaussNewton<W>>),
    Fixed(FixedLoop),
}

type Gradient = DiagonalGradientIdentifier<f32, Velocity, Ab, 2>;
type GradientWithFriction = DiagonalGradientIdentifier<f32, Velocity, AbCoulomb, 3>;
type GaussNewton<const W: usize> = GaussNewtonIdentifier<f32, AbCoulombLoad, 4, W>;

/// What a loop has learnt: [`ClosedLoop::estimates`] says it in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Learnt(States);

#[derive(Debug, Clone, Copy, PartialEq)]
enum States {
    Gradient(<Gradient as Identify<f32>>::State),
    GradientWithFriction(<GradientWithFriction as Identify<f32>>::State),
    /// In SI already: the state with its record is too long to be handed on.
    GaussNewton(Estimates),
    Fixed(<fixed_loop::Identifier as Identify<Word>>::State),
}

/// A loop with one identifier.
#[derive(Debug, Clone, Copy, PartialEq)]
struct With<I: Identify<f32>> {
    servo_loop: ServoLoop<f32, Velocity, I>,
    state: ServoLoopState<f32, LowPassState<f32>, I::State>,
}

impl<I: Identify<f32> + FromSettings> With<I> {
    fn build(settings: &Settings) -> Result<Self, IdentifierError> {
        let servo_loop: ServoLoop<f32, Velocity, I> = settings.build()?;
        Ok(Self {
            state: servo_loop.start(0),
            servo_loop,
        })
    }

    fn estimates(&self, state: &I::State) -> Estimates {
        parts::estimates(self.servo_loop.identifier(), state)
    }
}

/// Functions of their own, so that what divides in them can be told from what every sample does.
impl<const W: usize> With<GaussNewton<W>> {
    /// A sample; in the one after a first fit the recursion begins, which divides.
    #[inline(never)]
    fn learn_or_begin(&mut self, sample: &ControlSample<f32>) -> Seen<f32> {
        self.servo_loop.learn(&mut self.state, sample)
    }

    /// The estimates in SI, of a sample that is shown.
    #[inline(never)]
    fn found_in_si(&self) -> Estimates {
        self.estimates(self.state.identification())
    }

    /// At most `budget` blocks of a first fit.
    #[inline(never)]
    fn work_on_first_fit(&mut self, budget: u32) {
        let identifier = self.servo_loop.identifier();
        identifier.work(self.state.identification_mut(), budget);
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

impl<const W: usize> ClosedLoop<W> {
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

    /// Puts the loop at rest at a count.
    pub(crate) fn start(&mut self, count: i32) {
        whatever_law!(
            &mut self.0,
            own => own.state = own.servo_loop.start(count),
            fixed => fixed.start(count)
        );
    }

    /// The count of the last sample.
    #[must_use]
    pub(crate) fn count(&self) -> i32 {
        whatever_law!(&self.0, own => own.state.count(), fixed => fixed.count())
    }

    /// The first half of a sample: measure, control, act.
    ///
    /// # Errors
    /// [`ControlStepError`]; the actuator was released.
    #[inline]
    pub(crate) fn control<S: PositionSensor, A: Actuator<f32>>(
        &mut self,
        setpoint: Setpoint<f32>,
        sensor: &mut S,
        actuator: &mut A,
    ) -> Result<ControlSample<f32>, ControlStepError<S::Error, A::Error>> {
        whatever_law!(
            &mut self.0,
            own => control_step(&own.servo_loop, &mut own.state, setpoint, sensor, actuator),
            fixed => fixed.control(setpoint, sensor, actuator)
        )
    }

    /// The second half: learn, while the command acts.
    #[inline]
    pub(crate) fn learn(&mut self, sample: &ControlSample<f32>) -> Seen<f32> {
        match &mut self.0 {
            Laws::Gradient(own) => own.servo_loop.learn(&mut own.state, sample),
            Laws::GradientWithFriction(own) => own.servo_loop.learn(&mut own.state, sample),
            Laws::GaussNewton(own) => own.learn_or_begin(sample),
            Laws::Fixed(fixed) => fixed.learn(),
        }
    }

    /// Work that is not of this sample, when its command is out and it was learnt from: at most `budget`
    /// blocks of Gauss–Newton's first fit, as long as it records.
    #[inline]
    pub(crate) fn work(&mut self, budget: u32) {
        if let Laws::GaussNewton(own) = &mut self.0 {
            own.work_on_first_fit(budget);
        }
    }

    /// What it has learnt so far.
    #[inline]
    #[must_use]
    pub(crate) fn learnt(&self) -> Learnt {
        Learnt(match &self.0 {
            Laws::Gradient(own) => States::Gradient(*own.state.identification()),
            Laws::GradientWithFriction(own) => {
                States::GradientWithFriction(*own.state.identification())
            }
            Laws::GaussNewton(own) => States::GaussNewton(own.found_in_si()),
            Laws::Fixed(fixed) => States::Fixed(fixed.learnt()),
        })
    }

    /// What was learnt as estimates, SI; none of a loop of another law.
    #[must_use]
    pub(crate) fn estimates(&self, learnt: &Learnt) -> Option<Estimates> {
        match (&self.0, &learnt.0) {
            (Laws::Gradient(own), States::Gradient(state)) => Some(own.estimates(state)),
            (Laws::GradientWithFriction(own), States::GradientWithFriction(state)) => {
                Some(own.estimates(state))
            }
            (Laws::GaussNewton(_), States::GaussNewton(found)) => Some(*found),
            (Laws::Fixed(fixed), States::Fixed(state)) => Some(fixed.estimates(state)),
            _ => None,
        }
    }
}
