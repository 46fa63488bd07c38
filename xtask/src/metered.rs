//! The linked drive on an emulated chip, the instructions of every sample interrupt of which are counted.
//!
//! The emulator runs an instruction a nanosecond of its own time. Its clock, and with it every sample, is thus the same
//! from run to run, except for the arrival of the host's requests.

use std::collections::HashMap;
use std::error::Error;
use std::io::{BufReader, Read};
use std::net::TcpStream;
use std::ops::Range;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use drive_link::Report;
use servo_id::drive::{AtEnd, Client, Driven};

use crate::elf::{Elf, mangled};
use crate::meter::{Cost, Lost, Meter, OutputWords, Watched};
use crate::thumb::Instruction;
use crate::{emulator, firmware};

/// The core's clock, Hz, and its cycles for an instruction. They are above the 1.9 to 2.14 that the manuals of core and
/// flash give for this code.
const CLOCK: f64 = 168e6;
const CYCLES: f64 = 2.2;

/// Instructions that a time, s, has room for.
pub(crate) fn instructions_in(time: f64) -> u64 {
    (time * CLOCK / CYCLES) as u64
}

/// The instructions that a share of the interrupts need at most; 0 of none.
pub(crate) fn share(instructions: &[u64], share: f64) -> u64 {
    let mut sorted = instructions.to_vec();
    sorted.sort_unstable();
    let last = sorted.len().saturating_sub(1);
    let place = (share * last as f64).round() as usize;
    sorted.get(place).copied().unwrap_or(0)
}

/// The interrupt's handler.
const HANDLER: &str = "TIM5";

/// A function that a drive has only in the emulator: neither it nor its callees count.
const ONLY_EMULATED: &str = "emulated_servo::advance";

/// The memory for TIM1's registers, and the offsets of those that drive the output (RM0090, 17.4). The direction is
/// written with every command. CR1 then lets both take effect.
const TIM1: &str = "emulated::TIM1_REGISTERS";
const CCR2: u32 = 0x38;
const CR1: u32 = 0x00;

/// Time of the host between two looks at the meter.
const LISTEN: Duration = Duration::from_millis(100);

/// The continuation after an interrupt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Next {
    /// The next one.
    Interrupt,
    /// Nothing: enough were metered.
    Enough,
}

/// Time limit of the emulator for what is metered.
pub(crate) const TIME_LIMIT: Duration = Duration::from_secs(300);

/// A drive that is metered, and the emulator's plugin that traces it.
#[derive(Debug)]
pub(crate) struct Metered {
    drive: PathBuf,
    plugin: PathBuf,
}

impl Metered {
    pub(crate) fn build() -> Result<Self, String> {
        Ok(Self {
            drive: firmware::emulated_drive()?,
            plugin: firmware::build_trace()?,
        })
    }
}

/// Runs a drive in the emulator and holds the conversation with it. It passes the cost of every interrupt, marked by
/// functions each of which is there once, to `take`, in order, until that has enough.
pub(crate) fn run(
    Metered { drive, plugin }: &Metered,
    marks: &[&str],
    conversation: impl FnOnce(&mut Driven) -> Result<(), Box<dyn Error>>,
    take: impl FnMut(Cost) -> Result<Next, String> + Send,
) -> Result<(), String> {
    let awaited = emulator::Awaited::new()?;
    // The emulator takes a comma for the end of an argument, and two for one.
    let file = plugin.display().to_string().replace(',', ",,");
    let elf = Elf::read(drive)?;
    let Range { start, end } = elf.static_at(TIM1)?;
    let watched = watched(&elf, marks, start)?;
    let plugin = format!(
        "file={file},listener={},writes={start}-{end}",
        awaited.address
    );
    thread::scope(|scope| {
        // Ends with this closure, and the trace with it.
        let (mut running, port) =
            emulator::Running::start(drive, &["-plugin", &plugin]).map_err(|error| {
                format!(
                    "{error}; the emulator must be QEMU 9.1 or later, and be built with plugins"
                )
            })?;
        let mut client = Driven::new(Client::new(port), 0.0, AtEnd::Leave);
        let trace = awaited.connection(&mut running)?;
        let reader = scope.spawn(|| read(trace, &elf, Meter::new(watched), take));
        conversation(&mut client).map_err(|error| error.to_string())?;
        let mut fault = None;
        let until = Instant::now() + TIME_LIMIT;
        while !reader.is_finished() {
            if Instant::now() > until {
                return Err(format!(
                    "the emulator has not run all samples in {} s: does the drive run?",
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
        let read = reader
            .join()
            .map_err(|_| "reading the trace has failed".to_owned())?;
        read.map_err(|error| match fault {
            Some(fault) => format!("{error}; it was {fault}"),
            None => error,
        })
    })
}

/// The code of a drive that is measured, and the registers of its output.
fn watched(elf: &Elf, marks: &[&str], tim1: u32) -> Result<Watched, String> {
    let functions = |path: &str| {
        let part = mangled(path);
        elf.ranges(path, |symbol| symbol.contains(&part))
    };
    let only = |path: &str, found: Vec<Range<u32>>| match &found[..] {
        [function] => Ok(function.start),
        _ => Err(format!("the drive has more than one {path}")),
    };
    let mark = |path: &&str| only(path, functions(path)?);
    Ok(Watched {
        handler: only(HANDLER, elf.ranges(HANDLER, |symbol| symbol == HANDLER)?)?,
        left_out: functions(ONLY_EMULATED)?,
        marks: marks.iter().map(mark).collect::<Result<_, _>>()?,
        output: OutputWords {
            driven: tim1 + CCR2,
            effective: tim1 + CR1,
        },
    })
}

/// Meters the emulator's trace.
fn read(
    trace: TcpStream,
    elf: &Elf,
    mut meter: Meter,
    mut take: impl FnMut(Cost) -> Result<Next, String>,
) -> Result<(), String> {
    let mut trace = BufReader::with_capacity(1 << 16, trace);
    let mut decoded: HashMap<u32, Instruction> = HashMap::new();
    let mut interrupts = 0_usize;
    let mut word = [0; 4];
    while trace.read_exact(&mut word).is_ok() {
        let word = u32::from_ne_bytes(word);
        if word & 1 == 0 {
            meter.store(word);
            continue;
        }
        let address = word & !1;
        let decode = || elf.instruction(address);
        let instruction = decoded.entry(address).or_insert_with(decode);
        let ended = meter.execute(instruction);
        let ended = ended.map_err(|Lost| "the end of an interrupt was lost".to_owned())?;
        if let Some(cost) = ended {
            interrupts += 1;
            if take(cost)? == Next::Enough {
                return Ok(());
            }
        }
    }
    Err(format!(
        "the emulator ended after {interrupts} interrupts, which were not enough"
    ))
}
