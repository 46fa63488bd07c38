//! The picture of a result, as the program draws it.

use identifier_log::analysis::Seen;
use identifier_log::experiment::Sample;
use identifier_log::result::Summary;
use host_sim::scenario::Scenario;
use servo_id::present::{self, Experiment, ExperimentTraces};
use servo_id::render::chart::{self, Size};

/// The picture as SVG, empty without samples. They get what the model leaves of them, where it is known at their end.
pub(crate) fn picture(
    scenario: &Scenario,
    summary: &Summary,
    seen: Option<&Seen>,
    samples: &mut [Sample],
) -> String {
    if samples.is_empty() {
        return String::new();
    }
    let errors = seen.iter().flat_map(|seen| &seen.errors);
    for (sample, error) in samples.iter_mut().zip(errors) {
        sample.output_error = Some(*error);
    }
    let mut traces = ExperimentTraces::default();
    for sample in samples {
        traces.add(sample);
    }
    let page = present::experiment(&Experiment {
        title: "",
        command: "",
        scenario,
        summary,
        traces: Some(&traces),
        seen,
    });
    chart::figures(Size::Page, "", 2, page.figures()).svg()
}
