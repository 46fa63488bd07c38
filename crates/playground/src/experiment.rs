//! A run of the page's settings: samples, verdict, gains, steps before and after.

use host_sim::scenario::{Estimator, ExcitationKind, ExcitationSettings, Fault, Purpose, Scenario};
use host_sim::simulate;
use identifier_core::settings::ControllerSettings;
use identifier_log::experiment::{Outcome, Sample};
use identifier_log::result::Summary;
use identifier_log::tune::Tuned;
use identifier_log::{RecordedSamples, identify_run};

/// A run that has ended.
#[derive(Debug, Clone)]
pub struct PageRun {
    scenario: Scenario,
    samples: Vec<Sample>,
    outcome: Outcome,
}

/// Columns of [`PageRun::rows`].
pub const COLUMNS: usize = 13;

impl PageRun {
    /// Runs a scenario.
    ///
    /// # Errors
    /// The key that something cannot be built from.
    pub fn run(scenario: Scenario) -> Result<Self, Fault> {
        let mut samples = Vec::with_capacity(scenario.samples() as usize);
        let outcome = simulate::run(&scenario, &mut |sample| samples.push(*sample))?;
        Ok(Self {
            scenario,
            samples,
            outcome,
        })
    }

    /// Row by row the columns of `servo-id run --csv`: time, reference, position, command, output error, the
    /// estimates of a, b, c and d, and their standard errors; NaN where there is none.
    #[must_use]
    pub fn rows(&self) -> Vec<f64> {
        let values = |sample: &Sample| {
            let all = sample.measured().into_iter().chain(sample.identified());
            all.map(|value| value.unwrap_or(f64::NAN))
                .collect::<Vec<_>>()
        };
        self.samples.iter().flat_map(values).collect()
    }

    /// The verdict on it, by the fit of its whole record.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let mut scenario = self.scenario.clone();
        scenario.identifier.set_estimator(Estimator::Fit);
        let mut recorded = RecordedSamples::default();
        for sample in &self.samples {
            recorded.add(sample);
        }
        // The events of the recursive estimator do not concern the fit.
        let outcome = Outcome {
            samples: self.outcome.samples,
            abort: self.outcome.abort,
            ..Outcome::default()
        };
        let unstable = scenario.unstable_loop();
        let found = identify_run(&scenario, recorded, outcome, unstable, &|| true);
        Summary {
            truth: scenario.plant,
            ..found.summary
        }
    }

    /// Gains for a result of it.
    ///
    /// # Errors
    /// Why there are none, without an end.
    pub fn tuned(&self, summary: &Summary) -> Result<Tuned, String> {
        Tuned::stiffest(&self.scenario, summary).map(|(tuned, _)| tuned)
    }

    /// The step response of the true servo under gains and a cut-off, rad/s: positions, rad, from the step on. Before
    /// it the servo settles for `time`, s, and the step is watched as long.
    ///
    /// # Errors
    /// The key that something cannot be built from.
    pub fn step(
        &self,
        controller: ControllerSettings,
        cutoff: f64,
        size: f64,
        time: f64,
    ) -> Result<Vec<f64>, Fault> {
        let mut scenario = self.scenario.clone();
        scenario.faults.clear();
        scenario.identifier.set_estimator(Estimator::Fit);
        scenario.stated.controller = Some(controller);
        scenario.stated.cutoff = cutoff;
        scenario.excitation = ExcitationSettings {
            kind: ExcitationKind::Steps,
            levels: vec![0.0, size],
            hold: time,
            ..ExcitationSettings::default()
        };
        scenario.duration = 2.0 * time;
        let run = Self::run(scenario.checked(Purpose::Run)?)?;
        let begin = run.samples.len() / 2;
        Ok(run.samples[begin..]
            .iter()
            .map(|sample| sample.position)
            .collect())
    }

    /// Its controller and cut-off.
    #[must_use]
    pub fn controller(&self) -> (ControllerSettings, f64) {
        (*self.scenario.controller(), self.scenario.stated.cutoff)
    }
}
