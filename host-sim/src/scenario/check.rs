//! Checks of a scenario as a whole, for the purpose that it is read for.

use identifier_core::error::Allowed;
use identifier_core::parameters::Term;

use super::error::Fault;
use super::estimator::{Estimator, LoopKind};
use super::{Arithmetic, Purpose, Scenario, commission, inner, log, physical};

/// The longest run, control samples.
const MAX_SAMPLES: f64 = 1e10;

/// The position unit of an ideal sensor, rad: as of an encoder that is finer than any effect.
const IDEAL_UNIT: f64 = 1e-5;

/// Completes a parsed scenario for a purpose. `build` finds settings from which no loop can be built.
pub(super) fn complete(
    mut scenario: Scenario,
    purpose: Purpose,
    build: fn(&Scenario) -> Result<(), Fault>,
) -> Result<Scenario, Fault> {
    let unit = |counts| std::f64::consts::TAU / counts;
    scenario.stated.resolution = scenario.counts_per_rev.map_or(IDEAL_UNIT, unit);
    if purpose == Purpose::Commission {
        commission::adopt_sample_time(&mut scenario)?;
    }
    scenario.checked_units()?;
    physical::check(&scenario, purpose)?;
    let sample_time = scenario.sample_time();
    Allowed::Within(sample_time, MAX_SAMPLES * sample_time)
        .check("duration", scenario.duration)
        .map_err(|error| Fault::new("run.duration", error))?;
    if let Some(servo) = &scenario.plant {
        let effects = scenario.effects.check(servo, sample_time);
        effects.map_err(|error| Fault::in_effect(&error))?;
    }
    let law = scenario.identifier.law;
    if scenario.identifier.arithmetic == Arithmetic::Fixed && !law.is_gradient() {
        return Err(Fault::new(
            "identifier.arithmetic",
            "only \"gradient\" and \"pd-gradient\" exist in fixed point",
        ));
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
            replayable(&scenario)?;
            let scenario = scenario.in_own_loop();
            build(&scenario)?;
            Ok(scenario)
        }
        Purpose::Replay => {
            replayable(&scenario)?;
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

/// Checks the needs of a replay, apart from the log itself.
fn replayable(scenario: &Scenario) -> Result<(), Fault> {
    log::check(scenario)?;
    inner::check(scenario)?;
    let (given, identifier) = (&scenario.stated, &scenario.stated.identifier);
    let law = scenario.identifier.law;
    let log = scenario.log_columns();
    let own = scenario.is_log_of_simulated_run();
    let own_loop = format!(
        "\"{}\" runs only in its own loop and cannot take a log: {} can",
        law.name(),
        replayable_names()
    );
    let follows = given.controller.is_some()
        || identifier.correction.is_some()
        || identifier.parameter_range.is_some();
    let refusals = [
        (
            log.command.is_none() && log.reference.is_none(),
            "log.command",
            "the log must have the command, or the reference from which the declared controller computes it",
        ),
        (
            identifier.terms.demanded.has(Term::Gravity) && !log.absolute && !own,
            "log.angle",
            "gravity depends on the absolute angle, which this counter does not give: if position zero is the same \
             angle in every recording, state angle = \"absolute\", else remove the term \"gravity\"",
        ),
        (
            !(law.is_replayable() || own && law.closing() == LoopKind::Pd),
            "identifier.law",
            own_loop.as_str(),
        ),
        (
            scenario.identifier.arithmetic == Arithmetic::Fixed
                && scenario.counts_per_rev.is_none(),
            "identifier.arithmetic",
            "\"fixed\" needs encoder.counts_per_rev, the resolution of the log's position; \"f32\" and \"f64\" do not",
        ),
        (
            given.controller.is_none() && log.command.is_none() && log.inner.is_none(),
            "controller",
            "without log.command declare the controller that ran, so that its command can be computed: [controller], \
             or [inner] for a servo that takes position goals",
        ),
        (
            law.is_gradient() && !follows,
            "identifier.correction",
            "without a [controller] this estimator needs the gains of its correction, or a plant_box to derive them \
             from",
        ),
        (
            law.is_gradient() && log.reference.is_none() && identifier.gamma.is_none(),
            "identifier.gamma",
            "without log.reference no gamma can be chosen: state it",
        ),
    ];
    let refusal = refusals.into_iter().find(|(is_refused, ..)| *is_refused);
    refusal.map_or(Ok(()), |(_, key, fault)| Err(Fault::new(key, fault)))
}

fn replayable_names() -> String {
    let replayable = Estimator::ALL.iter().filter(|law| law.is_replayable());
    let names: Vec<_> = replayable
        .map(|law| format!("\"{}\"", law.name()))
        .collect();
    names.join(", ")
}
