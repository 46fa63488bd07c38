//! The cost of samples, interrupts and binaries against the accepted budget.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::thread;

use crate::command::root;
use crate::elf::Elf;
use crate::metered::Metered;
use crate::{emulator, firmware, interrupt, lead, listing};

/// The budget, beside the firmware.
const FILE: &str = "firmware-stm32/budget.toml";

/// Relative change of a figure that needs no acceptance, up or down. A saving that was not accepted could be lost
/// unnoticed.
const TOLERANCE: f64 = 0.02;

/// The same for the interrupts of a commissioning, whose course depends on the time of the host's requests. The same
/// drive has differed by 5 %.
const TOLERANCE_OF_A_COURSE: f64 = 0.1;

/// The most that a sample may take at the optimiser level "s", in percent of what it takes at 3.
const MAX_PERCENT_AT_S: u64 = 119;

/// The samples that are counted at both levels: their figures, and their rows on [`PAGES`].
const SAMPLES: [(&str, &str); 6] = [
    ("pid-f32", "PID, f32, without an identifier"),
    ("gradient-f32-2", "gradient, f32, a and b"),
    ("gradient-f32-friction", "gradient, f32, with friction"),
    ("gradient-fixed-2", "gradient, fixed point, a and b"),
    ("gauss-newton-f32-4", "Gauss–Newton, f32, four parameters"),
    (
        "gauss-newton-recording",
        "the same while it records for its first fit",
    ),
];

/// The phases of a commissioning, the rates at which one is counted whole, and the estimators of a run, in the pages'
/// words.
const PHASES: [(&str, &str); 8] = [
    ("rest", "`rest`"),
    ("probe", "`probe`"),
    ("fit", "`fit`"),
    ("frequency-response", "`frequency-response`"),
    ("gains", "`gains`"),
    ("trial", "`trial`"),
    ("applied", "`applied`, its first sample"),
    ("slice", "a slice of the solver, in the background"),
];
const RATES: [(&str, &str); 3] = [
    ("1-khz", "1 kHz"),
    ("10-khz", "10 kHz"),
    ("20-khz", "20 kHz"),
];
const ESTIMATORS: [(&str, &str); 7] = [
    ("gradient", "gradient, a and b"),
    ("gradient-friction", "gradient with friction"),
    ("gauss-newton", "Gauss–Newton"),
    ("gauss-newton-terms", "the same with all terms"),
    ("gradient-20-khz", "gradient, a and b, at 20 kHz"),
    (
        "gradient-friction-20-khz",
        "gradient with friction, at 20 kHz",
    ),
    ("gauss-newton-20-khz", "Gauss–Newton, at 20 kHz"),
];
/// The sets of unknowns of Gauss–Newton with a term that has entered.
const TERMS: [(&str, &str); 6] = [
    ("asymmetry", "asymmetry | 5"),
    ("dead-band", "dead band | 5"),
    ("delay", "delay | 5"),
    ("low-speed", "low speed | 5"),
    ("gravity", "gravity | 6"),
    ("ripple", "ripple | 6"),
];

/// The pages with rows of figures.
const PAGES: [&str; 3] = ["README.md", "identifier-core/README.md", "docs/cost.md"];

/// The memory of the drive, in kB on [`PAGES`].
const DRIVE: [(&str, &[&str]); 6] = [
    (
        "the whole drive: flash, memory, stack",
        &["drive-flash", "drive-memory", "drive-stack"],
    ),
    ("flash of the drive, of 512 KiB", &["drive-flash"]),
    ("its static memory", &["drive-memory"]),
    ("its deepest stack, with both interrupts", &["drive-stack"]),
    ("both together, of 128 KiB", &["drive-ram"]),
    (
        "the drive of a small board: flash of 192 KiB, both of 64 KiB",
        &["small-drive-flash", "small-drive-ram"],
    ),
];

/// Parts of the bench without static memory, whose code a user's firmware has. It is compiled for speed here, and the
/// drive for size. And with what the names of the figures of each begin, the last of which counts none.
const WITHOUT_MEMORY: [(&str, &str); 4] = [
    ("samples", ""),
    ("terms", ""),
    ("commission", "commission-"),
    ("same", ""),
];

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
    let mut objections = compare(&counted, &accepted);
    objections.extend(slower_at_s(&counted));
    refuse(&objections)
}

/// Records the figures, unless one was not counted at all.
fn record(counted: &Figures) -> Result<(), String> {
    let mut objections = compare(counted, counted);
    objections.extend(slower_at_s(counted));
    refuse(&objections)?;
    let mut text = String::from(
        "# Counted on the emulated chip; `cargo xtask budget --accept` records it anew.\n",
    );
    for (name, value) in counted {
        text.push_str(&format!("{name} = {value}\n"));
    }
    write(FILE, &text)?;
    for page in PAGES {
        write(page, &with_rows(&read(page)?, counted))?;
    }
    Ok(())
}

/// A page with the rows of these figures.
fn with_rows(page: &str, figures: &Figures) -> String {
    let rows = rows();
    let row = |line: &str| {
        let of_it =
            |(label, _): &&(&str, Vec<Vec<String>>)| line.starts_with(&format!("| {label} |"));
        let (label, cells) = rows.iter().find(of_it)?;
        let figure = |name: &String| {
            let figure = figures.get(name).copied().unwrap_or(0);
            match name.contains("drive-") {
                true => format!("{} kB", (figure + 500) / 1000),
                false => figure.to_string(),
            }
        };
        let cell = |names: &Vec<String>| names.iter().map(figure).collect::<Vec<_>>().join(", ");
        let cells: Vec<String> = cells.iter().map(cell).collect();
        Some(format!("| {label} | {} |", cells.join(" | ")))
    };
    let lines = page
        .lines()
        .map(|line| row(line).unwrap_or_else(|| line.to_owned()));
    lines.map(|line| line + "\n").collect()
}

/// The rows of pages: their labels, and the names of the figures in each cell.
fn rows() -> Vec<(&'static str, Vec<Vec<String>>)> {
    let named = |name: &str, cells: &[&[&str]]| -> Vec<Vec<String>> {
        let cell = |whats: &&[&str]| whats.iter().map(|what| name.replace('*', what)).collect();
        cells.iter().map(cell).collect()
    };
    let table = |begin: &'static str, of: &[(&str, &'static str)], cells: &[&[&str]]| {
        let row = |(name, label): &(&str, &'static str)| {
            (*label, named(&format!("{begin}{name}-*"), cells))
        };
        of.iter().map(row).collect::<Vec<_>>()
    };
    let both: [&[&str]; 3] = [
        &["mean", "most"],
        &["at-s-mean", "at-s-most"],
        &["state-bytes"],
    ];
    let drive = DRIVE.map(|(label, parts)| {
        let name = |part: &&str| format!("{part}-bytes");
        (label, vec![parts.iter().map(name).collect()])
    });
    [
        drive.to_vec(),
        table("", &SAMPLES, &both),
        table(
            "gauss-newton-with-",
            &TERMS,
            &[&["mean"], &["most"], &["state-bytes"]],
        ),
        table(
            "gauss-newton-",
            &[("f32-4", "none | 4")],
            &[&["mean"], &["most"], &["state-bytes"]],
        ),
        table("commission-", &PHASES, &[&["mean"], &["most"]]),
        table(
            "commission-",
            &[("slices", "slices of one commissioning")],
            &[&["working"], &["long"]],
        ),
        table(
            "interrupt-commission-",
            &RATES,
            &[&["command"], &["typical"], &["ninetieth"], &["worst"]],
        ),
        table(
            "interrupt-",
            &ESTIMATORS,
            &[&["typical"], &["shown"], &["first"], &["worst"]],
        ),
    ]
    .concat()
}

fn read(file: &str) -> Result<String, String> {
    let path = root().join(file);
    std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(file: &str, text: &str) -> Result<(), String> {
    let path = root().join(file);
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

/// Objections to samples that take more at "s" than is allowed.
fn slower_at_s(counted: &Figures) -> Vec<String> {
    let mut objections = Vec::new();
    for (name, _) in SAMPLES {
        for figure in ["mean", "most"] {
            let at_s = format!("{name}-at-s-{figure}");
            let [small, fast] = [&at_s, &format!("{name}-{figure}")].map(|name| counted.get(name));
            match (small, fast) {
                (Some(small), Some(fast)) if 100 * small <= MAX_PERCENT_AT_S * fast => {}
                (Some(small), Some(fast)) => objections.push(format!(
                    "{at_s}: {small}, more than {MAX_PERCENT_AT_S} % of the {fast} at 3"
                )),
                _ => objections.push(format!("{at_s}: not counted at both levels")),
            }
        }
    }
    objections
}

/// The relative change of a figure that needs no acceptance.
fn tolerance(name: &str) -> f64 {
    if name.starts_with("interrupt-commission-") && !name.ends_with("-command") {
        TOLERANCE_OF_A_COURSE
    } else {
        TOLERANCE
    }
}

/// An error if there is a rejection reason.
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
fn accepted() -> Result<Figures, String> {
    toml::from_str(&read(FILE)?).map_err(|error| format!("{FILE}: {error}"))
}

/// Instructions per sample and interrupt, bytes of state, flash, static memory and
/// stack, by name.
fn count() -> Result<Figures, String> {
    let mut counted = Figures::new();
    let mut benches = vec![
        firmware::bench("samples", firmware::FOR_SIZE)?,
        firmware::bench("turns", None)?,
    ];
    for (part, _) in WITHOUT_MEMORY {
        let bench = firmware::bench(part, firmware::FOR_SPEED)?;
        let elf = Elf::read(&bench)?;
        counted.insert(format!("{part}-flash-bytes"), elf.flash);
        if elf.memory > 0 {
            counted.insert(format!("{part}-memory-bytes"), elf.memory);
        }
        benches.push(bench);
    }
    benches.pop();
    for (drive, board) in [
        ("small-drive", firmware::SMALL_BOARD),
        ("drive", emulator::BOARD),
    ] {
        let elf = Elf::read(&firmware::drive(&[board])?)?;
        counted.insert(format!("{drive}-flash-bytes"), elf.flash);
        counted.insert(format!("{drive}-memory-bytes"), elf.memory);
        for (name, bound) in listing::bounds(&elf)? {
            let of_both = if name == "stack-bytes" { elf.memory } else { 0 };
            counted.insert(format!("{drive}-{name}"), bound.into());
            if of_both > 0 {
                counted.insert(format!("{drive}-ram-bytes"), of_both + u64::from(bound));
            }
        }
    }
    let [at_s, others @ ..] = &printed(&benches)?[..] else {
        return Err("nothing was printed".to_owned());
    };
    let begins = ["turn-"]
        .into_iter()
        .chain(WITHOUT_MEMORY.map(|(_, begin)| begin));
    for (begin, printed) in begins.zip(others) {
        for line in printed.lines() {
            if let Some(plain) = line.strip_prefix("count ") {
                let (name, figure) = plain.trim_end().split_once(' ').unwrap_or((plain, ""));
                let figure = figure.parse().map_err(|error| format!("{line}: {error}"))?;
                counted.insert(format!("{begin}{name}"), figure);
                continue;
            }
            let Counted {
                name,
                mean,
                most,
                bytes,
            } = Counted::parse(line)?;
            counted.insert(format!("{begin}{name}-mean"), mean);
            counted.insert(format!("{begin}{name}-most"), most);
            counted.insert(format!("{begin}{name}-state-bytes"), bytes);
        }
    }
    for line in at_s.lines() {
        let Counted {
            name, mean, most, ..
        } = Counted::parse(line)?;
        if SAMPLES.iter().any(|(own, _)| *own == name) {
            counted.insert(format!("{name}-at-s-mean"), mean);
            counted.insert(format!("{name}-at-s-most"), most);
        }
    }
    // The last, as they build the drive again, for the emulator.
    let metered = Metered::build()?;
    counted.extend(lead::figures(&metered)?);
    counted.extend(interrupt::figures(&metered)?);
    Ok(counted)
}

/// Runs binaries in emulators at once, and returns what each has printed.
fn printed(binaries: &[PathBuf]) -> Result<Vec<String>, String> {
    thread::scope(|scope| {
        let binaries = binaries.iter();
        let running: Vec<_> = binaries
            .map(|binary| scope.spawn(move || emulator::run(emulator::BOARD, binary)))
            .collect();
        let ended = running.into_iter().map(|running| {
            let ended = running.join();
            ended.unwrap_or_else(|_| Err("running an emulator has failed".to_owned()))
        });
        ended.collect()
    })
}

/// A line of a bench.
struct Counted<'a> {
    name: &'a str,
    mean: u64,
    most: u64,
    bytes: u64,
}

impl<'a> Counted<'a> {
    fn parse(line: &'a str) -> Result<Self, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [name, mean, most, bytes] = words[..] else {
            return Err(format!("the bench printed a line that is none: {line}"));
        };
        let count = |figure: &str| figure.parse().map_err(|error| format!("{line}: {error}"));
        Ok(Self {
            name,
            mean: count(mean)?,
            most: count(most)?,
            bytes: count(bytes)?,
        })
    }
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
    fn every_difference_is_an_rejection_reason_that_names_the_figure() {
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
    fn an_interrupt_of_a_commissioning_may_differ_by_a_tenth() {
        const NAME: &str = "interrupt-commission-1-khz-worst";
        let accepted = figures([(NAME, 2000)]);
        let found = |taken| compare(&figures([(NAME, taken)]), &accepted).len();
        assert_eq!([1799, 1800, 2200, 2201].map(found), [1, 0, 0, 1]);
    }

    #[test]
    fn a_sample_may_take_little_more_at_s_and_must_be_counted_there() {
        let counted = |at_s: u64| {
            let both = SAMPLES.into_iter().flat_map(|(name, _)| {
                let figures = ["mean", "most"].map(|figure| (format!("{name}-{figure}"), 200));
                let at_s = ["mean", "most"].map(|figure| (format!("{name}-at-s-{figure}"), at_s));
                figures.into_iter().chain(at_s)
            });
            both.collect::<Figures>()
        };
        assert!(slower_at_s(&counted(2 * MAX_PERCENT_AT_S)).is_empty());
        assert_eq!(
            slower_at_s(&counted(2 * MAX_PERCENT_AT_S + 1)).len(),
            2 * SAMPLES.len()
        );
        let mut missing = counted(200);
        missing.remove("gradient-fixed-2-at-s-most");
        assert_eq!(slower_at_s(&missing).len(), 1);
        assert!(
            slower_at_s(&missing)
                .concat()
                .starts_with("gradient-fixed-2-at-s-most: ")
        );
    }

    #[test]
    fn the_pages_have_the_figures_of_the_budget() {
        let accepted = accepted().expect("the budget");
        for page in PAGES {
            let text = read(page).expect("the page");
            assert_eq!(with_rows(&text, &accepted), text, "{page}");
        }
        let pages = PAGES.map(|page| read(page).expect("the page")).concat();
        for (label, cells) in rows() {
            assert!(pages.contains(&format!("\n| {label} |")), "{label}");
            for name in cells.concat() {
                assert!(accepted.contains_key(&name), "{name}");
            }
        }
    }

    #[test]
    fn the_program_has_the_instructions_of_the_board_test() {
        let accepted = accepted().expect("the budget");
        let of = |which| accepted[&format!("turn-board-test-{which}")];
        let own = drive_logic::BOARD_TEST_INSTRUCTIONS.map(u64::from);
        assert_eq!(own, [of("mean"), of("most")]);
    }

    #[test]
    fn zero_is_never_accepted() {
        let zero = figures([("flash", 130_000), ("sample", 0)]);
        assert_eq!(compare(&zero, &zero).len(), 1);
        assert!(record(&zero).is_err());
    }
}
