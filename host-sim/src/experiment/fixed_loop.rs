//! The PID's loop in fixed point, with the Γ-gradient identifier beside it.

use identifier_core::Settings;
use identifier_core::excitation::Excitation;
use identifier_core::fixed_point::{
    FixedGradientIdentifier, FixedServoLoop, FixedVelocity, split_setpoint,
};
use identifier_core::identifier::{IdentifierError, Identify};
use identifier_core::parameters::ParameterSet;
use virtual_servo::{Encoder, Plant};

use super::{Outcome, Sample};
use crate::scenario::fixed::WithWords;
use crate::scenario::{CHECKED, Reference, Scenario};

pub(super) fn run(scenario: &Scenario, observe: &mut impl FnMut(&Sample)) -> Outcome {
    let settings = scenario.settings().expect(CHECKED);
    scenario.with_words(Loop {
        scenario,
        settings,
        observe,
    })
}

/// Whether a scenario's loop fits words.
///
/// # Errors
/// What does not, and what would.
pub(crate) fn check(scenario: &Scenario, settings: &Settings) -> Result<(), IdentifierError> {
    struct Try<'a>(&'a Settings);

    impl WithWords for Try<'_> {
        type Output = Result<(), IdentifierError>;

        fn with<V, S, const P: usize>(self) -> Self::Output
        where
            V: FixedVelocity + 'static,
            S: ParameterSet<P> + 'static,
        {
            self.0.build::<FixedServoLoop<V, S, P>>().map(|_| ())
        }
    }

    scenario.with_words(Try(settings))
}

/// What is known of an identifier in fixed point before it runs.
pub(crate) fn known_beforehand<V, S, const P: usize>(
    settings: &Settings,
    identifier: &FixedGradientIdentifier<V, S, P>,
) -> Outcome
where
    V: FixedVelocity,
    S: ParameterSet<P>,
{
    Outcome {
        gamma: settings.identifier.gamma.map(super::build::rows::<S, P>),
        mu: Some(identifier.mu()),
        certified: identifier.certificate().is_some(),
        gain_margin: identifier.gain_margin(),
        ..Outcome::default()
    }
}

struct Loop<'a, O> {
    scenario: &'a Scenario,
    settings: Settings,
    observe: &'a mut O,
}

impl<O: FnMut(&Sample)> WithWords for Loop<'_, O> {
    type Output = Outcome;

    fn with<V, S, const P: usize>(self) -> Outcome
    where
        V: FixedVelocity + 'static,
        S: ParameterSet<P> + 'static,
    {
        let Self {
            scenario,
            settings,
            observe,
        } = self;
        let servo_loop: FixedServoLoop<V, S, P> = settings.build().expect(CHECKED);
        let (controller, identifier) = (servo_loop.controller(), servo_loop.identifier());
        let mut outcome = known_beforehand(&settings, identifier);
        let units = scenario.units();
        let unit = units.position_unit();
        let reference = Reference::<f64>::new(&units, &scenario.excitation).expect(CHECKED);
        let mut progress = reference.start();
        let encoder = Encoder::new(std::f64::consts::TAU / unit);
        let mut plant = Plant::at_rest(&scenario.plant.expect(CHECKED), units.sample_time());
        let mut state = servo_loop.start(0);
        for k in 0..scenario.samples() {
            let time = k as f64 * units.sample_time();
            let wanted = reference.process(&mut progress);
            let (setpoint, offset) = split_setpoint(wanted);
            let count = encoder.read(plant.position);
            // A counter of 32 bits.
            let step = match servo_loop.process(&mut state, setpoint, offset, count as i32) {
                Ok(step) => step,
                Err(error) => {
                    outcome.end_early(time, error);
                    break;
                }
            };
            outcome.count(Some(step.seen.event));
            let command = controller.command(step.control.command);
            observe(&Sample {
                time,
                reference: wanted * unit,
                position: count as f64 * unit,
                command,
                output_error: Some(identifier.output_error(&step.seen) * unit),
                estimates: identifier.estimates(state.identification()),
                standard_errors: None,
                at_bounds: identifier.at_bounds(state.identification()),
            });
            plant.advance(command);
        }
        outcome
    }
}
