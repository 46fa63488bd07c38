//! Builds the firmware's binaries.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::seal::seal;

/// The chip.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// The root of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap_or_else(|| Path::new("."))
}

/// Builds the release of some binaries, all if none is named, with some features. It links only without
/// a panic. The drive is sealed.
pub(crate) fn build(binaries: &[&str], features: &[&str]) -> Result<(), String> {
    let has_drive = binaries.is_empty() || binaries.contains(&"drive");
    let features = format!("--features={}", features.join(","));
    let binaries = binaries.iter().flat_map(|binary| ["--bin", binary]);
    let what: Vec<&str> = binaries.chain([features.as_str()]).collect();
    // The settings beside the firmware name its target.
    release(&root().join("firmware-stm32"), &what)?;
    if has_drive {
        seal(&path("drive"))?;
    }
    Ok(())
}

/// The crates whose code is generic or the firmware's own, which a bench is of.
const OF_A_BENCH: [&str; 3] = ["firmware-stm32", "identifier-core", "virtual-servo"];

/// Arguments that compile them at an optimiser level in place of the drive's, and what they depend on at 3.
fn at(level: &str) -> impl Iterator<Item = String> {
    let setting = move |name| format!("profile.release.package.{name}.opt-level={level}");
    let settings = OF_A_BENCH.map(setting).into_iter();
    let settings = settings.chain(["profile.release.opt-level=3".to_owned()]);
    settings.flat_map(|setting| ["--config".to_owned(), setting])
}

/// Builds the releases of benches at the optimiser level 3.
pub(crate) fn build_for_speed(benches: &[&str]) -> Result<(), String> {
    let levels: Vec<String> = at("3").collect();
    let benches = benches.iter().flat_map(|bench| ["--bin", bench]);
    let what: Vec<&str> = benches.chain(levels.iter().map(String::as_str)).collect();
    release(&root().join("firmware-stm32"), &what)
}

/// Builds the release of a bench at the optimiser level "s", in place of that at 3. It may panic.
pub(crate) fn build_for_size(bench: &str) -> Result<PathBuf, String> {
    let levels: Vec<String> = at("\"s\"").collect();
    let mut what = vec!["--bin", bench];
    what.extend(levels.iter().map(String::as_str));
    what.extend([
        "--",
        "-C",
        "link-arg=--defsym=a_panic_survived_in_this_release=0",
    ]);
    cargo(&root().join("firmware-stm32"), "rustc", &what)?;
    Ok(path(bench))
}

/// Builds and seals the drive for a board.
pub(crate) fn image(board: &str) -> Result<(), String> {
    let features = format!("--features={board}");
    let what = ["--bin", "drive", "--no-default-features", &features];
    release(&root().join("firmware-stm32"), &what)?;
    let drive = path("drive");
    seal(&drive)?;
    println!("sealed: {}", drive.display());
    Ok(())
}

/// Builds the emulator's plugin for this machine and returns its file.
pub(crate) fn build_trace() -> Result<PathBuf, String> {
    release(root(), &["-p", "trace"])?;
    let name = format!("{DLL_PREFIX}trace{DLL_SUFFIX}");
    Ok(built().join("release").join(name))
}

/// Builds a binary of the examples, which are a workspace of their own, and returns its file. They share the folder of what
/// is built, so that common dependencies are built once.
///
/// Its package alone: those of one on an operating system have other features.
pub(crate) fn build_example(package: &str, name: &str, target: &str) -> Result<PathBuf, String> {
    let what = ["-p", package, "--bin", name, "--target", target];
    release(&root().join("examples"), &what)?;
    Ok(built().join(target).join("release").join(name))
}

/// Builds a release in a folder.
fn release(folder: &Path, what: &[&str]) -> Result<(), String> {
    cargo(folder, "build", what)
}

/// Runs `cargo build` or `cargo rustc` for a release in a folder.
fn cargo(folder: &Path, verb: &str, what: &[&str]) -> Result<(), String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(folder)
        .args([verb, "--release", "--locked", "--target-dir"])
        .arg(built())
        .args(what)
        .status()
        .map_err(|error| format!("cargo does not start: {error}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!(
            "cargo {verb} {} fails in {}",
            what.join(" "),
            folder.display()
        ))
    }
}

/// The folder of cargo's output.
pub(crate) fn built() -> PathBuf {
    // Joining leaves a path alone that is absolute.
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// The file of a binary.
pub(crate) fn path(binary: &str) -> PathBuf {
    built().join(TARGET).join("release").join(binary)
}
