//! The PID's loop around the simulated servo, with the identifier beside it.

use identifier_core::control::ControlState;
use identifier_core::excitation::Excitation;
use identifier_core::identifier::Recorded;
use identifier_core::measurement::origin::Origin;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;

use super::build::{CHECKED, learner};
use super::learner::{Given, Learner};
use super::{Abort, Outcome, Sample};
use crate::scenario::{Arithmetic, Reference, Scenario, WithVelocity};
use virtual_servo::{Encoder, Plant};

pub(super) fn run(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Outcome {
    if scenario.identifier.arithmetic == Arithmetic::Fixed {
        return super::fixed_loop::run(scenario, observe);
    }
    let velocity = &scenario.controller.velocity;
    let units = &scenario.controller.units;
    let work = Loop { scenario, observe };
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => velocity.with::<f32, _>(units, work),
        Arithmetic::F64 | Arithmetic::Fixed => velocity.with::<f64, _>(units, work),
    }
    .expect(CHECKED)
}

struct Loop<'a, O> {
    scenario: &'a Scenario,
    observe: &'a mut O,
}

impl<N: Number, O: FnMut(&Sample)> WithVelocity<N> for Loop<'_, O> {
    type Output = Outcome;

    fn with<V: VelocityEstimate<N> + 'static>(self, velocity: V) -> Outcome {
        let Self { scenario, observe } = self;
        let (mut learner, outcome) = build::<N, V>(scenario, velocity);
        drive(scenario, velocity, learner.as_mut(), outcome, observe)
    }
}

/// The learner of a scenario that was checked when it was read.
pub(super) fn build<N: Number, V: VelocityEstimate<N> + 'static>(
    scenario: &Scenario,
    velocity: V,
) -> (Box<dyn Learner<N, V::State>>, Outcome) {
    let units = &scenario.controller.units;
    let played = Reference::<f64>::new(units, &scenario.excitation).expect(CHECKED);
    learner::<N, V>(scenario, velocity, &played).expect(CHECKED)
}

/// Runs the loop with a learner beside it.
pub(super) fn drive<N: Number, V: VelocityEstimate<N>>(
    scenario: &Scenario,
    velocity: V,
    learner: &mut dyn Learner<N, V::State>,
    mut outcome: Outcome,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    let units = &scenario.controller.units;
    let sample_time = units.sample_time();
    let position_unit = units.position_unit();
    let servo = scenario.plant.expect(CHECKED);

    let reference = Reference::<N>::new(units, &scenario.excitation).expect(CHECKED);
    let controller = scenario.controller::<N, V>(velocity);
    let encoder = scenario.counts_per_rev.map(Encoder::new);
    let origin = Origin::default();
    let per_unit = units.position();

    let mut plant = Plant::at_rest(&servo, sample_time);
    let mut reference_state = reference.start();
    let mut control = ControlState::at_rest(N::ZERO);
    for k in 0..scenario.samples() {
        let time = k as f64 * sample_time;
        let wanted = reference.process(&mut reference_state);
        let position: N = match &encoder {
            Some(encoder) => origin.position(encoder.read(plant.position)),
            None => N::from_f64(plant.position * per_unit),
        };
        let given = Given {
            before: control,
            sample: Recorded {
                reference: wanted,
                position,
                injection: N::ZERO,
            },
        };
        let real = match controller.process(&mut control, wanted, position) {
            Ok(real) => real,
            Err(error) => {
                outcome.abort = Some(Abort { time, error });
                break;
            }
        };
        let seen = learner.process(&given, &real);
        outcome.count(&seen);
        let command = real.command.to_f64();
        observe(&Sample {
            time,
            reference: wanted.to_f64() * position_unit,
            position: position.to_f64() * position_unit,
            command,
            output_error: seen
                .output_error
                .map(|error| error.to_f64() * position_unit),
            estimates: learner.estimates(),
            standard_errors: learner.standard_errors(),
        });
        plant.advance(command);
    }
    outcome
}
