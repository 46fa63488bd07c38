//! Every method on the same servo: cases that each break one assumption, and one that breaks all.

mod cases;

pub use cases::Case;

use rayon::prelude::*;

use identifier_core::parameters::Parameter;
use identifier_core::settings::IdentifierSettings;

use crate::analysis::Summariser;
use crate::result::Summary;
use crate::scenario::{Arithmetic, Closing, Fault, Law, Scenario};
use crate::simulate::{Simulation, operations};

/// A comparison.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The methods, one row in each table.
    pub methods: Vec<Method>,
    /// The cases, in order.
    pub cases: Vec<Compared>,
}

/// What is to be said of a method whatever the case.
#[derive(Debug, Clone)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// Where it is from.
    pub source: &'static str,
    /// What must be known beforehand.
    pub prior: &'static str,
    /// What closes its loop.
    pub closing: &'static str,
    /// Arithmetic operations a sample; none for what is computed after the experiment, or cannot be
    /// built for this servo.
    pub operations: Option<f64>,
}

/// One case with the results of all methods, in their order.
#[derive(Debug, Clone)]
pub struct Compared {
    /// The case.
    pub case: Case,
    /// What each method found.
    pub results: Vec<MethodResult>,
}

/// What a method found.
#[derive(Debug, Clone)]
pub enum MethodResult {
    /// It ran.
    Ran(Box<Summary>),
    /// It cannot be built for this case.
    Refused(String),
}

/// The scenario with another law and the parameters that it estimates at most, in the loop that the
/// law closes.
#[must_use]
pub fn with_law(base: &Scenario, law: Law) -> Scenario {
    let mut scenario = base.clone();
    scenario.identifier.set_law(law);
    // A controller's integral finds the load in any case.
    let wanted = |parameter: &Parameter| law.is_rival() || *parameter != Parameter::Load;
    scenario.identifier.parameters = law.finds().iter().copied().filter(wanted).collect();
    if scenario.identifier.arithmetic == Arithmetic::Fixed && !law.is_gradient() {
        scenario.identifier.arithmetic = Arithmetic::F32;
    }
    // What is stated of the servo stays, for the laws that need it; what a law is tuned with does not.
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
            plant_box: stated.plant_box,
            ..unstated
        },
    };
    scenario.in_own_loop()
}

/// How many runs a comparison is.
///
/// # Errors
/// The scenario has no servo.
pub fn runs(base: &Scenario) -> Result<usize, Fault> {
    Ok(Law::ALL.len() * Case::all(base)?.len())
}

/// Runs every method in every case, on all cores; `done` is told of each run's end.
///
/// # Errors
/// The scenario has no servo.
pub fn compare(base: &Scenario, done: &(dyn Fn() + Sync)) -> Result<Comparison, Fault> {
    let laws = Law::ALL;
    let cases = Case::all(base)?;
    let pairs: Vec<(&Case, Law)> = cases
        .iter()
        .flat_map(|case| laws.iter().map(move |&law| (case, law)))
        .collect();
    let found: Vec<MethodResult> = pairs
        .par_iter()
        .map(|&(case, law)| {
            let found = run(&with_law(&case.scenario, law));
            done();
            found
        })
        .collect();
    let mut found = found.into_iter();
    let methods = laws
        .par_iter()
        .map(|law| Method {
            name: law.name(),
            source: law.source(),
            prior: law.prior(),
            closing: match law.closing() {
                Closing::Pid => "PID",
                Closing::Pd => "PD",
                Closing::Proportional => "P, low gain",
                Closing::TwoDegreesOfFreedom => "2 degrees of freedom",
                Closing::Relay => "relay",
            },
            operations: cases
                .first()
                .and_then(|case| operations(&with_law(&case.scenario, *law)).ok().flatten()),
        })
        .collect();
    Ok(Comparison {
        methods,
        cases: cases
            .into_iter()
            .map(|case| Compared {
                case,
                results: found.by_ref().take(laws.len()).collect(),
            })
            .collect(),
    })
}

fn run(scenario: &Scenario) -> MethodResult {
    let simulation = match Simulation::build(scenario) {
        Ok(simulation) => simulation,
        Err(refusal) => return MethodResult::Refused(refusal.to_string()),
    };
    let mut summariser = Summariser::new(scenario);
    let outcome = simulation.run(&mut |sample| summariser.add(sample));
    MethodResult::Ran(Box::new(summariser.finish(scenario, outcome)))
}
