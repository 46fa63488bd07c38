//! The loop on the chip, the plant elsewhere: one sample a question.

use core::convert::Infallible;

use drive_link::{Answer, LoopSettings, NotAllowed, Question, Reading, Refused};
use identifier_core::drive::{Actuator, PositionSensor, Setpoint};
use identifier_core::identifier::Event;

use crate::closed_loop::ClosedLoop;

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
                setpoint,
                offset,
                count,
            } => self.sample(number, setpoint, offset, count).map_or_else(
                Answer::Refused,
                |reading| Answer::Command { number, reading },
            ),
        }
    }

    fn sample(
        &mut self,
        number: u32,
        setpoint: i32,
        offset: f64,
        count: i32,
    ) -> Result<Reading, Refused> {
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
            Loops::Single(closed_loop) => single(closed_loop, setpoint, offset, count)?,
        };
        self.last = Some((number, reading));
        Ok(reading)
    }
}

fn build(settings: &LoopSettings) -> Result<Loops, NotAllowed> {
    ClosedLoop::new(settings).map(Loops::Single)
}

fn single(
    closed_loop: &mut ClosedLoop,
    setpoint: i32,
    offset: f64,
    count: i32,
) -> Result<Reading, Refused> {
    let mut far = Far { command: 0.0 };
    let setpoint = Setpoint {
        count: setpoint,
        offset: offset as f32,
    };
    let sample = closed_loop
        .control(setpoint, &mut Counted(count), &mut far)
        .map_err(|_| Refused::OutOfReach)?;
    let seen = closed_loop.learn(&sample);
    Ok(Reading {
        command: f64::from(far.command),
        output_error: f64::from(seen.output_error),
        estimates: closed_loop.estimates(),
        slowed: seen.event == Event::Slowed,
        restarted: seen.event == Event::Restarted,
    })
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
