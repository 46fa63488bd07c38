//! The judgement on an identification: its values against the truth, its verdict, and the causes that it names.

use std::time::Instant;

use host_sim::analysis::Status;
use host_sim::result::Summary;
use identifier_core::parameters::{Parameter, ServoParameters, Unknown};

use integration_tests::in_parallel;
use integration_tests::logs::{Draw, DrawnLog, Effect};

use super::identify::{LogFile, Settings};
use super::truth::truth;

const PARAMETERS: [Parameter; 4] = [
    Parameter::A,
    Parameter::B,
    Parameter::Coulomb,
    Parameter::Load,
];

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
    /// The cause that is named, and whether the log has it.
    pub(super) named: Option<(&'static str, bool)>,
    /// The terms that entered, and whether the log has them.
    pub(super) entered: Vec<(&'static str, bool)>,
    /// Of a log that is shifted: estimated less true shift, samples.
    pub(super) off_shift: Option<f64>,
    /// Estimated over true noise of the position, less one.
    pub(super) off_noise: Option<f64>,
    /// Time of the identification, s.
    pub(super) seconds: f64,
    /// The reason of the verdict, or the refusal.
    pub(super) reason: String,
}

impl Judgement {
    /// True if a, b, c and d are within their tolerances.
    pub(super) fn is_right(&self) -> bool {
        self.wrongness.is_some_and(|wrongness| wrongness <= 1.0)
    }
}

/// Draws logs by their numbers and judges each under each of some settings: a list per setting, in the order of the
/// numbers.
pub(super) fn judge(
    settings: &[Settings],
    numbers: &[u32],
    draw: impl Fn(u32) -> DrawnLog + Sync,
) -> Vec<Vec<Judgement>> {
    let by_log = in_parallel(numbers, |&number| {
        let log = draw(number);
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

fn judgement(log: &DrawnLog, result: Result<Summary, String>, seconds: f64) -> Judgement {
    let draw = &log.draw;
    let refused = Judgement {
        present: draw.present.clone(),
        is_converged: false,
        wrongness: None,
        off_b: None,
        deviations: Vec::new(),
        named: None,
        entered: Vec::new(),
        off_shift: None,
        off_noise: None,
        seconds,
        reason: String::new(),
    };
    let summary = match result {
        Ok(summary) => summary,
        Err(reason) => return Judgement { reason, ..refused },
    };
    let errors: Option<Vec<Error>> = PARAMETERS
        .iter()
        .map(|&parameter| Error::of(parameter, &summary, log))
        .collect();
    let has = |name: &str| draw.present.iter().any(|&effect| is_name_of(name, effect));
    let entered = summary.terms_entered.iter();
    // An effect beside which another explains the log nearly as well has no name.
    let fit = summary.fit.iter().flat_map(|fit| &fit.effects);
    let named = fit
        .filter(|effect| effect.or.is_none())
        .map(|effect| effect.name);
    Judgement {
        is_converged: summary.status() == Status::Converged,
        wrongness: errors.as_ref().map(|errors| {
            let all = errors.iter().map(|error| error.size / error.tolerance);
            all.fold(0.0, f64::max)
        }),
        off_b: errors.as_ref().map(|errors| errors[1].size / draw.servo.b),
        deviations: errors
            .iter()
            .flatten()
            .filter_map(Error::deviation)
            .collect(),
        named: summary.cause.as_ref().map(|finding| {
            let name = finding.cause.name();
            (name, has(name))
        }),
        entered: entered
            .map(|(term, _)| term.name())
            .chain(named)
            .map(|name| (name, has(name)))
            .collect(),
        off_shift: off_shift(&summary, draw),
        off_noise: off_noise(&summary, draw),
        reason: summary.reason,
        ..refused
    }
}

/// The error of an estimate.
struct Error {
    /// Distance from the truth, or from the range of it.
    size: f64,
    tolerance: f64,
    std_error: Option<f64>,
    /// True if the truth is one value.
    is_constant: bool,
}

impl Error {
    /// Relative tolerances: of b, and of the others.
    const OF_B: f64 = 0.02;
    const OF_OTHERS: f64 = 0.05;
    /// An acceleration that hardly matters, of that by the largest commands: load and friction may be as far off.
    const OF_AUTHORITY: f64 = 0.01;
    /// Three standard errors widen a tolerance, by no more than this factor.
    const WIDEST: f64 = 4.0;

    /// Of a parameter; none if the estimate is no number.
    fn of(parameter: Parameter, summary: &Summary, log: &DrawnLog) -> Option<Self> {
        let truth = truth(parameter, log);
        let estimate = summary.estimates.get(parameter);
        if !estimate.value.is_finite() {
            return None;
        }
        let size = (truth[0] - estimate.value)
            .max(estimate.value - truth[1])
            .max(0.0);
        // The 0.1 % largest commands are left out, for a single peak is no authority.
        let hardly_matters = Self::OF_AUTHORITY * log.draw.servo.b * log.command_exceeded_by(0.001);
        let largest = truth[0].abs().max(truth[1].abs());
        let tolerance = match parameter {
            Parameter::B => Self::OF_B * largest,
            Parameter::A => (Self::OF_OTHERS * largest).max(hardly_matters / log.velocity_rms),
            Parameter::Coulomb | Parameter::Load => (Self::OF_OTHERS * largest).max(hardly_matters),
        };
        let three = 3.0 * estimate.std_error.unwrap_or(0.0);
        Some(Self {
            size,
            tolerance: three.clamp(tolerance, Self::WIDEST * tolerance),
            std_error: estimate.std_error,
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
/// none is estimated.
fn off_shift(summary: &Summary, draw: &Draw) -> Option<f64> {
    let is_delay = |term: &&host_sim::result::TermSize| term.unknown == Unknown::Delay;
    let delay = summary.estimates.terms.iter().find(is_delay)?.value;
    let effects = &draw.effects;
    let lag = draw.shift + (effects.delay + effects.current_loop) / draw.sample_time;
    let is_shifted = draw.present.contains(&Effect::Shift);
    is_shifted.then_some(delay / draw.sample_time - lag)
}

/// The relative error of the position's noise: what the model leaves of it against that of rounding and sensor.
fn off_noise(summary: &Summary, draw: &Draw) -> Option<f64> {
    let count = std::f64::consts::TAU / draw.counts_per_rev;
    let rounding = count / 12.0_f64.sqrt();
    let noise = draw.sensor.noise.hypot(rounding);
    summary.residual.map(|residual| residual.rms / noise - 1.0)
}

/// True if a name that results use stands for an effect.
fn is_name_of(name: &str, effect: Effect) -> bool {
    let others: &[&str] = match effect {
        // A lag resembles a delay, and so does a record that is early.
        Effect::CurrentLoop | Effect::Shift => &["delay"],
        Effect::LowSpeedFriction => &["low-speed"],
        Effect::TorqueRipple => &["ripple"],
        _ => &[],
    };
    name == effect.name() || others.contains(&name)
}

#[test]
fn a_result_is_right_for_its_servo_and_wrong_for_another() {
    let mut log = Draw::log_with(2, 3, &[]);
    let file = LogFile::write(&log);
    let result = file.identify(&log, super::identify::FOUR);
    let is_right = |log: &DrawnLog| judgement(log, result.clone(), 0.0).is_right();
    assert!(is_right(&log), "{result:?}");
    let own = log.draw.servo;
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
        log.draw.servo = other;
        assert!(!is_right(&log), "{other:?}");
    }
}
