//! The test rig: a simulated servo with its sensor, and the reference that it is to follow.

use virtual_servo::faults::{Condition, Faults};
use virtual_servo::{SensorErrors, Servo};

use super::sensor::Sensor;
use crate::loops::{Measurement, SimLoop};
use identifier_log::experiment::{Abort, AbortCause, Outcome, Sample};

/// The servo that a loop is closed around.
pub(crate) struct SimulatedAxis<'a> {
    pub(super) sample_time: f64,
    /// Rad.
    pub(super) position_unit: f64,
    pub(crate) samples: u64,
    /// The reference of the next sample, position units.
    pub(crate) reference: Box<dyn FnMut() -> f64 + 'a>,
    pub(super) sensor: Sensor,
    /// The errors of the sensor, if it has any.
    pub(super) sensor_errors: Option<SensorErrors>,
    pub(super) servo: Servo,
    /// The injected faults, if there are any.
    pub(super) faults: Option<Faults>,
}

/// The readings of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Update {
    /// The sensor's reading; none if it is not valid.
    pub(crate) measured: Option<Measurement>,
    /// Its distance from the start of the servo, position units; NaN without a reading.
    pub(crate) position: f64,
    /// A late sample, an open limit switch, a fault of the amplifier.
    pub(crate) condition: Condition,
}

impl SimulatedAxis<'_> {
    /// Begins a sample with its readings; inlined as is [`Summariser::add`](crate::analysis::Summariser::add).
    #[inline(always)]
    pub(crate) fn sense(&mut self) -> Update {
        let condition = match &mut self.faults {
            Some(faults) => faults.begin_sample(&mut self.servo),
            None => Condition::SOUND,
        };
        let exact = self.servo.position();
        let seen = match &mut self.sensor_errors {
            Some(errors) => errors.seen(exact, self.servo.velocity()),
            None => exact,
        };
        let shown = match &mut self.faults {
            Some(faults) => faults.seen(seen),
            None => Some(seen),
        };
        let read = shown.map(|shown| self.sensor.read(shown));
        Update {
            measured: read.map(|(measured, _)| measured),
            position: read.map_or(f64::NAN, |(_, position)| position),
            condition,
        }
    }

    /// Ends it: the servo moves under this command until the next.
    pub(crate) fn act(&mut self, command: f64) {
        let acting = match &mut self.faults {
            Some(faults) => faults.acting(command),
            None => command,
        };
        self.servo.advance(acting);
    }

    /// Closes a loop around the servo, sample by sample. It shows each sample to `observe` before its command acts,
    /// with the loop's present state.
    pub(crate) fn run<L: SimLoop + ?Sized>(
        mut self,
        closed: &mut L,
        observe: &mut impl FnMut(&Sample, &L),
    ) -> Outcome {
        let unit = self.position_unit;
        let mut run = Outcome::default();
        for number in 0..self.samples {
            let time = number as f64 * self.sample_time;
            let reference = (self.reference)();
            let Update {
                measured, position, ..
            } = self.sense();
            let Some(measured) = measured else {
                let cause = AbortCause::NoReading;
                run.abort = Some(Abort { time, cause });
                break;
            };
            let step = match closed.process(reference, measured) {
                Ok(step) => step,
                Err(error) => {
                    run.end_early(time, error);
                    break;
                }
            };
            run.count(step.event);
            let [reference, position] = [reference, position].map(|units| units * unit);
            observe(
                &step.sample(time, number == 0, reference, position, unit),
                closed,
            );
            self.act(step.command);
        }
        Outcome {
            samples: run.samples,
            events: run.events,
            abort: run.abort,
            ..closed.outcome()
        }
    }
}

#[cfg(test)]
mod tests {
    use identifier_core::error::StepError;
    use identifier_core::identifier::Event;
    use identifier_core::parameters::ServoParameters;
    use virtual_servo::Effects;

    use super::*;
    use crate::loops::Step;

    const SAMPLE_TIME: f64 = 1e-3;
    const UNIT: f64 = 1e-4;

    /// A command that nothing changes, until it fails.
    struct Constant {
        command: f64,
        lasts: u64,
        asked: Vec<(f64, Measurement)>,
    }

    fn constant(command: f64, lasts: u64) -> Constant {
        Constant {
            command,
            lasts,
            asked: Vec::new(),
        }
    }

    impl SimLoop for Constant {
        fn process(&mut self, reference: f64, measured: Measurement) -> Result<Step, StepError> {
            if self.asked.len() as u64 == self.lasts {
                return Err(StepError::CommandNotFinite);
            }
            self.asked.push((reference, measured));
            Ok(Step {
                event: Some(Event::Standing),
                output_error: Some(2.0),
                ..Step::direct(self.command, None)
            })
        }

        fn outcome(&self) -> Outcome {
            Outcome {
                mu: Some(3.0),
                samples: 99,
                ..Outcome::default()
            }
        }
    }

    /// An axis with a free servo, under a reference that grows by a count in each sample.
    fn axis<'a>(samples: u64, sensor: Sensor) -> SimulatedAxis<'a> {
        let mut reference = 0.0;
        SimulatedAxis {
            sample_time: SAMPLE_TIME,
            position_unit: UNIT,
            samples,
            reference: Box::new(move || {
                reference += 1.0;
                reference
            }),
            sensor,
            sensor_errors: None,
            servo: Servo::at_rest(&FREE, &Effects::NONE, SAMPLE_TIME, 1).expect("allowed"),
            faults: None,
        }
    }

    const FREE: ServoParameters = ServoParameters::new(0.0, 257.7, 0.0, 0.0);

    #[test]
    fn a_constant_command_moves_a_free_servo_along_a_parabola() {
        let command = 0.25;
        let mut closed = constant(command, u64::MAX);
        let mut seen = Vec::new();
        let ideal = Sensor::ideal::<f64>(1.0 / UNIT);
        let run = axis(1000, ideal).run(&mut closed, &mut |sample, _| seen.push(*sample));
        assert_eq!(run.abort, None);
        assert_eq!(seen.len(), 1000);
        for (number, sample) in seen.iter().enumerate() {
            let time = number as f64 * SAMPLE_TIME;
            // A sample is observed before its command acts.
            let expected = FREE.b * command * time * time / 2.0;
            assert!((sample.time - time).abs() < 1e-12);
            let off = sample.position - expected;
            assert!(off.abs() < 1e-9 * (1.0 + expected), "{sample:?}");
            assert!((sample.reference - (number + 1) as f64 * UNIT).abs() < 1e-12);
            assert_eq!(sample.output_error, Some(2.0 * UNIT));
        }
        let (_, last) = closed.asked[999];
        let Measurement::Position(last) = last else {
            panic!("an ideal sensor shows positions: {last:?}");
        };
        assert!((last * UNIT - seen[999].position).abs() < 1e-12);
    }

    #[test]
    fn an_encoder_shows_the_last_count_passed_from_where_its_counter_starts() {
        let mut closed = constant(0.5, u64::MAX);
        let encoder = Sensor::encoder(std::f64::consts::TAU / UNIT, i32::MAX);
        axis(200, encoder).run(&mut closed, &mut |sample, closed| {
            let counts = (sample.position / UNIT).round();
            let expected = i32::MAX.wrapping_add(counts as i32);
            let (_, measured) = closed.asked[closed.asked.len() - 1];
            assert_eq!(measured, Measurement::Count(expected));
        });
        assert_eq!(closed.asked.len(), 200);
    }

    #[test]
    fn a_loop_that_fails_ends_the_run_and_the_samples_before_it_count() {
        let mut closed = constant(1.0, 7);
        let mut seen = 0;
        let ideal = Sensor::ideal::<f64>(1.0 / UNIT);
        let run = axis(100, ideal).run(&mut closed, &mut |_, _| seen += 1);
        assert_eq!(seen, 7);
        assert_eq!((run.samples, run.events.standing), (7, 7));
        assert_eq!(run.mu, Some(3.0));
        let Abort { time, cause } = run.abort.expect("it failed");
        assert!((time - 7.0 * SAMPLE_TIME).abs() < 1e-12);
        assert_eq!(cause, AbortCause::Loop(StepError::CommandNotFinite));
    }
}
