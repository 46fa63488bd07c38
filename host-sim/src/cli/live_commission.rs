use identifier_core::commission::{HoldingGains, Limits};

use super::call;
use super::live::Live;
use crate::commission::{Course, Outcome, Sample};
use crate::present::{Commissioned, commissioning};
use crate::report::commission::Traces;
use crate::scenario::Scenario;

/// Shows a commissioning while it goes on: its report, as far as it has come.
#[derive(Debug)]
pub(super) struct LiveCommission<'a> {
    live: Live,
    title: String,
    scenario: &'a Scenario,
    limits: Limits,
    before: Option<HoldingGains>,
    course: Course,
}

impl<'a> LiveCommission<'a> {
    pub(super) fn new(
        live: Live,
        title: String,
        scenario: &'a Scenario,
        limits: Limits,
        before: Option<HoldingGains>,
    ) -> Self {
        Self {
            live,
            title,
            scenario,
            limits,
            before,
            course: Course::default(),
        }
    }

    /// A sample, which the traces have taken in.
    pub(super) fn add(&mut self, sample: &Sample, traces: &Traces) {
        self.course.add(sample);
        if !self.live.keep_pace(sample.time) {
            return;
        }
        let outcome = Outcome {
            end: None,
            known: Vec::new(),
            tuning: None,
            no_gains: None,
            trial: None,
            course: self.course.clone().finish(sample.time),
        };
        let page = commissioning(&Commissioned {
            title: &self.title,
            command: &call::command(),
            scenario: self.scenario,
            limits: &self.limits,
            before: self.before.as_ref(),
            outcome: &outcome,
            traces: Some(traces),
        });
        let clock = format!(
            "running: {} since {:.2} s",
            sample.phase.name(),
            self.since()
        );
        self.live.show(&page.so_far(clock));
    }

    /// When the phase began, s.
    fn since(&self) -> f64 {
        self.course
            .phases
            .last()
            .map_or(0.0, |stretch| stretch.begin)
    }

    /// What shows it in the end.
    pub(super) fn into_live(self) -> Live {
        self.live
    }
}
