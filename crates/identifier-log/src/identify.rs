//! Identification from logs: the one way from their rows to what is known of the servo.

use identifier_core::measurement::VelocityEstimate;
use identifier_core::parameters::{Parameter, PerParameter, ServoParameters};
use identifier_core::stability::SampledLoopError;
use log_fit::{GoesOn, Logged};

use crate::analysis::{Ending, EstimationMethod, RoughAnswer, Seen, WholeRecord};
use crate::experiment::{NO_ESTIMATE, Outcome, Sample};
use crate::found_servo::FoundServo;
use crate::log::Log;
use crate::predictions::predict_logs;
use crate::replay::{Agreement, Played, Player, Stopped};
use crate::result::{Estimate, LogReading, ReplayNotes, SettlingTime, Summary};
use crate::scenario::{Fault, Options};
use crate::verdict::VerdictReason;
use crate::with_velocity;

/// A servo identified from its logs.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The options with what only the logs know.
    pub options: Options,
    /// The result.
    pub summary: Summary,
    /// What was identified from.
    pub recorded: RecordedSamples,
    /// The residuals of the model over the logs. None if nothing explains them.
    pub seen: Option<Seen>,
    /// The servo itself, for a [prediction](crate::predict::predict). None if there is none.
    pub found: Option<FoundServo>,
}

/// The samples of logs, one after the other, SI.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordedSamples {
    /// Time, s, without the ranges that are left out.
    pub times: Vec<f64>,
    /// Reference, rad; NaN where it is not known.
    pub references: Vec<f64>,
    /// Position, rad, and the command that acted.
    pub samples: Vec<Logged>,
}

/// Identifies the servo of one or more logs by a fit to all of them. It predicts the logs of `predictions`, which do not enter
/// the fit unless they are among the others. `goes_on` is asked before each step of the search; once it is false, the
/// result has what is known until then.
///
/// # Errors
/// The key that does not suit the logs.
pub fn identify(
    logs: &[Log],
    predictions: &[Log],
    options: &Options,
    goes_on: GoesOn<'_>,
) -> Result<Identified, Fault> {
    options.check_terms_of_fit()?;
    let options = options.clone().fitted(logs, false);
    let (recorded, agreement, outcome) = with_velocity!(options, f64 => record(&options, logs))?;
    let options = options.along(&recorded.samples);
    let fitted = recorded.fit(&options, &outcome, goes_on);
    let whole = fitted.1.as_ref();
    let options = Options {
        between: whole.map_or(options.between, WholeRecord::between),
        ..options
    };
    let found = whole.map(WholeRecord::found);
    let predicted = predict_logs(&options, found.as_ref(), logs, predictions)?;
    let notes = ReplayNotes {
        agreement,
        logs: LogReading::all(logs, predictions),
        predictions: predicted.predictions,
    };
    let mut identified = Identified::new(
        options,
        recorded,
        outcome,
        &fitted,
        predicted.largest_error,
        None,
    );
    identified.summary.replay = notes;
    Ok(identified)
}

/// Identifies the servo of a simulated run that has ended, as one of a log. `unstable_loop` is why it may have ended
/// early.
#[must_use]
pub fn identify_run(
    options: &Options,
    recorded: RecordedSamples,
    outcome: Outcome,
    unstable_loop: Option<SampledLoopError>,
    goes_on: GoesOn<'_>,
) -> Identified {
    let fitted = recorded.fit(options, &outcome, goes_on);
    Identified::new(
        options.clone(),
        recorded,
        outcome,
        &fitted,
        None,
        unstable_loop,
    )
}

impl Identified {
    fn new(
        options: Options,
        recorded: RecordedSamples,
        outcome: Outcome,
        (rough, whole): &(RoughAnswer, Option<WholeRecord>),
        prediction: Option<f64>,
        unstable_loop: Option<SampledLoopError>,
    ) -> Self {
        let samples = &recorded.samples;
        let whole = whole.as_ref();
        let servo = whole.map_or(NO_ESTIMATE, |whole| *whole.servo());
        let course = |parameter: Parameter, _| Estimate::of_fit(servo.get(parameter));
        let seen =
            whole.and_then(|whole| Seen::new(&options, samples, &recorded.references, whole));
        let innovation = |whole| seen.as_ref().map(|seen| seen.innovation(whole));
        let summary = Ending {
            options: &options,
            method: EstimationMethod::Fit(whole.map(|whole| (whole, innovation(whole))), rough),
            samples,
            travelled: recorded.travelled(),
            outcome,
            servo,
            course: &course,
            prediction,
            truth: None,
            output_error: None,
            settling_time: SettlingTime { a: None, b: None },
            unstable_loop,
        }
        .summary();
        let is_rough = matches!(summary.verdict.reason, VerdictReason::Rough { .. });
        Self {
            found: whole.map(WholeRecord::found),
            options,
            summary,
            recorded,
            seen: seen.filter(|_| !is_rough),
        }
    }

    /// Its samples, each with the residual of the model where there is one, and the estimates of the whole.
    pub fn samples(&self) -> impl Iterator<Item = Sample> {
        let recorded = &self.recorded;
        let estimates = ServoParameters::from_fn(|parameter| {
            let estimate = self.summary.estimate(parameter);
            estimate.map_or(f64::NAN, |estimate| estimate.value)
        });
        let free_run = self.seen.as_ref().and_then(|seen| seen.free_run.as_ref());
        let samples = recorded.samples.iter().enumerate();
        samples.map(move |(place, of)| Sample {
            time: recorded.times[place],
            begins: of.begins,
            reference: recorded.references[place],
            position: of.position,
            command: of.command,
            output_error: free_run.map(|ran| ran.errors[place]),
            estimates,
            standard_errors: None,
            at_bounds: PerParameter::default(),
        })
    }
}

fn record<V: VelocityEstimate<f64>>(
    options: &Options,
    logs: &[Log],
) -> Result<(RecordedSamples, Option<Agreement>, Outcome), Fault> {
    let Some(log) = logs.first() else {
        return Err(Fault::new("log", "there is no log"));
    };
    let settings = options.identifier_settings();
    let is_declared = log.first().reference.is_some() && settings.controller.is_some();
    let command_recorded = log.first().command.is_some();
    let mut player = Player::<V>::new(options, &settings, is_declared, command_recorded)?;
    let (mut recorded, mut outcome) = (RecordedSamples::default(), Outcome::default());
    let played = player.play(options, logs, 1, &mut |played| {
        let Played { row, input, .. } = played;
        outcome.count(None);
        recorded.times.push(played.time);
        recorded.references.push(row.reference.unwrap_or(f64::NAN));
        recorded.samples.push(Logged {
            position: row.position,
            command: input.command,
            begins: input.beginning.is_some(),
        });
        Ok(())
    });
    if let Err(Stopped { time, error }) = played {
        outcome.end_early(time, error);
    }
    Ok((recorded, player.agreement(), outcome))
}

impl RecordedSamples {
    /// Takes in a sample of a run.
    pub fn add(&mut self, sample: &Sample) {
        self.times.push(sample.time);
        self.references.push(sample.reference);
        self.samples.push(sample.logged());
    }

    /// The rough answer and the fit of all of it; none where it ended early or nothing explains it.
    fn fit(
        &self,
        options: &Options,
        outcome: &Outcome,
        goes_on: GoesOn<'_>,
    ) -> (RoughAnswer, Option<WholeRecord>) {
        if outcome.abort.is_some() {
            return (RoughAnswer::default(), None);
        }
        WholeRecord::identify(options, &self.samples, goes_on)
    }

    /// The distance travelled, forth and back, rad.
    fn travelled(&self) -> f64 {
        let pairs = self.samples.windows(2).filter(|pair| !pair[1].begins);
        pairs
            .map(|pair| (pair[1].position - pair[0].position).abs())
            .sum()
    }
}
