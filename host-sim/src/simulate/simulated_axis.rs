//! The test rig: a simulated servo with its sensor, and the reference that it is to follow.

use identifier_core::excitation::Excitation;
use identifier_core::number::Number;
use identifier_log::experiment::{Abort, AbortCause, Outcome, Sample};

use super::sensor::Sensor;
use crate::loops::SimLoop;
use crate::scenario::{Fault, Scenario};
use crate::virtual_axis::VirtualAxis;

/// The servo that a loop is closed around.
pub(crate) struct SimulatedAxis<'a> {
    pub(super) sample_time: f64,
    /// Rad.
    pub(super) position_unit: f64,
    pub(crate) samples: u64,
    /// The reference of the next sample, position units.
    pub(crate) reference: Box<dyn FnMut() -> f64 + 'a>,
    pub(super) sensor: Sensor,
    pub(super) axis: VirtualAxis,
}

impl SimulatedAxis<'_> {
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
            let (shown, _) = self.axis.sense(0.0);
            let Some((measured, position)) = shown.map(|shown| self.sensor.read(shown)) else {
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
            self.axis.advance(step.command);
        }
        Outcome {
            samples: run.samples,
            events: run.events,
            abort: run.abort,
            ..closed.outcome()
        }
    }

    /// The rig of a scenario, its signals in the number format of the loop.
    pub(crate) fn build<N: Number>(scenario: &Scenario) -> Result<Self, Fault> {
        let reference = scenario.reference::<N>()?;
        let units = scenario.checked_units()?;
        let mut progress = reference.start();
        Ok(Self {
            sample_time: units.sample_time(),
            position_unit: units.position_unit(),
            samples: scenario.samples(),
            reference: Box::new(move || reference.process(&mut progress).to_f64()),
            sensor: match scenario.counts_per_rev {
                Some(counts) => Sensor::encoder(counts, 0),
                None => Sensor::ideal::<N>(units.position()),
            },
            axis: VirtualAxis::new(scenario, &units)?,
        })
    }

    /// The same with a counter that shows `start` where the servo starts; an ideal sensor counts
    /// position units.
    #[cfg(feature = "experiments")]
    pub(crate) fn counting_from(mut self, start: i32) -> Self {
        self.sensor = match self.sensor {
            Sensor::Encoder { encoder, .. } => Sensor::Encoder { encoder, start },
            Sensor::Ideal { .. } => {
                Sensor::encoder(std::f64::consts::TAU / self.position_unit, start)
            }
        };
        self
    }
}

#[cfg(test)]
mod tests {
    use identifier_core::error::StepError;
    use identifier_core::identifier::Event;
    use identifier_core::parameters::ServoParameters;

    use super::*;
    use crate::loops::{Measurement, Step};
    use crate::scenario::{Purpose, Scenario};

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
            axis: free_servo(),
        }
    }

    fn free_servo() -> VirtualAxis {
        let mut scenario = Scenario::blank(Purpose::Run);
        scenario.plant = Some(FREE);
        scenario.stated.sample_time = SAMPLE_TIME;
        let units = scenario.checked_units().expect("allowed");
        VirtualAxis::new(&scenario, &units).expect("allowed")
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
