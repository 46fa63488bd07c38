//! The loop on the chip, the plant elsewhere: one sample a question.

use core::convert::Infallible;

use drive_link::{
    Answer, Estimates, Format, Law, LoopSettings, NoGains, NotAllowed, Question, Reading, Refused,
    Why,
};
use identifier_core::commission::{
    CommissionInputs, CommissionReading, CommissionState, SynchronousCommission,
};
use identifier_core::control::ControlSample;
use identifier_core::drive::{Actuator, PositionSensor, Setpoint};
use identifier_core::fixed_point::{
    FixedLowPass, FixedServoLoop, FixedServoLoopState, FixedVelocity, split_setpoint,
};
use identifier_core::identifier::{Identify, SettingsError};
use identifier_core::parameters::Ab;
use identifier_core::settings::Settings;

use crate::closed_loop::{ClosedLoop, Look, Looked, WithFirstFit};
use crate::{parts, studying};

/// Blocks of Gauss–Newton's start record: as many as the simulator's.
const BLOCKS: usize = 256;

/// Answers the questions of a host that simulates the plant.
///
/// The plant waits for the answer: a first fit is made in one sample, as in the simulator.
///
/// A question that comes twice is answered twice and done once, so the host may ask again whenever
/// an answer is late.
#[derive(Debug)]
pub struct LockStep {
    loops: Loops,
    last: Option<(u32, Done)>,
}

#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one loop, and no heap to put it on"
)]
enum Loops {
    None,
    Single(ClosedLoop<WithFirstFit<BLOCKS>>),
    Fixed(Words),
    Commissioning(SynchronousCommission<f32, { studying::BLOCKS }>),
}

/// What was done in the last sample.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and no heap to put it on"
)]
enum Done {
    Reading(Reading),
    Commissioning(CommissionReading, Option<NoGains>),
}

impl Default for LockStep {
    fn default() -> Self {
        Self::new()
    }
}

impl LockStep {
    /// Without a loop yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            loops: Loops::None,
            last: None,
        }
    }

    /// Answers a question.
    pub fn answer(&mut self, question: &Question) -> Answer {
        match *question {
            Question::Begin(settings) => self.begin(build(&settings)),
            Question::BeginCommission {
                settings,
                before,
                held,
            } => {
                let built = SynchronousCommission::new(&settings, before.as_ref(), held);
                let built = built.map_err(|error| parts::not_commissioned(&error));
                self.begin(built.map(Loops::Commissioning))
            }
            Question::Sample {
                number,
                setpoint,
                offset,
                count,
            } => self.once(number, |loops| match loops {
                Loops::None => Err(Refused::NotBegun),
                Loops::Single(closed_loop) => {
                    single(closed_loop, setpoint, offset, count).map(Done::Reading)
                }
                Loops::Fixed(words) => words.sample(setpoint, offset, count).map(Done::Reading),
                Loops::Commissioning(_) => Err(Refused::BegunOtherwise),
            }),
            Question::CommissionSample {
                number,
                count,
                late,
                stop,
            } => self.once(number, |loops| match loops {
                Loops::None => Err(Refused::NotBegun),
                Loops::Commissioning(commissioning) => {
                    let step = commissioning.sample(&CommissionInputs { count, late, stop });
                    let error = commissioning
                        .state()
                        .and_then(CommissionState::tuning_error);
                    Ok(Done::Commissioning(step, error.map(NoGains::from)))
                }
                Loops::Single(_) | Loops::Fixed(_) => Err(Refused::BegunOtherwise),
            }),
        }
    }

    fn begin(&mut self, built: Result<Loops, NotAllowed>) -> Answer {
        match built {
            Ok(loops) => {
                *self = Self { loops, last: None };
                Answer::Ready
            }
            Err(refused) => Answer::Refused(Refused::Setting(refused)),
        }
    }

    /// Does a sample, unless it is the last one: that is answered again.
    fn once(
        &mut self,
        number: u32,
        sample: impl FnOnce(&mut Loops) -> Result<Done, Refused>,
    ) -> Answer {
        let next = match &self.last {
            Some((last, done)) if *last == number => return done.answer(number),
            Some((last, _)) => last.wrapping_add(1),
            None => 0,
        };
        // One that was reset is at its first sample too, and has to say that it was.
        let begun = !matches!(self.loops, Loops::None);
        if begun && number != next {
            return Answer::Refused(Refused::OutOfStep { next });
        }
        match sample(&mut self.loops) {
            Ok(done) => {
                let answer = done.answer(number);
                self.last = Some((number, done));
                answer
            }
            Err(refused) => Answer::Refused(refused),
        }
    }
}

impl Done {
    fn answer(&self, number: u32) -> Answer {
        match self {
            Self::Reading(reading) => Answer::Command {
                number,
                reading: *reading,
            },
            Self::Commissioning(step, no_gains) => Answer::Commissioned {
                number,
                step: *step,
                no_gains: no_gains.clone(),
            },
        }
    }
}

fn build(settings: &LoopSettings) -> Result<Loops, NotAllowed> {
    match (settings.format, settings.law) {
        (Format::Single, _) => ClosedLoop::new(settings).map(Loops::Single),
        (Format::Fixed, Law::Gradient { friction: false }) => Words::new(&settings.core)
            .map(Loops::Fixed)
            .map_err(parts::not_allowed),
        (Format::Fixed, _) => Err(parts::refusal("law", Why::NotHere)),
    }
}

fn single(
    closed_loop: &mut ClosedLoop<WithFirstFit<BLOCKS>>,
    setpoint: i32,
    offset: f64,
    count: i32,
) -> Result<Reading, Refused> {
    let mut far = Far { command: 0.0 };
    let setpoint = Setpoint {
        count: setpoint,
        offset: offset as f32,
    };
    let (_, seen) = closed_loop.sample(setpoint, &mut Counted(count), &mut far, Unwatched)?;
    closed_loop.work(u32::MAX);
    Ok(Reading {
        command: f64::from(far.command),
        output_error: f64::from(seen.output_error),
        estimates: Estimates {
            standard_errors: closed_loop.standard_errors(),
            ..closed_loop
                .estimates(&closed_loop.learnt())
                .unwrap_or_default()
        },
        event: seen.event,
    })
}

/// Nobody watches over a plant that is simulated.
struct Unwatched;

impl Look for Unwatched {
    type End = Refused;

    fn look<S: PositionSensor, A: Actuator<f32>>(
        self,
        taken: Looked<S, A>,
    ) -> Result<ControlSample<f32>, Refused> {
        taken
            .map(|(sample, _)| sample)
            .map_err(|_| Refused::OutOfReach)
    }
}

/// A count that somebody else read.
struct Counted(i32);

impl PositionSensor for Counted {
    type Error = Infallible;

    fn count(&mut self) -> Result<i32, Infallible> {
        Ok(self.0)
    }
}

/// A command for somebody else.
struct Far {
    command: f32,
}

impl Actuator<f32> for Far {
    type Error = Infallible;

    fn hold(&mut self, command: f32) -> Result<(), Infallible> {
        self.command = command;
        Ok(())
    }

    fn release(&mut self) -> Result<(), Infallible> {
        self.hold(0.0)
    }
}

/// The loop in fixed point.
#[derive(Debug)]
struct Words {
    servo_loop: FixedServoLoop<FixedLowPass, Ab, 2>,
    state: FixedServoLoopState<<FixedLowPass as FixedVelocity>::State, 2>,
}

impl Words {
    fn new(settings: &Settings) -> Result<Self, SettingsError> {
        let servo_loop: FixedServoLoop<FixedLowPass, Ab, 2> = settings.build()?;
        Ok(Self {
            state: servo_loop.start(0),
            servo_loop,
        })
    }

    fn sample(&mut self, setpoint: i32, offset: f64, count: i32) -> Result<Reading, Refused> {
        if !offset.is_finite() {
            return Err(Refused::OutOfReach);
        }
        let Self { servo_loop, state } = self;
        let (whole, part) = split_setpoint(offset);
        let sample = servo_loop
            .control(state, setpoint.wrapping_add(whole), part, count)
            .map_err(|_| Refused::OutOfReach)?;
        let seen = servo_loop.learn(state, &sample);
        let identifier = servo_loop.identifier();
        Ok(Reading {
            command: servo_loop.controller().command(sample.command),
            output_error: identifier.output_error(&seen),
            estimates: parts::estimates(identifier, &identifier.snapshot(state.identification())),
            event: seen.event,
        })
    }
}
