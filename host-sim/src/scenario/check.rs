//! Checks of a scenario as a whole, for the purpose that it is read for.

use identifier_core::error::Allowed;

use identifier_log::scenario::Fault;
use virtual_servo::EffectError;

use super::{Purpose, Scenario, commission};

/// The longest run, control samples.
const MAX_SAMPLES: f64 = 1e10;

/// Completes a parsed scenario for a purpose. `build` finds settings from which no loop can be built.
pub(crate) fn complete(
    mut scenario: Scenario,
    purpose: Purpose,
    build: fn(&Scenario) -> Result<(), Fault>,
) -> Result<Scenario, Fault> {
    scenario.purpose = purpose;
    if purpose == Purpose::Commission {
        commission::adopt_sample_time(&mut scenario)?;
    }
    scenario.options.complete(purpose == Purpose::Replay)?;
    let sample_time = scenario.sample_time();
    Allowed::Within(sample_time, MAX_SAMPLES * sample_time)
        .check("duration", scenario.duration)
        .map_err(|error| Fault::new("run.duration", error))?;
    if let Some(servo) = &scenario.plant {
        let effects = scenario.effects.check(servo, sample_time);
        effects.map_err(|error| in_effect(&error))?;
    }
    match purpose {
        Purpose::Run => {
            scenario.servo()?;
            lasting(&scenario)?;
            let scenario = scenario.in_own_loop();
            build(&scenario)?;
            Ok(scenario)
        }
        Purpose::Commission => {
            scenario.servo()?;
            build(&scenario)?;
            Ok(scenario)
        }
        // A replay knows its units and its reference only once the log is read.
        Purpose::Replay if scenario.is_log_of_simulated_run() => {
            scenario.check_log(true)?;
            let scenario = scenario.in_own_loop();
            build(&scenario)?;
            Ok(scenario)
        }
        Purpose::Replay => {
            scenario.check_log(false)?;
            Ok(scenario)
        }
    }
}

/// Checks that gain and friction last as long as the run.
fn lasting(scenario: &Scenario) -> Result<(), Fault> {
    let drifts = [
        ("plant.gain_drift", scenario.effects.gain_drift, "gain"),
        (
            "plant.friction_drift",
            scenario.effects.friction_drift,
            "friction",
        ),
    ];
    for (key, drift, what) in drifts {
        if drift * scenario.duration <= -1.0 {
            let (ends, duration) = (-1.0 / drift, scenario.duration);
            let fault = format!(
                "no {what} would be left after {ends} s, but the run lasts {duration} s: reduce the drift or \
                 run.duration"
            );
            return Err(Fault::new(key, fault));
        }
    }
    Ok(())
}

/// An effect that the servo of a scenario cannot have, at its key.
pub(crate) fn in_effect(error: &EffectError) -> Fault {
    Fault::new(format!("plant.{}", error.parameter()), error)
}
