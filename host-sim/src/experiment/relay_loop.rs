//! The loop closed by a relay, with least squares beside it: what the paper compares itself with.
//!
//! The command is ± the relay's level by the sign of q_d − q, for the same reference as the PID's.
//! A servo under such a relay swings around its reference; that swing is the excitation.

use identifier_core::excitation::Excitation;
use identifier_core::measurement::origin::Origin;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;

use super::build::CHECKED;
use super::{Outcome, Sample};
use crate::scenario::{Arithmetic, Reference, RelaySettings, Scenario};
use crate::servo::{Encoder, Plant};

pub(super) fn run(
    scenario: &Scenario,
    settings: &RelaySettings,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => run_in::<f32>(scenario, settings, observe),
        Arithmetic::F64 => run_in::<f64>(scenario, settings, observe),
    }
}

fn run_in<N: Number>(
    scenario: &Scenario,
    settings: &RelaySettings,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    let units = &scenario.controller.units;
    let sample_time = units.sample_time();
    let position_unit = units.position_unit();

    let reference = Reference::<N>::new(units, &scenario.excitation).expect(CHECKED);
    let initial = &scenario.identifier.initial;
    let law = settings
        .least_squares::<N>(units, [initial.a, initial.b])
        .expect(CHECKED);
    let encoder = scenario.counts_per_rev.map(Encoder::new);
    let origin = Origin::default();
    let level = settings
        .relay
        .min(scenario.limit.high())
        .min(-scenario.limit.low());

    let mut plant = Plant::at_rest(&scenario.plant.expect(CHECKED), sample_time);
    let mut reference_state = reference.start();
    let mut state = law.start(N::ZERO);
    let mut outcome = Outcome::default();
    for k in 0..scenario.samples() {
        let wanted = reference.process(&mut reference_state);
        let position: N = match &encoder {
            Some(encoder) => origin.position(encoder.read(plant.position)),
            None => N::from_f64(plant.position * units.position()),
        };
        let command = if wanted >= position { level } else { -level };
        law.process(&mut state, position, N::from_f64(command));
        let [a, b] = law.estimates(&state);
        outcome.samples += 1;
        observe(&Sample {
            time: k as f64 * sample_time,
            reference: wanted.to_f64() * position_unit,
            position: position.to_f64() * position_unit,
            command,
            output_error: None,
            estimates: ServoParameters {
                a,
                b,
                coulomb: 0.0,
                load: 0.0,
            },
            standard_errors: None,
        });
        plant.advance(command);
    }
    outcome
}
