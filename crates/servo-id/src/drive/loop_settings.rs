//! From a scenario to the settings that a drive builds its loop from, and back.

use std::f64::consts::TAU;

use drive_link::{Estimator as LinkEstimator, HoldingBrake, LoopSettings};
use host_sim::scenario::{Arithmetic, Estimator, Fault, ModelSet, Options, Scenario, Velocity};
use identifier_core::parameters::Parameter;

/// The holding brake of a scenario as a drive's setting.
#[must_use]
pub fn holding_brake(scenario: &Scenario) -> Option<HoldingBrake> {
    (scenario.brake).map(|[opens, closes]| HoldingBrake { opens, closes })
}

/// The settings of a drive's loop for a scenario.
///
/// # Errors
/// The key that asks for something that the firmware does not have.
pub fn loop_settings(scenario: &Scenario) -> Result<LoopSettings, Fault> {
    let refused = |key: &str, fault: &str| Err(Fault::new(key, fault));
    let identifier = &scenario.identifier;
    let gradient = match &identifier.law {
        Estimator::Gradient => true,
        Estimator::GaussNewton => false,
        _ => {
            return refused(
                "identifier.law",
                "the firmware has \"gradient\" and \"gauss-newton\"",
            );
        }
    };
    if identifier.arithmetic != Arithmetic::F32 {
        return refused(
            "identifier.arithmetic",
            "the firmware has \"f32\"; for fixed point (chips without an FPU) write your own firmware",
        );
    }
    let law = match scenario.model_set() {
        ModelSet::Ab if gradient => LinkEstimator::Gradient { friction: false },
        ModelSet::AbCoulomb if gradient => LinkEstimator::Gradient { friction: true },
        ModelSet::AbCoulombLoad if !gradient => LinkEstimator::GaussNewton,
        _ => {
            return refused(
                "identifier.parameters",
                "the firmware has [\"a\", \"b\"] and [\"a\", \"b\", \"coulomb\"], and for gauss-newton \
                 [\"a\", \"b\", \"coulomb\", \"load\"]",
            );
        }
    };
    if scenario.velocity != Velocity::LowPass {
        return refused(
            "controller.velocity_filter.kind",
            "the firmware has \"low-pass\"",
        );
    }
    if scenario.counts_per_rev.is_none() {
        let fault = "a chip needs an encoder with counts, so it must not be 0";
        return refused("encoder.counts_per_rev", fault);
    }
    let core = scenario.settings()?;
    // Refuses with the scenario's key what the drive would refuse with its own.
    scenario.identifiable_with(&core)?;
    Ok(LoopSettings { core, law })
}

/// The settings of a drive's loop as the tables of a scenario that sends them, where they differ from the defaults.
#[must_use]
pub fn tables_of(of: &LoopSettings) -> String {
    let parameters = match of.law {
        LinkEstimator::Gradient { friction: false } => &Parameter::ALL[..2],
        LinkEstimator::Gradient { friction: true } => &Parameter::ALL[..3],
        LinkEstimator::GaussNewton => &Parameter::ALL,
    };
    let mut options = Options::blank();
    options.identifier.set_estimator(match of.law {
        LinkEstimator::Gradient { .. } => Estimator::Gradient,
        LinkEstimator::GaussNewton => Estimator::GaussNewton,
    });
    options.identifier.parameters = parameters.to_vec();
    options.stated = of.core;
    // To the last digits but one, those of a quotient.
    options.set_encoder((1e6 * TAU / of.core.resolution).round() / 1e6);
    options.text()
}

#[cfg(test)]
mod tests {
    use drive_link::HoldingBrake;
    use virtual_servo::VirtualBrake;

    #[test]
    fn a_drive_takes_the_times_of_a_brake_that_a_scenario_may_state() {
        let [scenario, drive] = [VirtualBrake::MAX_TIME, HoldingBrake::MAX_TIME];
        assert_eq!(scenario.to_bits(), drive.to_bits());
    }
}
