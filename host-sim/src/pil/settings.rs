//! From a scenario to what the chip builds its loop from.

use drive_link::{Format, LoopSettings};
use identifier_core::interval::Interval;
use identifier_core::measurement::velocity::VelocityEstimate;

use super::PilError;
use crate::experiment::{self, Outcome};
use crate::scenario::{
    Arithmetic, Law, ModelSet, Reference, Scenario, VelocitySettings, WithVelocity,
};

/// Why an ideal sensor will not do.
pub(super) const NO_COUNTS: &str = "encoder.counts_per_rev: a chip counts, so it must not be 0";

/// The settings, and what is known of the identifier beforehand.
pub(super) fn of(scenario: &Scenario) -> Result<(LoopSettings, Outcome), PilError> {
    let refused = |what: &str| Err(PilError::Scenario(what.to_owned()));
    let identifier = &scenario.identifier;
    let Law::Gradient(_) = &identifier.law else {
        return refused("identifier.law: the firmware has \"gradient\"");
    };
    let format = match identifier.arithmetic {
        Arithmetic::F32 => Format::Single,
        Arithmetic::Fixed => Format::Fixed,
        Arithmetic::F64 => {
            return refused("identifier.arithmetic: the firmware has \"f32\" and \"fixed\"");
        }
    };
    let friction = match identifier.model_set() {
        ModelSet::Ab => false,
        ModelSet::AbCoulomb if format == Format::Single => true,
        _ => {
            return refused(
                "identifier.parameters: the firmware has [\"a\", \"b\"], and in f32 \
                 [\"a\", \"b\", \"coulomb\"]",
            );
        }
    };
    if identifier.parameters.len() != 2 + usize::from(friction) {
        return refused("identifier.parameters: the firmware estimates every one of its model");
    }
    if identifier.ranges.is_some() {
        return refused("identifier.ranges: the firmware chooses them itself");
    }
    let VelocitySettings::LowPass(cutoff) = scenario.controller.velocity else {
        return refused("controller.velocity_filter.kind: the firmware has \"low-pass\"");
    };
    let Some(counts_per_rev) = scenario.counts_per_rev else {
        return refused(NO_COUNTS);
    };
    let outcome = outcome(scenario)?;
    let mut gamma = [0.0; 3];
    for (i, row) in outcome.gamma.iter().flatten().enumerate() {
        for (j, &entry) in row.iter().enumerate() {
            match gamma.get_mut(i) {
                Some(place) if i == j => *place = entry,
                _ if entry == 0.0 => {}
                _ => return refused("identifier.gamma: the firmware has a diagonal one"),
            }
        }
    }
    let controller = &scenario.controller;
    let (gains, initial, bounds) = (&controller.gains, &identifier.initial, &identifier.bounds);
    let pair = |interval: Interval| [interval.min(), interval.max()];
    let settings = LoopSettings {
        sample_time: controller.units.sample_time(),
        counts_per_rev,
        gains: [gains.kp(), gains.kd(), gains.ki()],
        limit: [scenario.limit.low(), scenario.limit.high()],
        cutoff,
        plant_box: identifier
            .plant_box
            .map(|plant_box| [pair(plant_box.a()), pair(plant_box.b())]),
        initial: [initial.a, initial.b, initial.coulomb, initial.load],
        bounds: [bounds.a, bounds.b, bounds.coulomb, bounds.load].map(pair),
        gamma,
        mu: outcome.mu,
        friction,
        format,
    };
    Ok((settings, outcome))
}

/// What the same identifier is known to be on the host.
fn outcome(scenario: &Scenario) -> Result<Outcome, PilError> {
    struct Build<'a>(&'a Scenario, &'a Reference<f64>);

    impl WithVelocity<f64> for Build<'_> {
        type Output = Result<Outcome, String>;

        fn with<V: VelocityEstimate<f64> + 'static>(self, velocity: V) -> Self::Output {
            let Self(scenario, reference) = self;
            experiment::learner::<f64, V>(scenario, velocity, reference)
                .map(|(_, outcome)| outcome)
                .map_err(|error| error.to_string())
        }
    }

    let units = &scenario.controller.units;
    let reference = Reference::<f64>::new(units, &scenario.excitation)
        .map_err(|error| PilError::Scenario(format!("excitation: {error}")))?;
    scenario
        .controller
        .velocity
        .with(units, Build(scenario, &reference))
        .map_err(|error| PilError::Scenario(format!("controller.velocity_filter: {error}")))?
        .map_err(PilError::Scenario)
}
