//! The judgement on an identification: its values against the truth, its verdict, and the causes that it names.

use std::time::Instant;

use identifier_core::parameters::{Parameter, ServoParameters, Unknown};
use identifier_log::result::{EnteredEffect, Summary, TermSize};
use identifier_log::verdict::Status;

use integration_tests::in_parallel;
use integration_tests::logs::{Effect, LoopSetup, RecordedLog, drawn_with};

use super::identify::{LogFile, Settings};
use super::truth::truth;

/// The judgement on one log under some settings.
#[derive(Debug, Clone)]
pub(super) struct Judgement {
    /// The effects of the log.
    pub(super) present: Vec<Effect>,
    /// True if the result is called converged.
    pub(super) is_converged: bool,
    /// The largest error of a, b, c and d over its tolerance; none without a result.
    pub(super) wrongness: Option<f64>,
    /// Relative error of b.
    pub(super) off_b: Option<f64>,
    /// Errors over standard errors, of parameters whose truth is one value.
    pub(super) deviations: Vec<f64>,
    /// The effects that the result names, the first of them first, and whether the log has them: the cause that the
    /// model lacks, the terms that entered, the effects that a fit found, and a noise above that of rounding.
    pub(super) names: Vec<(&'static str, bool)>,
    /// For a shifted log: estimated minus true shift, samples.
    pub(super) off_shift: Option<f64>,
    /// Estimated over true noise of the position, less one.
    pub(super) off_noise: Option<f64>,
    /// Time of the identification, s.
    pub(super) seconds: f64,
    /// The reason of the verdict, or the refusal.
    pub(super) reason: String,
}

impl Judgement {
    /// Whether the first name is that of an effect which the log has; none without a name.
    pub(super) fn first_name_is_right(&self) -> Option<bool> {
        self.names.first().map(|(_, is_right)| *is_right)
    }

    /// True if a, b, c and d are within their tolerances.
    pub(super) fn is_right(&self) -> bool {
        self.wrongness.is_some_and(|wrongness| wrongness <= 1.0)
    }
}

/// Draws a log for each of some items and judges it under each of some settings: a list per setting, in the order of the
/// items.
pub(super) fn judge<T: Sync>(
    settings: &[Settings],
    items: &[T],
    draw: impl Fn(&T) -> RecordedLog + Sync,
) -> Vec<Vec<Judgement>> {
    let by_log = in_parallel(items, |item| {
        let log = draw(item);
        let file = LogFile::write(&log);
        let of = |&settings: &Settings| {
            let begun = Instant::now();
            let result = file.identify(&log, settings);
            judgement(&log, result, begun.elapsed().as_secs_f64())
        };
        settings.iter().map(of).collect::<Vec<_>>()
    });
    let of_setting = |place: usize| by_log.iter().map(|all| all[place].clone()).collect();
    (0..settings.len()).map(of_setting).collect()
}

/// A noise that is not rounding's alone, counts.
const NOISY: f64 = 0.4;

fn judgement(log: &RecordedLog, result: Result<Summary, String>, seconds: f64) -> Judgement {
    let setup = &log.setup;
    let refused = Judgement {
        present: setup.present.clone(),
        is_converged: false,
        wrongness: None,
        off_b: None,
        deviations: Vec::new(),
        names: Vec::new(),
        off_shift: None,
        off_noise: None,
        seconds,
        reason: String::new(),
    };
    let summary = match result {
        Ok(summary) => summary,
        Err(reason) => return Judgement { reason, ..refused },
    };
    let errors: Option<Vec<Error>> = Parameter::ALL
        .into_iter()
        .map(|parameter| Error::of(parameter, &summary, log))
        .collect();
    let has = |name: &str| setup.present.iter().any(|&effect| is_name_of(name, effect));
    // An effect beside which another explains the log nearly as well has no name.
    let fit = summary.fit.iter().flat_map(|fit| &fit.effects);
    let found = fit.filter(|effect| effect.or.is_none());
    let late = (summary.fit.iter()).filter_map(|fit| fit.command_recorded_late.map(|_| "shift"));
    let noisy = (summary.noise.moving_counts).filter(|counts| *counts > NOISY);
    // A noise that grows with the speed is that of the sampling instants.
    let is_jitter = |effect: &EnteredEffect| effect.name == Effect::Jitter.name();
    let noisy = noisy.filter(|_| !found.clone().any(is_jitter));
    let noisy = noisy.map(|_| Effect::Noise.name());
    let names = (summary.cause.iter().map(|finding| finding.cause.name()))
        .chain(summary.terms_entered.iter().map(|(term, _)| term.name()))
        .chain(late)
        .chain(noisy)
        .chain(found.map(|effect| effect.name));
    Judgement {
        is_converged: summary.status() == Status::Converged,
        wrongness: errors.as_ref().map(|errors| {
            let all = errors.iter().map(|error| error.size / error.tolerance);
            all.fold(0.0, f64::max)
        }),
        off_b: errors.as_ref().map(|errors| errors[1].size / setup.servo.b),
        deviations: errors
            .iter()
            .flatten()
            .filter_map(Error::deviation)
            .collect(),
        names: names.map(|name| (name, has(name))).collect(),
        off_shift: off_shift(&summary, setup),
        off_noise: off_noise(&summary, setup),
        reason: summary.reason,
        ..refused
    }
}

/// The error of an estimate.
struct Error {
    /// Distance from the truth, or from the range of it.
    size: f64,
    /// The least error that matters, or more where the result says that it is less sure.
    tolerance: f64,
    std_error: Option<f64>,
    /// True if the truth is one value.
    is_constant: bool,
}

impl Error {
    /// Relative tolerances: of b, and of the others.
    const OF_B: f64 = 0.02;
    const OF_OTHERS: f64 = 0.05;
    /// A negligible acceleration, relative to that by the largest commands: load and friction may be as far off.
    const OF_AUTHORITY: f64 = 0.01;
    /// Three standard errors widen a tolerance, by no more than this factor.
    const WIDEST: f64 = 4.0;

    /// For a parameter; none if the estimate is no number.
    fn of(parameter: Parameter, summary: &Summary, log: &RecordedLog) -> Option<Self> {
        let truth = truth(parameter, log);
        let estimate = summary.estimates.get(parameter);
        if !estimate.value.is_finite() {
            return None;
        }
        let size = (truth[0] - estimate.value)
            .max(estimate.value - truth[1])
            .max(0.0);
        // The 0.1 % largest commands are left out, for a single peak is no authority.
        let hardly_matters =
            Self::OF_AUTHORITY * log.setup.servo.b * log.command_exceeded_by(0.001);
        let largest = truth[0].abs().max(truth[1].abs());
        let tolerance = match parameter {
            Parameter::B => Self::OF_B * largest,
            Parameter::A => (Self::OF_OTHERS * largest).max(hardly_matters / log.velocity_rms),
            Parameter::Coulomb | Parameter::Load => (Self::OF_OTHERS * largest).max(hardly_matters),
        };
        let std_error = estimate.std_error.filter(|error| !error.is_nan());
        let three = 3.0 * std_error.unwrap_or(0.0);
        Some(Self {
            size,
            tolerance: three.clamp(tolerance, Self::WIDEST * tolerance),
            std_error,
            is_constant: truth[0] >= truth[1],
        })
    }

    /// The error over the standard error.
    fn deviation(&self) -> Option<f64> {
        let known = self
            .std_error
            .filter(|error| *error > 0.0 && error.is_finite());
        known
            .filter(|_| self.is_constant)
            .map(|std_error| self.size / std_error)
    }
}

/// The error of the lag between a row and the action of its command, samples, where the record is shifted; none where
/// nothing of it is known.
fn off_shift(summary: &Summary, setup: &LoopSetup) -> Option<f64> {
    let is_delay = |term: &&TermSize| term.unknown == Unknown::Delay;
    let delay = summary.estimates.terms.iter().find(is_delay);
    let fit = summary.fit.as_ref();
    let late = fit.and_then(|fit| fit.command_recorded_late);
    let sizes = fit.iter().flat_map(|fit| &fit.effects);
    let lags = sizes.flat_map(|effect| &effect.sizes);
    let lag: f64 = lags
        .filter(|(name, _)| *name == "time_constant_s")
        .map(|(_, lag)| lag)
        .sum();
    // A command that was recorded late is a delay below zero: the same fact twice.
    let found = delay.map_or(0.0, |delay| delay.value) + lag;
    let found = late.map_or(found / setup.sample_time, |late| -late);
    let effects = &setup.effects;
    let true_lag = setup.shift + (effects.delay + effects.current_loop) / setup.sample_time;
    let is_known = delay.is_some() || late.is_some();
    (is_known && setup.present.contains(&Effect::Shift)).then_some(found - true_lag)
}

/// The relative error of the position's noise: rounding and the sensor's.
fn off_noise(summary: &Summary, setup: &LoopSetup) -> Option<f64> {
    let count = std::f64::consts::TAU / setup.counts_per_rev;
    let rounding = 1.0 / 12.0_f64.sqrt();
    let noise = rounding.hypot(setup.sensor.noise / count);
    summary.noise.moving_counts.map(|found| found / noise - 1.0)
}

/// True if a name that results use stands for an effect.
fn is_name_of(name: &str, effect: Effect) -> bool {
    let others: &[&str] = match effect {
        // A lag resembles a delay, and so does a record that is early.
        Effect::CurrentLoop | Effect::Shift => &["delay"],
        Effect::LowSpeedFriction => &["low-speed"],
        Effect::LoadDependentFriction => &["load-friction"],
        Effect::InertiaVariation => &["varying-inertia"],
        Effect::TorqueRipple => &["ripple"],
        _ => &[],
    };
    name == effect.name() || others.contains(&name)
}

#[test]
fn a_result_is_right_for_its_servo_and_wrong_for_another() {
    let mut log = drawn_with(2, 3, &[]);
    let file = LogFile::write(&log);
    let result = file.identify(&log, super::identify::FOUR);
    let is_right = |log: &RecordedLog| judgement(log, result.clone(), 0.0).is_right();
    assert!(is_right(&log), "{result:?}");
    let own = log.setup.servo;
    let authority = own.b * log.command_exceeded_by(0.0);
    let others = [
        ServoParameters {
            b: 1.1 * own.b,
            ..own
        },
        ServoParameters {
            a: own.a + authority / log.velocity_rms,
            ..own
        },
        ServoParameters {
            coulomb: own.coulomb + 0.2 * authority,
            ..own
        },
        ServoParameters {
            load: own.load - 0.2 * authority,
            ..own
        },
    ];
    for other in others {
        log.setup.servo = other;
        assert!(!is_right(&log), "{other:?}");
    }
}
