//! What a sample, an interrupt and a binary cost, against what was accepted.

use std::collections::BTreeMap;
use std::fmt::{self, Write};

use crate::elf::{Elf, Sizes};
use crate::firmware::Paths;
use crate::{emulator, firmware, interrupt};

/// The budget, beside the firmware.
const FILE: &str = "firmware-stm32/budget.toml";

/// By how much a figure may rise or fall unaccepted. What became cheaper is accepted too, or it could
/// become as dear as before unnoticed.
const TOLERANCE: f64 = 0.02;

/// Binaries without static memory.
const WITHOUT_MEMORY: [&str; 4] = ["virtual-servo", "bench", "terms", "commission"];

/// Names and figures.
type Figures = BTreeMap<String, u64>;

/// Why a figure does not stand.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Objection {
    /// It is in the budget and was not counted.
    NotCounted(String),
    /// It was counted and is not in the budget.
    NotAccepted(String, u64),
    /// Nothing that is counted takes nothing: it was not counted at all.
    Zero(String),
    /// It differs from what was accepted.
    Differs {
        name: String,
        accepted: u64,
        counted: u64,
    },
}

impl fmt::Display for Objection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotCounted(name) => write!(f, "{name}: accepted, but not counted any more"),
            Self::NotAccepted(name, counted) => write!(f, "{name}: {counted}, never accepted"),
            Self::Zero(name) => write!(f, "{name}: zero, so nothing was counted"),
            Self::Differs {
                name,
                accepted,
                counted,
            } => write!(
                f,
                "{name}: {counted}, more than {} % from the {accepted} accepted",
                TOLERANCE * 100.0
            ),
        }
    }
}

/// Counts and compares; with `accept` records instead.
pub(crate) fn check(accept: bool) -> Result<(), String> {
    let counted = count()?;
    if accept {
        return record(&counted);
    }
    let accepted = accepted()?;
    for (name, value) in &counted {
        let accepted = accepted.get(name).map_or("none".to_owned(), u64::to_string);
        println!("{name:<44} {value:>7}  (accepted: {accepted})");
    }
    stands(&compare(&counted, &accepted))
}

/// Records what was counted, unless it was not counted at all.
fn record(counted: &Figures) -> Result<(), String> {
    stands(&compare(counted, counted))?;
    let mut text = String::from(
        "# Counted on the emulated chip; `cargo xtask budget --accept` records it anew.\n",
    );
    for (name, value) in counted {
        writeln!(text, "{name} = {value}").map_err(|error| error.to_string())?;
    }
    let path = firmware::root().join(FILE);
    std::fs::write(&path, text)
        .map_err(|error| format!("{} cannot be written: {error}", path.display()))
}

/// Objects to every figure that is not the one that was accepted.
fn compare(counted: &Figures, accepted: &Figures) -> Vec<Objection> {
    let missing = accepted
        .keys()
        .filter(|name| !counted.contains_key(*name))
        .map(|name| Objection::NotCounted(name.clone()));
    let wrong = counted.iter().filter_map(|(name, &counted)| {
        let name = name.clone();
        match accepted.get(&name) {
            _ if counted == 0 => Some(Objection::Zero(name)),
            None => Some(Objection::NotAccepted(name, counted)),
            Some(&accepted) => {
                let most = accepted as f64 * TOLERANCE;
                (counted.abs_diff(accepted) as f64 > most).then_some(Objection::Differs {
                    name,
                    accepted,
                    counted,
                })
            }
        }
    });
    missing.chain(wrong).collect()
}

/// An error if there is an objection.
fn stands(objections: &[Objection]) -> Result<(), String> {
    if objections.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = objections.iter().map(ToString::to_string).collect();
    Err(format!(
        "{FILE} is not what was counted:\n  {}\nmake it cheaper, or `cargo xtask budget --accept` if \
         that is what it takes now",
        lines.join("\n  ")
    ))
}

/// The budget.
pub(crate) fn accepted() -> Result<Figures, String> {
    let path = firmware::root().join(FILE);
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Name and figure: instructions a sample and an interrupt, an interrupt's cycles, bytes of state,
/// flash, static memory and stack.
fn count() -> Result<Figures, String> {
    firmware::build(&[], &[])?;
    let mut printed = emulator::run(&firmware::path("bench"))?;
    for beside in ["terms", "commission", "background"] {
        printed.push_str(&emulator::run(&firmware::path(beside))?);
    }
    let mut counted = Figures::new();
    for line in printed.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [name, mean, most, state] = words[..] else {
            return Err(format!("the bench printed a line that is none: {line}"));
        };
        for (what, figure) in [("mean", mean), ("most", most), ("state-bytes", state)] {
            let figure = figure.parse().map_err(|error| format!("{line}: {error}"))?;
            counted.insert(format!("{name}-{what}"), figure);
        }
    }
    for binary in ["virtual-servo", "bench", "terms", "commission", "drive"] {
        let Sizes { flash, memory } = Elf::read(&firmware::path(binary))?.sizes()?;
        counted.insert(format!("{binary}-flash-bytes"), flash);
        if !(memory == 0 && WITHOUT_MEMORY.contains(&binary)) {
            counted.insert(format!("{binary}-memory-bytes"), memory);
        }
    }
    let Paths {
        stack,
        sample,
        loops,
        commission,
        commission_loops,
    } = firmware::paths(&firmware::path("drive"))?;
    counted.insert("drive-stack-bytes".to_owned(), stack);
    counted.insert("drive-sample-stack-bytes".to_owned(), sample);
    counted.insert("drive-sample-loops".to_owned(), loops);
    counted.insert("drive-commission-stack-bytes".to_owned(), commission);
    counted.insert("drive-commission-loops".to_owned(), commission_loops);
    // The last, as it builds the drive anew, for the emulator.
    for (law, summary) in interrupt::count()? {
        for (which, taken) in summary.named() {
            let name = format!("interrupt-{law}-{which}");
            // One interrupt's cycles depend on what the flash's cache holds of the background; a
            // median's do not.
            if matches!(which, "typical" | "shown") {
                counted.insert(format!("{name}-cycles"), taken.cycles);
            }
            counted.insert(name, taken.instructions);
        }
    }
    Ok(counted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures<const N: usize>(figures: [(&str, u64); N]) -> Figures {
        figures.map(|(name, value)| (name.to_owned(), value)).into()
    }

    fn budget() -> Figures {
        figures([("flash", 130_000), ("sample", 400)])
    }

    #[test]
    fn what_was_accepted_stands() {
        assert_eq!(compare(&budget(), &budget()), []);
        assert_eq!(stands(&[]), Ok(()));
        let within = figures([("flash", 132_600), ("sample", 392)]);
        assert_eq!(compare(&within, &budget()), []);
    }

    #[test]
    fn a_name_that_is_not_counted_any_more_is_missed() {
        let counted = figures([("flash", 130_000)]);
        let missing = Objection::NotCounted("sample".to_owned());
        assert_eq!(compare(&counted, &budget()), [missing]);
    }

    #[test]
    fn a_name_that_was_never_accepted_is_objected_to() {
        let counted = figures([("flash", 130_000), ("new", 7), ("sample", 400)]);
        let unknown = Objection::NotAccepted("new".to_owned(), 7);
        assert_eq!(compare(&counted, &budget()), [unknown]);
    }

    #[test]
    fn zero_is_no_figure_though_it_was_accepted() {
        let zero = figures([("flash", 130_000), ("sample", 0)]);
        let objection = [Objection::Zero("sample".to_owned())];
        assert_eq!(compare(&zero, &budget()), objection);
        assert_eq!(compare(&zero, &zero), objection);
        assert!(record(&zero).is_err());
    }

    #[test]
    fn more_and_less_than_accepted_are_objected_to() {
        for counted in [391, 409] {
            let differs = Objection::Differs {
                name: "sample".to_owned(),
                accepted: 400,
                counted,
            };
            let figures = figures([("flash", 130_000), ("sample", counted)]);
            assert_eq!(compare(&figures, &budget()), [differs]);
        }
    }

    #[test]
    fn an_objection_is_an_error_that_names_the_figure() {
        let objections = compare(&figures([("flash", 200_000), ("sample", 400)]), &budget());
        let fault = stands(&objections).expect_err("flash has grown");
        assert!(fault.contains("flash: 200000"), "{fault}");
        assert!(!fault.contains("sample"), "{fault}");
    }
}
