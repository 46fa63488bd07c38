use super::call;
use super::live::Live;
use crate::analysis::Summariser;
use crate::experiment::Outcome;
use crate::present::traces::Traces;
use crate::present::{self, Experiment};
use crate::scenario::Scenario;

/// Shows a run or a replay while it goes on: its report, as far as it has come.
#[derive(Debug)]
pub(super) struct LiveExperiment {
    live: Live,
    title: String,
    scenario: Scenario,
    /// How long all of it takes, s.
    duration: f64,
    samples: u64,
}

impl LiveExperiment {
    pub(super) fn new(live: Live, title: &str, scenario: &Scenario, duration: f64) -> Self {
        Self {
            live,
            title: title.to_owned(),
            scenario: scenario.clone(),
            duration,
            samples: 0,
        }
    }

    /// A sample was taken in.
    pub(super) fn add(&mut self, summariser: &Summariser, traces: &Traces) {
        self.samples += 1;
        let done = self.samples as f64 * self.scenario.sample_time();
        if !self.live.keep_pace(done) {
            return;
        }
        let outcome = Outcome {
            samples: self.samples,
            ..Outcome::default()
        };
        let summary = summariser.clone().finish(&self.scenario, outcome);
        let page = present::experiment(&Experiment {
            title: &self.title,
            command: &call::command(),
            scenario: &self.scenario,
            summary: &summary,
            traces: Some(traces),
        });
        let clock = format!("running: {done:.1} of {:.1} s", self.duration);
        self.live.show(&page.so_far(clock));
    }

    /// What shows it in the end.
    pub(super) fn into_live(self) -> Live {
        self.live
    }
}
