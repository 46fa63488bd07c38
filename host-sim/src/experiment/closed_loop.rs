//! The PID's loop with the identifier beside it.

use identifier_core::adaptation::GradientUpdate;
use identifier_core::control::ControlState;
use identifier_core::excitation::Excitation;
use identifier_core::identifier::{Identifier, IdentifierConfig};
use identifier_core::measurement::origin::Origin;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::number::Number;

use super::{Abort, Outcome, Sample};
use crate::scenario::{Arithmetic, GradientSettings, Reference, Scenario, WithVelocity};
use crate::servo::{Encoder, Plant};

/// Why the parts can be relied on: a [`Scenario`] builds each of them once when it is read.
const CHECKED: &str = "the scenario was checked when it was read";

pub(super) fn run(
    scenario: &Scenario,
    settings: &GradientSettings,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    let config = scenario.identifier_config(settings).expect(CHECKED);
    let velocity = &scenario.controller.velocity;
    let units = &config.units;
    let work = Loop {
        scenario,
        config: &config,
        observe,
    };
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => velocity.with::<f32, _>(units, work),
        Arithmetic::F64 => velocity.with::<f64, _>(units, work),
    }
    .expect(CHECKED)
}

struct Loop<'a, O> {
    scenario: &'a Scenario,
    config: &'a IdentifierConfig,
    observe: &'a mut O,
}

impl<N: Number, O: FnMut(&Sample)> WithVelocity<N> for Loop<'_, O> {
    type Output = Outcome;

    fn with<V: VelocityEstimate<N>>(self, velocity: V) -> Outcome {
        let Self {
            scenario,
            config,
            observe,
        } = self;
        let units = &config.units;
        let sample_time = units.sample_time();
        let position_unit = units.position_unit();
        let samples = scenario.samples();

        let reference = Reference::<N>::new(units, &scenario.excitation).expect(CHECKED);
        let controller = scenario.controller::<N, V>(velocity);
        let identifier = Identifier::<N, V>::new(config, velocity).expect(CHECKED);
        let encoder = scenario.counts_per_rev.map(Encoder::new);
        let origin = Origin::default();

        let mut plant = Plant::at_rest(&scenario.plant, sample_time);
        let mut reference_state = reference.start();
        let mut control = ControlState::at_rest(N::ZERO);
        let mut identification = identifier.start();
        let mut outcome = Outcome {
            gamma: Some(config.gamma),
            mu: Some(config.mu()),
            bounds: Some(config.bounds),
            certified: identifier.certificate().is_some(),
            gain_margin: identifier.gain_margin(),
            ..Outcome::default()
        };
        for k in 0..samples {
            let time = k as f64 * sample_time;
            let wanted = reference.process(&mut reference_state);
            let position: N = match &encoder {
                Some(encoder) => origin.position(encoder.read(plant.position)),
                None => N::from_f64(plant.position),
            };
            let real = match controller.process(&mut control, wanted, position) {
                Ok(real) => real,
                Err(error) => {
                    outcome.abort = Some(Abort { time, error });
                    break;
                }
            };
            let seen = identifier.process(&mut identification, &real);
            let estimates = identifier.estimates(&identification);
            outcome.samples += 1;
            outcome.slowed += u64::from(seen.update == GradientUpdate::Slowed);
            outcome.restarts += u64::from(seen.restarted);
            let command = real.command.to_f64();
            observe(&Sample {
                time,
                reference: wanted.to_f64() * position_unit,
                position: position.to_f64() * position_unit,
                command,
                output_error: Some(seen.model.output_error.to_f64() * position_unit),
                a: estimates.a,
                b: estimates.b,
                load: Some(estimates.load),
            });
            plant.advance(command);
        }
        outcome
    }
}
