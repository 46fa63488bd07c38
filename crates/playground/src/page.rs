//! The functions that the page calls.

use std::cell::RefCell;
use std::fmt::Write;

use identifier_core::parameters::Parameter;
use identifier_core::settings::ControllerSettings;
use identifier_core::tuning::Tuning;
use identifier_log::recognise::{LogOptions, Recognised};
use identifier_log::result::Summary;
use identifier_log::tune::{Conditions, Tuned};

use crate::experiment::PageRun;
use crate::log;
use crate::settings::Settings;

/// Memory that the page and its functions share.
struct Page {
    input: Vec<u8>,
    text: String,
    numbers: Vec<f64>,
    experiment: Option<PageRun>,
    summary: Option<Summary>,
}

thread_local! {
    static PAGE: RefCell<Page> = const {
        RefCell::new(Page {
            input: Vec::new(),
            text: String::new(),
            numbers: Vec::new(),
            experiment: None,
            summary: None,
        })
    };
}

/// A function of the page: 1 if it did what it was asked for, otherwise 0 and the text says why.
fn answer(function: impl FnOnce(&mut Page) -> Result<(), String>) -> u32 {
    PAGE.with_borrow_mut(|page| {
        page.text.clear();
        page.numbers.clear();
        match function(page) {
            Ok(()) => 1,
            Err(refusal) => {
                page.text = refusal;
                0
            }
        }
    })
}

impl Page {
    fn settings(&self) -> Result<Settings, String> {
        let values: Vec<f64> = (self.input.chunks_exact(8))
            .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap_or_default()))
            .collect();
        Settings::from_values(&values).ok_or_else(|| "the settings are not complete".to_owned())
    }

    fn result(&mut self, summary: &Summary) {
        let text = &mut self.text;
        let status = summary.status().name();
        let _ = writeln!(text, "status\t{status}");
        let _ = writeln!(text, "reason\t{}", summary.reason);
        let _ = writeln!(text, "unit\t{}", summary.position_unit.name());
        for parameter in Parameter::ALL {
            if let Some(estimate) = summary.estimate(parameter) {
                let error = estimate.std_error.unwrap_or(f64::NAN);
                let name = parameter.name();
                let _ = writeln!(
                    text,
                    "{name}\t{}\t{error}\t{}",
                    estimate.last, estimate.unit
                );
            }
        }
        for term in &summary.estimates.terms {
            let (name, unit) = (term.unknown.name(), term.unit);
            let _ = writeln!(text, "{name}\t{}\t{}\t{unit}", term.value, term.std_error);
        }
        for effect in summary.fit.iter().flat_map(|fit| &fit.effects) {
            let _ = writeln!(text, "effect\t{}\t{}", effect.name, effect.meaning);
        }
    }

    /// Gains with predicted response, margins, and the command and step that they are for.
    fn gains(&mut self, tuned: &Tuned) {
        let Tuned {
            tuning, settings, ..
        } = tuned;
        let predicted_response = &tuning.predicted_response;
        let [low, high] = predicted_response.gain_margins;
        let _ = writeln!(
            self.text,
            "gains\t{}\t{}\t{}\t{}\ncap\t{}\npredicted\t{}\t{}\nmargins\t{}\t{low}\t{high}\ncommand\t{}\n\
             step\t{}\t{}",
            tuning.kp,
            tuning.ki,
            tuning.kd,
            tuning.cutoff,
            tuning.cap.map_or(String::new(), |cap| cap.to_string()),
            predicted_response.rise_time,
            predicted_response.overshoot,
            predicted_response.sensitivity,
            settings.command,
            settings.step,
            settings.sample_time,
        );
    }

    /// Gains for a servo that is not here, and, after the numbers, the predicted step.
    ///
    /// # Errors
    /// Why there are none.
    fn predicted(&mut self, tuned: &Tuned) -> Result<(), String> {
        let step = tuned
            .tuner()
            .and_then(|tuner| tuner.step(&tuned.tuning))
            .map_err(|error| error.to_string())?;
        let samples = (shown_time(&tuned.tuning) / tuned.settings.sample_time).ceil();
        let rows = self.numbers.len();
        let step = step.take(samples as usize).map(|sample| sample.position);
        self.numbers.extend(step);
        self.gains(tuned);
        let _ = writeln!(self.text, "rows\t{rows}");
        Ok(())
    }
}

/// The time for which a step under new gains is shown, s.
fn shown_time(tuning: &Tuning) -> f64 {
    /// In 1/ω of their loop, and the least, s.
    const SHOWN: [f64; 2] = [25.0, 0.2];
    (SHOWN[0] / tuning.bandwidth).max(SHOWN[1])
}

/// Columns, a line each.
fn listed(columns: &[String]) -> String {
    let lines = columns.iter().map(|name| format!("column\t{name}\n"));
    lines.collect()
}

/// What a log was taken as, by option.
fn chosen(recognised: &Recognised) -> Vec<(&'static str, String)> {
    let settings = &recognised.settings;
    let units = &settings.units;
    let reference = match recognised.inner {
        Some(_) => "goal",
        None => "reference",
    };
    let columns = [
        ("time", settings.time.as_ref()),
        ("position", Some(&settings.position)),
        ("command", settings.command.as_ref()),
        (reference, settings.reference.as_ref()),
        ("velocity", settings.velocity.as_ref()),
    ];
    let columns = columns.into_iter();
    let columns = columns.filter_map(|(option, column)| Some((option, column?.to_string())));
    let more = [
        ("time-unit", units.time.name().to_owned()),
        ("position-unit", units.position.name().to_owned()),
        ("position-scale", units.position_scale.to_string()),
        ("command-scale", units.command_scale.to_string()),
    ];
    let counts = recognised.counts_per_rev;
    let counts = counts.map(|counts| ("counts-per-rev", counts.to_string()));
    columns.chain(more).chain(counts).collect()
}

/// A buffer for what is to be read next.
#[unsafe(no_mangle)]
pub extern "C" fn input(length: usize) -> *mut u8 {
    PAGE.with_borrow_mut(|page| {
        page.input = vec![0; length];
        page.input.as_mut_ptr()
    })
}

/// The text of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> *const u8 {
    PAGE.with_borrow(|page| page.text.as_ptr())
}

/// Its length, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn text_length() -> usize {
    PAGE.with_borrow(|page| page.text.len())
}

/// The numbers of the last answer.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f64 {
    PAGE.with_borrow(|page| page.numbers.as_ptr())
}

/// How many there are.
#[unsafe(no_mangle)]
pub extern "C" fn numbers_length() -> usize {
    PAGE.with_borrow(|page| page.numbers.len())
}

/// Runs the settings in the buffer, [`Settings::COUNT`] numbers: the numbers are the rows of the samples.
#[unsafe(no_mangle)]
pub extern "C" fn run() -> u32 {
    answer(|page| {
        let scenario = page.settings()?.scenario();
        let scenario = scenario.map_err(|fault| fault.to_string())?;
        let experiment = PageRun::run(scenario).map_err(|fault| fault.to_string())?;
        page.numbers = experiment.rows();
        page.experiment = Some(experiment);
        page.summary = None;
        Ok(())
    })
}

/// The verdict on the last run.
#[unsafe(no_mangle)]
pub extern "C" fn judge() -> u32 {
    answer(|page| {
        let experiment = page.experiment.as_ref().ok_or("nothing has run yet")?;
        let summary = experiment.summary();
        page.result(&summary);
        page.summary = Some(summary);
        Ok(())
    })
}

/// Gains for the last result, or why there are none. The true servo's step before tuning, then after it.
#[unsafe(no_mangle)]
pub extern "C" fn tune() -> u32 {
    /// For a loop that is not tuned, s.
    const SHOWN_UNTUNED: f64 = 1.0;
    answer(|page| {
        let (Some(experiment), Some(summary)) = (&page.experiment, &page.summary) else {
            return Err("no verdict".to_owned());
        };
        let (before, cutoff) = experiment.controller();
        let step = |controller, cutoff, size: f64, time: f64| {
            let samples = (time / summary.sample_time).round();
            let step = experiment.step(controller, cutoff, size, samples * summary.sample_time);
            step.map_err(|fault| fault.to_string())
        };
        let tuned = match experiment.tuned(summary) {
            Ok(tuned) => tuned,
            Err(why) => {
                let size = Conditions::STEP;
                page.numbers = step(before, cutoff, size, SHOWN_UNTUNED)?;
                let time = summary.sample_time;
                let _ = writeln!(page.text, "none\t{why}\nstep\t{size}\t{time}");
                return Ok(());
            }
        };
        let (tuning, settings) = (&tuned.tuning, &tuned.settings);
        let time = shown_time(tuning);
        let after = ControllerSettings::tuned(tuning, before.limit);
        page.numbers = [
            step(before, cutoff, settings.step, time)?,
            step(after, tuning.cutoff, settings.step, time)?,
        ]
        .concat();
        page.gains(&tuned);
        Ok(())
    })
}

/// The scenario of the settings in the buffer as a text for the command line.
#[unsafe(no_mangle)]
pub extern "C" fn scenario() -> u32 {
    answer(|page| {
        page.text = page.settings()?.text();
        Ok(())
    })
}

/// Identifies the log in the buffer, which follows a text of `stated` bytes. The text has answers to questions, one per
/// line: flag, tab, answer. The numbers are time, position and residual of its samples. Open questions are lines that
/// begin with a question mark. A line each has the columns that may be chosen. After the rows follows the predicted step of the gains for the result.
#[unsafe(no_mangle)]
pub extern "C" fn identify(stated: usize) -> u32 {
    answer(|page| {
        let log = page.input.split_off(stated.min(page.input.len()));
        let answers = String::from_utf8_lossy(&std::mem::take(&mut page.input)).into_owned();
        let mut stated = LogOptions::default();
        for (flag, answer) in answers.lines().filter_map(|line| line.split_once('\t')) {
            let refused = |allowed| format!("?{flag}\t{allowed}");
            stated.answer(flag, answer).map_err(refused)?;
        }
        let found = log::identify(log, &stated);
        let found = found.map_err(|refusal| refusal.text + "\n" + &listed(&refusal.columns))?;
        page.result(&found.summary);
        page.text += &listed(&found.columns);
        for (option, value) in chosen(&found.recognised) {
            let _ = writeln!(page.text, "chosen\t{option}\t{value}");
        }
        for finding in &found.recognised.findings {
            let _ = writeln!(page.text, "finding\t{}\t{}", finding.about, finding.text);
        }
        page.numbers = found.rows.into_flattened();
        if let Some(window) = found.window {
            let _ = writeln!(page.text, "window\t{window}");
        }
        if let Err(why) = found.tuned.and_then(|tuned| page.predicted(&tuned)) {
            let _ = writeln!(page.text, "none\t{why}");
        }
        Ok(())
    })
}
