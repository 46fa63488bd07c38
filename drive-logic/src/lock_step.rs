//! The loop on the chip, the plant elsewhere: one sample a question.

use core::convert::Infallible;

use drive_link::{Answer, Format, LoopSettings, NotAllowed, Question, Reading, Refused};
use identifier_core::adaptation::GradientUpdate;
use identifier_core::drive::{Actuator, PositionSensor};
use identifier_core::fixed_point::{
    Accumulator, FixedControlState, FixedGradientIdentifier, FixedGradientState, FixedLowPass,
    Ranges, reference_of_counts,
};
use identifier_core::identifier::IdentifierError;
use identifier_core::measurement::velocity::LowPass;
use identifier_core::parameters::Ab;

use crate::closed_loop::ClosedLoop;
use crate::parts;

/// Answers the questions of a host that simulates the plant.
///
/// A question that comes twice is answered twice and done once, so the host may ask again whenever
/// an answer is late.
#[derive(Debug)]
pub struct LockStep {
    loops: Loops,
    last: Option<(u32, Reading)>,
}

#[derive(Debug)]
enum Loops {
    None,
    Single(ClosedLoop),
    Fixed(Words),
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
            Question::Begin(settings) => match build(&settings) {
                Ok(loops) => {
                    *self = Self { loops, last: None };
                    Answer::Ready
                }
                Err(refused) => Answer::Refused(Refused::Setting(refused)),
            },
            Question::Sample {
                number,
                reference,
                count,
            } => self
                .sample(number, reference, count)
                .map_or_else(Answer::Refused, |reading| Answer::Command {
                    number,
                    reading,
                }),
        }
    }

    fn sample(&mut self, number: u32, reference: f64, count: i64) -> Result<Reading, Refused> {
        let next = match self.last {
            Some((last, reading)) if last == number => return Ok(reading),
            Some((last, _)) => last.wrapping_add(1),
            None => 0,
        };
        if number != next {
            return Err(Refused::OutOfStep { next });
        }
        let reading = match &mut self.loops {
            Loops::None => return Err(Refused::NotBegun),
            Loops::Single(closed_loop) => single(closed_loop, reference, count)?,
            Loops::Fixed(words) => words.sample(reference, count),
        };
        self.last = Some((number, reading));
        Ok(reading)
    }
}

fn build(settings: &LoopSettings) -> Result<Loops, NotAllowed> {
    match settings.format {
        Format::Single => ClosedLoop::new(settings, 0).map(Loops::Single),
        Format::Fixed if settings.friction => Err(parts::refusal("friction", 1.0, 0.0, 0.0)),
        Format::Fixed => Words::new(settings)
            .map(Loops::Fixed)
            .map_err(parts::not_allowed),
    }
}

fn single(closed_loop: &mut ClosedLoop, reference: f64, count: i64) -> Result<Reading, Refused> {
    let mut sensor = Counted(count);
    let mut far = Far { command: 0.0 };
    let seen = closed_loop
        .step(reference as f32, &mut sensor, &mut far)
        .map_err(|_| Refused::OutOfReach)?;
    Ok(Reading {
        command: f64::from(far.command),
        output_error: f64::from(seen.output_error),
        estimates: closed_loop.estimates(),
        slowed: seen.slowed,
        restarted: seen.restarted,
    })
}

/// A count that somebody else read.
struct Counted(i64);

impl PositionSensor for Counted {
    type Error = Infallible;

    fn count(&mut self) -> Result<i64, Infallible> {
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
    identifier: FixedGradientIdentifier<FixedLowPass, Ab, 2>,
    control: FixedControlState<Accumulator>,
    learnt: FixedGradientState<Accumulator, 2>,
}

impl Words {
    fn new(settings: &LoopSettings) -> Result<Self, IdentifierError> {
        let config = parts::config(settings)?;
        let ranges = Ranges::of(&config);
        let velocity = LowPass::<f64>::new(&config.units, settings.cutoff)?;
        let law = parts::law(settings)?;
        let identifier = FixedGradientIdentifier::new(&config, &law, &ranges, velocity)?;
        Ok(Self {
            control: identifier.controller().start(0),
            learnt: identifier.start(),
            identifier,
        })
    }

    fn sample(&mut self, reference: f64, count: i64) -> Reading {
        let wanted = reference_of_counts(reference);
        let controller = self.identifier.controller();
        let sample = controller.process(&mut self.control, wanted, count);
        let seen = self.identifier.process(&mut self.learnt, &sample);
        Reading {
            command: controller.command(&sample),
            output_error: self.identifier.output_error(&seen),
            estimates: parts::estimates(&self.identifier.estimates(&self.learnt)),
            slowed: seen.update == GradientUpdate::Slowed,
            restarted: seen.restarted,
        }
    }
}
