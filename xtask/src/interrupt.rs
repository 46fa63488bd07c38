//! The whole sample interrupt of the linked drive, counted on an emulated chip: instructions as they
//! are executed, and cycles by the model of `docs/cycles.md`.
//!
//! The emulator runs an instruction a nanosecond of its own time, so that its clock and with it every
//! sample is the same from run to run, except for when the host's requests arrive.

use std::collections::HashMap;
use std::error::Error;
use std::io::{BufReader, Read};
use std::net::{Ipv4Addr, TcpListener};
use std::ops::Range;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use drive_link::{Command, Format, Law, Report};
use host_sim::drive::Client;

use crate::cycles::{Cost, Lost, Meter, Taken, Watched};
use crate::elf::{Elf, mangled};
use crate::thumb::Instruction;
use crate::{emulator, firmware};

/// A law by the name that its figures have.
type NamedLaw = (&'static str, Law);

/// The laws of the drive of each arithmetic, with the features that it is built with.
const DRIVES: [(Format, &[&str], &[NamedLaw]); 2] = [
    (
        Format::Single,
        &["emulator"],
        &[
            ("gradient-friction", Law::Gradient { friction: true }),
            ("gradient", Law::Gradient { friction: false }),
            ("gauss-newton", Law::GaussNewton),
        ],
    ),
    (
        Format::Fixed,
        &["emulator", "fixed-point"],
        &[("fixed", Law::Gradient { friction: false })],
    ),
];

/// The interrupt's handler.
const HANDLER: &str = "TIM5";

/// Functions by which interrupts are classified, in the order of the marks: the first begins a run,
/// the second shows a sample, the third ends the run.
const MARKS: [&str; 3] = ["Run::start", "sampler::report", "Sampler::end_run"];
const FIRST: u32 = 0b001;
const SHOWN: u32 = 0b010;
const FAILED: u32 = 0b100;

/// A function that a drive has only in the emulator: neither it nor its callees count.
const ONLY_EMULATED: &str = "emulated_servo::advance";

/// Interrupts that are counted, from the one that begins the run.
const COUNTED: usize = 100_000;

/// Samples from one that is shown to the next.
const WATCHED: u16 = 20;

/// Time limit of the emulator for them.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// Time of the host between two looks at the meter.
const LISTEN: Duration = Duration::from_millis(100);

/// The core's clock, MHz.
const CLOCK: f64 = 168.0;

/// The cost of the interrupts of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Summary {
    /// Medians of those that show nothing.
    pub(crate) typical: Taken,
    /// Medians of those that show a sample.
    pub(crate) shown: Taken,
    /// The one that begins the run.
    pub(crate) first: Taken,
    /// The most of all, of instructions and of cycles.
    pub(crate) worst: Taken,
}

/// Prints the cost of every law.
pub(crate) fn print() -> Result<(), String> {
    let counted = count()?;
    println!(
        "{:<18} {:<8} {:>12} {:>8} {:>8}",
        "law", "", "instructions", "cycles", "µs"
    );
    for (law, summary) in counted {
        for (
            name,
            Taken {
                instructions,
                cycles,
            },
        ) in summary.named()
        {
            let time = cycles as f64 / CLOCK;
            println!("{law:<18} {name:<8} {instructions:>12} {cycles:>8} {time:>8.1}");
        }
    }
    println!("{COUNTED} interrupts of each law; µs at {CLOCK} MHz; the cycles are a model's");
    Ok(())
}

/// Builds the drive of each arithmetic for the emulator and counts every law.
pub(crate) fn count() -> Result<Vec<(&'static str, Summary)>, String> {
    let plugin = firmware::build_trace()?;
    let mut counted = Vec::new();
    for (format, features, laws) in DRIVES {
        firmware::build(&["drive"], features)?;
        counted.extend(count_laws(format, laws, &plugin)?);
    }
    Ok(counted)
}

/// Counts the laws of the drive that was built last.
fn count_laws(
    format: Format,
    laws: &[NamedLaw],
    plugin: &Path,
) -> Result<Vec<(&'static str, Summary)>, String> {
    let drive = firmware::path("drive");
    let count_one = |&(name, law): &NamedLaw| {
        let costs = measure(&drive, plugin, |client| start(client, law, format))?;
        let summary = Summary::new(&costs).map_err(|fault| format!("{name}: {fault}"))?;
        Ok((name, summary))
    };
    thread::scope(|scope| {
        let count_one = &count_one;
        let laws: Vec<_> = laws
            .iter()
            .map(|law| scope.spawn(move || count_one(law)))
            .collect();
        laws.into_iter()
            .map(|law| {
                law.join()
                    .map_err(|_| "counting a law has failed".to_owned())?
            })
            .collect()
    })
}

/// Starts a law, and some of its samples being shown.
fn start(drive: &mut Client, law: Law, format: Format) -> Result<(), Box<dyn Error>> {
    let mut settings = drive.settings()?;
    settings.closed_loop.law = law;
    settings.closed_loop.format = format;
    // The emulator's time is not the host's.
    settings.protection.link_timeout = 0.0;
    drive.ask(Command::Configure(settings))?;
    drive.ask(Command::Watch(WATCHED))?;
    drive.ask(Command::Start)?;
    Ok(())
}

/// Runs a drive in the emulator, has the conversation with it, and returns the costs of [`COUNTED`]
/// interrupts from the one that begins its run.
fn measure(
    drive: &Path,
    plugin: &Path,
    conversation: impl FnOnce(&mut Client) -> Result<(), Box<dyn Error>>,
) -> Result<Vec<Cost>, String> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))
        .map_err(|error| format!("no port is free on this machine: {error}"))?;
    let address = listener.local_addr().map_err(|error| error.to_string())?;
    // The emulator takes a comma for the end of an argument, and two for one.
    let file = plugin.display().to_string().replace(',', ",,");
    let plugin = format!("file={file},listener={address}");
    let elf = Elf::read(drive)?;
    let watched = watched(&elf)?;
    let (_running, port) =
        emulator::Running::start(drive, &["-plugin", &plugin]).map_err(|error| {
            format!("{error}; the emulator must be QEMU 9.1 or later, and be built with plugins")
        })?;
    let reader = thread::spawn(move || read(&listener, &elf, watched));

    let mut client = Client::new(port);
    conversation(&mut client).map_err(|error| error.to_string())?;
    let mut fault = None;
    let until = Instant::now() + TIME_LIMIT;
    while !reader.is_finished() {
        if Instant::now() > until {
            return Err(format!(
                "the emulator has not run {COUNTED} samples in {} s: does the drive run?",
                TIME_LIMIT.as_secs()
            ));
        }
        // Its reports must be read, or it has no room for more.
        let heard = client
            .port()
            .listen(
                &|report: &Report| matches!(report, Report::Fault(_)),
                LISTEN,
            )
            .map_err(|error| error.to_string())?;
        if let Some(Report::Fault(found)) = heard {
            fault = Some(found);
        }
    }
    let costs = reader
        .join()
        .map_err(|_| "reading the trace has failed".to_owned())?;
    costs.map_err(|error| match fault {
        Some(fault) => format!("{error}; it was {fault}"),
        None => error,
    })
}

/// The code of a drive that is measured.
fn watched(elf: &Elf) -> Result<Watched, String> {
    let functions = |path: &str| {
        let part = mangled(path);
        elf.ranges(path, |symbol| symbol.contains(&part))
    };
    let only = |path: &str, found: Vec<Range<u32>>| match &found[..] {
        [function] => Ok(function.start),
        _ => Err(format!("the drive has more than one {path}")),
    };
    let mark = |path| only(path, functions(path)?);
    Ok(Watched {
        handler: only(HANDLER, elf.ranges(HANDLER, |symbol| symbol == HANDLER)?)?,
        left_out: functions(ONLY_EMULATED)?,
        marks: MARKS.into_iter().map(mark).collect::<Result<_, _>>()?,
    })
}

/// Meters the emulator's trace from the interrupt that begins the run.
fn read(listener: &TcpListener, elf: &Elf, watched: Watched) -> Result<Vec<Cost>, String> {
    let (stream, _) = listener.accept().map_err(|error| error.to_string())?;
    let mut trace = BufReader::with_capacity(1 << 16, stream);
    let mut meter = Meter::new(watched);
    let mut decoded: HashMap<u32, Instruction> = HashMap::new();
    let mut costs = Vec::with_capacity(COUNTED);
    let mut word = [0; 4];
    while trace.read_exact(&mut word).is_ok() {
        let word = u32::from_ne_bytes(word);
        let address = word & !1;
        if address == word {
            meter.load(address);
            continue;
        }
        let decode = || elf.instruction(address);
        let instruction = decoded.entry(address).or_insert_with(decode);
        let ended = meter.execute(instruction);
        let Some(cost) = ended.map_err(|Lost| "the end of an interrupt was lost".to_owned())?
        else {
            continue;
        };
        if costs.is_empty() && !has(cost, FIRST) {
            continue;
        }
        if has(cost, FAILED) {
            return Err(format!(
                "the drive ends its run with a fault after {} samples: those that are counted \
                 must all be of a run",
                costs.len()
            ));
        }
        costs.push(cost);
        if costs.len() == COUNTED {
            return Ok(costs);
        }
    }
    Err(format!(
        "the emulator ended after {} of {COUNTED} interrupts",
        costs.len()
    ))
}

fn has(cost: Cost, mark: u32) -> bool {
    cost.marks & mark != 0
}

impl Summary {
    /// Summarises the interrupts of a run, the first of which begins it.
    fn new(costs: &[Cost]) -> Result<Self, String> {
        let (first, others) = costs.split_first().ok_or("no interrupt was seen")?;
        let (shown, typical): (Vec<_>, Vec<_>) =
            others.iter().copied().partition(|&cost| has(cost, SHOWN));
        Ok(Self {
            typical: middle(&typical).ok_or("no interrupt without a sample shown was seen")?,
            shown: middle(&shown).ok_or("no interrupt with a sample shown was seen")?,
            first: first.taken,
            worst: Taken {
                instructions: most(costs, |taken| taken.instructions),
                cycles: most(costs, |taken| taken.cycles),
            },
        })
    }

    /// The figures by their names.
    pub(crate) fn named(&self) -> [(&'static str, Taken); 4] {
        [
            ("typical", self.typical),
            ("shown", self.shown),
            ("first", self.first),
            ("worst", self.worst),
        ]
    }
}

/// The medians.
fn middle(costs: &[Cost]) -> Option<Taken> {
    let median = |figure: fn(Taken) -> u64| {
        let mut figures: Vec<u64> = costs.iter().map(|cost| figure(cost.taken)).collect();
        figures.sort_unstable();
        figures.get(figures.len() / 2).copied()
    };
    Some(Taken {
        instructions: median(|taken| taken.instructions)?,
        cycles: median(|taken| taken.cycles)?,
    })
}

fn most(costs: &[Cost], figure: fn(Taken) -> u64) -> u64 {
    costs
        .iter()
        .map(|cost| figure(cost.taken))
        .max()
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost(marks: u32, instructions: u64, cycles: u64) -> Cost {
        Cost {
            marks,
            taken: Taken {
                instructions,
                cycles,
            },
        }
    }

    #[test]
    fn the_classes_are_separate() {
        let costs = [
            cost(FIRST | SHOWN, 900, 2000),
            cost(0, 100, 250),
            cost(0, 110, 210),
            cost(0, 5000, 900),
            cost(SHOWN, 300, 400),
        ];
        let summary = Summary::new(&costs).expect("all classes are there");
        let taken = |instructions, cycles| Taken {
            instructions,
            cycles,
        };
        assert_eq!(summary.typical, taken(110, 250));
        assert_eq!(summary.shown, taken(300, 400));
        assert_eq!(summary.first, taken(900, 2000));
        assert_eq!(summary.worst, taken(5000, 2000));
    }

    #[test]
    fn a_class_that_was_not_seen_is_an_error() {
        let first = cost(FIRST, 900, 2000);
        assert!(Summary::new(&[]).is_err());
        assert!(Summary::new(&[first]).is_err());
        assert!(Summary::new(&[first, cost(0, 1, 1)]).is_err());
        assert!(Summary::new(&[first, cost(SHOWN, 1, 1)]).is_err());
    }
}
