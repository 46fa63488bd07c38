//! The PID's loop in fixed point, with the Γ-gradient identifier beside it.

use identifier_core::adaptation::GradientUpdate;
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::{FixedVelocity, reference_of_counts};
use identifier_core::identifier::IdentifierError;
use identifier_core::measurement::velocity::VelocityEstimate;
use identifier_core::parameters::ParameterSet;

use super::build::CHECKED;
use super::{Outcome, Sample};
use crate::scenario::fixed::{Choose, FixedParts, WithFixed};
use crate::scenario::{Reference, Scenario};
use virtual_servo::{Encoder, Plant};

pub(super) fn run(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Outcome {
    Choose { scenario }
        .with(Loop { scenario, observe })
        .expect(CHECKED)
}

struct Loop<'a, O> {
    scenario: &'a Scenario,
    observe: &'a mut O,
}

impl<O: FnMut(&Sample)> WithFixed for Loop<'_, O> {
    type Output = Outcome;

    fn with<W, V, S, const P: usize>(
        self,
        parts: FixedParts<V, S, P>,
    ) -> Result<Outcome, IdentifierError>
    where
        W: VelocityEstimate<f64>,
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static,
    {
        let Self { scenario, observe } = self;
        let FixedParts {
            identifier,
            gamma,
            mu,
        } = parts;
        let mut outcome = Outcome {
            bounds: Some(scenario.identifier.bounds),
            gamma: Some(gamma),
            mu: Some(mu),
            certified: identifier.gain_margin().is_some(),
            gain_margin: identifier.gain_margin(),
            ..Outcome::default()
        };
        let units = &scenario.controller.units;
        let sample_time = units.sample_time();
        let position_unit = units.position_unit();
        let reference = Reference::<f64>::new(units, &scenario.excitation).expect(CHECKED);
        let encoder = Encoder::new(std::f64::consts::TAU / position_unit);
        let mut plant = Plant::at_rest(&scenario.plant.expect(CHECKED), sample_time);
        let mut reference_state = reference.start();
        let controller = identifier.controller();
        let mut control = controller.start(0);
        let mut state = identifier.start();
        for k in 0..scenario.samples() {
            let wanted = reference.process(&mut reference_state);
            let count = encoder.read(plant.position);
            let real = controller.process(&mut control, reference_of_counts(wanted), count);
            let seen = identifier.process(&mut state, &real);
            outcome.samples += 1;
            outcome.slowed += u64::from(seen.update == GradientUpdate::Slowed);
            outcome.restarts += u64::from(seen.restarted);
            let command = controller.command(&real);
            observe(&Sample {
                time: k as f64 * sample_time,
                reference: wanted * position_unit,
                position: count as f64 * position_unit,
                command,
                output_error: Some(identifier.output_error(&seen) * position_unit),
                estimates: identifier.estimates(&state),
                standard_errors: None,
            });
            plant.advance(command);
        }
        Ok(outcome)
    }
}
