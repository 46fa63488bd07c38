//! The loop closed by a relay: the command is ± its level by the sign of q_d − q.
//!
//! The relay's least squares follows the scenario's reference and swings around it, as the paper
//! has it; limit cycles are left alone around a place that stands still.

use identifier_core::excitation::Excitation;
use identifier_core::model::ServoParameters;
use identifier_core::number::Number;
use rivals::{
    DirectEstimator, FilteredLeastSquares, FilteredLeastSquaresState, Relay, RelayCycle,
    RelayCycleState, RelayState, TwoRelays, TwoRelaysState,
};

use super::NO_ESTIMATE;
use crate::experiment::sensor::Sensor;
use crate::experiment::{Outcome, Sample};
use crate::scenario::{Arithmetic, Baseline, BaselineSettings, CHECKED, Reference, Scenario};
use identifier_core::settings::PerParameter;
use virtual_servo::Plant;

pub(super) fn run(
    scenario: &Scenario,
    baseline: Baseline,
    settings: &BaselineSettings,
    observe: &mut impl FnMut(&Sample),
) -> Outcome {
    match scenario.identifier.arithmetic {
        Arithmetic::F32 => run_in::<f32>(scenario, baseline, settings, observe, &mut |process| {
            process()
        }),
        Arithmetic::F64 | Arithmetic::Fixed => {
            run_in::<f64>(scenario, baseline, settings, observe, &mut |process| {
                process()
            })
        }
    }
}

/// Runs it, each of the method's samples within `around`.
pub(super) fn run_in<N: Number>(
    scenario: &Scenario,
    baseline: Baseline,
    settings: &BaselineSettings,
    observe: &mut impl FnMut(&Sample),
    around: &mut dyn FnMut(&mut dyn FnMut() -> N) -> N,
) -> Outcome {
    let mut method = method::<N>(scenario, baseline, settings);
    let units = &scenario.units();
    let sample_time = units.sample_time();
    let position_unit = units.position_unit();
    let reference = Reference::<N>::new(units, &scenario.excitation).expect(CHECKED);
    let mut sensor = Sensor::new(scenario);
    let mut plant = Plant::at_rest(&scenario.plant.expect(CHECKED), sample_time);
    let mut reference_state = reference.start();
    let mut outcome = Outcome::default();
    for k in 0..scenario.samples() {
        let wanted = if method.follows() {
            reference.process(&mut reference_state)
        } else {
            N::ZERO
        };
        let measured = sensor.read(plant.position, wanted);
        let (increment, error) = (measured.increment, measured.error);
        let command = around(&mut || method.process(increment, error)).to_f64();
        outcome.count(None);
        observe(&Sample {
            time: k as f64 * sample_time,
            reference: wanted.to_f64() * position_unit,
            position: measured.position * position_unit,
            command,
            output_error: None,
            estimates: method.estimates().unwrap_or(NO_ESTIMATE),
            standard_errors: None,
            at_bounds: PerParameter::default(),
        });
        plant.advance(command);
    }
    outcome.failure = method.failure();
    outcome
}

/// A method that closes its loop with a relay.
trait Method<N> {
    /// One sample: increment of the position and error to command.
    fn process(&mut self, increment: N, error: N) -> N;

    fn estimates(&self) -> Option<ServoParameters>;

    /// Whether it follows the reference.
    fn follows(&self) -> bool {
        false
    }

    /// Why it has no estimates, if it has none.
    fn failure(&self) -> Option<&'static str> {
        self.estimates()
            .is_none()
            .then_some("the limit cycle did not become steady")
    }
}

fn method<N: Number>(
    scenario: &Scenario,
    baseline: Baseline,
    settings: &BaselineSettings,
) -> Box<dyn Method<N>> {
    let units = &scenario.units();
    let relay = |part: f64| {
        scenario
            .relay::<N>(part * settings.relay, settings)
            .expect(CHECKED)
    };
    match baseline {
        Baseline::RelayCycle => {
            let law = RelayCycle::new(units, relay(1.0));
            Box::new(Cycle {
                state: law.start(),
                law,
            })
        }
        Baseline::TwoRelays => {
            let law = TwoRelays::new(units, [relay(1.0), relay(0.5)]);
            Box::new(TwoCycles {
                state: law.start(),
                law,
            })
        }
        _ => {
            let config = scenario.least_squares(settings);
            let law = FilteredLeastSquares::new(units, &config).expect(CHECKED);
            // The paper's relay has no delay.
            let prompt = BaselineSettings {
                relay_delay: 0.0,
                ..*settings
            };
            let relay = scenario.relay::<N>(settings.relay, &prompt).expect(CHECKED);
            Box::new(LeastSquares {
                state: law.start(),
                relay_state: relay.start(),
                relay,
                law,
            })
        }
    }
}

struct LeastSquares<N: Number> {
    relay: Relay<N>,
    relay_state: RelayState,
    law: FilteredLeastSquares<N>,
    state: FilteredLeastSquaresState<N>,
}

impl<N: Number> Method<N> for LeastSquares<N> {
    fn process(&mut self, increment: N, error: N) -> N {
        let command = self.relay.process(&mut self.relay_state, error);
        self.law.process(&mut self.state, increment, command);
        command
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates(&self.state)
    }

    fn follows(&self) -> bool {
        true
    }

    fn failure(&self) -> Option<&'static str> {
        None
    }
}

struct Cycle<N> {
    law: RelayCycle<N>,
    state: RelayCycleState<N>,
}

impl<N: Number> Method<N> for Cycle<N> {
    fn process(&mut self, increment: N, error: N) -> N {
        self.law.process(&mut self.state, increment, error)
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates(&self.state)
    }
}

struct TwoCycles<N> {
    law: TwoRelays<N>,
    state: TwoRelaysState<N>,
}

impl<N: Number> Method<N> for TwoCycles<N> {
    fn process(&mut self, increment: N, error: N) -> N {
        self.law.process(&mut self.state, increment, error)
    }

    fn estimates(&self) -> Option<ServoParameters> {
        self.law.estimates(&self.state)
    }
}
