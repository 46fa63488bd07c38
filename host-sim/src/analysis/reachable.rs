//! The accuracy that the motion of a run allows, for any estimator.

use identifier_core::parameters::{Parameter, Unknown};

use super::closed_loop::Response;
use super::information::Information;
use crate::experiment::Sample;
use crate::scenario::Scenario;
use identifier_log::verdict::MIN_TRAVEL_COUNTS;

/// Gathers it along a run of a simulated servo, in the same memory for a run of any length.
#[derive(Debug, Clone)]
pub(super) struct Reachable {
    information: Information,
    /// Weight of a new step in the velocity.
    new: f64,
    sample_time: f64,
    last: Option<f64>,
    velocity: f64,
    /// The distance travelled, forth and back, and the least that is informative, rad.
    travel: f64,
    least_travel: f64,
}

impl Reachable {
    /// For a run of this scenario; none where its servo is not simulated.
    pub(super) fn new(scenario: &Scenario) -> Option<Self> {
        /// The correction's bandwidth where there is no loop to take it from, in 1/T.
        const PER_SAMPLE: f64 = 0.05;
        /// The time over which the fit of a verdict trusts its model, over the reciprocal of the motion's bandwidth. It
        /// is four times the shortest, 0.7.
        const HORIZON: f64 = 2.8;
        let servo = scenario.plant?;
        let sample_time = scenario.sample_time();
        let crossover = Response::new(scenario, &servo)
            .and_then(|response| response.figures(scenario).crossover);
        let omega = crossover.map_or(PER_SAMPLE / sample_time, |crossover| crossover / HORIZON);
        let (resolution, noise) = (scenario.stated.resolution, scenario.sensor.noise);
        let variance = resolution * resolution / 12.0 + noise * noise;
        let parameters = scenario.estimated();
        Some(Self {
            information: Information::new(&parameters, omega, sample_time, variance),
            new: -(-scenario.stated.cutoff * sample_time).exp_m1(),
            sample_time,
            last: None,
            velocity: 0.0,
            travel: 0.0,
            least_travel: MIN_TRAVEL_COUNTS * resolution,
        })
    }

    pub(super) fn add(&mut self, sample: &Sample) {
        let moved = self.last.map_or(0.0, |last| sample.position - last);
        self.last = Some(sample.position);
        self.travel += moved.abs();
        self.velocity += self.new * (moved / self.sample_time - self.velocity);
        self.information.add(self.velocity, sample.command);
    }

    /// The least standard errors, SI; infinite where the motion says nothing.
    pub(super) fn standard_errors(&self) -> Vec<(Unknown, f64)> {
        let travelled = self.travel >= self.least_travel;
        let error = |error: f64| if travelled { error } else { f64::INFINITY };
        let parameters = self.information.parameters();
        let named = parameters.iter().map(|of: &Parameter| Unknown::from(*of));
        let errors = self.information.standard_errors();
        named.zip(errors.into_iter().map(error)).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::analysis::Summariser;
    use crate::result::Summary;
    use crate::scenario::{Purpose, Scenario};
    use crate::simulate;

    fn ran(coulomb: f64) -> Summary {
        let text = format!(
            "[plant]\na = 0.2174\nb = 257.7\nload = 20.0\ncoulomb = {coulomb:?}\n[identifier]\n\
             law = \"gauss-newton\"\nparameters = [\"a\", \"b\", \"load\"]\n[run]\nduration = 10.0\n"
        );
        let scenario = Scenario::parse("s.toml", &text, Purpose::Run).expect("a scenario");
        let mut summariser = Summariser::new(&scenario).with_reachable(&scenario);
        let outcome = simulate::run(&scenario, &mut |sample| summariser.add(sample));
        summariser.finish(&scenario, outcome.expect("it can be built"))
    }

    #[test]
    fn no_estimator_knows_more_than_the_motion_shows() {
        let moved = ran(0.0);
        assert_eq!(moved.reachable.len(), 3);
        let estimates = &moved.estimates;
        let reached = [&estimates.a, &estimates.b, &estimates.load];
        for ((unknown, least), reached) in moved.reachable.iter().zip(reached) {
            let reached = reached.std_error.expect("it is known");
            // Rounding is no noise, and may show a little more.
            assert!(
                *least > 0.0 && *least < 2.0 * reached && reached < 100.0 * least,
                "{unknown:?}: {least} at best, {reached}"
            );
        }
        let stood = ran(1e9);
        assert!(stood.reachable.iter().all(|(_, error)| error.is_infinite()));
    }
}
