//! Every method on the same servo: cases that each break one assumption, and one that breaks all.

mod cases;

pub use cases::Case;

use rayon::prelude::*;

use identifier_core::parameters::Parameter;
use identifier_core::settings::{IdentifierSettings, ParameterRangeSettings};

use crate::analysis::Summariser;
use identifier_log::result::Summary;

use crate::result::{CaseResult, ComparisonResult, Method, MethodErrors};
use crate::scenario::{Arithmetic, Estimator, Fault, LoopKind, Scenario, range_around};
use crate::simulate::Simulation;
use identifier_log::verdict::Status;

/// The scenario with another estimator and the most parameters that it estimates, in the loop that the estimator
/// closes.
#[must_use]
pub fn with_estimator(base: &Scenario, law: Estimator) -> Scenario {
    let mut scenario = base.clone();
    scenario.identifier.set_estimator(law);
    // A controller's integral finds the load in any case.
    let finds_all = law.is_rival() || law.takes_whole_record();
    let wanted = |parameter: &Parameter| finds_all || *parameter != Parameter::Load;
    scenario.identifier.parameters = law.finds().iter().copied().filter(wanted).collect();
    if scenario.identifier.arithmetic == Arithmetic::Fixed && !law.is_gradient() {
        scenario.identifier.arithmetic = Arithmetic::F32;
    }
    // The stated servo stays for the estimators that need it; the tuning of an estimator does not.
    let stated = &mut scenario.stated.identifier;
    let unstated = IdentifierSettings {
        max_speed: stated.max_speed,
        ranges: stated.ranges,
        ..IdentifierSettings::UNSTATED
    };
    *stated = match law.fits() {
        true => unstated,
        false => IdentifierSettings {
            initial: stated.initial,
            bounds: stated.bounds,
            parameter_range: stated.parameter_range,
            ..unstated
        },
    };
    scenario.in_own_loop()
}

/// The estimators that are compared: those that work in the loop.
fn compared() -> Vec<Estimator> {
    let all = Estimator::ALL.iter().copied();
    all.filter(|law| !law.takes_whole_record()).collect()
}

/// Number of runs of a comparison.
///
/// # Errors
/// The scenario has no servo.
pub fn runs(base: &Scenario) -> Result<usize, Fault> {
    Ok(compared().len() * Case::all(base)?.len())
}

/// Runs every method in every case, on all cores, and calls `done` at each run's end.
///
/// # Errors
/// The scenario has no servo.
pub fn compare(base: &Scenario, done: &(dyn Fn() + Sync)) -> Result<ComparisonResult, Fault> {
    let assumed_range = assumed_range(base)?;
    let mut base = base.clone();
    let known = &mut base.stated.identifier;
    if let Some(within) = assumed_range {
        known.parameter_range = Some(within);
        known.initial.b = Some(within.b[0]);
    }
    let cases = Case::all(&base)?;
    let laws = compared();
    let methods: Vec<Method> = laws.iter().map(|&law| method(law)).collect();
    let found: Vec<MethodErrors> = cases
        .par_iter()
        .flat_map(|case| laws.par_iter().map(move |&law| (case, law)))
        .map(|(case, law)| {
            let found = run(&with_estimator(&case.scenario, law));
            done();
            found
        })
        .collect();
    let mut found = found.into_iter();
    let cases = cases.into_iter().map(|case| CaseResult {
        case: case.name,
        detail: case.detail,
        methods: found.by_ref().take(methods.len()).collect(),
    });
    let cases = cases.collect();
    Ok(ComparisonResult {
        methods,
        cases,
        assumed_range,
    })
}

/// The parameter range for methods that need one, if the scenario states neither a range nor a first b.
fn assumed_range(base: &Scenario) -> Result<Option<ParameterRangeSettings>, Fault> {
    let stated = &base.stated.identifier;
    let is_known = stated.parameter_range.is_some() || stated.initial.b.is_some();
    let servo = base.servo()?;
    Ok((!is_known).then(|| range_around(&servo)))
}

fn method(law: Estimator) -> Method {
    Method {
        name: law.name(),
        source: law.source(),
        prior: law.prior(),
        closing: match law.closing() {
            LoopKind::Pid => "PID",
            LoopKind::Pd => "PD",
            LoopKind::Relay => "relay",
        },
    }
}

fn run(scenario: &Scenario) -> MethodErrors {
    let refused = MethodErrors {
        law: scenario.identifier.law.name(),
        true_b: scenario.plant.map_or(1.0, |plant| plant.b),
        ..MethodErrors::default()
    };
    let simulation = match Simulation::build(scenario) {
        Ok(simulation) => simulation,
        Err(refusal) => {
            let reason = refusal.to_string();
            return MethodErrors { reason, ..refused };
        }
    };
    let mut summariser = Summariser::new(scenario);
    let outcome = simulation.run(&mut |sample| summariser.add(sample));
    let summary = summariser.finish(scenario, outcome);
    let error = |parameter| error(&summary, parameter);
    MethodErrors {
        status: Some(summary.status()),
        error_a: error(Parameter::A),
        error_b: error(Parameter::B),
        error_coulomb: error(Parameter::Coulomb),
        error_load: error(Parameter::Load),
        settling_a: summary.settling_time.a,
        settling_b: summary.settling_time.b,
        reason: summary.reason,
        ..refused
    }
}

/// The estimate less the truth; none where the method has no estimate.
fn error(summary: &Summary, parameter: Parameter) -> Option<f64> {
    let truth = summary.truth.as_ref()?;
    let estimate = summary.estimate(parameter)?;
    let error = estimate.value - truth.get(parameter);
    (summary.status() != Status::Aborted && error.is_finite()).then_some(error)
}
