//! The firmware's binaries.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};

use crate::listing::Listing;

/// The chip.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Where the chip's flash ends and everything above is memory.
const FLASH_END: u64 = 0x1000_0000;

/// The root of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or_else(|| Path::new("."))
}

/// Builds the release of some binaries, all if none is named, with some features. It only links if no
/// panic is left in it.
pub(crate) fn build(binaries: &[&str], features: &[&str]) -> Result<(), String> {
    let features = format!("--features={}", features.join(","));
    let binaries = binaries.iter().flat_map(|binary| ["--bin", binary]);
    let what: Vec<&str> = binaries.chain([features.as_str()]).collect();
    // The settings beside the firmware name its target and make its release fit the chip.
    release(&root().join("firmware-stm32"), &what)
}

/// Builds the emulator's plugin for this machine and answers with its file.
pub(crate) fn build_interrupt_meter() -> Result<PathBuf, String> {
    release(root(), &["-p", "interrupt-meter"])?;
    let name = format!("{DLL_PREFIX}interrupt_meter{DLL_SUFFIX}");
    Ok(built().join("release").join(name))
}

/// Builds somebody else's firmware, a workspace of its own, beside ours, so that what both stand on is
/// built once, and answers with the folder of its binary.
pub(crate) fn build_elsewhere(
    folder: &Path,
    target: &str,
    features: &[&str],
) -> Result<PathBuf, String> {
    let features = format!("--features={}", features.join(","));
    release(folder, &["--target", target, &features])?;
    Ok(built().join(target).join("release"))
}

/// Builds a release in a folder.
fn release(folder: &Path, what: &[&str]) -> Result<(), String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(folder)
        .args(["build", "--release", "--locked"])
        .args(what)
        .arg("--target-dir")
        .arg(built())
        .status()
        .map_err(|error| format!("cargo does not start: {error}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!(
            "cargo build {} fails in {}",
            what.join(" "),
            folder.display()
        ))
    }
}

/// Where cargo puts what it builds.
fn built() -> PathBuf {
    // Joining leaves a path alone that is absolute.
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// The file of a binary.
pub(crate) fn path(binary: &str) -> PathBuf {
    built().join(TARGET).join("release").join(binary)
}

/// What the drive's paths take.
pub(crate) struct Paths {
    /// Bytes of stack at most, every interrupt on top of the background.
    pub(crate) stack: u64,
    /// Bytes of stack at most that the sample interrupt takes, what the processor puts there included.
    pub(crate) sample: u64,
    /// Branches backwards in what a sample may run.
    pub(crate) loops: u64,
    /// The same two of a sample of a commissioning.
    pub(crate) commission: u64,
    pub(crate) commission_loops: u64,
}

/// What the processor itself puts on the stack for an interrupt, the registers of the floating-point
/// unit and alignment included (RM of ARMv7-M, B1.5.7).
const EXCEPTION: u64 = 26 * 4 + 4;

/// What a sample does when no run is under way: it commissions, or rests.
const WITHOUT_A_RUN: &str = "without_a_run";

/// What is no part of a run, as mangled names have it.
const APART: [&str; 1] = ["13without_a_run"];

/// Bounds of the drive's paths. A division in what a sample of a run may run is an error, and one in what
/// begins a run or a commissioning.
pub(crate) fn paths(drive: &Path) -> Result<Paths, String> {
    let listing = Listing::of(drive)?;
    let sample = listing.under_without("TIM5", &APART)?;
    let commission = listing.under_method(WITHOUT_A_RUN)?;
    if !sample.divisions.is_empty() {
        return Err(format!(
            "a sample of the drive may divide, in {}",
            sample.divisions.join(", ")
        ));
    }
    let byte = listing.under("USART2")?;
    let background = listing.under("main")?;
    Ok(Paths {
        stack: background.stack + byte.stack + listing.under("TIM5")?.stack + 2 * EXCEPTION,
        sample: sample.stack + EXCEPTION,
        loops: sample.loops.into(),
        commission: commission.stack,
        commission_loops: commission.loops.into(),
    })
}

/// Where those functions of a binary are whose symbols fit, their ends not included; none is an error.
pub(crate) fn functions(
    path: &Path,
    name: &str,
    fits: impl Fn(&str) -> bool,
) -> Result<Vec<Range<u64>>, String> {
    let found = fitting(path, fits)?;
    if found.is_empty() {
        return Err(format!(
            "{} has no function {name}: was it renamed or inlined?",
            path.display()
        ));
    }
    Ok(found)
}

/// Refuses a binary in which a panic is left. The linker does so too, where the settings of the
/// firmware's folder ask it to; this looks at what was linked, whatever asked for it.
pub(crate) fn refuse_panics(path: &Path) -> Result<(), String> {
    const BEGINNING: &str = "Reset";
    const HANDLER: &str = "rust_begin_unwind";
    // A binary without symbols would have no panic either.
    functions(path, BEGINNING, |symbol| symbol == BEGINNING)?;
    if fitting(path, |symbol| symbol.contains(HANDLER))?.is_empty() {
        return Ok(());
    }
    Err(format!(
        "{} may panic: its release has a panic handler",
        path.display()
    ))
}

fn fitting(path: &Path, fits: impl Fn(&str) -> bool) -> Result<Vec<Range<u64>>, String> {
    let fault = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let data = std::fs::read(path).map_err(|error| fault(&error))?;
    let file = object::File::parse(&*data).map_err(|error| fault(&error))?;
    let text = file
        .symbols()
        .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0);
    Ok(text
        .filter(|symbol| symbol.name().is_ok_and(&fits))
        .map(|symbol| {
            // The lowest bit says Thumb.
            let start = symbol.address() & !1;
            start..start + symbol.size()
        })
        .collect())
}

/// Bytes of flash and of static memory that a binary takes.
pub(crate) fn sizes(path: &Path) -> Result<(u64, u64), String> {
    let fault = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let data = std::fs::read(path).map_err(|error| fault(&error))?;
    let file = object::File::parse(&*data).map_err(|error| fault(&error))?;
    let (mut flash, mut memory) = (0, 0);
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else {
            continue;
        };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
            continue;
        }
        if section.address() < FLASH_END {
            flash += section.size();
        } else {
            memory += section.size();
            // What memory starts with is kept in flash.
            if section.name() == Ok(".data") {
                flash += section.size();
            }
        }
    }
    Ok((flash, memory))
}
