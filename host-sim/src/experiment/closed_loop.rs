//! The PID's loop around the simulated servo, with the identifier beside it.

use identifier_core::Settings;
use identifier_core::control::{ControlState, Controller};
use identifier_core::error::StepError;
use identifier_core::excitation::Excitation;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;
use virtual_servo::Plant;

use super::build::learner;
use super::learner::Learner;
use super::sensor::Sensor;
use super::{Outcome, Sample};
use crate::scenario::{Arithmetic, CHECKED, Reference, Scenario, WithVelocity};

pub(super) fn run(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Outcome {
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => run_in::<f32>(scenario, observe),
        Arithmetic::F64 => run_in::<f64>(scenario, observe),
        Arithmetic::Fixed => super::fixed_loop::run(scenario, observe),
    }
}

fn run_in<N: Number>(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Outcome {
    let (settings, mut learner, outcome) = build::<N>(scenario);
    drive(scenario, &settings, learner.as_mut(), outcome, observe)
}

/// The learner of a scenario that was checked when it was read.
pub(super) fn build<N: Number>(scenario: &Scenario) -> (Settings, Box<dyn Learner<N>>, Outcome) {
    let settings = scenario.settings().expect(CHECKED);
    let (learner, outcome) = learner(scenario, &settings).expect(CHECKED);
    (settings, learner, outcome)
}

/// Runs the loop with a learner beside it.
pub(super) fn drive<N: Number>(
    scenario: &Scenario,
    settings: &Settings,
    learner: &mut dyn Learner<N>,
    outcome: Outcome,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    scenario.velocity.with(Loop {
        scenario,
        settings,
        learner,
        outcome,
        observe,
    })
}

struct Loop<'a, N, O> {
    scenario: &'a Scenario,
    settings: &'a Settings,
    learner: &'a mut dyn Learner<N>,
    outcome: Outcome,
    observe: &'a mut O,
}

impl<N: Number, O: FnMut(&Sample)> WithVelocity<N> for Loop<'_, N, O> {
    type Output = Outcome;

    fn with<V: VelocityEstimate<N> + 'static>(self) -> Outcome {
        let Self {
            scenario,
            settings,
            learner,
            mut outcome,
            observe,
        } = self;
        let controller: Controller<N, V> = settings.build().expect(CHECKED);
        let units = scenario.units();
        let unit = units.position_unit();
        let reference = Reference::<N>::new(&units, &scenario.excitation).expect(CHECKED);
        let mut progress = reference.start();
        let mut plant = Plant::at_rest(&scenario.plant.expect(CHECKED), units.sample_time());
        let mut sensor = Sensor::new(scenario);
        let mut control = ControlState::default();
        for k in 0..scenario.samples() {
            let time = k as f64 * units.sample_time();
            let wanted = reference.process(&mut progress);
            let measured = sensor.read(plant.position, wanted);
            let mut sample = || -> Result<_, StepError> {
                let real = controller.process(&mut control, measured.error, measured.increment)?;
                let seen = learner.learn(real.increment, real.command)?;
                Ok((real.command.to_f64(), seen))
            };
            let (command, seen) = match sample() {
                Ok(both) => both,
                Err(error) => {
                    outcome.end_early(time, error);
                    break;
                }
            };
            learner.work();
            outcome.count(seen.map(|seen| seen.event));
            observe(&Sample {
                time,
                reference: wanted.to_f64() * unit,
                position: measured.position * unit,
                command,
                output_error: seen.map(|seen| seen.output_error.to_f64() * unit),
                estimates: learner.estimates(),
                standard_errors: learner.standard_errors(),
                at_bounds: learner.at_bounds(),
            });
            plant.advance(command);
        }
        outcome.bandwidth = learner.bandwidth();
        outcome
    }
}
