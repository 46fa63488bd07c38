//! The cost of samples, interrupts and binaries against the accepted budget.

use std::collections::BTreeMap;

use crate::cycles::Choice;
use crate::elf::Elf;
use crate::{emulator, firmware, interrupt, lead, listing};

/// The budget, beside the firmware.
const FILE: &str = "firmware-stm32/budget.toml";

/// Relative change of a figure that needs no acceptance, up or down: a saving that was not accepted could be
/// lost unnoticed.
const TOLERANCE: f64 = 0.02;

/// The same of the cycles of one interrupt, which depend on what the flash's cache holds, and of those of a commissioning,
/// whose course depends on when the host asks: the same drive has differed by 5 %.
const TOLERANCE_OF_A_COURSE: f64 = 0.1;

/// Binaries without static memory.
const WITHOUT_MEMORY: [&str; 4] = ["virtual-servo", "bench", "terms", "commission"];

/// Names and figures.
type Figures = BTreeMap<String, u64>;

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
    refuse(&compare(&counted, &accepted))
}

/// Records the figures, unless one was not counted at all.
fn record(counted: &Figures) -> Result<(), String> {
    refuse(&compare(counted, counted))?;
    let mut text = String::from(
        "# Counted on the emulated chip; `cargo xtask budget --accept` records it anew.\n",
    );
    for (name, value) in counted {
        text.push_str(&format!("{name} = {value}\n"));
    }
    let path = firmware::root().join(FILE);
    std::fs::write(&path, text)
        .map_err(|error| format!("{} cannot be written: {error}", path.display()))
}

/// Objections to figures that differ from those accepted.
fn compare(counted: &Figures, accepted: &Figures) -> Vec<String> {
    let missing = accepted
        .keys()
        .filter(|name| !counted.contains_key(*name))
        .map(|name| format!("{name}: accepted, but no longer counted"));
    let wrong = counted.iter().filter_map(|(name, &counted)| {
        let accepted = accepted.get(name).copied();
        let difference = accepted.map_or(0, |accepted| counted.abs_diff(accepted));
        let tolerance = tolerance(name);
        match accepted {
            _ if counted == 0 => Some(format!("{name}: zero, so nothing was counted")),
            None => Some(format!("{name}: {counted}, never accepted")),
            Some(accepted) if difference as f64 > accepted as f64 * tolerance => Some(format!(
                "{name}: {counted}, more than {} % from the {accepted} accepted",
                tolerance * 100.0
            )),
            Some(_) => None,
        }
    });
    missing.chain(wrong).collect()
}

/// The relative change of a figure that needs no acceptance.
fn tolerance(name: &str) -> f64 {
    let is_of_course =
        name.starts_with("interrupt-commission-") && !name.ends_with("-command-cycles");
    if name.ends_with("-worst-cycles") || is_of_course {
        TOLERANCE_OF_A_COURSE
    } else {
        TOLERANCE
    }
}

/// An error if there is an objection.
fn refuse(objections: &[String]) -> Result<(), String> {
    if objections.is_empty() {
        return Ok(());
    }
    Err(format!(
        "{FILE} differs from the figures counted:\n  {}\nreduce the cost, or accept it with `cargo \
         xtask budget --accept`",
        objections.join("\n  ")
    ))
}

/// The budget.
pub(crate) fn accepted() -> Result<Figures, String> {
    let path = firmware::root().join(FILE);
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Instructions per sample and interrupt, cycles per interrupt, bytes of state, flash, static memory and
/// stack, by name.
fn count() -> Result<Figures, String> {
    firmware::build(&[], &[])?;
    let mut printed = String::new();
    for bench in ["bench", "terms", "commission", "background"] {
        printed.push_str(&emulator::run(emulator::BOARD, &firmware::path(bench))?);
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
        let elf = Elf::read(&firmware::path(binary))?;
        counted.insert(format!("{binary}-flash-bytes"), elf.flash);
        if !(elf.memory == 0 && WITHOUT_MEMORY.contains(&binary)) {
            counted.insert(format!("{binary}-memory-bytes"), elf.memory);
        }
        if binary == "drive" {
            for (name, bound) in listing::bounds(&elf)? {
                counted.insert(format!("drive-{name}"), bound.into());
            }
        }
    }
    // The last, as they build the drive again, for the emulator.
    counted.extend(lead::figures()?);
    for (law, summary) in interrupt::count(interrupt::COUNTED_BY_BUDGET, Choice::Assumed)? {
        for (which, taken) in summary.named() {
            let name = format!("interrupt-{law}-{which}");
            if matches!(which, "typical" | "shown" | "worst") {
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
    fn accepted_figures_pass() {
        assert!(compare(&budget(), &budget()).is_empty());
        assert_eq!(refuse(&[]), Ok(()));
        let within = figures([("flash", 132_600), ("sample", 392)]);
        assert!(compare(&within, &budget()).is_empty());
    }

    #[test]
    fn every_difference_is_an_objection_that_names_the_figure() {
        for (counted, objection) in [
            (vec![("flash", 130_000)], "sample: accepted, but no longer"),
            (
                vec![("flash", 130_000), ("new", 7), ("sample", 400)],
                "new: 7, never accepted",
            ),
            (vec![("flash", 130_000), ("sample", 0)], "sample: zero"),
            (vec![("flash", 130_000), ("sample", 391)], "sample: 391"),
            (vec![("flash", 130_000), ("sample", 409)], "sample: 409"),
        ] {
            let counted = counted.into_iter();
            let counted = counted.map(|(name, value)| (name.to_owned(), value));
            let objections = compare(&counted.collect(), &budget());
            let [found] = &objections[..] else {
                panic!("{objection}: {objections:?}");
            };
            assert!(found.starts_with(objection), "{found}");
            assert!(refuse(&objections).is_err_and(|fault| fault.contains(objection)));
        }
    }

    #[test]
    fn the_longest_interrupt_may_differ_by_a_tenth() {
        let accepted = figures([("a-worst-cycles", 2000)]);
        let found = |cycles| compare(&figures([("a-worst-cycles", cycles)]), &accepted).len();
        assert_eq!([1799, 1800, 2200, 2201].map(found), [1, 0, 0, 1]);
    }

    #[test]
    fn zero_is_never_accepted() {
        let zero = figures([("flash", 130_000), ("sample", 0)]);
        assert_eq!(compare(&zero, &zero).len(), 1);
        assert!(record(&zero).is_err());
    }
}
