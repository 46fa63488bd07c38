//! The paper's experiment (Miranda, Garrido and Bortoni, section IV): both methods, with the
//! amplifier balanced and unbalanced.

use host_sim::identify_run;
use host_sim::scenario::{self, Fault, Purpose, Scenario};
use identifier_log::experiment::Sample;
use identifier_log::result::Summary;

/// The paper's nominal a, 1/s.
pub const NOMINAL_A: f64 = 0.2174;

/// The paper's nominal b, rad/s² per command unit.
pub const NOMINAL_B: f64 = 257.7;

/// The unbalanced amplifier as a load, rad/s².
pub const UNBALANCE: f64 = 20.0;

/// The scenario of the proposed method with a balanced amplifier. It is the file that the README
/// offers as a first scenario.
pub const PROPOSED: &str = scenario::PAPER;

/// The scenario of the least squares with a balanced amplifier.
pub const LEAST_SQUARES: &str = scenario::PAPER_LEAST_SQUARES;

/// The two methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The Γ-gradient estimator on the model loop.
    Proposed,
    /// Relay-closed recursive least squares.
    LeastSquares,
}

/// The two cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// No load.
    Balanced,
    /// Constant load.
    Unbalanced,
}

/// One of the four experiments.
#[derive(Debug, Clone)]
pub struct Run {
    /// Its method.
    pub method: Method,
    /// Its case.
    pub case: Case,
    /// The result.
    pub summary: Summary,
    /// Every sample.
    pub trace: Vec<Sample>,
}

impl Method {
    /// Its name for a reader, which with dashes is that of its files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Proposed => "proposed",
            Self::LeastSquares => "least squares",
        }
    }
}

impl Run {
    /// The experiment's name for a reader.
    #[must_use]
    pub fn name(&self) -> String {
        let case = match self.case {
            Case::Balanced => "d = 0",
            Case::Unbalanced => "d ≠ 0",
        };
        format!("{}, {case}", self.method.name())
    }
}

/// All four, in the order of Fig. 03.
pub const EXPERIMENT: [(Method, Case); 4] = [
    (Method::Proposed, Case::Balanced),
    (Method::LeastSquares, Case::Balanced),
    (Method::Proposed, Case::Unbalanced),
    (Method::LeastSquares, Case::Unbalanced),
];

/// The name of one of the experiments for a file.
#[must_use]
pub fn file_stem(method: Method, case: Case) -> String {
    let case = match case {
        Case::Balanced => "balanced",
        Case::Unbalanced => "unbalanced",
    };
    format!("{}-{case}", method.name().replace(' ', "-"))
}

/// The scenario of a method and a case.
///
/// # Panics
/// Never: both files are part of the program and tested.
#[must_use]
pub fn scenario(method: Method, case: Case) -> Scenario {
    let (name, text) = match method {
        Method::Proposed => ("paper.toml", PROPOSED),
        Method::LeastSquares => ("paper-least-squares.toml", LEAST_SQUARES),
    };
    let mut scenario =
        Scenario::parse(name, text, Purpose::Run).expect("the built-in scenarios are valid");
    if let Some(plant) = &mut scenario.plant {
        plant.load = match case {
            Case::Balanced => 0.0,
            Case::Unbalanced => UNBALANCE,
        };
    }
    scenario
}

/// Runs all four, in the order of [`EXPERIMENT`].
///
/// # Errors
/// As [`identify_run`]; the tests see that there are none.
pub fn experiment() -> Result<[Run; 4], Fault> {
    let [first, second, third, fourth] = EXPERIMENT.map(|(method, case)| run(method, case));
    Ok([first?, second?, third?, fourth?])
}

fn run(method: Method, case: Case) -> Result<Run, Fault> {
    let scenario = scenario(method, case);
    let mut trace = Vec::new();
    let found = identify_run(scenario, &|| true, &mut |_, sample| trace.push(*sample))?;
    Ok(Run {
        method,
        case,
        summary: found.summary,
        trace,
    })
}
