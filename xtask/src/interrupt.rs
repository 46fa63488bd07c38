//! The whole sample interrupt of the linked drive in a run: its instructions, counted on an emulated chip.

use std::error::Error;
use std::thread;

use drive_link::{Command, Estimator};
use drive_logic::{MIN_SAMPLE_TIME, MIN_SAMPLE_TIME_WITH_TERMS};
use identifier_core::parameters::{Term, Terms};
use servo_id::drive::Driven;

use crate::meter::Cost;
use crate::metered::{self, Metered, Next, instructions_in, share};

/// An estimator, with the terms that it estimates and its sample time (s), by the name that its figures have.
#[derive(Clone, Copy)]
struct NamedEstimator {
    name: &'static str,
    law: Estimator,
    terms: Terms,
    sample_time: f64,
}

impl NamedEstimator {
    const fn plain(name: &'static str, law: Estimator, sample_time: f64) -> Self {
        Self {
            name,
            law,
            terms: Terms::NONE,
            sample_time,
        }
    }

    /// The shortest sample time at which the drive runs it, s.
    fn min_sample_time(&self) -> f64 {
        if self.terms.is_empty() {
            MIN_SAMPLE_TIME
        } else {
            MIN_SAMPLE_TIME_WITH_TERMS
        }
    }
}

/// Every term that the drive estimates.
const ALL_TERMS: Terms = Terms::NONE
    .with(Term::Delay)
    .with(Term::Asymmetry)
    .with(Term::LowSpeed)
    .with(Term::Gravity)
    .with(Term::Ripple)
    .with(Term::DeadBand);

const GRADIENT: Estimator = Estimator::Gradient { friction: false };
const GRADIENT_FRICTION: Estimator = Estimator::Gradient { friction: true };

/// The estimators of the drive, at a usual rate and at the highest.
const ESTIMATORS: [NamedEstimator; 7] = [
    NamedEstimator::plain("gradient-friction", GRADIENT_FRICTION, 1e-3),
    NamedEstimator::plain("gradient", GRADIENT, 1e-3),
    NamedEstimator::plain("gauss-newton", Estimator::GaussNewton, 1e-3),
    NamedEstimator {
        terms: ALL_TERMS,
        ..NamedEstimator::plain("gauss-newton-terms", Estimator::GaussNewton, 1e-3)
    },
    NamedEstimator::plain(
        "gradient-friction-20-khz",
        GRADIENT_FRICTION,
        MIN_SAMPLE_TIME,
    ),
    NamedEstimator::plain("gradient-20-khz", GRADIENT, MIN_SAMPLE_TIME),
    NamedEstimator::plain(
        "gauss-newton-20-khz",
        Estimator::GaussNewton,
        MIN_SAMPLE_TIME,
    ),
];

/// Functions by which interrupts are classified, in the order of the marks. The first begins a run, the second shows a
/// sample, the third ends the run.
const MARKS: [&str; 3] = ["Run::start", "sampler::report", "Sampler::end_run"];
const FIRST: u32 = 0b001;
const SHOWN: u32 = 0b010;
const FAILED: u32 = 0b100;

/// Interrupts that are counted, from the one that begins the run.
const COUNTED: usize = 20_000;

/// Samples from one that is shown to the next.
const WATCHED: u16 = 20;

/// Counts the interrupts of every estimator: the figures by name.
///
/// # Errors
/// Also where one takes more than half of the shortest sample that the drive allows its estimator.
pub(crate) fn figures(metered: &Metered) -> Result<Vec<(String, u64)>, String> {
    let count_one = |law: &NamedEstimator| {
        let costs = measure(metered, |client| start(client, law))?;
        let named = |fault| format!("{}: {fault}", law.name);
        let summary = summary(&costs).map_err(named)?;
        let [.., (_, worst)] = summary;
        check_half_is_free(worst, law.min_sample_time()).map_err(named)?;
        Ok(summary.map(|(which, taken)| (format!("interrupt-{}-{which}", law.name), taken)))
    };
    thread::scope(|scope| {
        let count_one = &count_one;
        let laws = ESTIMATORS.each_ref();
        let laws = laws.map(|law| scope.spawn(move || count_one(law)));
        let counted = laws.into_iter().map(|law| {
            let counted = law.join();
            counted.map_err(|_| "counting an estimator has failed".to_owned())?
        });
        let counted = counted.collect::<Result<Vec<_>, String>>()?;
        Ok(counted.into_iter().flatten().collect())
    })
}

/// # Errors
/// An interrupt takes more than half of a sample.
fn check_half_is_free(taken: u64, sample_time: f64) -> Result<(), String> {
    let allowed = instructions_in(sample_time / 2.0);
    if taken <= allowed {
        return Ok(());
    }
    Err(format!(
        "an interrupt takes {taken} instructions, of which {allowed} are allowed: half of a sample of {} µs",
        1e6 * sample_time
    ))
}

/// Starts an estimator, and some of its samples being shown.
fn start(drive: &mut Driven, law: &NamedEstimator) -> Result<(), Box<dyn Error>> {
    let mut settings = drive.settings()?;
    settings.closed_loop.law = law.law;
    settings.closed_loop.core.sample_time = law.sample_time;
    let declared = &mut settings.closed_loop.core.identifier.terms;
    declared.demanded = law.terms;
    declared.low_speed_velocity = Some(0.2);
    declared.ripple_order = Some(11.0);
    // The emulator's time is not the host's.
    settings.protection.link_timeout = 0.0;
    drive.ask(Command::Configure(settings))?;
    drive.ask(Command::Watch(WATCHED))?;
    drive.ask(Command::Start)?;
    Ok(())
}

/// The costs of the interrupts from the one that begins a run.
fn measure(
    metered: &Metered,
    conversation: impl FnOnce(&mut Driven) -> Result<(), Box<dyn Error>>,
) -> Result<Vec<Cost>, String> {
    let mut costs = Vec::with_capacity(COUNTED);
    let take = |cost: Cost| {
        if costs.is_empty() && !has(cost, FIRST) {
            return Ok(Next::Interrupt);
        }
        if has(cost, FAILED) {
            return Err(format!(
                "the drive ends its run with a fault after {} samples: those that are counted \
                 must all be of a run",
                costs.len()
            ));
        }
        costs.push(cost);
        Ok(if costs.len() == COUNTED {
            Next::Enough
        } else {
            Next::Interrupt
        })
    };
    metered::run(metered, &MARKS, conversation, take)?;
    Ok(costs)
}

fn has(cost: Cost, mark: u32) -> bool {
    cost.marks & mark != 0
}

/// The instructions of the interrupts of a run, the first of which begins it, by name: the medians of those that show
/// nothing and of those that show a sample, the one that begins the run, and the most of all.
fn summary(costs: &[Cost]) -> Result<[(&'static str, u64); 4], String> {
    let (first, others) = costs.split_first().ok_or("no interrupt was seen")?;
    let (shown, typical): (Vec<_>, Vec<_>) =
        others.iter().copied().partition(|&cost| has(cost, SHOWN));
    let of = |costs: &[Cost], part| {
        let instructions: Vec<u64> = costs.iter().map(|cost| cost.instructions).collect();
        share(&instructions, part)
    };
    let middle = |costs: &[Cost], which: &str| match costs {
        [] => Err(format!("no interrupt {which} a sample shown was seen")),
        costs => Ok(of(costs, 0.5)),
    };
    Ok([
        ("typical", middle(&typical, "without")?),
        ("shown", middle(&shown, "with")?),
        ("first", first.instructions),
        ("worst", of(costs, 1.0)),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost(marks: u32, instructions: u64) -> Cost {
        Cost {
            marks,
            command: None,
            instructions,
        }
    }

    #[test]
    fn the_classes_are_separate() {
        let costs = [
            cost(FIRST | SHOWN, 900),
            cost(0, 100),
            cost(0, 110),
            cost(0, 5000),
            cost(SHOWN, 300),
        ];
        let summary = summary(&costs).expect("all classes are there");
        let named = summary.map(|(_, instructions)| instructions);
        assert_eq!(named, [110, 300, 900, 5000]);
    }

    #[test]
    fn a_run_keeps_half_of_a_sample_free() {
        for (sample_time, half) in [(5e-5, 1909), (1.5e-4, 5727)] {
            assert_eq!(check_half_is_free(half, sample_time), Ok(()));
            assert!(check_half_is_free(half + 1, sample_time).is_err());
        }
    }

    #[test]
    fn a_class_that_was_not_seen_is_an_error() {
        let first = cost(FIRST, 900);
        assert!(summary(&[]).is_err());
        assert!(summary(&[first]).is_err());
        assert!(summary(&[first, cost(0, 1)]).is_err());
        assert!(summary(&[first, cost(SHOWN, 1)]).is_err());
    }
}
