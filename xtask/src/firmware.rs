//! Builds the firmware's binaries, and bounds the stack and the loops of the drive.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::listing::Listing;

/// The chip.
const TARGET: &str = "thumbv7em-none-eabihf";

/// The root of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or_else(|| Path::new("."))
}

/// Builds the release of some binaries, all if none is named, with some features. It links only without
/// a panic.
pub(crate) fn build(binaries: &[&str], features: &[&str]) -> Result<(), String> {
    let features = format!("--features={}", features.join(","));
    let binaries = binaries.iter().flat_map(|binary| ["--bin", binary]);
    let what: Vec<&str> = binaries.chain([features.as_str()]).collect();
    // The settings beside the firmware name its target and make its release fit the chip.
    release(&root().join("firmware-stm32"), &what)
}

/// Builds the emulator's plugin for this machine and returns its file.
pub(crate) fn build_interrupt_meter() -> Result<PathBuf, String> {
    release(root(), &["-p", "interrupt-meter"])?;
    let name = format!("{DLL_PREFIX}interrupt_meter{DLL_SUFFIX}");
    Ok(built().join("release").join(name))
}

/// Builds an example, a workspace of its own, and returns the folder of its binary. It shares the folder of
/// what is built, so that common dependencies are built once.
pub(crate) fn build_example(
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

/// The folder of cargo's output.
fn built() -> PathBuf {
    // Joining leaves a path alone that is absolute.
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// The file of a binary.
pub(crate) fn path(binary: &str) -> PathBuf {
    built().join(TARGET).join("release").join(binary)
}

/// Bounds of the drive's paths.
pub(crate) struct Paths {
    /// Bytes of stack at most, every interrupt on top of the background.
    pub(crate) stack: u64,
    /// Bytes of stack of the sample interrupt at most, the processor's own included.
    pub(crate) sample: u64,
    /// Branches backwards in the functions of a sample.
    pub(crate) loops: u64,
    /// The same two of a sample of a commissioning.
    pub(crate) commission: u64,
    pub(crate) commission_loops: u64,
}

/// Bytes that the processor itself stacks for an interrupt, the registers of the FPU and alignment
/// included (ARMv7-M Architecture Reference Manual, B1.5.7).
const EXCEPTION: u64 = 26 * 4 + 4;

/// The part of a sample outside a run, by its name and as mangled names contain it: it commissions, or
/// rests.
const WITHOUT_A_RUN: &str = "without_a_run";
const WITHOUT_A_RUN_MANGLED: &str = "13without_a_run";

/// Bounds of the drive's paths. A division in a sample of a run is an error, also in the one that begins a
/// run or a commissioning.
pub(crate) fn paths(drive: &Path) -> Result<Paths, String> {
    let listing = Listing::read(drive)?;
    let sample = listing.under_without("TIM5", &[WITHOUT_A_RUN_MANGLED])?;
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
