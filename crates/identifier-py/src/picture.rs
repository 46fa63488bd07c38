//! The picture of a result, as the program draws it.

use host_sim::IdentifiedScenario;
use identifier_log::experiment::Sample;
use servo_id::present::{self, Experiment, ExperimentTraces};
use servo_id::render::chart::{self, Size};

/// The picture as SVG, empty without samples.
pub(crate) fn picture(found: &IdentifiedScenario, samples: &[Sample]) -> String {
    if samples.is_empty() {
        return String::new();
    }
    let mut traces = ExperimentTraces::default();
    for sample in samples {
        traces.add(sample);
    }
    let page = present::experiment(&Experiment {
        title: "",
        command: "",
        scenario: &found.scenario,
        summary: &found.summary,
        traces: Some(&traces),
        seen: found.seen.as_ref(),
    });
    chart::figures(Size::Page, "", 2, page.figures()).svg()
}
